"""`clrt selftest`: does a device compute, bit for bit, what the reference in numpy does?"""

from __future__ import annotations

import argparse

from clrt.base.resources import validation_module
from clrt.cli.terminal import say


def run(options: argparse.Namespace) -> int:
    """Print a line for each check of `options.device`; return 1 when one of them failed."""
    from clrt.device.platforms import choose

    selftest = validation_module("selftest")
    print(f"on {choose(options.device)[0].label}:", flush=True)
    names = selftest.names(options.quick)
    least = "" if options.quick else "; --quick takes a third of that"
    say(f"{len(names)} checks, half a minute; kernels that were never used are compiled first{least}")
    width, failed = max(map(len, names)), 0
    for result in selftest.run_selftest(options.device, options.quick):
        verdict = "same" if result.passed else "DIFFERENT"
        print(f"{verdict:9}  {result.name:{width}}  {result.detail} ({result.seconds:.1f} s)", flush=True)
        failed += not result.passed
    print(f"{failed} of {len(names)} checks failed" if failed else f"all {len(names)} checks passed")
    return 1 if failed else 0
