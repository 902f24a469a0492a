"""The picture once more in numpy, float32, bit for bit what the kernels give: `clrt selftest` compares them.

It reads the flattened scene, as the kernels do, and goes by the formulas of docs/model.md in the same order
of operations, but by brute force and over whole arrays of rays.

    twin_math       vectors, elementary functions, hashes
    twin_geometry   where rays meet primitives
    twin_surface    point, normals and colour at a hit; background
    twin_shading    light, reflection and transmission at a surface
    twin_media      lists of media, the boundaries that they hide, absorption
    twin_queues     camera rays, rays of the caller
    twin_local      the passes `shade` and `feelers`
    twin_wavefront  children, and the loop over generations
    twin_film       sums and layers
    twin_compare    a device and the twin, stage by stage
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from clrt import layout
from clrt.base.layers import Geometry, comes_from
from clrt.flatten.flatten import FlatScene, flatten, flatten_camera
from clrt.scene.scene import Scene

from .film import Film, developed
from .geometry import Hits, nearest_hit, primitives_of
from .math import dot
from .media import first_seen
from .queues import Queue, adopt, generate, weights
from .surface import color_of, surface_at
from .wavefront import generations

_CHUNK = 1 << 14  # camera rays at a time
_KINDS = (
    "camera",
    "camera_hits",
    "reflection",
    "transmission",
    "ambient",
    "total_internal_reflection",
    "feelers",
    "hits",
)


@dataclass(frozen=True)
class Result32:
    """pixels: (height, width, 3) float32; layers by name and stats of rays as in `clrt.Image`."""

    pixels: np.ndarray
    layers: dict[str, np.ndarray]
    stats: dict[str, Any]


@dataclass(frozen=True)
class Hits32:
    """Answers to n rays, as `clrt.Hits`, and the `position` (n, 3) moved onto the primitive."""

    t: np.ndarray
    primitive: np.ndarray
    shape: np.ndarray
    normal: np.ndarray
    u: np.ndarray
    v: np.ndarray
    position: np.ndarray


def render32(
    scene: Scene,
    width: int | None = None,
    height: int | None = None,
    spp: int | None = None,
    max_depth: int | None = None,
    layers: Sequence[str] = (),
    flat: FlatScene | None = None,
) -> Result32:
    """The picture that the scene's camera sees; the same arguments as `clrt.render`.

    `flat` is the flattened scene, where the caller has it already. Raises SceneError as `flatten` does.
    """
    if scene.camera is None:
        raise ValueError("a picture needs a camera")
    flat = flat or flatten(scene)
    camera = flatten_camera(scene.camera, width, height, spp)
    size = int(camera["height"][0]), int(camera["width"][0])
    samples = int(camera["grid"][0]) ** 2
    depth = scene.max_depth if max_depth is None else max_depth
    counts: list[Counter[str]] = []
    parts: dict[str, list[np.ndarray]] = {}
    step = max(1, _CHUNK // samples)
    for start in range(0, size[0] * size[1], step):
        pixels = np.arange(start, min(start + step, size[0] * size[1]), dtype=np.uint32)
        for name, values in _render(flat, camera, pixels, samples, depth, tuple(layers), counts).items():
            parts.setdefault(name, []).append(values)
    planes = {
        name: np.concatenate(values).reshape(*size, *values[0].shape[1:]) for name, values in parts.items()
    }
    return Result32(planes["image"], {name: planes[name] for name in layers}, statistics(counts))


def _render(
    flat: FlatScene,
    camera: np.ndarray,
    pixels: np.ndarray,
    samples: int,
    depth: int,
    layers: tuple[str, ...],
    counts: list[Counter[str]],
) -> dict[str, np.ndarray]:
    """All planes at some pixels: (pixels,), (pixels, 3), or (pixels, bands) of the layer `bands`."""
    film = Film(len(pixels), layers, flat.bands, weights(camera, pixels))
    with np.errstate(all="ignore"):
        queue = generate(camera, pixels, flat.bands)
        for _ in generations(flat, queue, depth, film, counts):
            pass
        planes = film.means(samples, flat.response)
        if "bands" in layers:
            planes["bands"] = film.means(samples)["image"]
        if "xyz" in layers:
            planes["xyz"] = film.means(samples, flat.xyz)["image"]
        if any(comes_from(name, Geometry) for name in layers):
            found = geometry_layers(flat, queue, first_seen(flat, queue), camera)
            planes |= {name: np.ascontiguousarray(values[..., ::samples].T) for name, values in found.items()}
    return planes


def trace32(
    scene: Scene | FlatScene, origins: np.ndarray, directions: np.ndarray, t_max: float | np.ndarray = np.inf
) -> Hits32:
    """Nearest hits of n rays; the same arguments as `clrt.Tracer.intersect`."""
    flat = scene if isinstance(scene, FlatScene) else flatten(scene)
    with np.errstate(all="ignore"):
        queue = adopted(origins, directions, t_max)
        return geometry(flat, queue, nearest_hit(flat, queue.rays))


def radiance32(
    scene: Scene | FlatScene, origins: np.ndarray, directions: np.ndarray, max_depth: int
) -> tuple[np.ndarray, dict[str, Any]]:
    """Radiance (n, 3) float32 that comes back along n rays, and ray counts."""
    flat = scene if isinstance(scene, FlatScene) else flatten(scene)
    counts: list[Counter[str]] = []
    parts = [np.zeros((0, 3), np.float32)]
    with np.errstate(all="ignore"):
        for start in range(0, len(origins), _CHUNK):
            end = start + _CHUNK
            queue = adopted(origins[start:end], directions[start:end], np.inf, start, flat.bands)
            film = Film(len(queue), (), flat.bands)
            for _ in generations(flat, queue, max_depth, film, counts):
                pass
            parts.append(film.means(1, flat.response)["image"])
    return np.concatenate(parts), statistics(counts)


def adopted(
    origins: np.ndarray,
    directions: np.ndarray,
    t_max: float | np.ndarray,
    first: int = 0,
    bands: int = layout.BANDS,
) -> Queue:
    """The caller's rays as a queue: (n, 3), (n, 3), a number or (n,). `first` numbers the first ray."""
    o, d = np.asarray(origins, np.float32), np.asarray(directions, np.float32)
    limit = np.array(np.broadcast_to(np.asarray(t_max, np.float32), (len(o),)))
    return adopt(o, d, limit, np.arange(first, first + len(o), dtype=np.uint32), bands)


def geometry(flat: FlatScene, queue: Queue, hits: Hits) -> Hits32:
    """Distance, shape, outward normal, barycentric weights and position of known hits."""
    n = len(queue)
    out = Hits32(
        np.full(n, np.inf, np.float32),
        hits.primitive,
        np.full(n, -1, np.int32),
        np.zeros((n, 3), np.float32),
        np.zeros(n, np.float32),
        np.zeros(n, np.float32),
        np.zeros((n, 3), np.float32),
    )
    which = np.flatnonzero(hits.primitive >= 0)
    found = Hits(hits.t[which], hits.primitive[which])
    s = surface_at(flat, queue.rays[which], found)
    out.t[which], out.shape[which] = found.t, primitives_of(flat)["shape"][found.primitive]
    out.normal[which], out.position[which] = s.outward.T, s.point.T
    out.u[which], out.v[which] = s.uv
    return out


def geometry_layers(flat: FlatScene, queue: Queue, hits: Hits, camera: np.ndarray) -> dict[str, np.ndarray]:
    """What `layers.GEOMETRY` lists of known hits: (n,) or (values, n), as the camera's record sees it."""
    seen, eye = geometry(flat, queue, hits), camera[0]
    which = np.flatnonzero(hits.primitive >= 0)
    away = np.full((2, len(queue)), np.inf, np.float32)
    shading = np.zeros((3, len(queue)), np.float32)
    color = np.zeros((flat.bands, len(queue)), np.float32)
    material = np.full(len(queue), -1, np.int32)
    uv = np.zeros((2, len(queue)), np.float32)
    if len(which):
        s = surface_at(flat, queue.rays[which], Hits(hits.t[which], hits.primitive[which]))
        from_eye = s.point - eye["origin"][:3, None]
        along = dot(from_eye, np.repeat(eye["forward"][:3, None], len(which), axis=1))
        away[:, which] = along, along if eye["orthographic"] else np.sqrt(dot(from_eye, from_eye))
        shading[:, which] = s.ns
        color[:, which] = s.material["kd"] * color_of(s)
        uv[:, which] = np.where(np.isnan(s.place), np.float32(0.0), s.place)
        material[which] = primitives_of(flat)["material"][hits.primitive[which]]
    if flat.seen is not None:
        color = developed(color[None], flat.seen)[0]
    return {
        "depth": seen.t, "z": away[0], "distance": away[1], "position": seen.position.T,
        "normal": seen.normal.T, "shading_normal": shading, "albedo": color, "uv": uv, "shape": seen.shape,
        "material": material,
    }  # fmt: skip


def statistics(counts: list[Counter[str]]) -> dict[str, Any]:
    """Rays by kind: in all, and by generation."""
    rows = [{kind: counts[generation][kind] for kind in _KINDS} for generation in range(len(counts))]
    return {"rays": {kind: sum(row[kind] for row in rows) for kind in _KINDS}, "generations": rows}
