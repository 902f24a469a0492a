"""A small OBJ with its MTL, for tests of materials."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import clrt

WITH_UV = "vt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n"
CORNERS = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\n"


def load(folder: Path, mtl: str, obj: str = "usemtl m\nf 1 2 3\n", **options: Any) -> clrt.Scene:
    (folder / "a.mtl").write_text(mtl)
    (folder / "a.obj").write_text(f"mtllib a.mtl\n{CORNERS}{obj}")
    return clrt.load(folder / "a.obj", **options)
