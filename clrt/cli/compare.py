"""`clrt compare`: how far a picture is from another one, or from what its scene should show, and why."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from clrt.cli.terminal import console, marked
from clrt.errors import ClrtError
from clrt.install import install_extra
from clrt.resources import scene_file, validation_module

if TYPE_CHECKING:
    from clrt.scene import Scene

PICTURES = (".exr", ".png", ".tif", ".tiff", ".jpg", ".jpeg", ".bmp", ".hdr")
DIFFERS = 1  # exit code
DIGITS = {
    "PSNR": ".1f",
    "largest, of 255": ".1f",
    "mean, of 255": ".2f",
    "brightness": ".4f",
    "SSIM": ".5f",
    "worst window": ".3f",
    "FLIP": ".5f",
}
_MEANINGS = {
    "SSIM": "structure, 1 is equal",
    "FLIP": "what an eye sees, 0 is equal",
    "PSNR": "dB, inf is equal",
    "worst window": "SSIM of the worst 11 x 11 pixels",
    "largest difference": "linear radiance",
    "mean difference": "linear radiance, worst channels",
    "largest, of 255": "in steps of an 8-bit picture",
    "mean, of 255": "in steps of an 8-bit picture",
    "pixels that differ": "share, by more than rounding",
    "brightness": "mean radiance, A / B",
    "edges left out": "share of pixels",
}
VERDICTS = {
    "identical": ("green", "the same pixels, bit for bit"),
    "equal": ("green", "they differ by rounding only"),
    "same picture": ("green", "they show the same; single pixels differ"),
    "similar": ("yellow", "much is right, and something is not"),
    "different": ("red", "they show different things"),
}


def run(options: argparse.Namespace) -> int:
    """Print the comparison; 0 where all show the same, else 1. ClrtError where one cannot be read."""
    if options.seconds is not None and not options.seconds >= 0:
        raise ClrtError(f"--seconds: {options.seconds} is not allowed; it must be a number >= 0")
    try:
        pictures = validation_module("compare_pictures")
        if options.more:
            from clrt.cli import compare_many

            return compare_many.run(pictures, options)
        result = _compare(pictures, options)
    except ModuleNotFoundError as error:
        needs = f"clrt compare needs the package {error.name}"
        raise ClrtError(f"{needs}; install what it needs with: {install_extra('validation')}") from None
    if options.json:
        print(json.dumps(plain(result, options.a, options.b), indent=2, allow_nan=False))
    else:
        _show(result, options)
    return 0 if result.passed else DIFFERS


def _compare(pictures: Any, options: argparse.Namespace) -> Any:
    """The comparison of A with B; a scene is always the reference, whichever of the two it is."""
    from clrt.scene import Scene

    picture, reference = read(options.a, options.spp), read(options.b, options.spp)
    with reporting(options.json) as report:
        report("rendering")
        if isinstance(picture, Scene) and isinstance(reference, Scene):
            picture = scene_reference(pictures, picture, None, options).render()
        elif isinstance(picture, Scene):
            picture, reference = reference, picture
        scene = None
        if isinstance(reference, Scene):
            scene = scene_reference(pictures, reference, picture.shape[:2], options)
            reference = scene.render()
        return judge(pictures, picture, reference, scene, options, report)


def judge(
    pictures: Any, picture: Any, reference: Any, scene: Any, options: argparse.Namespace,
    report: Callable[[str], None],
) -> Any:
    """The comparison of two pictures; `scene` made the reference, where there is one."""
    seconds = pictures.SEARCH_SECONDS if options.seconds is None else options.seconds
    return pictures.compare_pictures(picture, reference, options.mask, scene, report, seconds)


def read(name: str, spp: int | None) -> Any:
    """Linear pixels of a picture file, else a scene."""
    if Path(name).suffix.lower() in PICTURES:
        from clrt.imagefile import read_samples

        return read_samples(name)
    import clrt

    scene = clrt.load(scene_file(name))
    if scene.camera is None:
        raise ClrtError(f"{name}: camera: missing; a picture needs a [camera]")
    return scene.override(spp=spp)


def scene_reference(pictures: Any, scene: Scene, shape: Any, options: argparse.Namespace) -> Any:
    """The scene to render: in the size of the picture, if that has the camera's aspect to within a pixel."""
    from clrt.settings import Settings

    assert scene.camera is not None
    width, height = scene.camera.width, scene.camera.height
    if shape and abs(shape[1] * height / width - shape[0]) <= 1:
        height, width = shape
    return pictures.SceneReference(scene, width, height, options.device, Settings(threads=options.threads))


@contextmanager
def reporting(quiet: bool) -> Iterator[Callable[[str], None]]:
    """A function that says on a terminal's stderr what is being tried."""
    if quiet or not sys.stderr.isatty():
        yield lambda name: None
        return
    with console(stderr=True).status("") as status:
        yield lambda name: status.update(f"trying: {marked(name)}" if name != "rendering" else name)


def _show(result: Any, options: argparse.Namespace) -> None:
    from rich.markup import escape

    terminal = console(highlight=False)
    names = f"[bold]{escape(options.a)}[/] (A) against [bold]{escape(options.b)}[/] (B)"
    terminal.print(names, soft_wrap=True)  # a path that is broken over lines cannot be copied
    terminal.print(_table(result))
    colour, meaning = VERDICTS[result.verdict]
    terminal.print(f"[bold {colour}]{result.verdict}[/]: {meaning}")
    for note in result.notes:
        terminal.print(f"note: {escape(note)}")
    proven = [cause for cause in result.causes if cause.proven]
    for cause in proven[:1] or result.causes[:3]:
        what = f"[bold]{certainty(cause)}: {escape(cause.name)}[/]: {escape(cause.text)}."
        terminal.print(f"{what} [dim]{_left(cause)}[/]")
    if not result.causes and not result.passed:
        pictures = all(Path(name).suffix.lower() in PICTURES for name in (options.a, options.b))
        more = "; with the scene as B, lights, shadows, depth, materials and objects are tried too"
        terminal.print("no usual mistake explains it" + (more if pictures else ""))


def _table(result: Any) -> Any:
    """A row a figure, with its limit where it has one."""
    from rich.markup import escape
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("figure", no_wrap=True, min_width=18)
    table.add_column("value", no_wrap=True, min_width=9, justify="right")
    table.add_column("limit", no_wrap=True, min_width=8)
    table.add_column("", no_wrap=True, min_width=5)
    table.add_column("")
    limits = {gate.name: gate for gate in result.gates}
    for name in dict.fromkeys([*limits, *result.metrics]):
        gate = limits.get(name)
        value = result.metrics.get(name, gate.value if gate else 0.0)
        bound = f"{'<=' if gate.better == 'low' else '>='} {gate.limit:g}" if gate else ""
        mark = ("[green]ok[/]" if gate.passed else "[red]fails[/]") if gate else ""
        meaning = escape(_MEANINGS.get(name, gate.detail if gate else ""))
        table.add_row(name, format(value, DIGITS.get(name, ".3g")), bound, mark, f"[dim]{meaning}[/]")
    return table


def certainty(cause: Any) -> str:
    return "cause" if cause.proven else "likely cause" if cause.certain and cause.likely else "possible cause"


def _left(cause: Any) -> str:
    if not cause.certain:
        return f"{100 * cause.left:.2g} % of the error is elsewhere"
    return f"Undoing it leaves {100 * cause.left:.2g} % of the error."


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
