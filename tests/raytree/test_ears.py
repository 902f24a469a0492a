"""Outlines of many corners as triangles, in time that grows no faster than their squared corners."""

from __future__ import annotations

import math
import sys
import time
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.raytree.solids import triangles_of

FAR = np.full(3, 9.0)


def around(count: int, turns: int, radii: Any) -> np.ndarray:
    angle = 2 * np.pi * turns * np.arange(count) / count
    return np.round(np.stack([radii * np.cos(angle), radii * np.sin(angle)], axis=1), 6)


def spiral(count: int) -> np.ndarray:
    angle = np.linspace(0, 6 * np.pi, count // 2)
    way = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.concatenate([way * (angle + 2)[:, None], (way * (angle + 3)[:, None])[::-1]])


OUTLINES = {
    "zigzag": lambda count: around(count, 1, np.where(np.arange(count) % 2, 1, 0.3)),
    "spiral": spiral,
    "spiral the other way": lambda count: spiral(count)[::-1],
    "circle": lambda count: around(count, 1, 1.0),
    "steps": lambda count: np.array([(k // 2, (k + 1) // 2) for k in range(count - 1)] + [(count / 2, -1.0)]),
}  # fmt: skip


def cut(points: np.ndarray) -> tuple[np.ndarray, float]:
    """The corners of the triangles (m, 3, 3), of a polygon and of a mesh alike, and processor time of one."""
    flat = np.insert(points, 2, 0.0, axis=1)
    polygon = clrt.load_dict({"shapes": [{"type": "polygon", "points": flat}]}).shapes[0]
    mesh = clrt.load_dict({"shapes": [{"type": "mesh", "vertices": flat, "faces": [[*range(len(flat))]]}]})
    start = time.process_time()
    made = triangles_of(polygon, -FAR, FAR)
    taken = time.process_time() - start
    same = triangles_of(mesh.shapes[0], -FAR, FAR)
    assert made is not None and same is not None and np.array_equal(made[0][made[1]], same[0][same[1]])
    return made[0][made[1]], taken


def areas(corners: np.ndarray) -> np.ndarray:
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] / 2


@pytest.mark.parametrize("package", [True, False])
@pytest.mark.parametrize("name", OUTLINES)
def test_triangles_cover_the_outline_and_no_more(
    name: str, package: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not package:
        monkeypatch.setitem(sys.modules, "mapbox_earcut", None)
    points = OUTLINES[name](200)
    x, y = points.T
    whole = (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2
    found = areas(cut(points)[0])
    assert len(found) == len(points) - 2
    assert np.abs(found).sum() == pytest.approx(abs(whole), rel=1e-9)
    assert (np.sign(found[np.abs(found) > 1e-12]) == math.copysign(1, whole)).all()


@pytest.mark.parametrize("package", [True, False])
def test_many_corners_take_no_time(package: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """A star of 801 corners, each of whose sides crosses all others, took 10 s."""
    if not package:
        monkeypatch.setitem(sys.modules, "mapbox_earcut", None)
    for points in (around(801, 400, 1.0), *(make(1600) for make in OUTLINES.values())):
        assert cut(points)[1] < 1.5
