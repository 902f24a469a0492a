"""The launches of real passes, recorded with their buffers, so that each can be run again alone.

Nothing here knows a kernel's parameters: passes are called as a render calls them, and what they launch is
kept. A kernel's compulsory traffic is the sum of its buffers, each read or written once; the world's are
left out, since only the walk through the tree can say how much of them is touched (`walk.py`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from clrt import layout
from clrt.bench.timing import Case
from clrt.device.device import Device
from clrt.device.opencl import cl
from clrt.device.settings import Settings
from clrt.engine.job import Job
from clrt.engine.queues import AMBIENT, REFLECTION, TRANSMISSION, Feelers, Queue, tile_rays
from clrt.engine.schedule import complete
from clrt.engine.stage import Stage
from clrt.engine.tiles import tiles
from clrt.engine.world import World
from clrt.flatten.flatten import flatten, flatten_camera
from clrt.layout import parameters
from clrt.scene.scene import Scene

CLASSES: Final = {REFLECTION: "reflection", TRANSMISSION: "refraction", AMBIENT: "incoherent"}
TRACING: Final = ("closest", "occluded")
ARRANGING: Final = "arrange"  # what readies rays for it, where that pays
COMPACTION: Final = ("count", "scan", "rank")
ADDING: Final = "offsets"  # what makes places of what `count` found, in place: other kernels read them
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


class Logged(Device):
    """A Device that keeps what it launches, and how large a buffer was asked for."""

    def __init__(self, wanted: int | str | None, settings: Settings, ray_format: layout.RayFormat) -> None:
        self.launched: list[tuple[str, int, tuple[Any, ...], int | None]] = []
        self.sizes: dict[int, int] = {}
        super().__init__(wanted, settings, ray_format)

    def buffer(self, nbytes: int, kind: str | None = None) -> Any:
        made = super().buffer(nbytes, kind)
        self.sizes[id(made)] = nbytes  # an id that is used again is a new buffer, entered again
        return made

    def launch(self, name: str, items: int, *arguments: Any, local_size: int | None = None) -> None:
        super().launch(name, items, *arguments, local_size=local_size)
        if items:
            self.launched.append((name, items, arguments, local_size))


class Recorder:
    """An observer that keeps the launches of generations 0 and 1, and those that spawn a queue of 2."""

    def __init__(self, device: Logged, world: World) -> None:
        self._device = device
        self.world_buffers = frozenset(map(id, world.arguments))
        self.launches: dict[tuple[str, str], list[Launch]] = {}
        self.rays: dict[str, list[Queue]] = {}
        device.launched.clear()

    def __call__(self, stage: Stage) -> None:
        launched = self._device.launched.copy()
        self._device.launched.clear()
        if stage.term:
            return
        name = "primary" if stage.generation == 0 else CLASSES[stage.kind]
        if stage.generation > 1:
            if stage.name != "spawn" or stage.kind != REFLECTION:
                return
            name = "generation 2"
        if stage.name == "closest":
            self.rays.setdefault(name, []).append(stage.queue)
        elif isinstance(stage.wrote, Feelers) and stage.generation == 0:
            feelers = replace(stage.queue, n=stage.wrote.n, rays=stage.wrote.rays)
            self.rays.setdefault("shadow", []).append(feelers)
        for kernel, items, arguments, local_size in launched:
            queue, rays = name, stage.queue.n
            if stage.generation > 1:  # from queues of several kinds: each launch says of how many rays
                rays = next(int(argument) for argument in arguments if isinstance(argument, np.uint32))
            elif isinstance(stage.wrote, Feelers) and kernel.startswith(("occluded", ARRANGING)):
                queue, rays = ("shadow" if queue == "primary" else f"shadow of {queue}"), stage.wrote.n
            source = stage.queue.device.kernels.source
            touched = [arguments[number] for number in parameters.used(source, kernel)]
            own = [a for a in touched if _is_buffer(a) and id(a) not in self.world_buffers]
            nbytes = sum(self._device.sizes[id(buffer)] for buffer in own)
            launch = Launch(kernel, queue, rays, items, arguments, local_size, nbytes)
            self.launches.setdefault((kernel, queue), []).append(launch)


@dataclass(frozen=True)
class Recording:
    """Launches by (kernel, kind of rays), one a tile; and by kind the buffers of rays with their numbers."""

    device: Device
    world: World
    launches: dict[tuple[str, str], list[Launch]]
    rays: dict[str, list[Queue]]
    world_buffers: frozenset[int]  # their ids


def record(scene: Scene, width: int, wanted: int | str | None, settings: Settings) -> Recording:
    """The launches of a square picture: see `Recorder`."""
    flat = flatten(scene)
    device = Logged(wanted, settings, flat.ray_format)
    world = World(device, flat)
    assert scene.camera is not None
    job = Job(flat, 2, flatten_camera(scene.camera, width, width, 1), settings=settings)
    recorder = Recorder(device, world)
    for pixels in tiles(width, width, (0, 0, width, width), tile_rays(flat.ray_format, settings)):
        complete(job.trace(device, world, pixels, (recorder,)))
        device.finish()
    return Recording(device, world, recorder.launches, recorder.rays, recorder.world_buffers)


def case(recording: Recording, kernel: str, queue: str, scene: str) -> Case:
    """All launches of a kernel on one kind of rays, as something to time.

    Tracing with what readies rays, counting with what adds up: that leaves the places as other kernels read
    them, however often it runs.
    """
    device = recording.device
    launches = recording.launches[kernel, queue]
    before = recording.launches.get((ARRANGING, queue), []) if kernel in TRACING else []
    after = recording.launches[ADDING, queue] if kernel == "count" else []

    def run() -> None:
        for launch in (*before, *launches, *after):
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
        if _is_buffer(a) and id(a) not in recording.world_buffers
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
