"""Turntables and camera paths: cameras where they should be."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import msgspec
import numpy as np
import pytest

import clrt
from clrt.base.places import At


@pytest.fixture(scope="module")
def scene() -> clrt.Scene:
    """A ball of glass."""
    glass = {"transmission": 0.9, "ior": 1.5}
    return clrt.load_dict({
        "camera": {"origin": [0, 2, 5], "target": [0, 0, 0], "width": 16, "height": 12}, "background": 0.2,
        "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": glass}],
    })  # fmt: skip


def test_a_turntable_goes_once_around_the_target(scene: clrt.Scene) -> None:
    assert scene.camera is not None
    cameras = clrt.turntable(scene.camera, 8)
    places = np.array([camera.origin for camera in cameras])
    assert np.allclose(places[:, 1], 2) and np.allclose(np.hypot(places[:, 0], places[:, 2]), 5)
    angles = np.unwrap(np.arctan2(places[:, 0], places[:, 2]))
    assert np.allclose(np.diff(angles), np.pi / 4) and cameras[0] == scene.camera
    alone = scene.replace({"shapes": scene.shapes[:1], "lights": []})
    ball = [clrt.render(alone, camera=camera) for camera in cameras[::2]]
    assert np.allclose(ball[0].pixels, ball[1].pixels, atol=1e-4), "a ball looks alike from all around"
    tilted = clrt.Camera(origin=[1, 2, 3], target=[1, 1, 1], up=[0, 0, 1])
    places = np.array([camera.origin for camera in clrt.turntable(tilted, 5)])
    assert np.allclose(places[:, 2], 3)


def test_a_path_passes_through_its_keys() -> None:
    places = ((0, 5, 30), (5, 0, 40), (0, -5, 50))
    keys = [clrt.Camera(origin=[x, 1, z], target=[0, 0, 0], fov=fov) for x, z, fov in places]
    path = clrt.camera_path(keys, 9)
    assert [path[i].origin for i in (0, 4, 8)] == [tuple(map(float, key.origin)) for key in keys]
    assert [path[i].fov for i in (0, 2, 4, 8)] == [30, 35, 40, 50]
    # Catmull-Rom between two keys, straight on at the ends: (9/8 of both - 1/8 of their neighbours) / 2
    between = 9 * np.add((5, 1, 0), (0, 1, -5)) - np.add((0, 1, 5), (-5, 1, -10))
    assert np.allclose(path[6].origin, between / 16)
    around = clrt.camera_path(keys, 6, closed=True)
    assert [around[i].origin for i in (0, 2, 4)] == [tuple(map(float, key.origin)) for key in keys]
    step = [np.linalg.norm(np.subtract(a.origin, b.origin)) for a, b in pairwise(path)]
    assert max(step) < 3


def test_a_path_is_at_its_keys_when_they_say() -> None:
    """And its speed there is that from the key before to the one after, whatever the times."""
    keys = [clrt.Camera(origin=[x, 1, z], target=[0, 0, 0]) for x, z in ((0, 5), (5, 0), (0, -5), (-5, 0))]
    times = [2.0, 3.0, 7.0, 8.0]
    fine = np.array([camera.origin for camera in clrt.camera_path(keys, 6_001, times=times)])
    at = [0, 1_000, 5_000, 6_000]
    assert np.allclose(fine[at], [key.origin for key in keys], atol=1e-12)
    step = 6 / 6_000
    for place, before, after in ((1_000, 0, 2), (5_000, 1, 3)):
        right = np.subtract(keys[after].origin, keys[before].origin) / (times[after] - times[before])
        for side in (fine[place] - fine[place - 1], fine[place + 1] - fine[place]):
            assert np.allclose(side / step, right, atol=0.02)  # the curve bends by 0.0125 in a step
    assert clrt.camera_path(keys, 50, times=np.arange(4) * 1.0) == clrt.camera_path(keys, 50)
    around = clrt.camera_path(keys, 16, closed=True, times=[0, 1, 2, 4, 8])
    assert [around[i].origin for i in (2, 4, 8)] == [tuple(map(float, key.origin)) for key in keys[1:]]


@pytest.mark.parametrize("times", [[0.0, 4.0, 8.0, 12.0], [1.0, 2.0, 6.0, 7.5]])
def test_a_path_of_even_motion_is_even(times: list[float]) -> None:
    """At both ends of an open path the velocity is that of the first and of the last stretch; it was half."""
    for used in (times, times[:2]):
        keys = [clrt.Camera(origin=[time, 1, 5], target=[time, 0, 0]) for time in used]
        path = np.array([camera.origin[0] for camera in clrt.camera_path(keys, 25, times=used)])
        assert np.allclose(path, np.linspace(used[0], used[-1], 25), atol=1e-12)


def test_a_path_has_the_k_that_any_of_its_keys_states() -> None:
    """That of a later key was lost, with its middle and its two scales, where the first stated none."""
    plain = clrt.Camera(origin=(0, 0, 3), target=(0, 0, 0), fov=20, width=64, height=48)
    other = msgspec.structs.replace(plain, fov=45.0, K=((40, 0, 20), (0, 30, 24), (0, 0, 1)))
    first, last = np.array(plain.upright().K), np.array(other.upright().K)
    path = np.array([camera.K for camera in clrt.camera_path([plain, other], 3)])
    assert path == pytest.approx(np.array([first, (first + last) / 2, last]))


PLACED: dict[str, Any] = {"origin": (0.0, 0.0, 3.0), "target": (0.0, 0.0, 0.0)}
SMALL: dict[str, Any] = {**PLACED, "width": 64, "height": 48}
LARGE: dict[str, Any] = {**PLACED, "width": 128, "height": 96}


@pytest.mark.parametrize(
    ("one", "same"),
    [
        (clrt.Camera(**SMALL, K=((70, 0, 30), (0, 60, 24), (0, 0, 1)), shift=(1, 2)),
         clrt.Camera(**LARGE, K=((140, 0, 60), (0, 120, 48), (0, 0, 1)), shift=(2, 4))),
        (clrt.Camera(**SMALL, fov=30, shift=(5, -3)), clrt.Camera(**LARGE, fov=30, shift=(10, -6))),
        (clrt.Camera(**SMALL, fov=90, fov_axis="vertical", shift=(1, 2)),
         clrt.Camera(**LARGE, K=((48, 0, 64), (0, 48, 48), (0, 0, 1)), shift=(2, 4))),
        (clrt.Camera(**SMALL, fov=90, shift=(1, 2)),
         clrt.Camera(**LARGE, K=((64, 0, 62), (0, 64, 44), (0, 0, 1)))),
        (clrt.Camera(**SMALL, type="orthographic", size=3, shift=(1, 2)),
         clrt.Camera(**LARGE, type="orthographic", size=3, shift=(2, 4))),
    ],
)  # fmt: skip
def test_one_view_in_two_sizes_is_one_view(one: clrt.Camera, same: clrt.Camera) -> None:
    """By K, or with a shift, the second was another one; an angle beside K, or a shift twice, no camera."""
    for first, last in ((one, same), (same, one)):
        wide, high = first.width, first.height
        right = first.half_extents(wide, high), first.offset(wide, high)
        for camera in clrt.camera_path([first, last], 4):
            camera.check(At())
            assert (camera.width, camera.height) == (wide, high)
            found = camera.half_extents(wide, high), camera.offset(wide, high)
            assert np.allclose(found, right, rtol=1e-12), (camera, right)


@pytest.mark.parametrize(
    ("change", "where"),
    [({"type": "orthographic", "size": 2.0}, "type"), ({"mirror": True}, "mirror"),
     ({"fov_axis": "vertical"}, "fov_axis")],
)  # fmt: skip
def test_keys_between_which_nothing_lies_are_refused(change: dict[str, Any], where: str) -> None:
    plain = clrt.Camera(origin=(0, 0, 3), target=(0, 0, 0))
    other = msgspec.structs.replace(plain, **change)
    with pytest.raises(clrt.ClrtError, match=rf"keys\[1\].{where}: .* as that of keys\[0\]"):
        clrt.camera_path([plain, other], 3)


@pytest.mark.parametrize("fov", [33.3, 35.0, 45.0, 50.0])
def test_what_keys_share_a_path_has_exactly(fov: float) -> None:
    """An angle came out as 29.999999999999996; at the end of the path all is the last key's."""
    one = clrt.Camera(origin=(0.1, 0.7, 5), target=(0.1, 0.3, 0.7), up=(0.1, 0.7, 0.3), fov=fov)
    other = msgspec.structs.replace(one, origin=(3.3, 0.7, 0.1))
    last = msgspec.structs.replace(one, fov=0.1, near=0.7, shift=(0.1, 0.3), target=(0.7, 0.1, 0.3))
    for frames, times in ((7, None), (10, [0, 1, 4]), (25, [0, 0.1, 7])):
        for camera in clrt.camera_path([one, other, one], frames, times=times):
            assert (camera.fov, camera.size, camera.origin[1]) == (fov, 2.0, 0.7)
            assert (camera.target, camera.up) == (one.target, one.up)
        *_, end = clrt.camera_path([one, other, last], frames, times=times)
        assert end == last
    by_k = clrt.Camera(**PLACED, K=((77.7, 0, 20.1), (0, 33.3, 24.7), (0, 0, 1)))
    assert all(camera.K == by_k.K for camera in clrt.camera_path([by_k, by_k], 7))


def _view(origin: Any, up: Any = (0, 1, 0)) -> clrt.Camera:
    return clrt.Camera(origin=origin, target=(0, 0, 0), up=up)


@pytest.mark.parametrize("frames", [2, 3, 4])
@pytest.mark.parametrize(
    ("keys", "what"),
    [
        ([_view((0, 0, 5)), _view((0, 0, 5), (0, -1, 0))], "`up` turns over"),
        ([_view((0, 0, 5), (0.6, 0.8, 0)), _view((0, 0, 5), (-1.2, -1.6, 0))], "`up` turns over"),
        ([_view((0, 0, 5)), _view((0, 0, -5))], "leads through its target"),
        ([_view((1, 2, -3)), _view((-2, -4, 6))], "leads through its target"),
    ],
)  # fmt: skip
def test_keys_that_lie_opposite_are_refused(keys: list[clrt.Camera], what: str, frames: int) -> None:
    """Cameras between them had no `up`, or stood at their target; others were upside down from one on."""
    with pytest.raises(clrt.ClrtError, match=rf"keys\[0\] and keys\[1\]: between them .*{what}"):
        clrt.camera_path(keys, frames)


def test_keys_around_a_target_are_a_path_and_those_beyond_a_pole_are_named() -> None:
    around = [_view((5, 0, 0)), _view((0, 0, 5)), _view((-5, 0, 0)), _view((0, 0, -5))]
    assert len(clrt.camera_path(around, 2, closed=True)) == 2
    bent = clrt.camera_path([*around[::2], around[1]], 21)
    assert min(np.linalg.norm(camera.origin) for camera in bent) > 0.3
    said = r"keys\[0\] and keys\[1\], at frame 1: camera\.up: .* must not be parallel"
    with pytest.raises(clrt.ClrtError, match=said):
        clrt.camera_path([_view((0, 5, 0.001)), _view((0, 5, -0.001))], 3)


def test_the_lens_of_a_path_changes_between_its_keys() -> None:
    placed = {"origin": (0.0, 1.0, 5.0), "target": (0.0, 1.0, 0.0)}
    one = clrt.Camera(**placed, aperture=0.1, shift=(0.0, 2.0))
    other = clrt.Camera(**placed, aperture=0.3, focus=3, near=1)
    middle = clrt.camera_path([one, other], 3)[1]
    assert (middle.aperture, middle.focus, middle.near, middle.shift) == (0.2, 4, 0.5, (0, 1))
    assert clrt.camera_path([one, one], 4)[1:] == [one.upright()] * 3


@pytest.mark.parametrize(
    "call",
    [
        lambda camera: clrt.turntable(camera, 0), lambda camera: clrt.turntable("x", 3),
        lambda camera: clrt.camera_path([camera], 3), lambda camera: clrt.camera_path([camera, 3], 3),
        lambda camera: clrt.camera_path([camera, camera], 1),
        lambda camera: clrt.camera_path([camera, clrt.Camera()], 3),
        lambda camera: clrt.camera_path([camera, clrt.Camera(**PLACED, K="K")], 3),
        lambda camera: clrt.camera_path([camera, clrt.Camera(**PLACED, width=0)], 3),
        lambda camera: clrt.camera_path([clrt.Camera(**PLACED, shift=3), camera], 3),
        lambda camera: clrt.turntable(clrt.Camera(origin=(0, 0, 1), target="here"), 3),
        lambda camera: clrt.camera_path([camera, camera], 2, times=[0, 0]),
        lambda camera: clrt.camera_path([camera, camera], 2, times=[0, 1, 2]),
        lambda camera: clrt.camera_path([camera, camera], 2, closed=True, times=[0, 1]),
        lambda camera: clrt.camera_path([camera, camera], 2, times=[-1.7e308, 1.7e308]),
        lambda camera: clrt.camera_path([camera, camera], 2, times=[0, "1"]),
    ],
)  # fmt: skip
def test_what_makes_no_path_is_an_error(call: Any, scene: clrt.Scene) -> None:
    with pytest.raises(clrt.ClrtError):
        call(scene.camera)
