"""Tables of JSON in which no key stands twice: of two, readers take one or the other."""

from __future__ import annotations

from typing import Any

from clrt.base.errors import show


def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """The table of these pairs, for `object_pairs_hook`; ValueError names the first key that stands twice."""
    table = dict(pairs)
    if len(table) < len(pairs):
        seen: set[str] = set()
        twice = next(key for key, _ in pairs if key in seen or seen.add(key))  # type: ignore[func-returns-value]
        raise ValueError(f"the key {show(twice)} stands twice in one table")
    return table
