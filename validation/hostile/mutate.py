"""Spoils good inputs: each index of a seed gives one hostile input, always the same.

By structure (a value of a scene's table), by words, by bytes, and by what a file declares: then the rest of
the file is right (lengths, CRCs), so that the change reaches the part that it is meant for.
"""

from __future__ import annotations

import copy
import random
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ..scenes.parts import Table
from . import archives, extreme, meshfiles, pictures, seeds, texts, textures, xmlfiles
from .values import KEYS, NUMBERS, OTHERS, WORDS


@dataclass(frozen=True)
class Input:
    """Files of one input by name; `scene` is the one to load, `checkpoint` one to go on from."""

    scene: str
    files: dict[str, bytes]
    checkpoint: str | None = None


def make(seed: int, index: int) -> Input:
    """Input `index` of the ones that `seed` draws."""
    draw = random.Random(f"{seed} {index}")
    return draw.choices([kind for kind, _ in _KINDS], [weight for _, weight in _KINDS])[0](draw)


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
    suffix = name[name.rindex(".") :]
    if draw.random() < 0.5:
        return f"mesh{suffix}", meshfiles.spoil(draw, suffix, data)
    for _ in range(_few(draw)):
        data = spoil_bytes(draw, data)
    return f"mesh{suffix}", data


def _mesh(draw: random.Random) -> Input:
    name, data = _mesh_file(draw)
    return Input(name, {name: data})


def _mesh_in_scene(draw: random.Random) -> Input:
    name, data = _mesh_file(draw)
    table = copy.deepcopy(draw.choice(seeds.tables()))
    extra: dict[str, Any] = {"smooth": True} if draw.random() < 0.4 else {}
    mesh = {"type": "mesh", "file": name, **extra}
    many = draw.choice((2, 50, 2000)) if draw.random() < 0.15 else 1
    table["shapes"] = [*table["shapes"][:3], *[mesh] * many]
    return Input("scene.json", {"scene.json": seeds.as_json(table), name: data})


def _spoilt_picture(draw: random.Random) -> tuple[str, bytes]:
    suffix, data = draw.choice(list(seeds.images().items()))
    if draw.random() < 0.6:
        return suffix, pictures.spoil(draw, suffix, data)
    for _ in range(_few(draw)):
        data = spoil_bytes(draw, data)
    return suffix, data


def _textured(draw: random.Random) -> Input:
    """Pictures on surfaces: a spoilt file, or spoilt keys, or both."""
    choice = draw.random()
    suffix, data = _spoilt_picture(draw)
    if choice < 0.5:
        suffix, data = draw.choice(list(seeds.images().items()))
    table = textures.table(suffix)
    for _ in range(_few(draw) if choice < 0.7 else 0):
        spoil(draw, table)
    return Input("scene.json", {"scene.json": seeds.as_json(table), f"paint{suffix}": data})


def _library(draw: random.Random) -> Input:
    """An OBJ file with its library of materials and their picture."""
    picture = seeds.images()[".png"]
    if draw.random() < 0.2:
        picture = pictures.spoil(draw, ".png", picture)
    return Input("mesh.obj", {**textures.model(draw), "paint.png": picture})


def _image(draw: random.Random) -> Input:
    suffix, data = _spoilt_picture(draw)
    if suffix == ".exr" and draw.random() < 0.5:
        data = pictures.spoil(draw, suffix, seeds.layered())
    elif draw.random() < 0.2:
        suffix = draw.choice(list(seeds.images()))
    table = {**copy.deepcopy(draw.choice(seeds.tables())), "background": f"sky{suffix}"}
    return Input("scene.json", {"scene.json": seeds.as_json(table), f"sky{suffix}": data})


def _checkpoint(draw: random.Random) -> Input:
    data = seeds.checkpoint()
    data = archives.spoil(draw, data) if draw.random() < 0.8 else spoil_bytes(draw, data)
    return Input("scene.json", {"scene.json": seeds.as_json(seeds.RESUMED), "part.ck": data}, "part.ck")


def _long(draw: random.Random) -> Input:
    """Small texts that mean much, and scenes with one entry many times."""
    kind = draw.choice((".toml", ".json", ".nff", ".txt", "repeat", "repeat"))
    if kind == ".toml":
        data = texts.toml(draw)
    elif kind == ".json":
        data = texts.json(draw)
    elif kind == "repeat":
        data, kind = seeds.as_json(texts.repeat(draw, draw.choice(seeds.tables()))), ".json"
    else:
        data = texts.lines(draw, seeds.NFF if kind == ".nff" else seeds.THESIS)
    return Input(f"scene{kind}", {f"scene{kind}": data})


def _xml(draw: random.Random) -> Input:
    """Mitsuba's XML."""
    text = xmlfiles.SCENE
    for _ in range(_few(draw)):
        text = xmlfiles.spoil(draw, text) if len(text) < 1 << 20 else text
    data = text.encode("utf-8", "replace")
    if draw.random() < 0.2:
        data = spoil_bytes(draw, data)
    return Input("scene.xml", {"scene.xml": data})


def _extreme(draw: random.Random) -> Input:
    """Right in form, and some of its numbers of any size that float32 holds."""
    generator = np.random.default_rng(draw.randrange(1 << 32))
    table = extreme.calm(extreme.extreme_scene(generator), generator)
    return Input("scene.json", {"scene.json": seeds.as_json(table)})


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


_KINDS: Final = (
    (_native, 30),
    (_extreme, 6),
    (_words, 10),
    (_mesh, 12),
    (_mesh_in_scene, 8),
    (_image, 8),
    (_textured, 9),
    (_library, 3),
    (_checkpoint, 6),
    (_long, 2),
    (_xml, 6),
)
"""What draws an input, and how often of 100."""
