"""`clrt devices`: what OpenCL offers on this machine."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict


def run(options: argparse.Namespace) -> int:
    """Print a line for each device, its number first; * marks the one that a render takes by default."""
    from clrt.platforms import choose, devices

    default = choose()[0].index
    if options.json:
        rows = [{**asdict(info), "label": info.label, "default": info.index == default} for info in devices()]
        print(json.dumps(rows, indent=2))
        return 0
    for info in devices():
        mark = "*" if info.index == default else " "
        memory = f"{info.memory / 2**30:.1f} GiB"
        print(f"{mark} {info.index}  {info.label}  ({info.kind}, {info.units} units, {memory})")
    return 0
