"""Reports of several devices, side by side: what one does in the time of another."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from clrt.base.atomic import write_json
from clrt.bench.report import FORMAT, Report, table
from clrt.bench.timing import Measurement

if TYPE_CHECKING:
    from rich.table import Table

_APART = ("embree",)  # another program, the same beside every device


def beside(reports: Sequence[Report]) -> Iterator[Table]:
    """A table a group: each device's time in ms, and how many times the first one's that is."""
    rows: dict[tuple[str, ...], dict[int, Measurement]] = {}
    for number, report in enumerate(reports):
        for m in report.measurements:
            # a device with other cores is timed with all of its own: 1, or "all"
            threads = "1" if m.threads == 1 else "all"
            if m.group not in _APART:
                rows.setdefault((m.group, m.scene, m.name, m.queue, threads), {})[number] = m
    for group in dict.fromkeys(key[0] for key in rows):
        numbers = range(1, len(reports) + 1)
        times = [f"{n}, ms" for n in numbers] + [f"{n} / 1" for n in numbers if n > 1]
        made = table(f"{group}, median times by device", ("scene", "what", "rays", "threads"), times)
        for key, found in rows.items():
            if key[0] == group:
                made.add_row(*key[1:], *_cells(found, len(reports)))
        yield made


def _cells(found: dict[int, Measurement], count: int) -> list[str]:
    times = [f"{found[n].median * 1e3:.2f}" if n in found else "-" for n in range(count)]
    if 0 not in found:
        return times + ["-"] * (count - 1)
    more = [f"x {found[n].ns / found[0].ns:.2f}" if n in found else "-" for n in range(1, count)]
    return times + more


def save(reports: Sequence[Report], path: str | Path) -> None:
    """All reports in one file, each as `Report.save` writes it."""
    content = [
        {"format": FORMAT, "machine": r.machine, "measurements": [m.to_dict() for m in r.measurements]}
        for r in reports
    ]
    write_json(path, {"reports": content})
