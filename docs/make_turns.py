"""Times this checkout in turns with another one, for docs/performance.md.

    git worktree add ../other b1acb5f && python docs/make_turns.py ../other [--thesis FILE] [--quick]

A process each time, A B A B, one driver, processor time; what only one of the two knows does not count. Times
go to docs/performance/turns.json. FILE is the thesis' `mbs`; --quick takes tiny scenes, and keeps nothing.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS.parent))

import performance_tables as tables  # noqa: E402

from clrt.bench import host, machine  # noqa: E402
from validation.reliability import kept  # noqa: E402

NAME, GROUPS = "performance/turns.json", ("tracing", "builder", "frame", "bands")  # others do other work now
BENCH = """import sys, time, types, clrt.bench.frames as frames, clrt.bench.timing as timing
frames.time = types.SimpleNamespace(perf_counter=time.process_time)
timing.CLOCKS["wall"] = time.process_time
from clrt.cli import main; sys.exit(main(sys.argv[1:]))"""


def spent(checkout: Path, caches: dict[str, str], *words: str) -> float:
    """Processor seconds of a whole process."""
    before, environment = os.times(), {**caches, "PYTHONPATH": str(checkout)}
    subprocess.run([sys.executable, *words], cwd=checkout, env=environment, check=True)
    return sum(os.times()[2:4]) - sum(before[2:4])


def turn(where: tuple[Any, ...], renders: dict[str, list[str]], quick: list[str]) -> dict[str, Any]:
    """Seconds of each case, once around."""
    with tempfile.TemporaryDirectory() as folder:
        report, picture = f"{folder}/a.json", f"{folder}/a.png"
        render = *where, "-m", "clrt", "render", "-o", picture, "--quiet"
        found = {name: [spent(*render, *words)] for name, words in renders.items()}
        bench = *where, "-c", BENCH, "bench", "--rounds", "3", "--only", "kernels,builder,frames,bands"
        spent(*bench, "--json", report, *quick)
        rows = json.loads(Path(report).read_text())["measurements"]
    for row in rows:
        if row["group"] in GROUPS and row["name"] != "tree":  # that goes by the driver's own clock
            words = [row["group"], row["scene"], row["name"], row["queue"], f"{row['items']} {row['unit']}"]
            words += [f"{row['threads']} threads"] * (row["threads"] > 1)
            found[", ".join(filter(None, words))] = row["seconds"]
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("other", type=Path)
    parser.add_argument("--thesis")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--quick", action="store_const", const=["--quick"], default=[])
    options = parser.parse_args()
    asked = f"git -C {options.other} rev-parse --short HEAD".split()
    told = {"stamp": kept.stamp(kept.FILES[NAME]), "load_before": machine.load(),
            "other": subprocess.check_output(asked, text=True).strip()}  # fmt: skip
    renders = {tables.SHOWCASE: ["showcase", *["--width=64" for _ in options.quick]]}
    if options.thesis:
        size = "--width=2000", "--height=2500", "--spp=1"  # a .png has 4 otherwise, and 1 in old states
        renders[tables.MBS] = [str(Path(options.thesis).resolve()), *size]
    cases: dict[str, dict[str, list[float]]] = {}
    with host.empty_caches() as first, host.empty_caches() as second:
        both = {"ours": (DOCS.parent, first), "other": (options.other.resolve(), second)}
        for number in range(options.rounds + 1):  # the first fills the caches
            for name, where in both.items():
                for case, found in turn(where, renders, options.quick).items():
                    cases.setdefault(case, {}).setdefault(name, []).extend(found if number else [])
    told["cases"] = {case: times for case, times in cases.items() if len(times) == len(both)}
    print(tables.turns(told))
    if not options.quick:
        (DOCS / NAME).write_text(json.dumps(told, indent=1) + "\n")
