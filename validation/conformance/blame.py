"""From a check of the self-test that failed to the kernel, the work-item, and the bits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from clrt.device.device import Device
from clrt.device.opencl import cl
from clrt.engine.stage import Stage
from clrt.flatten.flatten import FlatScene
from clrt.scene.scene import Scene

from ..twin.compare import Difference, compare_picture, compare_rays, twin_stages
from ..twin.rays import difficult_rays
from .watch import Launch, Log, places, watching

RAYS = 1000  # of callers, with a seed, for each scene


@dataclass(frozen=True)
class Fault:
    """The first value that a kernel computed otherwise than the reference.

    argument, word: where it stands: the number of the kernel's argument, and of the uint32 in its buffer;
    None where that cannot be told. expected, found: the bits.
    """

    launch: Launch
    where: str  # the pass, the generation, the kind of rays
    argument: int | None = None
    word: int | None = None
    expected: int = 0
    found: int = 0
    item: int | None = None  # the work-item that wrote it, where that is known beforehand

    @property
    def kernel(self) -> str:
        return self.launch.kernel


def blame(device: Device, scene: Scene, flat: FlatScene, seed: int) -> Fault | None:
    """The check of a scene once more, watched; None where nothing differs this time."""
    with watching() as log:
        picture = compare_picture(device, scene, flat, observe=log.forget)
        found = picture
        if not picture.difference:
            log.launches.clear()
            found = compare_rays(device, flat, *difficult_rays(RAYS, seed), max_depth=1, observe=log.forget)
    if not found.difference or not log.launches:
        return None
    return _located(found.difference, found.stage, log)


def _located(difference: Difference, stage: Any, log: Log) -> Fault:
    """The last launch that wrote the value's word; else the last launch of the pass."""
    said = f"{difference.name}, generation {difference.generation}, {difference.kind}"
    located = _word(difference, stage, log) if difference.ray >= 0 and isinstance(stage, Stage) else None
    if located is None:
        return Fault(log.launches[-1], said)
    buffer, word, expected, found = located
    for launch in reversed(log.launches):
        for number, argument in enumerate(launch.arguments):
            if argument is buffer and launch.before[number][word] != launch.after[number][word]:
                return Fault(launch, said, number, word, expected, found)
    for launch in reversed(log.launches):  # it wrote what stood there before
        for number, argument in enumerate(launch.arguments):
            if argument is buffer:
                return Fault(launch, said, number, word, expected, found)
    return Fault(log.launches[-1], said)


def _word(difference: Difference, stage: Stage, log: Log) -> tuple[Any, int, int, int] | None:
    """Buffer and word that the value came from, with the bits that should be and that are there."""
    device = stage.queue.device
    given = (argument for launch in log.launches for argument in launch.arguments)
    buffers = list({id(one): one for one in given if isinstance(one, cl.MemoryObjectHolder)}.values())
    name, *row = difference.value.replace("]", "").split("[")

    def value() -> np.ndarray:
        for decoded in twin_stages(stage):
            if decoded.name == difference.name:
                array = np.ascontiguousarray(decoded.values[name]).view(np.uint32)
                return array[(*map(int, row), difference.ray)]
        raise ValueError(difference.name)

    if isinstance(stage.wrote, dict):  # read back already: the arrays are the kernel's last arguments
        return None
    found = int(value())
    for number, place in places(buffers, value):
        words = device.read(buffers[number], np.empty(buffers[number].size // 4, np.uint32))
        if int(place) < len(words) and int(words[int(place)]) == found and int(place) != found:
            return buffers[number], int(place), difference.expected_bits, found
    return None

