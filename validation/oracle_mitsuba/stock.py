"""Layer A: scenes for Mitsuba's stock plugins, chosen so that their physics is the image model's.

A light of intensity pi I on a reflectance F kd sends I F kd. Where physics has more than the model (light
that goes from surface to surface), a factor of 1e-5 on reflectances and of 1e5 on lights makes it vanish. A
scene is taken only where every material is wholly of one class: then nothing that a configuration does was
written here.

| name | classes of materials | how |
|---|---|---|
| S1 | diffuse | `direct`, a render for each light; they are summed |
| S2 | diffuse, mirror, metals too | `path` with the factor; the background is a render of its own |
| S3 | emitter, mirror, glass | `path`, area emitters and background at once; random |
| S4 | highlight | a mirror in an environment (d.L)^m, on one convex shape |
| S5 | diffuse | S1 times the squared distance of the light: no falloff |
| S6 | diffuse, mirror, sheet | S2 with `mask`: reflects a, lets 1 - a through unbent; random |
| S7 | diffuse | `area` emitters on black shapes out of sight, `direct`, points at random |
| S8 | diffuse, mirror, glass | S2 with `dielectric` and `thindielectric`; random |
| S9 | emitter, mirror, rough, metals too | S3 with `roughconductor`; random, and so are we |
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import cameras, surfaces, textures
from .forms import Array
from .parts import EXACT, Part, geometry, is_endless
from .plugins import Plugin, shape, shifted
from .plugins import rgb as color
from .records import AreaLight, DirectionalLight, Material, Scene, rgb
from .shapes import Ellipsoid, Quadric, Sphere
from .skies import HALF_TURN

LIFT = 1500 * 2.0**-24  # Mitsuba's math::RayEpsilon: of 1 and the largest coordinate
FAINT = 1e-5  # reflectances are this much lower, lights this much stronger
LOBE_ROWS = 1025  # of the environment that is a Phong lobe
# where light goes on from mirrors; the others show what the camera meets
PATHS = ("S2", "S3", "S6", "S8", "S9")
BENDING = {"mirror", "glass", "sheet", "rough"}  # classes from which rays go on


@dataclass(frozen=True)
class Configuration:
    """classes: of materials that it takes. paths: random paths a sample, 1 where nothing is random."""

    classes: frozenset[str]
    paths: int = 1


CONFIGURATIONS = {
    "S1": Configuration(frozenset({"diffuse"})),
    "S2": Configuration(frozenset({"diffuse", "mirror"})),
    "S3": Configuration(frozenset({"emitter", "mirror", "glass"}), 256),
    "S4": Configuration(frozenset({"highlight"})),
    "S5": Configuration(frozenset({"diffuse"})),
    "S6": Configuration(frozenset({"diffuse", "mirror", "sheet"}), 256),
    "S7": Configuration(frozenset({"diffuse"}), 256),
    "S8": Configuration(frozenset({"diffuse", "mirror", "glass"}), 256),
    "S9": Configuration(frozenset({"emitter", "mirror", "rough"}), 256),
}


@dataclass(frozen=True, eq=False)
class Work:
    """Renders for the worker, and what their results are multiplied by before they are summed."""

    name: str
    scene: Scene
    size: tuple[int, int]
    spp: int
    center: Array  # where the renders have their origin
    renders: list[dict[str, Any]]
    light: list[int | None]  # which light a render is for; None: the background's or the emitters'


def material_class(material: Material, scene: Scene) -> str | None:
    """The one class that a material wholly belongs to, or None."""
    lit = material.diffuse > 0 or (material.ka > 0 and max(rgb(scene.ambient)) > 0)
    shines, emits = material.specular > 0, max(rgb(material.emission)) > 0
    if sum([lit, shines, emits, material.kr > 0 or material.kt > 0]) > 1:
        return None
    if material.alpha > 0:
        return "rough" if material.fresnel is False else None
    if material.kr == 0 and material.kt == 0:
        return "highlight" if shines else "emitter" if emits else "diffuse"
    if material.fresnel == "schlick":
        return None
    if material.fresnel is True:
        return "glass"
    if material.kt == 0:
        return "mirror"
    plain = set(rgb(material.reflection_color)) | set(rgb(material.transmission_color)) == {1.0}
    unbent = material.thin or material.ior_d == scene.medium_ior
    return "sheet" if plain and unbent and abs(material.kr + material.kt - 1) < 1e-9 else None


def supports(scene: Scene, name: str) -> str | None:
    """None where configuration `name` can express the scene, else why not."""
    allowed = CONFIGURATIONS[name].classes
    for number, item in enumerate(scene.shapes):
        material = scene.material_of(item)
        if material.pictures:
            return f"shapes[{number}]: pictures are left to the table mode"
        found = material_class(material, scene)
        if found not in allowed:
            return f"shapes[{number}]: its material is not wholly {' or '.join(sorted(allowed))}"
        if isinstance(item, Quadric) and is_endless(item):
            return (
                f"shapes[{number}]: a quadric without an end, whose mesh is too coarse to be taken as it is"
            )
        if found == "diffuse" and material.ka > 0 and max(rgb(scene.ambient)) > 0:
            return f"shapes[{number}]: ambient light, which Mitsuba does not have"
    return _settings_support(scene, name) or _lights_support(scene, name)


def _settings_support(scene: Scene, name: str) -> str | None:
    kinds = {material_class(scene.material_of(item), scene) for item in scene.shapes}
    if scene.camera is not None and scene.camera.aperture > 0 and scene.camera.type == "orthographic":
        return "an orthographic camera with a lens"
    if "glass" in kinds and any(scene.material_of(item).conductor is not None for item in scene.shapes):
        return "a metal and glass, in which it may lie: Mitsuba's metals lie in one medium"
    if scene.one_sided != "none" or (scene.shadow == "tinted" and kinds & {"glass", "sheet"}):
        return "Mitsuba has neither one-sided visibility nor tinted shadows"
    if scene.min_weight > 0 or (max(rgb(scene.depth_color)) > 0 and kinds & BENDING):
        return "Mitsuba has neither min_weight nor depth_color"
    if name not in PATHS and isinstance(scene.background, str):
        return "a background image: these configurations put a colour where nothing is hit"
    if name == "S4":
        if len(scene.shapes) != 1 or not isinstance(scene.shapes[0], (Sphere, Ellipsoid)):
            return "one sphere or ellipsoid alone, so that nothing shades or mirrors anything"
    return None


def _lights_support(scene: Scene, name: str) -> str | None:
    if name in ("S3", "S9"):
        return f"{name} has no point or directional lights" if scene.lights else None
    if not scene.lights and name not in PATHS:
        return "there are no lights"
    for number, light in enumerate(scene.lights):
        if isinstance(light, AreaLight) != (name == "S7"):
            return f"lights[{number}]: S7 is for lights with extent, and the others for those without"
        if isinstance(light, AreaLight):
            if light.two_sided:
                return f"lights[{number}]: Mitsuba's shine on one side"
            continue
        point = not isinstance(light, DirectionalLight)
        if name == "S4" and point:
            return f"lights[{number}]: a point light; the environment needs a directional one"
        if point and light.falloff == "none" and name != "S5":
            return f"lights[{number}]: Mitsuba's light has a falloff (S5 takes it out)"
    return None


def lift(scene: Scene) -> Callable[[Array], Array]:
    """How far (n,) from points (n, 3) of surfaces Mitsuba's plugins start rays (Interaction::offset_p)."""
    center = geometry(scene, EXACT).center
    return lambda point: np.asarray(LIFT * (1 + np.abs(point - center).max(axis=-1)))


def work(scene: Scene, name: str, paths: int | None) -> Work:
    """What the worker has to render for a picture from the scene's camera."""
    depth, camera = scene.max_depth, scene.camera
    assert camera is not None
    size, spp = (camera.width, camera.height), camera.spp
    world = geometry(scene, EXACT)
    found = Work(name, scene, size, spp, world.center, [], [])
    parts = [textures.shaped(part, scene) for part in world.parts]
    base = cameras.view(scene, *size, spp, world.size, world.center)
    base["positions"] = base["positions"].reshape(-1, 2)
    if base["lens"] is not None:
        base["lens"] = base["lens"].reshape(-1, 2)
        base["eye"] = None if base["eye"] is None else base["eye"].reshape(-1, 3)
    base["spp"] = spp
    base["paths"] = paths or CONFIGURATIONS[name].paths

    def add(children: dict[str, Plugin], integrator: Plugin, light: int | None) -> None:
        children["sensor"] = base["sensor"]
        owners = {name: int(name.split("_")[1]) for name in children if name.startswith("shape_")}
        job = {
            "scene": {"type": "scene", **children},
            "integrator": integrator,
            "owners": owners,
            "seed": len(found.renders),
        }
        found.renders.append(base | job)
        found.light.append(light)

    for index, source in enumerate(surfaces.lights(scene)):
        children = _shapes(scene, parts, world.center, FAINT if name in PATHS else 1.0)
        lamp = surfaces.emitter(source, world.center, color) if name != "S4" else _lobe(scene, source)
        children["light"] = lamp
        if name in PATHS:
            add(_strengthened(children), _path(depth + 2), index)
        else:
            by_light = int(name != "S4")
            add(
                children, {"type": "direct", "emitter_samples": by_light, "bsdf_samples": 1 - by_light}, index
            )
    if name in PATHS:
        sky = {"type": "sky", "background": surfaces.background(scene)}
        add(_shapes(scene, parts, world.center, 0.0) | {"sky": sky}, _path(depth + 1), None)
    return found


def _path(depth: int) -> Plugin:
    return {"type": "path", "max_depth": depth, "rr_depth": 100_000}


def _shapes(scene: Scene, parts: list[Part], center: Array, faint: float) -> dict[str, Plugin]:
    """All shapes; `faint` scales what diffuse ones reflect, which are black in the background's render."""
    children = {}
    for index, part in enumerate(parts):
        material = scene.material_of(scene.shapes[part.owner])
        inner: dict[str, Any] = {"bsdf": _bsdf(material, scene, part, faint)}
        if faint == 0 and max(rgb(material.emission)) > 0:
            inner["emitter"] = {"type": "area", "radiance": color(rgb(material.emission))}
        placed = shape(shifted(part, -center), **inner)
        children[f"shape_{part.owner}_{index}"] = textures.dressed(placed, part, scene, center)
    return children


def _bsdf(material: Material, scene: Scene, part: Part, faint: float) -> Plugin:
    """The stock plugin of a material's class."""
    kind = material_class(material, scene)
    tints = {
        "specular_reflectance": color(np.multiply(material.kr, rgb(material.reflection_color))),
        "specular_transmittance": color(np.multiply(material.kt, rgb(material.transmission_color))),
    }
    if kind == "glass":
        plugin = "thindielectric" if material.thin else "dielectric"
        return {"type": plugin, "int_ior": material.ior_d, "ext_ior": float(scene.medium_ior), **tints}
    if kind == "mirror":
        return _mirror(tints["specular_reflectance"], _index(material, scene))
    if kind == "rough":
        facets = {"distribution": "ggx", "alpha": material.alpha, "sample_visible": True}
        return _mirror(tints["specular_reflectance"], _index(material, scene), **facets)
    if kind == "highlight":
        return _mirror(color(np.multiply(material.specular, rgb(material.highlight_color))))
    if kind == "sheet":
        return {"type": "mask", "opacity": material.kr, "inner": _mirror(color(1.0))}
    texture = textures.reflectance(material, faint * material.diffuse, part, scene)
    return {"type": "twosided", "inner": {"type": "diffuse", "reflectance": texture}}


def _mirror(tint: Plugin, index: Plugin | None = None, **facets: Any) -> Plugin:
    """What reflects `tint`, or a metal of this `index`; with `facets` it is rough."""
    kind = "roughconductor" if facets else "conductor"
    inner = {"type": kind, "specular_reflectance": tint, **(index or {"material": "none"}), **facets}
    return {"type": "twosided", "inner": inner}


def _index(material: Material, scene: Scene) -> Plugin | None:
    """A metal's eta and k over the index around it; None for what has none."""
    if material.conductor is None:
        return None
    eta, k = surfaces.COLORS.metal(material.conductor)
    outer = float(scene.medium_ior)
    return {"eta": color(eta / outer), "k": color(k / outer)}


def _strengthened(children: dict[str, Plugin]) -> dict[str, Plugin]:
    """The scene with its light 1 / FAINT times as strong."""
    light = dict(children["light"])
    for key in ("intensity", "irradiance"):
        if key in light:
            light[key] = color(np.array(light[key]["value"]) / FAINT)
    return children | {"light": light}


def _lobe(scene: Scene, source: dict[str, Any]) -> Plugin:
    """The environment I (d.L)^m: what a mirror shows of it is the highlight I (R.V)^m."""
    rows, columns = LOBE_ROWS, 2 * (LOBE_ROWS - 1)
    theta = np.pi * np.arange(rows) / (rows - 1)
    phi = 2 * np.pi * ((np.arange(columns) + 0.5) / columns - 0.5)
    across, down = np.meshgrid(phi, theta)
    direction = np.stack([np.sin(down) * np.sin(across), np.cos(down), -np.sin(down) * np.cos(across)], -1)
    aligned = np.maximum(direction @ source["at"], 0.0)
    m = scene.material_of(scene.shapes[0]).shininess
    lobe = np.where(aligned > 0, aligned**m, 0.0)
    return {"type": "envmap", "bitmap": lobe[..., None] * source["intensity"], "to_world": HALF_TURN}


def finish(work: Work, answers: list[dict[str, Any]]) -> dict[str, Any]:
    """The picture: the sum of the renders, the scene's background where nothing is hit; of random paths also
    the standard `error` (h, w, 3)."""
    total, variance = np.zeros_like(answers[0]["mean"]), np.zeros_like(answers[0]["mean"])
    sources = surfaces.lights(work.scene)
    for answer, light in zip(answers, work.light, strict=True):
        factor = np.ones(len(total))
        if work.name == "S4" and light is not None:
            factor = (answer["normal"] @ sources[light]["at"] > 0).astype(float)
        if (
            work.name == "S5"
            and light is not None
            and not sources[light]["falloff"]
            and sources[light]["near"]
        ):
            factor = np.sum((answer["point"] - (sources[light]["at"] - work.center)) ** 2, axis=1)
        total += np.where(np.isfinite(answer["t"]), factor, work.name in PATHS)[:, None] * answer["mean"]
        if answer["error"] is not None:
            variance += answer["error"] ** 2
    t, shape = answers[0]["t"], answers[0]["shape"]
    if work.name not in PATHS:
        total[~np.isfinite(t)] = surfaces.background(work.scene)
    width, height = work.size
    n = width * height

    def averaged(samples: Array, shares: Array) -> Array:
        weighed = shares[..., None] * samples.reshape(work.spp, n, 3)
        return np.asarray(weighed.sum(axis=0).reshape(height, width, 3))

    t, shape = t[:n].reshape(height, width), shape[:n].reshape(height, width)
    shares = answers[0]["shares"]
    found = {"pixels": averaged(total, shares), "by_ray": {}, "t": t, "shape": shape}
    if CONFIGURATIONS[work.name].paths > 1:
        found["error"] = np.sqrt(averaged(variance, shares**2))
    return found
