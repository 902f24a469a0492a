"""A primitive is added in three places, as `docs/adding-a-primitive.md` says: a torus, in a copy of the tree.

It is rendered, shadows, mirrors and refracts, and all of it is what a formula in float64 says.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from tests.additions import RENDER, camera_rays, changed, grown, render, run
from tests.torus import ENTRIES

WIDTH, HEIGHT, DEPTH = 48, 36, 4
EYE = np.array([0.4, 1.9, 3.6])
RING, TUBE, CENTER = 1.0, 0.38, np.array([0.0, 0.1, 0.0])
AXIS = np.array([0.3, 1.0, 0.2]) / np.linalg.norm([0.3, 1.0, 0.2])
LIGHT = np.array([2.0, 4.0, 3.0])
SKY, FLOOR = 0.25, -0.9
GLASS = 1.3
MATERIALS = {
    "diffuse": {"diffuse": 0.8},
    "mirror": {"diffuse": 0.2, "reflection": 0.6},
    "glass": {"diffuse": 0.1, "reflection": 0.1, "transmission": 0.7, "ior": GLASS},
}
TOLERANCE = 1e-4  # of a pixel: two and a half times what float32 was seen to be off after DEPTH bounces


def scene(material: dict[str, float]) -> dict[str, Any]:
    return {
        "max_depth": DEPTH,
        "background": SKY,
        "camera": {"origin": EYE.tolist(), "target": [0, 0, 0], "width": WIDTH, "height": HEIGHT},
        "lights": [{"type": "point", "position": LIGHT.tolist()}],
        "shapes": [
            {
                "type": "torus",
                "center": CENTER.tolist(),
                "axis": AXIS.tolist(),
                "radius": RING,
                "tube": TUBE,
                "material": {"color": [1, 1, 1], **material},
            },
            {
                "type": "plane",
                "point": [0, FLOOR, 0],
                "normal": [0, 1, 0],
                "material": {"color": [1, 1, 1], "diffuse": 0.5},
            },
        ],
    }


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the product with a torus."""
    return grown(tmp_path_factory.mktemp("tree"), "torus", ENTRIES)


def meet(o: np.ndarray, d: np.ndarray) -> np.ndarray:
    """The first distance above 1e-9 to the torus, by the roots of its quartic, inf without one."""
    p = o - CENTER
    y, dy = p @ AXIS, d @ AXIS
    k = p @ p + RING**2 - TUBE**2
    # (t^2 + 2 t p.d + k)^2 = 4 R^2 (|p + t d|^2 - (y + t dy)^2)
    square = np.array([1.0, 2 * (p @ d), k])
    across = np.array([1 - dy * dy, 2 * (p @ d - y * dy), p @ p - y * y])
    found = np.roots(np.polysub(np.polymul(square, square), 4 * RING**2 * across))
    real = found.real[np.abs(found.imag) < 1e-7]
    return np.min(real[real > 1e-6], initial=np.inf)


def hit(o: np.ndarray, d: np.ndarray) -> tuple[float, np.ndarray, bool]:
    """Distance, outward normal, and whether it is the torus."""
    ring = meet(o, d)
    floor = (FLOOR - o[1]) / d[1] if d[1] else np.inf
    floor = floor if floor > 1e-9 else np.inf
    if floor <= ring:
        return floor, np.array([0.0, 1.0, 0.0]), False
    p = o + ring * d - CENTER
    across = p - AXIS * (p @ AXIS)
    n = p - RING * across / np.linalg.norm(across)
    return ring, n / np.linalg.norm(n), True


def radiance(o: np.ndarray, d: np.ndarray, material: dict[str, float], depth: int = 0) -> float:
    t, outward, torus = hit(o, d)
    if t == np.inf:
        return SKY
    p, inside = o + t * d, outward @ d > 0
    n = -outward if inside else outward
    of = material if torus else {"diffuse": 0.5}
    to = LIGHT - p
    far = np.linalg.norm(to)
    to = to / far
    value = 0.0
    if to @ n > 0 and hit(p + 1e-7 * n, to)[0] > far:
        value += of["diffuse"] * (to @ n)
    if depth == DEPTH:
        return value
    reflection, transmission = of.get("reflection", 0.0), of.get("transmission", 0.0)
    if transmission:
        eta, cosine = (GLASS if inside else 1 / GLASS), -(d @ n)
        k = 1 - eta**2 * (1 - cosine**2)
        if k < 0:
            reflection += transmission
        else:
            through = eta * d + (eta * cosine - np.sqrt(k)) * n
            through /= np.linalg.norm(through)
            value += transmission * radiance(p - 1e-7 * n, through, material, depth + 1)
    if reflection:
        value += reflection * radiance(p + 1e-7 * n, d - 2 * (d @ n) * n, material, depth + 1)
    return value


def expected(material: dict[str, float]) -> np.ndarray:
    camera = clrt.load_dict(scene({"diffuse": 1.0}) | {"shapes": []}).camera
    assert camera is not None
    rays = camera_rays(scene(material)["camera"], camera.fov)
    return np.array([[radiance(EYE, d, material) for d in row] for row in rays])


@pytest.mark.parametrize("lanes", [16, 8])
@pytest.mark.parametrize("name", MATERIALS)
def test_a_torus_is_right_in_every_pixel(name: str, lanes: int, tree: Path, tmp_path: Path) -> None:
    pixels = render(tree, scene(MATERIALS[name]), tmp_path, lanes)["pixels"]
    right = expected(MATERIALS[name])
    assert len(np.unique(right.round(3))) > 100, "the picture must show something"
    wrong = np.abs(pixels - right[..., None]).max(axis=-1) > TOLERANCE
    assert wrong.sum() == 0, f"{wrong.sum()} of {wrong.size} pixels, at {np.argwhere(wrong)[:5].tolist()}"


def test_a_kind_without_its_formulas_does_not_build(tree: Path, tmp_path: Path) -> None:
    lacking = shutil.copytree(tree, tmp_path / "lacking")
    changed(lacking, {"kernels/generic.clh": {'#include "torus.clh"\n': ""}})
    done = run(lacking, RENDER, lacking, "", repr(scene(MATERIALS["diffuse"])), 16)
    assert done.returncode and "do not build" in done.stderr
