"""Scenes whose surfaces show pictures, and OBJ files with libraries of materials, to be spoiled."""

from __future__ import annotations

import random
from typing import Any, Final

from ..scenes.parts import Table
from .seeds import SIDE
from .sizes import size

WORDS: Final = (
    b"map_Kd", b"map_Ke", b"map_d", b"map_Bump", b"norm", b"newmtl", b"Kd", b"Ks", b"Ni", b"Tr", b"illum",
    b"-s", b"-o", b"-clamp", b"-bm", b"-texres", b"on", b"paint.png", b"../paint.png", b"/dev/zero",
    b"mesh.mtl", b"mesh.obj", b"1e39", b"nan", b"-1", b"", b"\xff",
)  # fmt: skip

OBJ: Final = b"""\
mtllib mesh.mtl
v -1 -1 0
v 1 -1 0
v 1 1 0
v -1 1 0
vt 0 0
vt 2.5 0
vt 2.5 -1
vt 0 1
vn 0 0 1
usemtl paint
f 1/1/1 2/2/1 3/3/1
usemtl glow
f 1/1/1 3/3/1 4/4/1
"""

MTL: Final = b"""\
newmtl paint
Kd 0.8 0.7 0.6
Ks 0.2 0.2 0.2
Ns 30
illum 2
map_Kd -s 2 2 1 -o 0.1 0 0 -clamp on paint.png
norm -bm 0.5 paint.png
newmtl glow
Kd 0.1 0.1 0.1
Ke 0.5 0.4 0.1
map_Ke paint.png
Ni 1.4
d 0.5
"""


def table(suffix: str) -> Table:
    """A small scene in which each key of pictures stands somewhere; its picture is paint + suffix."""
    file = f"paint{suffix}"
    plain: dict[str, Any] = {"type": "image", "file": file}
    moved = {**plain, "wrap": "mirror", "scale": [2.0, -0.5], "offset": [0.1, 9.0], "filter": "nearest"}
    tinted = {**plain, "wrap": "clamp", "tint": [0.5, 0.2, 0.9], "encoding": "linear"}
    ball = {"color": plain, "normal_map": {"file": file, "scale": 0.5}, "specular": 0.3,
            "highlight_color": moved}  # fmt: skip
    glass = {"fresnel": True, "diffuse": 0.0, "transmission_color": tinted, "reflection_color": moved}
    square = [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1]]
    uv = [[0, 0], [1, 0], [1, 1], [0, 1]]
    return {
        "camera": {"origin": [0, 1, 6], "target": [0, 0, 0], **SIDE}, "max_depth": 2, "shadow": "tinted",
        "materials": {"ball": ball, "glass": glass, "glow": {"color": 0.5, "emission": tinted}},
        "lights": [{"type": "point", "position": [3, 5, 4]}],
        "shapes": [
            {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "ball"},
            {"type": "box", "min": [1, -1, 1], "max": [2, 0, 2], "material": "glass"},
            {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0], "material": {"color": moved}},
            {"type": "cone", "p0": [-2, -1, 0], "p1": [-2, 1, 0], "r0": 0.7, "r1": 0.1, "caps": True,
             "material": "ball"},
            {"type": "disk", "center": [2, 1, -1], "normal": [0, 0, 1], "radius": 1, "material": "glow"},
            {"type": "mesh", "vertices": square, "faces": [[0, 1, 2, 3]], "uv": uv, "material": "ball"},
        ],
    }  # fmt: skip


def model(draw: random.Random) -> dict[str, bytes]:
    """mesh.obj and mesh.mtl, of which one has words changed, left out, many times, or of another line."""
    files = {"mesh.obj": OBJ, "mesh.mtl": MTL}
    name = draw.choice(("mesh.obj", "mesh.mtl", "mesh.mtl"))
    lines = [line.split(b" ") for line in files[name].splitlines()]
    for _ in range(draw.choice((1, 1, 2, 5))):
        line = draw.choice(lines)
        at, choice = draw.randrange(len(line)), draw.random()
        if choice < 0.5:
            line[at] = draw.choice((*WORDS, b"%d" % size(draw)))
        elif choice < 0.65:
            line.insert(at, draw.choice(WORDS))
        elif choice < 0.8:
            del line[at:]
            line.append(b"")
        elif choice < 0.9:
            line[:] = draw.choice(lines)
        else:
            lines += [list(line)] * draw.choice((2, 1000))
    return {**files, name: b"\n".join(map(b" ".join, lines)) + b"\n"}
