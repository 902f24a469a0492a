"""One function a kernel pass. Each takes queues, launches, and gives back what the next pass needs.

Nothing here decides what the picture is; the kernels do.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from clrt import layout
from clrt.device import Device
from clrt.queues import (
    AMBIENT,
    CAMERA,
    REFLECTION,
    TRANSMISSION,
    Feelers,
    Hits,
    Lit,
    Queue,
    block_bytes,
    chunks,
    new_queue,
)
from clrt.world import World

_STREAM = {name: number for number, name in enumerate(layout.STREAMS)}
_SPAWNING = {
    REFLECTION: ("reflect", "REFLECTION"),
    TRANSMISSION: ("transmit", "TRANSMISSION"),
    AMBIENT: ("gather_ambient", "AMBIENT"),
}


def generate(device: Device, camera: Any, pixels: np.ndarray, samples: int) -> tuple[Queue, Any]:
    """Camera rays of a tile: `samples` a pixel number. Also a buffer with the work-group size it ran with."""
    queue = new_queue(device, CAMERA, len(pixels) * samples)
    local_size = device.buffer(4)
    device.launch_packets(
        "generate",
        queue.n,
        camera,
        device.upload(pixels, wait=False),
        np.uint32(queue.n),
        queue.rays,
        queue.pixel_of,
        queue.path,
        queue.weight,
        local_size,
    )
    return queue, local_size


def adopt(
    device: Device, origins: np.ndarray, directions: np.ndarray, t_max: np.ndarray, numbers: np.ndarray
) -> Queue:
    """A queue of the caller's rays: (n, 3), (n, 3), (n,) float32; the rays' numbers, (n,) uint32.

    Directions are normalised. Numbers stand for the pixels of camera rays: what looks random depends on them.
    """
    queue = new_queue(device, CAMERA, len(origins))
    device.launch(
        "adopt",
        queue.n,
        device.upload(origins, wait=False),
        device.upload(directions, wait=False),
        device.upload(t_max, wait=False),
        device.upload(numbers, wait=False),
        np.uint32(queue.n),
        queue.rays,
        queue.pixel_of,
        queue.path,
        queue.weight,
    )
    return queue


def closest(device: Device, world: World, queue: Queue, crossing: bool = True) -> Hits:
    """Nearest hit of every ray, and what the surface is there.

    `crossing`: rays that carry lists of media go on through boundaries that they do not see, and their
    weights are what the media leave of them. To be done once.
    """
    n, fields = queue.n, layout.surface_fields(device.media)
    hits = Hits(
        device.buffer(4 * n),
        device.buffer(4 * n),
        device.buffer(block_bytes(n, fields, device.settings.lanes)),
        device.buffer(4 * n),
    )
    found = (queue.rays, np.uint32(n), hits.t, hits.primitive)
    device.launch_packets("closest", n, *world.arguments, *found)
    met = (hits.surfaces, hits.code)
    arguments = (*world.arguments, queue.rays, hits.t, hits.primitive, np.uint32(n), *met)
    device.launch_packets("surface", n, *arguments)
    if crossing and world.flat.media is not None:
        lists = (queue.media, queue.weight, world.overflow)
        narrow = device.for_queue(queue.narrow)
        narrow.launch_packets("cross_boundaries", n, *world.arguments, *found, *met, *lists)
    return hits


def light(
    device: Device, world: World, queue: Queue, hits: Hits, last: bool, terms: int = layout.TERMS["TERM_ALL"]
) -> Lit:
    """Local light of every hit, and the count of what each will spawn."""
    kernels = device.for_queue(queue.narrow)
    local = device.buffer(block_bytes(queue.n, kernels.rays.values, device.settings.lanes))
    spawn = device.buffer(4 * queue.n)
    kernels.launch_packets(
        "light",
        queue.n,
        *world.arguments,
        queue.rays,
        hits.surfaces,
        hits.code,
        queue.path,
        queue.weight,
        np.uint32(queue.n),
        np.uint32(queue.kind == AMBIENT),
        np.uint32(last),
        np.uint32(terms),
        local,
        spawn,
    )
    streams = len(layout.streams(device.rays.group))
    offsets = device.buffer(4 * chunks(queue.n) * streams)
    totals = device.buffer(8 * streams)
    sizes = (np.uint32(queue.n), np.uint32(world.ambient_samples), np.uint32(chunks(queue.n)))
    device.launch("count", chunks(queue.n), spawn, *sizes, offsets)
    device.launch("offsets", 1, np.uint32(chunks(queue.n)), offsets, totals, local_size=1)
    return Lit(local, spawn, offsets, device.ask(totals, np.zeros(streams, np.uint64)))


def _first_places(device: Device, world: World, queue: Queue, lit: Lit, stream: str) -> Any:
    """Each ray's first place in a stream: a buffer of uint."""
    first = device.buffer(4 * queue.n)
    sizes = (np.uint32(queue.n), np.uint32(world.ambient_samples), np.uint32(chunks(queue.n)))
    device.launch("scan", chunks(queue.n), lit.spawn, *sizes, lit.offsets, np.uint32(_STREAM[stream]), first)
    return first


def feelers(device: Device, world: World, queue: Queue, hits: Hits, lit: Lit) -> Feelers:
    """Emit one shadow feeler for each light above each hit, and find which arrive."""
    n, lanes = lit.totals["FEELERS"], device.settings.lanes
    kernels = device.for_queue(queue.narrow)
    found = Feelers(
        n,
        _first_places(device, world, queue, lit, "FEELERS"),
        device.buffer(4 * n),
        device.buffer(block_bytes(n, len(layout.RAY_FIELDS), lanes)),
        device.buffer(4 * n),
        device.buffer(block_bytes(n if world.tinted else 0, kernels.rays.values, lanes)),
        world.tinted,
    )
    if n:
        kernels.launch_packets(
            "feelers",
            queue.n,
            *world.arguments,
            hits.surfaces,
            hits.code,
            queue.weight,
            lit.spawn,
            found.first,
            np.uint32(queue.n),
            found.owner,
            found.rays,
            found.filter,
        )
        arguments = (*world.arguments, found.rays, np.uint32(n), found.seen)
        if world.tinted:
            kernels.launch_packets("occluded_tinted", n, *arguments, found.filter)
        else:
            device.launch_packets("occluded", n, *arguments)
    return found


def illuminate(
    device: Device,
    world: World,
    queue: Queue,
    hits: Hits,
    lit: Lit,
    feelers: Feelers,
    terms: int = layout.TERMS["TERM_ALL"],
) -> None:
    """Add what comes from the lights that the feelers have reached to the local light. To be done once."""
    if feelers.n:
        device.for_queue(queue.narrow).launch_packets(
            "illuminate",
            queue.n,
            *world.arguments,
            queue.rays,
            hits.surfaces,
            hits.code,
            queue.weight,
            feelers.first,
            feelers.seen,
            feelers.filter,
            np.uint32(queue.n),
            np.uint32(terms),
            lit.local,
            lit.spawn,
        )


def any_hit(device: Device, world: World, queue: Queue) -> Any:
    """A buffer of uint: 1 where the way of the ray is free up to its t_max."""
    seen = device.buffer(4 * queue.n)
    device.launch_packets(
        "occluded", queue.n, *world.arguments, queue.rays, np.uint32(queue.n), seen
    )
    return seen


def next_hit(device: Device, world: World, queue: Queue, hits: Hits) -> None:
    """Every ray's next hit, in the order of (t, primitive), in place of the one in `hits`; misses stay."""
    found = (queue.rays, np.uint32(queue.n), hits.t, hits.primitive)
    device.launch("next_hit", queue.n, *world.arguments, *found)


def gather(
    device: Device,
    queue: Queue,
    lit: Lit,
    film: Any,
    plane: int,
    pixels: int,
    path_mask: int = 0,
    path_value: int = 0,
) -> None:
    """Add what the rays bring to their pixels; only rays with path & path_mask == path_value."""
    device.for_queue(queue.narrow).launch(
        "gather",
        queue.n,
        queue.pixel_of,
        queue.path,
        np.uint32(queue.n),
        lit.local,
        lit.spawn,
        np.uint32(path_mask),
        np.uint32(path_value),
        np.uint32(plane),
        np.uint32(pixels),
        film,
    )


def _sources(
    kind: str, narrow: bool, parents: list[tuple[Queue, Hits, Lit]]
) -> list[tuple[str, str, Queue, Hits, Lit]]:
    """The kernel and the stream by which each queue spawns rays of a kind, for those that do."""
    found = []
    for queue, hits, lit in parents:
        kernel, stream = _SPAWNING[kind]
        if queue.narrow != narrow:
            if queue.narrow or kind != TRANSMISSION:
                continue
            kernel, stream = "disperse", "GROUPS"
        if lit.totals[stream]:
            found.append((kernel, stream, queue, hits, lit))
    return found


def spawn(
    device: Device,
    world: World,
    kind: str,
    generation: int,
    parents: list[tuple[Queue, Hits, Lit]],
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
    firsts = [_first_places(device, world, queue, lit, stream) for _, stream, queue, _, lit in sources]
    total = sum(lit.totals[stream] for _, stream, _, _, lit in sources)
    child = new_queue(device.for_queue(narrow), kind, total)
    written = (child.rays, child.pixel_of, child.path, child.weight, child.media)
    for i, (kernel, stream, queue, hits, lit) in enumerate(sources):
        slots = firsts[i] if len(sources) == 1 else _first_places(device, world, queue, lit, stream)
        for j, (_, other_stream, other, _, other_lit) in enumerate(sources):
            if i != j:
                sizes = (np.uint32(other_lit.totals[other_stream]), np.uint32(j < i))
                numbers = (other.pixel_of, firsts[j], np.uint32(other.n), *sizes)
                device.launch("rank", chunks(queue.n), queue.pixel_of, np.uint32(queue.n), *numbers, slots)
        words = (queue.pixel_of, queue.path, queue.weight, lit.spawn, slots, queue.media)
        read = (hits.surfaces, hits.code, *words)
        n, kernels = np.uint32(queue.n), device.for_queue(queue.narrow)
        if kind == AMBIENT:
            kernels.launch(kernel, queue.n, *world.arguments, *read, n, np.uint32(generation), *written)
        else:
            kernels.launch_packets(kernel, queue.n, *world.arguments, queue.rays, *read, n, *written)
    return child


def geometry(device: Device, world: World, queue: Queue, hits: Hits, samples: int) -> dict[str, np.ndarray]:
    """Distance, position, normal, uv, primitive and shape of the first of every `samples` rays."""
    n = queue.n // samples
    out = {
        "depth": np.empty(n, np.float32),
        "position": np.empty((n, 3), np.float32),
        "normal": np.empty((n, 3), np.float32),
        "uv": np.empty((n, 2), np.float32),
        "primitive": np.empty(n, np.int32),
        "shape": np.empty(n, np.int32),
    }
    buffers = {name: device.buffer(array.nbytes) for name, array in out.items()}
    device.launch(
        "geometry",
        n,
        *world.arguments,
        queue.rays,
        hits.t,
        hits.primitive,
        np.uint32(n),
        np.uint32(samples),
        *buffers.values(),
    )
    return {name: device.read(buffers[name], array) for name, array in out.items()}
