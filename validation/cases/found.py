"""Scenes on which an oracle and the kernels once disagreed, or a fault went unnoticed; each says which."""

from __future__ import annotations

from collections.abc import Iterator

from .parts import Table


def scenes() -> Iterator[tuple[str, Table, set[str]]]:
    """Name, scene and what nobody can see from the scene's tables."""
    yield from ()
