"""Faces of a scene file's mesh with `uv` or normals: concave ones become triangles that cover just them."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.meshfiles.outlines import Outlines
from clrt.scene.mesh_arrays import FEW
from validation.scenes.parts import KEYHOLE

DART = [[0, 0, 0], [2, -1, 0], [0, 2, 0], [-2, -1, 0]]
SQUARE = [[4, 0, 0], [5, 0, 0], [5, 1, 0], [4, 1, 0]]
BOW = [[0, 0, 0], [3, 0, 0], [3, 2, 0], [1, -1, 0], [0, 2, 0]]


def mesh(corners: list[list[float]], *faces: list[int], **keys: Any) -> clrt.Scene:
    how = keys or {"uv": [[x, y] for x, y, _ in corners]}
    shape = {"type": "mesh", "vertices": corners, "faces": list(faces), **how}
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


@pytest.mark.parametrize("many", [1, FEW])
def test_many_faces_and_faces_of_many_corners_are_cut_too(many: int) -> None:
    """Together, in place of one after the other."""
    angles = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    lengths = np.where(np.arange(12) % 2, 1, 0.4)
    star = np.stack([lengths * np.cos(angles), lengths * np.sin(angles), 0 * angles], axis=1)
    corners = [*DART, *SQUARE, *star.tolist()]
    faces = [[1, 2, 3, 0], [4, 5, 6], [4, 5, 6, 7], [*range(8, 20)]] * many
    (shape,) = mesh(corners, *faces).shapes
    vertices, found = shape.data().vertices, shape.data().faces
    assert [len(face) for face in found] == ([3, 3, 3, 4] + [3] * 10) * many
    parts = np.array([area(vertices[face]) for face in found]).reshape(many, -1)
    whole = [area(np.array(DART, float)), 0.5, 1.0, area(star)]
    assert parts.min() > 0 and parts.sum(axis=1) == pytest.approx(np.full(many, sum(whole)))


def stars(draw: np.random.Generator) -> Iterator[np.ndarray]:
    """Outlines with dents, round about, the other way round, and one with a hole that a bridge leads to."""
    yield np.roll(DART, -1, axis=0).astype(float)
    for size in (5, 6, 9, 14):
        for way in (1, -1):
            angles = np.linspace(0, 2 * np.pi, size, endpoint=False)[::way] + draw.uniform(-0.1, 0.1, size)
            lengths = np.where(np.arange(size) % 3 == 1, draw.uniform(0.1, 0.3, size), 1)
            yield np.stack([lengths * np.cos(angles), lengths * np.sin(angles), 0 * angles], axis=1)
    yield np.array(KEYHOLE)


@pytest.mark.parametrize("names", [["smooth"], ["normals"], ["uv"], ["smooth", "uv"]])
def test_rays_meet_its_outline_and_nothing_else(names: list[str]) -> None:
    """As they do the polygon; also once a plain mesh has been changed to it. Computed normals are its own."""
    draw = np.random.default_rng(7)
    rays = np.c_[draw.uniform(-1.2, 1.2, (4000, 2)), np.full(4000, 3.0)], [0.0, 0.0, -1.0]
    for corners in stars(draw):
        size = len(corners)
        keys = {"smooth": True, "normals": draw.uniform(0.1, 1, (size, 3)), "uv": corners[:, :2]}
        shape = {"type": "mesh", "faces": [[*range(size)]], **{name: keys[name] for name in names}}
        angles = np.linspace(0, 2 * np.pi, size, endpoint=False)
        ring = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
        plain = clrt.load_dict({"ambient": 1.0, "shapes": [{**shape, "vertices": ring}]})
        changed = plain.replace({"shapes[0].vertices": corners})
        outline = {"type": "polygon", "points": corners.tolist()}
        with clrt.Tracer({"ambient": 1.0, "shapes": [outline]}) as polygon, clrt.Tracer(plain) as tracer:
            tracer.update(changed)
            expected, met = (np.isfinite(each.intersect(*rays).t) for each in (polygon, tracer))
        assert np.array_equal(met, expected) and expected.any()
        (read,) = changed.shapes
        if names[0] == "smooth":
            up = np.tile([0, 0, np.sign(area(corners))], (size, 1))
            assert read.data().normals == pytest.approx(up, abs=1e-12)


@pytest.mark.parametrize("keys", [{}, {"smooth": True}])
def test_a_face_that_crosses_itself_is_told_of(keys: dict[str, Any]) -> None:
    with pytest.warns(clrt.ClrtWarning, match=r"shapes\[0\].*cross"):
        mesh(BOW, [0, 1, 2, 3, 4], **keys)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mesh(SQUARE, [0, 1, 2, 3])


def test_more_entries_than_a_value_has_are_refused_before_they_are_a_list() -> None:
    endless = np.broadcast_to(0.5, (10**6, 10**6))
    with pytest.raises(clrt.SceneError, match="too many entries; a value has at most"):
        clrt.load_dict({"shapes": [{"type": "polygon", "points": endless}]})


def faces_of_all_kinds() -> Iterator[np.ndarray]:
    """Corners of faces: plane and not, thin, without area, that cross themselves."""
    draw = np.random.default_rng(3)
    for size in (3, 4, 5, 6, 8, 9):
        for bend in (0.0, 1e-3, 1e-2, 0.1, 1.0):
            for _ in range(40):
                angles = np.sort(draw.uniform(0, 2 * np.pi, size))
                ring = np.stack([np.cos(angles), np.sin(angles), bend * draw.normal(size=size)], axis=1)
                yield ring * draw.uniform(0.1, 1, (size, 1))
                yield draw.normal(size=(size, 3)) * (1, 1, bend)
    for far in (0.5, 0.25001, 0.2501, 0.25002, 0.250005):  # the last corner, from beyond a side to within
        yield np.array([[0.0, 0, 0], [0.5, -far, 0], [1, 0, 0], [0.5, -0.25, 0]])
        yield np.array([[0.5, -far + 0.25, 0], [1, 0, 0], [0.5, 1, 0], [0, 0, 0]])
    yield np.zeros((4, 3))
    yield np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]])
    yield np.array([[0.0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0]])


def test_a_face_alone_is_cut_as_many_are() -> None:
    pytest.importorskip("mapbox_earcut", reason="needs the optional dependency clrt[mesh]")
    kinds: Counter[str] = Counter()
    for corners in faces_of_all_kinds():
        alone, many, face = Outlines(), Outlines(), np.arange(len(corners))
        found = alone.few(corners, face)
        rows, cuts = many.cut(corners, face[None]) if len(face) > 3 else ((), ())
        if found is None:
            kinds["unclear"] += 1
            continue
        kinds["cut" if len(found) > 1 else "left" if alone.left_over else "whole"] += 1
        expected = face[cuts[0]] if len(rows) else face[None]
        assert [part.tolist() for part in found] == expected.tolist()
        assert alone.left_over == many.left_over
    assert min(kinds[kind] for kind in ("unclear", "cut", "left", "whole")) > 10, kinds
