"""Causes: each usual mistake is planted in a picture and must be found; where there is none, none may be."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace
from PIL import Image

import clrt
import compare_samples as samples
from clrt.base.resources import validation_module
from clrt.images.file import decode, encode
from clrt.scene.scene import edited

causes = validation_module("compare.causes")
pictures = validation_module("compare.pictures")
SceneReference = validation_module("compare.reference").SceneReference
metrics = validation_module("compare.metrics")


def stored(pixels: np.ndarray) -> np.ndarray:
    """What comes back from a file of 8 bits."""
    return decode(encode(np.ascontiguousarray(pixels)))


def found(picture: np.ndarray, reference: np.ndarray | None = None) -> list[Any]:
    reference = samples.picture() if reference is None else reference
    return list(pictures.compare_pictures(picture, reference).causes)


PLANTED: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "horizontal flip": lambda p: p[:, ::-1],
    "vertical flip": lambda p: p[::-1],
    "rotation by 180 degrees": lambda p: p[::-1, ::-1],
    "transpose": lambda p: p.swapaxes(0, 1),
    "rotation by 90 degrees to the right": lambda p: np.rot90(p, -1),
    "rotation by 90 degrees to the left": lambda p: np.rot90(p, 1),
    "transpose about the other diagonal": lambda p: p[::-1, ::-1].swapaxes(0, 1),
    "red and blue swapped": lambda p: p[..., ::-1],
    "red and green swapped": lambda p: p[..., [1, 0, 2]],
    "green and blue swapped": lambda p: p[..., [0, 2, 1]],
    "channels rotated": lambda p: p[..., [1, 2, 0]],
    "sRGB applied twice": metrics.encoded,
    "sRGB not applied": metrics.decoded,
    "gamma 2.2 in place of sRGB": lambda p: metrics.decoded(np.clip(p, 0, 1) ** (1 / 2.2)),
    "negative": lambda p: metrics.decoded(1 - metrics.encoded(p)),
    "exposure factor 0.5": lambda p: p * 0.5,
    "exposure factor 4": lambda p: p * 4,
    "exposure factor 0.97": lambda p: p * 0.97,
    "colour balance": lambda p: p * [1.1, 1, 0.8],
    "shift by 1 pixel left": lambda p: np.roll(p, -1, axis=1),
    "shift by 3 pixels right and 2 pixels up": lambda p: np.roll(p, (-2, 3), axis=(0, 1)),
    "vertical flip and sRGB not applied": lambda p: metrics.decoded(p[::-1]),
    "horizontal flip and red and blue swapped and exposure factor 0.5": lambda p: 0.5 * p[:, ::-1, ::-1],
    "cropped": lambda p: p[10:60, 20:80],
}


@pytest.mark.parametrize("name", PLANTED)
@pytest.mark.parametrize("file", [stored, np.float32], ids=["8 bits", "floats"])
def test_what_was_planted_is_found_and_undone(name: str, file: Callable[[np.ndarray], np.ndarray]):
    best = found(file(PLANTED[name](samples.picture())))[0]
    assert best.name == name and best.proven
    if best.undone is not None and name != "exposure factor 4":  # which clips for good
        assert np.abs(metrics.encoded(best.undone) - metrics.encoded(samples.picture())).mean() < 0.05


def test_a_gain_is_told_in_stops_and_per_channel():
    assert found(samples.picture() * 0.5)[0].text == "all of it is 2 times too dark (-1.00 stops)"
    assert found(samples.picture() * [1.5, 1, 1])[0].text == "red, green and blue are scaled by 1.5, 1, 1"


@pytest.mark.parametrize("shift", [(0.5, 0.5), (-0.5, 0), (0, 0.5)])
def test_half_a_pixel_is_likely_from_pictures_and_proven_by_the_scene(shift: tuple[float, float]):
    moved = clrt.render(samples.with_camera(shift=shift)).pixels
    ways = {
        (0.5, 0.5): "0.5 pixel left and 0.5 pixel up",
        (-0.5, 0): "0.5 pixel right",
        (0, 0.5): "0.5 pixel up",
    }
    best = found(moved)[0]
    assert best.name == f"shift by {ways[shift]}" and best.likely and not best.proven
    best = in_scene(moved)[0]
    assert best.name == f"shift by {ways[shift]}" and best.proven


@pytest.mark.parametrize("seed", range(3))
def test_pictures_of_other_things_have_no_cause(seed: int):
    random = np.random.default_rng(seed)
    coarse = random.random((9, 12, 3))
    assert not [c for c in found(np.kron(coarse, np.ones((8, 8, 1)))) if c.certain]
    assert not [c for c in found(samples.ours(samples.with_camera(origin=(3, 2, 5))).pixels) if c.certain]


def test_the_best_cause_comes_first_and_each_name_once():
    many = [
        causes.Cause(name, "", left, certain=certain)
        for name, left, certain in (
            ("a", 0.3, True),
            ("b", 0.0, False),
            ("c", 0.05, True),
            ("a", 0.02, True),
            ("d", 0.2, True),
        )
    ]
    best = [(cause.name, cause.left) for cause in causes.ranked(many)]
    assert best == [("a", 0.02), ("c", 0.05), ("b", 0.0), ("d", 0.2)]


def test_pictures_that_agree_have_no_cause():
    picture = samples.picture()
    equal = {"identical": picture.copy(), "equal": stored(picture), "equal ": picture + 1e-5}
    for verdict, other in equal.items():
        result = pictures.compare_pictures(other, picture)
        assert (result.verdict, result.causes, result.passed) == (verdict.strip(), (), True)
    odd = picture.copy()
    odd[30, 40] += 0.05
    assert pictures.compare_pictures(odd, picture).verdict == "same picture"


def test_other_pixels_of_the_same_view():
    half = clrt.render(samples.scene(), samples.WIDTH * 2, samples.HEIGHT * 2).pixels
    best = found(half)[0]
    assert best.name == "another size" and best.likely
    assert best.text == "the same view in 192 x 144 in place of 96 x 72 pixels"
    larger = np.pad(samples.picture(), ((5, 5), (9, 3), (0, 0)))
    assert found(larger)[0].name == "larger view" and "(9, 5)" in found(larger)[0].text


def test_places_that_differ_are_named_without_certainty():
    shadow = samples.picture().copy()
    shadow[40:52, 10:40] *= 0.6
    for a, b, name in (
        (samples.picture(), shadow, "a missing shadow, or light that should not be"),
        (shadow, samples.picture(), "a missing light, or a shadow that should not be"),
    ):
        (best,) = found(a, b)
        assert best.name == name and not best.proven
        assert "in 1 place, the largest 30 x 12 pixels at (10, 40), 5.2 % in all" in best.text


def test_nan_is_told_and_never_passes():
    broken = samples.picture().copy()
    broken[3, 4, 1] = np.nan
    result = pictures.compare_pictures(broken, samples.picture())
    assert result.notes == ("1 pixels of the picture are NaN or infinite; they count as 0",)
    assert not result.passed


def test_what_is_not_finite_is_the_cause_and_no_other():
    broken = samples.picture().copy()
    broken[40:52, 10:40] = np.nan
    (alone,) = found(broken)
    assert alone.name == "not finite" and alone.proven and "elsewhere they agree" in alone.text
    broken[0:20, 50:80] *= 0.6
    (other,) = found(broken)
    assert other.name == "a missing light, or a shadow that should not be"
    assert "in 1 place, the largest 30 x 20 pixels at (50, 0)" in other.text


def test_edges_can_be_left_out():
    picture = samples.picture()
    other = clrt.render(samples.with_camera(shift=(0.04, 0.02))).pixels
    plain, masked = (pictures.compare_pictures(other, picture, masked=m) for m in (False, True))
    assert masked.metrics["largest difference"] < plain.metrics["largest difference"]
    assert 0.1 < masked.metrics["edges left out"] < 0.6 and plain.metrics["edges left out"] == 0
    exact = pictures.compare_pictures(other, picture, True, reference())
    assert 0.05 < exact.metrics["edges left out"] < masked.metrics["edges left out"]
    assert {gate.name: gate.passed for gate in exact.gates}["pixels that differ"] is False


# --- causes in the scene


RENDERED: dict[str, np.ndarray] = {}  # the same changes of the scene are tried again and again


class Reference(SceneReference):
    """The scene as the reference; each change of it is rendered once for all tests."""

    def render(self, scene: clrt.Scene | None = None, shadows: bool = True) -> np.ndarray:
        key = f"{(scene or self.scene).to_dict()} {shadows}"
        if key not in RENDERED:
            RENDERED[key] = super().render(scene, shadows)
        return RENDERED[key]


def reference() -> Any:
    return Reference(samples.scene(), samples.WIDTH, samples.HEIGHT)


def in_scene(picture: np.ndarray) -> list[Any]:
    return list(pictures.compare_pictures(picture, samples.picture(), scene=reference()).causes)


def one_light_without_shadow() -> np.ndarray:
    scene = samples.scene()
    alone = replace(scene, lights=scene.lights[1:])
    more = samples.ours(alone, shadows=False).pixels - samples.ours(alone).pixels
    return samples.picture() + more


IN_SCENE: dict[str, Callable[[], np.ndarray]] = {
    "light 1 of 2 (point at 3, 5, 4) missing": lambda: render(samples.with_lights(0, 1)),
    "light 2 of 2 (direction 1, -1.5, -1) missing": lambda: render(samples.with_lights(1, 0)),
    "light 1 of 2 (point at 3, 5, 4) times 0.5": lambda: render(samples.with_lights(0.5, 1)),
    "light 1 of 2 (point at 3, 5, 4) times 0.5 and light 2 of 2 (direction 1, -1.5, -1) times 1.2":
        lambda: render(samples.with_lights(0.5, 1.2)),
    "shadows missing": lambda: samples.ours(shadows=False).pixels,
    "shadow of light 2 missing": one_light_without_shadow,
    "ambient light missing": lambda: render(replace(samples.scene(), ambient=0.0)),
    "background missing": lambda: render(replace(samples.scene(), background=0.0)),
    "highlights missing": lambda: render(dull()),
    "max_depth 1": lambda: render(replace(samples.scene(), max_depth=1)),
    "max_depth 2": lambda: render(replace(samples.scene(), max_depth=2)),
    "fov axis": lambda: render(samples.with_camera(fov_axis="vertical")),
    "16 samples a pixel": lambda: clrt.render(samples.scene(), spp=16).pixels,
    "ior inverted": lambda: render(samples.with_material(2, ior=1 / 1.5)),
    "reflections missing": lambda: render(unreflecting()),
    "shape 3 (box) missing": lambda: render(samples.without_shape(3)),
    "vertical flip and light 2 of 2 (direction 1, -1.5, -1) missing":
        lambda: render(samples.with_lights(1, 0))[::-1],
}  # fmt: skip


def render(scene: clrt.Scene) -> np.ndarray:
    return clrt.render(scene).pixels


def dull() -> clrt.Scene:
    scene = samples.with_material(1, specular=0.0)
    shapes = list(scene.shapes)
    shapes[2] = replace(shapes[2], material=replace(scene.material_of(shapes[2]), specular=0.0))
    return replace(scene, shapes=tuple(shapes))


def unreflecting() -> clrt.Scene:
    scene = samples.with_material(1, reflection=0.0)
    shapes = list(scene.shapes)
    shapes[2] = replace(shapes[2], material=replace(scene.material_of(shapes[2]), reflection=0.0))
    return replace(scene, shapes=tuple(shapes))


@pytest.mark.parametrize("name", IN_SCENE)
def test_what_is_wrong_with_the_scene_is_found(name: str):
    best = in_scene(stored(IN_SCENE[name]()))[0]
    assert best.name == name and best.proven, best


def test_a_black_picture_has_no_strong_highlights():
    """Without lights there are none: a factor of them is of what rounding left."""
    bright = edited(samples.scene(), {"lights[0].intensity": 30.0, "lights[1].intensity": 20.0})
    lit, black = clrt.render(bright).pixels, np.zeros((samples.HEIGHT, samples.WIDTH, 3), np.float32)
    scene = Reference(bright, samples.WIDTH, samples.HEIGHT)
    best = pictures.compare_pictures(black, lit, scene=scene).causes[0]
    assert best.name == "all lights missing and ambient light missing and background missing" and best.proven


def test_causes_are_compared_by_what_they_say():
    first, second = (in_scene(stored(samples.picture()[::-1]))[0] for _ in range(2))
    assert first == second and len({first, second}) == 1 and first.undone is not None


ODD: dict[str, dict[str, Any]] = {
    "K": {"camera.K": [[130, 0, 50], [0, 130, 36], [0, 0, 1]]},
    "pose": {"camera.pose": [[1, 0, 0, 0.2], [0, -1, 0, 1.5], [0, 0, -1, 6], [0, 0, 0, 1]]},
    "adaptive": {"adaptive": {"spp": 4}},
    "adaptive of 9": {"camera.spp": 9, "adaptive": {"spp": 36}},
    "highest ior": {"shapes[2].material.ior": 1e6, "shapes[2].material.shininess": 1e6},
}  # fmt: skip


@pytest.mark.parametrize("name", ODD)
def test_whatever_a_scene_states_has_a_verdict(name: str):
    """What cannot be changed in it, or not so, is no cause; the right one is found."""
    scene = samples.scene().replace(ODD[name])
    small = SceneReference(scene, 32, 24)
    wrong = clrt.render(scene.replace({"max_depth": 0, "shapes[3].material.color": 0.5}), 32, 24).pixels
    tried: list[str] = []
    result = pictures.compare_pictures(wrong, small.render(), scene=small, report=tried.append)
    assert result.verdict in ("similar", "different", "same picture") and "shape 3 (box) missing" in tried
    first = clrt.render(scene.replace({"lights": scene.lights[1:]}), 32, 24).pixels
    (best, *_) = pictures.compare_pictures(first, small.render(), scene=small).causes
    assert best.name == "light 1 of 2 (point at 3, 5, 4) missing" and best.proven


def test_angles_and_samples_are_causes_of_any_camera():
    scene = samples.scene().replace({**ODD["K"], **ODD["adaptive of 9"]})
    camera = scene.camera
    assert camera is not None
    shift = camera.offset(camera.width, camera.height)
    halved = scene.replace({"camera.fov": camera.fov / 2, "camera.shift": shift})
    few = scene.replace({"camera.spp": 1, "adaptive": None})
    whole = SceneReference(scene, samples.WIDTH, samples.HEIGHT)
    for name, picture in (("fov halved", render(halved)), ("1 samples a pixel", render(few))):
        best = pictures.compare_pictures(picture, whole.render(), scene=whole).causes[0]
        assert best.name == name and best.proven, best


def test_what_is_tried_is_reported_and_stops_at_the_proof():
    tried: list[str] = []
    pictures.compare_pictures(
        IN_SCENE["ambient light missing"](), samples.picture(), scene=reference(), report=tried.append
    )
    assert tried[0].startswith("light 1 of 2") and tried[-1] == "ambient light"


# --- how a picture was stored, and what a search may cost


def as_jpeg(pixels: np.ndarray, quality: int, subsampling: int) -> np.ndarray:
    file = io.BytesIO()
    Image.fromarray(encode(pixels)).save(file, "JPEG", quality=quality, subsampling=subsampling)
    return decode(np.asarray(Image.open(file)))


@pytest.mark.parametrize(("quality", "subsampling"), [(92, 0), (75, 2), (33, 2)])
def test_a_jpeg_is_told_with_its_quality_and_no_scene_is_searched(quality: int, subsampling: int):
    tried: list[str] = []
    result = pictures.compare_pictures(
        as_jpeg(samples.picture(), quality, subsampling), samples.picture(), scene=reference(),
        report=tried.append,
    )  # fmt: skip
    (best, *_) = result.causes
    assert best.name == "JPEG compression" and best.proven and f"quality {quality} " in best.text
    assert tried == []


def test_what_is_no_jpeg_is_not_called_one():
    rng = np.random.default_rng(3)
    noisy = np.clip(samples.picture() + rng.normal(0, 0.03, samples.picture().shape), 0, 1).astype(np.float32)
    assert "JPEG compression" not in [cause.name for cause in found(stored(noisy))]


@pytest.mark.parametrize("value", [0.0, 0.5, 1.0])
def test_a_curve_to_one_value_is_none(value: float) -> None:
    """It undoes every difference from a picture of one colour, such as a scene that came out black."""
    right = samples.picture()
    for faint in (0, 1e-6 * np.random.default_rng(1).random(right.shape)):
        flat = (np.full_like(right, value) + faint).astype(np.float32)
        assert "another tone curve" not in [cause.name for cause in found(right, flat)]


def test_what_is_black_in_one_place_is_no_curve() -> None:
    """Shadows that are black in place of ambient light, and a hole: all other values are right."""
    look = {"material": {"color": [0.7, 0.6, 0.5]}}
    image = clrt.render({
        "camera": {"origin": [0.5, 2, 6], "target": [0, 0.6, 0], "width": 160, "height": 120, "fov": 50},
        "background": [0.4, 0.5, 0.7], "ambient": 0.1,
        "lights": [{"type": "directional", "direction": [-1, -2, -1], "intensity": 0.6}],
        "shapes": [{"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], **look},
                   {"type": "sphere", "center": [0, 0.8, 0], "radius": 0.8, **look}],
    }, layers=["diffuse", "shape"])  # fmt: skip
    shaded = (image.layers["shape"] >= 0) & (image.layers["diffuse"].max(axis=2) == 0)
    hole = np.zeros_like(shaded)
    hole[60:63, 78:82] = True
    assert 0.01 < shaded.mean() < 0.3 and not (shaded & hole).any()
    for where in (shaded, hole):
        wrong = np.where(where[..., None], np.float32(0), image.pixels)
        assert all(cause.name != "another tone curve" for cause in found(wrong, image.pixels))


def test_a_tone_curve_of_its_own_is_told():
    right = stored(samples.picture())
    (best, *_) = found(stored(right / (1 + right)), right)
    assert best.name == "another tone curve" and best.proven
    middle = decode(np.uint8([128]))[0]
    shown = encode(np.full((1, 1, 3), middle / (1 + middle), np.float32))[0, 0, 0] / 255
    assert f"0.5 is {shown:.2f}" in best.text


def test_no_light_is_below_nothing():
    darker = samples.picture() * np.float32([0.4, 1.0, 0.7]) * (1 - samples.picture())
    causes = in_scene(stored(darker))
    assert not any("-" in name.split("times ")[-1] for cause in causes for name in cause.name.split(" and ")
                   if "times" in name)  # fmt: skip
    scene_causes = validation_module("compare.scene")
    part = np.full((50, 3), 0.2)
    cause = scene_causes._mixed(np.full((50, 3), 0.1), np.full((50, 3), 0.5), ["light"], [part], 0.1, 0.0)
    assert cause.name == "light missing" and cause.text == "there is nothing of light"


def test_the_search_ends_when_its_time_is_spent():
    tried: list[str] = []
    noise = np.random.default_rng(1).random(samples.picture().shape).astype(np.float32)
    result = pictures.compare_pictures(
        noise, samples.picture(), scene=reference(), report=tried.append, seconds=0.0
    )
    assert tried == [] and "the search for causes stopped after 0 s" in result.notes[-1]
    clock = iter([1.0, 2.0, 3.0])
    budget = causes.Budget(2.5, start=0.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(causes.time, "process_time", lambda: next(clock))
        assert [budget.over() for _ in range(3)] == [False, False, True]
    assert budget.over() and budget.stopped


@pytest.mark.filterwarnings("error")
def test_a_picture_of_nothing_makes_no_foreign_warnings() -> None:
    empty = np.zeros((16, 16, 3), np.float32)
    full = np.random.default_rng(1).random((16, 16, 3)).astype(np.float32)
    moves = validation_module("compare.moves")
    assert [*moves.moved(empty, full, 0.01), *moves.moved(full, empty, 0.01)] == []


def test_places_of_another_colour_are_places() -> None:
    """What was redder and as much less blue counted as agreeing: a smaller place was named."""
    right = np.full((60, 80, 3), 0.3)
    wrong = right.copy()
    shown = metrics.encoded(0.3)
    wrong[5:35, 10:50] = metrics.decoded(np.array([shown + 0.1, shown, shown - 0.1]))
    wrong[50:54, 60:64] -= 0.1
    (place,) = [cause for cause in found(wrong, right) if "place" in cause.text]
    assert "40 x 30 pixels at (10, 5)" in place.text and place.left < 0.01


def test_of_proven_causes_those_that_only_move_pixels_come_first() -> None:
    """A shift by half pixels blurs, and so hides the edges' noise: it stood before a flip."""
    flip = causes.Cause("vertical flip", "", 0.011)
    shift = causes.Cause("shift by 12.5 pixels up", "", 0.0045, blurs=True)
    assert [cause.name for cause in causes.ranked([shift, flip])] == [flip.name, shift.name]
    likely = causes.Cause("vertical flip", "", 0.3)
    assert causes.ranked([likely, shift])[0] == shift


def test_a_part_with_the_picture_s_own_proportions_is_one() -> None:
    """The scene is rendered in the size of such a part, where nothing of it is left to be cut."""
    ball = {"type": "sphere", "center": [0.3, 0, 0], "radius": 1, "material": {"color": [0.8, 0.3, 0.2]}}
    floor = {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]}
    scene = clrt.load_dict({
        "camera": {"origin": [0, 1, 5], "target": [0, 0, 0], "width": 96, "height": 72}, "ambient": 0.1,
        "lights": [{"type": "point", "position": [2, 4, 3]}], "shapes": [ball, floor],
    })  # fmt: skip
    part = clrt.compare(clrt.render(scene, crop=(20, 10, 64, 48)), scene)
    assert [(cause.name, cause.proven) for cause in part.causes] == [("cropped", True)]
    assert "from pixel (20, 10) on" in part.causes[0].text
    turned = clrt.render(scene, width=64, height=48).pixels[::-1].copy()
    assert clrt.compare(turned, scene).causes[0].name == "vertical flip"


def test_what_a_scene_has_not_is_not_missing() -> None:
    """Of a reference that renders another scene, all that differs looked like each part that is not there."""
    scene = replace(dull(), ambient=0.0, background=0.0)
    right = render(scene)
    wrong = right + np.linspace(0.1, 0.3, right.size, dtype=np.float32).reshape(right.shape)
    of = Reference(scene, samples.WIDTH, samples.HEIGHT)
    names = [cause.name for cause in pictures.compare_pictures(right, wrong, scene=of).causes]
    absent = ("ambient", "background", "highlights", "emission")
    assert not any(word in name for word in absent for name in names), names
