"""The comparison with oracles: its figures, its gates (each must fail when it should) and whom it blames."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

import clrt
import compare_samples as samples
from clrt.base.resources import validation_module
from clrt.images.file import encode
from compare_samples import EDGES, GREY, failed, oracle

compare = validation_module("compare.oracle")
metrics = validation_module("compare.metrics")
ours = validation_module("ours")
RANDOM = np.random.default_rng(7)
NOISE = RANDOM.normal(0, 2e-6, (samples.HEIGHT, samples.WIDTH, 3))


# --- figures


def test_the_curve_is_that_of_saved_pictures_and_its_inverse():
    values = np.linspace(0, 1, 1000).reshape(10, -1, 1)
    assert np.array_equal(np.floor(255 * metrics.encoded(values) + 0.5), encode(values.astype(np.float64)))
    assert np.allclose(metrics.decoded(metrics.encoded(values)), values, atol=1e-12)
    assert metrics.encoded(np.array([-1.0, 7.0])) == pytest.approx([0, 1], abs=1e-12)


def test_ssim_is_scikit_image_s_with_gaussian_windows():
    from skimage.metrics import structural_similarity

    a, b = RANDOM.random((20, 30, 3)), RANDOM.random((20, 30, 3))
    value, windows = metrics.ssim(a, b)
    expected = structural_similarity(
        a, b, data_range=1, channel_axis=-1, gaussian_weights=True, sigma=1.5, use_sample_covariance=False
    )
    assert value == pytest.approx(expected, abs=1e-12) and windows.shape == a.shape
    assert metrics.ssim(a, a)[0] == 1


def test_ssim_of_a_picture_smaller_than_a_window():
    a = RANDOM.random((4, 30, 3))
    value, windows = metrics.ssim(a, 1 - a)
    assert value < 0.5 and windows.shape == a.shape and metrics.ssim(a, a)[0] == 1


def test_flip_sees_a_spot_where_it_is():
    a = np.full((24, 40, 3), 0.5)
    b = a.copy()
    b[5, 31] = 1
    mean, places = metrics.flip(a, b)
    assert places.shape == (24, 40) and np.unravel_index(places.argmax(), places.shape) == (5, 31)
    assert mean == pytest.approx(places.mean(), rel=1e-5) and metrics.flip(a, a)[0] == 0


def test_without_flip_the_other_gates_decide(monkeypatch: pytest.MonkeyPatch):
    with_it = compare.compare(samples.ours(), samples.ours(), limit=LOOSE)
    monkeypatch.setitem(sys.modules, "flip_evaluator", None)
    without = compare.compare(samples.ours(), samples.ours(), limit=LOOSE)
    assert [gate for gate in with_it.gates if gate.name != "FLIP"] == list(without.gates)
    assert set(with_it.maps) - set(without.maps) == {"flip"} and "FLIP" not in without.metrics
    assert without.passed and not np.isnan(list(without.metrics.values())).any()
    suite = validation_module("suite.run")
    (said,) = [note for note in suite.notes(suite.Plan(), []) if "FLIP" in note]
    assert said.startswith("FLIP was not run") and "pip install flip-evaluator" in said
    monkeypatch.undo()
    assert not [note for note in suite.notes(suite.Plan(), []) if "FLIP" in note]


def test_psnr_of_a_known_error():
    a = np.full((8, 8, 3), 0.5)
    assert metrics.psnr(a, a + 0.1) == pytest.approx(20)
    assert metrics.psnr(a, a) == np.inf


def test_edge_masks():
    a = np.zeros((6, 8, 3))
    moved = a.copy()
    moved[2, 3, 1] = 0.0021
    moved[4, 4, 0] = 0.0019
    assert np.argwhere(metrics.edge_mask(a, [a, moved])).tolist() == [[2, 3]]
    assert not metrics.edge_mask(a, []).any()
    a[:, 4:] = 0.05
    assert np.flatnonzero(metrics.steep(a)[0]).tolist() == [3, 4]
    assert np.argwhere(metrics.steep(a.swapaxes(0, 1)).any(axis=1)).ravel().tolist() == [3, 4]


# --- our picture


@pytest.mark.parametrize("spp", [1, 4])
def test_our_picture_is_the_renderer_s_and_the_sum_of_its_rays(spp: int):
    scene = samples.scene()
    image = clrt.render(scene, spp=spp, layers=("depth", "shape", "highlight", "generation_2"))
    mine = samples.ours(scene, spp=spp)
    assert np.array_equal(mine.pixels, image.pixels)
    assert np.array_equal(mine.t, image.layers["depth"]) and np.array_equal(mine.shape, image.layers["shape"])
    assert np.array_equal(mine.by_ray["generation 0 camera highlight"], image.layers["highlight"])
    kinds = {key: values for key, values in mine.by_ray.items() if len(key.split()) == 3}
    assert np.allclose(sum(kinds.values()), image.pixels, atol=1e-6)
    second = sum(values for key, values in kinds.items() if key.startswith("generation 2 "))
    assert np.allclose(second, image.layers["generation_2"], atol=1e-6) and second.max() > 0.01
    assert {"generation 0 camera", "generation 1 reflection", "generation 5 transmission"} <= set(kinds)


def test_our_picture_does_not_depend_on_how_it_is_cut(monkeypatch: pytest.MonkeyPatch):
    whole = samples.ours()
    monkeypatch.setattr(ours, "_TILE", 500)
    cut = samples.ours()
    monkeypatch.setattr(ours, "_TILE", 1 << 15)
    monkeypatch.setattr(ours, "_BUDGET", 1 << 19)  # too little for all: tiles are halved
    halved = samples.ours()
    for other in (cut, halved):
        assert np.array_equal(other.pixels, whole.pixels) and set(other.by_ray) == set(whole.by_ray)
        assert all(np.array_equal(other.by_ray[key], whole.by_ray[key]) for key in whole.by_ray)


def test_without_shadows_more_light_arrives_and_never_less():
    lit, free = samples.picture(), samples.ours(shadows=False).pixels
    assert (free >= lit).all() and 0.02 < np.mean((free > lit + 0.01).any(axis=-1)) < 0.5


# --- gates

MUTANTS: dict[str, tuple[Callable[[], clrt.Scene], str]] = {
    "exponent 36 for 40": (lambda: samples.with_material(1, shininess=36), "generation 0, camera, highlight"),
    "kd 0.89 for 0.90": (
        lambda: samples.with_material(0, diffuse=0.89, ambient=0.9), "generation 0, camera, diffuse"
    ),
    "ambient 10 % low": (lambda: replace(samples.scene(), ambient=0.09), "generation 0, camera, ambient"),
    "kr 1 % low": (lambda: samples.with_material(1, reflection=0.198), "generation 1, reflection"),
    "kt 1 % low": (lambda: samples.with_material(2, transmission=0.792), "generation 1, transmission"),
    "index 1.501 for 1.5": (lambda: samples.with_material(2, ior=1.501), "generation 2, transmission"),
    "depth 4 for 5": (lambda: replace(samples.scene(), max_depth=4), "generation 5"),
    "background 1 % low": (
        lambda: replace(samples.scene(), background=(0.198, 0.297, 0.495)), "generation 0, camera"
    ),
    "light 2 lost": (lambda: samples.with_lights(1, 0), "generation 0, camera, diffuse"),
    "light 1 % low": (lambda: samples.with_lights(0.99, 1), "generation 0, camera, diffuse"),
    "0.1 pixel shift": (lambda: samples.with_camera(shift=(0.1, 0)), "generation 0, camera, geometry"),
    "half a pixel shift": (lambda: samples.with_camera(shift=(0.5, 0.5)), "generation 0, camera, geometry"),
    "a lost shape": (lambda: samples.without_shape(3), "generation 0, camera, geometry"),
    "radius 0.1 % large": (lambda: radius(0.8008), "generation 0, camera, geometry"),
}  # fmt: skip


def radius(value: float) -> clrt.Scene:
    scene = samples.scene()
    shapes = list(scene.shapes)
    shapes[2] = replace(shapes[2], radius=value)
    return replace(scene, shapes=tuple(shapes))


@pytest.mark.parametrize("name", MUTANTS)
def test_a_mutant_fails_and_is_found(name: str):
    change, where = MUTANTS[name]
    result = compare.compare(samples.ours(change()), samples.ours(), samples.edges(), limit=LOOSE)
    assert not result.passed and result.worst.startswith(where), (result.worst, failed(result))


def test_lost_shadows_are_found():
    result = compare.compare(samples.ours(shadows=False), samples.ours(), samples.edges(), limit=LOOSE)
    assert not result.passed and result.worst == "generation 0, camera"


LOOSE = dataclasses.replace(compare.limits(many_edges=True), mask=None)


def test_the_right_picture_passes():
    right = samples.ours()
    noisy = dataclasses.replace(right, pixels=right.pixels + NOISE, t=right.t * (1 + 1e-6))
    many = dataclasses.replace(compare.limits(16), mask=None, clipped=None)
    for limit in (LOOSE, compare.exact(LOOSE), many):
        result = compare.compare(noisy, right, samples.edges(), limit=limit)
        assert result.passed and result.worst == "", failed(result)
    assert np.allclose(result.maps["difference"], NOISE, atol=1e-6)
    assert {name: array.shape for name, array in result.maps.items()} == {
        "difference": (72, 96, 3), "flip": (72, 96), "ssim": (72, 96), "mask": (72, 96)}  # fmt: skip


def test_ssim_alone_would_have_let_a_wrong_exponent_pass():
    wrong = samples.ours(MUTANTS["exponent 36 for 40"][0]())
    result = compare.compare(wrong, samples.ours(), samples.edges(), limit=LOOSE)
    assert result.metrics["SSIM"] > 0.9995 and "SSIM" not in failed(result) and not result.passed


def spoilt(change: Callable[[np.ndarray], None], base: np.ndarray = GREY) -> Any:
    pixels = base.copy()
    change(pixels)
    return oracle(pixels)


def put(where: Any, value: float) -> Callable[[np.ndarray], None]:
    return lambda pixels: pixels.__setitem__(where, value)


TEXTURE = np.clip(0.5 + 0.2 * RANDOM.standard_normal((40, 50, 3)), 0.05, 0.95)
# a picture, its reference, and the gate that must fail; the others are None where they would fail, too
SPOILT: dict[str, tuple[Any, Any, str]] = {
    "SSIM": (oracle(TEXTURE[::-1]), oracle(TEXTURE), "SSIM"),
    "FLIP": (oracle(GREY * 1.1), oracle(GREY), "FLIP"),
    "PSNR": (oracle(GREY * 1.1), oracle(GREY), "PSNR"),
    "fine": (spoilt(put(np.s_[5, 10:13], 0.4002)), oracle(GREY), "within 1e-4"),
    "coarse": (spoilt(put(np.s_[5, 10:12], 0.402)), oracle(GREY), "within 1e-3"),
    "edges far off": (spoilt(put(np.s_[5:7, 0], 0.45)), oracle(GREY), "edges far off"),
    "mean": (oracle(GREY * 1.0002), oracle(GREY), "mean radiance"),
    "mean of one channel": (oracle(GREY * [1, 1.0002, 1]), oracle(GREY), "mean radiance"),
    "NaN": (spoilt(put(np.s_[5, 10, 1], np.nan)), oracle(GREY), "not finite"),
    "infinity": (spoilt(put(np.s_[5, 0, 1], np.inf)), oracle(GREY), "not finite"),
    "NaN in the reference": (oracle(GREY), spoilt(put(np.s_[5, 10, 1], np.nan)), "not finite"),
    "clipped": (oracle(GREY + 0.7), oracle(GREY + 0.7), "clipped"),
    "black": (oracle(GREY * 0), oracle(GREY * 0), "lit"),
}


@pytest.mark.parametrize("name", SPOILT)
def test_each_gate_fails_when_it_should(name: str):
    mine, reference, gate = SPOILT[name]
    result = compare.compare(mine, reference, EDGES)
    assert gate in failed(result) and result.worst
    if name != "clipped":  # the picture itself is no worse than the reference, so all others may pass
        good = compare.compare(oracle(GREY), oracle(GREY), EDGES)
        assert gate not in failed(good)


def test_a_share_of_a_small_picture_is_a_whole_pixel():
    one, two = (spoilt(put(np.s_[5, 10 : 10 + n], 0.402)) for n in (1, 2))
    assert "within 1e-3" not in failed(compare.compare(one, oracle(GREY), EDGES))
    assert "within 1e-3" in failed(compare.compare(two, oracle(GREY), EDGES))


def test_edges_do_not_count_as_other_pixels():
    mine = spoilt(put(np.s_[5:7, 0], 0.404))
    assert failed(compare.compare(mine, oracle(GREY))) >= {"within 1e-3"}
    assert compare.compare(mine, oracle(GREY), EDGES).passed


def test_a_mask_may_not_hide_the_picture():
    mask = np.zeros((40, 50), bool)
    mask[:, :5] = True
    assert failed(compare.compare(oracle(GREY), oracle(GREY), mask)) == {"edges"}
    assert compare.compare(oracle(GREY), oracle(GREY), mask, limit=compare.limits(many_edges=True)).passed
    assert failed(compare.compare(oracle(GREY), oracle(GREY), np.ones((40, 50), bool))) == {"edges"}


def test_the_worst_window_counts_from_16_samples_on():
    mine = spoilt(lambda pixels: pixels.__setitem__(np.s_[20:22, 20:22], 0.5))
    assert "worst window" not in {gate.name for gate in compare.compare(mine, oracle(GREY)).gates}
    assert "worst window" in failed(compare.compare(mine, oracle(GREY), spp=16))


def test_shapes_and_distances():
    t, shape = np.full((40, 50), 2.0), np.zeros((40, 50), int)
    right = oracle(GREY, t=t, shape=shape)
    other = shape.copy()
    other[7, 9] = 1
    assert failed(compare.compare(oracle(GREY, t=t, shape=other), right)) == {"another shape"}
    far = t.copy()
    far[7, 9] *= 2
    assert failed(compare.compare(oracle(GREY, t=far, shape=other), right)) == {"another shape"}, "told once"
    far[7, 9] = 2.00004
    assert failed(compare.compare(oracle(GREY, t=far, shape=shape), right)) == {"distance"}
    for wrong in (np.inf, np.nan):
        far[7, 9] = wrong
        assert failed(compare.compare(oracle(GREY, t=far, shape=shape), right)) == {"distance"}
    far[:] = t
    far[7, 1], other[7, 9], other[7, 1] = 9, 0, 1  # on an edge
    assert compare.compare(oracle(GREY, t=far, shape=other), right, EDGES).passed
    assert compare.compare(oracle(GREY), right).passed, "what one of them does not know is not compared"
    missed = np.full((40, 50), np.inf)
    assert compare.compare(oracle(GREY, t=missed), oracle(GREY, t=missed)).passed


def test_far_distances_are_compared_by_their_inverse():
    """Of a plane near its horizon float32 knows 1 / t as well as anywhere, but not t."""
    t, shape = np.full((40, 50), 2.0), np.zeros((40, 50), int)
    t[7, 9] = 2000.0  # 10 times 100 medians: its distance may be off by 10 times as much
    for error, wrong in ((9e-5, set()), (1.1e-4, {"distance"})):
        other = t.copy()
        other[7, 9] *= 1 + error
        found = compare.compare(oracle(GREY, t=other, shape=shape), oracle(GREY, t=t, shape=shape))
        assert failed(found) == wrong


def test_another_size_is_a_failure_not_a_crash():
    result = compare.compare(oracle(GREY[:30]), oracle(GREY))
    assert failed(result) == {"size"} and result.gates[0].detail == "50 x 30 in place of 50 x 40"


def test_the_limits_are_those_of_the_documentation():
    figures = {
        spp: (limit.ssim, limit.psnr, limit.flip, limit.window)
        for spp in (1, 4, 9, 16, 25, 64, 100)
        for limit in [compare.limits(spp)]
    }
    one, sixteen, many = (0.998, 45, 0.002, None), (0.9995, 60, 0.002, 0.9), (0.9999, 65, 0.002, 0.9)
    assert figures == {1: one, 4: one, 9: one, 16: sixteen, 25: sixteen, 64: many, 100: many}
    limit = compare.limits()
    assert (limit.fine, limit.coarse, limit.mean) == (0.999, 0.9999, 1e-4)
    assert (limit.masked, limit.mask, limit.distance, limit.shape) == (0.01, 0.08, 1e-5, 0)
    assert (limit.clipped, limit.lit) == (0.01, 0.5)
    assert compare.limits(many_edges=True).mask == 0.3
    strict = dataclasses.asdict(compare.exact(compare.limits(64)))
    assert strict["ssim"] == 0.9999 and strict["psnr"] == 65, "never looser than what it starts from"


def test_a_gate_is_met_on_its_limit_and_never_by_nan():
    assert compare.gate("a", 0.5, 0.5, "low").passed and compare.gate("a", 0.5, 0.5, "high").passed
    assert not compare.gate("a", 0.51, 0.5, "low").passed and not compare.gate("a", 0.49, 0.5, "high").passed
    assert not any(compare.gate("a", float("nan"), 0.5, better).passed for better in ("low", "high"))


def test_a_noisy_oracle_is_asked_for_the_mean_only():
    noisy = oracle(GREY + RANDOM.normal(0, 0.05, GREY.shape))
    limit = dataclasses.replace(compare.statistical(compare.limits()), psnr=20)
    assert compare.compare(oracle(GREY), noisy, limit=limit).passed
    assert failed(compare.compare(oracle(GREY * 1.02), noisy, limit=limit)) == {"mean radiance"}
