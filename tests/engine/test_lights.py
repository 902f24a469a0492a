"""Lights with extent: where they are seen, what they shade, and that nothing else changes a bit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import clrt

CAMERA = {"origin": [0, 1.5, 6], "target": [0, 0.8, 0], "fov": 40, "width": 40, "height": 30}
FLOOR = {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], "material": {"color": 0.6}}
BALL = {"type": "sphere", "center": [0.4, 0.6, 0], "radius": 0.6,
        "material": {"diffuse": 0.7, "specular": 0.1}}  # fmt: skip
PANEL = {"type": "rectangle", "center": [0, 3, 0], "u": [0.6, 0, 0], "v": [0.2, 0, 0.7],
         "radiance": [4, 3, 2]}  # fmt: skip
PLATE = {"type": "disk", "center": [-1, 1, 0], "normal": [0, 0, 2], "radius": 0.5, "radiance": 0.5}
BULB = {"type": "sphere", "center": [1.2, 1.6, 0.5], "radius": 0.3, "radiance": [0.6, 0.7, 0.8], "samples": 4}


def scene(*lights: dict[str, Any], shapes: Any = (FLOOR, BALL), **settings: Any) -> clrt.Scene:
    return clrt.load_dict({"camera": CAMERA, "shapes": list(shapes), "lights": list(lights), **settings})


def looking(lights: Any, origin: Any, direction: Any, shapes: Any = (), **settings: Any) -> list[float]:
    """What one ray sees."""
    found, _ = clrt.Tracer(scene(*lights, shapes=shapes, **settings)).radiance([origin], [direction])
    return list(found[0])


@pytest.mark.parametrize("settings", [{"tile": 64}, {"lanes": 8}, {"local_size": 2, "tile": 300}])
@pytest.mark.parametrize("shadow", ["opaque", "tinted"])
def test_the_same_bits_however_it_is_traced(settings: dict[str, Any], shadow: str) -> None:
    mirror = {"type": "sphere", "center": [-0.9, 0.5, 0.6], "radius": 0.5, "material": {"reflection": 0.6}}
    camera = {**CAMERA, "spp": 4, "jitter": 1}
    found = scene(PANEL, PLATE, BULB, shapes=(FLOOR, BALL, mirror), shadow=shadow, camera=camera)
    assert clrt.render(found).hash == clrt.render(found, settings=clrt.Settings(**settings)).hash


def test_pixels_have_points_of_their_own_and_crops_keep_them() -> None:
    tracer = clrt.Tracer(scene(PANEL))
    whole, part = tracer.render(), tracer.render(crop=(10, 5, 20, 17))
    assert np.array_equal(whole.pixels[5:22, 10:30], part.pixels)


@pytest.mark.parametrize(
    ("light", "origin", "direction", "sees"),
    [
        (PANEL, [0.3, 5, 0.3], [0, -1, 0], 0.0),  # u x v points down
        (PANEL, [0.3, 0, 0.3], [0, 1, 0], 4.0),
        (PANEL, [0.75, 0, 0.65], [0, 1, 0], 4.0),  # a corner of the slanting side
        (PANEL, [-0.75, 0, 0.65], [0, 1, 0], 0.125),
        ({**PANEL, "two_sided": True}, [0.3, 5, 0.3], [0, -1, 0], 4.0),
        ({**PANEL, "visible": False}, [0.3, 5, 0.3], [0, -1, 0], 0.125),
        (PLATE, [-1, 1.49, 3], [0, 0, -1], 0.5),
        (PLATE, [-1, 1.51, 3], [0, 0, -1], 0.125),
        (PLATE, [-1, 1, -3], [0, 0, 1], 0.0),
        (BULB, [1.2, 1.6, 5], [0, 0, -1], 0.6),
        (BULB, [1.2, 1.6, 0.6], [0, 0, -1], 0.0),  # from within
        ({**BULB, "two_sided": True}, [1.2, 1.6, 0.6], [0, 0, -1], 0.6),
    ],
)
def test_what_a_ray_sees_of_a_light(light: Any, origin: Any, direction: Any, sees: float) -> None:
    assert looking([light], origin, direction, background=0.125)[0] == np.float32(sees)


def test_mirrors_and_glass_see_lights() -> None:
    mirror = {**FLOOR, "material": {"diffuse": 0, "reflection": 0.5}}
    glass = {**FLOOR, "material": {"diffuse": 0, "transmission": 0.5, "ior": 1.0}}
    up = {**PANEL, "center": [0, -3, 0], "v": [-0.2, 0, -0.7]}
    assert looking([{**PANEL, "two_sided": True}], [0, 1, 0], [0, -1, 0], [mirror])[0] == 2.0
    assert looking([up], [0, 1, 0], [0, -1, 0], [glass])[0] == 2.0


def test_a_visible_light_has_no_highlight_on_a_mirror() -> None:
    shiny = {**FLOOR, "material": {"diffuse": 0, "specular": 0.5, "shininess": 4, "reflection": 0.0}}
    mirror = {**FLOOR, "material": {**shiny["material"], "reflection": 0.25}}
    lamp = {**PANEL, "two_sided": True}
    ray = [3.0, 1, 0.1], [-0.4, -1, 0]  # whose mirror image passes by the light
    hidden = {**lamp, "visible": False}
    highlight = looking([lamp], *ray, [shiny])
    assert highlight[0] > 0.01 and looking([hidden], *ray, [mirror]) == highlight
    assert looking([lamp], *ray, [mirror]) == [0, 0, 0]


def test_a_light_stands_in_the_way_of_others_but_not_of_itself() -> None:
    above = {"type": "point", "position": [0, 5, 0]}
    tracer = clrt.Tracer(scene(PANEL, shapes=[FLOOR]))
    hidden = clrt.Tracer(scene({**PANEL, "visible": False}, shapes=[FLOOR]))
    ray = [[0, 1, 0]], [[0, -1, 0]]
    seen = tracer.radiance(*ray)[0]
    assert np.array_equal(seen, hidden.radiance(*ray)[0]) and seen.all()
    dark, lit = (looking([above, {**PANEL, "radiance": 0, "visible": seen}], [0, 1, 0], [0, -1, 0], [FLOOR])
                 for seen in (True, False))  # fmt: skip
    assert dark == [0, 0, 0] and lit[0] > 0.5
    tinted = looking([above, {**PANEL, "radiance": 0}], [0, 1, 0], [0, -1, 0], [FLOOR], shadow="tinted")
    assert tinted == [0, 0, 0]
    assert list(tracer.occluded([[0, 1, 0], [2, 1, 0]], [[0, 1, 0]] * 2)) == [True, False]


def test_lights_are_counted_after_shapes() -> None:
    sun = {"type": "directional", "direction": [0, -1, 0]}
    found = scene(sun, PLATE, {**BULB, "visible": False}, PANEL)
    image = clrt.render(found, layers=["shape", "emission", "depth"])
    shape, emission = image.layers["shape"], image.layers["emission"]
    assert set(np.unique(shape)) == {-1, 0, 1, 2 + 1}
    assert (emission[shape == 3] == 0.5).all() and not emission[shape != 3].any()
    hits = clrt.Tracer(found).intersect([[0.3, 5, 0.3]], [[0, -1, 0]])
    assert (hits.shape[0], hits.primitive[0]) == (2 + 3, 3)
    np.testing.assert_allclose([*hits.normal[0], hits.t[0]], [0, -1, 0, 2], atol=1e-6)


def test_ambient_rays_do_not_count_a_light_twice() -> None:
    """All around is light: feelers bring all of it, the ambient rays that meet it nothing."""
    sky = {"type": "sphere", "center": [0, 0, 0], "radius": 50, "two_sided": True, "samples": 64}
    white = {**FLOOR, "material": {"color": 1.0}}
    found = looking([sky], [0, 1, 0], [0, -1, 0], [white], ambient_samples=16)
    assert found[0] == pytest.approx(looking([sky], [0, 1, 0], [0, -1, 0], [white])[0], rel=1e-6)


@pytest.mark.parametrize(
    ("changes", "cost"),
    [
        ({"lights[0].radiance": 2}, "tables"), ({"lights[1].center": [0, 2, 0]}, "tables"),
        ({"lights[0].samples": 3}, "tables"), ({"lights[1].radius": 0.2}, "tables"),
        ({"lights": []}, "tables"), ({"camera.fov": 30}, "camera"),
        ({"shapes[1].radius": 0.5}, "refit"),
    ],
)  # fmt: skip
def test_a_tracer_follows_lights(changes: dict[str, Any], cost: str) -> None:
    before = scene(PANEL, BULB, PLATE)
    after = before.replace(changes)
    with clrt.Tracer(before) as tracer:
        assert tracer.update(after) == cost
        assert tracer.render().hash == clrt.render(after).hash
        assert tracer.update(before) != "nothing"
        assert tracer.render().hash == clrt.render(before).hash


def test_feelers_have_a_ceiling() -> None:
    many = [{**PANEL, "samples": 30_000}, {**BULB, "samples": 35_535}]
    clrt.Tracer(scene(*many))
    with pytest.raises(clrt.LimitError, match=r"lights: 65 536 is too many: 65 535 .*or lower their samples"):
        clrt.Tracer(scene(*many, {"type": "point", "position": [0, 5, 0]}))


def test_a_camera_inside_a_light_has_a_picture() -> None:
    around = {"type": "sphere", "center": [0, 1, 6], "radius": 2, "radiance": 0.5, "samples": 2}
    assert not clrt.render(scene(around)).pixels.any()
    assert (clrt.render(scene({**around, "two_sided": True})).pixels == 0.5).all()
    seen = clrt.render(scene({**around, "two_sided": True, "visible": False})).pixels
    assert np.isfinite(seen).all() and seen.max() > 0.01


def test_a_light_beyond_float32_is_refused() -> None:
    with pytest.raises(clrt.SceneError, match=r"lights\[1\]: its surface .*1e\+15.* or not visible"):
        clrt.Tracer(scene(PANEL, {**BULB, "radius": 2e15}))
    clrt.Tracer(scene({**PANEL, "u": [1e16, 0, 0], "visible": False}))
