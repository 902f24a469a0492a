"""The launches of real passes, recorded with their buffers, so that each can be run again alone.

Nothing here knows a kernel's parameters: passes are called as a render calls them, and what they launch is
kept. A kernel's compulsory traffic is the sum of its buffers, each read or written once; the world's are
left out, since only the walk through the tree can say how much of them is touched (`walk.py`).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pyopencl as cl

from clrt import layout, parameters, passes
from clrt.bench.timing import Case
from clrt.device import Device
from clrt.film import Film
from clrt.flatten import flatten, flatten_camera
from clrt.immersion import immerse
from clrt.queues import AMBIENT, REFLECTION, TRANSMISSION, Hits, Lit, Queue, tile_rays
from clrt.scene import Scene
from clrt.settings import Settings
from clrt.tiles import tiles
from clrt.world import World

Family = tuple[Queue, Hits, Lit]
CLASSES: Final = {REFLECTION: "reflection", TRANSMISSION: "refraction", AMBIENT: "incoherent"}
TRACING: Final = ("closest", "occluded")
COMPACTION: Final = ("count", "scan", "rank")
# kernels that read what they write: their buffers are put back before every repetition
_IN_PLACE: Final = ("rank", "illuminate", "gather", "resolve")


@dataclass(frozen=True)
class Launch:
    kernel: str
    queue: str  # what kind of rays: "primary", "shadow", CLASSES
    rays: int
    items: int
    arguments: tuple[Any, ...]
    local_size: int | None
    nbytes: int  # of the buffers that are not the world's


class Recorder(Device):
    """A Device that keeps every launch inside `rays_of`."""

    def __init__(self, wanted: int | str | None, settings: Settings, rays: layout.Rays) -> None:
        super().__init__(wanted, settings, rays)
        self.launches: list[Launch] = []
        self.world_buffers: frozenset[int] = frozenset()
        self._sizes: dict[int, int] = {}
        self._kind: tuple[str, int | None, int] | None = None

    @contextmanager
    def rays_of(self, queue: str, rays: int | None, feelers: int = 0) -> Iterator[None]:
        """Name the rays that the launches inside belong to; shadow feelers are counted apart.

        `rays` = None: as many as the first number among a launch's arguments says.
        """
        self._kind = (queue, rays, feelers)
        yield
        self._kind = None

    def buffer(self, nbytes: int, kind: str | None = None) -> Any:
        made = super().buffer(nbytes, kind)
        self._sizes[id(made)] = nbytes  # an id that is used again is a new buffer, entered again
        return made

    def launch(self, name: str, items: int, *arguments: Any, local_size: int | None = None) -> None:
        super().launch(name, items, *arguments, local_size=local_size)
        if self._kind is None or items == 0:
            return
        queue, rays, feelers = self._kind
        if name.startswith("occluded"):
            queue, rays = ("shadow" if queue == "primary" else f"shadow of {queue}"), feelers
        touched = [arguments[number] for number in parameters.used(self.source, name)]
        own = [a for a in touched if _is_buffer(a) and id(a) not in self.world_buffers]
        if rays is None:
            rays = next(int(a) for a in arguments if isinstance(a, np.uint32))
        nbytes = sum(self._sizes[id(a)] for a in own)
        self.launches.append(
            Launch(name, queue, rays, items, arguments, local_size, nbytes)
        )


@dataclass(frozen=True)
class Recording:
    """Launches by (kernel, kind of rays), one a tile; and by kind the buffers of rays with their numbers."""

    device: Recorder
    world: World
    launches: dict[tuple[str, str], list[Launch]]
    rays: dict[str, list[tuple[Any, int]]]


def record(scene: Scene, width: int, wanted: int | str | None, settings: Settings) -> Recording:
    """Render generation 0 of a square picture, spawn and light all kinds of generation 1, spawn one of 2."""
    flat = flatten(scene)
    device = Recorder(wanted, settings, flat.rays)
    world = World(device, flat)
    device.world_buffers = frozenset(map(id, world.arguments))
    assert scene.camera is not None
    camera = flatten_camera(scene.camera, width, width, 1)
    buffer = device.upload(camera)
    rays: dict[str, list[tuple[Any, int]]] = {}
    for pixels in tiles(width, width, (0, 0, width, width), settings.tile or tile_rays(flat.rays)):
        _record_tile(device, world, buffer, pixels, rays)
        device.finish()
    grouped: dict[tuple[str, str], list[Launch]] = {}
    for launch in device.launches:
        grouped.setdefault((launch.kernel, launch.queue), []).append(launch)
    return Recording(device, world, grouped, rays)


def _record_tile(
    device: Recorder, world: World, camera: Any, pixels: np.ndarray, rays: dict[str, list[tuple[Any, int]]]
) -> None:
    film = Film(device, len(pixels), ())
    with device.rays_of("primary", len(pixels)):
        queue, _ = passes.generate(device, camera, pixels, 1)
        immerse(device, world, queue)
        family = _light(device, world, film, queue, "primary", rays)
    children = []
    for kind, name in CLASSES.items():
        with device.rays_of(name, family[2].totals[kind.upper()]):
            child = passes.spawn(device, world, kind, 0, [family])
            if child:
                children.append(_light(device, world, film, child, name, rays))
    with device.rays_of("generation 2", None):
        passes.spawn(device, world, REFLECTION, 1, children)
    with device.rays_of("primary", len(pixels)):
        film.develop(1, world.flat.response)


def _light(
    device: Recorder,
    world: World,
    film: Film,
    queue: Queue,
    name: str,
    rays: dict[str, list[tuple[Any, int]]],
) -> Family:
    """Trace a queue and light it, as the loop in `wavefront.py` does."""
    rays.setdefault(name, []).append((queue.rays, queue.n))
    hits = passes.closest(device, world, queue)
    lit = passes.light(device, world, queue, hits, last=False)
    with device.rays_of(name, queue.n, lit.totals["FEELERS"]):
        feelers = passes.feelers(device, world, queue, hits, lit)
    with device.rays_of(name, queue.n):
        passes.illuminate(device, world, queue, hits, lit, feelers)
        film.add(queue, lit, 0)
    if name == "primary":
        rays.setdefault("shadow", []).append((feelers.rays, feelers.n))
    return queue, hits, lit


def case(recording: Recording, kernel: str, queue: str, scene: str) -> Case:
    """All launches of a kernel on one kind of rays, as something to time."""
    device = recording.device
    launches = recording.launches[kernel, queue]

    def run() -> None:
        for launch in launches:
            device.launch(launch.kernel, launch.items, *launch.arguments, local_size=launch.local_size)
        device.finish()

    group = "tracing" if kernel in TRACING else "compaction" if kernel in COMPACTION else "shading"
    return Case(
        group=group,
        scene=scene,
        name=kernel,
        queue=queue,
        items=sum(launch.rays for launch in launches),
        unit="rays",
        clock="cpu" if device.info.kind == "CPU" else "wall",
        run=run,
        reset=_restorer(recording, launches) if kernel in _IN_PLACE else None,
        nbytes=float(sum(launch.nbytes for launch in launches)),
    )


def _restorer(recording: Recording, launches: list[Launch]) -> Any:
    """A function that gives the launches' own buffers the contents they have now."""
    device = recording.device
    buffers = {
        id(a): a
        for launch in launches
        for a in launch.arguments
        if _is_buffer(a) and id(a) not in device.world_buffers
    }
    copies: list[tuple[Any, Any]] = []
    for buffer in buffers.values():
        copy: Any = device.pool.allocate(buffer.size)
        cl.enqueue_copy(device.queue, copy, buffer)
        copies.append((buffer, copy))
    device.finish()

    def restore() -> None:
        for buffer, copy in copies:
            cl.enqueue_copy(device.queue, buffer, copy)
        device.finish()

    return restore


def _is_buffer(argument: Any) -> bool:
    return isinstance(argument, cl.MemoryObjectHolder)
