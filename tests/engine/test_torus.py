"""A primitive is added in three places, as `docs/adding-a-primitive.md` says: a torus, in a copy of the tree.

It is rendered, shadows, mirrors and refracts, and all of it is what a formula in float64 says.
"""

from __future__ import annotations

import itertools
import shutil
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.flatten.mapping import about
from tests.additions import RENDER, camera_rays, changed, grown, render, run
from tests.torus import ENTRIES

WIDTH, HEIGHT, DEPTH = 48, 36, 4
EYE = np.array([0.4, 1.9, 3.6])
RING, TUBE, CENTER = 1.0, 0.38, np.array([0.0, 0.1, 0.0])
AXIS = np.array([0.3, 1.0, 0.2]) / np.linalg.norm([0.3, 1.0, 0.2])
LIGHT = np.array([2.0, 4.0, 3.0])
SKY, FLOOR = 0.25, -0.9
GLASS, BALL_GLASS = 1.3, 1.6
BALL, RADIUS = np.array([0.3, 0.3, 0.1]), 1.05
MATERIALS = {
    "diffuse": {"diffuse": 0.8},
    "mirror": {"diffuse": 0.2, "reflection": 0.6},
    "glass": {"diffuse": 0.1, "reflection": 0.1, "transmission": 0.7, "ior": GLASS},
}
TOLERANCE = 1e-4  # of a pixel: two and a half times what float32 was seen to be off after DEPTH bounces


def scene(materials: dict[str, Any], eye: np.ndarray = EYE) -> dict[str, Any]:
    """The torus above a floor, and with a material of its own a ball of glass across the torus."""
    shapes = {
        "torus": {
            "type": "torus", "center": CENTER.tolist(), "axis": AXIS.tolist(), "radius": RING, "tube": TUBE,
        },
        "floor": {"type": "plane", "point": [0, FLOOR, 0], "normal": [0, 1, 0]},
        "ball": {"type": "sphere", "center": BALL.tolist(), "radius": RADIUS},
    }  # fmt: skip
    return {
        "max_depth": DEPTH,
        "background": SKY,
        "camera": {"origin": eye.tolist(), "target": [0, 0, 0], "width": WIDTH, "height": HEIGHT},
        "lights": [{"type": "point", "position": LIGHT.tolist()}],
        "shapes": [
            {**shapes[name], "material": {"color": [1, 1, 1], **of}} for name, of in materials.items()
        ],
    }


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the product with a torus."""
    return grown(tmp_path_factory.mktemp("tree"), "torus", ENTRIES)


def roots(o: np.ndarray, d: np.ndarray) -> np.ndarray:
    """The distances above 1e-6 to the torus, by the roots of its quartic."""
    p = o - CENTER
    y, dy = p @ AXIS, d @ AXIS
    k = p @ p + RING**2 - TUBE**2
    # (t^2 + 2 t p.d + k)^2 = 4 R^2 (|p + t d|^2 - (y + t dy)^2)
    square = np.array([1.0, 2 * (p @ d), k])
    across = np.array([1 - dy * dy, 2 * (p @ d - y * dy), p @ p - y * y])
    found = np.roots(np.polysub(np.polymul(square, square), 4 * RING**2 * across))
    real = found.real[np.abs(found.imag) < 1e-7]
    return real[real > 1e-6]


def middle(p: np.ndarray) -> np.ndarray:
    """The point nearest to p of the circle in the torus' tube."""
    across = p - CENTER - AXIS * ((p - CENTER) @ AXIS)
    return CENTER + RING * across / np.linalg.norm(across)


def index_at(p: np.ndarray, ball: bool) -> float:
    """The index of refraction there: where the ball is, it alone counts."""
    if ball and np.linalg.norm(p - BALL) < RADIUS:
        return BALL_GLASS
    return GLASS if np.linalg.norm(p - middle(p)) < TUBE else 1.0


Crossing = tuple[float, np.ndarray, str]  # distance, outward normal, what is crossed


def crossings(o: np.ndarray, d: np.ndarray, ball: bool) -> list[Crossing]:
    """All that a ray crosses, in order."""
    found: list[Crossing] = []
    for t in roots(o, d):
        p = o + t * d
        found.append((t, (p - middle(p)) / TUBE, "torus"))
    b, c = (o - BALL) @ d, (o - BALL) @ (o - BALL) - RADIUS**2
    if ball and b * b > c:
        for t in -b + np.sqrt(b * b - c) * np.array([-1, 1]):
            found.append((t, (o + t * d - BALL) / RADIUS, "ball"))
    if d[1]:
        found.append(((FLOOR - o[1]) / d[1], np.array([0.0, 1.0, 0.0]), "floor"))
    return sorted((one for one in found if one[0] > 1e-6), key=lambda one: one[0])


def radiance(o: np.ndarray, d: np.ndarray, materials: dict[str, dict[str, float]], depth: int = 0) -> float:
    ball = "ball" in materials
    glass = materials["torus"].get("transmission")
    met = crossings(o, d, ball)
    ends = [0.0, *(t for t, _, _ in met), met[-1][0] + 1.0] if met else []
    indices = [index_at(o + (a + b) / 2 * d, ball) for a, b in itertools.pairwise(ends)]
    seen = [k for k, (_, _, name) in enumerate(met)
            if name == "floor" or not glass or indices[k] != indices[k + 1]]  # fmt: skip
    if not seen:
        return SKY
    t, outward, name = met[seen[0]]
    before, after = indices[seen[0] : seen[0] + 2]
    p, of = o + t * d, materials[name]
    n = -outward if outward @ d > 0 else outward
    to = LIGHT - p
    far = np.linalg.norm(to)
    to = to / far
    value = 0.0
    if to @ n > 0 and not any(t < far for t, _, _ in crossings(p + 1e-7 * n, to, ball)):
        value += of["diffuse"] * (to @ n)
    if depth == DEPTH:
        return value
    reflection, transmission = of.get("reflection", 0.0), of.get("transmission", 0.0)
    if transmission:
        eta, cosine = before / after, -(d @ n)
        k2 = 1 - eta**2 * (1 - cosine**2)
        if k2 < 0:
            reflection += transmission
        else:
            through = eta * d + (eta * cosine - np.sqrt(k2)) * n
            through /= np.linalg.norm(through)
            value += transmission * radiance(p - 1e-7 * n, through, materials, depth + 1)
    if reflection:
        value += reflection * radiance(p + 1e-7 * n, d - 2 * (d @ n) * n, materials, depth + 1)
    return value


def wrong(pixels: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Of each pixel whether it is not what the formula says."""
    assert len(np.unique(right.round(4))) > 100, "the picture must show something"
    return np.abs(pixels - right.reshape(HEIGHT, WIDTH, -1)).max(axis=-1) > TOLERANCE


def rays(eye: np.ndarray = EYE) -> np.ndarray:
    table = scene({"floor": {"diffuse": 0.5}}, eye)
    camera = clrt.load_dict(table).camera
    assert camera is not None
    return camera_rays(table["camera"], camera.fov)


@cache
def above_a_floor(name: str) -> tuple[dict[str, dict[str, float]], np.ndarray]:
    """The materials of a torus above the floor, and what the formula says of its picture."""
    materials = {"torus": MATERIALS[name], "floor": {"diffuse": 0.5}}
    return materials, np.array([[radiance(EYE, d, materials) for d in row] for row in rays()])


@pytest.mark.parametrize("lanes", [16, 8])
@pytest.mark.parametrize("name", MATERIALS)
def test_a_torus_is_right_in_every_pixel(name: str, lanes: int, tree: Path, tmp_path: Path) -> None:
    materials, right = above_a_floor(name)
    pixels = render(tree, scene(materials), tmp_path, lanes)["pixels"]
    off = wrong(pixels, right)
    assert off.sum() == 0, f"{off.sum()} of {off.size} pixels, at {np.argwhere(off)[:5].tolist()}"


@pytest.mark.parametrize(("eye", "within"), [
    (EYE, (1.0, 1.0)), (np.array([0.9, -0.2, 0.4]), (GLASS, BALL_GLASS)),
    (np.array([-0.95, 0.4, 0.05]), (GLASS, GLASS)),
])  # fmt: skip
def test_a_torus_of_glass_in_other_glass(
    eye: np.ndarray, within: tuple[float, float], tree: Path, tmp_path: Path
) -> None:
    """A ray may cross it four times unseen. The eye is outside, within both, and within the torus alone."""
    assert (index_at(eye, ball=False), index_at(eye, ball=True)) == within
    ball = {**MATERIALS["glass"], "ior": BALL_GLASS, "priority": 1}
    materials = {"torus": MATERIALS["glass"], "ball": ball, "floor": {"diffuse": 0.5}}
    right = np.array([[radiance(eye, d, materials) for d in row] for row in rays(eye)])
    pixels = render(tree, scene(materials, eye), tmp_path)["pixels"]
    off = wrong(pixels, right)
    assert off.sum() == 0, f"{off.sum()} of {off.size} pixels, at {np.argwhere(off)[:5].tolist()}"


def test_a_torus_shows_a_picture(tree: Path, tmp_path: Path) -> None:
    """u around its axis, v along it."""
    texels = np.random.default_rng(7).uniform(0.1, 1.0, (6, 12, 3)).astype(np.float32)
    clrt.Image(texels).save(tree / "texels.exr")
    color = {"type": "image", "file": "texels.exr", "filter": "nearest"}
    table = scene({"torus": {"color": color, "diffuse": 0.0, "ambient": 1.0}}) | {"ambient": 1.0}
    tangent, bitangent = about(AXIS)
    right = np.full((HEIGHT, WIDTH, 3), SKY)
    for at in np.ndindex(HEIGHT, WIDTH):
        d = rays()[at]
        if len(roots(EYE, d)):
            p = EYE + roots(EYE, d).min() * d - CENTER
            u, v = np.arctan2(p @ bitangent, p @ tangent) / (2 * np.pi) % 1, p @ AXIS / (2 * TUBE) + 0.5
            right[at] = texels[int(6 * v), int(12 * u)]
    off = wrong(render(tree, table, tmp_path)["pixels"], right)
    assert off.sum() == 0, np.argwhere(off)[:5].tolist()


def test_a_kind_without_its_formulas_does_not_build(tree: Path, tmp_path: Path) -> None:
    lacking = shutil.copytree(tree, tmp_path / "lacking")
    changed(lacking, {"kernels/generic.clh": {'#include "torus.clh"\n': ""}})
    done = run(lacking, RENDER, lacking, "", repr(scene({"torus": MATERIALS["diffuse"]})), 16)
    assert done.returncode and "do not build" in done.stderr
