"""Numbers whose squares leave the range of float32 give the answers that others give."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest

import clrt


def test_directions_of_any_length() -> None:
    tracer = clrt.Tracer({"shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 0.5}], "ambient": 1})
    way = np.array([-1.0, -2.0, -3.0])
    for length in (1e-36, 1e-23, 1, 2e19, 1e38):
        ray = [1, 2, 3], length * way
        assert tracer.intersect(*ray).t == pytest.approx(np.sqrt(14) - 0.5, rel=1e-6)
        assert tracer.occluded(*ray) and tracer.count_hits(*ray) == 2
        assert tracer.radiance(*ray)[0] == pytest.approx(0.8)


@pytest.mark.parametrize("size", [2.0**-40, 2.0**-35, 2.0**35, 2.0**39])
def test_triangles_of_any_size(size: float) -> None:
    assert np.allclose(_picture(size), _picture(1.0), atol=1e-3)


def test_triangles_whose_products_are_no_numbers_are_refused() -> None:
    """They were missed without a word."""
    with pytest.raises(clrt.SceneError, match=r"shapes\[0\]: its coordinates are beyond 1e\+12"):
        _picture(2.0**41)


@pytest.mark.parametrize(
    "far",
    [
        {"type": "plane", "point": [0, 3e38, 0], "normal": [0, 1, 0]},
        {"type": "paraboloid", "apex": [0, 0, 0], "axis": [0, 0, 1], "focal": 1e19, "height": 3e38},
    ],
    ids=lambda shape: shape["type"],
)
def test_surfaces_too_far_for_products_are_refused(far: dict[str, Any]) -> None:
    """Points on them were endless."""
    with pytest.raises(clrt.SceneError, match=r"shapes\[0\]: its coordinates are beyond 1e\+15"):
        clrt.Tracer({"shapes": [far]})


def test_from_so_far_that_the_hit_is_the_centre_a_sphere_has_a_normal() -> None:
    """Against the ray; it was none (NaN), or endless where the hit lay within 1e-20 of the centre."""
    tracer = clrt.Tracer({"shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}]})
    found = tracer.intersect([[0, 1e8, 0], [1e-22, 1e8, 0]], [0.0, -1.0, 0.0])
    assert found.shape.tolist() == [0, 0]
    assert np.allclose(np.linalg.norm(found.normal, axis=1), 1)
    assert found.normal[0].tolist() == [0, 1, 0]


@pytest.mark.parametrize("kind", ["point", "spot"])
def test_lights_as_far_as_they_may_be_shine_as_parallel_light_does(kind: str) -> None:
    """From 1e19 on, where float32 has no square of the distance, they shone on nothing."""
    table = {
        "camera": {"origin": [0, 1, 5], "target": [0, 0, 0], "width": 24, "height": 18},
        "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1},
                   {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]}],
    }  # fmt: skip
    far = {"type": kind, "position": [1e18, 1e18, 1e18]} | ({"target": [0, 0, 0]} if kind == "spot" else {})
    found, parallel = (
        clrt.render({**table, "lights": [light]}).pixels
        for light in (far, {"type": "directional", "direction": [-1, -1, -1]})
    )
    assert found.mean() > 0.1 and np.abs(found - parallel).max() < 1e-5


STEEP = (
    [1e30, -1, -3e38, -0.5, 1000, -2, 1000, 1e-45, 1e-10, 1e30],  # the square of its gradient is denormal
    [-1e19, 1000, 0, -2, 0, 3e38, 0, 1, 1000, 1],  # and here the inverse of its length
)


@pytest.mark.parametrize("coefficients", STEEP, ids=("nothing", "steep"))
def test_quadrics_whose_gradients_have_no_square_have_normals(coefficients: list[float]) -> None:
    """They were up to 11 % too long, or 2 % too short; of the corpus, `quadric_steep.json` had one of NaN."""
    tracer = clrt.Tracer({"shapes": [{"type": "quadric", "coefficients": coefficients}]})
    places = np.array(list(product((-5, 0, 1e-3, 3), (-2, 0, 1), (0, 5, 1e10))), float)
    ways = np.array([[0, 0, -1], [0, -1, -5], [1, 0, 0], [1, 1, 1], [-1e-3, 0.3, 1], [0.1, -1.1, -5]])
    found = tracer.intersect(places[:, None], ways[None], fields=("shape", "normal"))
    met = found.shape == 0
    assert met.any() and np.allclose(np.linalg.norm(found.normal[met], axis=1), 1, atol=1e-6)


def _picture(size: float) -> np.ndarray:
    corners = size * np.array([[-1, -1, 0], [1, -1, 0.5], [0, 1, 0]])
    mesh: dict[str, Any] = {"type": "mesh", "vertices": corners, "faces": [[0, 1, 2]]}
    view = {"origin": [0, 0, 4 * size], "target": [0, 0, 0], "width": 16, "height": 12}
    lamp = {"type": "point", "position": [size, 2 * size, 5 * size]}
    return clrt.render(clrt.load_dict({"camera": view, "lights": [lamp], "shapes": [mesh]})).pixels


def test_lights_that_come_leave_the_hash_of_a_new_tracer() -> None:
    scene = clrt.load_dict({"shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}]})
    tracer = clrt.Tracer(scene)
    for light in ({"type": "disk", "center": [0, 3, 0], "normal": [0, -1, 0], "radius": 1},
                  {"type": "rectangle", "center": [0, 3, 0], "u": [1, 0, 0], "v": [0, 0, 1]}):  # fmt: skip
        lit = scene.replace({"lights": [light]})
        tracer.update(lit)
        assert tracer.flat.hash == clrt.Tracer(lit).flat.hash
