"""`python -m clrt.diagnosis.probe [DEVICE]`: what `clrt doctor` asks about a device, in a process apart.

The last line on stdout is a JSON object: the devices, then either `error` and perhaps `mend`, or the checks
against the reference, a small picture's hash and time, and what an old PoCL costs.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any

from clrt.base.errors import ClrtError
from clrt.base.resources import validation_module

_OLD_POCL = (
    "PoCL below 3.1 cannot compile vectors of 16 numbers, so that rays travel by 8: pictures take about a "
    "quarter more processor time (docs/reliability.md)"
)
_SCENE = {
    "camera": {"origin": [0, 1, 4], "target": [0, 0, 0], "width": 32, "height": 24},
    "lights": [{"type": "point", "position": [3, 5, 4]}],
    "materials": {"glass": {"diffuse": 0.2, "reflection": 0.3, "transmission": 0.5}},
    "shapes": [
        {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "glass"},
        {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]},
    ],
}


def probe(wanted: str | None) -> dict[str, Any]:
    """The answers about one device."""
    from clrt.device.platforms import choose, devices, pocl_version
    from clrt.device.trial import verdict
    from clrt.engine.tracer import Tracer
    from clrt.formats import load_dict

    told: dict[str, Any] = {"devices": []}
    try:
        found = devices()
        # what is known to work need not show it again; what did not may have been mended
        faults = {info.index: verdict(info)[0] and verdict(info, anew=True)[0] for info in found}
        told["works"] = not all(faults.values())
        told["devices"] = [_described(info, False, faults[info.index]) for info in found]
        used = choose(wanted)[0]
        told["devices"] = [_described(info, info == used, faults[info.index]) for info in found]
        tracer = Tracer(load_dict(_SCENE), device=wanted)
        selftest = validation_module("selftest")
        checks = {
            "records": selftest.check_layout(tracer.device),
            "arithmetic": selftest.check_arithmetic(tracer.device),
        }
        tracer.render()  # compiles
        start = time.perf_counter()
        image = tracer.render()
    except ClrtError as error:
        return {**told, "error": str(error)}
    told["checks"] = [
        {"name": name, "passed": passed, "detail": detail} for name, (passed, detail) in checks.items()
    ]
    told["seconds"] = time.perf_counter() - start
    told["pixels"], told["hash"] = image.width * image.height, image.hash
    newest = max(pocl_version(info) for info in found)
    told["old_pocl"] = _OLD_POCL if () < newest < (3, 1) else ""
    return told


def _described(info: Any, used: bool, fault: str) -> dict[str, Any]:
    return {
        "index": info.index, "label": info.label, "kind": info.kind, "units": info.units,
        "memory": info.memory, "used": used, "fault": fault,
    }  # fmt: skip


if __name__ == "__main__":
    print(json.dumps(probe(sys.argv[1] if len(sys.argv) > 1 else None)))
