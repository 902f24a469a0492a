"""The values of every pass of a device, in the stages of the float32 twin."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from clrt import film as device_film
from clrt import layout, passes
from clrt.device import Device
from clrt.immersion import immerse
from clrt.queues import Hits, Lit, Queue
from clrt.wavefront import spawned_kinds
from clrt.world import World

from .twin_wavefront import SPAWNING, Stage

LAYERS = (
    "direct",
    "reflection",
    "transmission",
    "generation_0",
    "emission",
    "ambient",
    "diffuse",
    "highlight",
)


def device_stages(
    device: Device, world: World, queue: Queue, pixels: int, samples: int, max_depth: int
) -> Iterator[Stage]:
    """The generation loop of `clrt.wavefront`, one stage at a time."""
    film = device_film.Film(device, pixels, LAYERS)
    immerse(device, world, queue)
    yield _queue_stage(device, "generate", 0, queue)
    first, first_hits = queue, None
    queues = [queue]
    for generation in range(max_depth + 1):
        parents = []
        for queue in queues:
            hits = passes.closest(device, world, queue)
            first_hits = first_hits or hits
            place = _words(device, queue.pixel_of, queue.n)
            values = {
                "t": _words(device, hits.t, queue.n, np.float32),
                "primitive": _words(device, hits.primitive, queue.n, np.int32),
            }
            yield Stage("closest", generation, queue.kind, values, place)
            yield Stage("surface", generation, queue.kind, _surface(device, queue, hits), place)
            last = generation == max_depth
            if generation == 0:
                film.add_terms(world, queue, hits, last)
            lit = passes.light(device, world, queue, hits, last)
            values = {"spawn": _words(device, lit.spawn, queue.n), "local": _local(device, queue, lit)}
            yield Stage("light", generation, queue.kind, values, place)
            shadows = passes.feelers(device, world, queue, hits, lit)
            owner = _words(device, shadows.owner, shadows.n)
            by_ray = np.argsort(owner, kind="stable")
            values = _rays(device, shadows.rays, shadows.n)
            values["seen"] = _words(device, shadows.seen, shadows.n)
            if world.tinted:
                values["filter"] = _blocks(device, shadows.filter, shadows.n, _values(device, queue))
            values = {name: array[..., by_ray] for name, array in values.items()}
            yield Stage("feelers", generation, queue.kind, values, place[owner[by_ray]])
            passes.illuminate(device, world, queue, hits, lit, shadows)
            yield Stage("illuminate", generation, queue.kind, {"local": _local(device, queue, lit)}, place)
            film.add(queue, lit, generation)
            parents.append((queue, hits, lit))
        queues = []
        for kind, narrow in spawned_kinds(device):
            child = passes.spawn(device, world, kind, generation, parents, narrow)
            shown = child or passes.new_queue(device.for_queue(narrow), kind, 0)
            yield _queue_stage(device, SPAWNING[kind], generation + 1, shown)
            if child:
                queues.append(child)
        if not queues:
            break
    place = np.arange(pixels, dtype=np.uint32)
    yield Stage("gather", max_depth, "film", {"sums": _film(device, film, pixels)}, place)
    film.develop(samples)
    yield Stage("resolve", max_depth, "film", {"means": _film(device, film, pixels)}, place)
    if world.flat.response is not None:
        rows = film.read(world.flat.response)
        values = {"rows": np.ascontiguousarray(rows.transpose(0, 2, 1))}
        yield Stage("develop", max_depth, "film", values, place)
    assert first_hits is not None
    seen = passes.geometry(device, world, first, first_hits, samples)
    yield Stage("geometry", 0, "camera", {name: array.T for name, array in seen.items()}, place)


def _queue_stage(device: Device, name: str, generation: int, queue: Queue) -> Stage:
    place = _words(device, queue.pixel_of, queue.n)
    values = {
        "pixel_of": place,
        "path": _words(device, queue.path, queue.n),
        **_rays(device, queue.rays, queue.n),
        "weight": _blocks(device, queue.weight, queue.n, _values(device, queue)),
        **_media(device, queue),
    }
    return Stage(name, generation, queue.kind, values, place)


def _local(device: Device, queue: Queue, lit: Lit) -> np.ndarray:
    """Radiance by itself, zeros where the word of a ray says that it is not to be read."""
    local = _blocks(device, lit.local, queue.n, _values(device, queue))
    dark = _words(device, lit.spawn, queue.n) & layout.SPAWN["SPAWN_LOCAL"] == 0
    local[: device.for_queue(queue.narrow).rays.carried, dark] = 0
    return local


def _rays(device: Device, rays: object, n: int) -> dict[str, np.ndarray]:
    fields = _blocks(device, rays, n, len(layout.RAY_FIELDS))
    return {"origin": fields[:3], "direction": fields[3:6], "t_max": fields[6]}


def _surface(device: Device, queue: Queue, hits: Hits) -> dict[str, np.ndarray]:
    fields = _blocks(device, hits.surfaces, queue.n, layout.surface_fields(device.media))
    values = {"point": fields[:3], "n": fields[3:6], "ns": fields[6:9], "offset": fields[9]}
    values["code"] = _words(device, hits.code, queue.n, np.int32)
    if not device.media:
        return values
    tops = fields[10:].view(np.int32)
    weight = _blocks(device, queue.weight, queue.n, _values(device, queue))
    return values | _media(device, queue) | {"before": tops[0], "after": tops[1], "weight": weight}


def _media(device: Device, queue: Queue) -> dict[str, np.ndarray]:
    if not device.media:
        return {}
    media = _blocks(device, queue.media, queue.n, device.media).view(np.int32)
    return {"media": np.where(np.logical_or.accumulate(media < 0, axis=0), np.int32(-1), media)}


def _values(device: Device, queue: Queue) -> int:
    """Of a ray's weight or light."""
    return device.for_queue(queue.narrow).rays.values


def _words(device: Device, buffer: object, n: int, kind: type[np.generic] = np.uint32) -> np.ndarray:
    return device.read(buffer, np.empty(n, kind))


def _blocks(device: Device, buffer: object, n: int, fields: int) -> np.ndarray:
    """(fields, n) of a buffer of blocks (`kernels/ray.clh`)."""
    lanes = device.settings.lanes
    blocks = device.read(buffer, np.empty((-(-n // lanes), fields, lanes), np.float32))
    return np.ascontiguousarray(blocks.transpose(1, 0, 2).reshape(fields, -1)[:, :n])


def _film(device: Device, film: device_film.Film, pixels: int) -> np.ndarray:
    sums = device.read(film.sums, np.empty((len(film.planes), pixels, device.bands), np.float32))
    return np.ascontiguousarray(sums.transpose(0, 2, 1))
