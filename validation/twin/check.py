"""The float32 twin on many rays: not a bit of what the kernels compute may differ."""

from __future__ import annotations

import time

from clrt.device.device import Device

from ..types import CheckResult
from .compare import compare_picture, compare_rays
from .rays import difficult_rays
from .scenes import scenes

RAYS = 1_000_000  # callers' rays, over all scenes; what these spawn comes on top
_BLOCK = 20_000  # that numpy traces at a time


def twin_check(device: Device, rays: int = RAYS) -> CheckResult:
    """Every pass of `rays` difficult rays and of the twin's own pictures, on this device and in numpy."""
    start = time.perf_counter()
    asked = compared = values = 0
    small = scenes()
    for seed, (name, (scene, flat)) in enumerate(small.items()):
        found = [compare_picture(device, scene, flat)]
        share = rays // len(small) + 1
        for first in range(0, share, _BLOCK):
            count = min(_BLOCK, share - first)
            asked += count
            rays_of = difficult_rays(count, 1000 * seed + first // _BLOCK)
            found.append(compare_rays(device, flat, *rays_of, max_depth=1))
            if found[-1].difference:
                break
        compared += sum(comparison.rays for comparison in found)
        values += sum(comparison.values for comparison in found)
        wrong = next((comparison.difference for comparison in found if comparison.difference), None)
        if wrong:
            return CheckResult("float32 twin", False, f"{name}: {wrong}", time.perf_counter() - start)
    detail = f"{asked:,} rays of callers, {compared:,} with all they spawn: {values:,} values, 0 bits differ"
    return CheckResult("float32 twin", True, detail, time.perf_counter() - start)
