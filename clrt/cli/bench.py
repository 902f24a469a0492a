"""`clrt bench`: time every pass, the builder and whole pictures; compare with an older run, with Embree."""

from __future__ import annotations

import argparse
import math
import re
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from clrt.base.atomic import check_replaceable
from clrt.base.errors import ClrtError
from clrt.base.resources import scene_file
from clrt.cli.outputs import check_apart
from clrt.cli.terminal import console, marked
from clrt.cli.tracing import tracing

if TYPE_CHECKING:
    from clrt.bench.timing import Tell
    from clrt.scene.scene import Scene

SLOWER = 1  # exit code


def run(options: argparse.Namespace) -> int:
    """Measure and print; 1 where --compare finds something slower. ClrtError, first, for bad options."""
    from clrt.bench import report, suite

    old = report.load(options.compare) if options.compare else None
    outputs = {"--json": options.json, "--chart": options.chart, "--trace": options.trace}
    _check_devices(options)
    scenes = {f"the scene {name}": scene_file(name) for name in options.scene or ()}
    check_apart(outputs, {"the report of --compare": options.compare, **scenes})
    for path in filter(None, outputs.values()):
        check_replaceable(path)
    plan = _plan(options)
    check_apart(outputs, {})
    if old:
        _check_same_machine(old, plan)
    with _reporting() as tell, tracing(options.trace) as save_trace:
        reports = [suite.run(replace(plan, device=device), tell) for device in options.device or [None]]
    save_trace()
    if len(reports) > 1:
        return _show_beside(reports, options.json)
    (measured,) = reports
    _show(measured)
    if options.json:
        measured.save(options.json)
    if options.chart:
        from clrt.bench.chart import roofline

        roofline(measured, options.chart)
    return _compare(old, measured) if old else 0


def _plan(options: argparse.Namespace) -> Any:
    from clrt.bench import suite

    groups = options.only or suite.GROUPS
    for name in groups:
        if name not in suite.GROUPS:
            raise ClrtError(f"--only: {name!r} is not one of {', '.join(suite.GROUPS)}")
    if options.rounds < 1:
        raise ClrtError(f"--rounds: {options.rounds} is not allowed; it must be at least 1")
    if options.chart:
        from clrt.bench.chart import check_chart

        check_chart(options.chart, groups)
    return suite.Plan(
        groups=groups,
        device=next(iter(options.device), None),
        rounds=options.rounds,
        quick=options.quick,
        embree=options.against is not None,
        isa="avx2" if options.against == "embree-avx2" else "",
        extra=_scenes(options.scene or (), dict(options.limit)),
    )


def _scenes(names: Sequence[str], limits: dict[str, int]) -> dict[str, Scene]:
    """What --scene names, by what tables call them; ClrtError where one cannot be timed."""
    from clrt.base.limits import Limits
    from clrt.formats.shipped import load_scene

    scenes: dict[str, Scene] = {}
    for name in names:
        scene, short = load_scene(name, Limits(**limits)), _name(name)
        if scene.camera is None:
            raise ClrtError(f"{name}: camera: missing; a picture needs a [camera]")
        if short in scenes:
            raise ClrtError(f"--scene: {name}: another one is called {short}, too; give them different names")
        scenes[short] = scene
    return scenes


def _name(scene: str) -> str:
    """What a scene is called in tables, which take brackets for markup."""
    return re.sub(r"[^\w.-]+", "_", Path(scene).stem)


def _show(measured: Any) -> None:
    from clrt.bench import report

    # a table that is cut is worthless: lines may be long where nobody sees the terminal's edge
    terminal = console(width=None if sys.stdout.isatty() else 160, highlight=False)
    facts = measured.machine
    terminal.print(f"{facts['processor']}, {facts['cores']} cores; {facts['device']}")
    terminal.print(
        f"load before: {facts['load_before']:.1f}" + ("; quick: small scenes" if facts["quick"] else "")
    )
    for table in report.tables(measured):
        terminal.print(table)


def _check_devices(options: argparse.Namespace) -> None:
    """ClrtError for what one report is needed for, where there will be several; and for a device twice."""
    if len(options.device) < 2:
        return
    for name in ("compare", "chart"):
        if getattr(options, name):
            raise ClrtError(f"--{name}: is for one --device; give it {len(options.device)} runs of their own")
    from clrt.device.platforms import choose

    labels = [choose(wanted)[0].label for wanted in options.device]
    for number, label in enumerate(labels):
        if label in labels[:number]:
            raise ClrtError(f"--device: {options.device[number]}: is {label}, which was named before")


def _show_beside(reports: Sequence[Any], file: str | None) -> int:
    """The times of several devices in one table."""
    from clrt.bench.beside import beside, save

    terminal = console(width=None if sys.stdout.isatty() else 200, highlight=False)
    for number, measured in enumerate(reports, 1):
        terminal.print(f"{number}: {marked(str(measured.machine['device']))}")
    for table in beside(reports):
        terminal.print(table)
    if file:
        save(reports, file)
    return 0


def _check_same_machine(old: Any, plan: Any) -> None:
    from clrt.bench.machine import facts
    from clrt.device.device import Device

    new = {**facts(Device(plan.device)), "quick": plan.quick}
    differ = [name for name in ("processor", "device", "quick") if old.machine.get(name) != new[name]]
    if differ:
        what = ", ".join(f"{name} {old.machine.get(name)!r}" for name in differ)
        raise ClrtError(
            f"--compare: the old report is of {what}; its times cannot be compared with those of here"
        )


def _compare(old: Any, new: Any) -> int:
    from clrt.bench import verdict

    verdicts = verdict.compare(old, new)
    if not verdicts:
        raise ClrtError("--compare: the old report has none of the cases measured now")
    console(width=None if sys.stdout.isatty() else 160, highlight=False).print(
        verdict.verdict_table(verdicts)
    )
    return SLOWER if any(v.word == verdict.SLOWER for v in verdicts) else 0


class _Lines:
    """What is being done, a line at first and then each time that EVERY seconds have passed."""

    EVERY = 5.0

    def __init__(self) -> None:
        self.next = -math.inf

    def tell(self, text: str) -> None:
        now = time.monotonic()
        if now >= self.next:
            print(f"clrt: bench: {text}", file=sys.stderr, flush=True)
            self.next = now + self.EVERY


@contextmanager
def _reporting() -> Iterator[Tell | None]:
    """A function that shows one changing line on stderr, or now and then a line where that is none."""
    if not sys.stderr.isatty():
        yield _Lines().tell
        return
    with console(stderr=True).status("") as status:
        yield lambda text: status.update(marked(text))
