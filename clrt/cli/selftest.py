"""`clrt selftest`: does a device compute, bit for bit, what the reference in numpy does?"""

from __future__ import annotations

import argparse

from clrt.resources import validation_module


def run(options: argparse.Namespace) -> int:
    """Print a line for each check of `options.device`; return 1 when one of them failed."""
    from clrt.platforms import choose

    print(f"on {choose(options.device)[0].label}:")
    results = validation_module("selftest").run_selftest(options.device)
    width = max(len(result.name) for result in results)
    for result in results:
        verdict = "same" if result.passed else "DIFFERENT"
        print(f"{verdict:9}  {result.name:{width}}  {result.detail} ({result.seconds:.1f} s)")
    failed = sum(not result.passed for result in results)
    print(f"{failed} of {len(results)} checks failed" if failed else f"all {len(results)} checks passed")
    return 1 if failed else 0
