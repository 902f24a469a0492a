"""Meshes of glass with a hole, or with faces of both windings, are told of; closed ones are not."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.flatten.flatten import flatten
from tests.flatten.test_winding import ball

GLASS = {"diffuse": 0, "transmission": 1, "fresnel": True}
CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
CUBE = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
SPHERE, TRIANGLES = ball(6)
SINGLE, NUMBERS = SPHERE[TRIANGLES].reshape(-1, 3), np.arange(TRIANGLES.size).reshape(-1, 3)


def told(vertices: Any, faces: Any, **material: Any) -> list[str]:
    mesh = {"type": "mesh", "vertices": vertices, "faces": faces, "material": {**GLASS, **material}}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        flatten(clrt.load_dict({"ambient": 1, "shapes": [mesh]}))
    return [str(warning.message) for warning in caught]


OPEN = {
    "a pane": (CORNERS[:4], CUBE[:1]),
    "a tube": (CORNERS, CUBE[:4]),
    "a face is missing": (CORNERS, CUBE[1:]),
    "a face is turned": (CORNERS, [CUBE[0][::-1], *CUBE[1:]]),
    "a triangle is missing": (SPHERE, TRIANGLES[1:]),
    "a triangle is turned": (SPHERE, [*TRIANGLES[1:].tolist(), TRIANGLES[0, ::-1].tolist()]),
}
CLOSED = {
    "a cube": (CORNERS, CUBE),
    "a ball": (SPHERE, TRIANGLES),
    "a ball whose triangles share no vertex": (SINGLE, NUMBERS),
    "whose corners differ by rounding": (SINGLE + 1e-16 * (NUMBERS.reshape(-1, 1) % 7), NUMBERS),
    "two in one": (np.concatenate([CORNERS, CORNERS + 3]), CUBE + (np.array(CUBE) + 8).tolist()),
}


@pytest.mark.parametrize("name", OPEN)
def test_open_meshes_of_glass_are_told_of(name: str) -> None:
    vertices, faces = OPEN[name]
    (text,) = told(vertices, faces)
    assert text.startswith("shapes[0]: an open mesh transmits but encloses nothing") and "thin = true" in text
    assert told(vertices, faces, thin=True) == [] == told(vertices, faces, transmission=0, fresnel=False)


@pytest.mark.parametrize("name", CLOSED)
def test_closed_ones_are_not(name: str) -> None:
    assert told(*CLOSED[name]) == []
