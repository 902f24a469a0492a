"""`clrt validate --against CMD`: somebody else's renderer as the one under test."""

from __future__ import annotations

import argparse
import shlex
import sys
import time
from pathlib import Path
from typing import Any

from clrt.base.errors import ClrtError
from clrt.base.resources import validation_module
from clrt.cli.terminal import console
from clrt.cli.validating import progress_bar, say_json, write
from clrt.judging.verdict import certainty

PASSED, FAILED = 0, 1  # exit codes
_SHOWN = 40  # cases that are listed


def run(options: argparse.Namespace) -> int:
    """Print what is wrong with the program; 0 where all its pictures are right, else 1."""
    for flag, name in ((options.mutants, "--mutants"), (options.spd, "--spd"), (options.random, "--random")):
        if flag:
            raise ClrtError(f"{name} is of clrt's own validation; not together with --against")
    program = validation_module("suite.program").parse(options.against, options.timeout)
    against = validation_module("suite.against")
    if options.report:
        validation_module("suite.files").check_beside(Path(options.report))
    names = _names(against, options)
    start = time.perf_counter()
    with progress_bar() as progress:
        judged = against.run(names, program, options.device, bool(options.report), progress)
    asked = [j for j in judged if not j.left_out]
    if options.report or options.json:
        seconds, command = time.perf_counter() - start, shlex.join(["clrt", *sys.argv[1:]])
        result = against.suite_result(judged, program, command, seconds)
    if options.report:
        write(result, Path(options.report), options.json)
    if options.json:
        say_json(result)
    else:
        _show(against, judged, asked)
    return PASSED if asked and all(j.passed for j in asked) else FAILED


def _names(against: Any, options: argparse.Namespace) -> list[str]:
    cases = validation_module("cases")
    if options.scenes or options.case:
        chosen = [name for name in options.case or () if cases.case_named(name)]
        return [*chosen, *(cases.own_case(name) for name in options.scenes)]
    names: list[str] = against.usual_cases(options.full)
    return names


def _show(against: Any, judged: list[Any], asked: list[Any]) -> None:
    """A line for each case that fails, then what explains them together."""
    from rich.markup import escape

    out = console(highlight=False, soft_wrap=True)
    seen = [j for j in asked if j.result.results]
    wrong = [j for j in seen if not j.passed]
    for j in wrong[:_SHOWN]:
        out.print(f"[red]wrong[/] {escape(_line(j))}")
    if len(wrong) > _SHOWN:
        out.print(f"[red]and {len(wrong) - _SHOWN} more[/]")
    reasons = {("no picture", why): j for j in asked for why in j.result.unproven.values()}
    reasons |= {("left out", j.left_out): j for j in judged if j.left_out}
    for (what, why), last in reasons.items():
        same = [j for j in judged if why in (j.left_out, *j.result.unproven.values())]
        more = f" and {len(same) - 1} more" if len(same) > 1 else ""
        out.print(f"[red]{what}[/] {escape(last.result.case.name + more)}: {escape(why)}")
    common, features = against.common_causes(judged), against.suspects(judged)
    if wrong and (common or features):
        out.print("[bold]mend first:[/]")
    for name, text, count in common[:3]:
        out.print(f"  [bold]{escape(name)}[/]: {escape(text)} ({_of(count, wrong)})")
    for feature, count in features:
        out.print(f"  all pictures with [bold]{escape(feature)}[/] are wrong ({_of(count, wrong)})")
    for text in against.told(judged):
        out.print(f"note: {escape(text)}")
    right, none = len(seen) - len(wrong), len(asked) - len(seen)
    colour = "green" if asked and right == len(asked) else "red"
    rest = f"; {none} cases gave none" if none else ""
    out.print(f"[bold {colour}]{right} of {len(seen)} pictures are right{rest}[/]")


def _of(count: int, wrong: list[Any]) -> str:
    return f"{count} of the {len(wrong)} wrong"


def _line(judged: Any) -> str:
    """A case in a line: its name, what failed, why."""
    case = judged.result
    said = []
    for _, found in case.results.values():
        failed = [gate for gate in found.gates if not gate.passed]
        said.append(f"{found.worst}: " + ", ".join(f"{gate.name} {gate.value:.4g}" for gate in failed[:2]))
    said += [f"{certainty(cause)}: {cause.name}" for cause in case.causes[:1]]
    return f"{case.case.name}: {'; '.join(said)}"
