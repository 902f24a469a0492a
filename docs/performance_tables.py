"""The tables of docs/performance.md, in Markdown, from reports and kept times."""

from __future__ import annotations

from collections.abc import Iterable
from statistics import geometric_mean, median
from typing import Any

from clrt.bench import bands as bench_bands
from clrt.bench import live as bench_live
from clrt.bench import queries as bench_queries
from clrt.bench import report
from clrt.bench.frames import shares
from clrt.bench.report import Report

SHOWCASE, MBS = "clrt render showcase", "clrt render mbs, 2000 x 2500"  # of docs/make_turns.py


def table(head: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """A table in Markdown; the first column is text, the others are numbers."""
    head = list(head)
    lines = [head, ["---", *(["---:"] * (len(head) - 1))], *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


def machine_line(made: Report) -> str:
    facts = made.machine
    return (
        f"{facts['processor']}, {facts['cores']} cores; {facts['device']}; load before the run "
        f"{facts['load_before']:.1f}."
    )


def against(made: Report) -> str:
    head = (
        "rays",
        "Mrays/s",
        "best call, default",
        "best call, robust",
        "single ray, default",
        "single ray, robust",
    )
    rows = []
    for row in report.ratios(made):
        if row["queue"] != "tree":
            modes = ("default", "robust", "default_single", "robust_single")
            rate = f"{row['rate'] / 1e6:.1f}"
            cells = (f"{row[mode]:.2f}" if mode in row else "" for mode in modes)
            rows.append((f"{row['scene']}, {row['queue']}", rate, *cells))
    return table(head, rows)


def trees(made: Report) -> str:
    rows = []
    for row in report.ratios(made):
        if row["queue"] == "tree":
            ours = next(
                m
                for m in made.of("builder")
                if (m.scene, m.name, m.threads) == (row["scene"], "tree", row["threads"])
            )
            speed = (f"{row[mode]:.2f}" for mode in ("default", "robust"))
            rows.append(
                (f"{ours.scene}, {ours.items} primitives", ours.threads, f"{ours.median * 1e3:.0f}", *speed)
            )
    return table(("tree", "threads", "ms", "Embree's time / ours, default", "robust"), rows)


def passes(made: Report) -> str:
    best = made.roof
    assert best is not None
    cell = {
        (m.name, m.queue, m.scene): f"{m.ns:.1f} ({best.least_seconds(m) / m.median:.0%})"
        for m in made.of("tracing", "shading", "compaction")
    }
    names = dict.fromkeys((name, queue) for name, queue, _ in cell)
    found = dict.fromkeys(scene for _, _, scene in cell)
    head = ("pass, rays", *found)
    return table(head, ((f"{n}, {q}", *(cell.get((n, q, scene), "") for scene in found)) for n, q in names))


def frames(made: Report) -> str:
    head = ("picture", "threads", "ms", "Mpixel/s", "Mrays/s", "finding hits", "other passes", "host")
    rows = []
    for m in made.of("frame"):
        part = shares(m)
        rate = (f"{m.median * 1e3:.0f}", f"{1e3 / m.ns:.2f}", f"{m.extra['rays'] / m.median / 1e6:.1f}")
        rows.append((m.scene, m.threads, *rate, *(f"{part[k]:.0%}" for k in ("tracing", "passes", "host"))))
    return table(head, rows)


def bands(made: Report) -> str:
    rows = []
    for m in made.of("bands"):
        cost = bench_bands.ratio(made.of("bands"), m.scene, m.name)
        memory = f"{m.extra['device_bytes'] / 2**20:.0f}"
        apart = f"{m.extra['apart']:.2%}" if "apart" in m.extra else ""
        rows.append((f"{m.scene}, {m.name}", f"{m.median * 1e3:.0f}", f"{cost:.2f}", memory, apart))
    head = ("picture", "processor time, ms", "times RGB, or one wavelength", "device, MiB", "values apart")
    return table(head, rows)


def programs(content: dict[str, Any]) -> str:
    """The thesis' own scene, a process a time."""
    rows = [
        (driver, f"{median(times['wall']):.2f}", f"{median(times['cpu']):.2f}")
        for driver, times in content["drivers"].items()
    ]
    return table(("driver", "wall time, s", "processor time, s"), rows)


def around(made: Report) -> str:
    rows = [
        (f"{m.group}: {m.name}", f"{m.ns / 1e3:.1f} us" if m.items > 1 else f"{m.median:.2f} s")
        for m in made.of("launch", "compile", "program")
    ]
    return table(("what", "time"), rows)


def povray(content: dict[str, Any]) -> str:
    rows = []
    for name, threads in content["scenes"].items():
        for n, times in threads.items():
            ours, theirs = median(times["ours"]), median(times["povray"])
            rows.append((name, n, f"{theirs:.2f}", f"{ours:.3f}", f"{theirs / ours:.1f}"))
    return table(("scene", "threads", "POV-Ray, s", "clrt, s", "times as fast"), rows)


def growth(content: dict[str, Any]) -> str:
    head = ("what grows", "to", "picture, ms", "Mrays/s", "until ready, ms", "device, MiB", "peak, MiB")
    rows = []
    for name, points in content["series"].items():
        for point in points:
            seconds = median(point["seconds"])
            memory = (f"{point[k] / 2**20:.0f}" for k in ("device_bytes", "peak_bytes"))
            rate = f"{point['rays'] / seconds / 1e6:.1f}"
            ready = f"{point['ready_seconds'] * 1e3:.0f}"
            rows.append(
                (name, f"{point['x']:,}".replace(",", " "), f"{seconds * 1e3:.1f}", rate, ready, *memory)
            )
    return table(head, rows)


def drivers(made: Report, other: Report) -> str:
    """The speed with another driver, as a share of that with the first, over the cases of each group."""
    first = {m.key: m for m in made.measurements}
    rows = []
    for group in ("roof", "tracing", "shading", "compaction", "builder", "frame"):
        ratio = [first[m.key].ns / m.ns for m in other.of(group) if m.key in first]
        if ratio:
            rows.append((group, *(f"{value:.2f}" for value in (min(ratio), median(ratio), max(ratio)))))
    named = f"{other.machine['device']}, as a share of {made.machine['device']}:"
    return f"{named}\n\n" + table(("cases", "least", "median", "largest"), rows)


def narrow(_: Report, made: Report) -> str:
    """The same rays otherwise: without AVX-512, ours and Embree's; or in packets of 8."""
    return f"{made.machine['device']}; Embree {', '.join(made.machine['embree'])}:\n\n" + against(made)


def processors(kept: dict[str, Any]) -> str:
    """Our speed over Embree's best call, default / robust, by kind of processor."""
    rows: dict[tuple[str, str], dict[tuple[str, str], str]] = {}
    heads = []
    for kind, found in kept.items():
        for name, code in ("bench", "all it has"), ("bench_lanes8", "packets of 8"), ("bench_avx2", "AVX2"):
            if name not in found:
                continue
            heads.append((kind, code))
            for row in found[name]:
                if row["queue"] != "tree":
                    cell = f"{row['default']:.2f} / {row['robust']:.2f}"
                    rows.setdefault((row["scene"], row["queue"]), {})[kind, code] = cell
    head = ("rays", *(f"{kind}, {code}" for kind, code in heads))
    return table(head, ((f"{s}, {q}", *(cells.get(h, "") for h in heads)) for (s, q), cells in rows.items()))


def queries(made: Report) -> str:
    """What a call takes, beside its kernel alone, beside embreex and beside Embree's best call from C."""
    rows, found = [], made.of("queries")
    others = bench_queries.KERNEL, bench_queries.EMBREEX, *bench_queries.CALLS
    for m in found:
        if not m.queue:
            kernel, embreex, *embree = (bench_queries.said(found, m, other) for other in others)
            cells = kernel, embreex, " / ".join(filter(None, embree))
            rows.append((m.name, f"{m.median * 1e3:.3g}", *cells))
    best = "times Embree's best call, default / robust"
    return table(("question", "ms", "of its kernel's rate", "times embreex", best), rows)


def live(made: Report) -> str:
    """Updates beside a new Tracer, pictures beside their kernels."""
    rows, found = [], made.of("live")
    for m in found:
        if not m.queue:
            ratio = bench_live.ratio(found, m)
            said = "" if ratio is None else f"{ratio:.2g} of a new `Tracer`"
            if m.unit != "primitives" and ratio is not None:
                said = f"{ratio:.3f} times its kernels"
            took = m.median * 1e3
            rows.append((m.name, f"{took:.0f}" if took > 1000 else f"{took:.3g}", said))
    return table(("what", "ms", "beside"), rows)


def faster(told: dict[str, Any]) -> dict[str, float]:
    """By case: how many times as fast it is as in the other checkout, of docs/make_turns.py."""
    return {case: median(found["other"]) / median(found["ours"]) for case, found in told["cases"].items()}


def turns(told: dict[str, Any]) -> str:
    """Every case, and their geometric mean."""
    rows = []
    for case, ratio in faster(told).items():
        took = (f"{median(told['cases'][case][name]) * 1e3:.4g}" for name in ("other", "ours"))
        rows.append((case, *took, f"{ratio:.2f}"))
    rows.append(("geometric mean", "", "", f"{geometric_mean(faster(told).values()):.2f}"))
    return table(("case", f"{told['other']}, ms", "now, ms", "times as fast"), rows)
