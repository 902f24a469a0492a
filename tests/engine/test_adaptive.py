"""Adaptive sampling: pixels have the bits of even pictures of their samples, and get what the model says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.cluster import pictures, worker
from clrt.engine.adaptive import around
from tests.cluster.test_farm import Here, done

WIDTH, HEIGHT = 40, 28
CAMERA = {"origin": [0, 0.6, 4], "target": [0, 0, 0], "width": WIDTH, "height": HEIGHT, "spp": 4, "jitter": 2}
SCENE: dict[str, Any] = {
    "background": [0.1, 0.2, 0.3], "max_depth": 2, "camera": CAMERA,
    "lights": [{"type": "rectangle", "center": [3, 4, 5], "u": [0.5, 0, 0], "v": [0, 0, 0.5], "samples": 2,
                "radiance": 60.0}],
    "shapes": [
        {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {"diffuse": 0.5, "reflection": 0.4}},
        {"type": "box", "min": [-2, -1, -1], "max": [-1.2, 0, 0.5]},
        {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0],
         "material": {"color": {"type": "checker", "colors": [0.3, 0.6], "size": 0.7}}},
    ],
}  # fmt: skip
THRESHOLD = 0.004
LAYERS = ("samples", "direct", "depth", "shape", "normal")


@pytest.fixture(scope="module")
def scene() -> clrt.Scene:
    return clrt.load_dict({**SCENE, "adaptive": {"spp": 64, "threshold": THRESHOLD}})


@pytest.fixture(scope="module")
def tracer(scene: clrt.Scene) -> clrt.Tracer:
    return clrt.Tracer(scene)


@pytest.fixture(scope="module")
def image(tracer: clrt.Tracer) -> clrt.Image:
    return tracer.render(layers=LAYERS)


@pytest.fixture(scope="module")
def even() -> dict[int, clrt.Image]:
    plain = clrt.Tracer(SCENE)
    return {spp: plain.render(spp=spp, layers=LAYERS) for spp in (4, 16, 64)}


def test_each_pixel_has_the_bits_of_the_even_picture_of_its_samples(
    image: clrt.Image, even: dict[int, clrt.Image]
) -> None:
    count = image.layers["samples"]
    assert set(np.unique(count)) == {4, 16, 64}
    for spp, whole in even.items():
        here = count == spp
        assert np.array_equal(image.pixels[here], whole.pixels[here])
        for name in LAYERS:
            assert np.array_equal(image.layers[name][here], whole.layers[name][here]), name
        assert (whole.layers["samples"] == spp).all()


def test_pixels_get_what_the_model_says(image: clrt.Image, even: dict[int, clrt.Image]) -> None:
    """docs/model.md once more, pixel by pixel."""
    root = {spp: np.sqrt(np.clip(whole.pixels, 0, 1)) for spp, whole in even.items()}
    shape, normal = even[4].layers["shape"], even[4].layers["normal"]
    expected = np.full((HEIGHT, WIDTH), 4)
    for y in range(HEIGHT):
        for x in range(WIDTH):
            for j, i in ((y, x - 1), (y, x + 1), (y - 1, x), (y + 1, x)):
                if 0 <= j < HEIGHT and 0 <= i < WIDTH:
                    colour = ((root[4][y, x] - root[4][j, i]) ** 2 > np.float32(THRESHOLD)).any()
                    bent = min(shape[y, x], shape[j, i]) >= 0 and normal[y, x] @ normal[j, i] < 0.9
                    if colour or bent or shape[y, x] != shape[j, i]:
                        expected[y, x] = 16
            if expected[y, x] == 16 and ((root[16][y, x] - root[4][y, x]) ** 2 > np.float32(THRESHOLD)).any():
                expected[y, x] = 64
    assert np.array_equal(image.layers["samples"], expected)


def test_parts_and_tiles_have_the_bits_of_the_whole(scene: clrt.Scene, image: clrt.Image) -> None:
    """Neighbours beyond the edge of a part count, too; what they cost is not told, so counts are the same."""
    small = clrt.Tracer(scene, settings=clrt.Settings(tile=150, lanes=8))
    again = small.render(layers=LAYERS)
    assert again.hash == image.hash and again.stats["rays"] == image.stats["rays"]
    assert all(np.array_equal(again.layers[name], image.layers[name]) for name in LAYERS)
    parts = [small.render(crop=(x, 3, 7, 20), layers=("samples",)) for x in (0, 7, 14)]
    assert np.array_equal(np.concatenate([p.pixels for p in parts], axis=1), image.pixels[3:23, :21])
    counts = np.concatenate([p.layers["samples"] for p in parts], axis=1)
    assert np.array_equal(counts, image.layers["samples"][3:23, :21])


def test_counts_are_those_of_all_grids(image: clrt.Image) -> None:
    count = image.layers["samples"]
    grids = 4 * count.size + 16 * (count >= 16).sum() + 64 * (count >= 64).sum()
    assert image.stats["rays"]["camera"] == grids


def test_workers_give_the_same_bits(
    scene: clrt.Scene, image: clrt.Image, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(worker, "check", lambda device: None)
    monkeypatch.setattr(pictures, "_LEAST", 100)
    found, report = done(Here(), scene, layers=LAYERS)
    assert report.answers > 3 and found.hash == image.hash
    assert np.array_equal(found.layers["samples"], image.layers["samples"])
    assert found.stats["rays"] == image.stats["rays"]


def test_a_render_that_was_broken_off_goes_on(scene: clrt.Scene, image: clrt.Image, tmp_path: Path) -> None:
    path, small = tmp_path / "half.npz", clrt.Tracer(scene, settings=clrt.Settings(tile=200))

    def stop(done: int, total: int, rays: int) -> None:
        if done > total / 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        small.render(checkpoint=path, progress=stop, layers=("samples",))
    other = scene.replace({"adaptive.threshold": 0.1})
    with pytest.raises(clrt.ClrtError, match=r"adaptive was up to 8 a side, 0\.004, is up to 8 a side, 0\.1"):
        clrt.Tracer(other).render(checkpoint=path, layers=("samples",))
    again = small.render(checkpoint=path, layers=("samples",))
    assert again.hash == image.hash and again.stats["rays"] == image.stats["rays"]


def test_a_pixel_is_explained_by_its_last_grid(tracer: clrt.Tracer, image: clrt.Image) -> None:
    count = image.layers["samples"]
    for spp in (4, 16):
        y, x = np.argwhere(count == spp)[5].tolist()
        tree = tracer.explain(x, y)
        assert tree.samples == spp and np.array_equal(tree.total, image.pixels[y, x])


def test_threshold_0_refines_what_differs_at_all_and_1_only_outlines(scene: clrt.Scene) -> None:
    most = clrt.render(scene.replace({"adaptive.threshold": 0}), layers=("samples",)).layers["samples"]
    least = clrt.render(scene.replace({"adaptive.threshold": 1}), layers=("samples",)).layers["samples"]
    assert (most == 64).mean() > 0.5 and set(np.unique(least)) == {4, 16}


def test_a_filter_goes_with_it(scene: clrt.Scene) -> None:
    soft = scene.replace({"camera.filter": "gaussian"})
    image = clrt.render(soft, layers=("samples",))
    for spp in (4, 16, 64):
        whole = clrt.render(soft.replace({"adaptive": None}), spp=spp)
        here = image.layers["samples"] == spp
        assert here.any() and np.array_equal(image.pixels[here], whole.pixels[here])


def test_neighbours_are_those_within_the_picture() -> None:
    assert around(np.array([0, 1], np.uint32), 4, 3).tolist() == [2, 4, 5]
    assert around(np.array([11], np.uint32), 4, 3).tolist() == [7, 10]
    assert around(np.arange(12, dtype=np.uint32), 4, 3).tolist() == []


@pytest.mark.parametrize(("changes", "says"), [
    ({"spp": 32}, "adaptive.spp: 32 .* camera.spp = 4 .* 16 or 64"),
    ({"spp": 1}, "adaptive.spp: 1 .* 4 or 16"),
    ({"spp": 2.5}, "adaptive.spp: 2.5 .* a power of 4"),
    ({"threshold": -0.1}, "adaptive.threshold: -0.1 .* 0 to 1"),
    ({"threshold": float("nan")}, "adaptive.threshold: nan"),
    ({"threshold": 2}, "adaptive.threshold: 2 .* 0 to 1"),
    ({"treshold": 0.1}, "adaptive: .*'threshold'"),
])  # fmt: skip
def test_what_cannot_be(changes: dict[str, Any], says: str) -> None:
    with pytest.raises(clrt.SceneError, match=says):
        clrt.load_dict({**SCENE, "adaptive": changes})


def test_samples_are_looked_at_again_where_a_picture_is_asked_for(tracer: clrt.Tracer) -> None:
    with pytest.raises(clrt.SceneError, match=r"adaptive.spp: 64 .* camera.spp = 9 .* 36 or 144"):
        tracer.render(spp=9)
    assert tracer.render(spp=64).hash == clrt.render(SCENE, spp=64).hash
    with pytest.raises(clrt.LimitError, match="samples: 64"):
        clrt.render(tracer.scene, settings=clrt.Settings(limits=clrt.Limits(samples=16)))
    with pytest.raises(clrt.SceneError, match="conformance counts the rays"):
        clrt.load_dict({**SCENE, "conformance": "spd", "adaptive": {}})
