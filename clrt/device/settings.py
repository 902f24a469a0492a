"""How to run, never what the image is: tile and work-group sizes, lanes, threads, limits."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from clrt.base.arguments import flag, instance, optional, whole
from clrt.base.errors import ClrtError, fault
from clrt.base.limits import Limits

_MOST: Final = 2**31 - 1  # work-items of a work-group, far beyond any device
_COUNTS: Final = ("tile", "local_size", "threads")


@dataclass(frozen=True, kw_only=True)
class Settings:
    """How a render runs. The picture has the same bits for every choice made here.

    tile: rays of generation 0 traced at a time (all samples of a pixel stay together), at least 1; None: as
    many as caches are good for, which depends on what they carry (`clrt.engine.queues.tile_rays`).
    local_size: work-items of a work-group, 1 to what the device allows; None: what suits each kernel. Kernels
    that need much memory for each take fewer.
    lanes: rays of a queue block, 8 or 16.
    threads: cores of the device to use; None: all of them. (Intel's runtime lets the thread that waits help,
    so that one more is at work.)
    check: look for numbers that are not finite after each pass (slow): a ClrtError names the first.
    limits: what a render may cost at most.
    """

    tile: int | None = None
    local_size: int | None = None
    lanes: int = 16
    threads: int | None = None
    check: bool = False
    limits: Limits = field(default_factory=Limits)

    def __post_init__(self) -> None:
        plain: dict[str, object] = {n: optional(f"settings.{n}", getattr(self, n), 1) for n in _COUNTS}
        optional("settings.local_size", self.local_size, 1, _MOST)
        plain["lanes"] = whole("settings.lanes", self.lanes)
        if plain["lanes"] not in (8, 16):
            raise ClrtError(fault("", "settings.lanes", self.lanes, "it must be 8 or 16"))
        plain["check"] = flag("settings.check", self.check)
        instance("settings.limits", self.limits, Limits)
        for name, value in plain.items():  # Python's own numbers, where numpy's were given
            object.__setattr__(self, name, value)
