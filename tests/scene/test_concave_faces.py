"""Faces of a scene file's mesh with `uv`: concave ones are cut into triangles that cover them and no more."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import clrt

DART = [[0, 0, 0], [2, -1, 0], [0, 2, 0], [-2, -1, 0]]
SQUARE = [[4, 0, 0], [5, 0, 0], [5, 1, 0], [4, 1, 0]]
BOW = [[0, 0, 0], [3, 0, 0], [3, 2, 0], [1, -1, 0], [0, 2, 0]]


def mesh(corners: list[list[float]], *faces: list[int]) -> clrt.Scene:
    uv = [[x, y] for x, y, _ in corners]
    shape = {"type": "mesh", "vertices": corners, "faces": list(faces), "uv": uv}
    return clrt.load_dict({"shapes": [shape], "ambient": 1.0})


def area(corners: np.ndarray) -> float:
    x, y = corners[:, 0], corners[:, 1]
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2


def test_a_concave_face_becomes_triangles_and_a_convex_one_stays() -> None:
    # the corner that points inwards is not the first: a fan about corner 1 would lie outside
    (shape,) = mesh([*DART, *SQUARE], [1, 2, 3, 0], [4, 5, 6, 7]).shapes
    vertices, faces = shape.data().vertices, shape.data().faces
    assert [len(face) for face in faces] == [3, 3, 4]
    whole = area(np.array(DART, float))
    parts = [area(vertices[face]) for face in faces[:2]]
    assert min(parts) > 0 and sum(parts) == pytest.approx(whole)


def test_a_face_that_crosses_itself_is_told_of() -> None:
    with pytest.warns(clrt.ClrtWarning, match=r"shapes\[0\].*cross"):
        mesh(BOW, [0, 1, 2, 3, 4])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mesh(SQUARE, [0, 1, 2, 3])


def test_more_entries_than_a_value_has_are_refused_before_they_are_a_list() -> None:
    endless = np.broadcast_to(0.5, (10**6, 10**6))
    with pytest.raises(clrt.SceneError, match="too many entries; a value has at most"):
        clrt.load_dict({"shapes": [{"type": "polygon", "points": endless}]})
