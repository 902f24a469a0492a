"""What each mode can express, what the worker is asked for it, and what its answer means."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from clrt.scene.scene import Checker, Mesh, Scene

from ..oracle64 import media_at
from ..oracle64.camera import camera_rays
from ..types import OracleImage
from . import stock, surfaces
from .hashing import camera_words
from .parts import POLISHED, geometry
from .plugins import packed

LAYER_B = ("table", "bsdf")
MODES = (*LAYER_B, *(f"stock-{name}" for name in stock.CONFIGURATIONS))


@dataclass(frozen=True, eq=False)
class Plan:
    """A task of the worker, and what makes a picture of its answer, a name and the seconds it took."""

    task: str
    job: dict[str, Any]
    finish: Callable[[Any, str, float], OracleImage]


def supports(scene: Scene, mode: str) -> str | None:
    """None where `mode` can express the scene, else why not."""
    if mode not in MODES:
        return f"unknown mode; the modes are {', '.join(MODES)}"
    for number, shape in enumerate(scene.shapes):
        if isinstance(shape, Mesh) and not len(shape.data().faces):
            return f"shapes[{number}]: a mesh without faces"
    if scene.spectrum is not None:
        return "Mitsuba has three bands; ask wavelength by wavelength"
    if mode == "table":
        return None
    return _bsdf_supports(scene) if mode == "bsdf" else stock.supports(scene, mode.removeprefix("stock-"))


def _bsdf_supports(scene: Scene) -> str | None:
    """Mitsuba's own plugins have no Phong lobe and no Schlick mirror."""
    if scene.ambient_samples:
        return "Mitsuba has no ambient rays (ambient_samples)"
    if scene.shadow == "tinted":
        return "Mitsuba has no tinted shadows"
    for number, shape in enumerate(scene.shapes):
        material = scene.material_of(shape)
        if material.specular > 0 and scene.lights:
            return f"shapes[{number}]: Mitsuba has no Phong highlight (specular > 0)"
        if material.fresnel == "schlick":
            return f"shapes[{number}]: Mitsuba has no mirror by Schlick's formula"
        if isinstance(material.color, Checker):
            return f"shapes[{number}]: checkers are left to the table mode"
    return None


def plan(scene: Scene, width: int | None, height: int | None, mode: str, spp: int,
         max_depth: int | None, paths: int | None) -> Plan:  # fmt: skip
    """What to ask the worker for a picture. ValueError without a camera."""
    camera = scene.camera
    if camera is None:
        raise ValueError("the scene has no camera")
    size = _size(camera.width, camera.height, width, height)
    if mode in LAYER_B:
        job = _job(scene, mode, max_depth)
        job |= surfaces.view(scene, *size, spp, job["geometry"]["size"], job["geometry"]["center"])
        x, y = np.moveaxis(job["positions"] * size, -1, 0).reshape(2, -1)
        job |= _starting(scene, camera_rays(camera, *size, x, y)[0].reshape(spp, -1, 3))
        return Plan("picture", job, lambda answer, name, seconds: _image(answer, size, name, seconds))
    name = mode.removeprefix("stock-")
    work = stock.work(scene, name, size, spp, max_depth, paths)
    return Plan("stock", {"renders": work.renders}, lambda *answer: stock.finish(work, *answer))


def radiance_job(
    scene: Scene, origins: Any, directions: Any, mode: str, max_depth: int | None
) -> dict[str, Any]:
    """What to ask the worker for the radiance along rays (n, 3)."""
    origin = np.asarray(origins, float).reshape(-1, 3)
    direction = np.asarray(directions, float).reshape(-1, 3)
    direction = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    paths = camera_words(0, np.arange(len(origin)), 0)
    rays = {"origin": origin, "direction": direction, "paths": paths}
    return _job(scene, mode, max_depth) | rays | _starting(scene, origin[None])


def _starting(scene: Scene, origin: np.ndarray) -> dict[str, Any]:
    """The states of media (media.Media) in which rays from origins (spp, n, 3) start.

    Where a point is inside of is asked of the float64 oracle, which the kernels' host does not use either.
    """
    lists, place = np.unique(media_at(scene, origin.reshape(-1, 3)), axis=0, return_inverse=True)
    each = [tuple(int(medium) for medium in row if medium >= 0) for row in lists]
    states = list(dict.fromkeys([(), *each]))  # the surroundings are state 0
    first = np.array([states.index(state) for state in each])
    return {"states": states, "start": first[place.ravel()].reshape(origin.shape[:2])}


def _job(scene: Scene, mode: str, max_depth: int | None) -> dict[str, Any]:
    world = geometry(scene, POLISHED)
    return {
        "mode": mode, "geometry": packed(world), "materials": surfaces.materials(scene),
        "media": surfaces.media(scene),
        "lights": surfaces.lights(scene), "settings": surfaces.settings(scene, max_depth),
    }  # fmt: skip


def _image(answer: dict[str, Any], size: tuple[int, int], name: str, seconds: float) -> OracleImage:
    width, height = size
    by_ray = {kind: total.reshape(height, width, 3) for kind, total in answer["by_ray"].items()}
    pixels = np.sum([by_ray[kind] for kind in answer["whole"]], axis=0)
    t, shape = (answer[key].reshape(height, width) for key in ("t", "shape"))
    return OracleImage(pixels, by_ray, t, shape, name, seconds)


def _size(camera_width: int, camera_height: int, width: int | None, height: int | None) -> tuple[int, int]:
    if width is None and height is None:
        return camera_width, camera_height
    if width is None:
        assert height is not None
        return max(1, round(height * camera_width / camera_height)), height
    return width, height or max(1, round(width * camera_height / camera_width))
