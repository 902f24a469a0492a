"""Write into docs/validation.md what docs/mutants.json says of the faults that nobody chose.

    python -m validation.mutants.generated_run
    python docs/make_mutants.py
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from clrt.base.resources import validation_module

PAGE = Path(__file__).parent / "validation.md"
KEPT = PAGE.with_name("mutants.json")
BEGIN, END = "<!-- mutants: make_mutants.py writes what follows -->\n", "<!-- end of mutants -->\n"
outcomes = validation_module("mutants.outcomes")
Rows = Mapping[str, Mapping[str, Any]]


def lines(rows: Rows) -> Iterator[str]:
    """How many came out how, and each that is not live with the reason."""
    count = {kind: sum(row["outcome"] == kind for row in rows.values()) for kind in outcomes.OUTCOMES}
    missed = count[outcomes.SURVIVED] or "none"
    unbuilt = f", {count[outcomes.NOT_BUILT]} did not build" if count[outcomes.NOT_BUILT] else ""
    yield (f"Of {len(rows)} faults {count[outcomes.NOTICED]} were noticed, {count[outcomes.NO_PICTURE]} gave "
           f"no picture{unbuilt}, {count[outcomes.NOT_LIVE]} were not live, {missed} survived.")  # fmt: skip
    for why, meaning in outcomes.REASONS.items():
        found = {name: row for name, row in rows.items() if row.get("why") == why}
        if found:
            yield f"\n<details>\n<summary>{len(found)} not live: {meaning}</summary>\n"
            yield "| place | fault | measured |\n|---|---|---|"
            yield from (_row(name, row) for name, row in found.items())
            yield "\n</details>"


def _row(name: str, row: Mapping[str, Any]) -> str:
    place, _, fault = name.partition(": ")
    old, _, new = fault.partition(" becomes ")
    where = f", in {row['case']}" if "case" in row else ""
    cells = f"`{place}`", f"`{old}` becomes `{new}`", row["by"] + where
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def written(text: str, rows: Rows) -> str:
    """The page with these lines between the marks."""
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    return before + BEGIN + "\n" + "\n".join(lines(rows)) + "\n\n" + END + after


def main() -> None:
    rows = json.loads(KEPT.read_text("utf-8"))["faults"]
    PAGE.write_text(written(PAGE.read_text("utf-8"), rows), encoding="utf-8")


if __name__ == "__main__":
    main()
