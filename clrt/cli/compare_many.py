"""`clrt compare REFERENCE A B C ...`: many pictures of one scene, as a table."""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

from clrt.base.errors import ClrtError, one_line
from clrt.cli.judging import DIGITS, VERDICTS, bits_of, judge, plain, read, reporting, scene_reference
from clrt.cli.terminal import console
from clrt.judging.verdict import certainty

SAME, DIFFERS = 0, 1  # exit codes
_FIGURES = ("SSIM", "FLIP", "PSNR")


def run(pictures: Any, options: argparse.Namespace) -> int:
    """Print a row a picture; 0 where all show the same, else 1. ClrtError at the end for what is not read."""
    from clrt.scene.scene import Scene

    names = [options.b, *options.more]
    reference = read(options.a, options)
    rendered: dict[tuple[int, ...], Any] = {}  # by size
    results: list[Any] = []
    with reporting(options.json) as report:
        for name in names:
            report(name)
            try:
                picture, scene, wanted = read(name, options), None, reference
                if isinstance(picture, Scene):
                    raise ClrtError(f"{name}: a scene; of three or more, only the first may be one")
                if isinstance(reference, Scene):
                    size = picture.shape[:2]
                    scene = scene_reference(reference, size, options)
                    if size not in rendered:
                        rendered[size] = scene.render()
                    wanted = rendered[size]
                bits = bits_of(name, options), bits_of(options.a, options)
                results.append(judge(pictures, picture, wanted, scene, options, report, bits))
            except ClrtError as error:
                results.append(error)
    if options.json:
        rows = [
            {"a": name, "b": options.a, "error": str(found)}
            if isinstance(found, ClrtError)
            else plain(found, name, options.a)
            for name, found in zip(names, results, strict=True)
        ]
        print(json.dumps(rows, indent=2, allow_nan=False))
    else:
        _show(names, results, options)
    unread = [str(found) for found in results if isinstance(found, ClrtError)]
    if unread:
        rest = f" (and {len(unread) - 1} more of {len(names)})" if len(unread) > 1 else ""
        raise ClrtError(f"{unread[0]}{rest}")
    return SAME if all(found.passed for found in results) else DIFFERS


def _show(names: list[str], results: list[Any], options: argparse.Namespace) -> None:
    from rich.markup import escape
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("picture", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    for figure in _FIGURES:
        table.add_column(figure, justify="right", no_wrap=True)
    table.add_column("why", overflow="fold")
    for name, found in zip(names, results, strict=True):
        if isinstance(found, ClrtError):
            why = one_line(str(found)).removeprefix(f"{name}: ")
            table.add_row(escape(name), "[red]not read[/]", "", "", "", escape(why))
            continue
        figures = [
            format(found.metrics[figure], DIGITS[figure]) if figure in found.metrics else ""
            for figure in _FIGURES
        ]
        first = found.causes[:1]
        why = "".join(f"{certainty(cause)}: {cause.name}" for cause in first)
        if not found.passed and not first:
            why = found.gates[0].detail if not found.metrics else "no usual mistake explains it"
        if found.notes:
            why = "; ".join(filter(None, [why, *found.notes]))
        colour = VERDICTS[found.verdict][0]
        table.add_row(escape(name), f"[{colour}]{found.verdict}[/]", *figures, escape(why))
    out = console(width=None if sys.stdout.isatty() else 200, highlight=False)
    out.print(f"against [bold]{escape(options.a)}[/]", soft_wrap=True)
    out.print(table)
    passed = sum(not isinstance(found, ClrtError) and found.passed for found in results)
    out.print(f"{passed} of {len(results)} show the same")
