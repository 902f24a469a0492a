"""What the project wants to reach, and whether it does: the first table of docs/performance.md.

An aim is met where every value of it is, not rounded.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from statistics import geometric_mean, median
from typing import Any

from performance_tables import MBS, faster, table

from clrt.bench import bands, live, queries, report
from clrt.bench.frames import shares
from clrt.bench.report import Report

LARGE = ("terrain", "lumps")
RAYS = ("primary", "shadow", "reflection", "refraction", "incoherent")
MODES = ("default", "robust")
SHARE = 0.95  # of Embree's speed, where neither may use AVX-512
POVRAY = {"balls": 7, "mount": 6.5, "teapot": 9, "tree": 8}
Row = tuple[str, str, str, str]


def aims(
    made: Report, grown: dict[str, Any], peers: dict[str, Any], asked: Report, narrow: Report | None,
    turns: dict[str, Any] | None,
) -> str:  # fmt: skip
    """All of them. asked: queries and live scenes; narrow: without AVX-512; turns: with another checkout."""
    rows = [*_against_embree(made), *_without_avx512(narrow), *_whole(made, grown), *_povray(peers)]
    rows += [*_in_turns(turns), *_queries(asked), *_live(asked if asked.of("live") else made)]
    return table(("aim", "wanted", "measured", ""), rows)


def _aim(
    what: str, sign: str, wanted: Sequence[float], found: Sequence[float],
    form: str = "{:.2f}", unit: str = "",
) -> Row:  # fmt: skip
    """A row; each of `found` against its own of `wanted`, or the last."""
    limits = [*wanted, *[wanted[-1]] * len(found)][: len(found)]
    good = all(a >= b if sign == ">=" else a <= b for a, b in zip(found, limits, strict=True))
    texts = (" / ".join(form.format(value) for value in values) + unit for values in (wanted, found))
    limit, measured = texts
    return what, f"{sign} {limit}", measured, "met" if good else "missed"


def _against_embree(made: Report) -> Iterator[Row]:
    rows = {(row["scene"], row["queue"]): row for row in report.ratios(made) if row["queue"] != "tree"}
    for scene in (*LARGE, "flake"):
        for queue in RAYS:
            wanted = (1.10, 1.15) if scene in LARGE else (4.5,) if queue == "primary" else (1.6,)
            if (scene, queue) in rows:
                what = f"{scene}, {queue} rays, against Embree's best call, default / robust"
                yield _aim(what, ">=", wanted, [rows[scene, queue][mode] for mode in MODES])
    for scene in LARGE:
        for m in made.of("builder"):
            if (m.scene, m.name, m.threads) == (scene, "tree", 2):
                yield _aim(f"tree of {scene}, two cores", "<=", [0.28], [m.median], unit=" s")
    yield "a better tree of 1M triangles: built; incoherent rays", "<= 0.6 s; >= 1.05", "none", "missed"


def _without_avx512(narrow: Report | None) -> Iterator[Row]:
    found = [row for row in report.ratios(narrow) if row["queue"] in RAYS] if narrow else []
    if found:
        worst = [min(found, key=lambda row, mode=mode: row[mode]) for mode in MODES]
        names = " / ".join(f"{row['scene']}, {row['queue']}" for row in worst)
        what = f"without AVX-512, the worst rays, default / robust ({names}), against Embree with AVX2"
        yield _aim(what, ">=", [SHARE], [row[mode] for row, mode in zip(worst, MODES, strict=True)])


def _whole(made: Report, grown: dict[str, Any]) -> Iterator[Row]:
    flake = {m.threads: m for m in made.of("frame") if m.scene == "flake"}
    what = "sphereflake, 1024 x 1024, 3 lights, 5 generations, two cores of a Zen 5"
    if 2 in flake:
        yield _aim(what, ">=", [4.7], [1e3 / flake[2].ns], unit=" Mpixel/s")
        passes = 100 * shares(flake[2])["passes"]
        what = "passes other than finding hits, share of that picture"
        yield _aim(what, "<=", [36], [passes], "{:.0f}", " %")
        both = flake[1].median / flake[2].median
        yield _aim("two threads against one, that picture", ">=", [1.85], [both])
    for m in made.of("program"):
        what = "clrt render, small scene, caches filled, the process"
        yield _aim(what, "<=", [0.35], [m.median], unit=" s")
    for m in made.of("compile"):
        if m.name == "cold":
            yield _aim("kernels compiled, caches empty", "<=", [5], [m.median], unit=" s")
    peak = grown["series"]["pixels of 1M triangles"][-1]["peak_bytes"] / 2**30
    yield _aim("peak of memory, 1M triangles, 4096 x 4096", "<=", [1.5], [peak], unit=" GiB")
    found = made.of("bands")
    if found:
        wide = bands.ratio(found, "flake", "24 bands")
        yield _aim("24 bands against RGB, that picture", "<=", [2], [wide])
        faster = bands.MOST / bands.ratio(found, "glass ball", bands.DISPERSED)
        what = f"{bands.MOST} dispersed bands, glass on 8 % of the picture, against a picture for each"
        yield _aim(what, ">=", [6], [faster])


def _povray(peers: dict[str, Any]) -> Iterator[Row]:
    for name, times in peers["scenes"].items():
        wanted = POVRAY.get(name.split("_")[0])
        if wanted:
            faster = [median(t["povray"]) / median(t["ours"]) for t in times.values()]
            what = f"{name}, times as fast as POV-Ray, one thread / two"
            yield _aim(what, ">=", [wanted], faster)


def _in_turns(turns: dict[str, Any] | None) -> Iterator[Row]:
    """Against the other checkout that turns.json is about."""
    if not turns:
        return
    ratios, other = faster(turns), f"in turns with {turns['other']}, processor time"
    for case, ratio in ratios.items():
        if case.startswith("frame, flake") and "2 threads" in case:
            yield _aim(f"sphereflake, two cores, times as fast, {other}", ">=", [1.45], [ratio])
        if case == MBS:
            yield _aim(f"{case}, share of the time, {other}", "<=", [0.75], [1 / ratio])
    worst = min(ratios, key=lambda case: ratios[case])
    yield _aim(f"the slowest case ({worst}), {other}", ">=", [0.95], [ratios[worst]])
    mean = geometric_mean(ratios.values())
    yield _aim(f"geometric mean of {len(ratios)} cases, {other}", ">=", [1], [mean])


def _queries(asked: Report) -> Iterator[Row]:
    found = asked.of("queries")
    calls = {m.name: m for m in found if not m.queue}
    for name, other, what, wanted in (
        (queries.NEAREST, queries.KERNEL, "share of its kernel's rate", 0.85),
        (queries.NEAREST, queries.EMBREEX, "times embreex", 2.0),
        (queries.ALL, queries.EMBREEX, "times embreex", 1.3),
        (queries.BLOCKED, queries.EMBREEX, "times embreex", 2.0),
    ):
        value = queries.ratio(found, calls[name], other) if name in calls else None
        if value is not None:
            yield _aim(f"{name}, primary rays of the terrain, {what}", ">=", [wanted], [value])
    for few, most in (("1000 rays", 0.3), ("1 ray", 0.12)):
        if f"{queries.NEAREST}, {few}" in calls:
            took = calls[f"{queries.NEAREST}, {few}"].median * 1e3
            yield _aim(f"{queries.NEAREST}, {few}", "<=", [most], [took], unit=" ms")


def _live(asked: Report) -> Iterator[Row]:
    found = asked.of("live")
    for m in found:
        over = None if m.queue else live.ratio(found, m)
        if over is None:
            continue
        if m.name.startswith("update, another"):
            yield _aim(f"{m.name}, terrain", "<=", [5], [m.median * 1e3], "{:.1f}", " ms")
        elif m.name.startswith("update"):
            yield _aim(f"{m.name}, terrain, share of a new Tracer's time", "<=", [0.25], [over])
        else:
            most = 1.15 if "series" in m.name else 1.04 if "512" in m.name else 1.12
            yield _aim(f"{m.name}, {m.scene}, over its kernels' time", "<=", [most], [over])
