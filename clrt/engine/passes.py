"""One function a kernel pass. Each takes queues, launches, and gives back what the next pass needs.

Nothing here decides what the picture is; the kernels do.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from clrt import layout
from clrt.base.layers import GEOMETRY
from clrt.device.device import Device
from clrt.engine.queues import (
    AMBIENT,
    CAMERA,
    REFLECTION,
    TRANSMISSION,
    Feelers,
    Pixels,
    Queue,
    QueueHits,
    Shaded,
    Weights,
    block_bytes,
    chunks,
    new_queue,
)
from clrt.engine.world import World
from clrt.layout.parameters import element

_STREAM = {name: number for number, name in enumerate(layout.STREAMS)}
_SPAWNING = {
    REFLECTION: ("reflect", "REFLECTION"),
    TRANSMISSION: ("transmit", "TRANSMISSION"),
    AMBIENT: ("gather_ambient", "AMBIENT"),
}
_SCATTERED = (REFLECTION, AMBIENT)  # queues whose feelers start here and there: they gain by being arranged


def generate(
    device: Device, camera: Any, pixels: np.ndarray, samples: int, seed: int = 0
) -> tuple[Queue, Any]:
    """Camera rays of a tile: `samples` a pixel number. Also a buffer with the work-group size it ran with.

    `seed`: of the camera, for those who ask for light.
    """
    queue = new_queue(device, CAMERA, len(pixels) * samples)
    local_size = device.buffer(4, "uint")
    numbers = device.upload(pixels, wait=False)
    device.launch_packets("generate", queue.n, camera, numbers, *queue.arguments, local_size)
    found = Pixels(numbers, np.uint32(seed), np.uint32(samples))
    return replace(queue, pixels=found), local_size


def adopt(
    device: Device, origins: np.ndarray, directions: np.ndarray, t_max: np.ndarray, numbers: np.ndarray
) -> Queue:
    """A queue of the caller's rays: (n, 3), (n, 3), (n,) float32; the rays' numbers, (n,) uint32.

    Directions are normalised. Numbers stand for the pixels of camera rays: what looks random depends on them.
    """
    queue = new_queue(device, CAMERA, len(origins))
    given = [device.upload(array, wait=False) for array in (origins, directions, t_max, numbers)]
    device.launch("adopt", queue.n, *given, *queue.arguments)
    return replace(queue, pixels=Pixels(given[-1], np.uint32(0), np.uint32(1)))


def arranged(device: Device, rays: Any, n: int) -> Any:
    """An order of rays in which neighbours go the same way, for tracing them: a buffer of uint."""
    keys, between, sequence = (device.buffer(4 * n, "uint") for _ in range(3))
    groups = -(-n // layout.ARRANGED)
    device.launch("arrange", groups, rays, np.uint32(n), keys, between, sequence, local_size=1)
    return sequence


def closest(device: Device, world: World, queue: Queue, crossing: bool = True) -> QueueHits:
    """Nearest hit of every ray, and what the surface is there.

    `crossing`: rays that carry lists of media go on through boundaries that they do not see, and their
    weights are what the media leave of them. To be done once.
    """
    n, fields = queue.n, device.ray_format.surface_fields
    hits = QueueHits(
        device.buffer(4 * n, "float"),
        device.buffer(4 * n, "int"),
        device.buffer(block_bytes(n, fields, device.settings.lanes), "float"),
        device.buffer(4 * n, "int"),
    )
    arguments = (*world.arguments, *queue.arguments, *hits.arguments)
    sequence = arranged(device, queue.rays, n) if queue.kind == AMBIENT and world.small else None
    device.launch_packets("closest", n, *arguments, sequence)
    # what a hit is does not depend on what a ray carries, but for cones
    cones = device.for_queue(queue.narrow and device.ray_format.mips)
    cones.launch_packets("surface", n, *arguments)
    if crossing and world.flat.media is not None:
        device.for_queue(queue.narrow).launch_packets("cross_boundaries", n, *arguments, queue.overflow)
    return hits


def shade(
    device: Device,
    world: World,
    queue: Queue,
    hits: QueueHits,
    last: bool,
    terms: int = layout.TERMS["TERM_ALL"],
) -> Shaded:
    """Local light of every hit, and the count of what each will spawn."""
    kernels = device.for_queue(queue.narrow)
    local = device.buffer(block_bytes(queue.n, kernels.ray_format.values, device.settings.lanes), "float")
    spawn = device.buffer(4 * queue.n, "uint")
    how = (np.uint32(queue.kind == AMBIENT), np.uint32(last), np.uint32(terms))
    groups = (*queue.arguments, *hits.arguments, local, spawn, *queue.pixels.arguments)
    kernels.launch_packets("shade", queue.n, *world.arguments, *groups, *how)
    streams = len(layout.streams(device.ray_format.group))
    offsets = device.buffer(4 * chunks(queue.n) * streams, "uint")
    totals = device.buffer(8 * streams, "ulong")
    sizes = (np.uint32(queue.n), np.uint32(world.ambient_samples), np.uint32(chunks(queue.n)))
    device.launch("count", chunks(queue.n), spawn, *sizes, offsets)
    device.launch("offsets", 1, np.uint32(chunks(queue.n)), offsets, totals, local_size=1)
    return Shaded(local, spawn, offsets, device.ask(totals, np.zeros(streams, np.uint64)))


def _first_places(device: Device, world: World, queue: Queue, shaded: Shaded, stream: str) -> Any:
    """Each ray's first place in a stream: a buffer of uint."""
    first = device.buffer(4 * queue.n, "uint")
    sizes = (np.uint32(queue.n), np.uint32(world.ambient_samples), np.uint32(chunks(queue.n)))
    which = np.uint32(_STREAM[stream])
    device.launch("scan", chunks(queue.n), shaded.spawn, *sizes, shaded.offsets, which, first)
    return first


def feelers(device: Device, world: World, queue: Queue, hits: QueueHits, shaded: Shaded) -> Feelers:
    """Emit a shadow feeler for each point of a light above each hit, and find which arrive."""
    n, lanes = shaded.totals["FEELERS"], device.settings.lanes
    kernels = device.for_queue(queue.narrow)
    found = Feelers(
        n,
        shaded.offsets,  # whose first stream is that of feelers
        device.buffer(4 * n, "uint"),
        device.buffer(block_bytes(n, len(layout.RAY_FIELDS), lanes), "float"),
        device.buffer(4 * n, "uint"),
        device.buffer(4 * n, "int") if world.surfaces else None,
        device.buffer(block_bytes(n if world.tinted else 0, kernels.ray_format.values, lanes), "float"),
        world.tinted,
    )
    if n:
        lit_by = (*shaded.arguments, *queue.pixels.arguments, *found.arguments)
        groups = (*queue.arguments, *hits.arguments, *lit_by)
        kernels.launch_chunks("feelers", queue.n, *world.arguments, *groups)
        arguments = (*world.arguments, found.rays, np.uint32(n), found.seen)
        if world.tinted:
            through = found.filter, found.own, queue.overflow
            kernels.launch_packets("occluded_tinted", n, *arguments, *through)
        else:
            sequence = arranged(device, found.rays, n) if queue.kind in _SCATTERED else None
            device.launch_packets("occluded", n, *arguments, sequence, found.own)
    return found


def illuminate(
    device: Device,
    world: World,
    queue: Queue,
    hits: QueueHits,
    shaded: Shaded,
    feelers: Feelers,
    terms: int = layout.TERMS["TERM_ALL"],
) -> None:
    """Add what comes from the lights that the feelers have reached to the local light. To be done once."""
    if feelers.n:
        lit_by = (*shaded.arguments, *queue.pixels.arguments, *feelers.arguments)
        groups = (*queue.arguments, *hits.arguments, *lit_by)
        kernels = device.for_queue(queue.narrow)
        kernels.launch_chunks("illuminate", queue.n, *world.arguments, *groups, np.uint32(terms))


def gather(
    device: Device,
    queue: Queue,
    shaded: Shaded,
    film: Any,
    plane: int,
    pixels: int,
    path_mask: int = 0,
    path_value: int = 0,
) -> None:
    """Add what the rays bring to their pixels; only rays with path & path_mask == path_value."""
    where = (np.uint32(path_mask), np.uint32(path_value), np.uint32(plane), np.uint32(pixels))
    kernels = device.for_queue(queue.narrow)
    kernels.launch_chunks("gather", queue.n, *queue.arguments, *shaded.arguments, *where, film)


def weigh_samples(device: Device, camera: Any, queue: Queue) -> Weights:
    """What each camera ray counts for in its pixel, by the camera's filter."""
    found = Weights(device.buffer(4 * queue.n, "float"), int(queue.pixels.samples))
    numbers, n = queue.pixels.numbers, np.uint32(queue.n)
    device.launch_packets("weigh_samples", queue.n, camera, numbers, n, found.buffer)
    return found


def _sources(
    kind: str, narrow: bool, parents: list[tuple[Queue, QueueHits, Shaded]]
) -> list[tuple[str, str, Queue, QueueHits, Shaded]]:
    """The kernel and the stream by which each queue spawns rays of a kind, for those that do."""
    found = []
    for queue, hits, shaded in parents:
        kernel, stream = _SPAWNING[kind]
        if queue.narrow != narrow:
            if queue.narrow or kind != TRANSMISSION:
                continue
            kernel, stream = "disperse", "GROUPS"
        if shaded.totals[stream]:
            found.append((kernel, stream, queue, hits, shaded))
    return found


def spawn(
    device: Device,
    world: World,
    kind: str,
    generation: int,
    parents: list[tuple[Queue, QueueHits, Shaded]],
    narrow: bool = False,
) -> Queue | None:
    """The next generation's queue of one kind, from all queues of this generation; None if it is empty.

    A ray's place is the number of children that stand before it: those of its own queue (`scan`), and those
    of the others with a smaller pixel, or the same pixel and an earlier queue (`rank`). `narrow`: the queue
    whose rays carry one dispersion group each.
    """
    sources = _sources(kind, narrow, parents)
    if not sources:
        return None
    firsts = [_first_places(device, world, queue, shaded, stream) for _, stream, queue, _, shaded in sources]
    total = sum(shaded.totals[stream] for _, stream, _, _, shaded in sources)
    child = new_queue(device.for_queue(narrow), kind, total, parents[0][0].overflow)
    for i, (kernel, stream, queue, hits, shaded) in enumerate(sources):
        slots = firsts[i] if len(sources) == 1 else _first_places(device, world, queue, shaded, stream)
        for j, (_, other_stream, other, _, other_lit) in enumerate(sources):
            if i != j:
                sizes = (np.uint32(other_lit.totals[other_stream]), np.uint32(j < i))
                numbers = (other.pixel_of, firsts[j], np.uint32(other.n), *sizes)
                device.launch("rank", chunks(queue.n), queue.pixel_of, np.uint32(queue.n), *numbers, slots)
        groups = (*queue.arguments, *hits.arguments, *shaded.arguments, slots, *child.written)
        kernels = device.for_queue(queue.narrow)
        launch = kernels.launch if kind == AMBIENT else kernels.launch_packets
        drawn = queue.pixels.arguments if kernel == "reflect" else ()
        launch(kernel, queue.n, *world.arguments, *groups, np.uint32(generation), *drawn)
    return child


def geometry(
    device: Device, world: World, queue: Queue, hits: QueueHits, samples: int, camera: np.ndarray
) -> dict[str, np.ndarray]:
    """What `layers.GEOMETRY` lists of the first of every `samples` rays: by name, (n,) or (n, values).

    camera: the record with the eye. Colours are in bands.
    """
    n = queue.n // samples
    out = {}
    for name, layer in GEOMETRY.items():
        size = n if layer.values == 1 else (n, layer.values or device.bands)
        out[name] = np.empty(size, layout.dtype(layer.kind))
    buffers = {name: device.buffer(array.nbytes, element(array.dtype)) for name, array in out.items()}
    groups = (*world.arguments, *queue.arguments, *hits.arguments)
    eye = device.upload(camera, wait=False)
    device.launch("geometry", n, *groups, eye, np.uint32(samples), *buffers.values())
    if world.flat.seen is not None:
        for name in (name for name, layer in GEOMETRY.items() if layer.picture == "color"):
            buffers[name] = develop(device, buffers[name], n, world.flat.seen)
            out[name] = np.empty((n, len(world.flat.seen)), np.float32)
    return {name: device.read(buffers[name], array) for name, array in out.items()}


def develop(device: Device, film: Any, n: int, matrix: np.ndarray) -> Any:
    """A buffer of (n, rows) from one of (n, bands) and a matrix (rows, bands) float32."""
    developed = device.buffer(4 * n * len(matrix), "float")
    rows = device.upload(matrix, wait=False)
    device.launch_packets("develop", n, film, np.uint32(n), rows, np.uint32(len(matrix)), developed)
    return developed
