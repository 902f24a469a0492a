"""Arguments whose own methods fail, or that say more than their numbers do."""

from __future__ import annotations

import ctypes
import pickle
import sys
import threading
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import clrt
from clrt.base.arguments import device, names, number, vectors, whole
from clrt.base.elsewhere import apart
from clrt.base.errors import show
from clrt.engine.answers import FIELDS, Crossings
from clrt.engine.batch import Batch


class Failing:
    def __repr__(self) -> str:
        raise RuntimeError("mine")


def test_what_cannot_be_shown_is_named_by_its_class() -> None:
    assert show(Failing()) == "a Failing" and show(10**5000) == "a int"


def test_an_array_is_no_list_of_names() -> None:
    for value in (np.zeros((2, 3)), np.zeros(0), np.ma.masked_array([1.0, 2.0], mask=[0, 1])):
        with pytest.raises(clrt.ClrtError, match="it must be a list of names"):
            names("layers", value)


def test_masks_are_not_ignored() -> None:
    numbers = np.ma.masked_array([[0.0, 0.0, 4.0]], mask=[[0, 0, 1]])
    with pytest.raises(clrt.ClrtError, match="origins: 1 of its numbers are masked"):
        vectors("origins", numbers, np.float32)
    assert vectors("origins", np.ma.masked_array([[0.0, 0.0, 4.0]]), np.float32).shape == (1, 3)


def test_times_are_no_numbers() -> None:
    """numpy counts a span among its integers, and makes one of a span or a date in nanoseconds."""
    for time in (np.timedelta64(5, "s"), np.timedelta64(5, "ns"), np.datetime64(5, "ns")):
        for call in (whole, number, device):
            with pytest.raises(clrt.ClrtError, match=r"x: .* is not allowed; it must be a"):
                call("x", time)
        with pytest.raises(clrt.ClrtError, match="it must be numbers in an array"):
            vectors("x", np.array([[time] * 3], object), np.float32)
        for value in (time, np.array([time] * 3)):
            with pytest.raises(clrt.ClrtError, match="a time or a date cannot be part of a scene"):
                clrt.load_dict({"max_depth": value})


def test_more_rays_than_numpy_makes_a_view_of() -> None:
    one = np.float32([0, 0, 1])
    for n in (1 << 30, 1 << 40):
        with pytest.raises(clrt.LimitError, match=r"rays: .* are more than any memory holds"):
            Batch(np.broadcast_to(one, (n, 1, 3)), np.broadcast_to(one, (1, n, 3)), 0.0, 1.0)
    with pytest.raises(clrt.ClrtError, match="do not go together"):
        Batch(np.zeros((2, 1, 3)), np.zeros((3, 2, 3)), np.zeros(3), 1.0)
    assert Batch(np.zeros((2, 1, 3)), np.zeros((3, 3)), np.zeros((4, 1, 1)), 1.0).shape == (4, 2, 3)


def test_numbers_of_thousands_of_digits_are_refused() -> None:
    for wrong in ({10**5000: 1}, {"shapes": [{"type": 10**5000}]}):
        with pytest.raises(clrt.ClrtError):
            clrt.load_dict(wrong)
    with pytest.raises(clrt.ClrtError, match="local_size"):
        clrt.Settings(local_size=10**5000)


class Many:
    """As distributed's asynchronous Client: it answers in coroutines only."""

    asynchronous = True

    def get_executor(self) -> None:
        raise TypeError("inside")


def test_an_executor_that_answers_in_coroutines_is_refused() -> None:
    with pytest.raises(clrt.ClrtError, match=r"executor: .* is not allowed; .* without asynchronous=True"):
        clrt.render("bubble", executor=Many())  # type: ignore[arg-type]


@pytest.mark.parametrize("one", [10**30, Fraction(9), Decimal(9), np.float64(9), np.int16(9)])
def test_rays_are_any_kind_of_real_numbers(one: object) -> None:
    expected = vectors("origins", [[float(one), 0.0, 1.0]], np.float32)  # type: ignore[arg-type]
    for given in ([[one, 0, 1]], np.array([[one, 0, 1]], object)):
        assert vectors("origins", given, np.float32).tobytes() == expected.tobytes()
    for wrong in (True, "9", None, 1j, 10**5000):
        with pytest.raises(clrt.ClrtError, match=r"origins: .* is not allowed; it must be numbers"):
            vectors("origins", np.array([[one, wrong, 1]], object), np.float32)


def test_a_bound_of_one_ray_has_one_shape() -> None:
    with pytest.raises(clrt.ClrtError, match=r"t_max: 'x' .* in an array of shape \(\)$"):
        Batch([0, 0, 0], [0, 0, 1], 0, "x")


def test_fractions_are_numbers_and_what_holds_itself_is_told() -> None:
    sphere = {"type": "sphere", "center": [0, 0, 0], "radius": Fraction(1, 2)}
    assert clrt.load_dict({"ambient": 1, "shapes": [sphere]}).shapes[0].radius == 0.5  # type: ignore[union-attr]
    endless: dict[str, object] = {"diffuse": 0.5}
    endless["color"] = endless
    with pytest.raises(clrt.SceneError, match=r"materials\.m: it holds itself, or"):
        clrt.load_dict({"materials": {"m": endless}})


def test_cameras_of_arrays_are_those_of_lists() -> None:
    one, other = (
        clrt.Camera(origin=kind([0, 0, 4]), target=kind([0, 0, 0]), pose=kind(np.eye(4).tolist()))
        for kind in (np.array, list)
    )
    assert one == other and hash(one) == hash(other) and len({one, other}) == 1
    assert one != clrt.Camera(origin=np.array([0, 0, 5]), target=np.zeros(3))
    assert one != "camera"


def test_the_tables_of_a_picture_stay_as_they_are() -> None:
    seconds = {"closest": 1.0}
    image = clrt.Image(np.zeros((1, 1, 3), np.float32), stats={"seconds": seconds, "generations": [{"a": 1}]})
    seconds.clear()
    for table in (image.stats, image.stats["seconds"], image.stats["generations"][0]):
        with pytest.raises(clrt.ClrtError, match="stays as it is"):
            table.clear()  # type: ignore[attr-defined]
    assert image.stats == {"seconds": {"closest": 1.0}, "generations": [{"a": 1}]}
    assert pickle.loads(pickle.dumps(image)).stats == image.stats


def test_crossings_can_be_replaced_in_part() -> None:
    flat = {name: np.zeros((2, k) if k > 1 else 2, kind) for name, (kind, k) in FIELDS.items()}
    found = Crossings.of(flat, np.array([0, 2]))
    other = replace(found, t=found.t + 1)
    assert len(other) == 2 and other.t.tolist() == [1, 1] and other.rays.tolist() == [0, 0]


@pytest.mark.skipif(sys.platform != "linux", reason="glibc tells the size")
def test_threads_of_clrts_own_have_their_own_stack() -> None:
    """A driver that compiles runs over the least one that a program may choose for its threads."""
    sizes: list[int] = []

    def measured() -> None:
        limits = ctypes.create_string_buffer(256)
        libc, size = ctypes.CDLL(None), ctypes.c_size_t()
        libc.pthread_self.restype = ctypes.c_void_p
        if libc.pthread_getattr_np(ctypes.c_void_p(libc.pthread_self()), limits) == 0:
            libc.pthread_attr_getstacksize(limits, ctypes.byref(size))
            sizes.append(size.value)

    before = threading.stack_size(1 << 16)
    try:
        apart(Path.cwd(), measured)
        assert threading.stack_size() == 1 << 16
    finally:
        threading.stack_size(before)
    assert sizes and sizes[0] > 1 << 20
