"""All kernels are one program: a macro of two files would change the code of whichever comes later."""

from __future__ import annotations

import re
from collections import defaultdict
from pathlib import Path

KERNELS = Path(__file__).resolve().parents[2] / "kernels"


def defined_twice(files: dict[str, str]) -> dict[str, set[str]]:
    """Macros that more than one file leaves defined, and these files."""
    found: dict[str, set[str]] = defaultdict(set)
    for file, text in files.items():
        for directive, name in re.findall(r"^[ \t]*#[ \t]*(define|undef)[ \t]+(\w+)", text, re.M):
            (found[name].add if directive == "define" else found[name].discard)(file)
    return {name: where for name, where in found.items() if len(where) > 1}


def test_a_macro_is_of_one_file() -> None:
    """One called PARTS made arrays of no places in files that meant another one by it."""
    files = {file.name: file.read_text(encoding="utf-8") for file in KERNELS.glob("*.cl*")}
    assert len(files) > 40 and defined_twice(files) == {}
    files["film.cl"] += "#define PARTS 0\n"
    assert defined_twice(files) == {"PARTS": {"film.cl", "intersect.clh"}}
    files["film.cl"] += "#undef PARTS\n"
    assert defined_twice(files) == {}
