"""What a picture or an answer about rays is made by: a function of a list of pixels or rays."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final, TypeVar

import numpy as np

from clrt import layout
from clrt.base.errors import DeviceError, LimitError
from clrt.base.layers import Count, Geometry, Samples, Spectral, comes_from, find
from clrt.device import foreign
from clrt.device.added import added
from clrt.device.device import Device
from clrt.device.settings import Settings
from clrt.engine import passes
from clrt.engine.adaptive import refined
from clrt.engine.coverage import covered
from clrt.engine.film import Film
from clrt.engine.immersion import immerse
from clrt.engine.queues import tile_rays
from clrt.engine.schedule import Work, interleaved
from clrt.engine.stage import Observer, tell
from clrt.engine.tripwire import Tripwire
from clrt.engine.wavefront import Tile, trace
from clrt.engine.world import World
from clrt.flatten.camera import near_corners
from clrt.flatten.flatten import FlatScene
from clrt.layout import ceilings
from clrt.spectra.colorimetry import finished

TILE_BYTES: Final = 128 << 20  # bytes of queues that one tile may have

_FINITE: Final = float(np.finfo(np.float32).max)

GivenRays = tuple[np.ndarray, ...]  # as `rayinput.ray_chunks` gives them
Piece = TypeVar("Piece", np.ndarray, GivenRays)  # numbers of pixels, (n,) uint32; or a caller's rays


@dataclass(frozen=True, eq=False)
class Job:
    """What is asked of a scene, and nothing of how far it is: pieces are traced in any order, anywhere.

    flat: the scene. camera: a record of `flatten_camera`, or None where the pieces are a caller's rays.
    max_depth: the last generation. layers: as `layers.check_layers` gives them.
    adaptive: side of the finest grid and threshold, None for an even picture. mattes: as
    `coverage.mattes` gives them for the layers. A job can be pickled: what
    another process needs beside it is `World(Device(None, job.settings, job.flat.ray_format), job.flat)`.
    """

    flat: FlatScene
    max_depth: int
    camera: np.ndarray | None = None
    layers: tuple[str, ...] = ()
    settings: Settings = field(default_factory=Settings)
    adaptive: tuple[int, float] | None = None
    mattes: Mapping[str, np.ndarray] = field(default_factory=dict)

    @property
    def filtered(self) -> bool:
        """Are samples weighed?"""
        return self.camera is not None and bool(self.camera["filter"][0])

    @property
    def grid(self) -> int:
        """Side of the square grid of a pixel's samples; of the first one."""
        return 1 if self.camera is None else int(self.camera["grid"][0])

    @property
    def samples(self) -> int:
        """Rays of generation 0 for a pixel; at least, where it is adaptive."""
        return self.grid**2

    @property
    def piece_samples(self) -> int:
        """By how many rays of a pixel pieces are cut. An adaptive one goes through its pixels tile by tile,
        and few of them get the finer grids, so that many make a tile there."""
        return self.samples if self.adaptive is None else 1

    @property
    def refinements(self) -> int:
        """How often the grid's sides may double."""
        return 0 if self.adaptive is None else (self.adaptive[0] // self.grid).bit_length() - 1

    @property
    def tile_rays(self) -> int:
        """Rays that are traced at once: the setting, or what suits the scene's number of bands."""
        return tile_rays(self.flat.ray_format, self.settings)

    def even(self, grid: int, layers: tuple[str, ...] = ()) -> Job:
        """The same picture with this grid for all pixels."""
        assert self.camera is not None
        camera = self.camera.copy()
        camera["grid"] = grid
        return replace(self, camera=camera, layers=tuple(dict.fromkeys(layers)), adaptive=None)

    def trace(
        self,
        device: Device,
        world: World,
        piece: np.ndarray | GivenRays,
        observers: Sequence[Observer] = (),
        budget: int | None = None,
    ) -> Work[Tile]:
        """Trace a piece, on the device that has the job's scene; observers are told of each pass.

        TooLarge where its queues would take more than `budget` bytes; None: there is no bound.
        """
        if self.adaptive is not None and not isinstance(piece, tuple):
            return refined(self, device, world, piece, observers, budget)
        return self._trace_evenly(device, world, piece, observers, budget)

    def _trace_evenly(
        self,
        device: Device,
        world: World,
        piece: np.ndarray | GivenRays,
        observers: Sequence[Observer] = (),
        budget: int | None = None,
    ) -> Work[Tile]:
        if self.settings.check:
            width = 0 if self.camera is None else int(self.camera["width"][0])
            numbers = piece[3] if isinstance(piece, tuple) else piece
            places = np.repeat(numbers, self.samples) if self.filtered else numbers
            observers = (*observers, Tripwire(world, places, width))
        reported = record = weights = None
        if isinstance(piece, tuple):
            queue = passes.adopt(device, *piece)
            immerse(device, world, queue, piece[0])
        else:
            camera, corners = self._camera
            record = device.upload(camera, wait=False)
            seed = int(camera["seed"][0])
            queue, reported = passes.generate(device, record, piece, self.samples, seed)
            immerse(device, world, queue, corners if len(corners) == 1 else None, corners)
        tell(observers, "adopt" if reported is None else "generate", 0, queue, queue)
        if self.filtered:
            weights = passes.weigh_samples(device, record, queue)
            tell(observers, "weigh_samples", 0, queue, weights)
        hits = passes.closest(device, world, queue)
        tell(observers, "closest", 0, queue, hits)
        film = Film(device, queue.n // self.samples, self.layers, weights)
        rays = yield from trace(device, world, queue, hits, film, self.max_depth, budget, observers)
        found: dict[str, np.ndarray] = {}
        if any(comes_from(name, Geometry) for name in self.layers):
            eye = np.zeros(1, layout.dtype("Camera")) if self.camera is None else self.camera
            found = passes.geometry(device, world, queue, hits, self.samples, eye)
            tell(observers, "geometry", 0, queue, dict(found))
        if any(comes_from(name, Samples) for name in self.layers):
            met = queue.words(hits.primitive, np.int32)
            counts = None if weights is None else weights.decoded(queue)["weights"].reshape(-1, self.samples)
            found |= covered(self.layers, self.flat, met.reshape(-1, self.samples), self.mattes, counts)
        size = device.ask(reported, np.zeros(1, np.uint32)) if reported is not None else None
        means = film.developing(self.samples, self.flat.response)
        yield means
        planes = means.wait()
        tell(observers, "resolve", 0, queue, film)
        tell(observers, "develop", 0, queue, {"rows": planes})
        found |= dict(zip(film.planes, finished(planes), strict=True))
        for name in self.layers:
            for source in find(name).sources:
                if isinstance(source, Count):
                    found[name] = np.full(len(planes[0]), self.samples, np.int32)
                if isinstance(source, Spectral):
                    response = getattr(self.flat, source.response) if source.response else None
                    found[name] = film.reading(response, planes=1).wait()[0]
        return Tile(rays, found, int(size.wait()[0]) if size else 0)

    def tiles(self, device: Device, world: World, pieces: list[Piece]) -> Iterator[tuple[Piece, Tile]]:
        """All pieces, the last one first, as they are done: those that turn out TooLarge in parts.

        Whoever gives up on the way (an error, Ctrl-C, `progress`) leaves work behind on both tracks. What
        comes later comes after it.
        """

        def begin(track: Device, piece: Piece) -> Work[Tile]:
            return self.trace(track, world, piece, budget=TILE_BYTES)

        whole = False
        try:
            yield from interleaved(device, pieces, begin, halves)
            whole = True
        finally:
            if not whole:
                with suppress(DeviceError):  # why it is given up is what counts
                    device.driver.barrier()

    def identity(self, window: tuple[int, int, int, int]) -> dict[str, str]:
        """What decides a picture's window (x, y, width, height) and its counts, as texts by name: the kernels
        that this process takes, and what its environment adds to them, among it."""
        assert self.camera is not None
        width, height = (int(self.camera[name][0]) for name in ("width", "height"))
        named = {name: hashlib.sha256(ids.tobytes()).hexdigest() for name, ids in self.mattes.items()}
        named |= added()
        return named | {
            "size": f"{width} x {height}",
            "spp": str(self.samples),
            "adaptive": "no" if self.adaptive is None else "up to {} a side, {!r}".format(*self.adaptive),
            "refinements": str(self.refinements),
            "crop": " ".join(map(str, window)),
            "max_depth": str(self.max_depth),
            "layers": ",".join(sorted(self.layers)),
            "scene": self.flat.hash,
            "camera": hashlib.sha256(self.camera.tobytes()).hexdigest(),
            "kernels": foreign.source_hash(self.flat.ray_format),
        }

    def fingerprint(self, window: tuple[int, int, int, int]) -> str:
        """SHA-256 (hexadecimal) of `identity`."""
        return hashlib.sha256(repr(self.identity(window)).encode()).hexdigest()

    def ranges(self) -> dict[str, tuple[float, float]]:
        """The least and the most that a number of the picture ("image") and of each layer can be."""
        flat, brightest = self.flat, float(np.float32(layout.BRIGHTEST))

        negative = self.camera is not None and int(self.camera["filter"][0]) == layout.FILTERS["MITCHELL"]
        dark = bool(np.any(flat.background < 0))  # as in a picture that somebody has sharpened

        def seen(response: np.ndarray | None) -> tuple[float, float]:
            if dark:  # nothing bounds a sum of light from below
                return -_FINITE, brightest if response is None else _FINITE
            if response is None:  # radiance is never negative, but for what a filter takes off
                return -4 * brightest if negative else 0.0, brightest
            if len(response) == 3:  # but colours beyond what red, green and blue show are; rounded sums
                most = (4 if negative else 1) * 1.001 * brightest * float(np.abs(response).sum(axis=1).max())
                return -most, most
            return -_FINITE, brightest  # `colorimetry.finished` bounds it above

        last = {"shape": flat.n_shapes + flat.scene["lights"][0] - 1, "material": len(flat.materials) - 1}

        def of(name: str) -> tuple[float, float]:
            (source, *_), (least, most) = find(name).sources, find(name).within
            if isinstance(source, Spectral):
                return seen(getattr(flat, source.response) if source.response else None)
            if isinstance(source, Count):
                return 0.0, float(ceilings.RAYS)
            if isinstance(source, Geometry | Samples):
                return least, float(last[most] if isinstance(most, str) else most)
            return seen(flat.response)

        return {"image": seen(flat.response), **{name: of(name) for name in self.layers}}

    @cached_property
    def _camera(self) -> tuple[np.ndarray, np.ndarray]:
        """The record, and points between which its rays start."""
        assert self.camera is not None
        return self.camera, near_corners(self.camera)


def halves(piece: Piece) -> list[Piece]:
    """Two halves, the first one last (for a stack). LimitError where there is only one pixel or ray left."""
    if isinstance(piece, tuple):
        return list(zip(*map(_halves, piece), strict=True))
    return _halves(piece)


def _halves(array: np.ndarray) -> list[np.ndarray]:
    if len(array) < 2:
        raise LimitError(
            f"a single pixel needs more than {TILE_BYTES >> 20} MiB of rays; "
            "lower spp, max_depth, ambient_samples or the number of lights"
        )
    return [array[len(array) // 2 :], array[: len(array) // 2]]
