"""What a glTF file says: its JSON, checked as it is parsed, and the binary chunk of a .glb.

Only what a mesh needs is kept; everything else is passed over without being built. floats of other parts are
whole and not negative here; whether there are such parts is for the reader to see.
"""

from __future__ import annotations

import struct
from typing import Annotated, Final, Literal

import msgspec
from msgspec import Meta

Count = Annotated[int, Meta(ge=0, le=1 << 53)]
Component = Literal[5120, 5121, 5122, 5123, 5125, 5126]
Vector3 = tuple[float, float, float]
Vector4 = tuple[float, float, float, float]


# Extensions that a file may require: of what is not read, or read (quantization), or refused where it is met.
_PASSED_OVER: Final = (
    "KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_", "EXT_lights_",
    "KHR_xmp", "KHR_animation_", "KHR_mesh_quantization", "KHR_draco_mesh_compression",
)  # fmt: skip


class BrokenMesh(ValueError):
    """A mesh file that cannot be read; its text says why, for people."""


class _Part(msgspec.Struct, frozen=True, gc=False):
    """A table of the file; what it has besides is ignored."""


class SparseIndices(_Part, frozen=True, gc=False):
    bufferView: Count
    componentType: Component
    byteOffset: Count = 0


class SparseValues(_Part, frozen=True, gc=False):
    bufferView: Count
    byteOffset: Count = 0


class Sparse(_Part, frozen=True, gc=False):
    count: Count
    indices: SparseIndices
    values: SparseValues


class Accessor(_Part, frozen=True, gc=False):
    componentType: Component
    count: Count
    type: Literal["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"]
    bufferView: Count | None = None
    byteOffset: Count = 0
    normalized: bool = False
    sparse: Sparse | None = None


class View(_Part, frozen=True, gc=False):
    buffer: Count
    byteLength: Count
    byteOffset: Count = 0
    byteStride: Count | None = None


class Buffer(_Part, frozen=True, gc=False):
    uri: str | None = None


class Attributes(_Part, frozen=True, gc=False):
    POSITION: Count | None = None
    NORMAL: Count | None = None
    COLOR_0: Count | None = None
    TEXCOORD_0: Count | None = None


class Compression(_Part, frozen=True, gc=False):
    """That it is there is all that counts."""


class Extensions(_Part, frozen=True, gc=False):
    KHR_draco_mesh_compression: Compression | None = None


class Primitive(_Part, frozen=True, gc=False):
    attributes: Attributes
    indices: Count | None = None
    mode: Count = 4
    extensions: Extensions | None = None


class Mesh(_Part, frozen=True, gc=False):
    primitives: tuple[Primitive, ...]
    weights: tuple[float, ...] = ()


class Instancing(_Part, frozen=True, gc=False):
    """That it is there is all that counts."""


class NodeExtensions(_Part, frozen=True, gc=False):
    EXT_mesh_gpu_instancing: Instancing | None = None


class Node(_Part, frozen=True, gc=False):
    mesh: Count | None = None
    children: tuple[Count, ...] = ()
    matrix: Annotated[tuple[float, ...], Meta(min_length=16, max_length=16)] | None = None
    translation: Vector3 | None = None
    rotation: Vector4 | None = None
    scale: Vector3 | None = None
    skin: Count | None = None
    weights: tuple[float, ...] = ()
    extensions: NodeExtensions | None = None


class SceneNodes(_Part, frozen=True, gc=False):
    nodes: tuple[Count, ...] = ()


class Asset(_Part, frozen=True, gc=False):
    version: str | float = "2.0"
    minVersion: str | float = "2.0"


class Document(_Part, frozen=True, gc=False):
    asset: Asset = Asset()
    accessors: tuple[Accessor, ...] = ()
    bufferViews: tuple[View, ...] = ()
    buffers: tuple[Buffer, ...] = ()
    meshes: tuple[Mesh, ...] = ()
    nodes: tuple[Node, ...] = ()
    scenes: tuple[SceneNodes, ...] = ()
    scene: Count = 0
    extensionsRequired: tuple[str, ...] = ()


def parse(data: bytes, binary: bool) -> tuple[Document, memoryview | None]:
    """The document in a .gltf, or, if `binary`, in a .glb with its binary chunk (None without)."""
    text, chunk = _chunks(data) if binary else (memoryview(data), None)
    if bytes(text[:3]) == b"\xef\xbb\xbf":  # a byte order mark
        text = text[3:]
    try:
        document = msgspec.json.decode(text, type=Document)
    except RecursionError:
        raise BrokenMesh("its JSON is nested too deeply") from None
    except (msgspec.MsgspecError, UnicodeDecodeError, OverflowError) as error:
        raise BrokenMesh(f"its JSON is not that of a glTF file: {error}") from None
    if str(document.asset.version).split(".")[0] != "2":
        raise BrokenMesh("only glTF of version 2 is read")
    if str(document.asset.minVersion) not in ("2.0", "2"):
        raise BrokenMesh(f"it needs glTF of version {document.asset.minVersion}; 2.0 is read")
    for name in document.extensionsRequired:
        if not name.startswith(_PASSED_OVER):
            raise BrokenMesh(f"it needs the extension {name}, which is not read; save it without that")
    return document, chunk


def _chunks(data: bytes) -> tuple[memoryview, memoryview | None]:
    """The JSON and the first binary chunk of a .glb, not copied."""
    if len(data) < 20 or data[:4] != b"glTF":
        raise BrokenMesh("it does not begin as a .glb file does")
    (version,) = struct.unpack_from("<I", data, 4)
    if version != 2:
        raise BrokenMesh("only glTF of version 2 is read")
    found: dict[bytes, memoryview] = {}
    start = 12
    while start + 8 <= len(data) and len(found) < 2:
        length, kind = struct.unpack_from("<I4s", data, start)
        start += 8 + length
        if start > len(data):
            raise BrokenMesh("it ends before its last chunk does")
        if kind in (b"JSON", b"BIN\0"):  # others are extensions
            found.setdefault(kind, memoryview(data)[start - length : start])
    if b"JSON" not in found:
        raise BrokenMesh("it has no JSON chunk")
    return found[b"JSON"], found.get(b"BIN\0")
