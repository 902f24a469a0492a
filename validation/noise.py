"""How far float32 moves a scene's picture: what limits of its own a case may have, and why.

    python -m validation.noise [CASE ...]        measures these, or all cases that have limits of their own

The float64 oracle renders the scene, and once more with every number of shapes, lights, materials and camera
moved by one unit in the last place of a float32, up or down by a seed. What the two pictures differ by is the
least that any program in float32 may differ by, for it rounds as much when it reads the scene. The worst of
SEEDS pictures is kept in noise.json with the digest of the scene.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from clrt.base.atomic import write_text
from clrt.formats import load_dict
from clrt.scene.scene import Scene

from .cases import OWN_LIMITS, case_named, limits_of, quietly
from .compare.oracle import compare
from .oracles import ORACLE64, edges64, picture64, scene_of
from .types import Comparison

SEEDS: Final = 2
FILE: Final = Path(__file__).with_name("noise.json")
# fields of Limits that float32 has a say in -> the figure, and whether the smaller is the worse
FIGURES: Final = {
    "fine": ("within 1e-4", True), "coarse": ("within 1e-3", True), "masked": ("edges far off", False),
    "mean": ("mean radiance", False), "distance": ("distance", False), "ssim": ("SSIM", True),
    "psnr": ("PSNR", True), "flip": ("FLIP", False), "rays": ("rays", True), "layers": ("layers", True),
}  # fmt: skip
# fields that are the worst of several figures -> how the names of these begin and end
_WORST_OF: Final = {"rays": ("", ": within 1e-4"), "layers": ("layer ", "")}
_KEPT: Final = frozenset({"spp", "max_depth", "width", "height", "samples", "seed", "jitter", "priority"})


def cases() -> list[str]:
    """The cases with limits of their own that float32 has a say in."""
    named = (name.partition(" (")[0] for name, (own, _) in OWN_LIMITS.items() if own.keys() & FIGURES.keys())
    return list(dict.fromkeys(named))


def moved(scene: Scene, seed: int) -> Scene:
    """The scene with each of those numbers one step of float32 away, at random up or down."""
    draw = np.random.default_rng(seed)
    table = scene.to_dict()
    for key in ("shapes", "lights", "materials", "camera"):
        if key in table:
            table[key] = _moved(table[key], draw)
    return quietly(lambda: load_dict(table, folder=scene.folder))


def _moved(value: Any, draw: np.random.Generator) -> Any:
    if isinstance(value, dict):
        return {key: inner if key in _KEPT else _moved(inner, draw) for key, inner in value.items()}
    if isinstance(value, list):
        return [_moved(inner, draw) for inner in value]
    if isinstance(value, float) and value not in (0.0, 1.0):
        return float(value + float(np.spacing(np.float32(abs(value)))) * draw.choice((-1.0, 1.0)))
    return value


def measured(name: str) -> dict[str, float]:
    """The worst of each figure of a case's pictures."""
    case = case_named(name)
    scene = scene_of(case)
    reference = picture64(scene)
    edges = edges64(scene, reference)
    limit = dataclasses.replace(limits_of(case, ORACLE64), clipped=None, lit=None, mask=None)
    found: dict[str, float] = {}
    for seed in range(SEEDS):
        comparison = compare(picture64(moved(scene, seed)), reference, edges, case.spp, limit)
        for field, (_, low) in FIGURES.items():
            value = _figure(field, comparison)
            if value is not None:
                found[field] = (min if low else max)(value, found.get(field, value))
    return found


def _figure(field: str, comparison: Comparison) -> float | None:
    if field in _WORST_OF:
        start, end = _WORST_OF[field]
        return min((value for key, value in comparison.metrics.items()
                    if key.startswith(start) and key.endswith(end)), default=None)  # fmt: skip
    return comparison.metrics.get(FIGURES[field][0])


def allowed(field: str, noise: float, programs: int = 2) -> float:
    """The limit that so many programs in float32 are given whose own noise is that, of a float64 picture 1.

    Shares and differences add up; a mean of squares (PSNR) does so as energy.
    """
    if field == "psnr":
        return noise - 10 * float(np.log10(programs * programs))
    return 1 - programs * (1 - noise) if FIGURES[field][1] else programs * noise


def digest(name: str) -> str:
    """Of the case's scene, size and samples."""
    scene = scene_of(case_named(name))
    return hashlib.sha256(repr((scene.to_dict(), case_named(name).spp)).encode()).hexdigest()[:16]


def kept() -> Mapping[str, Any]:
    """What was measured before, by case."""
    return dict(json.loads(FILE.read_text("utf-8"))) if FILE.is_file() else {}


def main(names: list[str]) -> int:
    """Measure, print, keep."""
    for name in names or cases():
        start = time.process_time()
        row = {"scene": digest(name), "noise": measured(name)}
        rows = sorted({**kept(), name: row}.items())
        lines = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in rows]
        write_text(FILE, "{\n" + ",\n".join(lines) + "\n}\n")
        print(f"{name}: {row['noise']} ({time.process_time() - start:.0f} s)", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
