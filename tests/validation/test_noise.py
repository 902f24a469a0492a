"""What float32 does to a scene's picture, and how far a case's limits follow from it."""

from __future__ import annotations

import dataclasses
from functools import partial
from typing import Any

import msgspec
import numpy as np
import pytest

import clrt
from clrt.base.resources import validation_module
from clrt.scene.scene import Scene

noise, limits = validation_module("noise"), validation_module("limits")
cases, oracles = validation_module("cases"), validation_module("oracles")
compare, worker = validation_module("compare.oracle"), validation_module("suite.worker")

ACNE = "shipped thesis_3_07_acne"
BRIGHTER = 1.0005  # so much that each of its pixels is off by more than 1e-4, and none by more than 1e-3


def test_neighbours_are_moved_apart_in_some_picture() -> None:
    """A camera and its target both moved up see the horizon where it was: that would hide its noise."""
    camera = {"origin": [3.7, 0.3, 4.1], "target": [0.7, 0.2, 0.9], "width": 8, "height": 6}
    scene = clrt.load_dict({"camera": camera, "shapes": []})

    def way(picture: int) -> np.ndarray:
        now = noise.moved(scene, picture).camera
        found = np.array([now.origin, now.target]) - [camera["origin"], camera["target"]]
        return np.sign(found).ravel()

    ways = np.array([way(picture) for picture in range(noise.PICTURES)])
    assert np.all(np.abs(ways) == 1)
    for one, other in ((0, 1), (1, 2), (3, 4), (4, 5), (0, 3), (1, 4), (2, 5)):
        assert set(ways[:, one] * ways[:, other]) == {-1, 1}


def test_of_many_pictures_each_moves_numbers_its_own_way() -> None:
    ball = {"type": "sphere", "center": [0.1, 0.2, 0.3], "radius": 0.7}
    scene = clrt.load_dict({"shapes": [ball] * 8})
    ways = {repr(noise.moved(scene, picture).to_dict()) for picture in range(noise.MANY)}
    assert len(ways) == noise.MANY > noise.PICTURES


def test_every_number_moves_by_one_step_of_float32() -> None:
    camera = {"origin": [0, 0.3, 4.1], "target": [0, 0, 0], "width": 8, "height": 6}
    ball = {"type": "sphere", "center": [3000.0, 0, 0], "radius": 0.7}
    scene = clrt.load_dict({"camera": camera, "shapes": [ball], "ambient": 0.5})
    for picture in (1, noise.PICTURES, noise.MANY - 1):
        one, other = noise.moved(scene, picture), noise.moved(scene, picture)
        assert one.to_dict() == other.to_dict() and one.camera.width == 8
        for was, now in ((3000.0, one.shapes[0].center[0]), (0.7, one.shapes[0].radius)):
            assert abs(now - was) == float(np.spacing(np.float32(was)))


@pytest.mark.parametrize("oracle", ["mitsuba-table", "oracle64", "povray"])
@pytest.mark.parametrize("name", ["random 1/0", "random 7/3 at 16 samples", "shipped rainbow", ACNE])
def test_scenes_that_ship_or_are_random_have_the_limits_of_tests(name: str, oracle: str) -> None:
    """But for the share of edges, which is the reference's alone, and pictures that may be dark or bright."""
    case = cases.case_named(name)
    mine, test = (limits.limits_of(dataclasses.replace(case, is_test=made), oracle) for made in (False, True))
    free = {"mask": 0.0, "clipped": None, "lit": None}
    if oracle == "oracle64" and case.spp == 1:  # of a test more is asked than of others
        assert (mine.ssim, test.ssim) == (0.999, 0.9995)
        free["ssim"] = 0.0
    assert dataclasses.replace(mine, **free) == dataclasses.replace(test, **free)


def silent(pixels: int) -> Any:
    """The noise of a scene that float32 does not move, as far as pictures of so many pixels tell."""
    found = {"mean": 0.0, "distance": 0.0, "flip": 0.0, "ssim": 1.0, "psnr": np.inf, "masked": 0.0}
    counted = dict.fromkeys(("fine", "coarse", "rays", "layers"), 1 - 1 / (noise.PICTURES * pixels))
    return limits.Noise(found | counted, dict.fromkeys(("masked", *counted), pixels))


def test_without_noise_no_limit_is_wider_by_more_than_a_few_pixels() -> None:
    before, pixels = compare.limits(1, many_edges=True), 10_000
    after = limits.widened(before, silent(pixels), 2)
    assert before.coarse - 3 / pixels < after.coarse < before.coarse
    assert dataclasses.replace(after, coarse=before.coarse) == before


@pytest.mark.parametrize(("name", "oracle", "times"), [
    (ACNE, "oracle64", 2), (ACNE, "mitsuba-table", 4), ("shipped rainbow", "oracle64", 4),
    ("shipped rainbow", "mitsuba-spectral", 8),
])  # fmt: skip
def test_an_oracle_in_float32_rounds_as_often_as_we(name: str, oracle: str, times: int) -> None:
    assert limits.times_of(cases.case_named(name), oracle) == times


def test_no_limit_becomes_narrower() -> None:
    loose = compare.Limits(0.1, 0.1, 0.9, 10, 0.9, 0.1, 0.1, 0.9, 0.5, 0.1, 0.5, 0.5, 0.1)
    assert limits.widened(loose, silent(100), 2) == loose


@pytest.mark.parametrize(("field", "value", "most"), [
    ("mean", 3e-4, 6e-4), ("distance", 1e-3, 2e-3), ("ssim", 0.99, 0.98),
    ("psnr", 50.0, 50 - 20 * np.log10(2)),
    ("masked", 0.04, 0.08 + 3 * np.sqrt(0.08 / 400)), ("fine", 0.98, 0.96 - 3 * np.sqrt(0.04 / 400)),
])  # fmt: skip
def test_noise_adds_up(field: str, value: float, most: float) -> None:
    """Of two: differences and shares twice, a mean of squares four times; counts by chance more."""
    pixels = {"masked": 400, "fine": 400}
    assert limits.allowed(field, limits.Noise({field: value}, pixels), 2) == pytest.approx(most)


def excused(name: str, made: bool = False) -> tuple[Any, Any, Scene]:
    """A small picture's excuses by its float64 reference, the case, and the scene."""
    case = dataclasses.replace(cases.case_named(name), width=64, height=48, is_test=made)
    scene = oracles.scene_of(case)
    return noise.Excuses(case, scene, oracles.picture64(scene)), case, scene


def judged(excuses: Any, case: Any, scene: Scene) -> Any:
    """What is said of the kernels' picture of a scene."""
    return judged_by_itself(excuses, case, oracles.our_picture(scene, worker.device_of(None)))


def judged_by_itself(excuses: Any, case: Any, ours: Any) -> Any:
    """What is said of a picture in place of the kernels'."""
    judging = partial(worker.judge, ours, excuses.reference, case, "oracle64", True)
    return excuses.judged(judging, "oracle64")


def test_noise_excuses_what_float32_cannot_do_better_and_no_fault() -> None:
    """3000 units from the origin. The fault is as small as the gates see: all light is 0.05 % brighter."""
    excuses, case, scene = excused(ACNE)
    assert judged(excuses, case, scene).passed
    lamps = [msgspec.structs.replace(lamp, intensity=[BRIGHTER * part for part in lamp.intensity])
             for lamp in scene.lights]  # fmt: skip
    assert lamps
    wrong = judged(excuses, case, msgspec.structs.replace(scene, lights=lamps))
    assert {"mean radiance", "within 1e-4"} <= {gate.name for gate in wrong.gates if not gate.passed}


def test_a_test_is_not_excused() -> None:
    excuses, case, scene = excused(ACNE, made=True)
    found = judged(excuses, case, scene)
    assert "distance" in {gate.name for gate in found.gates if not gate.passed}
    assert "noise" not in vars(excuses)  # not even measured


def test_who_passes_is_asked_for_no_excuse() -> None:
    excuses, case, _ = excused("random 1/0")
    found = judged_by_itself(excuses, case, excuses.reference)
    assert found.passed and not {"edges", "noise", "rare"} & vars(excuses).keys()


def test_what_one_picture_in_ten_shows_is_looked_for_where_three_explain_too_little() -> None:
    """A mesh seen at a grazing angle: rounding its corners moves one hit by up to 1e-5, mostly by less."""
    case = cases.case_named("random 1/78 at 16 samples")
    scene = oracles.scene_of(case)
    excuses = noise.Excuses(case, scene, oracles.picture64(scene))
    few, many = excuses.noise.figures["distance"], excuses.rare.figures["distance"]
    assert many > 2 * few

    def off(error: float) -> Any:
        """Whether a hit so far off, outside edges, is excused beside an oracle in float32."""
        shape, t = excuses.reference.shape, np.array(excuses.reference.t)
        assert shape is not None
        t[tuple(np.argwhere(~excuses.edges & (shape >= 0))[0])] *= 1 + error
        away = dataclasses.replace(excuses.reference, t=t)
        judging = partial(worker.judge, away, excuses.reference, case, "mitsuba-spectral", True)
        return excuses.judged(judging, "mitsuba-spectral").passed

    assert off(3 * many) and not off(9 * many)


def test_a_picture_of_another_size_has_no_excuse() -> None:
    excuses, case, _ = excused(ACNE)
    small = dataclasses.replace(excuses.reference, pixels=np.zeros((3, 4, 3)))
    found = judged_by_itself(excuses, case, small)
    assert [gate.name for gate in found.gates] == ["size"] and "edges" not in vars(excuses)


def of_stock(ours: Any, case: Any, lifted: bool) -> dict[str, float]:
    """Gates that fail beside the picture of Mitsuba's plugins, whose rays start farther from surfaces."""
    (oracle,) = (name for name in case.oracles if name.startswith("stock"))
    theirs = oracles.oracles().render(oracle, oracles.source_of(case))
    if lifted:
        theirs = dataclasses.replace(theirs, pixels=theirs.pixels - oracles.lifted64(case))
    excuses = noise.Excuses(case, oracles.scene_of(case), oracles.picture64(oracles.scene_of(case)))
    found = excuses.judged(partial(worker.judge, ours, theirs, case, oracle, True), oracle)
    failed = {gate.name: gate.value for gate in found.gates if not gate.passed}
    return failed | {"PSNR": found.metrics["PSNR"]}


def test_where_mitsubas_rays_start_explains_what_its_plugins_differ_by() -> None:
    """And nothing else: light 0.05 % brighter and rays that start three times as far off still fail."""
    case = cases.case_named("stock S5")
    scene = oracles.scene_of(case)
    ours = oracles.our_picture(scene, worker.device_of(None))
    assert "edges far off" in of_stock(ours, case, lifted=False)
    right = of_stock(ours, case, lifted=True)
    assert right.keys() == {"PSNR"} and right["PSNR"] > 80  # measured: 44.0 before, 104 after
    brighter = dataclasses.replace(ours, pixels=ours.pixels * BRIGHTER)
    assert "mean radiance" in of_stock(brighter, case, lifted=True)
    farther = oracles.lift(oracles.read(oracles.source_of(case)))
    off = oracles.picture64(scene, lambda point: 3 * farther(point))
    assert "edges far off" in of_stock(off, case, lifted=True)
