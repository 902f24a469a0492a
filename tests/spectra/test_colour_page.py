"""The figures of docs/colour.md are those that its script makes."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"


def test_the_table_is_what_is_measured() -> None:
    spec = importlib.util.spec_from_file_location("make_colour", DOCS / "make_colour.py")
    assert spec is not None and spec.loader is not None
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    rows = (DOCS / "colour.md").read_text("utf-8").split(made.MARKS[0])[1].split(made.MARKS[1])[0].split("\n")
    table = {row.split("|")[1].strip(): [float(x) for x in row.split("|")[2:-1]] for row in rows[3:-1]}
    assert list(table) == ["RGB mode", *map(str, made.COUNTS)]
    for n, name in ((0, "RGB mode"), (8, "8"), (24, "24"), (64, "64")):
        measured = [made.differences(lamp, n).max() for lamp in made.LAMPS]
        assert measured == pytest.approx(table[name], abs=0.006)
