"""Ways from points to lights, as the model states them: of a light with extent to each of its points."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

import msgspec
import numpy as np

from clrt.scene.scene import (
    DirectionalLight,
    Disk,
    DiskLight,
    Material,
    PointLight,
    Polygon,
    RectangleLight,
    Scene,
    Sphere,
    SphereLight,
    SpotLight,
)

from . import hashing
from .film import Rays
from .vectors import Array, Ints, dot, unit

Way = tuple[Array, Array, Array]  # directions (n, 3) to a light, distances (n,), factors (n,)


def point(source: Any, origin: Array) -> Way:
    """By inverse square, or not at all less over the distance."""
    to_light = np.array(source.position) - origin
    distance = np.sqrt(dot(to_light, to_light))
    fades = source.falloff == "inverse-square"
    return unit(to_light), distance, distance**-2.0 if fades else np.ones_like(distance)


def directional(source: Any, origin: Array) -> Way:
    """From infinitely far away."""
    distance = np.full(len(origin), np.inf)
    return np.broadcast_to(-unit(source.direction), origin.shape), distance, np.ones_like(distance)


def spot(source: Any, origin: Array) -> Way:
    """As `point`; directions are 0 outside the cone."""
    direction, distance, factor = point(source, origin)
    axis = unit(np.subtract(source.target, source.position))
    theta = np.degrees(np.arccos(np.clip(dot(-direction, axis), -1, 1)))
    inner = source.angle * (1 - source.penumbra)
    share = np.where(theta <= inner, 1.0, 0.0)
    if source.penumbra > 0:
        share = np.clip((source.angle - theta) / (source.angle - inner), 0, 1)
    share = np.where(theta < source.angle, share, 0.0)
    return direction * (share > 0)[:, None], distance, factor * share


def rectangle(source: Any, origin: Array, u1: Array, u2: Array) -> Way:
    """To points of a parallelogram, (u1, u2) in [0, 1)^2 each."""
    u, v = np.array(source.u, float), np.array(source.v, float)
    at = np.array(source.center) + (2 * u1 - 1)[:, None] * u + (2 * u2 - 1)[:, None] * v
    normal = np.cross(u, v)
    return _flat(source, origin, at, normal, 4 * np.sqrt(normal @ normal))


def disk(source: Any, origin: Array, u1: Array, u2: Array) -> Way:
    """To points of a disk."""
    x, y = hashing.concentric(u1, u2)
    normal = unit(source.normal)
    across, along = (axis[0] for axis in hashing.frame(normal[None]))
    at = np.array(source.center) + source.radius * (x[:, None] * across + y[:, None] * along)
    return _flat(source, origin, at, normal, np.pi * source.radius**2)


def _flat(source: Any, origin: Array, at: Array, normal: Array, area: float) -> Way:
    way = at - origin
    distance = np.sqrt(dot(way, way))
    cosine = -dot(unit(way), unit(normal)[None])
    cosine = np.abs(cosine) if source.two_sided else cosine
    shines = (cosine > 0) & (distance > 0)
    factor = area / source.samples * cosine / (np.pi * distance**2)
    return np.where(shines[:, None], unit(way), 0.0), distance, np.where(shines, factor, 0.0)


def sphere(source: Any, origin: Array, u1: Array, u2: Array) -> Way:
    """To points that are spread evenly over the solid angle of a sphere."""
    to_center = np.array(source.center, float) - origin
    squared, rho = dot(to_center, to_center), source.radius
    d = np.sqrt(squared)
    outside = d > rho
    w = np.where(d[:, None] > 0, to_center / d[:, None], [0.0, 0.0, 1.0])
    edge = np.where(outside, np.sqrt(np.maximum(0, 1 - rho**2 / squared)), -1.0)  # cosine at the rim
    cap = np.where(outside, rho**2 / squared / (1 + edge), 2.0)
    cosine, phi = 1 - u1 * cap, 2 * np.pi * u2
    sine = np.sqrt(u1 * cap * (2 - u1 * cap))
    across, along = hashing.frame(w)
    direction = (sine * np.cos(phi))[:, None] * across + (sine * np.sin(phi))[:, None] * along
    direction = direction + cosine[:, None] * w
    half = np.sqrt(np.maximum(0, rho**2 - squared * sine**2))  # of the chord
    distance = d * cosine + np.where(outside, -half, half)
    shines = outside | source.two_sided
    factor = 2 * cap / source.samples
    return np.where(shines[:, None], direction, 0.0), distance, np.where(shines, factor, 0.0)


def with_surfaces(scene: Scene) -> tuple[Scene, Ints]:
    """The scene with the surfaces of its visible lights after its shapes, and of each of these the light's
    number, -1 for what is no light."""
    numbers = [k for k, light in enumerate(scene.lights) if getattr(light, "visible", False)]
    found = copy.copy(scene)
    surfaces = tuple(_surface(scene.lights[k]) for k in numbers)
    msgspec.structs.force_setattr(found, "shapes", (*scene.shapes, *surfaces))
    return found, np.array([-1] * len(scene.shapes) + numbers, int)


def _surface(light: Any) -> Any:
    """A black shape that sends the light's radiance."""
    glow = Material(color=0.0, diffuse=0.0, emission=light.radiance)
    if isinstance(light, RectangleLight):
        center, u, v = (np.array(value, float) for value in (light.center, light.u, light.v))
        corners = (center - u - v, center + u - v, center + u + v, center - u + v)
        points = tuple((float(x), float(y), float(z)) for x, y, z in corners)
        return Polygon(points=points, material=glow)
    if isinstance(light, DiskLight):
        return Disk(center=light.center, normal=light.normal, radius=light.radius, material=glow)
    return Sphere(center=light.center, radius=light.radius, material=glow)


LIGHTS: dict[Any, Any] = {PointLight: point, DirectionalLight: directional, SpotLight: spot}
EXTENDED: dict[Any, Any] = {RectangleLight: rectangle, DiskLight: disk, SphereLight: sphere}


def ways(source: Any, number: int, origin: Array, rays: Rays) -> Iterator[Way]:
    """The way to light `number` from where rays hit, or to each of its points in their order."""
    if type(source) in LIGHTS:
        yield LIGHTS[type(source)](source, origin)
        return
    h = hashing.combine(rays.base, 0x80000002 + number)
    for i in range(source.samples):
        yield EXTENDED[type(source)](source, origin, *hashing.pair(h, rays.sample * source.samples + i))
