"""Random files of meshes, with what such files have: for readers that are compared with one another."""

from __future__ import annotations

import random
import re
import struct
from pathlib import Path
from typing import Any

import numpy as np

from tests.gltf_samples import gltf, some

Rng = random.Random
_ENDS = ("\n", "\r\n", "\r")


def write_sample(path: Path, seed: int) -> None:
    """A file of the kind that its suffix says."""
    rng = Rng(f"{path.suffix} {seed}")
    writer = {".obj": _obj, ".ply": _ply, ".stl": _stl, ".gltf": gltf, ".glb": gltf}[path.suffix]
    path.write_bytes(writer(rng, path))


def _outline(rng: Rng, size: int, dented: bool) -> list[list[float]]:
    """The corners of a plane face somewhere in space."""
    angles = sorted(rng.sample(range(0, 360, 15), size))
    while max((b - a) % 360 for a, b in zip(angles, [*angles[1:], angles[0]], strict=True)) > 170:
        angles = sorted(rng.sample(range(0, 360, 15), size))
    radii = [1.0] * size
    if dented:
        radii[rng.randrange(size)] = 0.1
    turn = np.linalg.qr(np.array([[rng.gauss(0, 1) for _ in range(3)] for _ in range(3)]))[0]
    flat = [[r * np.cos(np.radians(a)), r * np.sin(np.radians(a)), 0.0]
            for a, r in zip(angles, radii, strict=True)]  # fmt: skip
    middle = [rng.uniform(-5, 5) for _ in range(3)]
    return [[round(float(x), 5) for x in row] for row in np.array(flat) @ turn.T + middle]


def _outlines(rng: Rng) -> list[list[list[float]]]:
    """Some faces; now and then dented ones among them."""
    dented = rng.random() < 0.3
    sizes = rng.choice([(3,), (4,), (3, 4), (3, 4, 5, 6, 9)])
    found = []
    for _ in range(rng.randint(1, 7)):
        size = rng.choice(sizes)
        found.append(_outline(rng, size, dented and size > 3 and rng.random() < 0.5))
    return found


def _numbers(row: list[float]) -> str:
    return " ".join(map(repr, row))


def _obj(rng: Rng, path: Path) -> bytes:
    back, between, forms = rng.random() < 0.5, rng.random() < 0.5, rng.random() < 0.2
    form = rng.choice(["v", "v/vt", "v//vn", "v/vt/vn"])
    head: list[str] = []
    library = rng.random() < 0.6
    if library:
        path.with_suffix(".mtl").write_text("newmtl a b\nKd 1 0 0\nnewmtl c\nKd 0 1 0\nnewmtl d\nKd 0 0 1\n")
        head.append(f"mtllib {path.stem}.mtl")
    vertices: list[str] = []
    faces: list[str] = []
    counts = {"v": 0, "vt": 0, "vn": 0}
    for outline in _outlines(rng):
        if forms:
            form = rng.choice(["v", "v/vt", "v//vn", "v/vt/vn"])
        lines = vertices if between else head
        corners = []
        for row in outline:
            lines.append(f"v {_numbers(row)}")
            if form != "v" or forms:
                lines.append(f"vt {_numbers(some(rng, 2))}")
                lines.append(f"vn {_numbers(some(rng, 3))}")
            counts = {key: count + 1 for key, count in counts.items()}
            corners.append(form.replace("vt", "T").replace("vn", "N").replace("v", "V"))
        size = len(outline)
        words = []
        for place, corner in enumerate(corners):
            numbers = place - size if back and between else counts["v"] - size + place + 1
            words.append(re.sub("[VTN]", str(numbers), corner))
        if library and rng.random() < 0.6:
            faces.append(f"usemtl {rng.choice(['a b', 'c', 'd'])}")
        if rng.random() < 0.3:
            faces.append(rng.choice(["o thing", "g part one", "s 1", "s off", "", "l 1 2", "# words"]))
        line = "f " + " ".join(words)
        if between:
            head += [*vertices, *faces, line]
            vertices.clear()
            faces.clear()
        else:
            faces.append(line)
    return _odd(rng, [*head, *vertices, *faces])


def _odd(rng: Rng, lines: list[str]) -> bytes:
    """Lines as some programs write them."""
    if rng.random() < 0.3:
        lines = [line.replace(" ", "\t") for line in lines]
    if rng.random() < 0.3:
        lines = [f"{line} # said" if rng.random() < 0.3 else line for line in lines]
    if rng.random() < 0.3:
        lines = [f"  {line}" if rng.random() < 0.3 else line for line in lines]
    if rng.random() < 0.3:
        lines = [line.replace(" ", " \\\n", 1) if line.startswith("f ") and "#" not in line else line
                 for line in lines]  # fmt: skip
    text = rng.choice(_ENDS).join([rng.choice(["# made", "# f\xfcr"]), *lines, ""])
    return rng.choice([b"", b"\xef\xbb\xbf"]) + text.encode(rng.choice(["utf-8", "latin-1"]))


def _ply(rng: Rng, path: Path) -> bytes:
    outlines = _outlines(rng)
    order = rng.choice(["ascii", "binary_little_endian", "binary_big_endian"])
    if order != "ascii":  # clrt refuses others
        outlines = [outline for outline in outlines if len(outline) == len(outlines[0])]
    names = ["x", "y", "z"]
    names += ["nx", "ny", "nz"] if rng.random() < 0.4 else []
    names += rng.choice([[], ["u", "v"], ["texture_u", "texture_v"], ["s", "t"]])
    extra = rng.random() < 0.3
    kind = rng.choice(["float", "double", "float32", "float64"])
    tones = rng.choice([[], ["red", "green", "blue"]])
    of_faces = rng.random() < 0.3
    rows = [row + some(rng, len(names) - 3) for outline in outlines for row in outline]
    head = ["ply", f"format {order} 1.0", "comment made", f"element vertex {len(rows)}"]
    head += [f"property {kind} {name}" for name in names] + ["property int count"] * extra
    head += [f"property uchar {name}" for name in tones] * (not of_faces)
    corners = rng.choice(["vertex_index", "vertex_indices"])
    head += [f"element face {len(outlines)}", f"property list uchar int {corners}"]
    head += [f"property uchar {name}" for name in tones] * of_faces
    text = rng.choice(_ENDS[:2] if order == "ascii" else _ENDS[:1]).join([*head, "end_header", ""]).encode()
    size = "f" if "float" in kind and "64" not in kind else "d"
    written: list[list[tuple[str, Any]]] = []  # by row the forms and values
    for row in rows:
        written.append([(size, value) for value in row] + [("i", 7)] * extra)
        written[-1] += [("B", rng.randrange(256)) for _ in tones] * (not of_faces)
    first = 0
    for outline in outlines:
        numbers: list[tuple[str, Any]] = [("i", first + k) for k in range(len(outline))]
        written.append([("B", len(outline)), *numbers])
        written[-1] += [("B", rng.randrange(256)) for _ in tones] * of_faces
        first += len(outline)
    if order == "ascii":
        return text + b"".join(" ".join(str(value) for _, value in row).encode() + b"\n" for row in written)
    mark = "<" if "little" in order else ">"
    rows_of = (struct.pack(mark + "".join(k for k, _ in row), *(v for _, v in row)) for row in written)
    return text + b"".join(rows_of)


def _stl(rng: Rng, path: Path) -> bytes:
    faces = [_outline(rng, 3, False) for _ in range(rng.randint(1, 6))]
    if rng.random() < 0.4:
        rows = b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel(face), 0) for face in faces)
        return rng.choice([b"made", b"solid made"]).ljust(80) + struct.pack("<I", len(faces)) + rows
    solids = [faces, faces[:1]] if rng.random() < 0.2 else [faces]
    lines = []
    for solid in solids:
        name = rng.choice(["", " a", " facet vertex 1 2 3", " endsolid"])
        lines.append(f"solid{name}")
        for face in solid:
            lines += ["facet normal 0 0 1", "outer loop", *(f"vertex {_numbers(row)}" for row in face)]
            lines += ["endloop", "endfacet"]
        lines.append(f"endsolid{name}")
    if rng.random() < 0.3:
        lines = [line.replace(" ", "\t") for line in lines]
    if rng.random() < 0.3:
        lines = [f"  {line}" for line in lines]
    return rng.choice([b"", b"\xef\xbb\xbf"]) + "\n".join([*lines, ""]).encode()
