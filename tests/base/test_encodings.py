"""Text files of clrt's own have an encoding that is said, whatever the surroundings' is."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

CLRT = Path(__file__).resolve().parents[2] / "clrt"
# a method -> the number of its arguments once an encoding is among them
_NEEDS = {"write_text": 2, "read_text": 1}


def unsaid(file: Path) -> Iterator[str]:
    """The calls that leave the encoding open: python -X warn_default_encoding warns of them when they run."""
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if not isinstance(node, ast.Call) or any(key.arg == "encoding" for key in node.keywords):
            continue
        if isinstance(node.func, ast.Attribute) and len(node.args) < _NEEDS.get(node.func.attr, 0):
            yield f"{file}:{node.lineno}: {node.func.attr}"
        if isinstance(node.func, ast.Name) and node.func.id == "open":
            mode = node.args[1] if len(node.args) > 1 else None
            if not (isinstance(mode, ast.Constant) and "b" in str(mode.value)):
                yield f"{file}:{node.lineno}: open"


def test_encodings_are_said() -> None:
    assert [call for file in sorted(CLRT.rglob("*.py")) for call in unsaid(file)] == []
