"""What a long proof finds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

Tell = Callable[[float], None]
"""Told the share that is done, 0 to 1."""


@dataclass(frozen=True)
class Figure:
    """How many rays, inputs or frames were tried, how many went wrong, and what else is worth saying."""

    tried: int
    wrong: int
    detail: str
    seconds: float


def listed(found: list[str]) -> str:
    """The first faults, to follow a figure's detail."""
    return "".join(f"; {text}" for text in found[:5])
