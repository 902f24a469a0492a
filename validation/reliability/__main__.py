"""Runs the rows that need it, and writes docs/reliability.md; see the package's own text."""

from __future__ import annotations

import argparse
import json
import os
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

from rich.progress import Progress

from clrt.base.atomic import replacing

from . import code
from . import kept as pages
from .rows import ROWS, Row, timed

DOCS: Final = Path(__file__).resolve().parents[2] / "docs"
KEPT: Final = DOCS / "reliability.json"
PAGE: Final = DOCS / "reliability.md"
STALE: Final = pages.STALE
START, END = "<!-- figures -->", "<!-- end of figures -->"


def kept() -> dict[str, dict[str, Any]]:
    """The figures of earlier runs by row."""
    return dict(json.loads(KEPT.read_text())) if KEPT.exists() else {}


def stands(row: Row, figures: dict[str, dict[str, Any]]) -> str:
    """What is wrong with a row's figure; "" where it is good."""
    found = figures.get(row.name)
    if found is None:
        return "not measured"
    if found["wrong"]:
        return f"{found['wrong']:,} wrong"
    if found["tried"] < row.count:
        return f"only {found['tried']:,}"
    if found.get("code") != row.code:
        return STALE
    return "measured with changes that no commit holds" if found["dirty"] else ""


def measure(row: Row) -> dict[str, Any]:
    """Run a row, and say with what."""
    stamp = pages.stamp(row.modules)
    with Progress() as bar:
        task = bar.add_task(row.name, total=1.0)
        figure = timed(row, lambda share: bar.update(task, completed=share))
    code.digest.cache_clear()
    return {**asdict(figure), **stamp, "dirty": stamp["dirty"] or row.code != stamp["code"]}


def table(figures: dict[str, dict[str, Any]]) -> str:
    """The figures as a table in Markdown."""
    lines = ["| promise | target | figure | time | measured |", "|---|---|---|---|---|"]
    for row in ROWS:
        found = figures.get(row.name)
        target = f"0 of {row.count:,} {row.unit}"
        if found is None:
            lines.append(f"| {row.promise} | {target} | not measured | | |")
            continue
        figure = f"**{found['wrong']:,} of {found['tried']:,}**; {found['detail']}"
        where = f"{found['date']}, {found['commit']}, {found['device'].split(' / ')[0]}"
        where += f" on {found['processor']}" if "processor" in found else ""
        if found.get("unable"):
            where = f"not run on this processor: {found['unable']}; last: {where}"
        command = f"`python -m validation.reliability --only {row.name}`"
        took = f"{found['seconds']:.0f} s"
        lines.append(f"| {row.promise} | {target} | {figure} | {took} | {where}; {command} |")
    return "\n".join(lines)


def write(figures: dict[str, dict[str, Any]]) -> None:
    """Put the table between its marks in the page."""
    text = PAGE.read_text()
    before, rest = text.split(START, 1)
    with replacing(PAGE) as temporary:
        temporary.write_text(f"{before}{START}\n{table(figures)}\n{END}{rest.split(END, 1)[1]}")


def keep(name: str, figures: dict[str, dict[str, Any]]) -> None:
    """Save a row's figure and the page; other rows may have been measured beside it."""
    figures |= {row: found for row, found in kept().items() if row != name}
    with replacing(KEPT) as temporary:
        temporary.write_text(json.dumps(figures, indent=1) + "\n")
    write(figures)


def excuse(row: Row, figures: dict[str, dict[str, Any]]) -> str:
    """Why a figure that is missing or old cannot be measured on this machine; what is wrong has no excuse."""
    found = figures.get(row.name)
    return "" if found and found["wrong"] else row.unable()


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m validation.reliability", description=(__doc__ or ""))
    parser.add_argument("--only", action="append", choices=[row.name for row in ROWS], metavar="ROW")
    parser.add_argument("--list", action="store_true", help="say how the figures stand")
    parser.add_argument(
        "--check", action="store_true", help="as --list; exit code 1 unless all that can be run here are "
        "good and the figures of the other pages are of this code",
    )
    options = parser.parse_args()
    figures = kept()
    bad = False
    for row in ROWS:
        state = stands(row, figures)
        print(f"{row.name:12} {state or 'good'}")
        wanted = row.name in options.only if options.only else bool(state)
        why = excuse(row, figures) if state or wanted else ""
        if why:
            print(f"{row.name:12} not run here: {why}")
        if wanted and not (options.list or options.check):
            if not why:
                figures[row.name] = measure(row)
                state = stands(row, figures)
                print(f"{row.name:12} {state or 'good'}: {figures[row.name]['detail']}")
                keep(row.name, figures)
            elif row.name in figures:
                figures[row.name]["unable"] = why
                keep(row.name, figures)
        bad |= bool(state) and not why
    if options.list or options.check:
        for name in pages.FILES:
            state = pages.stale(name)
            print(f"{os.path.normpath(f'docs/{name}')}: {state or 'good'}")
            bad |= bool(state)
    return int(bad and not options.list)


if __name__ == "__main__":
    sys.exit(main())
