"""The public API: a scene compiled to a device, rendered or asked about rays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np

from clrt import layout, passes
from clrt.device import Device
from clrt.errors import ClrtError, LimitError, SceneError
from clrt.film import GEOMETRY, SPECTRAL, Film, check_layers, finished
from clrt.flatten import flatten, flatten_camera
from clrt.image import Image
from clrt.limits import Branching
from clrt.picture import Picture
from clrt.scene import Scene
from clrt.schedule import Work, interleaved
from clrt.settings import Settings
from clrt.tiles import tiles
from clrt.version import __version__
from clrt.wavefront import RayCounts, trace
from clrt.world import World

Progress = Callable[[int, int, int], None]
_TILE_BYTES: Final = 128 << 20  # bytes of queues that one tile may have


@dataclass(frozen=True)
class Hits:
    """Answers to n rays. A miss has primitive = shape = -1 and t = inf.

    t: (n,) float32, distance. primitive, shape: (n,) int32. normal: (n, 3) float32, the outward geometric
    unit normal (0 on a miss). u, v: (n,) float32, barycentric weights of a triangle's second and third
    corner, 0 on other primitives.
    """

    t: np.ndarray
    primitive: np.ndarray
    shape: np.ndarray
    normal: np.ndarray
    u: np.ndarray
    v: np.ndarray


class Tracer:
    """A scene compiled to a device: reusable for pictures and ray queries, by one thread at a time.

    device: a number from `clrt.devices()`, a part of "platform version / name", or None (CLRT_DEVICE, else
    the newest PoCL). Raises DeviceError, SceneError, LimitError.
    """

    def __init__(
        self, scene: Scene, device: int | str | None = None, settings: Settings | None = None
    ) -> None:
        self.scene = scene
        self.settings = settings or Settings()
        self.flat = flatten(scene)
        self.device = Device(device, self.settings, self.flat.bands, media=self.flat.media_places)
        self.world = World(self.device, self.flat)

    def render(
        self,
        width: int | None = None,
        height: int | None = None,
        spp: int | None = None,
        max_depth: int | None = None,
        layers: Sequence[str] = (),
        progress: Progress | None = None,
        crop: tuple[int, int, int, int] | None = None,
    ) -> Image:
        """The picture that the scene's camera sees.

        width, height, spp, max_depth: in place of the scene's; width or height alone keeps the aspect.
        layers: names as in docs/model.md (`direct`, `generation_1`, `depth`, ...). progress: called with
        (pixels done, pixels in all, rays traced) after every tile. crop: (x, y, width, height), the part of
        the picture to render, with the same bits as in the whole.
        """
        if self.scene.camera is None:
            raise SceneError(f"{self.scene.source or 'scene'}: camera: missing; a picture needs a [camera]")
        camera = flatten_camera(self.scene.camera, width, height, spp)
        full = int(camera["width"][0]), int(camera["height"][0])
        samples = int(camera["grid"][0]) ** 2
        depth = self._depth(max_depth)
        names = check_layers(layers, depth, self.flat.response is not None)
        window = _check_crop(crop, *full)
        self._check_limits(full[0] * full[1], samples, depth)

        picture = Picture(window, full[0], names, self.flat.bands)
        counts, done, local_size = RayCounts(), 0, 0
        total = window[2] * window[3]
        camera_buffer = self.device.upload(camera)
        self.device.take_seconds()

        def traced(pixels: np.ndarray) -> Work[_Tile]:
            queue, reported = passes.generate(self.device, camera_buffer, pixels, samples)
            passes.immerse(self.device, self.world, queue)
            hits = passes.closest(self.device, self.world, queue)
            film = Film(self.device, len(pixels), names)
            rays = yield from trace(self.device, self.world, queue, hits, film, depth, _TILE_BYTES)
            found = {}
            if set(names) & set(GEOMETRY):
                found = passes.geometry(self.device, self.world, queue, hits, samples)
            size = self.device.ask(reported, np.empty(1, np.uint32))
            means = film.developing(samples, self.flat.response)
            yield means
            found |= dict(zip(film.planes, finished(means.wait()), strict=True))
            for name in set(names) & set(SPECTRAL):
                found[name] = film.read(self.flat.xyz if name == "xyz" else None, planes=1)[0]
            return _Tile(rays, found, int(size.wait()[0]))

        pieces = list(tiles(*full, window, max(1, self.settings.tile // samples)))[::-1]
        for pixels, tile in interleaved(self.device, pieces, traced, _halves):
            picture.put(pixels, tile.layers)
            counts.merge(tile.rays)
            local_size = tile.local_size
            done += len(pixels)
            if progress:
                progress(done, total, counts.traced)
        stats = self._stats(counts, local_size)
        return Image(picture.pixels, picture.layers, stats, self._metadata())

    def intersect(
        self, origins: np.ndarray, directions: np.ndarray, t_max: float | np.ndarray = np.inf
    ) -> Hits:
        """Nearest hits of n rays: origins, directions (n, 3); t_max a number or (n,).

        Only hits with 0 < t < t_max count. Directions need not have unit length; t is a distance. A zero or
        non-finite direction misses.
        """
        parts = []
        for queue in self._adopted(origins, directions, t_max):
            hits = passes.closest(self.device, self.world, queue, crossing=False)
            parts.append(passes.geometry(self.device, self.world, queue, hits, 1))
            self.device.finish()
        found = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        return Hits(
            found["depth"],
            found["primitive"],
            found["shape"],
            found["normal"],
            found["uv"][:, 0],
            found["uv"][:, 1],
        )

    def occluded(
        self, origins: np.ndarray, directions: np.ndarray, t_max: float | np.ndarray = np.inf
    ) -> np.ndarray:
        """(n,) bool: does anything stand within 0 < t < t_max. Rays as for `intersect`."""
        parts = []
        for queue in self._adopted(origins, directions, t_max):
            seen = passes.any_hit(self.device, self.world, queue)
            parts.append(self.device.read(seen, np.empty(queue.n, np.uint32)) == 0)
        return np.concatenate(parts)

    def radiance(
        self, origins: np.ndarray, directions: np.ndarray, max_depth: int | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Radiance along n rays, (n, 3) float32 linear Rec.709, and ray counts as in Image.stats.

        Each ray starts in the media that its origin lies in.
        """
        depth = self._depth(max_depth)
        counts = RayCounts()

        def traced(chunk: tuple[np.ndarray, ...]) -> Work[tuple[RayCounts, np.ndarray]]:
            queue = passes.adopt(self.device, *chunk)
            passes.immerse(self.device, self.world, queue)
            hits = passes.closest(self.device, self.world, queue)
            film = Film(self.device, queue.n, ())
            rays = yield from trace(self.device, self.world, queue, hits, film, depth, _TILE_BYTES)
            means = film.developing(1, self.flat.response)
            yield means
            return rays, finished(means.wait())[0]

        def split(chunk: tuple[np.ndarray, ...]) -> list[tuple[np.ndarray, ...]]:
            return list(zip(*map(_halves, chunk), strict=True))

        pieces = list(self._ray_chunks(origins, directions, np.inf))[::-1]
        found = np.empty((sum(len(chunk[0]) for chunk in pieces), 3), np.float32)
        for (_, _, _, numbers), (rays, values) in interleaved(self.device, pieces, traced, split):
            found[numbers] = values
            counts.merge(rays)
        return found, dict(counts.table())

    def _adopted(self, origins: np.ndarray, directions: np.ndarray, t_max: float | np.ndarray) -> Any:
        for chunk in self._ray_chunks(origins, directions, t_max):
            yield passes.adopt(self.device, *chunk)

    def _ray_chunks(self, origins: np.ndarray, directions: np.ndarray, t_max: float | np.ndarray) -> Any:
        """Checked float32 arrays and the rays' numbers, in pieces of a tile; one empty piece for no rays."""
        with np.errstate(over="ignore"):  # beyond float32: infinite, which misses
            o, d = np.asarray(origins, np.float32), np.asarray(directions, np.float32)
            for name, array in (("origins", o), ("directions", d)):
                if array.ndim != 2 or array.shape[1] != 3:
                    raise ClrtError(f"{name}: shape {array.shape} is not (n, 3)")
            if len(o) != len(d):
                raise ClrtError(f"origins and directions: {len(o)} and {len(d)} rays; they must be as many")
            limit = np.asarray(t_max, np.float32)
        if limit.ndim and limit.shape != (len(o),):
            raise ClrtError(f"t_max: shape {limit.shape} is neither a number nor ({len(o)},)")
        limit, numbers = np.broadcast_to(limit, (len(o),)), np.arange(len(o), dtype=np.uint32)
        step = self.settings.tile
        for start in range(0, max(len(o), 1), step):
            yield tuple(np.ascontiguousarray(a[start : start + step]) for a in (o, d, limit, numbers))

    def _depth(self, max_depth: int | None) -> int:
        depth = self.scene.max_depth if max_depth is None else max_depth
        if not isinstance(depth, int) or depth < 0:
            raise ClrtError(f"max_depth: {depth!r} is not allowed; it must be a whole number, at least 0")
        self.settings.limits.check("depth", depth)
        return depth

    def _check_limits(self, pixels: int, samples: int, depth: int) -> None:
        limits = self.settings.limits
        limits.check("pixels", pixels)
        limits.check("samples", samples)
        limits.check_work(pixels * samples, self.world.lights, self._branching(depth))

    def _branching(self, depth: int) -> Branching:
        info, materials = self.flat.scene[0], self.flat.materials
        doubling = bool(np.any((materials["kr"] > 0) & (materials["kt"] > 0)))
        if info["spd"]:  # counts every reflection, whatever its weight
            return Branching(depth, bool(np.any(materials["kt"] > 0)))
        tint = np.maximum(materials["mirror"].max(axis=1), materials["fresnel"] == layout.FRESNEL["SCHLICK"])
        # total internal reflection takes both shares
        share = materials["kr"] * tint + materials["kt"] * materials["tint"].max(axis=1)
        least, ambient = float(info["min_weight"]), int(info["ambient_samples"])
        return Branching(depth, doubling, float(share.max()), least, ambient)

    def _stats(self, counts: RayCounts, local_size: int) -> dict[str, Any]:
        seconds = self.device.take_seconds()
        return {
            **counts.table(),
            "seconds": seconds,
            "traced": counts.traced,
            "device": self.device.info.label,
            "local_size": local_size,
        }

    def _metadata(self) -> dict[str, str]:
        settings = {name: value for name, value in asdict(self.settings).items() if name != "limits"}
        return {
            "scene_hash": self.flat.hash,
            "kernel_hash": self.device.kernel_hash,
            "device": self.device.info.label,
            "version": __version__,
            "settings": ", ".join(f"{name}={value}" for name, value in settings.items()),
        }


@dataclass(frozen=True)
class _Tile:
    """What was found for some pixels: counts, the picture ("image") and layers, the work-group size."""

    rays: RayCounts
    layers: dict[str, np.ndarray]
    local_size: int


def _halves(array: np.ndarray) -> list[np.ndarray]:
    """Two halves, the first one last (for a stack). LimitError when there is only one pixel left."""
    if len(array) < 2:
        raise LimitError(
            f"a single pixel needs more than {_TILE_BYTES >> 20} MiB of rays; "
            "lower spp, max_depth, ambient_samples or the number of lights"
        )
    return [array[len(array) // 2 :], array[: len(array) // 2]]


def _check_crop(crop: tuple[int, int, int, int] | None, width: int, height: int) -> tuple[int, int, int, int]:
    if crop is None:
        return 0, 0, width, height
    x, y, w, h = crop
    if w < 1 or h < 1 or x < 0 or y < 0 or x + w > width or y + h > height:
        raise ClrtError(f"crop: {x} {y} {w} {h} is not a part of the picture of {width} x {height} pixels")
    return x, y, w, h


def render(
    scene: Scene,
    width: int | None = None,
    height: int | None = None,
    spp: int | None = None,
    max_depth: int | None = None,
    device: int | str | None = None,
    layers: Sequence[str] = (),
    progress: Progress | None = None,
    settings: Settings | None = None,
    crop: tuple[int, int, int, int] | None = None,
) -> Image:
    """The picture of a scene: `Tracer(scene, device, settings).render(...)`."""
    return Tracer(scene, device, settings).render(width, height, spp, max_depth, layers, progress, crop)
