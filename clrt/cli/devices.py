"""`clrt devices`: what OpenCL offers on this machine."""

from __future__ import annotations

import argparse
import json
import os
from dataclasses import asdict


def run(options: argparse.Namespace) -> int:
    """Print a line for each device, its number first; * marks the one that a render takes by default.

    A device that does not work says why: each is tried, once a driver and processor.
    Return 1 where none works.
    """
    from clrt.device.platforms import choose, devices
    from clrt.device.trial import broken, verdict

    found = devices()
    if not found and not options.json:
        choose()  # says why, and what mends it
    faults = {info.index: verdict(info)[0] for info in found}
    none = all(faults.values()) and not os.environ.get("CLRT_DEVICE")
    default = -1 if none else choose()[0].index
    if options.json:
        rows = [
            {
                **asdict(info), "label": info.label, "default": info.index == default,
                "fault": faults[info.index],
            }
            for info in found
        ]  # fmt: skip
        print(json.dumps(rows, indent=2))
        return 0 if default >= 0 else 1
    for info in found:
        mark = "*" if info.index == default else " "
        memory = f"{info.memory / 2**30:.1f} GiB"
        fault = f" does not work: {broken(faults[info.index])}" if faults[info.index] else ""
        print(f"{mark} {info.index}  {info.label}  ({info.kind}, {info.units} units, {memory}){fault}")
    return 0 if default >= 0 else 1
