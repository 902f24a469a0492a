"""Five drops of water on a rainbow: each shows the colours of its place.

Source: lecture notes, refraction; Descartes' ray, which leaves a drop 42 degrees from where the light came
from (docs/model.md, number 11).
What to look at: the sun, a bright disk behind the camera, is seen in each drop twice: white, reflected on
the outside near the top, and once more below, reflected on the inside. No colour comes back further than its
own angle, red 42.4 degrees and violet 40.6. The drops stand further and further from the point opposite the
sun, from left to right: the lower image loses violet, blue, green, and is red before it goes out. That is how
rain makes a rainbow. (The sun here is 12 degrees wide, so that its
images can be seen; each colour goes out 6 degrees further than its angle.)

    clrt render rainbow -o rainbow.png
    python scenes/rainbow.py rainbow.json
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

ELEVATION = 18.0  # degrees of the sun behind the camera
SUN, FAR = 6.0, 400.0  # its radius in degrees (the true one is .27), and how far it is
PLACES = (44.0, 46.2, 47.0, 47.7, 48.2)  # of the drops: degrees from the point opposite the sun
ACROSS, AWAY, RADIUS = 45.0, 10.0, 0.6
EYE = (0.0, 1.6, 0.0)


def towards(angle: float, turn: float) -> list[float]:
    """The direction `angle` degrees from the point opposite the sun, turned round that from straight up."""
    sun, angle, turn = math.radians(ELEVATION), math.radians(angle), math.radians(turn)
    along, up, right = math.cos(angle), math.sin(angle) * math.cos(turn), math.sin(angle) * math.sin(turn)
    return [right, up * math.cos(sun) - along * math.sin(sun), -up * math.sin(sun) - along * math.cos(sun)]


def scene() -> dict[str, Any]:
    """What a scene file would hold."""
    sun = [-FAR * x for x in towards(0.0, 0.0)]
    drops = []
    for i, angle in enumerate(PLACES):
        direction = towards(angle, (i / (len(PLACES) - 1) - 0.5) * ACROSS)
        center = [round(e + AWAY * d, 4) for e, d in zip(EYE, direction, strict=True)]
        drops.append({"type": "sphere", "center": center, "radius": RADIUS, "material": "water"})
    target = [e + d for e, d in zip(EYE, towards(45.5, 0.0), strict=True)]
    grass = {"color": {"type": "checker", "colors": [[0.22, 0.30, 0.13], [0.16, 0.23, 0.10]], "size": 2.0}}
    return {
        "spectrum": {"bands": 24},
        "max_depth": 3,
        "min_weight": 0.01,
        "background": [0.11, 0.14, 0.19],
        "ambient": 0.5,
        "materials": {"water": {"diffuse": 0.0, "fresnel": True, "ior": "water-dispersive"}},
        "camera": {"origin": list(EYE), "target": target,
                   "fov": 46.0, "width": 640, "height": 280, "spp": 4},
        "lights": [{"type": "directional", "direction": [-x for x in sun],
                    "intensity": {"name": "D65", "scale": 0.5}}],
        "shapes": [
            {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], "material": grass},
            {"type": "disk", "center": [e + s for e, s in zip(EYE, sun, strict=True)],
             "normal": [-x for x in sun], "radius": FAR * math.tan(math.radians(SUN)),
             "material": {"color": 0.0, "emission": {"name": "D65", "scale": 11.0}}},
            *drops,
        ],
    }  # fmt: skip


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(json.dumps(scene(), indent=1))
