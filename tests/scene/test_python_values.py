"""Values that Python has and scene files have not: taken where they mean one thing, else refused."""

from __future__ import annotations

import datetime
import subprocess
import sys
import uuid
from decimal import Decimal
from enum import Enum
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt

BALL: dict[str, Any] = {"type": "sphere", "center": [2.5, -1, 0.25], "radius": 1}
CORNERS = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
TRIANGLE: dict[str, Any] = {"type": "mesh", "vertices": CORNERS, "faces": [[0, 1, 2]]}


@pytest.mark.parametrize("table", [
    {"shapes": [{**BALL, "center": {2.5, -1, 0.25}}]},
    {"shapes": [BALL], "background": frozenset({0.9, 0.1, 0.5})},
    {"shapes": [{**TRIANGLE, "faces": [{2, 0, 1}]}]},
    {"shapes": [{**TRIANGLE, "vertices": [[0, 0, 0], (1, 0, 0), {0, 1, 2}]}]},
    {"shapes": [{**BALL, "material": {"color": {"type": "checker", "colors": [0.1, {0.2, 0.3, 0.4}]}}}]},
])  # fmt: skip
def test_sets_have_no_order(table: dict[str, Any]) -> None:
    with pytest.raises(clrt.SceneError, match="a set has no order; give a list or a tuple"):
        clrt.load_dict(table)
    scene = clrt.load_dict({"shapes": [BALL]})
    with pytest.raises(clrt.SceneError, match="a set has no order"):
        scene.replace({"shapes[0].center": {1.0, 2.0, 3.0}})


@pytest.mark.parametrize("value", [
    b"red", bytearray(b"red"), np.bytes_(b"red"), memoryview(np.ones(3)), Decimal("0.5"), uuid.UUID(int=5),
    datetime.date(2026, 1, 2), datetime.datetime(2026, 1, 2), datetime.time(3), datetime.timedelta(4),
])  # fmt: skip
def test_no_texts_are_made_of_other_things(value: Any) -> None:
    """A shape was called 'YmFsbA==' that was to be b"ball"; of a Decimal it was said that it is a text."""
    says = rf"an object of class {type(value).__name__} cannot be part of a scene; give a text or a number"
    checker = {"type": "checker", "colors": [0.1, 0.2]}
    for table in (
        {"shapes": [BALL, {**BALL, "name": value}]}, {"shapes": [{**BALL, "material": {"color": value}}]},
        {"background": value}, {"shapes": [{**TRIANGLE, "vertices": value}]},
        {"shapes": [{**TRIANGLE, "vertices": [[0, 0, value], *CORNERS[1:]]}]},
        {"materials": {"a": {"ior": value}}},
        {"shapes": [{**BALL, "material": {"color": checker, "specular": {**checker, "colors": [0, value]}}}]},
    ):  # fmt: skip
        with pytest.raises(clrt.SceneError, match=says):
            clrt.load_dict(table)
    with pytest.raises(clrt.SceneError, match=says):
        clrt.load_dict({"shapes": [BALL]}).replace({"shapes[0].name": value})


def test_bytes_are_refused_in_words_where_python_warns_of_them() -> None:
    """`python -bb` makes an error of `str(b"...")`: it was that in the place of the refusal."""
    code = f"import clrt\nclrt.load_dict({{'shapes': [{{**{BALL}, 'name': b'ball'}}]}})"
    done = subprocess.run([sys.executable, "-bb", "-c", code], capture_output=True, text=True)
    assert "shapes[0].name: b'ball' is not allowed; an object of class bytes" in done.stderr, done.stderr


@pytest.mark.parametrize("kind", [np.longdouble, np.float64, np.float32, np.float16])
def test_numpys_numbers_of_all_sizes(kind: Any) -> None:
    center = np.array(BALL["center"], kind)
    scene = clrt.load_dict({"shapes": [{**BALL, "center": center, "radius": kind(1)}]})
    assert scene == clrt.load_dict({"shapes": [BALL]})
    moved = scene.replace({"shapes[0].center": 2 * center, "shapes[0].radius": kind(0.5)})
    assert moved.to_dict()["shapes"][0]["center"] == [5, -2, 0.5]


def test_a_text_that_is_an_enum_is_its_text(tmp_path: Path) -> None:
    class Given(str, Enum):  # noqa: UP042  (of a StrEnum str() is its text)
        SCENE = str(tmp_path / "ball.toml")
        KIND = "sphere"

    clrt.load_dict({"shapes": [{**BALL, "type": Given.KIND}]}).save(Given.SCENE)
    assert clrt.load(Given.SCENE) == clrt.load(tmp_path / "ball.toml") == clrt.load_dict({"shapes": [BALL]})


def test_cameras_of_arrays_and_of_lists_are_equal() -> None:
    one = clrt.Camera(origin=np.array([0.0, 0, 5]), target=np.zeros(3))  # type: ignore[arg-type]
    other = clrt.Camera(origin=[0, 0, 5], target=[0, 0, 0])  # type: ignore[arg-type]
    assert one == other and hash(one) == hash(other)
    assert one != clrt.Camera(origin=(0, 0, 6), target=(0, 0, 0)) and one != "camera"


def test_fractions_are_numbers() -> None:
    half = clrt.load_dict({"shapes": [{**BALL, "radius": Fraction(1, 2)}]})
    assert half == clrt.load_dict({"shapes": [{**BALL, "radius": 0.5}]})
