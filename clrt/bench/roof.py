"""What the device can do at best, by two small kernels in the same run: bytes and operations a second."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from clrt.bench.timing import Case, Measurement
from clrt.device.device import Device
from clrt.device.opencl import cl

MEMORY, CACHE, ARITHMETIC = "copy, memory", "copy, cache", "arithmetic"
_SIZES: Final = {MEMORY: 64 << 20, CACHE: 256 << 10}  # bytes read, and as many written
_STRETCH: Final = 64  # runs of 8 floats that a work-item copies
_CHAINS, _STEPS, _ITEMS = 8, 4096, 256  # arithmetic: as in the kernel; steps and work-items


@dataclass(frozen=True)
class Roof:
    """Bytes a second through memory and within a core's cache, floating-point operations a second."""

    memory: float
    cache: float
    arithmetic: float

    def least_seconds(self, measurement: Measurement) -> float:
        """The time that the device would need at best: for the bytes, or for the operations."""
        return max(measurement.nbytes / self.memory, measurement.flops / self.arithmetic)


def cases(device: Device, threads: int) -> list[Case]:
    """The two kernels as cases; the copy once through memory and once small enough for a core's own cache."""
    program = _program(device)
    made = [_copy(device, program, name, nbytes) for name, nbytes in _SIZES.items()]
    clock = "cpu" if threads == 1 and device.info.kind == "CPU" else "wall"
    return [replace(case, threads=threads, clock=clock) for case in (*made, arithmetic_case(device, _STEPS))]


def roof_of(measurements: Sequence[Measurement], threads: int = 1) -> Roof:
    """The roof from the measured cases."""
    rate = {
        m.name: (m.flops or m.nbytes) / m.median
        for m in measurements
        if m.group == "roof" and m.threads == threads
    }
    return Roof(rate[MEMORY], rate[CACHE], rate[ARITHMETIC])


def _program(device: Device) -> cl.Program:
    source = Path(__file__).with_suffix(".cl").read_text(encoding="utf-8")
    return device.driver.build(f"#define WIDTH {device.packet}\n{source}")


def _copy(device: Device, program: cl.Program, name: str, nbytes: int) -> Case:
    kernel = cl.Kernel(program, "copy")
    source, target = device.upload(np.ones(nbytes // 4, np.float32)), device.buffer(nbytes)
    times = _SIZES[MEMORY] // nbytes
    kernel.set_args(source, target, np.int32(_STRETCH), np.int32(times))

    def run() -> None:
        cl.enqueue_nd_range_kernel(device.queue, kernel, (nbytes // 32 // _STRETCH,), (1,))
        device.finish()

    moved = 2.0 * nbytes * times
    return Case(group="roof", name=name, run=run, items=round(moved / 1e6), unit="MB", nbytes=moved)


def arithmetic_case(device: Device, steps: int) -> Case:
    """That many steps of the kernel `arithmetic` in every work-item."""
    kernel = cl.Kernel(_program(device), "arithmetic")
    out = device.buffer(4 * _ITEMS)
    kernel.set_args(out, np.float32(0.999), np.float32(0.001), np.int32(steps))

    def run() -> None:
        cl.enqueue_nd_range_kernel(device.queue, kernel, (_ITEMS,), (16,))
        device.finish()

    flops = 2.0 * _CHAINS * steps * _ITEMS * device.packet
    return Case(group="roof", name=ARITHMETIC, run=run, items=round(flops / 1e6), unit="Mflop", flops=flops)
