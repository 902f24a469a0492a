"""Two reports compared: what became slower or faster by more than the scatter of its times explains.

Times scatter with a long tail, so medians are compared, on a logarithmic scale. A median of n times with the
robust standard deviation s = 1.4826 MAD has the standard error 1.2533 s / sqrt(n) (for a normal centre). A
change counts if it is more than SURE errors of both reports together, and more than FLOOR: two runs of the
same program lie that far apart, since memory falls into other places. How far these two do shows in all the
cases that nobody touched: SURE robust standard deviations of all changes count too, up to MOST.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, Final

from clrt.bench.report import Report, table
from clrt.bench.timing import Measurement

if TYPE_CHECKING:
    from rich.table import Table

SURE: Final = 4.0
FLOOR: Final = 0.05  # what two runs of the same program may differ by
MOST: Final = 0.085
WORTH: Final = 0.10  # a change that must not be missed
_ENOUGH: Final = 10  # cases that tell how far two runs lie apart
SAME, FASTER, SLOWER, UNCLEAR = "same", "faster", "slower", "unclear"
_COLORS: Final = {SAME: "", FASTER: "green", SLOWER: "red", UNCLEAR: "yellow"}


@dataclass(frozen=True)
class Verdict:
    """`ratio` is new time over old; `error` its standard error, as a share."""

    old: Measurement
    new: Measurement
    ratio: float
    error: float
    word: str


def judge(old: Measurement, new: Measurement, between: float = 0.0) -> Verdict:
    """Whether a case takes another time than it did. "unclear": a change of 10 % could not have been seen.

    `between` is the standard deviation of what two runs of the same program differ by, as a share.
    """
    change = math.log(new.ns / old.ns)
    error = math.hypot(_error(old.seconds), _error(new.seconds))
    least = max(SURE * error, FLOOR, min(SURE * between, MOST))
    if abs(change) > least:
        word = SLOWER if change > 0 else FASTER
    else:
        word = SAME if least < math.log(1 + WORTH) else UNCLEAR
    return Verdict(old, new, math.exp(change), error, word)


def compare(old: Report, new: Report) -> list[Verdict]:
    """A verdict for each case that both reports have."""
    before = {m.key: m for m in old.measurements}
    pairs = [(before[m.key], m) for m in new.measurements if m.key in before]
    changes = [math.log(b.ns / a.ns) for a, b in pairs]
    between = 1.4826 * _deviation(changes) if len(changes) >= _ENOUGH else 0.0
    return [judge(*pair, between) for pair in pairs]


def verdict_table(verdicts: Sequence[Verdict]) -> Table:
    """What changed or is unclear, and how many are the same."""
    words = [v.word for v in verdicts]
    title = ", ".join(f"{words.count(word)} {word}" for word in _COLORS)
    made = table(
        f"against the old report: {title}", ("what", "scene", "rays"), ("threads", "time", "error", "is")
    )
    for v in sorted(verdicts, key=lambda v: -v.ratio):
        if v.word != SAME:
            m, color = v.new, _COLORS[v.word]
            row = (
                f"{m.group}: {m.name}",
                m.scene,
                m.queue,
                str(m.threads),
                f"x {v.ratio:.3f}",
                f"{v.error:.1%}",
            )
            made.add_row(*row, f"[{color}]{v.word}[/]")
    return made


def _error(times: Sequence[float]) -> float:
    """The standard error of the median, as a share of it; infinite for fewer than three times."""
    if len(times) < 3:
        return math.inf
    return 1.2533 * 1.4826 * _deviation(times) / math.sqrt(len(times)) / median(times)


def _deviation(values: Sequence[float]) -> float:
    """Median distance from the median."""
    middle = median(values)
    return median(abs(value - middle) for value in values)
