"""What tests of flattening share: shapes with points on them in float64, and quadric records read back."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from clrt.flatten.flatten import FlatScene, flatten
from clrt.scene.scene import Scene

SAMPLES = 20_000


def flat(shape: dict[str, Any]) -> tuple[FlatScene, np.ndarray]:
    scene = Scene(shapes=[shape])
    return flatten(scene), scene.shapes[0].matrix


def unbounded(scene: FlatScene) -> list[int]:
    """The numbers of the primitives without a box."""
    return scene.unbounded[: int(scene.scene["unbounded"][0])].tolist()  # type: ignore[no-any-return]


def quadric(record: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Q, g, J of a record, in float64."""
    rows = np.array([record[name] for name in ("axis_x", "axis_y", "axis_z")], float)
    axes, g, (*form, j) = rows[:, :3], rows[:, 3], record["form"].astype(float)
    return axes.T @ np.diag(form) @ axes, axes.T @ g, float(j)


def value(record: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """F at world points (n, 3), and the sum of its terms' magnitudes."""
    q, g, j = quadric(record)
    local = points - record["center"][:3].astype(float)
    form = np.einsum("ni,ij,nj->n", local, q, local) + 2 * local @ g + j
    size = np.abs(local)
    return form, np.einsum("ni,ij,nj->n", size, np.abs(q), size) + 2 * size @ np.abs(g) + abs(j)


def gradient(record: np.ndarray, points: np.ndarray) -> np.ndarray:
    q, g, _ = quadric(record)
    return 2 * ((points - record["center"][:3].astype(float)) @ q + g)


def clipped(record: np.ndarray, points: np.ndarray, slack: float) -> np.ndarray:
    """Which world points lie inside the clip, or outside by no more than `slack`."""
    local = points - record["center"][:3].astype(float)
    inside = np.ones(len(points), bool)
    for name, high in zip(("clip_x", "clip_y", "clip_z"), record["clip_high"].astype(float), strict=False):
        at = local @ record[name][:3].astype(float)
        inside &= (at >= record[name][3] - slack) & (at <= high + slack)
    return inside


def hits(record: np.ndarray, origin: np.ndarray, direction: np.ndarray) -> list[float]:
    q, g, j = quadric(record)
    p = origin - record["center"][:3].astype(float)
    roots = np.roots([direction @ q @ direction, 2 * direction @ (q @ p + g), p @ q @ p + 2 * g @ p + j])
    return sorted(roots.real.tolist())


def on_sphere(rng: np.random.Generator) -> np.ndarray:
    d = rng.normal(size=(SAMPLES, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def around(axis: Any, rng: np.random.Generator) -> np.ndarray:
    """Unit vectors perpendicular to an axis."""
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    d = rng.normal(size=(SAMPLES, 3))
    d -= (d @ axis)[:, None] * axis
    return np.asarray(d / np.linalg.norm(d, axis=1, keepdims=True))


def heights(rng: np.random.Generator) -> np.ndarray:
    """Numbers from 0 to 1, with both ends well covered."""
    return np.clip(rng.uniform(-0.2, 1.2, (SAMPLES, 1)), 0.0, 1.0)


def sample_cone(shape: dict[str, Any], rng: np.random.Generator) -> np.ndarray:
    p0, p1 = np.array(shape["p0"], float), np.array(shape["p1"], float)
    r0, r1 = shape.get("r0", shape.get("radius")), shape.get("r1", shape.get("radius"))
    s = heights(rng)
    return p0 + s * (p1 - p0) + (r0 + s * (r1 - r0)) * around(p1 - p0, rng)


def sample_paraboloid(shape: dict[str, Any], rng: np.random.Generator) -> np.ndarray:
    axis = np.array(shape["axis"], float) / np.linalg.norm(shape["axis"])
    h = heights(rng) ** 2 * shape["height"]
    return shape["apex"] + h * axis + np.sqrt(4 * shape["focal"] * h) * around(axis, rng)


def sample_hyperboloid(shape: dict[str, Any], rng: np.random.Generator) -> np.ndarray:
    y = np.clip(rng.uniform(-1.3, 1.3, (SAMPLES, 1)), -1, 1)
    return y * [0, 1, 0] + np.sqrt(1 + y * y) * around([0, 1, 0], rng)


def sample_polygon(shape: dict[str, Any], rng: np.random.Generator) -> np.ndarray:
    weights = rng.dirichlet(np.full(3, 0.2), SAMPLES)
    return weights @ np.array(shape["points"], float)[:3]


Sampler = Callable[[dict[str, Any], np.random.Generator], np.ndarray]
SHAPES: dict[str, tuple[dict[str, Any], Sampler]] = {
    "sphere": (
        {"type": "sphere", "center": [1, 2, 3], "radius": 0.7},
        lambda shape, rng: shape["center"] + shape["radius"] * on_sphere(rng),
    ),
    "ellipsoid": (
        {"type": "ellipsoid", "center": [1, 0, -2], "radii": [0.5, 2, 1]},
        lambda shape, rng: shape["center"] + shape["radii"] * on_sphere(rng),
    ),
    "cylinder": ({"type": "cylinder", "p0": [1, 0, 2], "p1": [-1, 3, 1], "radius": 0.8}, sample_cone),
    "thin cylinder": ({"type": "cylinder", "p0": [1, 0, 2], "p1": [-1, 3, 1], "radius": 0.02}, sample_cone),
    "cone": ({"type": "cone", "p0": [1, 0, 2], "r0": 0.0, "p1": [-1, 3, 1], "r1": 1.5}, sample_cone),
    "truncated cone": (
        {"type": "cone", "p0": [0, 0, 0], "r0": 2.0, "p1": [0, 1, 0.5], "r1": 0.3},
        sample_cone,
    ),
    "paraboloid": (
        {"type": "paraboloid", "apex": [1, 1, 0], "axis": [1, 2, -1], "focal": 0.3, "height": 1.5},
        sample_paraboloid,
    ),
    "hyperboloid": (  # x^2 - y^2 + z^2 = 1 for |y| <= 1, just inside its clip box
        {
            "type": "quadric",
            "coefficients": [1, -1, 1, 0, 0, 0, 0, 0, 0, -1],
            "clip": [[-1.415, -1, -1.415], [1.415, 1, 1.415]],
        },
        sample_hyperboloid,
    ),
    "clipped sphere": (  # the clip box is the tighter one below, the sphere the tighter one on the sides
        {
            "type": "quadric",
            "coefficients": [1, 1, 1, 0, 0, 0, 0, 0, 0, -1],
            "clip": [[-2, -2, -0.5], [2, 2, 2]],
        },
        lambda shape, rng: (p := on_sphere(rng))[p[:, 2] >= -0.5],
    ),
    "disk": (
        {"type": "disk", "center": [1, -1, 2], "normal": [1, 2, 3], "radius": 1.3},
        lambda shape, rng: shape["center"] + shape["radius"] * around(shape["normal"], rng),
    ),
    "polygon": ({"type": "polygon", "points": [[0, 0, 0], [2, 0, 1], [1, 3, 1]]}, sample_polygon),
    "mesh": (
        {"type": "mesh", "vertices": [[0, 0, 0], [2, 0, 1], [1, 3, 1]], "faces": [[0, 1, 2]]},
        lambda shape, rng: sample_polygon({"points": shape["vertices"]}, rng),
    ),
}
NOT_TIGHT = {"hyperboloid", "clipped sphere"}  # under rotation their boxes are those of clip boxes


def transforms(rng: np.random.Generator, similar: bool) -> list[dict[str, Any]]:
    """A random turn, scale (-3 to 3 a factor) and shift, a mirror half of the time."""
    factors = np.full(3, rng.uniform(0.3, 3)) if similar else rng.uniform(0.3, 3, 3)
    factors *= rng.choice([-1, 1], 3)
    turns = [{"rotate": [rng.normal(size=3).tolist(), rng.uniform(0, 360)]} for _ in range(2)]
    return [
        turns[0],
        {"scale": factors.tolist()},
        turns[1],
        {"translate": (rng.normal(size=3) * 10).tolist()},
    ]


def place(name: str, seed: int) -> tuple[FlatScene, np.ndarray, np.ndarray]:
    """A shape under the `seed`-th transform (0: none), world points on it, and the transform's matrix."""
    rng = np.random.default_rng(seed)
    shape, sampler = SHAPES[name]
    transform = transforms(rng, similar=name == "disk" or seed == 1) if seed else None
    scene, matrix = flat(shape | {"transform": transform})
    points = sampler(shape, rng) @ matrix[:3, :3].T + matrix[:3, 3]
    return scene, points, matrix
