"""Causes that feign others: the plainest that explains a picture comes first, and says what is wrong."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import clrt
import compare_samples as samples
from clrt.base.resources import validation_module
from clrt.images.file import decode, encode

causes = validation_module("compare.causes")
curves = validation_module("compare.curves")
metrics = validation_module("compare.metrics")
pictures = validation_module("compare.pictures")
SceneReference = validation_module("compare.reference").SceneReference

FIRST, SECOND = "light 1 of 2 (point at -3, 5, 4)", "light 2 of 2 (point at 4, 5, 2)"


def of_clay() -> clrt.Scene:
    """One material and no background: its values tell where they are lit, so that curves explain much."""
    return clrt.load_dict({
        "camera": {"origin": [0, 1, 5], "target": [0, 0.5, 0], "width": 80, "height": 60}, "ambient": 0.1,
        "lights": [{"type": "point", "position": [-3, 5, 4], "intensity": 0.6},
                   {"type": "point", "position": [4, 5, 2], "intensity": 0.3}],
        "materials": {"clay": {"color": [0.8, 0.5, 0.3]}},
        "shapes": [{"type": "sphere", "center": [0, 0.5, 0], "radius": 1, "material": "clay"},
                   {"type": "plane", "point": [0, -0.5, 0], "normal": [0, 1, 0], "material": "clay"}],
    })  # fmt: skip


def lit(first: float, second: float) -> dict[str, Any]:
    return {"lights[0].intensity": 0.6 * first, "lights[1].intensity": 0.3 * second}


def lights_of(scene: clrt.Scene, factor: float) -> dict[str, Any]:
    """All lights times a factor."""
    rgb = clrt.scene.scene.rgb
    return {f"lights[{n}].intensity": list(factor * np.array(rgb(light.intensity)))
            for n, light in enumerate(scene.lights)}  # fmt: skip


def stored(pixels: np.ndarray) -> np.ndarray:
    return decode(encode(np.ascontiguousarray(pixels, np.float32)))


def first_cause(picture: Any, reference: Any, **options: Any) -> Any:
    return clrt.compare(picture, reference, **options).causes[0]


CLAY = {
    "ambient light times 0.5": {"ambient": 0.05},
    "ambient light times 2": {"ambient": 0.2},
    "ambient light missing": {"ambient": 0.0},
    "all lights times 0.8": lit(0.8, 0.8),
    "all lights times 1.5": lit(1.5, 1.5),
    f"{FIRST} times 0.8 and {SECOND} times 0.7": lit(0.8, 0.7),
    "all lights times 0.5 and ambient light times 2": {**lit(0.5, 0.5), "ambient": 0.2},
}


@pytest.mark.parametrize("name", CLAY)
@pytest.mark.parametrize("file", ["floats", "8 bits"])
def test_a_light_comes_before_a_curve_that_feigns_it(name: str, file: str) -> None:
    wrong = clrt.render(of_clay().replace(CLAY[name])).pixels
    best = first_cause(wrong if file == "floats" else encode(wrong), of_clay())
    assert (best.name, best.proven) == (name, True) and best.left < 0.01


SHIPPED = {
    "room": ({"ambient": 0.5}, "ambient light times 0.5"),
    "fresnel": (0.8, "all lights times 0.8"),
    "gallery": (1.3, "all lights times 1.3"),
    "refraction": (0.8, "all lights times 0.8"),
    "mirrors": (1.3, "all lights times 1.3"),
}


@pytest.mark.parametrize("scene", SHIPPED)
def test_faults_of_shipped_scenes_that_curves_and_exposures_feign(scene: str) -> None:
    change, name = SHIPPED[scene]
    right = clrt.load(scene).override(spp=1)
    if isinstance(change, dict):
        changes = {key: list(factor * np.array(clrt.scene.scene.rgb(getattr(right, key))))
                   for key, factor in change.items()}  # fmt: skip
    else:
        changes = lights_of(right, change)
    best = first_cause(encode(clrt.render(right.replace(changes), width=120).pixels), right)
    assert best.name.startswith(name) and best.proven and " and " not in best.name, best.name


def test_a_curve_is_a_curve_though_there_is_a_scene() -> None:
    """Of the scene only shares are fitted then: nothing that has to be rendered for it alone."""
    right, tried = samples.picture(), list[str]()
    wrong = stored(right / (1 + right))
    whole = SceneReference(samples.scene(), samples.WIDTH, samples.HEIGHT)
    (best, *_) = pictures.compare_pictures(wrong, right, scene=whole, report=tried.append).causes
    assert best.name == "another tone curve" and best.proven
    assert "all lights" in tried and not any("fov" in name or "max_depth" in name for name in tried)


def test_what_takes_more_numbers_has_to_leave_less() -> None:
    curve = causes.Cause("another tone curve", "", 0.0, numbers=256)
    for left, first in ((0.005, "light"), (0.05, "another tone curve")):
        light = causes.Cause("light", "", left)
        assert causes.ranked([curve, light])[0].name == first
    many = causes.Cause("lights", "", 0.04, numbers=5)
    assert causes.ranked([many, causes.Cause("light", "", 0.05)])[0].name == "light"


# --- numbers that show what is wrong


@pytest.mark.parametrize(
    ("factor", "text"),
    [(0.5, "0.5"), (2.0, "2"), (1.2, "1.2"), (0.318, "0.32"), (33.51, "34"), (1.03, "1.03"), (1.05, "1.05"),
     (1.0052, "1.005"), (0.994, "0.994"), (0.97, "0.97"), (1.0, "1"), (float("inf"), "inf")],
)  # fmt: skip
def test_a_factor_says_how_far_from_1_it_is(factor: float, text: str) -> None:
    assert causes.told(factor) == text


def test_no_light_is_told_to_be_times_1() -> None:
    wrong = clrt.render(of_clay().replace(lit(1.03, 1.0)))
    assert first_cause(wrong, of_clay()).name == f"{FIRST} times 1.03"


@pytest.mark.parametrize("factor", [1.02, 1.05, 0.99])
def test_no_cause_is_a_factor_of_1(factor: float) -> None:
    right = clrt.render(of_clay()).pixels
    assert first_cause(right * np.float32(factor), right).name == f"exposure factor {factor:g}"


# --- channels and colours


def test_channels_that_are_multiples_of_each_other_are_not_swapped() -> None:
    """Swapped and scaled back they are what they were, and a factor for each explains as much."""
    grey = np.random.default_rng(1).uniform(0.2, 0.9, (40, 50, 1))
    right = grey * [0.9, 0.03, 0.4]
    for wrong in (right * 1.004, right * [1.0, 0.8, 1.1]):
        found = pictures.explain(wrong, right, causes.FLOAT)
        assert not any("swapped" in cause.name or "rotated" in cause.name for cause in found)
    colours = np.random.default_rng(3).uniform(0.1, 0.9, (40, 50, 3))
    (best, *_) = pictures.explain(colours[..., ::-1] * [0.9, 0.7, 1.0], colours, causes.FLOAT)
    assert best.name == "red and blue swapped and colour balance"


GREYS = {
    "of linear values": lambda p: p @ [0.2126, 0.7152, 0.0722],
    "of stored values": lambda p: metrics.decoded(metrics.encoded(p) @ [0.299, 0.587, 0.114]),
    "mean": lambda p: p.mean(axis=-1),
}


@pytest.mark.parametrize("grey", GREYS)
def test_a_grey_picture_is_told(grey: str) -> None:
    """It was 'a missing shadow' of most of the picture, or a balance of colours."""
    right = samples.picture()
    wrong = np.repeat(GREYS[grey](right)[..., None], 3, axis=-1).astype(np.float32)
    tried: list[str] = []
    whole = SceneReference(samples.scene(), samples.WIDTH, samples.HEIGHT)
    for scene, picture in ((None, wrong), (None, stored(wrong)), (whole, wrong)):
        found = pictures.compare_pictures(picture, right, scene=scene, report=tried.append).causes
        assert [(cause.name, cause.proven) for cause in found] == [("in grey", True)]
    assert tried == []
    (best, *_) = pictures.compare_pictures(wrong * np.float32(0.7), right).causes
    assert best.name == "in grey and exposure factor 0.7" and best.proven


@pytest.mark.parametrize("amount", [0.5, 1.3])
def test_less_colour_and_more_are_told(amount: float) -> None:
    right = samples.picture()
    grey = (right @ np.float32([0.2126, 0.7152, 0.0722]))[..., None]
    best = first_cause(grey + np.float32(amount) * (right - grey), right)
    assert best.name == f"saturation times {amount:g}" and best.proven


def test_what_is_cut_off_has_its_colour() -> None:
    """The right picture, taken to stored values and back, was clipped as well, and seemed to need no more."""
    right = samples.picture() * np.float32(3)
    found = pictures.explain(np.clip(right, 0, 1), right, causes.FLOAT)
    assert found[0].name == "clipped" and not any("saturation" in cause.name for cause in found)


def test_most_of_a_picture_is_no_place() -> None:
    """Where it differs nearly everywhere nothing can be said of what 'agrees elsewhere'."""
    right = samples.picture()
    for rows, count in ((20, 1), (60, 0)):
        shaded = right.copy()
        shaded[-rows:] *= np.float32(0.6)
        assert len(pictures.regions(shaded, right, causes.FLOAT)) == count


@pytest.mark.parametrize(
    ("name", "change", "undo"),
    [
        ("horizontal flip and all lights times 0.5", lit(0.5, 0.5), np.s_[:, ::-1]),
        ("vertical flip and ambient light times 2", {"ambient": 0.2}, np.s_[::-1]),
        ("red and blue swapped and all lights times 2", lit(2, 2), np.s_[..., ::-1]),
    ],
)
def test_lights_of_a_picture_that_is_turned_or_swapped_need_no_exposure(
    name: str, change: dict[str, Any], undo: Any
) -> None:
    """An exposure was undone first, and then explained away by four shares: a proven list of faults that were
    not there."""
    scene = of_clay().replace({
        "materials.clay.color": [0.8, 0.5, 0.2], "background": [0.1, 0.15, 0.3],
        "lights[0].intensity": [0.6, 0.5, 0.4], "shapes[0].center": [0.9, 0.8, 0],
    })  # fmt: skip
    changed = {place: value * np.array([1, 5 / 6, 4 / 6]) if place == "lights[0].intensity" else value
               for place, value in change.items()}  # fmt: skip
    picture = clrt.render(scene.replace(changed)).pixels[undo]
    assert first_cause(np.ascontiguousarray(picture), scene).name == name
