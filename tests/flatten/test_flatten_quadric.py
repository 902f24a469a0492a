"""Quadrics in their centred frame, against points sampled on each shape in float64."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from clrt import layout
from clrt.flatten import quadric
from flatten_samples import (
    SHAPES,
    around,
    clipped,
    flat,
    gradient,
    hits,
    on_sphere,
    place,
    transforms,
    unbounded,
    value,
)


def test_the_model_s_quadric() -> None:
    scene, _ = flat({"type": "quadric", "coefficients": [1, 2, 3, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, -7]})
    record = scene.quadrics[0]
    origin, direction = np.array([0.3, -0.2, -5.0]), np.array([0.1, 0.2, 1.0]) / np.sqrt(1.05)
    near, far = hits(record, origin, direction)
    assert near == pytest.approx(3.4507064402, rel=1e-6) and far == pytest.approx(5.8051354205, rel=1e-6)
    normal = gradient(record, (origin + near * direction)[None])[0]
    expected = [0.1406860007, 0.2802985105, -0.9495473628]
    np.testing.assert_allclose(normal / np.linalg.norm(normal), expected, atol=1e-6)
    assert scene.finite.tolist() == [0]  # an ellipsoid: its form is definite


def test_the_model_s_paraboloid_is_unbounded_and_centred_at_its_apex() -> None:
    scene, _ = flat({"type": "quadric", "coefficients": [1, 0, 1, 0, 0, 0, 0, -0.5, 0, 0]})
    record = scene.quadrics[0]
    assert hits(record, np.array([0.5, 5.0, 0.25]), np.array([0.0, -1.0, 0.0])) == pytest.approx([4.6875])
    normal = gradient(record, np.array([[0.5, 0.3125, 0.25]]))[0]
    np.testing.assert_allclose(-normal / np.linalg.norm(normal), np.array([-2, 2, -1]) / 3, atol=1e-7)
    assert unbounded(scene) == [0] and record["reach"].tolist() == [0, 0, 0, np.inf]
    assert record["center"].tolist() == [0, 0, 0, np.inf]
    moved, _ = flat(
        {
            "type": "quadric",
            "coefficients": [1, 0, 1, 0, 0, 0, 0, -0.5, 0, 0],
            "transform": [{"translate": [100.0, 20.0, -3.0]}],
        }
    )
    np.testing.assert_allclose(moved.quadrics["center"][0, :3], [100, 20, -3])
    shifted, _ = flat({"type": "quadric", "coefficients": [1, 0, 1, 0, 0, 0, -100, -0.5, 3, 10029]})
    np.testing.assert_allclose(
        shifted.quadrics["center"][0, :3], [100, 20, -3]
    )  # the same by its coefficients


def test_an_infinite_cylinder_is_centred_where_its_axis_is_nearest() -> None:
    scene, _ = flat({"type": "quadric", "coefficients": [1, 0, 1, 0, 0, 0, -7, 0, 5, 73]})
    assert unbounded(scene) == [0]
    np.testing.assert_allclose(scene.quadrics["center"][0, :3], [7, 0, -5], atol=1e-6)
    assert scene.quadrics["form"][0].tolist() == [1, 0, 1, -1]


def test_a_form_keeps_its_sign_and_its_ratios_to_the_bit() -> None:
    """Scaled by a power of two only, so what a scene says in a few digits stays what it is."""
    given = np.array([-0.1, -0.7, -0.3, 0.9], np.float32)
    inverted, _ = flat({"type": "quadric", "coefficients": [-0.1, -0.7, -0.3, 0, 0, 0, 0, 0, 0, 0.9]})
    ratio = inverted.quadrics["form"][0] / given
    assert (ratio == ratio[0]).all() and np.frexp(ratio[0])[0] == 0.5
    assert inverted.finite.tolist() == [0]
    np.testing.assert_allclose(
        inverted.boxes["high"][0, :3], np.sqrt(0.9 / np.array([0.1, 0.7, 0.3])), rtol=1e-4
    )


@pytest.mark.parametrize("size", [1e-12, 1e-3, 1.0, 1e5, 1e12])
def test_forms_are_scaled_to_what_float32_holds(size: float) -> None:
    shape = {"type": "ellipsoid", "center": [size, 0, 0], "radii": [size, 2 * size, 3 * size]}
    scene, _ = flat(shape)
    record = scene.quadrics[0]
    assert np.linalg.norm(gradient(record, np.array([[2 * size, 0.0, 0.0]]))) == pytest.approx(2, rel=0.5)
    np.testing.assert_allclose(scene.boxes["low"][0, :3], np.array([0, -2, -3]) * size, atol=2e-4 * size)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", [name for name in SHAPES if name not in ("disk", "polygon", "mesh")])
def test_quadrics_vanish_on_their_shape_and_grow_outwards(name: str, seed: int) -> None:
    scene, points, matrix = place(name, seed)
    kind = scene.primitives["kind"][0]
    if kind == layout.KINDS["SPHERE"]:
        assert name == "sphere" and seed < 2
        center, radius = np.split(scene.spheres["center_radius"][0].astype(float), [3])
        np.testing.assert_allclose(np.linalg.norm(points - center, axis=1), radius[0], rtol=1e-5)
        return
    assert kind == layout.KINDS["QUADRIC"]
    record = scene.quadrics[0]
    assert np.array_equal(record["center"], record["center"].astype(np.float32))
    form, terms = value(record, points)
    assert (np.abs(form) <= 4 * 2.0**-24 * terms).all()
    assert clipped(record, points, 1e-6 * np.abs(points).max()).all()
    reach = record["reach"][:3].astype(float)
    assert (np.abs(points) <= reach * (1 + 1e-6)).all() and (reach <= np.abs(points).max(axis=0) * 1.6).all()
    if name != "hyperboloid":  # all others bound a convex region, so that this holds at every point
        inner = matrix[:3, :3] @ _inner_point(SHAPES[name][0]) + matrix[:3, 3]
        outwards, slope = points - inner, gradient(record, points)
        assert value(record, inner[None])[0][0] < 0
        sine = np.einsum("ni,ni->n", outwards, slope) / np.linalg.norm(outwards, axis=1)
        assert (sine > -1e-4).all() and (sine > 1e-3).mean() > 0.8  # a cone's apex has no gradient


def _inner_point(shape: dict[str, Any]) -> np.ndarray:
    """A point inside the shape, in its own coordinates."""
    if "p0" in shape:
        return np.asarray(0.4 * np.array(shape["p0"]) + 0.6 * np.array(shape["p1"]))
    if "apex" in shape:
        axis = np.array(shape["axis"]) / np.linalg.norm(shape["axis"])
        return np.asarray(shape["apex"] + 0.9 * shape["height"] * axis)
    return np.asarray(shape.get("center", [0.0, 0.0, 0.0]), float)


def test_what_lies_beyond_the_end_circles_is_clipped() -> None:
    shape = SHAPES["cylinder"][0]
    scene, _ = flat(shape)
    p0, p1 = np.array(shape["p0"], float), np.array(shape["p1"], float)
    s = np.array([[-0.01], [0.01], [0.99], [1.01]])
    side = p0 + s * (p1 - p0) + 0.8 * around(p1 - p0, np.random.default_rng(0))[:1]
    assert clipped(scene.quadrics[0], side, 0.0).tolist() == [False, True, True, False]
    cone, _ = flat(SHAPES["cone"][0])
    other_nappe = p0 - 0.1 * (p1 - p0)
    assert not clipped(cone.quadrics[0], other_nappe[None], 0.0)[0]


def test_a_clip_box_follows_its_quadric() -> None:
    shape = {
        "type": "quadric",
        "coefficients": [1, 1, 1, 0, 0, 0, 0, 0, 0, -1],
        "clip": [[-2, 0, -2], [2, 2, 0.5]],
    }
    rng = np.random.default_rng(4)
    scene, matrix = flat(shape | {"transform": transforms(rng, similar=False)})
    points = on_sphere(rng)
    inside = (points[:, 1] >= 0) & (points[:, 2] <= 0.5)
    clear = (np.abs(points[:, 1]) > 1e-4) & (np.abs(points[:, 2] - 0.5) > 1e-4)
    got = clipped(scene.quadrics[0], points @ matrix[:3, :3].T + matrix[:3, 3], 0.0)
    np.testing.assert_array_equal(got[clear], inside[clear])
    assert inside.any() and not inside.all()


def test_an_ellipsoid_that_float32_cannot_tell_from_a_cylinder_is_tested_for_every_ray() -> None:
    needle = {"type": "ellipsoid", "center": [0, 0, 0], "radii": [1.5e-6, 1, 1.5e-6]}
    straight, _ = flat(needle)
    turn = {"transform": [{"rotate": [[1, 0.3, 0.2], 40.0]}]}
    tilted, _ = flat(needle | turn)
    thicker, _ = flat(needle | turn | {"radii": [1e-4, 1, 1e-4]})
    assert straight.finite.tolist() == thicker.finite.tolist() == [0] and unbounded(tilted) == [0]
    assert np.isfinite(tilted.quadrics["form"]).all()


@pytest.mark.parametrize("seed", range(20))
def test_axes_of_a_form_are_its_eigenvectors(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    for values in (rng.normal(size=3), [1, 1, 0], [1e-9, 1, 1], [2, 2, 2], [0, 0, 0], [-1, 0, 1e6]):
        q = turn @ np.diag(values) @ turn.T
        found, axes = (part[0] for part in quadric._own_axes(q[None]))
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-14)
        np.testing.assert_allclose(axes.T @ np.diag(found) @ axes, q, atol=1e-13 * np.abs(q).max())


def test_axes_of_equal_eigenvalues_do_not_follow_rounding() -> None:
    """What the last bits of a matrix are differs from one processor's BLAS to the next."""
    rng = np.random.default_rng(5)
    axis = rng.normal(size=(500, 3, 1))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    q = np.eye(3) - axis @ np.swapaxes(axis, 1, 2)
    noise = 1 + 2.0**-52 * rng.integers(-2, 3, q.shape)
    one, other = (quadric._own_axes(0.5 * (m + np.swapaxes(m, 1, 2)))[1] for m in (q, q * noise))
    assert (np.abs(one - other).max(axis=(1, 2)) < 1e-12).mean() > 0.99
