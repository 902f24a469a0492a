"""Mesh files that declare more than they hold, or name the same thing many times; whole otherwise."""

from __future__ import annotations

import json
import random
import struct
from collections.abc import Callable
from typing import Any, Final

from .sizes import count, size

_EXTENSIONS: Final = (
    "KHR_draco_mesh_compression", "EXT_meshopt_compression", "EXT_mesh_gpu_instancing",
    "KHR_mesh_quantization", "KHR_texture_transform", "KHR_materials_variants", "KHR_lights_punctual", "x",
)  # fmt: skip
_TYPES: Final = (5120, 5121, 5122, 5123, 5125, 5126, 5130, 0)
_STRANGE: Final[tuple[Any, ...]] = (
    -1, 0, 1e-30, 1e308, "x", "../x.png", "/dev/zero", "data:;base64,AAAA", "", [], {}, None, True, [1, 2, 3],
)  # fmt: skip
_GLASSES: Final = 300
"""At one place: a tinted feeler looks for the next 32 anew (docs/reliability.md, bounds)."""
_FORMS: Final = ("SCALAR", "VEC2", "VEC3", "VEC4", "MAT4", "VEC3 ", "")


def spoil(draw: random.Random, suffix: str, data: bytes) -> bytes:
    """One change of what a mesh file of this format declares; other formats as they are."""
    change = _FORMATS.get(suffix)
    return change(draw, data) if change else data


def _gltf(draw: random.Random, data: bytes) -> bytes:
    tree = json.loads(data)
    _spoil_tree(draw, tree)
    return json.dumps(tree).encode()


def _glb(draw: random.Random, data: bytes) -> bytes:
    """The tree changed, with the lengths of file and chunks right, or a length that is not."""
    (length,) = struct.unpack_from("<I", data, 12)
    tree, rest = json.loads(data[20 : 20 + length]), data[20 + length :]
    if draw.random() < 0.2:
        at = draw.choice((4, 8, 12, 16, 20 + length, 24 + length))
        return data[:at] + struct.pack("<I", size(draw, 32)) + data[at + 4 :]
    _spoil_tree(draw, tree)
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<III", 0x46546C67, 2, 20 + len(text) + len(rest))
    return head + struct.pack("<II", len(text), 0x4E4F534A) + text + rest


def _spoil_tree(draw: random.Random, tree: dict[str, Any]) -> None:
    """One change: a declared size, the same thing many times, a shape of the graph, a value of a material."""
    draw.choice(_CHANGES)(draw, tree)


def _accessor(draw: random.Random, tree: dict[str, Any]) -> None:
    accessor = draw.choice(tree["accessors"])
    field = draw.choice(("count", "count", "byteOffset", "componentType", "type", "bufferView", "normalized"))
    values: dict[str, Any] = {"componentType": draw.choice(_TYPES), "type": draw.choice(_FORMS)}
    accessor[field] = values.get(field, size(draw))
    if draw.random() < 0.2:  # without data: zeros, as many as it says
        accessor.pop("bufferView", None)


def _sparse(draw: random.Random, tree: dict[str, Any]) -> None:
    """An accessor of many zeros with a few numbers in between."""
    accessor = draw.choice(tree["accessors"])
    declared = draw.choice((accessor["count"], 10**5, 10**6, 2**24, 6 * 10**7, 3 * 10**8, 2**31, 2**40))
    part = {"bufferView": draw.choice((0, 1, 99)), "byteOffset": draw.choice((0, 0, 4, 2**31))}
    accessor["sparse"] = {
        "count": draw.choice((0, 1, 3, accessor["count"], 2**24, 2**31)),
        "indices": {**part, "componentType": draw.choice(_TYPES)},
        "values": {"bufferView": draw.choice((0, 1, 99))},
    }
    accessor["count"] = declared
    if draw.random() < 0.6:
        accessor.pop("bufferView", None)


def _view(draw: random.Random, tree: dict[str, Any]) -> None:
    """Lengths of buffers and views, and many of them with the same data."""
    kind = draw.choice(("bufferViews", "buffers"))
    entry = draw.choice(tree[kind])
    entry[draw.choice(("byteLength", "byteOffset", "byteStride", "buffer"))] = size(draw)
    if draw.random() < 0.3:
        tree[kind] += [entry] * count(draw)


def _repeat(draw: random.Random, tree: dict[str, Any]) -> None:
    """Nodes, parts, meshes, materials or scenes again: each costs the file a few bytes."""
    many = count(draw)
    if many > _GLASSES:
        for material in tree.get("materials", ()):
            material.get("extensions", {}).pop("KHR_materials_transmission", None)
    mesh = draw.randrange(len(tree["meshes"]))
    kind = draw.choice(("nodes", "nodes", "primitives", "meshes", "materials", "accessors", "children"))
    if kind == "nodes":
        first = len(tree["nodes"])
        tree["nodes"] += [{"mesh": mesh}] * many
        tree["scenes"][0]["nodes"] += list(range(first, first + many))
    elif kind == "primitives":
        tree["meshes"][mesh]["primitives"] *= many
    elif kind == "materials":
        tree["materials"] = [{"name": "m", "doubleSided": True}] * many
        for number, part in enumerate(tree["meshes"][mesh]["primitives"]):
            part["material"] = number
    elif kind == "children":  # the same node below a node many times
        tree["nodes"][0]["children"] = [len(tree["nodes"])] * many
        tree["nodes"].append({"mesh": mesh})
    else:
        tree[kind] *= many


def _graph(draw: random.Random, tree: dict[str, Any]) -> None:
    """A chain of nodes, a circle, or a tree in which each node is named twice: 2^n meshes of n nodes."""
    first, depth = len(tree["nodes"]), draw.choice((2, 20, 30, 500, 3000))
    step = draw.choice(([1], [1, 1], [0], [-1], [1, 10**9]))
    for number in range(first, first + depth):
        tree["nodes"].append({"children": [max(number + by, 0) for by in step], "matrix": [2.0] * 16})
    tree["nodes"].append({"mesh": 0, "scale": [draw.choice((0, 1e308, -1))] * 3})
    tree["scenes"][0]["nodes"].append(first)


def _extension(draw: random.Random, tree: dict[str, Any]) -> None:
    name = draw.choice(_EXTENSIONS)
    value = {"bufferView": 0, "count": size(draw), "attributes": {"POSITION": 0, "TRANSLATION": 0}}
    entry = draw.choice(
        (tree, *tree["meshes"][0]["primitives"], *tree["nodes"][:3], *tree["bufferViews"][:1])
    )
    entry["extensions"] = {name: value}
    tree["extensionsRequired"] = tree["extensionsUsed"] = [name] * draw.choice((1, 1, 1000))


def _look(draw: random.Random, tree: dict[str, Any]) -> None:
    """A value of what makes the picture: of materials, their pictures, cameras or lights."""
    named = ("materials", "images", "textures", "samplers", "cameras", "extensions")
    left: list[Any] = [tree[name] for name in named if name in tree]
    places: list[tuple[Any, Any]] = []
    while left:
        table = left.pop()
        for key in range(len(table)) if isinstance(table, list) else list(table):
            places.append((table, key))
            if isinstance(table[key], (dict, list)):
                left.append(table[key])
    if places:
        table, key = draw.choice(places)
        table[key] = draw.choice((*_STRANGE, size(draw), table[key]))
        if isinstance(table, list) and draw.random() < 0.2:
            table *= draw.choice((2, 1000))


_CHANGES: Final = (
    _accessor, _accessor, _sparse, _sparse, _view, _repeat, _repeat, _graph, _extension, _look, _look,
)  # fmt: skip


def _ply(draw: random.Random, data: bytes) -> bytes:
    """Counts of the header, kinds of its properties, properties and elements again."""
    end = data.index(b"end_header")
    lines, body = data[:end].split(b"\n")[:-1], data[end:]
    chosen = draw.randrange(len(lines))
    words = lines[chosen].split()
    choice = draw.random()
    if choice < 0.5:
        chosen = draw.choice([n for n, line in enumerate(lines) if line.startswith(b"element")])
        lines[chosen] = b" ".join([*lines[chosen].split()[:2], b"%d" % draw.choice((-1, 0, 1, size(draw)))])
    elif choice < 0.7:
        kinds = (
            b"double",
            b"uchar",
            b"list uchar int",
            b"list int int",
            b"list float float",
            b"list list",
            b"",
        )
        lines[chosen] = b" ".join([*words[:1], draw.choice(kinds), *words[-1:]])
    elif choice < 0.9:
        names = b"%s_%d" if draw.random() < 0.5 else b"%s"
        for number in range(min(count(draw), 3000)):
            lines.insert(chosen, names % ((lines[chosen], number) if b"%d" in names else lines[chosen]))
    else:
        lines.insert(1, b"comment " + b"x" * draw.choice((10, 1_000_000)))
    return b"\n".join(lines) + b"\n" + body


def _obj(draw: random.Random, data: bytes) -> bytes:
    """Lines that begin parts, one line many times, faces of many corners, indices beyond all vertices."""
    lines = data.split(b"\n")
    at = draw.randrange(len(lines))
    many = count(draw, len(lines[at]))
    choice = draw.random()
    if choice < 0.3:
        start = draw.choice((b"o x%d", b"g x%d", b"usemtl m%d", b"s %d", b"mtllib m%d.mtl"))
        corners = draw.choice((b"", b"\nf 1 2 3", b"\nf 1//1 2//2 3//3"))
        lines[at:at] = [start % number + corners for number in range(many)]
    elif choice < 0.5:
        lines[at:at] = [draw.choice(lines)] * many
    elif choice < 0.7:
        lines.append(b"f " + b" ".join(b"%d" % (1 + number % 3) for number in range(many)))
    elif choice < 0.9:
        index = b"%d" % draw.choice((-1, 0, -size(draw), size(draw)))
        lines.append(
            draw.choice((b"f 1 2 %s", b"f 1/%s/1 2/1/1 3/1/1", b"f 1//%s 2//1 3//1", b"l 1 %s")) % index
        )
    else:
        lines.insert(at, b"v " + b" ".join([b"1"] * draw.choice((1, 4, 6, 7, many))))
    return b"\n".join(lines)


def _stl(draw: random.Random, data: bytes) -> bytes:
    """The number of triangles of a binary file; words of one in letters again."""
    if data[:5] == b"solid":
        part = draw.choice(
            (b"solid x\n", b"endsolid\n", b"vertex 0 0 0\n", b"facet normal 0 0 1\nouter loop\n")
        )
        at = draw.randrange(len(data))
        return data[:at] + part * count(draw) + data[at:]
    return data[:80] + struct.pack("<I", size(draw, 32)) + data[84:]


_FORMATS: Final[dict[str, Callable[[random.Random, bytes], bytes]]] = {
    ".gltf": _gltf, ".glb": _glb, ".ply": _ply, ".obj": _obj, ".stl": _stl,
}  # fmt: skip
