"""Checkers as Mitsuba's own `checkerboard` texture.

That has cells of half a unit of u and v and its first colour where both counts of cells are even or both odd,
as the model has; so u and v are lengths in the model's squares over twice their edge.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from .forms import Array
from .meshing import Triangles
from .parts import Part
from .plugins import Plugin, rgb
from .records import Checker, Material, Scene
from .shapes import Sphere
from .surfaces import squares

RIM = 1024  # corners of a disk that is a mesh


def reflectance(material: Material, scale: float, part: Part, scene: Scene) -> Plugin:
    """F times `scale`: a colour, or a checkerboard for a part that `shaped` has made."""
    if not isinstance(material.color, Checker):
        return rgb(scale * np.array(_three(material.color)))
    colors = [rgb(scale * np.array(_three(color))) for color in material.color.colors]
    shape = scene.shapes[part.owner]
    if isinstance(shape, Sphere):  # Mitsuba's longitude runs the other way: counted from there parity changes
        n = material.color.divisions
        to_uv = np.diag([n / 2, n / 4, 1.0])
        colors = colors[:: -1 if n % 2 == 0 else 1]
    else:
        to_uv = (
            np.eye(3)
            if part.kind == "mesh"
            else _rectangle_to_squares(part, *squares(shape), material.color.size)
        )
    return {"type": "checkerboard", "color0": colors[0], "color1": colors[1], "to_uv": to_uv}


def _three(color: Any) -> Array:
    return np.broadcast_to(np.asarray(color, float), 3)


def _rectangle_to_squares(part: Part, origin: Array, across: Array, up: Array, size: float) -> Array:
    """From u, v (0 to 1) on a rectangle to squares."""
    assert part.to_world is not None
    corner = part.to_world @ np.array([-1.0, -1.0, 0.0, 1.0])
    sides = 2 * part.to_world[:3, :2]
    frame = np.stack([across, up]) / (2 * size)
    to_uv = np.eye(3)
    to_uv[:2, :2], to_uv[:2, 2] = frame @ sides, frame @ (corner[:3] - origin)
    return to_uv


def shaped(part: Part, scene: Scene) -> Part:
    """The part as it can carry a checker: disks become meshes, for Mitsuba's have polar u and v."""
    if part.kind != "disk" or not isinstance(scene.material_of(scene.shapes[part.owner]).color, Checker):
        return part
    assert part.to_world is not None
    angle = 2 * np.pi * np.arange(RIM) / RIM
    rim = np.stack([np.cos(angle), np.sin(angle), 0 * angle, 0 * angle + 1], -1) @ part.to_world.T
    middle = np.arange(1, RIM - 1)
    normal = np.linalg.inv(part.to_world[:3, :3]).T[:, 2]
    normals = np.tile(normal / np.linalg.norm(normal), (RIM, 1))
    mesh = Triangles(rim[:, :3], np.stack([0 * middle, middle, middle + 1], -1), normals)
    return replace(part, kind="mesh", to_world=None, mesh=mesh)


def dressed(plugin: Plugin, part: Part, scene: Scene, center: Array) -> Plugin:
    """The shape's plugin with the u and v that its checker needs; the part is about `center`."""
    shape = scene.shapes[part.owner]
    material = scene.material_of(shape)
    if not isinstance(material.color, Checker):
        return plugin
    if isinstance(shape, Sphere):  # Mitsuba's pole is z and its longitude starts at x
        to_world = np.eye(4)
        to_world[:3, :3] = plugin.pop("radius") * np.array(
            [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]
        )
        to_world[:3, 3] = plugin.pop("center")
        return {**plugin, "to_world": to_world}
    if plugin["type"] != "mesh":
        return plugin
    origin, across, up = squares(shape)
    offset = plugin["vertices"] + center - origin
    return {**plugin, "texcoords": offset @ np.stack([across, up], -1) / (2 * material.color.size)}
