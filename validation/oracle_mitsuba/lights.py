"""Ways from points to lights in float64; of a light with extent to each of its points."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from .hashing import basis, combine, mix, on_disk, unit

Array = np.ndarray
Way = tuple[Array, Array, Array]  # unit directions (n, 3), 0 where none shines; distances, factors (n,)


def ways(light: dict[str, Any], number: int, origin: Array, base: Array, sample: Array) -> Iterator[Way]:
    """To light `number` (a dict of surfaces.lights) from points (n, 3); base and sample (n,): what their rays
    draw from."""
    if "samples" not in light:
        yield _point(light, origin)
        return
    h = combine(base, np.uint32(0x80000002 + number))
    for i in range(light["samples"]):
        with np.errstate(over="ignore"):
            place = sample.astype(np.uint32) * np.uint32(light["samples"]) + np.uint32(i)
            u1 = unit(mix(h + np.uint32(1)) + place * np.uint32(0xC13FA9A9))
            u2 = unit(mix(h + np.uint32(2)) + place * np.uint32(0x91E10DA5))
        with np.errstate(all="ignore"):
            yield (_on_sphere if light["type"] == "sphere" else _on_plane)(light, origin, u1, u2)


def _point(light: dict[str, Any], origin: Array) -> Way:
    if not light["near"]:
        return np.broadcast_to(light["at"], origin.shape), np.full(len(origin), np.inf), np.ones(len(origin))
    L, distance = _towards(light["at"], origin)
    share = cone(light, L)
    with np.errstate(all="ignore"):
        factor = share / distance**2 if light["falloff"] else share
    return np.where((share > 0)[:, None], L, 0.0), distance, factor


def cone(light: dict[str, Any], L: Array) -> Array:
    """The share (n,) of a spot's light that goes against unit directions to it (n, 3); 1 of other kinds."""
    if light["type"] != "spot":
        return np.ones(len(L))
    away = np.degrees(2 * np.arctan2(np.linalg.norm(L + light["axis"], axis=1),
                                     np.linalg.norm(L - light["axis"], axis=1)))  # fmt: skip
    with np.errstate(all="ignore"):
        share = np.clip((light["angle"] - away) / (light["angle"] * light["penumbra"]), 0, 1)
    return np.where(away < light["angle"], share, 0.0)


def _on_plane(light: dict[str, Any], origin: Array, u1: Array, u2: Array) -> Way:
    a, b = on_disk(u1, u2) if light["type"] == "disk" else (2 * u1 - 1, 2 * u2 - 1)
    L, distance = _towards(light["at"] + a[:, None] * light["u"] + b[:, None] * light["v"], origin)
    cosine = -L @ light["normal"]
    cosine = np.abs(cosine) if light["two_sided"] else cosine
    factor = light["area"] * cosine / (light["samples"] * np.pi * distance**2)
    return np.where((cosine > 0)[:, None], L, 0.0), distance, factor


def _on_sphere(light: dict[str, Any], origin: Array, u1: Array, u2: Array) -> Way:
    """Evenly in the solid angle: the cosine to the middle is spread evenly between 1 and the rim's."""
    radius = light["radius"]
    axis, d = _towards(light["at"], origin)
    axis = np.where((d > 0)[:, None], axis, [0.0, 0.0, 1.0])
    outside = d > radius
    width = np.where(outside, (radius / d) ** 2 / (1 + np.sqrt(1 - (radius / d) ** 2)), 2.0)
    q, turn = u1 * width, 2 * np.pi * u2
    sine = np.sqrt(q * (2 - q))
    t, s = basis(axis)
    L = sine[:, None] * (np.cos(turn)[:, None] * t + np.sin(turn)[:, None] * s) + (1 - q)[:, None] * axis
    half = np.sqrt(np.maximum(0.0, radius**2 - (d * sine) ** 2))
    distance = d * (1 - q) + np.where(outside, -half, half)
    L = np.where((outside | light["two_sided"])[:, None], L, 0.0)
    return L, distance, 2 * width / light["samples"]


def surface(light: dict[str, Any], origin: Array, direction: Array) -> tuple[Array, Array]:
    """Where rays (n, 3) first meet the surface of a light that is seen, (n,), inf where they do not; and its
    outward unit normal there (n, 3)."""
    way, nowhere = light["at"] - origin, np.full(len(origin), np.inf)
    if light["type"] == "sphere":
        along = np.einsum("ni,ni->n", way, direction)
        across = way - along[:, None] * direction
        half = light["radius"] ** 2 - np.einsum("ni,ni->n", across, across)
        root = np.sqrt(np.maximum(half, 0.0))
        t = np.where(along - root > 0, along - root, along + root)
        t = np.where((half >= 0) & (t > 0), t, nowhere)
        with np.errstate(invalid="ignore"):
            return t, (t[:, None] * direction - way) / light["radius"]
    with np.errstate(all="ignore"):
        t = way @ light["normal"] / (direction @ light["normal"])
        at = t[:, None] * direction - way
        a, b = (at @ light[name] / (light[name] @ light[name]) for name in ("u", "v"))
        if light["type"] == "rectangle":  # whose sides need not be at right angles
            u, v = light["u"], light["v"]
            inverse = np.linalg.pinv(np.stack([u, v], axis=1))
            a, b = (at @ inverse.T).T
            met = (np.abs(a) <= 1) & (np.abs(b) <= 1)
        else:
            met = a * a + b * b <= 1
    return np.where(met & (t > 0), t, nowhere), np.broadcast_to(light["normal"], origin.shape)


def unhidden(lights: list[dict[str, Any]], number: int, origin: Array, L: Array, distance: Array) -> Array:
    """Where no surface of another light stands before light `number`, (n, 1)."""
    free = np.ones(len(origin), bool)
    for other, light in enumerate(lights):
        if other != number and light.get("visible"):
            free &= ~(surface(light, origin, L)[0] < distance)
    return free[:, None]


def _towards(place: Array, origin: Array) -> tuple[Array, Array]:
    way = place - origin
    distance = np.linalg.norm(way, axis=1)
    return way / np.where(distance > 0, distance, 1.0)[:, None], distance
