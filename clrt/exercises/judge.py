"""Is an exercise mended? Its kernels have to give the right pictures of all scenes, bit for bit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from clrt.base.resources import kernel_folder
from clrt.device.device import Device
from clrt.device.settings import Settings
from clrt.engine.tracer import Tracer
from clrt.exercises.table import Exercise, scenes
from clrt.images.image import Image


@dataclass(frozen=True)
class Finding:
    """What became of one scene. `share`: of its pixels that differ from the right ones, 0 to 1, by `largest`
    at most, of linear radiance or, above 1, of the right pixel."""

    scene: str
    share: float
    pixel: tuple[int, int] | None  # (column, row) of the one that differs most
    largest: float = 0.0

    @property
    def right(self) -> bool:
        """Are all pixels the right ones, bit for bit."""
        return self.pixel is None


def judged(chosen: Exercise, kernels: Path, device: int | str | None = None) -> Iterator[Finding]:
    """A finding for each scene, that of the exercise first; no more after the first that is wrong.

    DeviceError where the kernels do not build.
    """
    for name in sorted(scenes(), key=lambda name: name != chosen.scene):
        found = compared(name, right_picture(name, device), _picture(name, kernels, device))
        yield found
        if not found.right:
            return


def compared(scene: str, right: Image, mine: Image) -> Finding:
    """How far one picture is from another of the same size."""
    differ = (right.pixels.view(np.uint32) != mine.pixels.view(np.uint32)).any(axis=2)
    if not differ.any():
        return Finding(scene, 0.0, None)
    with np.errstate(all="ignore"):
        off = np.abs(mine.pixels - right.pixels).max(axis=2)
        off /= np.maximum(np.abs(right.pixels).max(axis=2), 1.0)
    off[differ & ~np.isfinite(off)] = np.inf
    row, column = divmod(int(np.argmax(np.where(differ, off, -1.0))), differ.shape[1])
    return Finding(scene, float(differ.mean()), (column, row), float(off[row, column]))


@cache
def right_picture(scene: str, device: int | str | None = None) -> Image:
    """The picture of a scene by the kernels that ship, whatever CLRT_KERNELS says."""
    return _picture(scene, kernel_folder(), device)


def _picture(scene: str, kernels: Path, device: int | str | None) -> Image:
    with Tracer(scenes()[scene], Device(device, Settings(), kernels=kernels)) as tracer:
        return tracer.render()
