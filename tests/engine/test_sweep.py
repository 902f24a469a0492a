"""Sweeps: the pictures of single renders. Their cameras: test_campath.py."""

from __future__ import annotations

import re
import shutil
import threading
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
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
