"""`clrt devices`: what OpenCL offers on this machine."""

from __future__ import annotations

import argparse


def run(options: argparse.Namespace) -> int:
    """Print a line for each device, its number first; * marks the one that a render takes by default.

    A device that does not work says why: each is tried, once a driver and processor.
    """
    from clrt.errors import DeviceError
    from clrt.platforms import choose, devices
    from clrt.trial import verdict

    found = devices()
    faults = {info.index: verdict(info)[0] for info in found}
    try:
        default = choose()[0].index
    except DeviceError:  # none works, and each line says why
        default = -1
    for info in found:
        mark = "*" if info.index == default else " "
        memory = f"{info.memory / 2**30:.1f} GiB"
        print(f"{mark} {info.index}  {info.label}  ({info.kind}, {info.units} units, {memory})")
        if faults[info.index]:
            print(f"     does not work: {faults[info.index]}")
    return 0 if default >= 0 else 1
