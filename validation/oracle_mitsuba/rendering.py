"""A scene's picture by each mode (worker process)."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import cameras, stock, surfaces
from .adaptive import refined
from .hashing import combine
from .insides import starting
from .lobes import Lobes
from .modes import SPECTRAL
from .palette import Bands, triples
from .parts import POLISHED, geometry
from .pictures import Pictures
from .plugins import packed
from .records import Scene
from .sensors import camera_rays, shares, stock_render
from .surfaces import COLORS, Palette
from .table import Table
from .whitted import Rays, trace

Array = np.ndarray
BLOCK = 1 << 19  # camera rays traced together


def picture(scene: Scene, mode: str, paths: int | None) -> dict[str, Any]:
    """`pixels` (h, w, 3), `by_ray`, `t` and `shape` (h, w), of random paths `error`."""
    if mode == SPECTRAL:
        return _spectral(scene)
    if mode.startswith("stock-"):
        work = stock.work(scene, mode.removeprefix("stock-"), paths)
        return stock.finish(work, [stock_render(render) for render in work.renders])
    world = packed(geometry(scene, POLISHED))
    if scene.adaptive is not None:
        return refined(scene, lambda even: _layer_b(even, mode, world, COLORS, normals=True))
    return _layer_b(scene, mode, world, COLORS)


def radiance(scene: Scene, mode: str, origin: Array, direction: Array) -> Array:
    """Radiance (n, 3) along rays (n, 3)."""
    direction = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    pixels = np.arange(len(origin))
    job = _job(scene, mode, packed(geometry(scene, POLISHED)), COLORS)
    start = _start(scene, job, origin)
    sums: dict[str, Array] = {}
    base, sample = combine(np.uint32(0), pixels), np.zeros(len(pixels), np.uint32)
    _trace(_shader(job), origin, direction, pixels, (base, sample), start, len(pixels), sums)
    return np.asarray(sum(sums[name] for name in _whole(sums)))


def _spectral(scene: Scene) -> dict[str, Any]:
    """Three bands at a time; one at a time where metals or dispersion have numbers of their own in each."""
    assert scene.spectrum is not None
    wanted, world = scene.spectrum, packed(geometry(scene, POLISHED))
    used = [scene.material_of(shape) for shape in scene.shapes]
    alone = any(m.varies or m.conductor is not None for m in used)
    found: dict[str, Array] = {}
    first: dict[str, Any] = {}
    for bands in triples(wanted, alone):
        answer = _layer_b(scene, "table", world, Bands(wanted, bands))
        first = first or answer
        for name, light in {**answer["by_ray"], "": answer["pixels"]}.items():
            found.setdefault(name, np.zeros((*light.shape[:2], wanted.bands)))[..., list(bands)] = light
    to_rgb = Bands(wanted).to_rgb.T
    by_ray = {name: bands @ to_rgb for name, bands in found.items()}
    return {"pixels": by_ray.pop(""), "by_ray": by_ray, "t": first["t"], "shape": first["shape"]}


def _job(scene: Scene, mode: str, world: dict[str, Any], palette: Palette) -> dict[str, Any]:
    """What a shader is made of."""
    return {
        "mode": mode, "geometry": world, "materials": surfaces.materials(scene, palette),
        "media": surfaces.media(scene, palette), "lights": surfaces.lights(scene, palette),
        "settings": surfaces.settings(scene, palette), "pictures": Pictures(scene, palette),
    }  # fmt: skip


def _start(scene: Scene, job: dict[str, Any], origin: Array) -> Array:
    """The states of media (media.Media) of rays from origins (n, 3)."""
    job["states"], start = starting(scene, job["media"]["number"], origin)
    return start


def _layer_b(scene: Scene, mode: str, world: dict[str, Any], palette: Palette,
             normals: bool = False) -> dict[str, Any]:  # fmt: skip
    """normals: also the outward `normal` of each pixel's first sample."""
    camera = scene.camera
    assert camera is not None
    width, height, spp = camera.width, camera.height, camera.spp
    job = _job(scene, mode, world, palette)
    view = cameras.view(scene, width, height, spp, world["size"], world["center"])
    positions = view["positions"].reshape(-1, 2)
    lens = None if view["lens"] is None else view["lens"].reshape(-1, 2)
    eye = view["eye"] if view["eye"] is None or lens is None else view["eye"].reshape(-1, 3)
    thin = lens if camera.type == "perspective" else None
    origin, direction = camera_rays(view["sensor"], eye, positions, thin)
    if lens is not None and thin is None:
        origin, direction = cameras.bent(camera, origin, direction, lens)
    origin = origin + world["center"]
    cone = cameras.cones(camera, direction)
    one_eye = eye is not None and lens is None
    start = _start(scene, job, np.asarray(camera.origin, float)[None] if one_eye else origin)
    start = np.broadcast_to(start, len(positions))
    shader, pixels = _shader(job), width * height
    weighed = view["off"] is not None  # each sample is then summed by itself
    sums: dict[str, Array] = {}
    t, shape = np.full(len(positions), np.inf), np.full(len(positions), -1)
    normal = np.zeros((len(positions), 3))
    for begin in range(0, len(positions), BLOCK):
        block = np.arange(begin, min(begin + BLOCK, len(positions)))  # sample by sample
        sample, pixel = np.divmod(block, pixels)
        streams = combine(np.uint32(view["seed"]), pixel), sample
        place, places = (block, len(positions)) if weighed else (pixel, pixels)
        rays = origin[block], direction[block], place, streams, start[block]
        first = _trace(shader, *rays, places, sums, cone[block])
        t[block], shape[block], normal[block] = first.t, first.shape, first.outward
    if weighed:
        counts = shares(view["sensor"], view["off"], spp, pixels)
        means = {k: np.einsum("sn,snk->nk", counts, v.reshape(spp, pixels, -1)) for k, v in sums.items()}
    else:
        means = {name: total / spp for name, total in sums.items()}
    by_ray = {name: mean.reshape(height, width, 3) for name, mean in means.items()}
    whole = np.sum([by_ray[name] for name in _whole(sums)], axis=0)
    first_sample = {"t": t[:pixels].reshape(height, width), "shape": shape[:pixels].reshape(height, width)}
    more = {"normal": normal[:pixels].reshape(height, width, 3)} if normals else {}
    return {"pixels": whole, "by_ray": by_ray, **first_sample, **more}


def _whole(sums: dict[str, Any]) -> list[str]:
    """The names of sums that are not parts of others: "generation 0 camera", not "generation 0 camera
    diffuse"."""
    return [name for name in sums if len(name.split()) == 3]


def _shader(job: dict[str, Any]) -> Table:
    return Lobes(job) if job["mode"] == "bsdf" else Table(job)


def _trace(shader: Any, origin: Any, direction: Any, pixel: Any, streams: Any, media: Any, pixels: int,
           sums: Any, cone: Any = None) -> Any:  # fmt: skip
    cone = np.zeros((len(pixel), 2)) if cone is None else cone
    nowhere, path = np.full(len(pixel), -1), combine(*streams) & ~np.uint32(15)
    base, sample = streams
    own = pixel, path, nowhere, media, base, sample, cone
    rays = Rays(origin, direction, np.ones_like(direction), *own)
    with np.errstate(divide="ignore", invalid="ignore"):
        return trace(shader, rays, pixels, sums)
