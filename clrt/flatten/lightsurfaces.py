"""Surfaces of visible lights: primitives after all others, in the order of the lights, in no tree.

A feeler passes by the surface of its own light, so rays try these one by one: they are few.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from clrt import layout
from clrt.base.errors import SceneError, located
from clrt.base.records import cross
from clrt.flatten.geometry import LARGEST
from clrt.scene.arealights import AreaLight, DiskLight, RectangleLight, SphereLight
from clrt.scene.scene import Scene

SECTIONS: Final = ("spheres", "disks", "quadrics")  # of such surfaces


def visible_lights(scene: Scene) -> dict[int, AreaLight]:
    """Those that rays see, by their number among the scene's lights."""
    return {
        number: light
        for number, light in enumerate(scene.lights)
        if isinstance(light, AreaLight) and light.visible
    }


def add_surfaces(scene: Scene, sections: dict[str, np.ndarray], materials: dict[int, int]) -> None:
    """Add the primitives of visible lights to the sections; materials: their numbers, by the light's.

    Raises `SceneError` for one that is too large for float32.
    """
    added: dict[str, list[np.ndarray]] = {"primitives": [], **{section: [] for section in SECTIONS}}
    for number, light in visible_lights(scene).items():
        if not _reach(light) <= LARGEST:
            text = f"its surface reaches beyond {LARGEST:g}, where float32 fails; make it smaller"
            raise SceneError(located(scene.source, f"lights[{number}]", f"{text}, or not visible"))
        kind, record = _record(light)
        section = layout.SECTIONS[kind]
        primitive = np.zeros(1, layout.dtype("Primitive"))
        primitive["kind"] = layout.KINDS[kind]
        primitive["index"] = len(sections[section]) + len(added[section])
        primitive["shape"], primitive["material"] = len(scene.shapes) + number, materials[number]
        sections["lights"]["surface"][number] = len(sections["primitives"]) + len(added["primitives"])
        added[section].append(record)
        added["primitives"].append(primitive)
    for section, records in added.items():
        if records:
            sections[section] = np.concatenate([sections[section], *records])
    sections["scene"]["primitives"] = len(sections["primitives"])
    sections["scene"]["surfaces"] = len(materials)


def without_surfaces(sections: dict[str, np.ndarray], shapes: int) -> dict[str, np.ndarray]:
    """Sections without what `add_surfaces` added; the very arrays where that was nothing."""
    primitives = sections["primitives"]
    own = primitives["shape"] < shapes
    if own.all():
        return sections
    kept: dict[str, Any] = {"primitives": primitives[own]}
    for kind, section in layout.SECTIONS.items():
        if section in SECTIONS:
            count = np.count_nonzero(kept["primitives"]["kind"] == layout.KINDS[kind])
            kept[section] = sections[section][:count]
    return sections | kept


def _reach(light: Any) -> float:
    """The largest |coordinate| of its surface."""
    size = np.full(3, getattr(light, "radius", 0.0))
    if isinstance(light, RectangleLight):
        size = np.abs(light.u) + np.abs(light.v)
    return float((np.abs(light.center) + size).max())


def _record(light: Any) -> tuple[str, np.ndarray]:
    match light:
        case RectangleLight():
            return "QUADRIC", _parallelogram(light)
        case DiskLight():
            disk = np.zeros(1, layout.dtype("Disk"))
            disk["center_radius"][0] = (*light.center, light.radius)
            disk["normal"][0, :3] = np.asarray(light.normal, float) / np.linalg.norm(light.normal)
            return "DISK", disk
        case SphereLight():
            sphere = np.zeros(1, layout.dtype("Sphere"))
            sphere["center_radius"][0] = (*light.center, light.radius)
            return "SPHERE", sphere
    raise AssertionError(f"no surface for {type(light).__name__}")


def _parallelogram(light: RectangleLight) -> np.ndarray:
    """The plane 2 n.p = 0 as a quadric without squares, clipped by its coordinates along u and v."""
    record = np.zeros(1, layout.dtype("Quadric"))
    one = record[0]
    u, v, n = (np.asarray(way, float) for way in (light.u, light.v, light.normal))
    n /= np.linalg.norm(n)
    reach = np.abs(u) + np.abs(v)
    one["center"] = (*light.center, reach[0])
    one["axis_x"] = (*n, 1.0)
    for name, side, other in (("clip_x", u, v), ("clip_y", v, u)):
        across = np.array(cross(other, n))
        one[name][:3], one[name][3] = across / (across @ side), -1.0
    one["clip_z"][3] = -np.inf
    one["clip_high"] = 1.0, 1.0, np.inf, reach[1]
    one["reach"] = (*reach, reach[2])
    return record
