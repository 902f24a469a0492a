"""Measure what a cluster costs, for docs/cluster.md: `python docs/make_cluster.py`.

One process with one thread, and 1 and 2 local workers with one thread each, in turns, render a picture of 64
tiles' worth of rays. Times are processor times, so that other work on the machine counts little. All raw
values go to docs/cluster.json; the tables of docs/cluster.md follow from them (`tables`).

    python docs/make_cluster.py wall [pinned]   wall times instead (2 minutes on a quiet machine); pinned: one
                                                core for the process, one for each worker
    python docs/make_cluster.py faults FILE     takes over what `tests.cluster.endurance --out FILE` found, in
                                                place of older runs with as many workers
"""

from __future__ import annotations

import json
import math
import os
import statistics
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))

import clrt  # noqa: E402
from clrt.cluster import pictures  # noqa: E402
from clrt.cluster.connect import connected  # noqa: E402
from clrt.engine.request import Request  # noqa: E402
from validation.reliability import kept  # noqa: E402

SCENE, WIDTH, HEIGHT, SPP, ROUNDS = "showcase", 2048, 1024, 4, 3
WORKERS = (1, 2, 10, 100, 1000)
BIG_SPP = 16
BIG = 3840 * 2160 * BIG_SPP  # rays of generation 0 of the picture that the model is asked about
MARK = "<!-- measured -->"
spread = statistics.median


def one_process(tracer: clrt.Tracer, size: dict[str, int]) -> dict[str, Any]:
    """Processor and wall seconds of a picture here."""
    cpu, wall = time.process_time(), time.perf_counter()
    image = tracer.render(**size)
    return {"cpu": time.process_time() - cpu, "wall": time.perf_counter() - wall, "hash": image.hash}


def on_workers(
    executor: Any, settings: clrt.Settings, scene: clrt.Scene, size: dict[str, int]
) -> dict[str, Any]:
    """Processor seconds of client (with the scheduler) and of each worker, and what an order took."""
    client = executor._client
    before = client.run(time.process_time)
    cpu, wall = time.process_time(), time.perf_counter()
    remote = pictures.Remote(executor, None, settings)
    sheet = pictures.Sheet(*remote.plan(scene, Request(**size)))
    (done,) = remote.sheets(iter([sheet]), 1)
    image, report = done.image(), remote.farm.report
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    after = client.run(time.process_time)
    return {
        "client": cpu, "workers": [after[name] - before[name] for name in before], "wall": wall,
        "orders": report.walls, "setups": report.setups, "sent": report.sent, "hash": image.hash,
    }  # fmt: skip


def measure() -> dict[str, Any]:
    """All raw values."""
    scene, size = clrt.load(SCENE), {"width": WIDTH, "height": HEIGHT, "spp": SPP}
    settings = clrt.Settings(threads=1)
    rounds: list[dict[str, Any]] = []
    first: dict[str, Any] = {}
    with clrt.Tracer(scene, settings=settings) as tracer:
        device = tracer.device.info.label
        first["process"] = one_process(tracer, size)  # what is new is compiled in the first
        for _ in range(ROUNDS):
            found = {"process": one_process(tracer, size)}
            for name in ("local:1", "local:2"):  # one at a time: schedulers are never quite idle
                with connected(name, settings) as (executor, _):
                    first[name] = on_workers(executor, settings, scene, size)
                    found[name] = on_workers(executor, settings, scene, size)
            rounds.append(found)
    picture = {"scene": SCENE, "rays": WIDTH * HEIGHT * SPP, "spp": SPP}
    return {"device": device, "picture": picture, "first": first, "rounds": rounds}


def pin(cores: set[int]) -> None:
    """Let all threads of this process use these cores; those that they start will do the same."""
    for thread in os.listdir("/proc/self/task"):
        with suppress(ProcessLookupError):  # it has ended since
            os.sched_setaffinity(int(thread), cores)


def walls(pinned: bool, rounds: int = 7) -> list[dict[str, dict[str, Any]]]:
    """One process, `local:1` and `local:2`, in turns: times of each, by the wall and of processors."""
    scene, size = clrt.load(SCENE), {"width": WIDTH, "height": HEIGHT, "spp": SPP}
    settings, cores = clrt.Settings(threads=1), sorted(os.sched_getaffinity(0))
    found: list[dict[str, dict[str, Any]]] = []
    with clrt.Tracer(scene, settings=settings) as tracer:
        one_process(tracer, size)
        for _ in range(rounds):
            if pinned:
                pin({cores[0]})
            told = {"process": one_process(tracer, size)}
            pin(set(cores))
            for name in ("local:1", "local:2"):
                with connected(name, settings) as (executor, _):
                    client = executor._client
                    for core, worker in zip(cores, client.run(os.getpid) if pinned else (), strict=False):
                        client.run(pin, {core}, workers=[worker])
                    on_workers(executor, settings, scene, size)  # scene, tree, memory of full tiles
                    told[name] = on_workers(executor, settings, scene, size)
            assert len({one["hash"] for one in told.values()}) == 1
            found.append(told)
    return found


def ratios(timed: dict[str, Any]) -> list[str]:
    """What wall times say of the two targets, as a table: median, least and most of the rounds."""
    where = "a core of its own" if timed["pinned"] else "any core"
    lines = ["", f"| wall time, each process with {where} | wanted | measured | met |", "|---|---|---|---|"]
    for title, wanted, top, bottom, more in (
        ("two workers, as fast as one", "1.7 times", "local:1", "local:2", True),
        ("`local:1` over one process", "at most 1.10", "local:1", "process", False),
    ):
        found = [one[top]["wall"] / one[bottom]["wall"] for one in timed["rounds"]]
        limit = float(wanted.split()[0] if more else wanted.split()[-1])
        met = spread(found) >= limit if more else spread(found) <= limit
        told = f"{spread(found):.2f} ({min(found):.2f} to {max(found):.2f})"
        lines.append(f"| {title} | {wanted} | {told} | {'yes' if met else 'no'} |")
    return lines


def tables(told: dict[str, Any]) -> str:
    """The tables of docs/cluster.md."""
    rounds = told["rounds"]
    here = spread(one["process"]["cpu"] for one in rounds)
    lines = ["| | processor time | of one process |", "|---|---|---|"]
    lines.append(f"| one process, one thread | {here:.2f} s | 1 |")
    for name in ("local:1", "local:2"):
        workers = spread(sum(one[name]["workers"]) for one in rounds)
        client = spread(one[name]["client"] for one in rounds)
        ratio = spread(
            (sum(one[name]["workers"]) + one[name]["client"]) / one["process"]["cpu"] for one in rounds
        )
        text = f"{workers:.2f} s in workers, {client:.2f} s in client and scheduler"
        lines.append(f"| `{name}`, one thread a worker | {text} | {ratio:.2f} |")
    worker, client, orders, setup = costs(told)
    rays, samples = told["picture"]["rays"], told["picture"]["spp"]
    pieces = math.ceil(BIG / (1 << 17))
    lines += [
        "",
        f"A task of {rays / orders:.0f} rays ({rays / orders / samples:.0f} pixels) takes a worker "
        f"{worker / orders * 1e3:.0f} ms, client and scheduler {client / orders * 1e3:.1f} ms; "
        f"a new worker is ready for the scene in {setup:.2f} s.",
        "",
        "| workers | time | speed-up | of it all |",
        "|---|---|---|---|",
    ]
    whole, served = worker * BIG / rays, client * BIG / BIG_SPP / (rays / samples)
    for workers in WORKERS:
        seconds = setup + max(math.ceil(pieces / workers) * whole / pieces, served)
        gain = whole / seconds
        lines.append(f"| {workers} | {seconds:.1f} s | {gain:.1f} | {100 * gain / workers:.0f} % |")
    return "\n".join([*lines, *(ratios(told["walls"]) if "walls" in told else ()), *faults(told)])


def faults(told: dict[str, Any]) -> list[str]:
    """What came of the rounds in which a worker was killed or paused, as a table."""
    lines = ["", "| workers, one of them | rounds | the same bits | done twice | median time |"]
    lines.append("|---|---|---|---|---|")
    kinds = {"picture": "a picture", "series": "four pictures", "validation": "cases of validation"}
    for run in told["faults"]:
        for what, name in (("kill", "killed"), ("pause", "paused")):
            for kind, shown in kinds.items():
                rows = [row for row in run["rounds"] if (row["what"], row["kind"]) == (what, kind)]
                rows = [row for row in rows if row.get("pieces", 1)]  # whose worker had something to do
                if rows:
                    same, took = sum(row["same"] for row in rows), spread(row["seconds"] for row in rows)
                    title = f"{run['workers']}, {name}, {shown}"
                    lines.append(f"| {title} | {len(rows)} | {same} | {twice(rows)} | {took:.1f} s |")
    return lines


def twice(rows: list[dict[str, Any]]) -> str:
    """What those left alone did beyond their answers; a single worker leaves nobody alone."""
    if any("twice" not in row for row in rows):
        return "not counted"
    known = [row["twice"] for row in rows if row["twice"] is not None]
    return str(sum(known)) if known else "nobody else"


def joined(old: list[dict[str, Any]], new: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Runs by their number of workers; the newer of two stays."""
    runs = {run["workers"]: run for run in (*old, *new)}
    return [runs[workers] for workers in sorted(runs)]


def common(stamps: list[dict[str, Any]]) -> dict[str, Any]:
    """The stamp of them all: parts are of one code, or of none."""
    if not all(stamps) or len({stamp["code"] for stamp in stamps}) > 1:
        return {}
    return {**stamps[0], "dirty": any(stamp["dirty"] for stamp in stamps)}


def costs(told: dict[str, Any]) -> tuple[float, float, float, float]:
    """Processor seconds of a worker and of the client for the picture, in how many orders; seconds of a
    worker's start. Rounds may differ in their orders, and all of them from the first."""
    found = [one["local:1"] for one in told["rounds"]]
    worker, client = spread(one["workers"][0] for one in found), spread(one["client"] for one in found)
    orders, setup = spread(len(one["orders"]) for one in found), max(told["first"]["local:1"]["setups"])
    return worker, client, orders, setup


def main() -> None:
    """Measure, and write file and page."""
    told = json.loads((FOLDER / "cluster.json").read_text("utf-8"))
    if sys.argv[1:2] == ["wall"]:
        pinned, stamp = sys.argv[2:] == ["pinned"], kept.stamp(kept.FILES[kept.CLUSTER])
        told["walls"] = {"pinned": pinned, "stamp": stamp, "rounds": walls(pinned)}
    elif sys.argv[1:2] == ["faults"]:
        runs = json.loads(Path(sys.argv[2]).read_text("utf-8"))["runs"]
        told["faults"] = joined(told["faults"], runs)
    else:
        told |= {"costs": kept.stamp(kept.FILES[kept.CLUSTER]), **measure()}
    parts = [told.get("costs", {}), told.get("walls", {}).get("stamp", {})]
    told["stamp"] = common([*parts, *(run.get("stamp", {}) for run in told["faults"])])
    (FOLDER / "cluster.json").write_text(json.dumps(told) + "\n", encoding="utf-8")
    page = FOLDER / "cluster.md"
    before, _, after = page.read_text(encoding="utf-8").split(MARK)
    page.write_text(f"{before}{MARK}\n{tables(told)}\n{MARK}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
