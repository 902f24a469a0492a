"""Measures what docs/performance.md shows, and writes its tables and charts.

    python docs/make_performance.py                        tables and charts, from the times that are kept
    python docs/make_performance.py --measure              measure again first; says how long each part took
    python docs/make_performance.py --measure --spd FOLDER and time POV-Ray, on scenes of the SPD
    python docs/make_performance.py --measure --thesis FILE and time the thesis' `mbs`
    python docs/make_performance.py --measure --part queries   that part alone; or packets: of 8; or others:
                                                           POV-Ray and mbs
    python docs/make_performance.py --measure --quick      try that with tiny scenes, in a temporary folder

FOLDER holds each scene twice, as spd/NAME.nff and pov/NAME.pov. The times are kept in
docs/performance/*.json. The machine should have nothing else to do; its load before each run is kept and
shown. The ratios to Embree are kept in processors.json once more, by kind of processor. Without FOLDER the
kept times of POV-Ray stay, without FILE those of `mbs`.
"""

# ruff: noqa: E402  (a checkout's own clrt is measured, installed or not)

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS.parent))

import performance_tables as tables
from performance_aims import aims

import clrt
from clrt.bench import chart, host, machine, report, scaling, scenes, suite
from clrt.bench.frames import frame_times
from clrt.device import trial
from clrt.device.platforms import devices
from validation.reliability import kept as figures

DRIVERS = ("PoCL 3.1", "PoCL 3.0", "Intel")  # those of them that work here are compared
NARROW = "Intel"  # the driver that can be told to do without AVX-512
NARROWED = {"CL_CONFIG_CPU_TARGET_ARCH": "core-avx2"}
CLUSTER = DOCS / "cluster.json"  # of docs/make_cluster.py
CALLS = ("queries", "live")  # groups of the bench that have pages of their own
FEW = 3  # rounds of what is only compared with itself, against nine


_HEADS = {
    "bench_avx2": """\
## Without AVX-512

Our speed over Embree's where neither may use AVX-512, as on most laptops: with Intel's runtime, which
`CL_CONFIG_CPU_TARGET_ARCH=core-avx2` tells so, and Embree with `isa=avx2`.""",
    "bench_lanes8": """\
## In packets of 8

The same with `Settings(lanes=8)` in place of 16: as many as a processor without AVX-512 takes at once.""",
    "turns": """\
## In turns with an older state

`python docs/make_turns.py`: a process each, A B A B, on one machine and driver; processor time, medians. What
only one of the two knows is left out.""",
    "processors": """\
## By kind of processor

Our speed over Embree's best call, default / robust. `--measure` writes the figures of the processor that it
runs on, and leaves those of others.""",
}
"""Of parts that are on the page only once they are measured."""


def measure(kept: Path, spd: Path | None, thesis: Path | None, quick: bool) -> None:
    """Everything anew, into `kept`/*.json; says how long each part took."""
    rounds = {"rounds": FEW} if quick else {}
    drivers = _found_apart()
    with _timed("bench"):
        stamp = _stamp("bench")
        groups = [group for group in suite.GROUPS if group not in CALLS]
        made = suite.run(suite.Plan(groups=groups, embree=True, quick=quick, **rounds), print)
        made.save(kept / "bench.json")
        _keep(kept / "bench.json", {**json.loads((kept / "bench.json").read_text()), "stamp": stamp})
    calls(kept, quick, **rounds)
    with _timed("the other driver"):
        (kept / "bench_other.json").unlink(missing_ok=True)
        if len(drivers) > 1:
            only = ["--only", "kernels,builder,frames"]
            _bench(only, drivers[1], FEW, kept / "bench_other.json", quick, {})
    with _timed("without AVX-512"):
        (kept / "bench_avx2.json").unlink(missing_ok=True)
        if NARROW in drivers:
            narrow(kept / "bench_avx2.json", quick)
    packets(kept, quick)
    _note_processor(kept, stamp)
    with _timed("scaling"):
        stamp = _stamp("scaling")
        _keep(kept / "scaling.json", {**scaling.run(quick, rounds=FEW), "stamp": stamp})
    others(kept, spd, thesis, quick)


def calls(kept: Path, quick: bool, **rounds: int) -> None:
    """What a caller's rays and changes cost; beside Embree, and embreex where that is installed."""
    with _timed("queries and live scenes"):
        stamp = _stamp("queries")
        made = suite.run(suite.Plan(groups=CALLS, embree=True, quick=quick, **rounds), print)
        made.save(kept / "queries.json")
        _keep(kept / "queries.json", {**json.loads((kept / "queries.json").read_text()), "stamp": stamp})


def others(kept: Path, spd: Path | None, thesis: Path | None, quick: bool) -> None:
    """Whole programs, on scenes that do not ship with clrt."""
    if spd:
        with _timed("POV-Ray"):
            stamp = _stamp("povray")
            _keep(kept / "povray.json", {**peers(spd, 1 if quick else 5), "stamp": stamp})
    if thesis:
        with _timed("the thesis' mbs"):
            stamp = _stamp("thesis")
            found = processes(thesis, 1 if quick else 5, _found_apart()[:2])
            _keep(kept / "thesis.json", {**found, "stamp": stamp})


@contextmanager
def _timed(what: str) -> Iterator[None]:
    begin = time.perf_counter()
    yield
    print(f"{what}: measured in {time.perf_counter() - begin:.0f} s", flush=True)


def working() -> list[str]:
    """Those of DRIVERS that build kernels on this machine."""
    found = []
    for name in DRIVERS:
        infos = [info for info in devices() if name.lower() in info.label.lower()]
        if infos and not trial.verdict(infos[0])[0]:
            found.append(name)
    return found


def narrow(file: Path, quick: bool) -> None:
    """Rays against Embree, both without AVX-512, in a process of its own: drivers read variables once."""
    against = ["--only", "kernels", "--against", "embree-avx2"]
    _bench(against, NARROW, FEW if quick else 5, file, quick, NARROWED)


def packets(kept: Path, quick: bool) -> None:
    """Rays against Embree in packets of 8: what Intel's driver takes by itself, and any by `lanes`."""
    with _timed("packets of 8"):
        stamp = _stamp("bench_lanes8")
        plan = suite.Plan(
            groups=["kernels"], names=tuple(scenes.WHOLE), rounds=FEW if quick else 5, quick=quick,
            embree=True, settings=clrt.Settings(lanes=8),
        )  # fmt: skip
        suite.run(plan, print).save(kept / "bench_lanes8.json")
        told = json.loads((kept / "bench_lanes8.json").read_text())
        _keep(kept / "bench_lanes8.json", {**told, "stamp": stamp})


def _bench(
    what: list[str], driver: str, rounds: int, file: Path, quick: bool, variables: dict[str, str]
) -> None:
    command = [sys.executable, "-m", "clrt", "bench", *what, "--device", driver]
    command += ["--rounds", str(rounds), "--json", str(file), *["--quick"] * quick]
    stamp = _stamp(file.stem)
    subprocess.run(command, cwd=DOCS.parent, env={**os.environ, **variables}, check=True)
    _keep(file, {**json.loads(file.read_text()), "stamp": stamp})


def _found_apart() -> list[str]:
    """`working()` of another process: a driver that is loaded here would meet Embree's libraries."""
    order = "import json, make_performance; print(json.dumps(make_performance.working()))"
    done = subprocess.run(
        [sys.executable, "-c", order], cwd=DOCS, capture_output=True, text=True, check=True
    )
    found: list[str] = json.loads(done.stdout)
    return found


def _note_processor(kept: Path, stamp: dict[str, Any]) -> None:
    """The ratios to Embree under this kind of processor; those of others stay."""
    file = kept / "processors.json"
    known = json.loads(file.read_text()) if file.exists() else {}
    own: dict[str, Any] = {"stamp": stamp}
    for name in ("bench", "bench_avx2", "bench_lanes8"):
        if (kept / f"{name}.json").exists():
            own[name] = report.ratios(report.load(kept / f"{name}.json"))
    _keep(file, {**known, machine.processor_kind(): own})


def _stamp(name: str) -> dict[str, Any]:
    """What a file of times is of; taken before they are."""
    return figures.stamp(figures.FILES[f"performance/{name}.json"])


def processes(scene: Path, rounds: int, drivers: list[str]) -> dict[str, Any]:
    """`clrt render` of a scene at 2000 x 2500 on these drivers, in turns, after one to fill the caches.

    Seconds of the whole process, by the wall and of processors.
    """
    found: dict[str, Any] = {"load_before": machine.load(), "drivers": {}}
    for driver in drivers:
        found["drivers"][driver] = {"wall": [], "cpu": []}
    with host.empty_caches() as environment, tempfile.TemporaryDirectory() as folder:
        size = ["--width", "2000", "--height", "2500", "--spp", "1", "-o", f"{folder}/out.png", "--quiet"]
        for turn in range(rounds + 1):
            for driver, times in found["drivers"].items():
                start = time.perf_counter()
                command = [sys.executable, "-m", "clrt", "render", str(scene), *size, "--device", driver]
                child = subprocess.Popen(command, cwd=DOCS.parent, env=environment)
                _, status, used = os.wait4(child.pid, 0)
                wall = time.perf_counter() - start
                if status:
                    raise RuntimeError(f"{scene}: clrt render on {driver} failed; its message is above")
                if turn:
                    times["wall"].append(wall)
                    times["cpu"].append(used.ru_utime + used.ru_stime)
    print(found)
    return found


def peers(folder: Path, rounds: int) -> dict[str, Any]:
    """Seconds of POV-Ray's trace and of our picture, 512 x 512, one thread and two, in turns."""
    found: dict[str, Any] = {"load_before": machine.load(), "scenes": {}}
    for file in sorted((folder / "pov").glob("*.pov")):
        scene = clrt.load(folder / "spd" / f"{file.stem}.nff")
        rows: dict[str, dict[str, list[float]]] = {}
        for threads in (1, 2):
            rows[str(threads)] = {"ours": [], "povray": []}
            for _ in range(rounds):
                rows[str(threads)]["povray"].append(_povray(file, threads))
                (ours,) = frame_times({file.stem: (scene, 512)}, (threads,), 1, None, clrt.Settings())
                rows[str(threads)]["ours"] += ours.seconds
        found["scenes"][file.stem] = rows
        print(file.stem, rows)
    return found


def _povray(file: Path, threads: int) -> float:
    """The trace time that POV-Ray itself reports."""
    with tempfile.TemporaryDirectory() as folder:
        size = ["+W512", "+H512", f"+WT{threads}", "-D", "-A"]
        command = ["povray", f"+I{file}", f"+O{folder}/out.png", *size]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    found = re.search(r"Trace Time:.*\(([\d.]+) seconds\)", done.stderr)
    if not found:
        raise RuntimeError(f"{file}: POV-Ray reported no trace time")
    return float(found.group(1))


def _keep(path: Path, content: dict[str, Any]) -> None:
    path.write_text(json.dumps(content, indent=1) + "\n")


def write(kept: Path, page: Path) -> None:
    """The charts, and each table between its marks in the page."""
    made = report.load(kept / "bench.json")
    grown = json.loads((kept / "scaling.json").read_text())
    times = kept / "povray.json"
    povray = json.loads(times.read_text()) if times.exists() else {"scenes": {}}
    asked = report.load(kept / "queries.json") if (kept / "queries.json").exists() else made
    turns = json.loads((kept / "turns.json").read_text()) if (kept / "turns.json").exists() else None
    narrow = report.load(kept / "bench_avx2.json") if (kept / "bench_avx2.json").exists() else None
    times = kept / "thesis.json"
    thesis = json.loads(times.read_text()) if times.exists() else {"drivers": {}}
    chart.roofline(made, kept / "roofline.svg")
    scaling.chart(grown, kept / "scaling.svg")
    parts = {
        "machine": tables.machine_line(made),
        "aims": aims(made, grown, povray, asked, narrow, turns, json.loads(CLUSTER.read_text())),
        "against": tables.against(made),
        "trees": tables.trees(made),
        "passes": tables.passes(made),
        "frames": tables.frames(made),
        "bands": tables.bands(made),
        "thesis": tables.programs(thesis),
        "around": tables.around(made),
        "povray": tables.povray(povray),
        "scaling": tables.growth(grown),
    }
    for name, show in (
        ("bench_other", tables.drivers), ("bench_avx2", tables.narrow), ("bench_lanes8", tables.narrow),
    ):  # fmt: skip
        if (kept / f"{name}.json").exists():
            parts[name] = show(made, report.load(kept / f"{name}.json"))
    if (kept / "processors.json").exists():
        parts["processors"] = tables.processors(json.loads((kept / "processors.json").read_text()))
    if turns:
        parts["turns"] = tables.turns(turns)
    for name in _HEADS:  # a page has no headings above nothing
        parts[name] = f"{_HEADS[name]}\n\n{parts[name]}" if name in parts else ""
    _fill(page, parts)
    for name, group, show in ("queries", "queries", tables.queries), ("live-scenes", "live", tables.live):
        found = asked if asked.of(group) else made
        if found.of(group) and (page.parent / f"{name}.md").exists():
            _fill(page.parent / f"{name}.md", {"measured": f"{tables.machine_line(found)}\n\n{show(found)}"})


def _fill(page: Path, parts: dict[str, str]) -> None:
    """Writes each part between its marks."""
    text = page.read_text()
    for name, part in parts.items():
        start, end = f"<!-- {name} -->", f"<!-- end {name} -->"
        if start not in text or end not in text:
            sys.exit(f"{page}: the marks {start} and {end} are missing")
        before, rest = text.split(start, 1)
        text = f"{before}{start}\n{part}\n{end}{rest.split(end, 1)[1]}"
    page.write_text(text)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--measure", action="store_true")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--spd", type=Path, metavar="FOLDER")
    parser.add_argument("--thesis", type=Path, metavar="FILE")
    parser.add_argument("--part", choices=["queries", "packets", "others"], help="measure that alone")
    options = parser.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="clrt-performance-")) if options.quick else DOCS
    page, kept = folder / "performance.md", folder / "performance"
    if options.quick:
        shutil.copy(DOCS / "performance.md", page)
        shutil.copytree(DOCS / "performance", kept)  # a part leaves the others
    kept.mkdir(exist_ok=True)
    if options.measure:
        with _timed("all"):
            rounds = {"rounds": FEW} if options.quick else {}
            if options.part == "queries":
                calls(kept, options.quick, **rounds)
            elif options.part == "packets":
                packets(kept, options.quick)
            elif options.part == "others":
                others(kept, options.spd, options.thesis, options.quick)
            else:
                measure(kept, options.spd, options.thesis, options.quick)
    write(kept, page)
    print(page)


if __name__ == "__main__":
    main()
