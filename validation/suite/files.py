"""A run of the suite for other programs: JUnit XML for build servers, JSON for whatever else."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final
from xml.etree import ElementTree

from clrt.base import inputs
from clrt.base.atomic import check_replaceable, write_json, write_text
from clrt.base.errors import ClrtError, legible
from clrt.base.files import read_bytes
from clrt.base.limits import Limits

from ..types import Gate, SuiteResult

_NAME: Final = "clrt validate"  # of what the JUnit file says it is
_HEAD: Final = re.compile(rb"<\?xml [^>]*\?>\s*<testsuites name=\"clrt validate\"")
_KEYS: Final = {"passed", "command", "versions", "cases", "coverage"}  # some of the JSON file's


def write_beside(result: SuiteResult, report: Path) -> tuple[Path, Path]:
    """Write JUnit XML and JSON beside `report`, each whole or not at all. ClrtError where that fails."""
    xml, data = _beside(report)
    write_text(xml, junit(result))
    write_json(data, plain(result), finite=True)
    return xml, data


def check_beside(report: Path) -> None:
    """ClrtError where `write_beside` could not write, or would replace a file that is not an older run's."""
    for path, is_ours in zip(_beside(report), (_is_junit, _is_run), strict=True):
        check_replaceable(path)
        if not path.exists():
            continue
        with inputs.watched(False):  # it may be replaced
            old = read_bytes(path, Limits())
        if not is_ours(old):
            what = "stands where the run's own file would, and is not an older run's"
            raise ClrtError(f"{path}: {what}; give the report another name, or move this file")


def _beside(report: Path) -> tuple[Path, Path]:
    return report.with_suffix(".xml"), report.with_suffix(".json")


def _is_junit(text: bytes) -> bool:
    return _HEAD.match(text) is not None


def _is_run(text: bytes) -> bool:
    try:
        table = json.loads(text)
        return isinstance(table, dict) and table.keys() >= _KEYS
    except (ValueError, RecursionError):
        return False


def junit(result: SuiteResult) -> str:
    """A test case for each comparison, mutant, ray count, check and feature."""
    root = ElementTree.Element("testsuites", name=_NAME)
    groups: dict[str, list[tuple[str, float, str, str]]] = {}
    for group, name, seconds, failure, skipped in map(legible, outcomes(result)):
        groups.setdefault(group, []).append((name, seconds, failure, skipped))
    for group, tests in groups.items():
        suite = ElementTree.SubElement(root, "testsuite", name=group, tests=str(len(tests)))
        suite.set("failures", str(sum(bool(failure) for _, _, failure, _ in tests)))
        suite.set("skipped", str(sum(bool(skipped) for *_, skipped in tests)))
        suite.set("time", f"{sum(seconds for _, seconds, _, _ in tests):.3f}")
        for name, seconds, failure, skipped in tests:
            test = ElementTree.SubElement(suite, "testcase", classname=group, name=name,
                                          time=f"{seconds:.3f}")
            if failure:
                ElementTree.SubElement(test, "failure", message=failure)
            elif skipped:
                ElementTree.SubElement(test, "skipped", message=skipped)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def outcomes(result: SuiteResult) -> Iterator[tuple[str, str, float, str, str]]:
    """Group, name, seconds, why it failed ("" if not), why it was not proven ("" if it was)."""
    for case in result.cases:
        for oracle, (picture, found) in case.results.items():
            failed = ", ".join(_said(gate) for gate in found.gates if not gate.passed)
            why = "".join(f"; {cause.name}: {cause.text}" for cause in case.causes[:1])
            said = f"{found.worst}: {failed}{why}" if failed else ""
            yield oracle, case.case.name, picture.seconds, said, ""
        for oracle, why in case.unproven.items():
            if result.subject:  # it is the program under test that gave no picture
                yield oracle, case.case.name, case.seconds, why, ""
            else:
                yield oracle, case.case.name, 0.0, "", f"not proven: {why}"
    for mutant in result.mutants:
        yield "mutants", mutant.name, 0.0, mutant.description if mutant.survived else "", ""
    for count in result.counts:
        said = f"{count.ours} rays, {count.published} expected"
        yield "ray counts", f"{count.scene}: {count.kind}", 0.0, "" if count.passed else said, ""
    for check in result.checks:
        yield "checks", check.name, check.seconds, "" if check.passed else check.detail, ""
    for feature, oracles in result.coverage.items():
        lacking = f"only under {', '.join(sorted(oracles)) or 'no oracle'}" if feature in result.thin else ""
        yield "coverage", feature, 0.0, lacking, ""


def plain(result: SuiteResult) -> dict[str, Any]:
    """The run as JSON has it; figures that are not finite become null."""
    return {
        "passed": result.passed, "subject": result.subject, "command": result.command,
        "started": result.started, "stamp": result.stamp,
        "seconds": result.seconds,
        "device": result.device, "versions": result.versions, "seed": result.seed,
        "notes": list(result.notes), "kept": list(result.kept),
        "cases": [
            {
                "name": case.case.name, "passed": case.passed, "size": [case.case.width, case.case.height],
                "samples": case.case.spp, "features": sorted(case.case.features), "seconds": case.seconds,
                "unproven": case.unproven,
                "causes": [{"name": cause.name, "text": cause.text, "error_left": cause.left,
                            "proven": cause.proven} for cause in case.causes],
                "oracles": {
                    oracle: {
                        "passed": found.passed, "worst": found.worst, "seconds": picture.seconds,
                        "metrics": {name: _finite(value) for name, value in found.metrics.items()},
                        "gates": [_gate(gate) for gate in found.gates],
                    }
                    for oracle, (picture, found) in case.results.items()
                },
            }
            for case in result.cases
        ],
        "mutants": [{"name": m.name, "file": m.file, "survived": m.survived, "caught_by": list(m.caught_by),
                     "where": m.where, "how": m.description} for m in result.mutants],
        "counts": [{"scene": c.scene, "kind": c.kind, "ours": c.ours, "expected": c.published,
                    "passed": c.passed} for c in result.counts],
        "checks": [{"name": c.name, "passed": c.passed, "detail": c.detail} for c in result.checks],
        "coverage": {feature: sorted(oracles) for feature, oracles in result.coverage.items()},
        "thin": result.thin,
    }  # fmt: skip


def _gate(gate: Gate) -> dict[str, Any]:
    return {"name": gate.name, "value": _finite(gate.value), "limit": gate.limit, "better": gate.better,
            "passed": gate.passed}  # fmt: skip


def _said(gate: Gate) -> str:
    if gate.name == "tripwire":
        return gate.detail
    side = "at most" if gate.better == "low" else "at least"
    return f"{gate.name} {gate.value:.6g} ({side} {gate.limit:g})"


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
