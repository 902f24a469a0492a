"""Spoils good inputs: each index of a seed gives one hostile input, always the same."""

from __future__ import annotations

import copy
import random
from dataclasses import dataclass
from typing import Any, Final

from ..cases.parts import Table
from . import seeds


@dataclass(frozen=True)
class Input:
    """Files of one input by name; `scene` is the one to load."""

    scene: str
    files: dict[str, bytes]


NUMBERS: Final[tuple[Any, ...]] = (
    0, -0.0, 1, -1, 2, 3, 1e-45, 1e-38, 1e-30, 1e-7, 0.5, 1e3, 65535, 65536, 1e6, 1e10, 1e19, 1e30, 3.4e38,
    -3.4e38, 1e39, 1e308, 2**31 - 1, 2**31, 2**32, 2**63, 2**64, 10**40, float("nan"), float("inf"),
    -float("inf"), 1.0000001, 0.9999999, 180, 360, 90,
)  # fmt: skip
OTHERS: Final[tuple[Any, ...]] = (
    None, True, False, "", "x", "nan", "1e5", "glass", "D65", "gold", "../../etc/passwd", "/dev/zero",
    "/etc/passwd", "scene.toml", ".", "a" * 5000, "\x00", "\u202e\ud7ff", "%s%n", [], {}, [[]], [{}],
    {"type": "sphere"}, [1, 2], [1, 2, 3], [1, 2, 3, 4], [0, 0, 0], [1e30, 1e30, 1e30], [[0, 0, 0]] * 3,
    {"blackbody": 5000}, {"line": 555}, {"gaussian": [555, 0]}, [[400, 1], [300, 1]], [[555, -1], [600, 2]],
    {"band": [600, 500]}, {"translate": [1, 2, 3]}, [{"scale": [0, 1, 1]}], [{"rotate": [[0, 0, 0], 3]}],
    [{"scale": [1e20, 1e-20, 1]}],
)  # fmt: skip
KEYS: Final = (
    "max_depth", "min_weight", "background", "ambient", "ambient_samples", "medium_ior", "one_sided",
    "shadow", "spectrum", "conformance", "camera", "materials", "lights", "shapes", "type", "origin",
    "target", "up", "fov", "fov_axis", "size", "near", "mirror", "shift", "width", "height", "spp",
    "jitter", "color", "diffuse", "specular", "shininess", "reflection", "transmission", "ior", "fresnel",
    "thin", "emission", "absorption", "priority", "conductor", "position", "direction", "intensity",
    "falloff", "center", "radius", "point", "normal", "points", "vertices", "faces", "normals", "file",
    "smooth", "coefficients", "clip", "radii", "p0", "p1", "r0", "r1", "caps", "apex", "axis", "focal",
    "height", "min", "max", "material", "name", "transform", "version", "depth_color", "bands", "range",
    "group", "response", "white", "$schema", "__class__", "folder", "limits",
)  # fmt: skip
WORDS: Final = (
    b"nan", b"inf", b"-1", b"0", b"1e39", b"1e-50", b"999999999999", b"2147483648", b"", b"\x00",
    b"\xff\xfe", b"#", b"p", b"pp", b"f", b"v", b"s", b"c", b"l", b"Surface", b"Mesh", b"Polygon", b"Point",
    b"Spectrum", b"None", b"[[", b"]]", b"{", b"}", b'"', b"=", b"[" * 3000, b"{" * 3000, b"a.b.c.d = 1\n",
    b"1_0", b"0x10", b"1e",
)  # fmt: skip


def make(seed: int, index: int) -> Input:
    """Input `index` of the ones that `seed` draws."""
    draw = random.Random(f"{seed} {index}")
    kind = draw.choices((_native, _words, _mesh, _mesh_in_scene, _image), (55, 20, 10, 8, 7))[0]
    return kind(draw)


def _native(draw: random.Random) -> Input:
    table = copy.deepcopy(draw.choice(seeds.tables()))
    for _ in range(_few(draw)):
        spoil(draw, table)
    suffix = draw.choice((".toml", ".json"))
    data = seeds.WRITERS[suffix](table)
    if data[:1] == b"{":
        suffix = ".json"
    if draw.random() < 0.2:
        data = spoil_bytes(draw, data)
    return Input(f"scene{suffix}", {f"scene{suffix}": data})


def _words(draw: random.Random) -> Input:
    """NFF and thesis files, whose words are what matters."""
    suffix, text = draw.choice(((".nff", seeds.NFF), (".txt", seeds.THESIS)))
    lines = [line.split(" ") for line in text.splitlines()]
    for _ in range(_few(draw)):
        line = draw.choice(lines)
        at = draw.randrange(len(line))
        choice = draw.random()
        if choice < 0.5:
            line[at] = str(draw.choice(NUMBERS))
        elif choice < 0.7:
            line[at] = draw.choice(draw.choice(lines))
        elif choice < 0.8:
            del line[at:]
            line.append("")
        elif choice < 0.9:
            lines.insert(draw.randrange(len(lines)), line[:])
        else:
            line.insert(at, draw.choice(WORDS).decode("latin-1"))
    data = "\n".join(" ".join(line) for line in lines).encode()
    if draw.random() < 0.2:
        data = spoil_bytes(draw, data)
    return Input(f"scene{suffix}", {f"scene{suffix}": data})


def _mesh_file(draw: random.Random) -> tuple[str, bytes]:
    name, data = draw.choice(list(seeds.meshes().items()))
    for _ in range(_few(draw)):
        data = spoil_bytes(draw, data)
    return f"mesh{name[name.rindex('.') :]}", data


def _mesh(draw: random.Random) -> Input:
    name, data = _mesh_file(draw)
    return Input(name, {name: data})


def _mesh_in_scene(draw: random.Random) -> Input:
    name, data = _mesh_file(draw)
    table = copy.deepcopy(draw.choice(seeds.tables()))
    extra: dict[str, Any] = {"smooth": True} if draw.random() < 0.4 else {}
    table["shapes"] = [*table["shapes"][:3], {"type": "mesh", "file": name, **extra}]
    return Input("scene.json", {"scene.json": seeds.as_json(table), name: data})


def _image(draw: random.Random) -> Input:
    suffix, data = draw.choice(list(seeds.images().items()))
    for _ in range(_few(draw)):
        data = spoil_bytes(draw, data)
    if draw.random() < 0.2:
        suffix = draw.choice(list(seeds.images()))
    table = {**copy.deepcopy(draw.choice(seeds.tables())), "background": f"sky{suffix}"}
    return Input("scene.json", {"scene.json": seeds.as_json(table), f"sky{suffix}": data})


def _few(draw: random.Random) -> int:
    return draw.choice((1, 1, 1, 2, 3, 6))


def spoil(draw: random.Random, table: Table) -> None:
    """One change of a table somewhere inside: a value, a key, an item too few or too many, a wrong place."""
    places = _places(table)
    parent, key = draw.choice(places)
    value = parent[key]
    choice = draw.random()
    if choice < 0.5:
        likely = NUMBERS if isinstance(value, (int, float)) else OTHERS
        parent[key] = copy.deepcopy(draw.choice(likely if draw.random() < 0.8 else NUMBERS + OTHERS))
    elif choice < 0.6:
        del parent[key]
    elif choice < 0.7 and isinstance(parent, dict):
        parent[draw.choice(KEYS)] = copy.deepcopy(draw.choice(NUMBERS + OTHERS))
    elif choice < 0.8 and isinstance(value, list) and value:
        parent[key] = value * draw.choice((2, 3, 50)) if len(value) < 50 else value[: len(value) // 2]
    elif choice < 0.87:
        for _ in range(draw.choice((1, 2, 70))):
            parent[key] = [parent[key]] if draw.random() < 0.5 else {"type": parent[key]}
    else:
        other, other_key = draw.choice(places)
        if other_key in other if isinstance(other, dict) else other_key < len(other):
            parent[key] = copy.deepcopy(other[other_key])


def _places(node: Any) -> list[tuple[Any, Any]]:
    """Every (container, key) below a node."""
    items = list(node.items()) if isinstance(node, dict) else list(enumerate(node))
    out: list[tuple[Any, Any]] = []
    for key, value in items:
        out.append((node, key))
        if isinstance(value, (dict, list)):
            out += _places(value)
    return out


def spoil_bytes(draw: random.Random, data: bytes) -> bytes:
    """One change of a file's bytes: flipped, cut, doubled, overwritten, a strange word put in."""
    if not data:
        return draw.choice(WORDS)
    at = draw.randrange(min(len(data), 200) if draw.random() < 0.4 else len(data))
    choice = draw.random()
    if choice < 0.35:
        return data[:at] + bytes([data[at] ^ (1 << draw.randrange(8))]) + data[at + 1 :]
    if choice < 0.5:
        return data[:at]
    if choice < 0.7:
        return (
            data[:at] + draw.choice((b"\xff" * 4, b"\0" * 4, b"\xff\xff\xff\x7f", b"\x80")) + data[at + 4 :]
        )
    if choice < 0.85:
        return data[:at] + draw.choice(WORDS) + data[at:]
    end = at + draw.randrange(1, 64)
    return data[:end] + data[at:]
