"""Shapes are flattened some thousand at a time: what each takes meanwhile, and that nothing shows of it."""

from __future__ import annotations

import tracemalloc
from typing import Any

import numpy as np
import pytest

from clrt.flatten import mesh, quadric
from clrt.flatten.flatten import flatten
from clrt.formats import load_dict
from clrt.scene.scene import Scene
from flatten_samples import SHAPES, transforms

ROUND = {"center": [0, 0, 0], "radius": 1}
ENDS = {"p0": [0, 0, 0], "p1": [0, 1, 0.2]}
BOWL = {"apex": [0, 0, 0], "axis": [0, 1, 0], "focal": 1, "height": 1}
BENT = [1, 2, -3, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, -7]
KINDS: dict[str, tuple[dict[str, Any], int]] = {
    "cylinders": ({"type": "cylinder", "radius": 1, **ENDS}, 1000),
    "cones": ({"type": "cone", "r0": 1, "r1": 0, **ENDS}, 1000),
    "ellipsoids": ({"type": "ellipsoid", "center": [0, 0, 0], "radii": [1, 2, 3]}, 1000),
    "paraboloids": ({"type": "paraboloid", **BOWL}, 1000),
    "quadrics": ({"type": "quadric", "coefficients": BENT}, 1000),
    "clipped quadrics": ({"type": "quadric", "coefficients": BENT, "clip": [[-1, -1, -1], [1, 1, 1]]}, 1000),
    "flattened spheres": ({"type": "sphere", **ROUND, "transform": [{"scale": [1, 2, 3]}]}, 1200),
    "spheres": ({"type": "sphere", **ROUND}, 1000),
    "disks": ({"type": "disk", "normal": [0, 1, 0], **ROUND}, 1000),
    "polygons": ({"type": "polygon", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0]]}, 1200),
    "boxes": ({"type": "box", "min": [0, 0, 0], "max": [1, 1, 1]}, 2500),
}  # fmt: skip


def peak(scene: Scene) -> int:
    tracemalloc.start()
    try:
        flatten(scene)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("kind", KINDS)
def test_bytes_that_a_shape_takes(kind: str) -> None:
    """Of these 132 to 952 are kept; each one more beyond the thousands that are treated at once."""
    shape, most = KINDS[kind]
    (one,) = load_dict({"shapes": [shape]}).shapes
    flatten(Scene(shapes=(one,)))  # what is made once
    few, many = 4000, 12000
    assert peak(Scene(shapes=(one,) * many)) - peak(Scene(shapes=(one,) * few)) <= most * (many - few)


@pytest.mark.parametrize("block", [1, 2, 7])
def test_blocks_change_no_bit(block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(3)
    shapes = [
        shape | {"transform": steps}
        for shape, _ in SHAPES.values()
        for steps in (None, transforms(rng, similar=shape["type"] == "disk"))
    ]
    scene = load_dict({"shapes": shapes + [{"type": "box", "min": [0, 0, 0], "max": [3, 1, 2]}] * 3})
    whole = flatten(scene).hash
    monkeypatch.setattr(quadric, "_BLOCK", block)
    monkeypatch.setattr(mesh, "_ROWS", block)
    assert flatten(scene).hash == whole
