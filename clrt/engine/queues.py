"""Queues: buffers and a count. What the passes hand to each other, and how many bytes it takes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from operator import attrgetter
from typing import Any, ClassVar, Final

import numpy as np

from clrt import layout
from clrt.device.device import Device
from clrt.device.settings import Settings
from clrt.device.tracks import Answer
from clrt.layout import ceilings

CAMERA: Final = "camera"
REFLECTION: Final = "reflection"
TRANSMISSION: Final = "transmission"
AMBIENT: Final = "ambient"
_WORDS: Final = 2 + 3 + 1 + 4  # of a ray: pixel and path; hit and code; spawn; places in four streams
_MANY_GROUPS: Final = 8  # of bands that dispersion bends apart


class _Parameters:
    """What kernels take as one of the groups of parameters in `clrt.layout`."""

    _fields: ClassVar[attrgetter[tuple[Any, ...]]]

    @cached_property
    def arguments(self) -> tuple[Any, ...]:
        """What the group's kernel parameters take, in their order."""
        return type(self)._fields(self)


@dataclass(frozen=True)
class Pixels(_Parameters):
    """Which pixels the rays of generation 0 belong to, `samples` next to each other; of others not known."""

    numbers: Any  # uint: of the pixels in the picture
    seed: np.uint32
    samples: np.uint32
    _fields = attrgetter(*layout.PIXELS)


_UNKNOWN: Final = Pixels(None, np.uint32(0), np.uint32(0))


@dataclass(frozen=True)
class Queue(_Parameters):
    """Rays of one kind and generation, in the order of their pixels."""

    kind: str
    n: int
    rays: Any  # blocks of layout.RAY_FIELDS
    pixel_of: Any  # uint: place of the pixel in the tile
    path: Any  # uint: layout.PATH
    weight: Any  # blocks of layout.RayFormat.values
    media: Any  # blocks of layout.MEDIA numbers of materials, where rays carry them
    device: Device  # whose kernels know what these rays carry
    overflow: Any  # one of layout.OVERFLOW once these rays, or others of their piece, met too much; 0 before
    pixels: Pixels = _UNKNOWN

    _fields = attrgetter(*layout.CHILD)

    @property
    def written(self) -> tuple[Any, ...]:
        """What CHILD_PARAMETERS take."""
        return Queue._fields(self)

    @cached_property
    def arguments(self) -> tuple[Any, ...]:
        """What QUEUE_PARAMETERS take."""
        return (*self.written, np.uint32(self.n))

    @property
    def narrow(self) -> bool:
        """Does each ray carry one dispersion group of bands?"""
        return self.device.ray_format.narrow

    def words(self, buffer: Any, kind: type[np.generic] = np.uint32, n: int | None = None) -> np.ndarray:
        """(n,) of a buffer with a word a ray, or for `n` other items."""
        return self.device.read(buffer, np.empty(self.n if n is None else n, kind))

    def blocks(self, buffer: Any, fields: int, n: int | None = None) -> np.ndarray:
        """(fields, n) float32 of a buffer of blocks (`kernels/ray.clh`), of rays or `n` other items."""
        n, lanes = self.n if n is None else n, self.device.settings.lanes
        blocks = self.device.read(buffer, np.empty((-(-n // lanes), fields, lanes), np.float32))
        return np.ascontiguousarray(blocks.transpose(1, 0, 2).reshape(fields, -1)[:, :n])

    def bands(self, buffer: Any, n: int | None = None) -> np.ndarray:
        """(layout.RayFormat.cone, n) of a buffer of weight or light: all but cones."""
        ray_format = self.device.ray_format
        return self.blocks(buffer, ray_format.values, n)[: ray_format.cone]

    def cones(self) -> dict[str, np.ndarray]:
        """`cone` (layout.CONE, n), where rays carry them."""
        ray_format = self.device.ray_format
        if not ray_format.mips:
            return {}
        return {"cone": self.blocks(self.weight, ray_format.values)[ray_format.cone :]}

    def lines(self, buffer: Any, n: int | None = None) -> dict[str, np.ndarray]:
        """`origin`, `direction` (3, n) and `t_max` (n,) of a buffer of rays."""
        fields = self.blocks(buffer, len(layout.RAY_FIELDS), n)
        return {"origin": fields[:3], "direction": fields[3:6], "t_max": fields[6]}

    def lists(self) -> dict[str, np.ndarray]:
        """`media` (layout.MEDIA, n) int32, -1 from the first empty place on, where rays carry them."""
        if not self.device.media:
            return {}
        media = self.blocks(self.media, self.device.media).view(np.int32)
        return {"media": np.where(np.logical_or.accumulate(media < 0, axis=0), np.int32(-1), media)}

    def decoded(self, queue: Queue) -> dict[str, np.ndarray]:
        """The rays themselves."""
        words = {"pixel_of": self.words(self.pixel_of), "path": self.words(self.path)}
        carried = {"weight": self.bands(self.weight)} | self.cones() | self.lists()
        return words | self.lines(self.rays) | carried


@dataclass(frozen=True)
class QueueHits(_Parameters):
    t: Any  # float
    primitive: Any  # int, -1 on a miss
    surfaces: Any  # blocks of layout.surface_fields
    code: Any  # int: layout.SURFACE and the material, -1 on a miss
    _fields = attrgetter(*layout.HITS)

    def decoded(self, queue: Queue) -> dict[str, np.ndarray]:
        """Distances, primitives and surfaces; with lists of media also what crossing boundaries changed."""
        fields = queue.blocks(self.surfaces, queue.device.ray_format.surface_fields)
        values = {
            "t": queue.words(self.t, np.float32),
            "primitive": queue.words(self.primitive, np.int32),
            "point": fields[:3],
            "n": fields[3:6],
            "ns": fields[6:9],
            "offset": fields[9],
            "code": queue.words(self.code, np.int32),
        }
        ray_format = queue.device.ray_format
        if ray_format.images:
            values["uv"] = fields[ray_format.place :][:2]
        if ray_format.mips:
            values["footprint"] = fields[ray_format.place + len(layout.UV_FIELDS) :]
        if not queue.device.media:
            return values
        before, after = fields[10:12].view(np.int32)
        tops = {"before": before, "after": after, "weight": queue.bands(queue.weight)}
        return values | queue.lists() | tops


@dataclass(frozen=True)
class Shaded(_Parameters):
    """What the pass `shade` found for a queue."""

    local: Any  # blocks of one value a band: radiance that needs no further ray
    spawn: Any  # uint: layout.SPAWN
    offsets: Any  # uint: for each stream, the first place of each chunk's rays in it
    counted: Answer  # uint64: the items of each stream
    _fields = attrgetter(*layout.SHADED)

    @cached_property
    def totals(self) -> dict[str, int]:
        """The items of each stream, by its name; waits until they are counted."""
        return dict(zip(layout.STREAMS, map(int, self.counted.wait()), strict=False))

    def decoded(self, queue: Queue) -> dict[str, np.ndarray]:
        """`spawn`, and `local`: 0 where the word of a ray says that there is no light."""
        spawn, local = queue.words(self.spawn), queue.bands(self.local)
        local[: queue.device.ray_format.carried, spawn & layout.SPAWN["SPAWN_LOCAL"] == 0] = 0
        return {"spawn": spawn, "local": local}


@dataclass(frozen=True)
class Weights:
    """What each camera ray counts for in its pixel, by the camera's filter."""

    buffer: Any  # float
    samples: int  # of a pixel

    def decoded(self, queue: Queue) -> dict[str, np.ndarray]:
        """`weights` (n,) float32."""
        return {"weights": queue.words(self.buffer, np.float32)}


@dataclass(frozen=True)
class Feelers(_Parameters):
    """Shadow feelers of a queue: packet after packet of its rays, in each light after light."""

    n: int
    first: Any  # uint: for each chunk of rays, how many belong to rays before it
    owner: Any  # uint: the ray that each belongs to
    rays: Any  # blocks of layout.RAY_FIELDS
    seen: Any  # uint: 0 where something blocks the light, else one of layout.SEEN
    own: Any  # int: where lights are seen, the primitive of the one that each goes to, -1 of others
    filter: Any  # where shadows are tinted, blocks of layout.RayFormat.values: what comes through a band of
    # those that are seen and not clear
    tinted: bool
    _fields = attrgetter(*layout.FEELERS)

    def decoded(self, queue: Queue) -> dict[str, np.ndarray]:
        """The feelers: `owner` is the number of each one's ray."""
        seen = queue.words(self.seen, n=self.n)
        arrives = np.where(seen == layout.SEEN["FILTERED"], np.uint32(1), seen)
        found = {"owner": queue.words(self.owner, n=self.n), "seen": arrives}
        found |= queue.lines(self.rays, self.n)
        if self.tinted:
            found["filter"] = queue.bands(self.filter, self.n)
            found["filter"][: queue.device.ray_format.carried, seen == layout.SEEN["CLEAR"]] = 1
        return found


def chunks(n: int) -> int:
    """Work-items for n rays, a chunk of the compaction each."""
    return -(-n // layout.CHUNK)


def block_bytes(n: int, fields: int, lanes: int) -> int:
    """Bytes of a queue of `n` items with `fields` floats each, in whole blocks."""
    return -(-n // lanes) * lanes * fields * 4


def queue_bytes(n: int, ray_format: layout.RayFormat, lanes: int) -> int:
    """Bytes of a Queue with its hits, local light, counts and places."""
    return block_bytes(n, _fields(ray_format), lanes) + 4 * n * _WORDS


def _fields(ray_format: layout.RayFormat) -> int:
    media = ray_format.media
    return len(layout.RAY_FIELDS) + ray_format.surface_fields + 2 * ray_format.values + media


def tile_rays(ray_format: layout.RayFormat, settings: Settings) -> int:
    """Rays of generation 0 to trace at a time: the setting, or 131 072 in RGB.

    With more bands as many bytes, or half of them where a ray may be split into many narrow ones. Fewer rays
    would wait for the host, whose part of a tile is the same however many it has; more would pass by the
    caches.
    """
    if settings.tile:
        return min(settings.tile, ceilings.RAYS)
    many = 0 < _MANY_GROUPS * ray_format.group < ray_format.bands
    number = 1 << 16 if many else 1 << 17
    return number * (_fields(layout.RayFormat()) + _WORDS) // (_fields(ray_format) + _WORDS)


def picture_tile(rays: int, tile: int) -> int:
    """Rays of a tile of a picture of so many rays, where `tile` would do for a large one.

    A small one is cut in two or three, of at most two such tiles each: while one part waits for the host the
    others go on, and what the host does for a tile, which a small picture waits for, is done less often.
    """
    if tile // 2 < rays <= 6 * tile:
        return -(-rays // max(2, -(-rays // (2 * tile))))
    return tile


def feeler_bytes(
    n: int, ray_format: layout.RayFormat, lanes: int, tinted: bool, surfaces: bool = False
) -> int:
    """Bytes of the Feelers."""
    fields = len(layout.RAY_FIELDS) + (ray_format.values if tinted else 0)
    return block_bytes(n, fields, lanes) + 4 * n * (2 + surfaces)  # owner, seen, own


def new_queue(device: Device, kind: str, n: int, overflow: Any = None) -> Queue:
    """Memory for rays of what the device's kernels know rays to carry.

    overflow: what the rays share that they come of; None: they are the first of a piece. Others may be traced
    at the same time, for a picture of their own.
    """
    lanes = device.settings.lanes
    if overflow is None:
        overflow = device.buffer(4, "uint")
        device.fill(overflow, 4)
    media = device.buffer(block_bytes(n, device.media, lanes), "int") if device.media else None
    return Queue(
        kind,
        n,
        device.buffer(block_bytes(n, len(layout.RAY_FIELDS), lanes), "float"),
        device.buffer(4 * n, "uint"),
        device.buffer(4 * n, "uint"),
        device.buffer(block_bytes(n, device.ray_format.values, lanes), "float"),
        media,
        device,
        overflow,
    )
