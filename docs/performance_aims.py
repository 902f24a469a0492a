"""What the project wants to reach, and whether it does: the first table of docs/performance.md.

An aim is met where every value of it is, not rounded. One without values is on the page, as not measured.
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
LIVE = {
    "update, moved vertices": "terrain", "update, another light": "terrain",
    "update, another material": "terrain", "picture of 512 x 512": "terrain",
    "picture of 320 x 180": "terrain", f"series of {live.FRAMES} pictures": "showcase",
}  # fmt: skip
NOT_MEASURED = "not measured"
Row = tuple[str, str, str, str]


def aims(
    made: Report, grown: dict[str, Any], peers: dict[str, Any], asked: Report, narrow: Report | None,
    turns: dict[str, Any] | None, cluster: dict[str, Any],
) -> str:  # fmt: skip
    """All of them. asked: queries and live scenes; narrow: without AVX-512; turns: with another checkout;
    cluster: docs/cluster.json."""
    rows = [*_against_embree(made), *_without_avx512(narrow), *_whole(made, grown), *_povray(peers)]
    rows += [*_in_turns(turns), *_queries(asked), *_live(asked if asked.of("live") else made)]
    rows += _cluster(cluster)
    return table(("aim", "wanted", "measured", ""), rows)


def _aim(
    what: str, sign: str, wanted: Sequence[float], found: Sequence[float],
    form: str = "{:.2f}", unit: str = "",
) -> Row:  # fmt: skip
    """A row; each of `found` against its own of `wanted`, or the last. None are found: not measured."""
    if not found:
        return what, f"{sign} {' / '.join(form.format(value) for value in wanted)}{unit}", "", NOT_MEASURED
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
            what = f"{scene}, {queue} rays, against Embree's best call, default / robust"
            measured = rows.get((scene, queue))
            yield _aim(what, ">=", wanted, [measured[mode] for mode in MODES] if measured else ())
    trees = {m.scene: m for m in made.of("builder") if (m.name, m.threads) == ("tree", 2)}
    for scene in LARGE:
        seconds = [trees[scene].median] if scene in trees else []
        yield _aim(f"tree of {scene}, two cores", "<=", [0.28], seconds, unit=" s")
    yield "a better tree of 1M triangles: built; incoherent rays", "<= 0.6 s; >= 1.05", "none", "missed"


def _without_avx512(narrow: Report | None) -> Iterator[Row]:
    found = [row for row in report.ratios(narrow) if row["queue"] in RAYS] if narrow else []
    worst = [min(found, key=lambda row, mode=mode: row[mode]) for mode in MODES] if found else []
    names = " / ".join(f"{row['scene']}, {row['queue']}" for row in worst)
    what = f"without AVX-512, the worst rays, default / robust{f' ({names})' if names else ''}"
    values = [row[mode] for row, mode in zip(worst, MODES, strict=False)]
    yield _aim(f"{what}, against Embree with AVX2", ">=", [SHARE], values)


def _whole(made: Report, grown: dict[str, Any]) -> Iterator[Row]:
    flake = {m.threads: m for m in made.of("frame") if m.scene == "flake"}
    both = [flake[threads] for threads in (1, 2) if threads in flake]
    two = [flake[2]] if 2 in flake else []
    what = "sphereflake, 1024 x 1024, 3 lights, 5 generations, two cores of a Zen 5"
    yield _aim(what, ">=", [4.7], [1e3 / m.ns for m in two], unit=" Mpixel/s")
    what = "passes other than finding hits, share of that picture"
    yield _aim(what, "<=", [36], [100 * shares(m)["passes"] for m in two], "{:.0f}", " %")
    gain = [both[0].median / both[1].median] if len(both) == 2 else []
    yield _aim("two threads against one, that picture", ">=", [1.85], gain)
    what = "clrt render, small scene, caches filled, the process"
    yield _aim(what, "<=", [0.35], [m.median for m in made.of("program")][:1], unit=" s")
    cold = [m.median for m in made.of("compile") if m.name == "cold"]
    yield _aim("kernels compiled, caches empty", "<=", [5], cold[:1], unit=" s")
    peak = grown["series"]["pixels of 1M triangles"][-1]["peak_bytes"] / 2**30
    yield _aim("peak of memory, 1M triangles, 4096 x 4096", "<=", [1.5], [peak], unit=" GiB")
    found = made.of("bands")
    wide = [bands.ratio(found, "flake", "24 bands")] if found else []
    yield _aim("24 bands against RGB, that picture", "<=", [2], wide)
    faster = [bands.MOST / bands.ratio(found, "glass ball", bands.DISPERSED)] if found else []
    what = f"{bands.MOST} dispersed bands, glass on 8 % of the picture, against a picture for each"
    yield _aim(what, ">=", [6], faster)


def _povray(peers: dict[str, Any]) -> Iterator[Row]:
    scenes = {name.split("_")[0]: name for name in peers["scenes"]}
    for short, wanted in POVRAY.items():
        times = peers["scenes"].get(scenes.get(short), {})
        faster = [median(t["povray"]) / median(t["ours"]) for t in times.values()]
        what = f"{scenes.get(short, short)}, times as fast as POV-Ray, one thread / two"
        yield _aim(what, ">=", [wanted], faster)


def _in_turns(turns: dict[str, Any] | None) -> Iterator[Row]:
    """Against the other checkout that turns.json is about."""
    ratios = faster(turns) if turns else {}
    other = f"in turns with {turns['other'] if turns else 'an older state'}, processor time"
    frames = [r for case, r in ratios.items() if case.startswith("frame, flake") and "2 threads" in case]
    yield _aim(f"sphereflake, two cores, times as fast, {other}", ">=", [1.45], frames[:1])
    share = [1 / ratios[MBS]] if MBS in ratios else []
    yield _aim(f"{MBS}, share of the time, {other}", "<=", [0.75], share)
    worst = min(ratios, key=lambda case: ratios[case], default="")
    named = f" ({worst})" if worst else ""
    yield _aim(f"the slowest case{named}, {other}", ">=", [0.95], [ratios[worst]] if worst else [])
    mean = [geometric_mean(ratios.values())] if ratios else []
    yield _aim(f"geometric mean of {len(ratios) or 'all'} cases, {other}", ">=", [1], mean)


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
        values = [] if value is None else [value]
        yield _aim(f"{name}, primary rays of the terrain, {what}", ">=", [wanted], values)
    for few, most in (("1000 rays", 0.3), ("1 ray", 0.12)):
        took = [1e3 * m.median for name, m in calls.items() if name == f"{queries.NEAREST}, {few}"]
        yield _aim(f"{queries.NEAREST}, {few}", "<=", [most], took, unit=" ms")


def _live(asked: Report) -> Iterator[Row]:
    found = asked.of("live")
    timed = {m.name: m for m in found if not m.queue}
    for name, scene in LIVE.items():
        m = timed.get(name)
        over = None if m is None else live.ratio(found, m)
        values = [] if over is None else [over]
        if name.startswith("update, another"):
            took = [m.median * 1e3] if m else []
            yield _aim(f"{name}, {scene}", "<=", [5], took, "{:.1f}", " ms")
        elif name.startswith("update"):
            yield _aim(f"{name}, {scene}, share of a new Tracer's time", "<=", [0.25], values)
        else:
            most = 1.15 if "series" in name else 1.04 if "512" in name else 1.12
            yield _aim(f"{name}, {scene}, over its kernels' time", "<=", [most], values)


def _cluster(told: dict[str, Any]) -> Iterator[Row]:
    """Wall times, medians of the rounds: docs/make_cluster.py wall."""
    rounds = told.get("walls", {}).get("rounds", [])
    walls = [{name: one["wall"] for name, one in times.items()} for times in rounds]
    gain = [median(one["local:1"] / one["local:2"] for one in walls)] if walls else []
    yield _aim("two workers on two cores, times as fast as one", ">=", [1.7], gain)
    over = [100 * (median(one["local:1"] / one["process"] for one in walls) - 1)] if walls else []
    what = "a picture of 64 tiles by one worker, over the time of one process"
    yield _aim(what, "<=", [10], over, "{:.0f}", " %")
