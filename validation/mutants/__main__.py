"""`python -m validation.mutants [NAME ...]`: plant these faults, or all, and say who noticed each."""

from __future__ import annotations

import sys

from clrt.base.resources import validation_module


def main(names: list[str]) -> int:
    """A line a fault; 1 where one was not noticed, 2 where there is none of a name."""
    run = validation_module("mutants.run")
    unknown = [name for name in names if name not in run.MUTANTS]
    if unknown:
        print(f"no such fault: {', '.join(unknown)}", file=sys.stderr)
        return 2
    survived = 0
    for name in names or run.MUTANTS:
        found = run.run_mutant(name)
        survived += found.survived
        by = "SURVIVED" if found.survived else f"noticed by {', '.join(found.caught_by)}"
        print(f"{name} ({found.file}): {by}: {found.description}", flush=True)
    return int(survived > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
