"""Rough mirrors: where their ray goes, how much of a uniform light comes back, and what stays a mirror."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import clrt
from clrt.flatten.camera import flatten_camera
from tests.engines import ENGINES, Engine
from validation.oracle64 import hashing
from validation.oracle64.gloss import mirrored_at_facet
from validation.twin import gloss, queues

ROUGH = np.round(np.arange(0.2, 1.01, 0.1), 1)
FURNACE = {  # numbers 33 to 35
    0: [0.99829, 0.99066, 0.96770, 0.91581, 0.82453, 0.69775, 0.55517, 0.41997, 0.30685],
    45: [0.99737, 0.98536, 0.95114, 0.88573, 0.79368, 0.68639, 0.57330, 0.46200, 0.35950],
    80: [0.96786, 0.90107, 0.85982, 0.83512, 0.80167, 0.75115, 0.68446, 0.60633, 0.52290],
}
V, ALPHA = np.array([0.6, 0.0, 0.8]), 0.25


def integrated(degrees: float, alpha: float) -> float:
    """The share of a uniform light that comes back: D G1(V) G1(r) / (4 V.N), over all facets.

    Over facets and not over directions, since these crowd: dr = 4 (V.H) dH.
    """
    v = np.array([np.sin(np.radians(degrees)), 0.0, np.cos(np.radians(degrees))])
    # tan^2 of a facet's angle is alpha^2 (1 - x)/x, x even in [0, 1] by D cos; of x = y^4, y is taken evenly,
    # for what is steep matters at grazing angles
    y, phi = (np.arange(1200) + 0.5) / 1200, (np.arange(720) + 0.5) * 2 * np.pi / 720
    tan2, share = alpha**2 * (1 - y**4) / y**4, 4 * y**3
    cos = 1 / np.sqrt(1 + tan2)[:, None]
    sin = np.sqrt(1 - cos**2)
    h = np.stack([sin * np.cos(phi), sin * np.sin(phi), cos + 0 * phi], axis=-1)
    across = h @ v
    r = 2 * across[..., None] * h - v
    valid = (across > 0) & (r[..., 2] > 0)

    def smith(z: np.ndarray) -> np.ndarray:
        return 2 / (1 + np.sqrt(1 + alpha**2 * (1 - z**2) / z**2))

    with np.errstate(all="ignore"):
        value = smith(np.array(v[2])) * smith(r[..., 2]) * across / (v[2] * h[..., 2])
    return float((share[:, None] * np.where(valid, value, 0.0)).mean())


@pytest.mark.parametrize("degrees", FURNACE)
def test_numbers_33_to_35_are_the_integral(degrees: int) -> None:
    found = [integrated(degrees, roughness**2) for roughness in ROUGH]
    assert found == pytest.approx(FURNACE[degrees], abs=1e-5)


@pytest.mark.parametrize("name", ENGINES)
def test_white_furnace(name: str) -> None:
    """What rays bring back from a uniform light, by roughness and angle: within 4.5 standard errors."""
    engine: Engine = ENGINES[name]
    rays = 16_000 if name == "kernels" else 2_000
    disks = [
        {"type": "disk", "center": [3.0 * i, 0, 0], "normal": [0, 0, 1], "radius": 1.0,
         "material": {"diffuse": 0.0, "reflection": 1.0, "roughness": float(roughness)}}
        for i, roughness in enumerate(ROUGH)
    ]  # fmt: skip
    scene = clrt.load_dict({"background": 1.0, "max_depth": 1, "shapes": disks})
    angle = np.radians(np.repeat(list(FURNACE), rays))
    u = np.stack([np.sin(angle), 0 * angle, -np.cos(angle)], axis=1)
    centers = 3.0 * np.arange(len(ROUGH))[:, None] * [1.0, 0, 0]
    origins = (centers[:, None] - u).reshape(-1, 3)
    light, _ = engine.radiance(scene, origins, np.tile(u, (len(ROUGH), 1)))
    seen = light[:, 0].reshape(len(ROUGH), len(FURNACE), rays)
    error = seen.std(axis=2) / np.sqrt(rays)
    assert np.all(np.abs(seen.mean(axis=2).T - list(FURNACE.values())) < 4.5 * error.T + 1e-5)
    assert seen.max() <= 1 + 1e-6, "no facet makes light"


def test_number_32() -> None:
    """One ray and its weight, of the oracle and of the float32 twin."""
    n, alpha = np.array([[0.0, 0, 1]]), np.array([ALPHA])
    point = hashing.concentric(np.array([0.3]), np.array([0.7]))
    found = mirrored_at_facet(n, -V[None], alpha, point)
    assert found.direction[0] == pytest.approx([-0.6469603, -0.1153776, 0.7537443], abs=5e-8)
    assert found.passed[0] == pytest.approx(0.988396553, abs=5e-10)
    twin = gloss._about(*(part.astype(np.float32) for part in (n.T, -V[:, None], alpha, *point)))
    assert twin.direction[:, 0] == pytest.approx([-0.6469603, -0.1153776, 0.7537443], abs=4e-7)
    assert twin.passed[0] == pytest.approx(0.988396553, abs=4e-7)


def test_numbers_are_drawn_as_said() -> None:
    """Of generation 0 from the pixel and its sample, which shares them out; deeper from the ray's key."""
    camera = {"origin": [0, 0, 5], "target": [0, 0, 0], "width": 3, "height": 2, "spp": 4, "jitter": 9}
    record = flatten_camera(clrt.Camera(**camera))
    queue = queues.generate(record, np.array([4], np.uint32))
    assert queue.streams.sample.tolist() == [0, 1, 2, 3] and len(set(queue.streams.base.tolist())) == 1
    pixel = hashing.combine(hashing.word([9]), 4)
    assert queue.streams.base[0] == pixel[0]


BALLS: dict[str, Any] = {
    "background": [0.3, 0.4, 0.6],
    "camera": {"origin": [0, 1, 6], "target": [0, 0, 0], "width": 40, "height": 30},
    "lights": [{"type": "point", "position": [3, 5, 4]}],
}


def picture(**material: Any) -> clrt.Image:
    floor = {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]}
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": material}
    return clrt.render({**BALLS, "shapes": [floor, ball]})


@pytest.mark.parametrize(
    "material",
    [
        {"reflection": 0.8, "diffuse": 0.1},
        {"conductor": "gold", "diffuse": 0.0},
        {"fresnel": "schlick", "reflection": 0.5},
        {"fresnel": True, "transmission": 0.0, "reflection": 0.9},
        {"specular": 0.5},  # no mirror at all
    ],
)
def test_what_is_smooth_has_the_bits_of_the_mirror(material: dict[str, Any]) -> None:
    plain = picture(**material).hash
    assert plain == picture(**material, roughness=0.0).hash == picture(**material, roughness=0.0099).hash
    for roughness in (0.01, 0.4):
        assert (picture(**material, roughness=roughness).hash == plain) == ("specular" in material)


def in_glass(inner: dict[str, Any], **glass: Any) -> str:
    """The hash of a picture of a ball of glass with something in it, both before a floor."""
    clear = {"diffuse": 0.0, "reflection": 1.0, "transmission": 1.0, "ior": 1.5, "fresnel": True,
             "absorption": [0.1, 0.3, 0.2], **glass}  # fmt: skip
    shapes = [
        {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]},
        {"type": "sphere", "center": [0, 0, 0], "radius": 1.4, "material": clear},
        {"type": "sphere", "center": [0.1, 0, 0.2], "radius": 0.7, "material": inner},
    ]
    return str(clrt.render({**BALLS, "shapes": shapes, "max_depth": 5}).hash)


@pytest.mark.parametrize(
    "inner",
    [
        {"reflection": 0.8, "diffuse": 0.1},
        {"conductor": "gold", "diffuse": 0.0},
        {"fresnel": "schlick", "reflection": 0.5},
    ],
)
def test_smooth_mirrors_in_glass_have_the_bits_of_the_mirror(inner: dict[str, Any]) -> None:
    """And so has the glass around them, whose roughness may be stated as 0 and as nothing else."""
    plain = in_glass(inner)
    assert plain == in_glass({**inner, "roughness": 0.0}, roughness=0.0)
    assert plain == in_glass({**inner, "roughness": 0.0099})
    assert plain != in_glass({**inner, "roughness": 0.4})


def test_glass_within_glass_has_the_bits_of_what_is_smooth() -> None:
    inner = {"diffuse": 0.0, "reflection": 0.3, "transmission": 0.7, "ior": 1.3}
    assert in_glass(inner) == in_glass({**inner, "roughness": 0.0}, roughness=0.0)
    with pytest.raises(clrt.ClrtError, match=r"shapes\[2\].*roughness.*rough transmits nothing"):
        in_glass({**inner, "roughness": 0.0099})


def test_tiles_and_crops_have_the_bits_of_the_whole() -> None:
    shapes = [{"type": "sphere", "center": [x, 0, 0], "radius": 1.2,
               "material": {"reflection": 0.9, "roughness": 0.5}} for x in (-1.3, 1.3)]  # fmt: skip
    scene = clrt.load_dict({**BALLS, "shapes": shapes, "max_depth": 4})
    whole = clrt.render(scene, spp=4)
    part = clrt.render(scene, spp=4, crop=(7, 5, 21, 19), settings=clrt.Settings(tile=64, lanes=8))
    assert np.array_equal(part.pixels, whole.pixels[5:24, 7:28])
