"""What a picture of a scene may be, or light along rays: depth, pixels, samples, work against the limits."""

from __future__ import annotations

import numpy as np

from clrt import layout
from clrt.base import arguments
from clrt.base.limits import Branching, Limits
from clrt.flatten.flatten import FlatScene
from clrt.layout import ceilings
from clrt.scene.scene import Scene


def depth_of(scene: Scene, given: int | None, limits: Limits) -> int:
    """The number of bounces that is given, else the scene's; LimitError beyond what may be."""
    depth = arguments.whole("max_depth", scene.max_depth if given is None else given)
    limits.check("depth", depth)
    ceilings.check_depth(depth)
    return depth


def check_limits(flat: FlatScene, limits: Limits, pixels: int, samples: int, depth: int) -> None:
    """Raise LimitError for a picture of more pixels, samples a pixel or work than may be."""
    limits.check("pixels", pixels)
    limits.check("samples", samples)
    ceilings.check_picture(pixels, samples)
    check_work(flat, limits, pixels * samples, depth)


def check_work(flat: FlatScene, limits: Limits, rays: int, depth: int, place: str = "") -> None:
    """Raise LimitError where so many rays of generation 0, and all that come of them, are too many."""
    parts = -(-flat.bands // flat.group) if flat.group and depth else 1  # rays that dispersion makes of one
    alone = int(flat.scene["unbounded"][0] + flat.scene["surfaces"][0])
    limits.check_work(rays * parts, flat.feelers, _branching(flat, depth), alone, place)


def _branching(flat: FlatScene, depth: int) -> Branching:
    info, materials = flat.scene[0], flat.materials
    doubling = bool(np.any((materials["kr"] > 0) & (materials["kt"] > 0)))
    if info["spd"]:  # counts every reflection, whatever its weight
        return Branching(depth, bool(np.any(materials["kt"] > 0)))
    tint = np.maximum(materials["mirror"].max(axis=1), materials["fresnel"] == layout.FRESNEL["SCHLICK"])
    # total internal reflection takes both shares
    share = materials["kr"] * tint + materials["kt"] * materials["tint"].max(axis=1)
    least, ambient = float(info["min_weight"]), int(info["ambient_samples"])
    return Branching(depth, doubling, float(share.max()), least, ambient)
