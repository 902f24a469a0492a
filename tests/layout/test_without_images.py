"""Kernels for scenes without pictures on surfaces hold no code for these, and rays carry nothing more."""

from __future__ import annotations

import re

from clrt import layout
from clrt.device.source import kernel_source
from clrt.layout import RayFormat
from clrt.layout.declarations import c_declarations

PLAIN = RayFormat()
FIELDS = (*layout.UV_FIELDS, *layout.MIP_FIELDS)
DEFINED = re.compile(r"^(?:inline|INLINED) [\w ]+?\*?\b(\w+)\(|^ *#define (\w+)", re.MULTILINE)


def parted(source: str) -> tuple[str, str]:
    """The lines that are compiled where IMAGES and MIPS are 0, and those that are not."""
    kept: list[str] = []
    dropped: list[str] = []
    within: list[bool | None] = []  # whether each branch around a line is compiled; None: others' conditions
    for line in source.splitlines():
        word = line.split()[0] if line.split() else ""
        if word in ("#if", "#ifdef", "#ifndef"):
            asked = re.search(r"\b(IMAGES|MIPS)\b", line)
            assert asked is None or line in ("#if IMAGES", "#if MIPS"), line
            within.append(None if asked is None else False)
        elif word == "#else" and within[-1] is not None:
            within[-1] = not within[-1]
        elif word == "#endif":
            within.pop()
        else:
            (dropped if False in within else kept).append(line.partition("//")[0])
    assert not within
    return "\n".join(kept), "\n".join(dropped)


def names(text: str) -> set[str]:
    """Functions and macros that it defines."""
    return {function or macro for function, macro in DEFINED.findall(text)}


def test_no_line_that_is_compiled_without_pictures_is_about_them() -> None:
    declared, source = c_declarations(PLAIN), kernel_source(PLAIN)
    assert source.startswith(declared)
    kept, dropped = parted(source.removeprefix(declared))
    assert {"find_places", "levels_at", "show_pictures"} <= names(dropped) - names(kept)
    used = set(re.findall(r"\w+", kept)) - {"reflecting"}  # a flag's name, too
    assert not used & {*layout.IMAGES, *FIELDS, *layout.IMAGES.values()} - {"float", "int", "float4"}
    assert not used & (names(dropped) - names(kept))
    assert not re.search(r"\breflecting\(", kept)
    # what takes a colour that may be a picture takes the material's own there
    either = names(dropped) & names(kept)
    assert "SHOW_PICTURES" in either
    for name, body in re.findall(r"^#define (\w+)\([^)]*\)(.*)", kept, re.MULTILINE):
        if name in either:
            assert re.fullmatch(r"| in_band\(\(material\)->\w+, s, b\)", body), name


def test_kernels_take_no_parameter_and_rays_no_field_for_pictures_where_there_are_none() -> None:
    assert layout.world(False) == layout.WORLD and not layout.WORLD.keys() & layout.IMAGES.keys()
    (parameters,) = re.findall(r"^#define WORLD_PARAMETERS (.*)", c_declarations(PLAIN), re.MULTILINE)
    assert re.findall(r"(\w+)(?:,|$)", parameters) == list(layout.WORLD)
    assert PLAIN.values == PLAIN.bands and PLAIN.surface_fields == len(layout.SURFACE_FIELDS)
