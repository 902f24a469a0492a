"""Several pieces of work at a time, so that the device is busy while the host decides about one of them."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from typing import Generic, TypeVar

from clrt.base import ending
from clrt.base.errors import LimitError, MemoryLimitError
from clrt.base.log import log
from clrt.device.device import TRACKS, Device
from clrt.device.tracks import Answer

Piece = TypeVar("Piece")
Result = TypeVar("Result")
Work = Generator[Answer, None, Result]  # yields what it is about to wait for


class TooLarge(Exception):
    """A piece of work would need more memory than it may have; it must be split."""


@dataclass(frozen=True, eq=False)
class _Running(Generic[Piece, Result]):
    piece: Piece
    device: Device
    work: Work[Result]
    awaits: Answer | None = None  # None: not begun yet


def complete(work: Work[Result]) -> Result:
    """Do one piece of work from beginning to end."""
    while True:
        try:
            next(work)
        except StopIteration as end:
            return end.value


def _split_or(error: MemoryLimitError, split: Callable[[Piece], list[Piece]], piece: Piece) -> list[Piece]:
    """The parts of a piece; the error itself where it has no parts."""
    try:
        return split(piece)
    except LimitError:
        raise error from None


def interleaved(
    device: Device,
    pieces: list[Piece],
    begin: Callable[[Device, Piece], Work[Result]],
    split: Callable[[Piece], list[Piece]],
) -> Iterator[tuple[Piece, Result]]:
    """Do the work of all pieces, the last one first: pairs of a piece and its result, in the order they end.

    Each piece has a track of the device to itself, which `begin` gets. One that turns out to be TooLarge is
    given up, and what `split` makes of it is done in its place. One for which the device has no memory left
    is done again when no other is under way, from then on one at a time; if it does not even fit alone, it is
    split, too.
    """
    together = TRACKS
    running: list[_Running[Piece, Result]] = []  # the longest waiting first
    free = [device.on(track) for track in range(TRACKS)]
    while pieces or running:
        ending.check()
        if pieces and len(running) < together:
            piece, track = pieces.pop(), free.pop()
            now = _Running(piece, track, begin(track, piece))
        else:
            now = next((one for one in running if one.awaits and one.awaits.ready), running[0])
            running.remove(now)
        try:
            awaits = next(now.work)
        except StopIteration as end:
            free.append(now.device)
            now.device.finish()
            yield now.piece, end.value
        except TooLarge:
            free.append(now.device)
            parts = split(now.piece)
            log.debug("a piece needs too much memory: done in %d parts", len(parts))
            pieces += parts
        except MemoryLimitError as error:
            free.append(now.device)
            together = 1
            pieces += [now.piece] if running else _split_or(error, split, now.piece)
        else:
            now.device.flush()
            running.append(_Running(now.piece, now.device, now.work, awaits))
