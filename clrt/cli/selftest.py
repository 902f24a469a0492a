"""`clrt selftest`: does a device compute, bit for bit, what the reference in numpy does?"""

from __future__ import annotations

import argparse
import json
from functools import partial
from pathlib import Path
from typing import Any

from clrt.base.errors import ClrtError, legible
from clrt.base.resources import validation_module
from clrt.cli.outputs import check_apart, check_named
from clrt.cli.terminal import say


def run(options: argparse.Namespace) -> int:
    """Print a line for each check of `options.device`; return 1 when one of them failed."""
    from clrt.base.atomic import check_replaceable
    from clrt.device.platforms import choose

    selftest = validation_module("selftest")
    names = _names(selftest.names(options.quick), options.only)
    if options.junit:
        check_apart({"--junit": options.junit}, {})
        check_replaceable(options.junit)
    if options.bundle:
        check_named("--bundle", options.bundle, "bundles")
        validation_module("conformance.bundle").check_folder(Path(options.bundle))
    label = choose(options.device)[0].label
    shown = say if options.json else partial(print, flush=True)
    shown(f"on {label}:")
    least = "" if options.quick else "; --quick takes a third of that"
    say(f"{len(names)} checks, half a minute; kernels that were never used are compiled first{least}")
    width, results = max(map(len, names)), []
    blaming = bool(options.junit or options.bundle)
    for result in selftest.run_selftest(options.device, options.quick, blaming, names):
        verdict = "same" if result.passed else "DIFFERENT"
        shown(f"{verdict:9}  {result.name:{width}}  {result.detail} ({result.seconds:.1f} s)")
        results.append(result)
        if not result.passed and options.bundle:
            shown(f"{'':9}  {'':{width}}  {_bundle(options, result)}")
    if options.junit:
        device = validation_module("conformance.bundle").about(selftest.Device(options.device))
        validation_module("conformance.junit").write_junit(Path(options.junit), results, device)
    failed = sum(not result.passed for result in results)
    shown(f"{failed} of {len(names)} checks failed" if failed else f"all {len(names)} checks passed")
    if options.json:
        print(json.dumps(legible(_plain(label, results)), indent=2))
    return 1 if failed else 0


def _plain(device: str, results: list[Any]) -> dict[str, Any]:
    """The answer for a program."""
    told = ("name", "passed", "detail", "seconds")
    checks = [{name: getattr(one, name) for name in told} for one in results]
    return {"device": device, "passed": all(one.passed for one in results), "checks": checks}


def _names(known: list[str], wanted: list[str] | None) -> list[str]:
    """The checks to do. ClrtError for one that is not known."""
    for name in wanted or ():
        if name not in known:
            raise ClrtError(f"--only: {name!r} is not one of {', '.join(known)}")
    return [name for name in known if name in wanted] if wanted else known


def _bundle(options: argparse.Namespace, result: object) -> str:
    """Write what a check found; a line about it."""
    bundle = validation_module("conformance.bundle")
    device = validation_module("selftest").Device(options.device)
    name, detail, fault = (getattr(result, field) for field in ("name", "detail", "fault"))
    place = bundle.write_bundle(Path(options.bundle), name, detail, device, fault)
    if fault is None:
        return f"{place}: no kernel can be blamed"
    shown = "; run its reproduce.py" if fault.argument is not None else ""
    return f"{place}: kernel {fault.kernel}{shown}"
