"""'Did you mean ...?': the known name that is nearest to a wrong one, found in bounded time."""

from __future__ import annotations

from collections.abc import Iterable
from heapq import nlargest
from itertools import pairwise
from typing import Final

from clrt.base.errors import show

_LETTERS: Final = 80  # of a name that are looked at: comparing two takes the square of it
_MOST: Final = 500  # names that are compared letter by letter


def nearest(name: object, known: Iterable[str], cutoff: float = 0.0) -> str | None:
    """The one of `known` that is most like `name`, whatever the case; None where none is, to `cutoff`.

    cutoff: 0 (any will do) to 1 (the same letters), as `difflib` measures it. The time is linear in the
    number of names: of many only those are compared that share the most pairs of letters with `name`.
    """
    wrong = (name if isinstance(name, str) else show(name))[:_LETTERS].lower()
    pairs = set(pairwise(wrong))

    def likeness(candidate: str) -> int:
        shared = pairs.intersection(pairwise(candidate[:_LETTERS].lower()))
        return 2 * len(shared) - abs(len(candidate) - len(wrong))

    names = list(known)
    if len(names) > _MOST:
        names = nlargest(_MOST, names, likeness)
    by_letters = {candidate[:_LETTERS].lower(): candidate for candidate in names}
    from difflib import get_close_matches  # only where somebody has erred

    near = get_close_matches(wrong, by_letters, n=1, cutoff=cutoff)
    return by_letters[near[0]] if near else None


def did_you_mean(name: object, known: Iterable[str], cutoff: float = 0.6) -> str:
    """'; did you mean ...?' with the nearest of `known`, or nothing where none is near."""
    near = nearest(name, known, cutoff)
    return "" if near is None else f"; did you mean {near!r}?"
