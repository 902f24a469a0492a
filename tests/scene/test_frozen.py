"""A scene stays as it was checked, all through; what is masked is refused, not taken."""

from __future__ import annotations

import copy
import json
import pickle
from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import numpy as np
import pytest

import clrt
from clrt.base.frozen import FrozenDict
from clrt.scene.scene import Mesh

CORNERS = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
SCENE: dict[str, Any] = {
    "ambient": 0.5, "spectrum": {"bands": 4},
    "camera": {"origin": [0, 0, 4], "target": [0, 0, 0], "width": 8, "height": 8},
    "materials": {
        "a": {"color": {"type": "checker", "colors": [0.9, {"samples": [[400, 1], [700, 0.5]]}]}},
        "b": {"ior": [[400, 1.5], [700, 1.4]], "transmission": 0.5},
    },
    "lights": [{"type": "point", "position": [0, 5, 5]}],
    "shapes": [
        {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "a"},
        {"type": "mesh", "vertices": CORNERS, "faces": [[0, 1, 2, 3], [0, 1, 2]], "smooth": True},
        {"type": "mesh", "vertices": CORNERS, "faces": [[0, 1, 2]], "normals": [[0, 0, 1]] * 4,
         "transform": [{"scale": 2}, {"rotate": ['x', 30]}]},
        {"type": "box", "min": [0, 0, 0], "max": [1, 1, 1], "material": {"emission": 1}},
    ],
}  # fmt: skip

CHANGES: list[Callable[[dict[str, Any]], Any]] = [
    lambda d: d.clear(), lambda d: d.pop("a"), lambda d: d.popitem(), lambda d: d.update(a=5),
    lambda d: d.setdefault("c", 5), lambda d: d.__setitem__("a", 5), lambda d: d.__delitem__("a"),
    lambda d: d.__ior__({"a": 5}),
]  # fmt: skip


@pytest.fixture
def scene() -> clrt.Scene:
    return clrt.load_dict(SCENE)


def _held(value: Any, place: str) -> Iterator[tuple[str, Any]]:
    """All that a record leads to, with its place."""
    yield place, value
    if isinstance(value, msgspec.Struct):
        for name in value.__struct_fields__:
            yield from _held(getattr(value, name), f"{place}.{name}")
        if isinstance(value, Mesh):
            yield from _held(value.data(), f"{place}.data()")
    elif hasattr(value, "__dataclass_fields__"):
        for name in value.__dataclass_fields__:
            yield from _held(getattr(value, name), f"{place}.{name}")
    elif isinstance(value, dict):
        for key, item in value.items():
            yield from _held(item, f"{place}[{key!r}]")
    elif isinstance(value, (tuple, list)):
        for number, item in enumerate(value):
            yield from _held(item, f"{place}[{number}]")


def test_nothing_in_a_scene_can_be_changed(scene: clrt.Scene) -> None:
    found = dict(_held(scene, "scene"))
    assert len(found) > 100 and "scene.shapes[1].data().normals" in found
    for place, value in found.items():
        if isinstance(value, np.ndarray):
            assert not value.flags.writeable, place
        elif isinstance(value, dict):
            assert isinstance(value, FrozenDict), place
        else:
            assert not isinstance(value, (list, set, bytearray)), place
        for name in getattr(value, "__struct_fields__", ()) or getattr(value, "__dataclass_fields__", ()):
            with pytest.raises(AttributeError):
                setattr(value, name, None)


@pytest.mark.parametrize("number", range(len(CHANGES)))
def test_materials_stay(number: int, scene: clrt.Scene) -> None:
    with pytest.raises(clrt.ClrtError, match="this dict stays as it is"):
        CHANGES[number](scene.materials)
    with pytest.raises((clrt.ClrtError, AttributeError)):
        scene.materials |= {"a": 5}  # type: ignore[misc]
    assert scene == clrt.load_dict(SCENE)


def test_frozen_scenes_are_equal_copied_pickled_and_saved(scene: clrt.Scene) -> None:
    for other in (copy.copy(scene), copy.deepcopy(scene), pickle.loads(pickle.dumps(scene)),
                  clrt.load_dict(scene.to_dict()), scene.override(width=9).override(width=8)):  # fmt: skip
        assert other == scene and other.materials == dict(scene.materials)
        assert isinstance(other.materials, FrozenDict)
        assert other.shapes[1].data().faces[0].tolist() == [0, 1, 2, 3]  # type: ignore[attr-defined]
    assert json.loads(json.dumps(scene.to_dict())) == scene.to_dict()
    assert (scene.materials | {"c": 1}).keys() == {"a", "b", "c"}


def test_images_stay() -> None:
    pixels = np.zeros((2, 2, 3), np.float32)
    image = clrt.Image(pixels, {"depth": pixels[..., 0]}, {"traced": 5}, {"scene": "a"})
    for table in (image.layers, image.stats, image.metadata):
        with pytest.raises(clrt.ClrtError, match="this dict stays as it is"):
            table["a"] = 5  # type: ignore[index]
    assert json.dumps(image.stats) == '{"traced": 5}'
    assert pickle.loads(pickle.dumps(image)).stats == {"traced": 5}


MASKED: dict[str, dict[str, Any]] = {
    "vertices": {"vertices": np.ma.masked_array(CORNERS, [[0] * 3, [1] * 3, [0] * 3, [0] * 3], float)},
    "whole vertices": {"vertices": np.ma.masked_equal(CORNERS, 1)},
    "faces": {"faces": np.ma.masked_array([[0, 1, 2]], [[0, 1, 0]])},
    "normals": {"normals": np.ma.masked_equal([[0.0, 0.0, 1.0]] * 4, 0)},
    "rows": {"vertices": [np.ma.masked_equal(row, 1) for row in CORNERS]},
    "a face": {"faces": [np.ma.masked_equal([0, 1, 2], 1)]},
    "faces of objects": {"faces": np.array([np.ma.masked_equal([0, 1, 2], 1), [0, 1, 2, 3]], object)},
}


@pytest.mark.parametrize("name", MASKED)
def test_masked_meshes_are_refused(name: str) -> None:
    mesh = {"type": "mesh", "vertices": CORNERS, "faces": [[0, 1, 2]], **MASKED[name]}
    with pytest.raises(clrt.SceneError, match=r"masked|not allowed"):
        clrt.load_dict({"shapes": [mesh]})


def test_masks_that_hide_nothing_and_matrices_are_arrays() -> None:
    plain = {"type": "mesh", "vertices": CORNERS, "faces": [[0, 1, 2]]}
    arrays = {"vertices": np.ma.masked_array(CORNERS), "faces": np.ma.masked_array([[0, 1, 2]])}
    whole = {"type": "mesh", **arrays}
    with pytest.warns(PendingDeprecationWarning):
        flat = {"type": "mesh", "vertices": np.matrix(CORNERS), "faces": np.matrix([[0, 1, 2]])}
    scenes = [clrt.load_dict({"shapes": [mesh]}) for mesh in (plain, whole, flat)]
    assert scenes[0] == scenes[1] == scenes[2]
    assert {type(scene.shapes[0].data().vertices) for scene in scenes} == {np.ndarray}  # type: ignore[attr-defined]


class Table:
    """As of pandas, xarray and the like."""

    def __init__(self, values: list[list[float]] | str) -> None:
        self.values = values

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        if isinstance(self.values, str):
            raise ValueError(self.values)
        return np.array(self.values, dtype)


def test_what_gives_an_array_of_itself_is_one() -> None:
    plain = {"type": "mesh", "vertices": CORNERS, "faces": [[0, 1, 2]]}
    given = {"type": "mesh", "vertices": Table(CORNERS), "faces": Table([[0, 1, 2]])}
    assert clrt.load_dict({"shapes": [given]}) == clrt.load_dict({"shapes": [plain]})
    refused = {**plain, "vertices": Table("on a GPU:\n call cpu()")}
    with pytest.raises(clrt.SceneError, match=r"vertices: a Table is no array of numbers \(on a GPU: call"):
        clrt.load_dict({"shapes": [refused]})


def test_masked_tables_and_pictures_are_refused() -> None:
    pixels = np.ma.masked_equal(np.zeros((2, 2, 3), np.float32), 0)
    with pytest.raises(clrt.ClrtError, match="pixels: 12 of its numbers are masked"):
        clrt.Image(pixels)
    with pytest.raises(clrt.ClrtError, match="masked"):
        clrt.Image(np.zeros((2, 2, 3), np.float32), {"depth": pixels[..., 0]})
    center = np.ma.masked_equal([0.0, 1.0, 2.0], 1)
    with pytest.raises(clrt.SceneError, match=r"shapes\[0\]\.center"):
        clrt.load_dict({"shapes": [{"type": "sphere", "center": center, "radius": 1}]})
