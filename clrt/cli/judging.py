"""What `clrt compare` does with one picture and with many: read, judge, and say so in JSON."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from clrt.base.errors import ClrtError, show
from clrt.base.places import listed
from clrt.cli import source
from clrt.cli.terminal import console, marked
from clrt.judging.verdict import PICTURES, RADIANCE, bits_of_file, check_room

if TYPE_CHECKING:
    from clrt.base.limits import Limits
    from clrt.scene.scene import Scene

DIGITS = {
    "PSNR": ".1f",
    "largest, of 255": ".1f",
    "mean, of 255": ".2f",
    "brightness": ".4f",
    "SSIM": ".5f",
    "worst window": ".3f",
    "FLIP": ".5f",
    "widest place": ".0f",
    "thin place": ".0f",
}
VERDICTS = {
    "identical": ("green", "the same pixels, bit for bit"),
    "equal": ("green", "they differ by rounding only"),
    "same picture": ("green", "they show the same; single pixels differ"),
    "similar": ("yellow", "much is right, and something is not"),
    "different": ("red", "they show different things"),
}


def judge(
    pictures: Any, picture: Any, reference: Any, scene: Any, options: argparse.Namespace,
    report: Callable[[str], None], bits: tuple[int, int],
) -> Any:
    """The comparison of two pictures; `scene` made the reference, where there is one. bits: see `bits_of`."""
    check_room(picture, reference, limits_of(options))
    seconds = pictures.SEARCH_SECONDS if options.seconds is None else options.seconds
    return pictures.compare_pictures(picture, reference, options.mask, scene, report, seconds, bits=bits)


def bits_of(name: str, options: argparse.Namespace) -> int:
    """Bits of a sample of what `read` gave: what a scene shows does not end at white."""
    return bits_of_file(name, limits_of(options)) if Path(name).suffix.lower() in PICTURES else RADIANCE


def limits_of(options: argparse.Namespace) -> Limits:
    """Those of --limit."""
    from clrt.base.limits import Limits

    return Limits(**dict(options.limit))


def read(name: str, options: argparse.Namespace) -> Any:
    """Linear pixels of a picture file, else a scene."""
    limits = limits_of(options)
    if Path(name).suffix.lower() in PICTURES:
        from clrt.images.file import read_samples

        return read_samples(name, limits)
    from clrt.formats import READERS

    file = source.scene_path(name)
    if name != source.STREAM and file.suffix.lower() not in READERS:
        what = "this is a folder" if file.is_dir() else f"the suffix {show(file.suffix)} is not known"
        raise ClrtError(f"{name}: {what}; pictures are {listed(PICTURES)} files, scenes {listed(READERS)}")
    scene = source.read(file, limits)
    if scene.camera is None:
        raise ClrtError(f"{name}: camera: missing; a picture needs a [camera]")
    return scene.override(spp=options.spp)


def scene_reference(scene: Scene, shape: Any, options: argparse.Namespace) -> Any:
    """The scene to render: in the size of the picture, if that has the camera's aspect to within a pixel."""
    from clrt.base.resources import validation_module
    from clrt.device.settings import Settings

    settings = Settings(threads=options.threads, limits=limits_of(options))
    return validation_module("compare.reference").reference_of(scene, shape, options.device, settings)


@contextmanager
def reporting(quiet: bool) -> Iterator[Callable[[str], None]]:
    """A function that says on a terminal's stderr what is being tried."""
    if quiet or not sys.stderr.isatty():
        yield lambda name: None
        return
    with console(stderr=True).status("") as status:
        yield lambda name: status.update(f"trying: {marked(name)}" if name != "rendering" else name)


def plain(result: Any, a: str, b: str) -> dict[str, Any]:
    """The comparison as JSON has it; what is infinite (the PSNR of equal pictures) becomes null."""

    def finite(value: float) -> float | None:
        return value if math.isfinite(value) else None

    return {
        "a": a,
        "b": b,
        "verdict": result.verdict,
        "passed": result.passed,
        "metrics": {name: finite(value) for name, value in result.metrics.items()},
        "gates": [{"name": gate.name, "value": finite(gate.value), "limit": gate.limit, "passed": gate.passed,
                   "better": gate.better, "detail": gate.detail} for gate in result.gates],
        "causes": [{"name": cause.name, "text": cause.text, "error_left": cause.left, "proven": cause.proven}
                   for cause in result.causes],
        "notes": list(result.notes),
    }  # fmt: skip

