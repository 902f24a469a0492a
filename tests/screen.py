"""Where light goes, measured: a screen on which three coloured lights tell the point that was hit."""

from __future__ import annotations

from typing import Any

import numpy as np

import clrt
from tests.engines import Engine, unit

Shapes = list[dict[str, Any]]
Ray = tuple[Any, Any]  # origin, direction
GAP = 0.25  # between the screen and its lights


def landing(engine: Engine, shapes: Shapes, ray: Ray, near: Any, facing: Any, **settings: Any) -> Any:
    """Where a ray ends on a screen through `near` that faces `facing`: a square of side 2.

    A red, a green and a blue light stand GAP above it. The screen sees light c at distance r_c under the
    cosine GAP / r_c: its radiance in band c is GAP / r_c^3.
    """
    near, n = np.asarray(near, float), unit(facing)
    u = unit(np.cross(n, [0.36, 0.48, 0.8]))
    v = np.cross(n, u)
    square = [list(near + a * u + b * v) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    screen = {"type": "polygon", "points": square, "material": {"color": 1.0}}
    lights = [
        {"type": "point", "position": list(foot + GAP * n), "intensity": color, "falloff": "inverse-square"}
        for foot, color in zip([near, near + GAP * u, near + GAP * v], np.eye(3).tolist(), strict=True)
    ]
    scene = clrt.load_dict({"shapes": [*shapes, screen], "lights": lights, **settings})
    light, _ = engine.radiance(scene, *ray)
    assert (light > 0).all(), "the ray missed the screen"
    across = (GAP / light[0]) ** (2 / 3) - GAP**2  # squared distances from below the lights
    a, b = ((across[0] - across[i]) / (2 * GAP) + GAP / 2 for i in (1, 2))
    return near + a * u + b * v


def passage(
    engine: Engine, shapes: Shapes, ray: Ray, near: Any, leaving: Any, **settings: Any
) -> tuple[np.ndarray, np.ndarray]:
    """A point of the ray that leaves near the point `near` in about this direction; its direction."""
    near, leaving = np.asarray(near, float), unit(leaving)
    screens = [near + distance * leaving for distance in (1.0, 3.0)]
    points = [landing(engine, shapes, ray, screen, -leaving, **settings) for screen in screens]
    return points[0], unit(points[1] - points[0])


def landed(engine: Engine) -> float:
    """How far a direction that `passage` measures may be off.

    A radiance of about 20 roundings gives GAP / 3 * 20 * 6e-8 = 1e-7 in r_c, up to four times as much on
    the screen, twice over the 2 units between the screens; the points' float32 coordinates add as much again.
    What is lit starts twice the offset and 2 units in the last place of the ray's length before the screen,
    4e-6 at coordinates of 4: that moves the point by as much at most, by half of it over 2 units.
    """
    return engine.tolerance(5e-6)


def degrees_between(a: Any, b: Any) -> float:
    """The angle between two directions, precise for small ones too."""
    a, b = unit(a), unit(b)
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), np.dot(a, b))))


def polar(degrees: float) -> np.ndarray:
    """The unit vector in the plane z = 0 that goes down (-y) and is turned by an angle towards +x."""
    angle = np.radians(degrees)
    return np.array([np.sin(angle), -np.cos(angle), 0.0])
