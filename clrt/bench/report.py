"""The report of a run: what stands in the JSON, and the tables that the terminal shows."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import msgspec

from clrt.base.atomic import write_json
from clrt.base.errors import ClrtError, one_line, show
from clrt.base.files import read_text_bytes
from clrt.base.limits import Limits
from clrt.bench import bands, live, queries, roof
from clrt.bench.frames import shares
from clrt.bench.timing import Measurement

if TYPE_CHECKING:
    from rich.table import Table

FORMAT: Final = 1
BESIDE_C: Final = "times Embree / robust"
_LEAST: Final = 1e-12  # seconds that nothing takes
_ROOFED: Final = ("tracing", "shading", "compaction")


@dataclass(frozen=True)
class Report:
    """All measurements of a run and the machine they are of."""

    machine: dict[str, Any]
    measurements: tuple[Measurement, ...]

    @property
    def roof(self) -> roof.Roof | None:
        """The device's best on one core; None where the run did not measure it."""
        measured = any(m.group == "roof" for m in self.measurements)
        return roof.roof_of(self.measurements) if measured else None

    def save(self, path: str | Path) -> None:
        content = {
            "format": FORMAT,
            "machine": self.machine,
            "measurements": [m.to_dict() for m in self.measurements],
        }
        write_json(path, content)

    def of(self, *groups: str) -> list[Measurement]:
        return [m for m in self.measurements if m.group in groups]


def load(path: str | Path) -> Report:
    """The report that `save` wrote. ClrtError for a file that is none."""
    try:
        content = json.loads(read_text_bytes(path, Limits()))
        if content["format"] != FORMAT:
            raise ClrtError(f"{path}: a report of format {show(content['format'])}; this clrt reads {FORMAT}")
        rows = msgspec.convert(content["measurements"], tuple[Measurement, ...])
        for row in rows:
            sound = row.seconds and all(_LEAST < t < 1 / _LEAST for t in row.seconds)
            if not (sound and row.items < 1 << 63):
                raise ValueError(f"its times or items are none: {row.seconds[:3]}, {show(row.items)}")
        return Report(msgspec.convert(content["machine"], dict[str, Any]), rows)
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        why = f"it has no {error}" if isinstance(error, KeyError) else one_line(str(error))
        raise ClrtError(f"{path}: not a report of `clrt bench --json`: {why}") from None


def tables(report: Report) -> Iterable[Table]:
    """What the terminal shows, a table a group."""
    if report.roof:
        yield _passes(report, report.roof)
    if report.of("embree"):
        yield _against(report)
    if report.of("queries"):
        yield _queries(report.of("queries"))
    if report.of("live"):
        yield _live(report.of("live"))
    others = report.of("builder", "launch", "compile", "program")
    if others:
        yield _others(others)
    if report.of("frame"):
        yield _frames(report.of("frame"))
    if report.of("bands"):
        yield _bands(report.of("bands"))


def table(title: str, left: Iterable[str], right: Iterable[str]) -> Table:
    from rich import box
    from rich.table import Table

    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for name in left:
        table.add_column(name, no_wrap=True)
    for name in right:
        table.add_column(name, justify="right", no_wrap=True)
    return table


def spread(m: Measurement) -> str:
    """How far its times scatter, or "-": one time does not."""
    return f"{m.spread:.1%}" if len(m.seconds) > 1 else "-"


def _passes(report: Report, best: roof.Roof) -> Table:
    title = (
        f"passes on one core; its roof: {best.memory / 1e9:.1f} GB/s copied "
        f"({best.cache / 1e9:.0f} in cache), {best.arithmetic / 1e9:.0f} Gflop/s"
    )
    right = ("Mrays/s", "ns a ray", "spread", "bytes a ray", "GB/s", "Gflop/s", "of the roof")
    rows = table(title, ("scene", "pass", "rays"), right)
    for m in report.of(*_ROOFED):
        rows.add_row(
            m.scene,
            m.name,
            m.queue,
            f"{1e3 / m.ns:.2f}",
            f"{m.ns:.1f}",
            spread(m),
            f"{m.nbytes / m.items:.0f}",
            f"{m.nbytes / m.median / 1e9:.2f}",
            f"{m.flops / m.median / 1e9:.1f}" if m.flops else "",
            f"{best.least_seconds(m) / m.median:.0%}",
        )
    return rows


def _others(measurements: Iterable[Measurement]) -> Table:
    rows = table(
        "around the passes, wall time", ("what", "scene"), ("threads", "a", "ms", "ns each", "spread")
    )
    for m in measurements:
        # what happens once has no time for each
        each = f"{m.ns:.1f}" if m.items > 1 else ""
        row = (f"{m.group}: {m.name}", m.scene, str(m.threads), f"{m.items} {m.unit}")
        rows.add_row(*row, f"{m.median * 1e3:.1f}", each, spread(m))
    return rows


def _frames(measurements: Iterable[Measurement]) -> Table:
    right = ("threads", "ms", "spread", "Mpixel/s", "Mrays/s", "tracing", "other passes", "host")
    rows = table("whole pictures, wall time", ("scene",), right)
    for m in measurements:
        part = shares(m)
        rows.add_row(
            m.scene,
            str(m.threads),
            f"{m.median * 1e3:.1f}",
            spread(m),
            f"{1e3 / m.ns:.2f}",
            f"{m.extra['rays'] / m.median / 1e6:.1f}",
            *(f"{part[name]:.0%}" for name in ("tracing", "passes", "host")),
        )
    return rows


def _queries(measurements: list[Measurement]) -> Table:
    lacking = "" if queries.compared(measurements) else "; embreex is not here to compare with"
    in_c = [m for m in measurements if m.queue.startswith(queries.CALLS)]
    right = ["rays", "ms a call", "spread", "Mrays/s", "of its kernel", "times embreex"]
    right += [BESIDE_C] if in_c else []
    rows = table(f"queries on one core, processor time{lacking}", ("scene", "query"), right)
    for m in measurements:
        if m in in_c:  # ten calls of each Embree, of which the best counts
            continue
        said = [queries.said(measurements, m, other) for other in (queries.KERNEL, queries.EMBREEX)]
        if in_c:
            said.append(" / ".join(filter(None, (queries.said(measurements, m, c) for c in queries.CALLS))))
        name = f"{m.name}: {m.queue}" if m.queue else m.name
        row = (m.scene, name, str(m.items), f"{m.median * 1e3:.3f}", spread(m), f"{1e3 / m.ns:.2f}")
        rows.add_row(*row, *said)
    return rows


def _live(measurements: list[Measurement]) -> Table:
    right = ("ms", "spread", "of a new Tracer's", "over its kernels'")
    rows = table("following a scene on one core, processor time", ("scene", "what"), right)
    for m in measurements:
        ratio = live.ratio(measurements, m)
        said = ["" if ratio is None else f"{ratio:.3f}", ""]
        said = said if m.unit == "primitives" else said[::-1]
        name = f"{m.name}: {m.queue}" if m.queue else m.name
        rows.add_row(m.scene, name, f"{m.median * 1e3:.2f}", spread(m), *said)
    return rows


def _bands(measurements: list[Measurement]) -> Table:
    right = ("ms", "spread", "times RGB, or one wavelength", "device, MiB")
    rows = table("pictures in bands, processor time", ("scene", "bands"), right)
    for m in measurements:
        cost = bands.ratio(measurements, m.scene, m.name)
        memory = f"{m.extra['device_bytes'] / 2**20:.0f}"
        rows.add_row(m.scene, m.name, f"{m.median * 1e3:.1f}", spread(m), f"{cost:.2f}", memory)
    return rows


def ratios(report: Report) -> list[dict[str, Any]]:
    """Our speed over Embree's: the best of its calls, and its single-ray call; a row a kind of rays.

    Keys: scene, queue, threads, rate (ours, items a second), default, robust, default_single, robust_single
    (absent for the tree), disagree.
    """
    rows = []
    for ours in report.of("tracing", "builder"):
        theirs = [
            m
            for m in report.of("embree")
            if (m.scene, m.queue, m.threads) == (ours.scene, ours.queue, ours.threads)
            and ("tree" in m.name) == (ours.name == "tree")
        ]
        if not theirs or (ours.group == "builder" and ours.name != "tree"):
            continue
        row: dict[str, Any] = {"scene": ours.scene, "queue": ours.queue or "tree", "threads": ours.threads}
        row["rate"] = ours.items / ours.median
        for mode in ("default", "robust"):
            calls = {m.name: m.median / ours.median for m in theirs if m.name.startswith(mode)}
            row[mode] = min(calls.values())
            if f"{mode} 1" in calls:
                row[f"{mode}_single"] = calls[f"{mode} 1"]
        row["disagree"] = theirs[0].extra.get("disagree")
        rows.append(row)
    return rows


def _against(report: Report) -> Table:
    right = (
        "threads",
        "Mitems/s",
        "best, default",
        "best, robust",
        "single, default",
        "single, robust",
        "disagree",
    )
    rows = table("our speed over Embree's, same rays and core", ("scene", "rays"), right)
    for row in ratios(report):
        modes = ("default", "robust", "default_single", "robust_single")
        rows.add_row(
            row["scene"],
            row["queue"],
            str(row["threads"]),
            f"{row['rate'] / 1e6:.2f}",
            *(f"{row[mode]:.2f}" if mode in row else "" for mode in modes),
            "" if row["disagree"] is None else f"{row['disagree']:.1e}",
        )
    return rows
