"""`clrt compare`: how far a picture is from another one, or from what its scene should show, and why."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from clrt.base.errors import ClrtError
from clrt.base.resources import validation_module
from clrt.cli import compare_many
from clrt.cli.judging import (
    DIGITS,
    VERDICTS,
    bits_of,
    judge,
    plain,
    read,
    reporting,
    scene_reference,
)
from clrt.cli.terminal import console
from clrt.judging.verdict import PICTURES, Verdict, certainty, check_page, needing_extra

DIFFERS = 1  # exit code
_MEANINGS = {
    "SSIM": "structure, 1 is equal",
    "FLIP": "what an eye sees, 0 is equal",
    "PSNR": "dB, inf is equal",
    "PSNR above white": "dB, of radiance above 1",
    "worst window": "SSIM of the worst 11 x 11 pixels",
    "widest place": "pixels a side, off by 8 of 255",
    "thin place": "pixels, 2 wide, off by 8 of 255",
    "largest difference": "linear radiance",
    "mean difference": "linear radiance, worst channels",
    "largest, of 255": "in steps of an 8-bit picture",
    "mean, of 255": "in steps of an 8-bit picture",
    "pixels that differ": "share, by more than rounding",
    "brightness": "mean radiance, A / B",
    "edges left out": "share of pixels",
}


def run(options: argparse.Namespace) -> int:
    """Print the comparison; 0 where all show the same, else 1. ClrtError where one cannot be read."""
    if options.seconds is not None and not options.seconds >= 0:
        raise ClrtError(f"--seconds: {options.seconds} is not allowed; it must be a number >= 0")
    if options.report:
        if options.more:
            raise ClrtError("--report is the page of one comparison; give two names")
        check_page(options.report)
    with needing_extra("clrt compare"):
        pictures = validation_module("compare.pictures")
        if options.more:
            return compare_many.run(pictures, options)
        result, picture, reference = _compare(pictures, options)
        if options.report:
            verdict = Verdict(
                result.verdict, result.passed, result.metrics, result.gates, result.causes, result.notes,
                picture, reference, (options.a, options.b),
            )  # fmt: skip
            verdict.save_report(options.report)
    if options.json:
        print(json.dumps(plain(result, options.a, options.b), indent=2, allow_nan=False))
    else:
        _show(result, options)
    return 0 if result.passed else DIFFERS


def _compare(pictures: Any, options: argparse.Namespace) -> tuple[Any, Any, Any]:
    """The comparison of A with B, and both as they were compared.

    A scene is always the reference, whichever of the two it is.
    """
    from clrt.scene.scene import Scene

    picture, reference = read(options.a, options), read(options.b, options)
    bits = bits_of(options.a, options), bits_of(options.b, options)
    with reporting(options.json) as report:
        report("rendering")
        if isinstance(picture, Scene) and isinstance(reference, Scene):
            picture = scene_reference(picture, None, options).render()
        elif isinstance(picture, Scene):
            picture, reference, bits = reference, picture, bits[::-1]
        scene = None
        if isinstance(reference, Scene):
            scene = scene_reference(reference, picture.shape[:2], options)
            reference = scene.render()
        return judge(pictures, picture, reference, scene, options, report, bits), picture, reference


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


def _left(cause: Any) -> str:
    if cause.left >= 1:
        return "Undoing it alone makes the error no smaller."
    if not cause.certain:
        return f"{100 * cause.left:.2g} % of the error is elsewhere"
    return f"Undoing it leaves {100 * cause.left:.2g} % of the error."
