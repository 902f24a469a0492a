"""Small files of Mitsuba's, and what is read of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import clrt
from clrt.base.errors import ClrtWarning

WOOD = '<string name="filename" value="wood.png"/>'
BALL = '<shape type="sphere">{}</shape>'
SCENES = Path(__file__).parents[1] / "scenes"


def read(tmp_path: Path, body: str, version: str = "3.0.0") -> clrt.Scene:
    """The scene of a file with these parts."""
    (tmp_path / "a.xml").write_text(f'\ufeff<scene version="{version}">{body}</scene>', encoding="utf-8")
    return clrt.load(tmp_path / "a.xml")


def table(tmp_path: Path, body: str, version: str = "3.0.0") -> dict[str, Any]:
    """What it says, as a scene file has it."""
    return read(tmp_path, body, version).to_dict()


def material(tmp_path: Path, bsdf: str) -> dict[str, Any]:
    """The material of a sphere that has this BSDF, whose values left out are the defaults'."""
    scene = read(tmp_path, BALL.format(bsdf))
    table = {"materials": {"a": scene.material_of(scene.shapes[0])}, "shapes": []}
    named = clrt.load_dict(table, folder=tmp_path)
    return dict(named.to_dict()["materials"]["a"])


def lost(tmp_path: Path, body: str) -> str:
    """What the one warning names."""
    with pytest.warns(ClrtWarning, match="left out, since there is no counterpart: ") as found:
        read(tmp_path, body)
    (one,) = [str(entry.message) for entry in found if "left out" in str(entry.message)]
    return one.split("counterpart: ")[1]
