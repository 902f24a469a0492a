"""Ray counts of the Standard Procedural Databases (Haines 1987), and counts that can be told beforehand.

Rays are counted as the published tables count them (`conformance="spd"`): a reflection wherever a surface
reflects or transmits, of weight 0 too, and opaque surfaces have one side.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, Final

import msgspec

import clrt
from clrt.base.errors import ClrtError
from clrt.device.device import Device
from clrt.formats import load_dict
from clrt.formats.shipped import load_scene
from clrt.scene.scene import Scene

from .cases import quietly
from .oracle64 import render64
from .oracles import tracer_of
from .types import CountResult

KINDS: Final = ("eye hits", "reflected", "refracted", "shadow")
# file name -> published counts, in the order of KINDS
PUBLISHED: Final[dict[str, tuple[int, ...]]] = {
    "balls_c_s4": (263169, 175095, 0, 954368),
    "mount_c_s6": (173125, 354769, 354769, 412922),
    "teapot_c_s12": (161120, 225248, 0, 407656),
    "tetra_c_s6": (49788, 0, 0, 46112),
    "tree_c_s11": (169836, 0, 0, 1097419),
}
GENERATED: Final = {"sphereflake": 96, "tetrahedron": 96,
                    "mountain": 48}  # scenes that ship, and their width here
_SIDE, _DEPTH = 64, 5  # of the scenes whose counts can be told beforehand


def check_folder(folder: Path) -> None:
    """ClrtError where a published scene is missing in `folder`."""
    missing = [f"{name}.nff" for name in PUBLISHED if not (folder / f"{name}.nff").is_file()]
    if missing:
        text = f"{', '.join(missing)} not found; the Standard Procedural Databases' generators write them"
        raise ClrtError(f"{folder}: {text}")


def published_counts(name: str, folder: Path, device: Device) -> list[CountResult]:
    """Our counts of a published scene, `folder`/`name`.nff."""
    scene = quietly(partial(clrt.load, folder / f"{name}.nff", conformance="spd"))
    return compared(name, our_counts(scene, device), PUBLISHED[name])


def known_counts(name: str, device: Device) -> list[CountResult]:
    """Our counts of one of KNOWN, against the float64 oracle's or those that can be told beforehand."""
    if name in GENERATED:
        width = GENERATED[name]
        scene = msgspec.structs.replace(load_scene(name), conformance="spd", min_weight=0.0)
        scene = scene.override(width=width, height=width * 3 // 4, spp=1)
        theirs = counted(render64(scene).stats["rays"])
        return compared(f"{name}, oracle64", our_counts(scene, device), theirs)
    make, theirs = _TOLD[name]
    return compared(f"{name}, closed form", our_counts(make(), device), theirs)


def our_counts(scene: Scene, device: Device) -> tuple[int, ...]:
    """Of the kernels, in the order of KINDS."""
    return counted(tracer_of(scene, device).render().stats["rays"])


def counted(rays: dict[str, int]) -> tuple[int, ...]:
    """Statistics of rays in the order of KINDS; published tables count an attempt to refract, too."""
    refracted = rays["transmission"] + rays["total_internal_reflection"]
    return rays["camera_hits"], rays["reflection"], refracted, rays["feelers"]


def compared(scene: str, ours: tuple[int, ...], theirs: tuple[int, ...]) -> list[CountResult]:
    """A result for each kind of ray."""
    return [CountResult(scene, kind, mine, known, (mine - known) / known if known else float(mine))
            for kind, mine, known in zip(KINDS, ours, theirs, strict=True)]  # fmt: skip


def _ball(kr: float, kt: float) -> Scene:
    """Within a ball: every ray hits it, is lit, and goes on; what leaves it meets nothing."""
    wall = {"diffuse": 0.1, "reflection": kr, "transmission": kt, "ior": 1.0}
    return load_dict({
        "max_depth": _DEPTH, "ambient": 0.1, "camera": _square([0.3, 0.1, 0.2], [1, 0, 0.1]),
        "lights": [{"type": "point", "position": [0, 0, 0]}],
        "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 2, "material": wall}],
    })  # fmt: skip


def _stack() -> Scene:
    """Planes one behind the other, each lit from the camera's side; glass blocks, but a feeler is counted."""
    sheet = {"diffuse": 0.3, "transmission": 0.7, "thin": True}
    planes = [{"type": "plane", "point": [0, 0, -k], "normal": [0, 0, 1],
               "material": sheet} for k in range(9)]
    return load_dict({"max_depth": _DEPTH, "camera": _square([0, 0, 4], [0, 0, 0]), "shapes": planes,
                      "lights": [{"type": "directional", "direction": [0.1, 0.2, -1]}]})  # fmt: skip


def _square(origin: list[float], target: list[float]) -> dict[str, Any]:
    return {"origin": origin, "target": target, "fov": 60, "width": _SIDE, "height": _SIDE}


_EYES = _SIDE * _SIDE
# scenes in which every ray's fate is known, and their counts
_TOLD: Final[dict[str, tuple[Callable[[], Scene], tuple[int, ...]]]] = {
    "ball of mirrors": (partial(_ball, 0.8, 0.0), (_EYES, _DEPTH * _EYES, 0, (_DEPTH + 1) * _EYES)),
    "ball of half mirrors": (partial(_ball, 0.4, 0.5),
                             (_EYES, _DEPTH * _EYES, _DEPTH * _EYES, (_DEPTH + 1) * _EYES)),
    "stack of sheets": (_stack, (_EYES, 0, _DEPTH * _EYES, (_DEPTH + 1) * _EYES)),
}
KNOWN: Final = (*_TOLD, *GENERATED)
