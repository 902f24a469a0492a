"""What a glTF file says: its JSON, checked as it is parsed, and the binary chunk of a .glb.

Only what a mesh needs is kept; everything else is passed over without being built. Numbers of other parts
are whole and not negative here; whether there are such parts is for the reader to see. Materials, cameras
and lights stay text (`msgspec.Raw`) until somebody asks for them (`decode`): a mesh alone needs none.
"""

from __future__ import annotations

import json
import re
import struct
from typing import Annotated, Any, Final, Literal, TypeVar

import msgspec
from msgspec import Meta

from clrt.base.mark import unmarked
from clrt.base.unique import unique
from clrt.meshfiles.broken import BrokenMesh

Count = Annotated[int, Meta(ge=0, le=1 << 53)]
Component = Literal[5120, 5121, 5122, 5123, 5125, 5126]
T = TypeVar("T")
Vector3 = tuple[float, float, float]
Vector4 = tuple[float, float, float, float]


# Extensions that a file may require: of what is not read, or read (quantization), or refused where it is met.
_PASSED_OVER: Final = (
    "KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_", "EXT_lights_",
    "KHR_xmp", "KHR_animation_", "KHR_mesh_quantization", "KHR_draco_mesh_compression", "KHR_node_visibility",
)  # fmt: skip
# Extensions that need no word: read, named or refused where they are met, or of no account for the picture.
_SILENT: Final = (
    "KHR_materials_", "KHR_texture_transform", "KHR_texture_basisu", "EXT_texture_", "MSFT_texture_dds",
    "MSFT_packing_", "KHR_lights_punctual", "EXT_mesh_gpu_instancing", "KHR_xmp", "KHR_animation_",
    "KHR_mesh_quantization", "KHR_draco_mesh_compression", "KHR_meshopt_compression",
    "EXT_meshopt_compression", "KHR_node_visibility", "EXT_mesh_features", "EXT_instance_features",
    "EXT_structural_metadata",
)  # fmt: skip
_EXTENSION: Final = re.compile(r"[A-Z][A-Z0-9]*_[A-Za-z]")  # as they are called; attributes end in _0


_NULL: Final = re.compile(rb":\s*null\b")
_DATA: Final = re.compile(rb'"data:[^"\\]*+"(?=\s*+[],}])')  # values, not keys


class Table(msgspec.Struct, frozen=True, gc=False):
    """A table of the file; what it has besides is ignored."""


class SparseIndices(Table, frozen=True, gc=False):
    bufferView: Count
    componentType: Component
    byteOffset: Count = 0


class SparseValues(Table, frozen=True, gc=False):
    bufferView: Count
    byteOffset: Count = 0


class Sparse(Table, frozen=True, gc=False):
    count: Count
    indices: SparseIndices
    values: SparseValues


class Accessor(Table, frozen=True, gc=False):
    componentType: Component
    count: Count
    type: Literal["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"]
    bufferView: Count | None = None
    byteOffset: Count = 0
    normalized: bool = False
    sparse: Sparse | None = None


class View(Table, frozen=True, gc=False):
    buffer: Count
    byteLength: Count
    byteOffset: Count = 0
    byteStride: Count | None = None


class Buffer(Table, frozen=True, gc=False):
    byteLength: Count | None = None
    uri: str | None = None


class Attributes(Table, frozen=True, gc=False):
    POSITION: Count | None = None
    NORMAL: Count | None = None
    COLOR_0: Count | None = None
    TEXCOORD_0: Count | None = None
    TANGENT: Count | None = None


class Compression(Table, frozen=True, gc=False):
    """That it is there is all that counts."""


class Extensions(Table, frozen=True, gc=False):
    KHR_draco_mesh_compression: Compression | None = None


class Primitive(Table, frozen=True, gc=False):
    attributes: Attributes
    indices: Count | None = None
    mode: Count = 4
    material: Count | None = None
    extensions: Extensions | None = None


class Mesh(Table, frozen=True, gc=False):
    primitives: tuple[Primitive, ...]
    weights: tuple[float, ...] = ()
    name: str = ""


class Instancing(Table, frozen=True, gc=False):
    """That it is there is all that counts."""


class LightHere(Table, frozen=True, gc=False):
    light: Count


class Visibility(Table, frozen=True, gc=False):
    visible: bool = True


class NodeExtensions(Table, frozen=True, gc=False):
    EXT_mesh_gpu_instancing: Instancing | None = None
    KHR_node_visibility: Visibility = Visibility()
    KHR_lights_punctual: LightHere | None = None


class Node(Table, frozen=True, gc=False):
    mesh: Count | None = None
    children: tuple[Count, ...] = ()
    matrix: Annotated[tuple[float, ...], Meta(min_length=16, max_length=16)] | None = None
    translation: Vector3 | None = None
    rotation: Vector4 | None = None
    scale: Vector3 | None = None
    skin: Count | None = None
    weights: tuple[float, ...] = ()
    extensions: NodeExtensions | None = None
    camera: Count | None = None
    name: str = ""


class SceneNodes(Table, frozen=True, gc=False):
    nodes: tuple[Count, ...] = ()


class Image(Table, frozen=True, gc=False):
    uri: str | None = None
    bufferView: Count | None = None
    mimeType: str = ""

    def __post_init__(self) -> None:
        if self.uri is not None and self.bufferView is not None:
            raise ValueError("an image has a uri or a bufferView, not both")


class Asset(Table, frozen=True, gc=False):
    version: str | float = "2.0"
    minVersion: str | float = "2.0"


class Document(Table, frozen=True, gc=False):
    asset: Asset = Asset()
    accessors: tuple[Accessor, ...] = ()
    bufferViews: tuple[View, ...] = ()
    buffers: tuple[Buffer, ...] = ()
    meshes: tuple[Mesh, ...] = ()
    nodes: tuple[Node, ...] = ()
    scenes: tuple[SceneNodes, ...] = ()
    scene: Count | None = None
    extensionsRequired: tuple[str, ...] = ()
    extensionsUsed: tuple[str, ...] = ()
    materials: msgspec.Raw = msgspec.Raw(b"[]")
    cameras: msgspec.Raw = msgspec.Raw(b"[]")
    extensions: msgspec.Raw = msgspec.Raw(b"{}")
    textures: msgspec.Raw = msgspec.Raw(b"[]")
    images: msgspec.Raw = msgspec.Raw(b"[]")
    samplers: msgspec.Raw = msgspec.Raw(b"[]")
    animations: msgspec.Raw = msgspec.Raw(b"[]")


def parse(data: bytes, binary: bool) -> tuple[Document, memoryview | None]:
    """The document in a .gltf, or, if `binary`, in a .glb with its binary chunk (None without)."""
    text, chunk = _chunks(data) if binary else (memoryview(data), None)
    text = unmarked(text)
    try:
        if _NULL.search(text):
            text = memoryview(_without_nulls(text))
        document = msgspec.json.decode(text, type=Document)
        met = _check_keys(text)
    except RecursionError:
        raise BrokenMesh("its JSON is nested too deeply") from None
    except (msgspec.MsgspecError, ValueError, OverflowError) as error:
        raise BrokenMesh(f"its JSON is not that of a glTF file: {error}") from None
    if str(document.asset.version).split(".")[0] != "2":
        raise BrokenMesh("only glTF of version 2 is read")
    if str(document.asset.minVersion) not in ("2.0", "2"):
        raise BrokenMesh(f"it needs glTF of version {document.asset.minVersion}; 2.0 is read")
    for name in document.extensionsRequired:
        if not name.startswith(_PASSED_OVER):
            raise BrokenMesh(f"it needs the extension {name}, which is not read; save it without that")
    used = tuple(dict.fromkeys((*document.extensionsUsed, *met)))
    return msgspec.structs.replace(document, extensionsUsed=used), chunk


def _without_nulls(text: memoryview) -> bytes:
    """The JSON without what is null in its tables: several exporters write that for what is not stated."""

    def stated(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        return unique([(key, value) for key, value in pairs if value is not None])

    plain = bytes(text).decode("utf-8", "surrogateescape")
    return json.dumps(json.loads(plain, object_pairs_hook=stated)).encode()


def unread(document: Document) -> list[str]:
    """The extensions that a `parse`d document uses, listed or not, and that nobody else names."""
    return [name for name in document.extensionsUsed if not name.startswith(_SILENT)]


def animated(document: Document) -> bool:
    """Whether a document has animations, whatever they are."""
    return re.match(rb"\s*\[\s*[^\s\]]", document.animations) is not None


def _check_keys(text: memoryview) -> dict[str, None]:
    """ValueError where a key stands twice in one table, wherever; nothing is built but one table at a time.

    The text is JSON. What it holds as base64 is not looked at. Returns the extensions in it, listed or not.
    """
    met: dict[str, None] = {}

    def check(pairs: list[tuple[str, Any]]) -> list[str] | None:
        unique(pairs)
        for key, names in pairs:
            if key == "extensions" and isinstance(names, list):
                met.update(dict.fromkeys(name for name in names if isinstance(name, str)))
        return [key for key, _ in pairs if _EXTENSION.match(key)] or None

    plain = _DATA.sub(b'""', text).decode("utf-8", "surrogateescape")
    json.loads(plain, object_pairs_hook=check, parse_int=bool, parse_float=bool, strict=False)
    return met


def decode(text: bytes | msgspec.Raw, kind: Any, name: str) -> Any:
    """What a part of the document says, as `kind`; `name` is what messages call the part."""
    try:
        return msgspec.json.decode(text, type=kind)
    except (msgspec.MsgspecError, UnicodeDecodeError, OverflowError) as error:
        raise BrokenMesh(f"its {name} are not those of a glTF file: {error}") from None


def item(items: tuple[T, ...], number: int, name: str) -> T:
    """One of the document's `items`; BrokenMesh where there are not so many."""
    if number >= len(items):
        raise BrokenMesh(f"there is no {name}[{number}], which it speaks of")
    return items[number]


def _chunks(data: bytes) -> tuple[memoryview, memoryview | None]:
    """The JSON and the first binary chunk of a .glb, not copied."""
    if len(data) < 20 or data[:4] != b"glTF":
        raise BrokenMesh("it does not begin as a .glb file does")
    version, total = struct.unpack_from("<2I", data, 4)
    if version != 2:
        raise BrokenMesh("only glTF of version 2 is read")
    if total > len(data):
        raise BrokenMesh(f"its header says {total} bytes, and it has {len(data)}")
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
