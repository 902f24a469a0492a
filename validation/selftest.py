"""Does a device compute what the model says, bit for bit? The answer of `clrt selftest`, in seconds.

Four questions, from the ground up, so that the first failure names the cause: do host and device agree on the
layout of records; does the device's arithmetic round as IEEE 754 asks; do the kernels give, pass by pass, the
values of the float32 twin on small scenes that hold every primitive and every term of the model; and have
small pictures of all scenes that ship the hashes that they had where this version was made.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from clrt import layout
from clrt.device.device import Device
from clrt.device.opencl import cl
from clrt.flatten.flatten import FlatScene
from clrt.layout.declarations import c_declarations
from clrt.scene.scene import Scene

from . import expected
from .conformance.blame import Fault, blame
from .conformance.watch import Launch, options_of, words_of
from .twin.compare import compare_picture, compare_rays
from .twin.rays import difficult_rays
from .twin.scenes import scenes


@dataclass(frozen=True)
class Result:
    """One check: `detail` says what was compared, or the first thing that differs."""

    name: str
    passed: bool
    detail: str
    seconds: float
    fault: Fault | None = None  # the kernel that differs, where it was looked for


Check = Callable[[], tuple[bool, str]]


def run_selftest(
    device: int | str | Device | None = None, quick: bool = False, blaming: bool = False,
    only: Collection[str] = (),
) -> Iterator[Result]:  # fmt: skip
    """The result of each check on a device, as it comes; a device as `clrt.render` takes it, or one opened.

    quick: without light in bands, whose kernels take long to compile, and the scenes that scripts make.
    blaming: look for the kernel where a check fails. only: of `names`, those to do; none: all.
    Raises DeviceError when there is no device, or when it cannot build the kernels.
    """
    opened = device if isinstance(device, Device) else Device(device)
    chosen = set(only or names(quick))
    for name, probing in (("layout of records", check_layout), ("arithmetic", check_arithmetic)):
        if name not in chosen:
            continue
        faults: list[Fault] = []
        result = _timed(name, partial(probing, opened, faults))
        yield replace(result, fault=faults[0] if faults and blaming else None)
    for seed, (name, (scene, flat)) in enumerate(scenes().items()):
        if name in chosen:
            result = _timed(name, _twin_check(opened, scene, flat, seed))
            again = blaming and not result.passed
            yield replace(result, fault=blame(opened, scene, flat, seed)) if again else result
    # a device of the caller's may have kernels of its own
    if not isinstance(device, Device) and "expected pictures" in chosen:
        yield _timed("expected pictures", lambda: expected.check(opened.info.index, quick))


def names(quick: bool = False) -> list[str]:
    """The names of all checks, in order."""
    twins = [name for name, (scene, _) in scenes().items() if not (quick and scene.spectrum is not None)]
    return ["layout of records", "arithmetic", *twins, "expected pictures"]


def _twin_check(device: Device, scene: Scene, flat: FlatScene, seed: int) -> Check:
    def check() -> tuple[bool, str]:
        picture = compare_picture(device, scene, flat)
        if picture.difference:
            return False, str(picture.difference)
        rays = compare_rays(device, flat, *difficult_rays(1000, seed), max_depth=1)
        if rays.difference:
            return False, f"caller's rays: {rays.difference}"
        values, traced = picture.values + rays.values, picture.rays + rays.rays
        return True, f"{values:,} values of {traced:,} rays are the same"

    return check


def _timed(name: str, check: Check) -> Result:
    start = time.perf_counter()
    passed, detail = check()
    return Result(name, passed, detail, time.perf_counter() - start)


def check_layout(device: Device, faults: list[Fault] | None = None) -> tuple[bool, str]:
    """Sizes and offsets of all records of `clrt.layout`, as numpy and as the device has them.

    What differs is added to `faults`.
    """
    names: list[str] = []
    expected: list[int] = []
    lines: list[str] = []
    for record in layout.RECORDS:
        kind = layout.dtype(record, device.bands)
        assert kind.fields is not None
        names.append(f"size of {record}")
        expected.append(kind.itemsize)
        lines += [f"    {{ {record} r;", f"    out[i++] = sizeof({record});"]
        for field, (_, offset, *_) in kind.fields.items():
            names.append(f"offset of {record}.{field}")
            expected.append(offset)
            lines.append(f"    out[i++] = (uint)((__private char *)&r.{field} - (__private char *)&r);")
        lines.append("    }")
    body = "\n".join(lines)
    source = (
        f"{c_declarations(device.ray_format, device.settings.lanes)}\n"
        f"__kernel void layout_of_records(__global uint *out)\n{{\n    uint i = 0;\n{body}\n}}\n"
    )
    found, launch = _run(device, source, "layout_of_records", 1, np.empty(len(names), np.uint32))
    for word, (name, here, there) in enumerate(zip(names, expected, found.tolist(), strict=True)):
        if here != there:
            if faults is not None:
                faults.append(Fault(launch, "layout of records", 0, word, here, there, item=0))
            return False, f"{name}: {there} bytes on the device, {here} in numpy"
    return True, f"{len(names)} sizes and offsets are the same"


_OPERATIONS: dict[str, Callable[..., np.ndarray]] = {
    "a + b": lambda a, b, c: a + b,
    "a - b": lambda a, b, c: a - b,
    "a * b": lambda a, b, c: a * b,
    "a / b": lambda a, b, c: a / b,
    "a * b + c": lambda a, b, c: a * b + c,
    "sqrt(fabs(a))": lambda a, b, c: np.sqrt(np.abs(a)),
    "floor(a)": lambda a, b, c: np.floor(a),
    "(float)as_uint(a)": lambda a, b, c: a.view(np.uint32).astype(np.float32),
}


def check_arithmetic(device: Device, faults: list[Fault] | None = None) -> tuple[bool, str]:
    """Is arithmetic correctly rounded, subnormal numbers included, and is a * b + c two operations.

    What differs is added to `faults`.
    """
    n = 1 << 14
    generator = np.random.default_rng(1)
    a, b, c = generator.normal(size=(3, n)) * np.exp2(generator.integers(-75, 62, (3, n)))
    a, b, c = a.astype(np.float32), b.astype(np.float32), c.astype(np.float32)
    c[::2] = -(a * b)[::2]  # here a fused operation leaves the rounding error instead of 0
    lines = "\n".join(f"    out[{k} * n + i] = {text};" for k, text in enumerate(_OPERATIONS))
    source = f"""#pragma OPENCL FP_CONTRACT OFF
__kernel void arithmetic(__global const float *as, __global const float *bs, __global const float *cs, uint n,
                         __global float *out)
{{
    const uint i = get_global_id(0);
    const float a = as[i], b = bs[i], c = cs[i];
{lines}
}}
"""
    with np.errstate(all="ignore"):
        expected = [operation(a, b, c) for operation in _OPERATIONS.values()]
    inputs = [device.upload(array) for array in (a, b, c)]
    out = np.empty((len(expected), n), np.float32)
    found, launch = _run(device, source, "arithmetic", n, out, *inputs, np.uint32(n))
    for k, (name, here, there) in enumerate(zip(_OPERATIONS, expected, found, strict=True)):
        wrong = np.flatnonzero(here.view(np.uint32) != there.view(np.uint32))
        if len(wrong):
            i = int(wrong[0])
            if faults is not None:
                right, wrong_one = (int(values.view(np.uint32)[i]) for values in (here, there))
                faults.append(Fault(launch, name, 4, k * n + i, right, wrong_one, item=i))
            values = f"a = {float(a[i]).hex()}, b = {float(b[i]).hex()}, c = {float(c[i]).hex()}"
            both = f"{float(there[i]).hex()} on the device, {float(here[i]).hex()} in numpy"
            return False, f"{name} with {values}: {both}; {len(wrong)} of {n} differ"
    return True, f"{len(_OPERATIONS)} operations on {n:,} numbers are the same"


def _run(
    device: Device, source: str, kernel: str, items: int, out: np.ndarray, *arguments: Any
) -> tuple[Any, Launch]:
    """Compile and run a kernel of its own; `out` is its last argument and comes back filled."""
    target = device.buffer(out.nbytes)
    before = (*(words_of(device, argument) for argument in arguments), np.zeros(out.size, np.uint32))
    program = device.driver.build(source)
    built = cl.Kernel(program, kernel)
    built(device.queue, (items,), None, *arguments, target)
    found = device.read(target, out)
    options = options_of(device, program)
    names = tuple(f"argument {number}" for number in range(len(before)))
    after = (*before[:-1], found.reshape(-1).view(np.uint32))
    return found, Launch(kernel, source, options, items, None, names, (*arguments, target), before, after)
