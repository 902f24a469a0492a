"""The oracle's public functions: pictures, hits and radiances in float64."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import msgspec
import numpy as np

from clrt.scene.arealights import AreaLight
from clrt.scene.scene import Camera, Checker, Scene, Sphere

from . import hashing
from .camera import Background, camera_rays, cones
from .film import ROUTES, TERMS, Film, Rays
from .filters import offsets, shares
from .media import around
from .palette import Palette
from .radiance import Job, radiance
from .spot import Met, spot_at, visible_hit
from .tree import LEAF
from .vectors import Array, Bools, Ints, Words, unit
from .world import Lift, World, nearest_hit

BLOCK = 1 << 15  # rays of three bands that go through the recursion together
GEOMETRY = ("depth", "z", "distance", "position", "normal", "shading_normal", "albedo", "uv", "shape",
            "material")  # layers of the first sample  # fmt: skip


@dataclass(frozen=True)
class Hits64:
    """Nearest hits of n rays; a miss has t = inf, primitive = shape = -1 and a zero normal."""

    t: Array
    primitive: Ints
    shape: Ints
    normal: Array  # (n, 3): outward geometric unit normal
    position: Array  # (n, 3)


@dataclass(frozen=True)
class Result64:
    """A picture: `pixels` (h, w, 3) linear radiance, `layers` by name, `stats` with rays and generations.

    `by_ray`: what the rays of each generation and kind bring, (h, w, 3) by "generation 2 reflection" etc.
    `bands` (h, w, bands): the picture before it is developed; the pixels themselves in RGB mode.
    `samples` (spp, h, w, 3): what each of a pixel's samples sees.
    """

    pixels: Array
    layers: dict[str, Any] = field(default_factory=dict)
    stats: dict[str, Any] = field(default_factory=dict)
    by_ray: dict[str, Array] = field(default_factory=dict)
    bands: Array = field(default_factory=lambda: np.zeros((0, 0, 0)))
    samples: Array = field(default_factory=lambda: np.zeros((0, 0, 0, 3)))


def trace64(scene: Scene, origins: Any, directions: Any, leaf: int = LEAF) -> Hits64:
    """Nearest hits of rays (n, 3), directions of any length; a zero or NaN direction misses.

    `leaf`: primitives in a leaf of the tree; as many as the scene has is brute force.
    """
    with np.errstate(all="ignore"):
        origin = np.asarray(origins, float).reshape(-1, 3)
        world, direction = World.of(scene, leaf), unit(directions).reshape(-1, 3)
        return _hits(world, origin, direction, *nearest_hit(world, origin, direction))


def _hits(world: World, origin: Array, direction: Array, t: Array, primitive: Ints) -> Hits64:
    hit = primitive >= 0
    shape = np.full(len(t), -1)
    normal, position = np.zeros_like(origin), np.zeros_like(origin)
    if hit.any():
        count = np.count_nonzero(hit)
        nothing = np.full((count, 0), -1)
        path, pixel = hashing.word(np.zeros(count)), np.arange(count)
        rays = _fresh(world, origin[hit], direction[hit], path, pixel, nothing)
        spot = spot_at(world, rays, Met(t[hit], primitive[hit], nothing, nothing))
        shape[hit], normal[hit], position[hit] = world.shown[spot.shape], spot.outward, spot.point
    return Hits64(t, primitive, shape, normal, position)


def media_at(scene: Scene, points: Any) -> Ints:
    """The media that points (n, 3) are inside of, (n, k), -1 in unused places: as rays that start there have.

    Media are numbered as the materials that bound them come up in the scene, equal ones as one.
    """
    world = World.of(scene)
    with np.errstate(all="ignore"):
        return around(world.batches, world.shape_of, world.media, np.asarray(points, float).reshape(-1, 3))


def radiance64(
    scene: Scene, origins: Any, directions: Any, max_depth: int | None = None
) -> tuple[Array, dict[str, Any]]:
    """Radiance (n, bands) along rays (n, 3), and `stats` as of a picture.

    Ray i hashes like pixel i of seed 0.
    """
    origin = np.asarray(origins, float).reshape(-1, 3)
    with np.errstate(all="ignore"):
        job = _job(scene, len(origin), max_depth)
        light = np.zeros((len(origin), job.world.palette.bands))
        direction = unit(directions).reshape(-1, 3)
        for pixel in _blocks(len(origin)):
            h = hashing.camera_path(0, pixel, 0)
            rays = _fresh(job.world, origin[pixel], direction[pixel], hashing.key(h), pixel)
            light[pixel] = radiance(job, rays, 0)
    return light, _stats(job)


def render64(
    scene: Scene,
    width: int | None = None,
    height: int | None = None,
    spp: int | None = None,
    max_depth: int | None = None,
    layers: Iterable[str] = (),
    shift: tuple[float, float] = (0.0, 0.0),
    lift: Lift | None = None,
) -> Result64:
    """The scene's picture. What is None is the camera's or the scene's; `shift` (pixels) moves samples.

    One of width and height alone keeps the camera's aspect. lift: as of World.

    layers: ROUTES, generation_0 ..., TERMS and GEOMETRY as clrt's own; alpha (h, w); crypto_shape is the part
    of the samples that hits each shape, and after them each light, (h, w, numbers).
    ValueError where the scene has no camera, `spp` is not square or a layer is unknown.
    """
    if scene.camera is None:
        raise ValueError("the scene has no camera")
    width, height = _size(scene.camera, width, height)
    camera = _shifted(scene.camera, shift, (width, height))
    spp = spp or camera.spp
    grid = math.isqrt(spp)
    if grid * grid != spp:
        raise ValueError(f"spp = {spp} is not a square number")
    with np.errstate(all="ignore"):
        apart = grid**2 if camera.filter != "box" else 1  # sums of a pixel in the film, one a sample
        job = _job(scene, width * height * apart, max_depth, lift)
        light = _sampled(job, camera, (width, height), grid, np.arange(width * height))
        counts = shares(camera, grid, width * height)
        film = job.film
        found = {name: film.developed(_weighed(counts[:apart], of)) for name, of in film.layers.items()}
        if set(layers) & set(GEOMETRY):
            found |= _geometry(job.world, scene, camera, (width, height), grid)
        numbers = len(scene.shapes) + len(scene.lights)
        found["samples"] = np.full(width * height, grid**2)
        if "alpha" in layers:
            found["alpha"] = np.clip(_weighed(counts[:apart], job.film.hit())[:, 0], 0, 1)
        if "crypto_shape" in layers:
            found["crypto_shape"] = _weighed(counts[:apart], job.film.covered(numbers))
    picked = {name: _layer(name, found, job.max_depth, (height, width)) for name in layers}
    by_ray = {name: found[name].reshape(height, width, 3) for name in sorted(found) if " " in name}
    bands = _weighed(counts, light).reshape(height, width, -1)
    developed = job.world.palette.developed
    samples = developed(light).reshape(-1, height, width, 3)
    return Result64(developed(bands), picked, _stats(job), by_ray, bands, samples)


def _weighed(counts: Array, light: Array) -> Array:
    """(n, k) of what samples bring, (spp, n, k) or sample after sample, by what each counts for, (spp, n)."""
    return np.asarray(np.einsum("sn,snk->nk", counts, light.reshape(*counts.shape, -1)))


def _sampled(job: Job, camera: Camera, size: tuple[int, int], grid: int, pixel: Ints) -> Array:
    """Radiances (grid**2, n, bands) of all samples of these pixels (n,); many samples share a block."""
    light = np.zeros((grid * grid * len(pixel), job.world.palette.bands))
    block = max(1 << 12, BLOCK * 3 // light.shape[1])  # rays of many bands take more memory
    for rows in np.split(np.arange(len(light)), range(block, len(light), block)):
        sample, place = np.divmod(rows, len(pixel))
        seen = _camera_block(job.world, camera, size, grid, sample, pixel[place])
        if camera.filter != "box":
            seen = replace(seen, pixel=rows)
        light[rows] = radiance(job, seen, 0)
    return light.reshape(grid * grid, len(pixel), -1)


def _shifted(camera: Camera, shift: tuple[float, float], size: tuple[int, int]) -> Camera:
    """The camera with `shift`, in pixels of a picture of `size`, added to its own."""
    x, y = shift[0] * (camera.width / size[0]), shift[1] * (camera.height / size[1])
    return msgspec.structs.replace(camera, shift=(camera.shift[0] + x, camera.shift[1] + y))


def edge_mask(
    scene: Scene,
    width: int | None = None,
    height: int | None = None,
    spp: int | None = None,
    max_depth: int | None = None,
    reference: Array | None = None,
    step: float = 0.05,
    change: float = 2e-3,
    together: bool = False,
) -> Bools:
    """Pixels (h, w) where a sample moves by more than `change` under four diagonal shifts of `step` pixel.

    Of what is brighter than 1 by more than that part of it.

    `reference`: the picture's samples (spp, h, w, 3), where they are at hand.

    Samples are asked for, not their mean: rounding takes one sample across an edge as easily where a pixel
    has others, and in the mean a jump of less than spp times `change` would not show. `together`: what a
    pixel's samples move by on average counts, whatever its sign.
    """
    if reference is None:
        reference = render64(scene, width, height, spp, max_depth).samples
    assert scene.camera is not None
    size, grid = (reference.shape[2], reference.shape[1]), math.isqrt(reference.shape[0])
    still = reference.reshape(len(reference), -1, 3)
    mask = np.zeros(still.shape[1], bool)
    with np.errstate(all="ignore"):
        job = replace(_job(scene, still.shape[1], max_depth), film=Film(0, Palette.of(scene)))
        for x, y in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            asked = np.flatnonzero(~mask)  # one shift that moves a pixel is enough
            if not len(asked):
                break
            camera = _shifted(scene.camera, (x * step, y * step), size)
            moved = job.world.palette.developed(_sampled(job, camera, size, grid, asked))
            moves = np.abs(moved - still[:, asked]) / np.maximum(np.abs(still[:, asked]), 1.0)
            if together:
                moves = moves.mean(axis=0, keepdims=True)
            mask[asked] = (moves > change).any(axis=(0, 2))
    return mask.reshape(reference.shape[1:3])


def _size(camera: Camera, width: int | None, height: int | None) -> tuple[int, int]:
    if width is None and height is None:
        return camera.width, camera.height
    return (
        width or max(1, round((height or 1) * camera.width / camera.height)),
        height or max(1, round((width or 1) * camera.height / camera.width)),
    )


def _job(scene: Scene, pixels: int, max_depth: int | None, lift: Lift | None = None) -> Job:
    depth = scene.max_depth if max_depth is None else max_depth
    world = World.of(scene, lift=lift)
    return Job(world, scene, Background(scene, world.palette), depth, Film(pixels, world.palette))


def _blocks(count: int) -> list[Ints]:
    return [np.arange(start, min(start + BLOCK, count)) for start in range(0, count, BLOCK)]


def _camera_block(
    world: World, camera: Camera, size: tuple[int, int], grid: int, sample: Any, pixel: Ints
) -> Rays:
    """Samples (n, or one for all) of these pixels: a grid of cells, their centres or jittered points."""
    width, height = size
    h = hashing.camera_path(camera.jitter or 0, pixel, sample)
    right, down = offsets(camera, grid, pixel, sample)
    x, y = np.asarray(pixel % width + 0.5 + right, float), np.asarray(pixel // width + 0.5 + down, float)
    seed = camera.jitter or 0
    lens = hashing.lens(seed, pixel, sample)
    origin, direction = camera_rays(camera, width, height, x, y, lens)
    rays = _fresh(world, origin, direction, hashing.key(h), pixel, seed=seed, sample=sample)
    return replace(rays, cone=cones(camera, width, height, grid, direction))


def _fresh(world: World, origin: Array, direction: Array, path: Words, pixel: Ints,
           media: Ints | None = None, seed: int = 0, sample: Any = 0) -> Rays:  # fmt: skip
    """Rays of all bands that start in the media that are there."""
    if media is None:
        media = around(world.batches, world.shape_of, world.media, origin)
    weight = np.ones((len(pixel), world.palette.bands))
    base = hashing.combine(hashing.word(np.full(len(pixel), seed)), pixel)
    sample = np.broadcast_to(sample, len(pixel))
    cone = np.zeros((len(pixel), 2))
    return Rays(origin, direction, weight, path, pixel, media, np.full(len(pixel), -1), base, sample, cone)


def _geometry(world: World, scene: Scene, camera: Camera, size: tuple[int, int], grid: int) -> dict[str, Any]:
    """The layers of the first sample's hits."""
    n = size[0] * size[1]
    out: dict[str, Any] = {name: np.zeros((n, 3)) for name in GEOMETRY}
    out |= {name: np.full(n, math.inf) for name in ("depth", "z", "distance")}
    out |= {name: np.full(n, -1) for name in ("shape", "material")}
    out["uv"] = np.zeros((n, 2))
    material = _numbered(scene)
    eye = np.asarray(camera.origin, float)
    forward = unit(np.asarray(camera.target, float) - eye)
    for pixel in _blocks(n):
        rays = _camera_block(world, camera, size, grid, 0, pixel)
        met = visible_hit(world, rays)
        hit = np.flatnonzero(met.primitive >= 0)
        if not hit.size:
            continue
        spot, to = spot_at(world, rays[hit], met[hit]), pixel[hit]
        away = spot.point - eye
        out["depth"][to], out["z"][to] = met.t[hit], away @ forward
        flat = camera.type == "orthographic"
        out["distance"][to] = away @ forward if flat else np.sqrt((away**2).sum(axis=1))
        out["position"][to], out["normal"][to], out["shading_normal"][to] = spot.point, spot.outward, spot.ns
        out["albedo"][to] = world.palette.under_white(world.surfaces.kd[spot.shape, None] * spot.color)
        out["uv"][to] = world.images.places(spot.shape, met.primitive[hit], spot.point, spot.outward)
        out["shape"][to], out["material"][to] = world.shown[spot.shape], material[world.shown[spot.shape]]
    return out


def _numbered(scene: Scene) -> Ints:
    """The number of the material of each shape, and then of each visible light's surface, by first use."""
    known: list[Any] = []
    found = np.full(len(scene.shapes) + len(scene.lights), -1)
    for place, shape in enumerate(scene.shapes):
        of = scene.material_of(shape)
        thing: Any = _same(of), isinstance(of.color, Checker) and isinstance(shape, Sphere)
        if thing not in known:
            known.append(thing)
        found[place] = known.index(thing)
    for place, light in enumerate(scene.lights, len(scene.shapes)):
        if isinstance(light, AreaLight) and light.visible:
            thing = light.radiance, light.two_sided
            if thing not in known:
                known.append(thing)
            found[place] = known.index(thing)
    return found


def _same(material: Any) -> dict[str, Any]:
    """What makes materials equal: a number stands for three of it, a name of a glass for its index."""
    of = msgspec.structs.asdict(material)
    tints = (f"{name}_color" for name in ("highlight", "reflection", "transmission"))
    for name in ("color", *tints, "emission", "absorption"):
        of[name] = (float(of[name]),) * 3 if isinstance(of[name], (int, float)) else of[name]
    return of | {"ior": material.ior_d}


def _layer(name: str, found: dict[str, Any], max_depth: int, size: tuple[int, int]) -> Any:
    """A layer as an image; one of the light that nothing reached is black."""
    numbered = (f"generation_{k}" for k in range(max_depth + 1))
    known = (*ROUTES, *TERMS, *GEOMETRY, "samples", "alpha", "crypto_shape", *numbered)
    if name not in known:
        raise ValueError(f"{name} is not a layer; there are {', '.join(known)}")
    layer = found.get(name, np.zeros((size[0] * size[1], 3)))
    return layer.reshape(*size, *layer.shape[1:])


def _stats(job: Job) -> dict[str, Any]:
    return {"rays": job.film.totals, "generations": job.film.generations}
