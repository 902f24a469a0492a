"""The tables of docs/performance.md, in Markdown, from reports and kept times."""

from __future__ import annotations

from collections.abc import Iterable
from statistics import median
from typing import Any

from clrt.bench import bands as bench_bands
from clrt.bench import live as bench_live
from clrt.bench import queries as bench_queries
from clrt.bench import report
from clrt.bench.frames import shares
from clrt.bench.report import Report

SCENES = ("terrain", "lumps", "flake")


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
    head = ("pass, rays", *SCENES)
    return table(head, ((f"{n}, {q}", *(cell.get((n, q, scene), "") for scene in SCENES)) for n, q in names))


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
    """The same rays without AVX-512, ours and Embree's."""
    return f"{made.machine['device']}; Embree {', '.join(made.machine['embree'])}:\n\n" + against(made)


def processors(kept: dict[str, Any]) -> str:
    """Our speed over Embree's best call, default / robust, by kind of processor."""
    rows: dict[tuple[str, str], dict[tuple[str, str], str]] = {}
    heads = []
    for kind, found in kept.items():
        for name, code in ("bench", "all it has"), ("bench_avx2", "AVX2"):
            if name not in found:
                continue
            heads.append((kind, code))
            for row in found[name]:
                if row["queue"] != "tree":
                    cell = f"{row['default']:.2f} / {row['robust']:.2f}"
                    rows.setdefault((row["scene"], row["queue"]), {})[kind, code] = cell
    head = ("rays", *(f"{kind}, {code}" for kind, code in heads))
    return table(head, ((f"{s}, {q}", *(cells.get(h, "") for h in heads)) for (s, q), cells in rows.items()))


def aims(made: Report, grown: dict[str, Any], peers: dict[str, Any], thesis: dict[str, Any]) -> str:
    """What the project wants to reach, and what it reaches."""
    rows = [*_against_embree(made), *_whole(made, grown), *_in_bands(made)]
    for driver, times in thesis["drivers"].items():
        wanted = {"PoCL 3.1": 4}.get(driver, 8)
        what = f"mbs, 2000 x 2500, 20 bands, the process, {driver}"
        rows.append((what, f"<= {wanted} s", f"{median(times['wall']):.2f} s"))
    for name, times in peers["scenes"].items():
        wanted = {"balls": 8, "teapot": 6, "mount": 6, "tree": 4}.get(name.split("_")[0])
        if wanted:
            faster = [median(t["povray"]) / median(t["ours"]) for t in times.values()]
            rows.append(
                (f"{name}, times as fast as POV-Ray, one thread and two", f">= {wanted}", *_texts(faster))
            )
    return table(("aim", "wanted", "measured"), rows)


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


def _in_bands(made: Report) -> Iterable[tuple[str, ...]]:
    found = made.of("bands")
    wide = bench_bands.ratio(found, "flake", "24 bands")
    yield "24 bands against RGB, that picture", "<= 2.0", f"{wide:.2f}"
    faster = bench_bands.MOST / bench_bands.ratio(found, "glass ball", bench_bands.DISPERSED)
    what = f"{bench_bands.MOST} dispersed bands, glass on 8 % of the picture, against a picture for each"
    yield what, ">= 10", f"{faster:.2f}"


def _texts(values: Iterable[float]) -> tuple[str]:
    return (", ".join(f"{value:.2f}" for value in values),)


def _against_embree(made: Report) -> Iterable[tuple[str, ...]]:
    rows = {(row["scene"], row["queue"], row["threads"]): row for row in report.ratios(made)}
    for queue, wanted in (("primary", ">= 1.05 / 1.15"), ("shadow", ">= 1.05 / 1.2")):
        for scene in ("terrain", "lumps"):
            row = rows[scene, queue, 1]
            what = f"{queue} rays, {scene}, against Embree's best call, default / robust"
            yield what, wanted, f"{row['default']:.2f} / {row['robust']:.2f}"
    for queue in ("reflection", "incoherent"):
        for scene in ("terrain", "lumps"):
            row = rows[scene, queue, 1]
            what = f"{queue} rays, {scene}, against Embree's single-ray call, default / robust"
            yield what, ">= 1.0 / 1.1", f"{row['default_single']:.2f} / {row['robust_single']:.2f}"
    spheres = {
        queue: row["default"]
        for (scene, queue, _), row in rows.items()
        if scene == "flake" and queue != "tree"
    }
    yield (
        "7381 spheres, the worst kind of rays, against Embree's best call",
        ">= 1.3",
        f"{min(spheres.values()):.2f}",
    )
    yield "7381 spheres, primary rays, against Embree's best call", ">= 5", f"{spheres['primary']:.2f}"
    for scene in ("terrain", "lumps"):
        row = rows[scene, "tree", 2]
        ours = next(m for m in made.of("builder") if (m.scene, m.name, m.threads) == (scene, "tree", 2))
        yield f"tree of {scene}, two cores", "<= 0.30 s", f"{ours.median:.2f} s"
        yield f"tree of {scene}, share of Embree's time on two threads", "<= 0.8", f"{1 / row['default']:.2f}"


def _whole(made: Report, grown: dict[str, Any]) -> Iterable[tuple[str, ...]]:
    flake = {m.threads: m for m in made.of("frame") if m.scene == "flake"}
    yield (
        "sphereflake, 1024 x 1024, 3 lights, 5 generations, two cores",
        ">= 4.5 Mpixel/s",
        f"{1e3 / flake[2].ns:.2f}",
    )
    part = shares(flake[2])
    yield "passes other than finding hits, share of that picture", "< 25 %", f"{part['passes']:.0%}"
    yield "two threads against one, that picture", ">= 1.85", f"{flake[1].median / flake[2].median:.2f}"
    program = next(iter(made.of("program")))
    yield "clrt render, small scene, caches filled, the process", "<= 0.6 s", f"{program.median:.2f} s"
    largest = grown["series"]["pixels of 1M triangles"][-1]
    peak = f"{largest['peak_bytes'] / 2**30:.2f} GiB"
    yield "peak of memory, 1M triangles, 4096 x 4096", "<= 1.5 GiB", peak
