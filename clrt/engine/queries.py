"""Questions about a caller's rays: the nearest hit, whether there is any, all that a ray crosses.

Answers are written once, by the kernels, into arrays that are made once; only what is asked for is computed.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from clrt.base.limits import Limits
from clrt.device.device import Device
from clrt.device.shared import Work
from clrt.engine.answers import FIELDS, Crossings, Hits
from clrt.engine.batch import Batch, Piece
from clrt.engine.corners import lacking, turn_back
from clrt.engine.world import World

_SURFACE: Final = ("shape", "normal", "u", "v")  # what the kernel `met` finds, in the order of its parameters
_GROUP: Final = 16  # work-items of a group: their walks keep stacks
_MOST: Final = 1 << 30  # crossings of a launch, whose places are 32-bit numbers
_RESOLVED: Final = 1 << 16  # crossings whose rays are written out at a time


def intersect(
    device: Device, world: World, batch: Batch, names: tuple[str, ...], turned: np.ndarray | None
) -> Hits:
    """The nearest hits, of which `names` are asked for. turned: as `corners.turned_meshes` has it."""
    found = _arrays(device, batch.n, names)
    for piece in batch.pieces(device.settings.tile):
        work = Work(device)
        asked = piece.arguments(work)
        arrays = _part(found, slice(piece.start, piece.stop), turned)
        kept = {name: work.answer(array) for name, array in arrays.items()}
        t = kept["t"] if "t" in kept else device.buffer(4 * piece.n, "float")
        primitive = kept["primitive"] if "primitive" in kept else device.buffer(4 * piece.n, "int")
        device.launch_packets("nearest", piece.n, *world.arguments, *asked, t, primitive)
        if not kept.keys().isdisjoint(_SURFACE):
            surface = [kept.get(name) for name in _SURFACE]
            device.launch_packets("met", piece.n, *world.arguments, *asked, t, primitive, *surface)
        work.take()
        turn_back(arrays, turned)
    return Hits.of(found, batch.shape)


def occluded(device: Device, world: World, batch: Batch) -> np.ndarray:
    """(...) bool: whether anything is hit."""
    _limits(device).check("host_bytes", batch.n, place="rays")
    found = np.empty(batch.n, np.uint8)
    for piece in batch.pieces(device.settings.tile):
        work = Work(device)
        arguments = (*piece.arguments(work), work.answer(found[piece.start : piece.stop]))
        device.launch_packets("blocked", piece.n, *world.arguments, *arguments)
        work.take()
    return found.view(bool).reshape(batch.shape)


def count_hits(device: Device, world: World, batch: Batch) -> np.ndarray:
    """(...) int32: how many surfaces each ray crosses."""
    _limits(device).check("host_bytes", 4 * batch.n, place="rays")
    found = np.empty(batch.n, np.int32)
    for piece in batch.pieces(device.settings.tile):
        work = Work(device)
        arguments = (*piece.arguments(work), work.answer(found[piece.start : piece.stop]))
        device.launch("count_crossings", piece.n, *world.arguments, *arguments, local_size=_GROUP)
        work.take()
    return found.reshape(batch.shape)


def all_hits(
    device: Device, world: World, batch: Batch, names: tuple[str, ...], turned: np.ndarray | None
) -> Crossings:
    """All that the rays cross, of which `names` are asked for. turned: as for `intersect`."""
    _limits(device).check("host_bytes", 12 * batch.n, place="rays")
    splits = np.zeros(batch.n + 1, np.int64)
    np.cumsum(count_hits(device, world, batch).reshape(-1), out=splits[1:])
    found = _arrays(device, int(splits[-1]), ("t", "primitive", *(n for n in names if n in _SURFACE)))
    for start, end in batch.ranges(device.settings.tile):
        while start < end:
            fitting = int(np.searchsorted(splits, splits[start] + _MOST, "right")) - 1
            stop = min(max(fitting, start + 1), end)
            _list(device, world, batch.piece(start, stop), splits[start : stop + 1], found)
            start = stop
    if not found.keys().isdisjoint(_SURFACE):
        _resolve(device, world, batch, splits, found, turned)
    return Crossings.of({name: found[name] for name in names}, splits)


def _list(
    device: Device, world: World, piece: Piece, splits: np.ndarray, found: dict[str, np.ndarray]
) -> None:
    """Distances and primitives of what the rays of a piece cross."""
    part = slice(splits[0], splits[-1])
    if part.start == part.stop:
        return
    work = Work(device)
    asked = piece.arguments(work)
    places = work.given((splits[:-1] - splits[0]).astype(np.uint32))
    answers = [work.answer(found[name][part]) for name in ("t", "primitive")]
    device.launch("list_crossings", piece.n, *world.arguments, *asked, places, *answers, local_size=_GROUP)
    work.take()


def _resolve(
    device: Device,
    world: World,
    batch: Batch,
    splits: np.ndarray,
    found: dict[str, np.ndarray],
    turned: np.ndarray | None,
) -> None:
    """What the surfaces are that are crossed."""
    for start in range(0, int(splits[-1]), _RESOLVED):
        part = slice(start, min(start + _RESOLVED, int(splits[-1])))
        rays = np.searchsorted(splits, np.arange(part.start, part.stop), "right") - 1
        crossings = Batch(*batch.some(rays), 0.0, np.inf).piece(0, len(rays))
        work = Work(device)
        asked = crossings.arguments(work)
        known = [work.given(found[name][part]) for name in ("t", "primitive")]
        arrays = _part({name: found[name] for name in _SURFACE if name in found}, part, turned)
        surface = [work.answer(arrays[name]) if name in arrays else None for name in _SURFACE]
        device.launch_packets("met", len(rays), *world.arguments, *asked, *known, *surface)
        work.take()
        turn_back(arrays, turned)


def _arrays(device: Device, n: int, names: tuple[str, ...]) -> dict[str, np.ndarray]:
    """Room for answers, by name."""
    kinds = {name: FIELDS[name] for name in names}
    _limits(device).check("host_bytes", 4 * n * sum(values for _, values in kinds.values()), place="rays")
    return {name: np.empty(n if size == 1 else (n, size), kind) for name, (kind, size) in kinds.items()}


def _part(found: dict[str, np.ndarray], part: slice, turned: np.ndarray | None) -> dict[str, np.ndarray]:
    """The part of the answers, and room for what is needed besides to tell u and v."""
    more = {name: np.empty(part.stop - part.start, FIELDS[name][0]) for name in lacking(found, turned)}
    return {name: array[part] for name, array in found.items()} | more


def _limits(device: Device) -> Limits:
    return device.settings.limits
