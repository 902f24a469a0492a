"""`clrt check`: is a scene right, without rendering it."""

from __future__ import annotations

import argparse
import json
import os
import warnings
from typing import TYPE_CHECKING, Any

from clrt.base.errors import ClrtError, ClrtWarning, in_line, legible
from clrt.base.records import Unstated
from clrt.cli.source import read, scene_path
from clrt.cli.terminal import say

if TYPE_CHECKING:
    from clrt.flatten.flatten import FlatScene
    from clrt.scene.scene import Scene

WRONG = 1  # exit code


def run(options: argparse.Namespace) -> int:
    """Print a line for each scene: what is in it, or what is wrong; 1 where one is."""
    import clrt

    if options.scenes.count("-") > 1:
        raise ClrtError("-: standard input can be read once")
    limits = clrt.Limits(**dict(options.limit))
    found = [_checked(name, options, limits) for name in options.scenes]
    if options.json:
        print(json.dumps(legible(found), indent=2))
    else:
        for row in found:
            for warning in row["warnings"]:
                say(f"warning: {warning}")
            if row["error"]:
                say(f"error: {row['error']}")
            elif not options.quiet:
                print(f"{in_line(row['scene'])}: {_words(row)}")
    return WRONG if any(row["error"] for row in found) else 0


def _checked(name: str, options: argparse.Namespace, limits: Any) -> dict[str, Any]:
    """All that a render would refuse before it asks for a device: the scene, its geometry, its picture."""
    from clrt.device.settings import Settings
    from clrt.engine.request import Request
    from clrt.engine.tree import least_bytes
    from clrt.flatten.flatten import check_ceilings, flatten
    from clrt.formats.native import with_values

    row: dict[str, Any] = {"scene": name, "error": None, "warnings": []}
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", ClrtWarning)
        try:
            scene = with_values(read(scene_path(name), limits), options.set)
            limits.check("device_bytes", least_bytes(scene), scene.source, "shapes")
            flat = flatten(scene)
            check_ceilings(flat, scene.source)
            if scene.camera is not None:
                job, *_ = Request().job(scene, flat, Settings(limits=limits))
                _look_around(flat, job.camera)
            row |= _contents(scene, flat.bands)
        except ClrtError as error:
            said, file = str(error), os.path.basename(name)
            row["error"] = said if file in said else f"{file}: {said}"
    row["warnings"] = [str(warning.message) for warning in told if issubclass(warning.category, ClrtWarning)]
    return row


def _look_around(flat: FlatScene, camera: Any) -> None:
    """LimitError where the rays of a pinhole start within more media than fit."""
    if flat.media is not None and not any(camera[name][0] for name in ("orthographic", "near", "aperture")):
        flat.media.lists(camera["origin"][:, :3])


def _contents(scene: Scene, bands: int) -> dict[str, Any]:
    camera = scene.camera
    return {
        "shapes": len(scene.shapes), "primitives": sum(shape.primitives for shape in scene.shapes),
        "lights": len(scene.lights), "materials": len(scene.materials), "bands": bands,
        "max_depth": scene.max_depth,
        "camera": None if camera is None else [camera.width, camera.height, _stated(camera.spp)],
    }  # fmt: skip


def _stated(number: int) -> int | None:
    return None if isinstance(number, Unstated) else number


def _words(row: dict[str, Any]) -> str:
    """What is in a scene, in a line."""
    counts = ", ".join(
        f"{row[name]} {name.removesuffix('s') if row[name] == 1 else name}"
        for name in ("shapes", "primitives", "lights", "materials")
    )
    if row["camera"] is None:
        return f"right; {counts}; no camera"
    width, height, spp = row["camera"]
    samples = "" if spp is None else f", {spp} sample{'' if spp == 1 else 's'} each"
    return f"right; {counts}; {width} x {height} pixels{samples}, max_depth {row['max_depth']}"
