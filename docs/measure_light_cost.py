"""What a light with extent costs: `room` with its first light alone, and with a rectangle in its place.

    python -m docs.measure_light_cost [ROUNDS]

The rectangle is 1.5 a side, shines down and has 16 samples; beside it 16 points of light in its place. On one
thread, in turns, 512 x 512, the scene's own samples, depth 4. Printed are the medians of the ratios of
processor times to those with the point, and quartiles, with tinted shadows and with opaque ones.
"""

from __future__ import annotations

import sys
from typing import Any, Final

import clrt
from docs.in_turns import ratios

SIDE: Final = 1.5
SAMPLES: Final = 16
WIDTH: Final = 512
DEPTH: Final = 4
_COUNT: Final = 4  # of points a side


def lights(point: dict[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """By what they are called the lights that are compared: about the place of a point light."""
    x, y, z = point["position"]
    at = [SIDE * ((n + 0.5) / _COUNT - 0.5) for n in range(_COUNT)]
    shared = {key: value for key, value in point.items() if key not in ("position", "intensity")}
    one = {**shared, "intensity": 1 / SAMPLES}
    rectangle = {
        "type": "rectangle", "center": [x, y, z], "u": [SIDE / 2, 0, 0], "v": [0, 0, SIDE / 2],
        "radiance": 1, "samples": SAMPLES, "visible": False,
    }  # fmt: skip
    points = [{**one, "position": [x + u, y, z + v]} for u in at for v in at]
    return {"one point": [point], "rectangle": [rectangle], "16 points": points}


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    room = clrt.load("room").override(width=WIDTH, height=WIDTH, max_depth=DEPTH)
    first = room.to_dict()["lights"][0]
    for shadow in ("tinted", "opaque"):
        settings, made = clrt.Settings(threads=1), {}
        for name, found in lights(first).items():
            scene = room.replace({"lights": found, "shadow": shadow})
            made[name] = tracer = clrt.Tracer(scene, settings=settings)
            tracer.render()  # kernels are compiled
        times = ratios([*made.values()], 0, rounds, WIDTH)
        for name, (_, told) in zip([*made][1:], times, strict=True):
            print(f"{shadow} shadows, {name}: {told} of one point", flush=True)


if __name__ == "__main__":
    main()
