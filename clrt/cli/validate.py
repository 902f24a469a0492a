"""`clrt validate`: independent programs render the same scenes, and their pictures are compared with ours."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from clrt.base.atomic import check_replaceable
from clrt.base.errors import ClrtError, printable
from clrt.base.install import install_extra
from clrt.base.resources import validation_module
from clrt.cli.clusters import cluster
from clrt.cli.outputs import check_apart
from clrt.cli.terminal import console
from clrt.cli.validating import progress_bar, say_json, write
from clrt.device.settings import Settings

FAILED = 1  # exit code
MOST_RANDOM = 10_000  # scenes: the list of all is made before the first is rendered
_SHOWN = 40  # failures that are listed


def run(options: argparse.Namespace) -> int:
    """Run the suite and print what is proven; 0 where all is, else 1. ClrtError where it cannot be run."""
    if options.report and Path(options.report).suffix.lower() not in (".html", ".htm"):
        raise ClrtError(f"{options.report}: the report is a page; give a name that ends in .html")
    if options.report:
        check_replaceable(options.report)
    try:
        suite = validation_module("suite.run")
        if options.list:
            return _list(suite, options.json)
        if options.as_oracle and options.against is None:
            raise ClrtError("--as-oracle: say which program: --against 'myrt {scene.toml} {out.exr}'")
        if options.against is not None and options.cluster:
            raise ClrtError(
                "--cluster: not together with --against: the program under test runs on this machine"
            )
        if options.against is not None and not options.as_oracle:
            from clrt.cli import validate_against

            return validate_against.run(options)
        if options.report:
            validation_module("suite.files").check_beside(Path(options.report))
            _check_spares(Path(options.report), options.spd)
        plan, stamp = _plan(suite, options), _stamp()
        with cluster(options, Settings()) as (workers, _), progress_bar() as progress:
            result = suite.run(replace(plan, **workers), progress)
        result = replace(result, stamp=_also_after(stamp))
        if options.report:
            write(result, Path(options.report), options.json)
    except ModuleNotFoundError as error:
        needs = f"clrt validate needs the package {error.name}"
        raise ClrtError(f"{needs}; install what it needs with: {install_extra('validation')}") from None
    if options.json:
        say_json(result)
    else:
        _show(result)
    return 0 if result.passed else FAILED


def _stamp() -> dict[str, Any]:
    """Of the code that is run, now: of a checkout only, an installed copy has a version."""
    kept = validation_module("reliability.kept")
    validation_module("reliability.code").forget()
    return kept.stamp(kept.FILES["validation.json"]) if kept.checkout() else {}


def _also_after(before: dict[str, Any]) -> dict[str, Any]:
    """A run's stamp, of which the code as it was before; dirty where it is another one now."""
    if not before:
        return {}
    now = _stamp()
    return {**before, "dirty": before["dirty"] or now["dirty"] or now["code"] != before["code"]}


def _check_spares(report: Path, spd: str | None) -> None:
    """ClrtError where the report would take the place of a scene whose rays are counted."""
    names = validation_module("spd").PUBLISHED if spd else ()
    scenes = [Path(spd or "", f"{name}.nff") for name in names]
    outputs = {f"--report ({file.suffix})": file for file in map(report.with_suffix, (".xml", ".json"))}
    check_apart({"--report": report, **outputs}, {f"{scene}, which is read": scene for scene in scenes})


def _list(suite: Any, as_json: bool) -> int:
    if as_json:
        print(json.dumps([{"case": name, "shows": shows} for name, shows in suite.case_rows()], indent=2))
        return 0
    for name, shows in suite.case_rows():
        print(f"{name}\t{shows}")
    print("random SEED/NUMBER\ta scene drawn at random")
    return 0


def _plan(suite: Any, options: argparse.Namespace) -> Any:
    if options.random is not None and not 0 <= options.random <= MOST_RANDOM:
        what = f"it is a number of scenes, from 0 to {MOST_RANDOM}"
        raise ClrtError(f"--random: {options.random} is not allowed; {what}")
    everything = options.full and not options.case and not options.scenes
    program = None
    if options.as_oracle:
        program = validation_module("suite.program").parse(options.against, options.timeout)
    return suite.Plan(
        quick=not options.full,
        random=suite.FULL_RANDOM if options.random is None and everything else options.random or 0,
        seed=options.seed,
        spd=Path(options.spd) if options.spd else None,
        mutants=options.mutants or everything,
        cases=tuple(options.case or ()),
        scenes=tuple(options.scenes),
        device=options.device,
        pictures=bool(options.report),
        command=printable(shlex.join(["clrt", *sys.argv[1:]])),
        program=program,
        keep=True,
        fresh=options.fresh,
    )


def _show(result: Any) -> None:
    """The summary: a line for each oracle, then all that failed or was not proven."""
    from rich.markup import escape
    from rich.table import Table

    terminal = console(highlight=False, soft_wrap=not sys.stdout.isatty())
    table = Table(box=None, pad_edge=False, header_style="bold")
    for title in ("what", "proven", "of", ""):
        table.add_column(title, justify="right" if title in ("proven", "of") else "left", no_wrap=True)
    for name, good, total, note in _rows(result):
        table.add_row(escape(name), str(good), str(total),
                      "[green]ok[/]" if good == total else f"[red]{escape(note)}[/]")
    terminal.print(table)
    failures = list(_failures(result))
    for line in failures[:_SHOWN]:
        terminal.print(f"[red]failed[/] {escape(line)}")
    if len(failures) > _SHOWN:
        terminal.print(f"[red]and {len(failures) - _SHOWN} more[/]")
    for note in result.notes:
        loud = note.startswith("NOT PROVEN")
        terminal.print(f"[bold red]{escape(note)}[/]" if loud else f"[dim]note: {escape(note)}[/]")
    verdict = "[bold green]proven[/]" if result.passed else "[bold red]not proven[/]"
    some = f", {len(result.cases)} of {result.known} cases," if len(result.cases) < result.known else ""
    terminal.print(f"{verdict}{some} on {escape(result.device)} in {result.seconds:.0f} s")


def _rows(result: Any) -> Iterator[tuple[str, int, int, str]]:
    """Name, good ones, all, what to say of the others."""
    oracles: dict[str, list[bool]] = {}
    for case in result.cases:
        for oracle, (_, found) in case.results.items():
            oracles.setdefault(oracle, []).append(found.passed)
        for oracle in case.unproven:
            oracles.setdefault(oracle, []).append(False)
    for oracle, passed in oracles.items():
        yield f"pictures, {oracle}", sum(passed), len(passed), "fails"
    if result.coverage:
        covered = len(result.coverage) - len(result.thin)
        yield "features under two oracles that share no code", covered, len(result.coverage), "too thin"
    if result.counts:
        yield "ray counts", sum(count.passed for count in result.counts), len(result.counts), "off"
    if result.mutants:
        yield "mutants caught", sum(not m.survived for m in result.mutants), len(result.mutants), "survived"
    for check in result.checks:
        yield f"{check.name}: {check.detail}", int(check.passed), 1, "differs"


def _failures(result: Any) -> Iterator[str]:
    suite_files = validation_module("suite.files")
    for group, name, _, failure, _ in suite_files.outcomes(result):
        if failure:
            yield f"{name} ({group}): {failure}"
