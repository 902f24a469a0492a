"""docs/scene-files.md names every key that a scene file may have, with its default, and no other."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from clrt.base.resources import PACKAGE

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "scene-files.md").read_text()
SCHEMA: dict[str, Any] = json.loads((PACKAGE / "scene" / "scene.schema.json").read_text())
KINDS = SCHEMA.get("$defs", SCHEMA)
KEYS = PAGE[PAGE.index("## All keys") : PAGE.index("## Samples")]
PARTS = re.split(r"\n\*\*", KEYS)[1:]  # the scene, camera, materials, lights, shapes


def named(text: str) -> set[str]:
    """The keys in backticks."""
    return set(re.findall(r"`([a-z_]\w*|K)`", text))


def rows(part: str) -> list[list[str]]:
    return [re.split(r"(?<!\\)\|", line)[1:-1] for line in part.splitlines() if line.startswith("| `")]


def keys(kind: dict[str, Any]) -> set[str]:
    return set(kind["properties"]) - {"$schema"}


@pytest.mark.parametrize(("number", "kind"), [(0, SCHEMA), (1, KINDS["Camera"]), (2, KINDS["Material"])])
def test_a_table_has_all_keys_and_their_defaults(number: int, kind: dict[str, Any]) -> None:
    table = rows(PARTS[number])
    known = set().union(*(named(cells[0]) for cells in table))
    orthographic = {"size"} if number == 1 else set()
    assert known | orthographic == keys(kind), known ^ keys(kind)
    for names, default, _ in table:
        several = re.findall(r"`(\w+)`", names)
        said = re.split(r", (?![^\[]*\])", default.strip())
        if len(said) != len(several):
            continue  # a sentence for all, or nothing
        for name, text in zip(several, said, strict=True):
            value = kind["properties"][name].get("default")
            if value is None:
                continue  # in words
            shown = {str(value).lower(), json.dumps(value), "none" if value in ({}, []) else str(value)}
            shown |= {f"{value:g}"} if isinstance(value, float) else set()
            shown |= {f"[{value[0]:g}, {value[1]:g}]"} if isinstance(value, list) and value else set()
            assert text in shown, (name, text, value)


@pytest.mark.parametrize(("number", "ending"), [(3, "Light"), (4, "")])
def test_every_light_and_shape_is_there_with_its_keys(number: int, ending: str) -> None:
    table = {cells[0].strip(" `"): cells[1] for cells in rows(PARTS[number])}
    del table["type"]  # the head
    all_have = {"type", "material", "name", "transform"}
    lights = {name.removesuffix("Light").lower() for name in KINDS if name.endswith("Light")}
    shapes = {name.lower() for name, kind in KINDS.items() if "material" in kind.get("properties", {})}
    assert set(table) == (lights if ending else shapes)
    for name, cell in table.items():
        said = named(cell)
        if "the same" in cell:
            said |= named(table["rectangle"]) - {"u", "v"}
        assert said == keys(KINDS[name.capitalize() + ending]) - all_have, name
