"""What a Tracer promises about limits, memory and arguments."""

from __future__ import annotations

import time

import numpy as np
import pytest

import clrt

SCENE = {
    "camera": {"origin": [0, 1, 4], "target": [0, 0, 0], "width": 40, "height": 30},
    "lights": [{"type": "point", "position": [3, 5, 4]}],
    "materials": {"glass": {"diffuse": 0.2, "reflection": 0.3, "transmission": 0.5}},
    "shapes": [
        {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "glass"},
        {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]},
    ],
}


def limited(**limits: int) -> clrt.Settings:
    return clrt.Settings(limits=clrt.Limits(**limits))


@pytest.mark.parametrize(
    ("limits", "render"),
    [
        ({"pixels": 1199}, {}),
        ({"samples": 3}, {"spp": 4}),
        ({"depth": 4}, {}),
        ({"work": 1200 * 2**5 * 101 // 100 - 1}, {}),  # rays, and a hundredth of one a test of the plane
        ({"device_bytes": 2_000}, {}),
    ],
)
def test_a_limit_stops_a_render_and_says_what_to_change(limits: dict, render: dict) -> None:
    scene = clrt.load_dict(SCENE)
    (name,) = limits
    advice = rf"{name}: .*limit of .*Settings\(limits=Limits\({name}="
    with pytest.raises(clrt.LimitError, match=advice) as caught:
        clrt.render(scene, settings=limited(**limits), **render)
    assert "\n" not in str(caught.value)
    enough = limits[name] * 1000 if name == "device_bytes" else limits[name] + 1
    clrt.render(scene, settings=limited(**{name: enough}))


def test_a_tile_that_needs_too_much_is_split_and_gives_the_same_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    tracer = clrt.Tracer(clrt.load_dict(SCENE))
    whole = tracer.render(max_depth=6)
    tiles: list[int] = []
    monkeypatch.setattr("clrt.engine.job.TILE_BYTES", 200_000)
    split = tracer.render(max_depth=6, progress=lambda done, total, rays: tiles.append(done))
    assert len(tiles) > 1
    assert split.hash == whole.hash
    assert split.stats["rays"] == whole.stats["rays"]
    monkeypatch.setattr("clrt.engine.job.TILE_BYTES", 100)
    with pytest.raises(clrt.LimitError, match="a single pixel needs more"):
        tracer.render()


@pytest.mark.parametrize("crop", [(0, 0, 0, 5), (-1, 0, 5, 5), (36, 0, 5, 5), (0, 0, 41, 30)])
def test_a_crop_outside_the_picture_is_refused(crop: tuple[int, int, int, int]) -> None:
    with pytest.raises(clrt.ClrtError, match=r"crop: .* is not a part of the picture of 40 x 30 pixels"):
        clrt.render(clrt.load_dict(SCENE), crop=crop)


def test_a_crop_that_is_a_huge_array_is_refused_at_once() -> None:
    tracer = clrt.Tracer(clrt.load_dict(SCENE))
    start = time.process_time()
    with pytest.raises(clrt.ClrtError, match=r"crop: .* it must be 4 whole numbers"):
        tracer.render(crop=np.broadcast_to(np.float32(1), (4, 1 << 22)))  # type: ignore[arg-type]
    assert time.process_time() - start < 0.5


def test_unknown_layers_are_refused_with_the_nearest_name() -> None:
    with pytest.raises(clrt.ClrtError, match="'reflections' is not a layer; did you mean 'reflection'"):
        clrt.render(clrt.load_dict(SCENE), layers=["reflections"])
    with pytest.raises(clrt.ClrtError, match="'generation_6' is not a layer"):
        clrt.render(clrt.load_dict(SCENE), layers=["generation_6"])


def test_layers_sum_to_the_picture() -> None:
    routes = ("direct", "reflection", "transmission")
    generations = tuple(f"generation_{g}" for g in range(6))
    image = clrt.render(clrt.load_dict({**SCENE, "ambient": 0.1}), spp=4, layers=(*routes, *generations))
    for names in (routes, generations):
        total = sum(image.layers[name].astype(np.float64) for name in names)
        assert np.abs(total - image.pixels).max() < 1e-6
        assert all(image.layers[name].max() > 0 for name in names)


def test_ray_queries_take_any_number_of_rays_and_say_what_is_wrong() -> None:
    tracer = clrt.Tracer(clrt.load_dict(SCENE))
    none = np.zeros((0, 3), np.float32)
    assert tracer.intersect(none, none).t.shape == (0,)
    assert tracer.occluded(none, none).shape == (0,)
    assert tracer.radiance(none, none)[0].shape == (0, 3)
    one = tracer.intersect([[0, 0, 4]], [[0, 0, -2]])
    assert (one.t[0], one.shape[0], one.primitive[0]) == (3.0, 0, 0)
    assert one.normal[0].tolist() == [0, 0, 1]
    assert tracer.occluded([[0, 0, 4]] * 2, [[0, 0, -1]] * 2, [2.9, 3.1]).tolist() == [False, True]
    hurt = tracer.intersect([[0, 0, 4]] * 4, [[0, 0, 0], [np.nan, 0, 1], [np.inf, 0, 0], [0, 1, 0]])
    assert hurt.shape.tolist() == [-1] * 4
    assert np.isinf(hurt.t).all()
    with pytest.raises(clrt.ClrtError, match=r"origins: shape \(2,\) is not \(..., 3\)"):
        tracer.intersect(np.zeros(2), np.zeros((1, 3)))
    with pytest.raises(clrt.ClrtError, match=r"shapes \(3, 3\) and \(2, 3\) do not go together"):
        tracer.intersect(np.zeros((3, 3)), np.zeros((2, 3)))
    with pytest.raises(clrt.ClrtError, match=r"t_max: shape \(2,\) is neither a number nor \(3,\)"):
        tracer.occluded(np.zeros((3, 3)), np.ones((3, 3)), np.ones(2))


def test_settings_are_checked() -> None:
    for wrong in ({"tile": 0}, {"local_size": 0}, {"lanes": 4}, {"threads": 0}, {"tile": 1.5}):
        with pytest.raises(clrt.ClrtError, match=next(iter(wrong))):
            clrt.Settings(**wrong)
    with pytest.raises(clrt.DeviceError, match="local_size 1000000 is above"):
        clrt.Tracer(clrt.load_dict(SCENE), settings=clrt.Settings(local_size=1_000_000))
    with pytest.raises(clrt.DeviceError, match="device 'Nonesuch' is not here; this machine offers"):
        clrt.Tracer(clrt.load_dict(SCENE), device="Nonesuch")
