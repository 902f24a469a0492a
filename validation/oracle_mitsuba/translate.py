"""A whole scene as plain data for Mitsuba, with its stock plugins: what `clrt convert scene.toml scene.xml`
writes.

Shapes, cameras, checkers, backgrounds, mirrors and dielectrics are exact. What Mitsuba has no plugin for
becomes the nearest one, and a note says so: a Phong highlight a rough conductor, constant shares of a
boundary Fresnel's, a light without falloff one that is as bright where the camera looks. Mitsuba adds what
the model leaves out: light from surface to surface, and the square of the index in transmitted radiance.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from . import cameras, skies, surfaces, textures
from .forms import Array, ellipsoid_frame
from .parts import SMALL, Part, geometry
from .plugins import Plugin, shape
from .plugins import rgb as color
from .reading import Untranslated
from .records import Camera, Checker, Material, Scene, rgb
from .shapes import Quadric
from .surroundings import around_glass

_NEAR = 1e-4  # of the distance to the camera's target: where it sees from, which Mitsuba has above 0


def to_mitsuba(source: Scene) -> Plugin:
    """The scene as what mitsuba.load_dict takes, once `engine.realised` has made its arrays Mitsuba's."""
    return translated(source)[0]


def translated(source: Scene) -> tuple[Plugin, list[str]]:
    """The scene as plain data (plugins.py), and notes on what is not exact in it."""
    if any(source.material_of(item).pictures for item in source.shapes):
        raise Untranslated("pictures on surfaces are not translated into a file of Mitsuba's")
    notes = _settings_notes(source)
    world = geometry(source, SMALL)
    outside = around_glass(source, world.parts, notes)
    for index, item in enumerate(source.shapes):
        if isinstance(item, Quadric) and item.clip is None and ellipsoid_frame(item.coefficients) is None:
            notes.append(f"shapes[{index}]: it has no end; its mesh has, and is coarse in a large scene")
    children: dict[str, Plugin] = {
        "integrator": {"type": "path", "max_depth": source.max_depth + 2, "rr_depth": 100_000}
    }
    camera = source.camera
    if camera is not None:
        children["sensor"] = cameras.sensor(camera, camera.width, camera.height, world.size, near=_NEAR)
        children["sensor"]["sampler"] = {"type": "independent", "sample_count": max(16, camera.spp)}
    for index, part in enumerate(world.parts):
        part = textures.shaped(part, source)
        inner = _surface(source, part, outside[index], notes)
        plugin = textures.dressed(shape(part, **inner), part, source, np.zeros(3))
        children[f"shape_{part.owner}_{index}"] = plugin
    look_at = np.asarray(camera.target, float) if camera is not None else world.center
    for index, light in enumerate(surfaces.lights(source)):
        children[f"light_{index}"] = _light(light, look_at, f"lights[{index}]", notes)
    sky = _sky(source)
    if sky is not None:
        children["sky"] = sky
    return {"type": "scene", **children}, list(dict.fromkeys(notes))


def _settings_notes(source: Scene) -> list[str]:
    notes = []
    sky = source.background_path is not None or max(rgb(source.background)) > 0
    same = source.background_path is None and rgb(source.background) == rgb(source.ambient)
    if sky and same:
        notes.append("ambient: the light of Mitsuba's sky, from which things shade one another")
    elif sky:
        notes.append("background: Mitsuba's sky lights surfaces, too")
    if max(rgb(source.ambient)) > 0 and not same:
        notes.append("ambient: left out; Mitsuba has no constant ambient light")
    if source.shadow == "tinted":
        notes.append("shadow: Mitsuba's shadows of glass are opaque")
    if source.one_sided != "none":
        notes.append("one_sided: Mitsuba's surfaces are seen from both sides")
    if max(rgb(source.depth_color)) > 0 or source.min_weight > 0:
        notes.append("depth_color, min_weight: left out")
    if source.conformance != "none":
        notes.append("conformance: Mitsuba has no such rules")
    filled = {m.priority for m in map(source.material_of, source.shapes) if m.kt > 0 and not m.thin}
    if len(filled) > 1:
        notes.append("priority: Mitsuba's media have none; where solids overlap all surfaces count")
    return notes + _camera_notes(source.camera)


def _camera_notes(camera: Camera | None) -> list[str]:
    """What `cameras.sensor` leaves to whoever places the samples, and a file cannot say."""
    if camera is None:
        return []
    notes = []
    middle = np.array(camera.shift, float)
    if camera.K is not None:
        (fx, _, cx), (_, fy, cy), _ = camera.K
        middle += np.array([camera.width / 2 - cx, camera.height / 2 - cy])
        if not math.isclose(fx, fy, rel_tol=1e-6):
            notes.append("camera.K: Mitsuba's pixels are as high as they are wide")
    if camera.aperture > 0 and camera.type == "orthographic":
        notes.append("camera.aperture: left out; Mitsuba has no lens for parallel rays")
    elif camera.aperture > 0 and np.abs(middle).max() > 1e-6 * camera.width:
        key = "shift" if camera.K is None else "K"
        notes.append(f"camera.{key}: Mitsuba's lens has no principal point but the middle")
    return notes


def _surface(source: Scene, part: Part, outside: float, notes: list[str]) -> dict[str, Any]:
    """`bsdf`, and `emitter` where the material emits; `outside`: the index around it."""
    material = source.material_of(source.shapes[part.owner])
    place = f"shapes[{part.owner}].material"
    lobes = _lobes(source, material, part, outside, place, notes)
    inner: dict[str, Any] = {"bsdf": _sum(lobes, place, notes)}
    if max(rgb(material.emission)) > 0:
        inner["emitter"] = {"type": "area", "radiance": color(rgb(material.emission))}
        notes.append(
            f"{place}.emission: Mitsuba's emitters shine from their outer side only, and light others"
        )
    return inner


Lobe = tuple[float, Any]
"""How strong a lobe is (its largest band), and a function that makes its plugin so many times as strong."""


def _lobes(
    source: Scene, material: Material, part: Part, outside: float, place: str, notes: list[str]
) -> list[Lobe]:
    lobes: list[Lobe] = []
    if material.diffuse > 0:
        colors = material.color.colors if isinstance(material.color, Checker) else (material.color,)

        def diffuse(scale: float) -> Plugin:
            texture = textures.reflectance(material, scale * material.diffuse, part, source)
            return {"type": "twosided", "inner": {"type": "diffuse", "reflectance": texture}}

        lobes.append((material.diffuse * max(max(rgb(c)) for c in colors), diffuse))
    if material.specular > 0:
        tint = material.specular * np.array(rgb(material.highlight_color))
        notes.append(f"{place}.specular: a rough conductor in place of a Phong highlight")
        roughness = {"distribution": "beckmann", "alpha": float(np.sqrt(2 / (material.shininess + 2)))}
        lobes.append((tint.max(), lambda scale: _mirror("roughconductor", scale * tint, **roughness)))
    mirror = material.kr * np.array(rgb(material.reflection_color))
    clear = material.kt * np.array(rgb(material.transmission_color))
    if material.kt > 0:
        if material.fresnel is not True:
            shares = "Schlick's" if material.fresnel else "constant ones"
            notes.append(f"{place}: Fresnel's shares in place of {shares}")
        if max(rgb(material.absorption)) > 0 and not material.thin:
            notes.append(f"{place}.absorption: left out; Mitsuba's dielectrics are clear")
        boundary = {
            "type": "thindielectric" if material.thin else "dielectric",
            "int_ior": material.ior_d, "ext_ior": outside,
        }  # fmt: skip
        lobes.append((max(mirror.max(), clear.max()), lambda scale: {
            **boundary, "specular_reflectance": color(scale * mirror),
            "specular_transmittance": color(scale * clear),
        }))  # fmt: skip
    elif material.kr > 0:
        if material.fresnel:
            notes.append(f"{place}.fresnel: a mirror that reflects alike at every angle")
        kind, lobe = "conductor", {}
        if material.alpha > 0:
            kind, lobe = "roughconductor", {"distribution": "ggx", "alpha": material.alpha}
        lobes.append((mirror.max(), lambda scale: _mirror(kind, scale * mirror, **lobe)))
    return [lobe for lobe in lobes if lobe[0] > 0]


def _mirror(kind: str, tint: Array, **more: Any) -> Plugin:
    inner = {"type": kind, "material": "none", "specular_reflectance": color(tint), **more}
    return {"type": "twosided", "inner": inner}


def _sum(lobes: list[Lobe], place: str, notes: list[str]) -> Plugin:
    """The sum of lobes: Mitsuba blends with shares of 1, so each is made stronger by what its share takes
    away."""
    total = sum(strength for strength, _ in lobes)
    if not lobes:
        return {"type": "twosided", "inner": {"type": "diffuse", "reflectance": color(0.0)}}
    if total > 1:
        notes.append(f"{place}: reflects more than it gets, which Mitsuba does not allow; weakened")
    scale = min(total, 1.0)
    (strength, first), rest = lobes[0], total
    plugin = first(scale / strength)
    so_far = strength
    for strength, make in lobes[1:]:
        so_far += strength
        blended = {"one": plugin, "two": make(scale / strength)}
        plugin = {"type": "blendbsdf", "weight": strength / so_far, **blended}
    assert so_far <= rest * (1 + 1e-12)
    return plugin


def _light(light: dict[str, Any], look_at: Array, place: str, notes: list[str]) -> Plugin:
    """pi I, as a reflectance of 1 then sends I."""
    if light["near"] and not light["falloff"]:
        notes.append(
            f"{place}.falloff: Mitsuba's lights have one; this one is as bright at the camera's target"
        )
        square = max(float(np.sum((light["at"] - look_at) ** 2)), 1e-12)
        light = light | {"intensity": light["intensity"] * square}
    if not light.get("visible", True):
        notes.append(f"{place}.visible: Mitsuba's lights with extent are seen, and shade")
    if light.get("two_sided", False):
        notes.append(f"{place}.two_sided: Mitsuba's lights shine from their outer side only")
    return surfaces.emitter(light, np.zeros(3), color)


def _sky(source: Scene) -> Plugin | None:
    path = source.background_path
    if path is not None:
        return {"type": "envmap", "filename": str(path), "to_world": skies.HALF_TURN}
    background: Any = source.background
    return {"type": "constant", "radiance": color(rgb(background))} if max(rgb(background)) > 0 else None


__all__ = ["to_mitsuba", "translated"]
