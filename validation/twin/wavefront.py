"""The float32 twin's generations: the same queues in the same order as on a device, one stage after another.

`generations` is the algorithm. It yields every stage's values, so that a comparison can name the first that
differs, and adds to a film.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator, Iterator
from dataclasses import dataclass, replace

import numpy as np

from clrt import layout
from clrt.flatten.flatten import FlatScene

from .dispersion import carried, own_bands
from .edges import nearest_faces
from .film import TERMS, Film, arriving, rays_counted
from .geometry import primitives_of
from .local import SPAWN, Feelers, Shaded, feelers, shade
from .math import Array, combine
from .media import Crossed, crossed, handed_on, immersed
from .queues import FLAGS, Queue, merged, new_queue
from .shading import ambient_directions, ambient_share
from .surface import Surface, second_color

_ROUTE = np.uint32(layout.PATH["PATH_ROUTE"])
SPAWNING = {"reflection": "reflect", "transmission": "transmit", "ambient": "gather_ambient"}
_GATHERED, _GATHERED_FIRST = layout.PATH["PATH_GATHERED"], layout.PATH["PATH_GATHERED_FIRST"]


@dataclass(frozen=True)
class Stage:
    """The values that one pass computed for one queue, each with the ray's number as its last axis.

    `name` is the kernel's, `kind` the queue's: camera, reflection, transmission or ambient.
    """

    name: str
    generation: int
    kind: str
    values: dict[str, Array]
    pixel_of: Array  # place of each ray's pixel
    term: str = ""  # of local light, of which alone it is


def spawned(
    flat: FlatScene, kind: str, narrow: bool, generation: int, parents: list[tuple[Queue, Shaded]]
) -> Queue:
    """The next generation's queue of one kind, of all bands or of narrow rays."""
    parts = []
    for queue, found in parents:
        if (queue.band is not None) == narrow:
            parts.append(children(flat, kind, generation, queue, found))
        elif narrow and kind == "transmission":
            parts.append(narrow_children(flat, queue, found))
    if parts:
        return merged(parts)
    queue, none = parents[0][0], np.zeros(0, np.uint32)
    media = None if queue.media is None else queue.media[:, :0]
    origin, weight = np.zeros((3, 0), np.float32), queue.weight[:, :0]
    band = none.astype(np.int32) if narrow else None
    return new_queue(kind, origin, origin, none, none, weight, None, media, band)


def narrow_children(flat: FlatScene, queue: Queue, found: Shaded) -> Queue:
    """Transmission rays of one group of bands each, by parent and then by group."""
    groups = found.groups
    hit, group = np.nonzero(np.array(found.parts, bool).reshape(len(groups.first), -1).T)
    parent, s, band = found.which[hit], found.surface[hit], np.array(groups.first, np.int32)[group]
    direction = np.stack([part.transmitted for part in groups.bounces])[group, :, hit].T
    weight = queue.weight[:, parent] * found.bounce.transmit[:, hit]
    weight = np.where(own_bands(flat, band), weight, np.float32(0.0))
    lists = None if queue.media is None else handed_on(flat, queue.media[:, parent], s)
    path = child_path(queue.path[parent], 2, 2)
    origin, cone = s.behind, _cone(queue, parent, s)
    return new_queue(
        "transmission", origin, direction, queue.pixel_of[parent], path, weight, None, lists, band, cone
    )


def _cone(queue: Queue, parent: Array, s: Surface) -> Array:
    """Children go on with their parents' cones."""
    assert queue.rays.cone is not None
    return np.stack([s.footprint[2], queue.rays.cone[1, parent]])


def child_path(path: Array, number: int, route: int) -> Array:
    """The word of children of one kind; `route` for those of rays that have had no bounce."""
    key = combine(path & ~FLAGS, np.full_like(path, number))
    flags = path & FLAGS
    return np.asarray(key & ~FLAGS | np.where(flags & _ROUTE, flags, flags | np.uint32(route)))


def children(flat: FlatScene, kind: str, generation: int, queue: Queue, found: Shaded) -> Queue:
    """The rays of one kind that a queue's hits spawn, with the same bands, in the order of their parents."""
    bit, flag, number = {
        "reflection": ("SPAWN_REFLECTION", 1, 1),
        "transmission": ("SPAWN_TRANSMISSION", 2, 2),
        "ambient": ("SPAWN_AMBIENT", 0, 3),
    }[kind]
    chosen = np.flatnonzero(found.spawn[found.which] & SPAWN[bit])
    parent, s = found.which[chosen], found.surface[chosen]
    path, weight, pixel_of = queue.path[parent], queue.weight[:, parent], queue.pixel_of[parent]
    lists = None if queue.media is None else queue.media[:, parent]
    band = None if queue.band is None else queue.band[parent]
    cone = _cone(queue, parent, s)
    if kind == "ambient":
        samples = int(flat.scene["ambient_samples"][0])
        direction, key = ambient_directions(s, path, samples)
        flags = path & FLAGS | np.uint32(_GATHERED | (_GATHERED_FIRST if generation == 0 else 0))
        own = combine(key[:, None], np.arange(samples, dtype=np.uint32))
        weight = weight * ambient_share(s) / np.float32(samples)
        return new_queue(
            kind,
            np.repeat(s.before, samples, axis=1),
            direction.reshape(3, -1),
            np.repeat(pixel_of, samples),
            (own & ~FLAGS | flags[:, None]).ravel(),
            np.repeat(weight, samples, axis=1),
            media=None if lists is None else np.repeat(lists, samples, axis=1),
            band=None if band is None else np.repeat(band, samples),
            cone=np.repeat(cone, samples, axis=1),
        )
    bounce = found.bounce
    direction, share = (
        (bounce.reflected, bounce.reflect) if kind == "reflection" else (bounce.transmitted, bounce.transmit)
    )
    origin = s.before if kind == "reflection" else s.behind
    if kind == "transmission" and lists is not None:
        lists = handed_on(flat, lists, s)
    path, weight = child_path(path, number, flag), weight * share[:, chosen]
    return new_queue(kind, origin, direction[:, chosen], pixel_of, path, weight, None, lists, band, cone)


def generations(
    flat: FlatScene, queue: Queue, max_depth: int, film: Film, counts: list[Counter[str]]
) -> Iterator[Stage]:
    """Trace a queue of generation 0 and all its descendants onto the film, and count rays by generation."""
    queue = immersed(flat, queue)
    yield stage("generate", 0, queue, queue_values(flat, queue))
    if film.weights is not None:
        yield stage("weigh_samples", 0, queue, {"weights": film.weights.ravel()})
    met = [(yield from _met(flat, queue, 0, max_depth))]
    yield from _terms(flat, met[0][0], max_depth == 0, film)
    for generation in range(max_depth + 1):
        for at, found in met:
            yield _shade(flat, generation, at.queue, found)
        for at, found in met:
            queue = at.queue
            shadows = feelers(flat, queue, found)
            yield from _lights(flat, generation, queue, found, shadows)
            film.add(queue, found, shadows, generation)
            yield _gather(generation, queue, film)
            _count(counts, generation, rays_counted(queue, found, shadows))
        parents, met = [(at.queue, found) for at, found in met], []
        for kind, narrow in kinds_of(flat.group):
            child = spawned(flat, kind, narrow, generation, parents)
            if len(child):
                yield stage(SPAWNING[kind], generation + 1, child, queue_values(flat, child))
                met.append((yield from _met(flat, child, generation + 1, max_depth)))
        if not met:
            break


def _met(
    flat: FlatScene, queue: Queue, generation: int, max_depth: int
) -> Generator[Stage, None, tuple[Crossed, Shaded]]:
    """What the rays of a queue meet, and the light there."""
    at = crossed(flat, queue, nearest_faces(flat, queue.rays))
    yield stage("closest", generation, at.queue, {"t": at.hits.t, "primitive": at.hits.primitive})
    found = shade(flat, at, last=generation == max_depth)
    yield stage("surface", generation, at.queue, surface_values(flat, at, found))
    return at, found


def _terms(flat: FlatScene, at: Crossed, last: bool, film: Film) -> Iterator[Stage]:
    for name in film.planes:
        if name in TERMS:
            found = shade(flat, at, last, TERMS[name])
            shadows = feelers(flat, at.queue, found, TERMS[name])
            yield replace(_shade(flat, 0, at.queue, found), term=name)
            for lit in _lights(flat, 0, at.queue, found, shadows):
                yield replace(lit, term=name)
            film.add_term(name, at.queue, found, shadows)
            yield replace(_gather(0, at.queue, film), term=name)


def _shade(flat: FlatScene, generation: int, queue: Queue, found: Shaded) -> Stage:
    local = carried(flat, found.local, queue.band)
    return stage("shade", generation, queue, {"spawn": found.spawn, "local": local})


def _lights(
    flat: FlatScene, generation: int, queue: Queue, found: Shaded, shadows: Feelers
) -> Iterator[Stage]:
    values = feeler_values(flat, queue, shadows)
    yield stage("feelers", generation, queue, values, queue.pixel_of[shadows.ray])
    lights = {"local": carried(flat, arriving(found, shadows), queue.band)}
    yield stage("illuminate", generation, queue, lights)


def _gather(generation: int, queue: Queue, film: Film) -> Stage:
    return stage("gather", generation, queue, {"sums": film.sums}, np.arange(film.sums.shape[-1]))


def _count(counts: list[Counter[str]], generation: int, row: dict[str, int]) -> None:
    while len(counts) <= generation:
        counts.append(Counter())
    counts[generation].update(row)


def stage(
    name: str, generation: int, queue: Queue, values: dict[str, Array], pixel_of: Array | None = None
) -> Stage:
    return Stage(name, generation, queue.kind, values, queue.pixel_of if pixel_of is None else pixel_of)


def kinds_of(group: int) -> list[tuple[str, bool]]:
    """A generation's queues: kind, narrow."""
    return [(kind, narrow) for narrow in ((False, True) if group else (False,)) for kind in SPAWNING]


def queue_values(flat: FlatScene, queue: Queue) -> dict[str, Array]:
    lists = {} if queue.media is None else {"media": queue.media}
    if flat.ray_format.mips and queue.rays.cone is not None:
        lists["cone"] = queue.rays.cone
    return lists | {
        "pixel_of": queue.pixel_of,
        "path": queue.path,
        "origin": queue.rays.origin,
        "direction": queue.rays.direction,
        "t_max": queue.rays.t_max,
        "weight": carried(flat, queue.weight, queue.band),
    }


def surface_values(flat: FlatScene, at: Crossed, found: Shaded) -> dict[str, Array]:
    """Zeros and the code -1 on a miss; what crossing boundaries made of rays that carry lists of media."""
    s, which, hits = found.surface, found.which, at.hits
    n = len(hits.t)
    fields = np.zeros((10, n), np.float32)
    fields[:, which] = np.concatenate([s.point, s.n, s.ns, s.offset[None]])
    material = primitives_of(flat)["material"][hits.primitive[which]]
    bits = layout.SURFACE
    code = np.full(n, -1, np.int32)
    code[which] = material * bits["SURFACE_MATERIAL"] + s.inside * bits["SURFACE_INSIDE"]
    code[which] += second_color(s) * bits["SURFACE_SECOND_COLOR"] + s.at_edge * bits["SURFACE_EDGE"]
    values = {"point": fields[:3], "n": fields[3:6], "ns": fields[6:9], "offset": fields[9], "code": code}
    if flat.pictured is not None:
        values["uv"] = np.zeros((2, n), np.float32)
        values["uv"][:, which] = s.place
    if flat.ray_format.mips:
        values["footprint"] = np.zeros((3, n), np.float32)
        values["footprint"][:, which] = s.footprint
    if at.queue.media is not None and at.before is not None and at.after is not None:
        weight = carried(flat, at.queue.weight, at.queue.band)
        values |= {"media": at.queue.media, "before": at.before, "after": at.after, "weight": weight}
    return values


def feeler_values(flat: FlatScene, queue: Queue, shadows: Feelers) -> dict[str, Array]:
    """Of opaque shadows `filter` is of no use, and is not kept."""
    tints = {}
    if flat.scene["tinted"][0]:
        band = None if queue.band is None else queue.band[shadows.ray]
        tints["filter"] = carried(flat, shadows.filter, band, beyond=True)
    return tints | {
        "origin": shadows.rays.origin,
        "direction": shadows.rays.direction,
        "t_max": shadows.rays.t_max,
        "seen": shadows.seen,
    }
