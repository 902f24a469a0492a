"""Sweeps, turntables and camera paths: the pictures of single renders, and cameras where they should be."""

from __future__ import annotations

import re
import shutil
import threading
import warnings
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

import clrt
from clrt.base.places import At
from clrt.base.resources import kernel_folder

SCENE: dict[str, Any] = {
    "camera": {"origin": [0, 2, 5], "target": [0, 0, 0], "width": 16, "height": 12},
    "materials": {"glass": {"transmission": 0.9, "ior": 1.5}},
    "lights": [{"type": "point", "position": [2, 4, 3]}],
    "background": 0.2,
    "shapes": [
        {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "glass"},
        {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0],
         "material": {"color": {"type": "checker", "colors": [0.1, 0.9], "size": 0.5}}},
    ],
}  # fmt: skip
EYE: dict[str, Any] = {"origin": [0, 2, 5], "target": [0, 0, 0]}


@pytest.fixture(scope="module")
def scene() -> clrt.Scene:
    return clrt.load_dict(SCENE)


def test_every_combination_is_the_picture_of_a_single_render(scene: clrt.Scene) -> None:
    changes = {"camera.fov": [20, 30], "materials.glass.ior": np.array([1.2, 1.5, 1.6])}
    found = list(clrt.sweep(scene, changes, width=12, layers=["depth"]))
    assert [values["camera.fov"] for values, _ in found] == [20, 20, 20, 30, 30, 30]
    assert [values["materials.glass.ior"] for values, _ in found] == [1.2, 1.5, 1.6] * 2
    for values, image in found:
        right = clrt.render(scene.replace(values), width=12, layers=["depth"])
        assert image.hash == right.hash and np.array_equal(image.layers["depth"], right.layers["depth"])
    assert len({image.hash for _, image in found}) == 6


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"camera.fov": [20, 300]}, r"camera\.fov: 300"),
        ({"camera.fov": 20}, "it must be a list of values"),
        ({"camera.fov": []}, "it must be a list of values"),
        ({"camera.fov": "20"}, "it must be a list of values"),
        ({"camera.fv": [20]}, "did you mean 'fov'"),
        ({"max_depth": [1, 65]}, "max_depth|limit"),
        ({"camera.spp": [4], "adaptive": [{"spp": 16}, {"spp": 36}]}, "adaptive"),
        ({"camera.origin": [[0, 0, 5], [0, 0, 1]], "camera.target": [[0, 0, 0], [0, 0, 1]]}, r"camera"),
        ([1], "changes: .* it must be a dict"),
    ],
)
def test_wrong_values_are_told_before_the_first_picture(changes: Any, says: str, scene: clrt.Scene) -> None:
    with pytest.raises(clrt.ClrtError, match=says):
        clrt.sweep(scene, changes)


@pytest.mark.parametrize(
    ("picture", "says"),
    [
        ({"width": "a"}, "width: 'a' is not allowed"),
        ({"widht": 8}, "sweep: unknown key 'widht'; did you mean 'width'?"),
        ({"layers": ["dept"]}, "layers: 'dept' is not a layer"),
        ({"progress": 3}, "progress: 3 is not allowed"),
        ({"checkpoint": "a.npz"}, "checkpoint: it keeps one picture; a sweep has many"),
    ],
)
@pytest.mark.parametrize("executor", [None, ThreadPoolExecutor(1)], ids=["here", "executor"])
def test_wrong_pictures_are_told_before_the_first(
    picture: dict[str, Any], says: str, executor: Any, scene: clrt.Scene
) -> None:
    with pytest.raises(clrt.ClrtError, match=re.escape(says)):
        clrt.sweep(scene, {"camera.fov": [20, 30]}, executor=executor, **picture)


SPECTRUM = {"bands": 8}
REFUSED: dict[str, tuple[dict[str, Any], dict[str, Any], str]] = {
    "samples": ({"camera.spp": [1, 16384]}, {}, "changes['camera.spp'][1]: samples: 16 384 is above"),
    "pixels": ({"camera.height": [12, 65536]}, {"crop": (0, 0, 1, 1)},
               "changes['camera.height'][1]: pixels: 4 294 967 296 is above the limit"),
    "crop": ({"camera.width": [16, 20, 8]}, {"crop": (8, 0, 4, 4)},
             "changes['camera.width'][2]: crop: 8 0 4 4 is not a part of the picture of 8 x 12 pixels"),
    "no camera": ({"camera": [{**EYE, "width": 8, "height": 8}, None]}, {},
                  "changes['camera'][1]: scene: camera: missing"),
    "a layer of spectra": ({"spectrum": [SPECTRUM, None]}, {"layers": ["bands"]},
                           "changes['spectrum'][1]: layers: 'bands' is for scenes with a spectrum"),
    "a generation": ({"max_depth": [3, 1]}, {"layers": ["generation_3"]},
                     "changes['max_depth'][1]: layers: 'generation_3' is not a layer"),
    "adaptive": ({"adaptive": [None, {"spp": 16, "threshold": 0.1}]}, {"spp": 9},
                 "changes['adaptive'][1]: adaptive.spp: 16 is not allowed"),
    "adaptive as it stands": ({"camera.spp": [4], "adaptive": [{"spp": 16}, {"spp": 36}]}, {},
                              "changes['adaptive'][1]: adaptive.spp: 36 is not allowed"),
    "an even grid": ({"conformance": ["spd"], "adaptive": [None, {"spp": 16}]}, {},
                     "changes['adaptive'][1]: adaptive: conformance counts the rays of one even grid"),
    "depth": ({"max_depth": [1, 65]}, {}, "changes['max_depth'][1]: depth: 65 is above the limit of 64"),
    "work": ({"materials.glass.reflection": [0, 0.1], "max_depth": [1, 60], "ambient": [0.1, 0.2]}, {},
             "changes['materials.glass.reflection'][1] and changes['max_depth'][1]: work: "),
    "a radius": ({"camera.fov": [20, 30], "shapes[0].radius": [1, 1e30]}, {},
                 "changes['shapes[0].radius'][1]: shapes[0]: its coordinates are beyond 1e+15"),
    "the first value": ({"camera.spp": [16384, 1]}, {}, "changes['camera.spp'][0]: samples: 16 384"),
    "all of them": ({"camera.fov": [20, 30]}, {"crop": (8, 0, 400, 4)}, "crop: 8 0 400 4 is not a part of"),
    "two of many": ({"camera.spp": [1, 4, 9], "camera.fov": [*range(1, 171)], "max_depth": [1, 3, 99]}, {},
                    "changes['max_depth'][2]: depth: 99 is above the limit of 64"),
}  # fmt: skip


@pytest.mark.parametrize("executor", [None, ThreadPoolExecutor(1)], ids=["here", "executor"])
@pytest.mark.parametrize("name", REFUSED)
def test_pictures_that_would_be_refused_are_told_before_the_first(
    name: str, executor: Any, scene: clrt.Scene
) -> None:
    changes, picture, says = REFUSED[name]
    if name == "pixels":
        scene = scene.replace({"camera.width": 65536})
    with pytest.raises(clrt.ClrtError) as caught, warnings.catch_warnings():
        warnings.simplefilter("error")
        clrt.sweep(scene, changes, executor=executor, **picture)
    assert str(caught.value).startswith(says), caught.value


@pytest.mark.parametrize("kind", ["scene", "dict"])
def test_depths_are_held_against_the_limits_of_the_settings(kind: str, scene: clrt.Scene) -> None:
    settings = clrt.Settings(limits=clrt.Limits(depth=99))
    given = scene if kind == "scene" else SCENE
    found = clrt.sweep(given, {"max_depth": [1, 80]}, settings=settings, width=4)
    deep = scene.replace({"max_depth": 80})
    assert [image.hash for _, image in found][1] == clrt.render(deep, width=4, settings=settings).hash
    loaded = clrt.load_dict(SCENE, limits=settings.limits)
    with pytest.raises(clrt.LimitError, match=r"^changes\['max_depth'\]\[1\]: depth: 80 is above"):
        clrt.sweep(loaded, {"max_depth": [1, 80]}, width=4)


def test_samples_that_are_given_are_those_that_adaptive_goes_on_from(scene: clrt.Scene) -> None:
    """36 is no power of 4 times the camera's 1, but it is 9 x 4."""
    found = [*clrt.sweep(scene, {"adaptive": [{"spp": 36}, {"spp": 9}]}, spp=9, width=4, layers=["samples"])]
    assert {9, 36} >= {*found[0][1].layers["samples"].ravel().tolist()}
    assert {9} == {*found[1][1].layers["samples"].ravel().tolist()}


def test_looking_ahead_warns_of_nothing(scene: clrt.Scene) -> None:
    """Warnings come with the pictures that they are of, once."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        series = clrt.sweep(scene, {"camera.filter": ["box", "mitchell"]}, width=4)
        assert not told
        next(series), next(series)
    assert [("mitchell" in str(one.message)) for one in told] == [True]


@pytest.mark.parametrize(
    ("place", "values", "given"),
    [
        ("max_depth", [0, 1], {"max_depth": 2}),
        ("camera.width", [8, 9], {"width": 8}),
        ("camera.spp", [1, 4], {"spp": 4}),
        ('camera."width"', [8, 9], {"width": 8}),
        ('"max_depth"', [0, 1], {"max_depth": 2}),
        ("camera", [{**EYE, "spp": 1}, {**EYE, "spp": 4}], {"spp": 4}),
        ("camera", [EYE, {**EYE, "width": 9}], {"width": 8}),
        ("camera.fov", [20, 30], {"camera": {"origin": [0, 2, 5], "target": [0, 0, 0]}}),
    ],
)
def test_an_argument_in_the_place_of_values_is_refused(
    place: str, values: list[Any], given: dict[str, Any], scene: clrt.Scene
) -> None:
    said = f"{next(iter(given))}: it would hold for all pictures, whatever changes['{place}'] says"
    with pytest.raises(clrt.ClrtError, match=re.escape(said)):
        clrt.sweep(scene, {place: values}, **given)


def test_cameras_alike_in_what_an_argument_says(scene: clrt.Scene) -> None:
    cameras = [{**EYE, "width": 9}, {**EYE, "width": 9, "origin": [1, 2, 5]}]
    assert [image.pixels.shape[1] for _, image in clrt.sweep(scene, {"camera": cameras}, width=4)] == [4, 4]


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("camera.fov", 'camera."fov"'), ("camera.fov", "camera"),
        ("shapes[0].radius", 'shapes."ball".radius'),
        ('shapes."ball".center[0]', "shapes[0].center"), ("max_depth", '"max_depth"'),
    ],
)  # fmt: skip
def test_values_of_which_nothing_would_be_left(first: str, second: str, scene: clrt.Scene) -> None:
    scene = scene.replace({"shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "name": "ball"}]})
    values: dict[str, list[Any]] = {
        "camera": [EYE], "max_depth": [1], "camera.fov": [20], "shapes[0].radius": [1],
        'shapes."ball".center[0]': [1], "shapes[0].center": [[0, 0, 0]],
    }  # fmt: skip
    changes = {place: values.get(place, [1]) for place in (first, second)}
    says = f"changes[{second!r}]: it stands in the place of changes[{first!r}], too"
    with pytest.raises(clrt.ClrtError, match=re.escape(says)):
        clrt.sweep(scene, changes)


def test_a_part_after_the_whole_is_fine(scene: clrt.Scene) -> None:
    fovs = [20, 30]
    found = clrt.sweep(scene, {"camera": [EYE], "camera.fov": fovs}, width=8)
    assert [values["camera.fov"] for values, _ in found] == fovs


def test_values_that_cannot_be_copied_are_one_error(scene: clrt.Scene) -> None:
    deep: list[Any] = []
    for _ in range(3000):
        deep = [deep]
    for value in ((fov for fov in [20]), deep, threading.Lock()):
        with pytest.raises(clrt.ClrtError, match=r"^changes\['camera.fov'\]: .*that can be copied"):
            clrt.sweep(scene, {"camera.fov": [value]})


def test_what_a_sweep_gives_is_not_what_it_was_given(scene: clrt.Scene) -> None:
    places: list[list[float]] = [[0, 2, 5], [1, 2, 5]]
    fovs = [30, 40]
    found = []
    for values, image in clrt.sweep(scene, {"camera.origin": places, "camera.fov": fovs}, width=8):
        found.append(image.hash)
        values["camera.origin"][0] = 7
        places[1][0] = fovs[1] = 9
    assert len(set(found)) == 4
    expected = scene.replace({"camera.origin": [1, 2, 5], "camera.fov": 40})
    assert found[-1] == clrt.render(expected, width=8).hash


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


def test_the_identity_is_that_of_the_picture(scene: clrt.Scene) -> None:
    tracer = clrt.Tracer(scene)
    one = tracer.identity(width=20)
    assert one == clrt.Tracer(SCENE).identity(width=20) and one != tracer.identity(width=21)
    assert one == tracer.identity(width=20, height=15), "the size that the aspect gives"
    others = {"camera.fov": 20, "max_depth": 2, "lights[0].intensity": 2, "shapes[0].radius": 2}
    for place, value in others.items():
        tracer.update(scene.replace({place: value}))
        assert tracer.identity(width=20) != one, place
    tracer.update(scene)
    assert tracer.identity(width=20) == one


def test_the_identity_knows_what_the_environment_adds_to_the_kernels(
    scene: clrt.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Other options of compilers are other bits; kernels of the user's own, other kernels."""
    tracer = clrt.Tracer(scene)
    usual = tracer.identity(width=20)
    seen = [usual]
    for name in ("PYOPENCL_BUILD_OPTIONS", "POCL_EXTRA_BUILD_FLAGS", "CL_CONFIG_CPU_TARGET_ARCH"):
        with monkeypatch.context() as patch:
            patch.setenv(name, "")
            assert tracer.identity(width=20) == usual
            patch.setenv(name, "-cl-fast-relaxed-math")
            seen.append(tracer.identity(width=20))
    own = Path(shutil.copytree(kernel_folder(), tmp_path / "kernels"))
    monkeypatch.setenv("CLRT_KERNELS", str(own))
    assert tracer.identity(width=20) == usual, "the same text"
    (own / "film.cl").write_text((own / "film.cl").read_text("utf-8") + "// more\n", "utf-8")
    seen.append(tracer.identity(width=20))
    assert len(set(seen)) == 5
