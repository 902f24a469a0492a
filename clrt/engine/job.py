"""What a picture or an answer about rays is made by: a function of a list of pixels or rays."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final, TypeVar

import numpy as np

from clrt import layout
from clrt.base.errors import LimitError
from clrt.base.layers import Geometry, Samples, Spectral, comes_from, find
from clrt.device.device import Device
from clrt.device.settings import Settings
from clrt.device.source import kernel_source
from clrt.engine import passes
from clrt.engine.coverage import covered
from clrt.engine.film import Film
from clrt.engine.immersion import immerse
from clrt.engine.schedule import Work, interleaved
from clrt.engine.stage import Observer, tell
from clrt.engine.tripwire import Tripwire
from clrt.engine.wavefront import RayCounts, trace
from clrt.engine.world import World
from clrt.flatten.camera import near_corners
from clrt.flatten.flatten import FlatScene
from clrt.spectra.colorimetry import finished

TILE_BYTES: Final = 128 << 20  # bytes of queues that one tile may have

_FINITE: Final = float(np.finfo(np.float32).max)

GivenRays = tuple[np.ndarray, ...]  # as `rayinput.ray_chunks` gives them
Piece = TypeVar("Piece", np.ndarray, GivenRays)  # numbers of pixels, (n,) uint32; or a caller's rays


@dataclass(frozen=True)
class Tile:
    """What was found for a piece: counts, the picture ("image") and layers, the work-group size of pixels."""

    rays: RayCounts
    layers: dict[str, np.ndarray]
    local_size: int = 0


@dataclass(frozen=True, eq=False)
class Job:
    """What is asked of a scene, and nothing of how far it is: pieces are traced in any order, anywhere.

    flat: the scene. camera: a record of `flatten_camera`, or None where the pieces are a caller's rays.
    max_depth: the last generation. layers: as `layers.check_layers` gives them. mattes: as `coverage.mattes`
    does for them. A job can be pickled: what
    another process needs beside it is `World(Device(None, job.settings, job.flat.ray_format), job.flat)`.
    """

    flat: FlatScene
    max_depth: int
    camera: np.ndarray | None = None
    layers: tuple[str, ...] = ()
    settings: Settings = field(default_factory=Settings)
    mattes: Mapping[str, np.ndarray] = field(default_factory=dict)

    @property
    def samples(self) -> int:
        """Rays of generation 0 for a pixel."""
        return 1 if self.camera is None else int(self.camera["grid"][0]) ** 2

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
        if self.settings.check:
            width = 0 if self.camera is None else int(self.camera["width"][0])
            observers = (*observers, Tripwire(world, piece[3] if isinstance(piece, tuple) else piece, width))
        reported = None
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
        hits = passes.closest(device, world, queue)
        tell(observers, "closest", 0, queue, hits)
        film = Film(device, queue.n // self.samples, self.layers)
        rays = yield from trace(device, world, queue, hits, film, self.max_depth, budget, observers)
        found: dict[str, np.ndarray] = {}
        if any(comes_from(name, Geometry) for name in self.layers):
            eye = np.zeros(1, layout.dtype("Camera")) if self.camera is None else self.camera
            found = passes.geometry(device, world, queue, hits, self.samples, eye)
            tell(observers, "geometry", 0, queue, dict(found))
        if any(comes_from(name, Samples) for name in self.layers):
            met = queue.words(hits.primitive, np.int32)
            found |= covered(self.layers, self.flat, met.reshape(-1, self.samples), self.mattes)
        size = device.ask(reported, np.zeros(1, np.uint32)) if reported is not None else None
        means = film.developing(self.samples, self.flat.response)
        yield means
        planes = means.wait()
        tell(observers, "resolve", 0, queue, film)
        tell(observers, "develop", 0, queue, {"rows": planes})
        found |= dict(zip(film.planes, finished(planes), strict=True))
        for name in self.layers:
            for source in find(name).sources:
                if isinstance(source, Spectral):
                    response = getattr(self.flat, source.response) if source.response else None
                    found[name] = film.reading(response, planes=1).wait()[0]
        return Tile(rays, found, int(size.wait()[0]) if size else 0)

    def tiles(self, device: Device, world: World, pieces: list[Piece]) -> Iterator[tuple[Piece, Tile]]:
        """All pieces, the last one first, as they are done: those that turn out TooLarge in parts."""
        return interleaved(
            device, pieces, lambda track, piece: self.trace(track, world, piece, budget=TILE_BYTES), halves
        )

    def identity(self, window: tuple[int, int, int, int]) -> dict[str, str]:
        """What decides a picture's window (x, y, width, height) and its counts, as texts by name."""
        assert self.camera is not None
        width, height = (int(self.camera[name][0]) for name in ("width", "height"))
        named = {name: hashlib.sha256(ids.tobytes()).hexdigest() for name, ids in self.mattes.items()}
        return named | {
            "size": f"{width} x {height}",
            "spp": str(self.samples),
            "crop": " ".join(map(str, window)),
            "max_depth": str(self.max_depth),
            "layers": ",".join(self.layers),
            "scene": self.flat.hash,
            "camera": hashlib.sha256(self.camera.tobytes()).hexdigest(),
            "kernels": hashlib.sha256(kernel_source(self.flat.ray_format).encode()).hexdigest(),
        }

    def fingerprint(self, window: tuple[int, int, int, int]) -> str:
        """SHA-256 (hexadecimal) of `identity`."""
        return hashlib.sha256(repr(self.identity(window)).encode()).hexdigest()

    def ranges(self) -> dict[str, tuple[float, float]]:
        """The least and the most that a number of the picture ("image") and of each layer can be."""
        flat, brightest = self.flat, float(np.float32(layout.BRIGHTEST))

        def seen(response: np.ndarray | None) -> tuple[float, float]:
            if response is None:  # radiance is never negative
                return 0.0, brightest
            if len(response) == 3:  # but colours beyond what red, green and blue show are; rounded sums
                most = 1.001 * brightest * float(np.abs(response).sum(axis=1).max())
                return -most, most
            return -_FINITE, brightest  # `colorimetry.finished` bounds it above

        special = {
            "bands": seen(None), "xyz": seen(flat.xyz), "depth": (0.0, np.inf), "normal": (-2.0, 2.0),
            "distance": (0.0, np.inf), "z": (-_FINITE, np.inf), "shading_normal": (-2.0, 2.0),
            "shape": (-1.0, flat.n_shapes + flat.scene["lights"][0] - 1.0),
            "material": (-1.0, len(flat.materials) - 1.0), "alpha": (0.0, 1.0),
        }  # fmt: skip
        light, number = seen(flat.response), (-_FINITE, _FINITE)
        other = {name: number if comes_from(name, Geometry, Samples) else light for name in self.layers}
        return {"image": light, **{name: special.get(name, each) for name, each in other.items()}}

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
