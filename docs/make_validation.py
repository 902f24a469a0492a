"""Write the figures of docs/validation.md from a run of the suite, or from several that are parts of one.

What they are made from is kept in docs/validation.json, with a stamp of the code.

    clrt validate --full --spd FOLDER --report report.html
    python docs/make_validation.py report.json
"""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from clrt.base.resources import validation_module

PAGE = Path(__file__).parent / "validation.md"
KEPT = PAGE.with_suffix(".json")
BEGIN, END = "<!-- figures: make_validation.py writes what follows -->\n", "<!-- end of figures -->\n"
SHOWN = ("exponent 36 for 40", "lost share at total internal reflection", "Snell without the square",
         "spheres 0.1 % too large", "one generation too few")  # fmt: skip
# figure, whether the smallest is the worst
FIGURES = {"SSIM": True, "FLIP": False, "PSNR": True, "within 1e-4": True, "mean radiance": False,
           "distance": False}  # fmt: skip
figure = validation_module("suite.report").figure


def figures(runs: list[dict[str, Any]]) -> Iterator[str]:
    """The lines between the marks."""
    for run in runs:
        failed = ", ".join(case["name"] for case in run["cases"] if not case["passed"])
        verdict = "all of it passed" if run["passed"] else f"NOT all of it passed: {failed or 'no case'}"
        done = f": {verdict}" if run["cases"] else ""
        yield f"- {command_of(run)}{done}; in {run['seconds'] / 60:.0f} min on {run['device']}"
    versions = [f"{name} {version}" for name, version in runs[0]["versions"].items()]
    yield f"\nMeasured with {', '.join(versions)}.\n"
    found = {key: [entry for run in runs for entry in run[key]] for key in ("mutants", "counts", "checks")}
    cases = {case["name"]: case for run in runs for case in run["cases"]}
    yield from pictures(list(cases.values()))
    for run in [run for run in runs if run["coverage"]][:1]:
        covered, features = len(run["coverage"]) - len(run["thin"]), len(run["coverage"])
        yield f"\n{covered} of {features} features agree under at least two oracles that share no code."
    if found["mutants"]:
        caught = sum(not mutant["survived"] for mutant in found["mutants"])
        yield f"{caught} of {len(found['mutants'])} faults that were planted in these runs were noticed."
    yield from (f"{check['name'].capitalize()}: {check['detail']}." for check in found["checks"])
    yield ""
    yield from counts([count for count in found["counts"] if ", " not in count["scene"]])
    yield ""
    yield from planted(found["mutants"])


def command_of(run: dict[str, Any]) -> str:
    """What was typed, without files; of many cases the first and the last."""
    command: str = run["command"]
    names = sorted((case["name"] for case in run["cases"]), key=lambda name: [
        int(part) if part.isdigit() else part for part in re.split(r"(\d+)", name)])  # fmt: skip
    if command.count(" --case ") > 2:
        options = re.sub(r" --case ('[^']*'|\S+)", "", command)
        command = f"{options} --case NAME, {len(names)} times ({names[0]} ... {names[-1]})"
    return f"`{command}`"


def pictures(cases: list[dict[str, Any]]) -> Iterator[str]:
    """A row for each oracle and number of samples: the worst of each figure."""
    yield "| oracle | samples | pictures | " + " | ".join(FIGURES) + " |"
    yield "|---|---|---|" + "---|" * len(FIGURES)
    groups: dict[tuple[str, int], list[dict[str, Any]]] = {}
    for case in cases:
        for oracle, found in case["oracles"].items():
            groups.setdefault((oracle, case["samples"]), []).append(found)
    for (oracle, samples), found in sorted(groups.items()):
        agree = sum(one["passed"] for one in found)
        cells = [worst(found, name, smallest) for name, smallest in FIGURES.items()]
        yield f"| {oracle} | {samples} | {agree} of {len(found)} | {' | '.join(cells)} |"


def worst(found: list[dict[str, Any]], name: str, smallest: bool) -> str:
    """The worst of a figure among those that are gated: the others are of pictures full of noise."""
    gated = [gate["value"] for one in found for gate in one["gates"] if gate["name"] == name]
    values = [math.inf if value is None else value for value in gated]  # an infinite PSNR is null
    return figure((min if smallest else max)(values)) if values else ""


def counts(rows: list[dict[str, Any]]) -> Iterator[str]:
    """Published ray counts and ours."""
    if not rows:
        return
    yield "| scene | rays | published | ours | apart |"
    yield "|---|---|---|---|---|"
    for row in rows:
        apart = f"{(row['ours'] - row['expected']) / row['expected']:+.3%}" if row["expected"] else ""
        yield f"| {row['scene']} | {row['kind']} | {row['expected']} | {row['ours']} | {apart} |"


def planted(mutants: list[dict[str, Any]]) -> Iterator[str]:
    """Some faults, and what validation says of them."""
    if not mutants:
        return
    yield "| fault | in | noticed on | blamed |"
    yield "|---|---|---|---|"
    for mutant in (mutant for name in SHOWN for mutant in mutants if mutant["name"] == name):
        how = mutant["how"].partition(": ")[0]
        yield f"| {mutant['name']} | `{mutant['file']}` | {how} | {mutant['where']} |"


def without_folders(run: dict[str, Any]) -> dict[str, Any]:
    """The run, whose command names no folder of the machine that it was on."""
    command = re.sub(r" --report \S+", "", re.sub(r" --spd \S+", " --spd FOLDER", run["command"]))
    return {**run, "command": command}


def main() -> None:
    runs = [without_folders(json.loads(Path(file).read_text("utf-8"))) for file in sys.argv[1:]]
    before, _, rest = PAGE.read_text("utf-8").partition(BEGIN)
    _, _, after = rest.partition(END)
    PAGE.write_text(before + BEGIN + "\n" + "\n".join(figures(runs)) + "\n\n" + END + after, encoding="utf-8")
    stamps = [run["stamp"] for run in runs]
    same = {stamp.get("code") for stamp in stamps}  # parts of one run are of one code, or of none
    first = {**stamps[0], "dirty": any(stamp["dirty"] for stamp in stamps)} if all(stamps) else {}
    kept = {"stamp": first if len(same) == 1 else {}, "runs": runs}
    KEPT.write_text(json.dumps(kept) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
