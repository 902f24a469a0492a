"""The suite's result as one page that needs nothing else: no network, no files beside it."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from clrt.base.atomic import write_text

from ..compare.rays import key_label
from ..types import COUNT_TOLERANCE, FEWEST_ORACLES, CaseResult, Gate, SuiteResult
from .pictures import DECADES, FLOOR, case_pictures

_TEMPLATES = Path(__file__).parent / "templates"


def write_report(result: SuiteResult, path: str | os.PathLike[str]) -> Path:
    """Write the page of a suite's result to `path`, whole or not at all; returns the absolute path.

    ClrtError where the file cannot be written.
    """
    write_text(path, report_html(result))
    return Path(path).resolve()


def report_html(result: SuiteResult) -> str:
    """The page."""
    pictures = [case_pictures(case.ours, case.results) for case in result.cases]
    return environment().get_template("report.html").render(
        result=result,
        headline=headline(result),
        tiles=list(tiles(result)),
        failures=list(failures(result)),
        closest=closest(result),
        oracles=oracle_names(result),
        unproven=[(case.case.name, *reason) for case in result.cases for reason in case.unproven.items()],
        cases=[
            (case, gate_rows(case), ray_rows(case), data)
            for case, data in zip(result.cases, pictures, strict=True)
        ],
        tolerance=COUNT_TOLERANCE,
        fewest=FEWEST_ORACLES,
        script_data=script_data,
        scale={"floor": FLOOR, "decades": DECADES},
        css=templated("report.css"),
        scripts=[templated(name) for name in ("maps.js", "viewer.js", "report.js")],
    )


def environment() -> Any:
    """What makes pages of the templates: all text is escaped, and a name that is missing is a fault."""
    import jinja2

    loader = jinja2.FileSystemLoader(_TEMPLATES)
    made = jinja2.Environment(loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True,
                              undefined=jinja2.StrictUndefined)  # fmt: skip
    made.filters |= {"figure": figure, "gate": gate_text, "duration": duration}
    return made


def templated(name: str) -> str:
    """A style sheet or script that stands in the page."""
    return (_TEMPLATES / name).read_text(encoding="utf-8")


def headline(result: SuiteResult) -> str:
    """What came of it, in a sentence."""
    if result.subject:
        wrong = sum(not case.passed for case in result.cases)
        of = f"{wrong} of {len(result.cases)} pictures" if wrong else f"all {len(result.cases)} pictures"
        return f"{of} {'differ from' if wrong else 'agree with'} the reference: {result.subject}"
    if result.passed:
        return f"Proven{_how_much(result)}: independent programs compute the same pictures"
    parts = (
        (len(list(failures(result))), "comparison", "failed"),
        (sum(len(case.unproven) for case in result.cases), "comparison", "not made"),
        (len(result.thin), "feature", "too thinly covered"),
        (sum(mutant.survived for mutant in result.mutants), "mutant", "survived"),
        (sum(not count.passed for count in result.counts), "ray count", "off"),
        (sum(not check.passed for check in result.checks), "check", "failed"),
    )
    said = [f"{n} {noun}{'s' if n > 1 else ''} {verb}" for n, noun, verb in parts if n]
    return "Not proven: " + ", ".join(said)


def _how_much(result: SuiteResult) -> str:
    """Of how many cases of all, where some were left out."""
    cases = len(result.cases)
    return f" for {cases} of {result.known} cases" if cases < result.known else ""


@dataclass(frozen=True)
class Tile:
    """One figure of the summary. `state`: "good", "bad" or "none" (nothing was asked)."""

    label: str
    value: str
    text: str
    state: str
    anchor: str


def tiles(result: SuiteResult) -> Iterator[Tile]:
    """The summary: what is proven at a glance."""
    agree = sum(case.passed for case in result.cases)
    yield _tile("Pictures", agree, len(result.cases), "agree with every oracle that ran", "cases")
    gates = [gate for case in result.cases for _, found in case.results.values() for gate in found.gates]
    passed = sum(gate.passed for gate in gates)
    yield _tile("Gates", passed, len(gates), "passed: limits on figures", "closest")
    covered = len(result.coverage) - len(result.thin)
    text = f"features proven by at least {FEWEST_ORACLES} oracles that share no code"
    yield _tile("Features", covered, len(result.coverage), text, "coverage")
    caught = sum(not mutant.survived for mutant in result.mutants)
    yield _tile("Mutants", caught, len(result.mutants), "planted faults were caught", "mutants")
    near = sum(count.passed for count in result.counts)
    text = f"within {100 * COUNT_TOLERANCE:g} % of what is known"
    yield _tile("Ray counts", near, len(result.counts), text, "counts")
    right = sum(check.passed for check in result.checks)
    yield _tile("Same bits", right, len(result.checks), "as the float32 twin, over a million rays", "checks")
    left = sum(len(case.unproven) for case in result.cases)
    text = "comparisons could not be made" if left else "comparisons were left out"
    yield Tile("Not proven", str(left), text, "bad" if left else "good", "unproven")


def _tile(label: str, good: int, total: int, text: str, anchor: str) -> Tile:
    state = "none" if not total else "good" if good == total else "bad"
    if not total:
        return Tile(label, "not run", "in this run", state, anchor)
    return Tile(label, f"{good} of {total}", text, state, anchor)


@dataclass(frozen=True)
class Failure:
    """A comparison that failed."""

    case: int  # place in the suite
    name: str
    oracle: str
    worst: str
    gates: list[Gate]  # that failed


def failures(result: SuiteResult) -> Iterator[Failure]:
    """All comparisons that failed, and cases that no oracle checked."""
    for number, case in enumerate(result.cases):
        for oracle, (_, found) in case.results.items():
            if not found.passed:
                failed = [gate for gate in found.gates if not gate.passed]
                yield Failure(number, case.case.name, oracle, found.worst, failed)
        if not case.results:
            yield Failure(number, case.case.name, "no oracle ran", "", [])


def closest(result: SuiteResult) -> list[tuple[Gate, str, str]]:
    """Of every gate the figure nearest to its limit, or farthest beyond; its case and its oracle."""
    worst: dict[str, tuple[float, Gate, str, str]] = {}
    for case in result.cases:
        for oracle, (_, found) in case.results.items():
            for gate in found.gates:
                name = "kinds of rays" if gate.name.startswith("generation ") else gate.name
                entry = (_room(gate), gate, case.case.name, oracle)
                if name not in worst or entry[0] < worst[name][0]:
                    worst[name] = entry
    return [entry[1:] for entry in worst.values()]


def _room(gate: Gate) -> float:
    """How far a gate is from its limit, as a share of what there is; below 0 it failed."""
    if not math.isfinite(gate.value):
        return math.inf if gate.passed else -math.inf
    span = max(abs(1 - gate.limit) if gate.better == "high" and gate.limit < 1 else abs(gate.limit), 1e-12)
    return (gate.limit - gate.value if gate.better == "low" else gate.value - gate.limit) / span


def oracle_names(result: SuiteResult) -> list[str]:
    """All oracles that had a part, in the order in which they first occur."""
    names = [name for case in result.cases for name in (*case.results, *case.unproven)]
    covering = sorted(name for oracles in result.coverage.values() for name in oracles)
    return list(dict.fromkeys([*names, *covering]))


def gate_rows(case: CaseResult) -> list[tuple[str, str, list[Gate | None]]]:
    """Rows (gate, what it is, a Gate or None for each oracle) of the gates that are on whole pictures."""
    rows: dict[str, tuple[str, dict[str, Gate]]] = {}
    for oracle, (_, found) in case.results.items():
        for gate in found.gates:
            if not gate.name.startswith("generation "):
                rows.setdefault(gate.name, (gate.detail, {}))[1][oracle] = gate
    return [(name, text, [of.get(oracle) for oracle in case.results]) for name, (text, of) in rows.items()]


def ray_rows(case: CaseResult) -> list[tuple[str, list[dict[str, Any] | None]]]:
    """Rows (generation and kind, a dict of figures or None for each oracle)."""
    rows: dict[str, dict[str, dict[str, Any]]] = {}
    for oracle, (_, found) in case.results.items():
        passed = {gate.name: gate.passed for gate in found.gates}
        for key, value in found.metrics.items():
            ray, _, figure_name = key.partition(": ")
            if figure_name:
                label = key_label(ray)
                entry = rows.setdefault(label, {}).setdefault(oracle, {"passed": passed.get(label)})
                entry[figure_name] = value
    return [(label, [of.get(oracle) for oracle in case.results]) for label, of in rows.items()]


def figure(value: float) -> str:
    """A number as people read it: 0.99998, 1.2e-07, 45.1, 12."""
    if not math.isfinite(value):
        return "∞" if value > 0 else "not a number" if math.isnan(value) else "-∞"
    if value == int(value) and abs(value) < 1e6:
        return str(int(value))
    if 0.9 < value < 1:
        digits = min(9, max(5, 1 - math.floor(math.log10(1 - value))))  # that tell it from 1
        return f"{value:.{digits}f}".rstrip("0").rstrip(".")
    if 20 <= abs(value) < 1e6:
        return f"{value:.1f}"
    return f"{value:.2g}" if abs(value) < 1e-3 else f"{value:.4g}"


def gate_text(gate: Gate) -> str:
    """A gate's figure and limit: "0.99998 (at least 0.998)"."""
    return f"{figure(gate.value)} ({'at most' if gate.better == 'low' else 'at least'} {figure(gate.limit)})"


def duration(seconds: float) -> str:
    """Seconds as people read them: "4 min 7 s", "12 s", "0.25 s"."""
    if seconds < 10:
        return f"{seconds:.2f} s"
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds // 60:.0f} min {seconds % 60:.0f} s"


def script_data(data: Any) -> str:
    """JSON that may stand in a script element."""
    return json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
