"""What kernels take, read from their source: a wrong argument is an error before a launch."""

from __future__ import annotations

import re
from functools import cache
from typing import Any, Final

import numpy as np

from clrt import layout

# with \n in place of ^, which is looked for letter by letter, they take a tenth
_MACRO: Final = re.compile(r"\n#define (\w+_PARAMETERS) ((?:.*\\\n)*.*)")
_KERNEL: Final = re.compile(r"\n__kernel void (\w+)\(([^)]*)\)")
_NUMBERS: Final = {"float": np.float32, "int": np.int32, "uint": np.uint32}
_ELEMENTS: Final = {"float32": "float", "int32": "int", "uint32": "uint", "uint64": "ulong", "uint8": "uchar"}
Kind = Any  # of an argument: the type of a number, or the name of the type of a buffer's elements


@cache
def element(dtype: np.dtype) -> str | None:
    """The C type of an array's elements: of its numbers, or the record of `clrt.layout`; None if none."""
    if dtype.names is None:
        return _ELEMENTS.get(dtype.name)
    names = [name for name in dtype.names if not name.startswith("pad")]
    for record, fields in layout.RECORDS.items():
        if names == [field for field, _ in fields if not field.startswith("pad")]:
            return record
    return None


@cache
def signatures(source: str) -> dict[str, tuple[tuple[str, Kind], ...]]:
    """Of each kernel of a program, name and kind of its parameters, in order."""
    groups = {name: text.replace("\\\n", " ") for name, text in _MACRO.findall(source)}
    found = {}
    for name, text in _KERNEL.findall(source):
        while groups.keys() & set(re.findall(r"\w+", text)):
            text = re.sub(r"\w+_PARAMETERS", lambda match: groups[match.group()], text)
        found[name] = tuple(map(_parameter, text.split(",")))
    return found


@cache
def used(source: str, kernel: str) -> frozenset[int]:
    """The numbers of the parameters that a kernel reads or writes: groups have some that it leaves alone.

    Those that its text names; of groups handed on as structs, those that are fields asked for anywhere.
    """
    start = source.index(f"__kernel void {kernel}(")
    body = source[source.index("{", start) : source.index("\n}\n", start)]
    names = set(re.findall(r"\w+", body))
    if "FAMILY_OF_PARAMETERS" in names:
        names |= set(re.findall(r"\.(\w+)", source))
    return frozenset(number for number, (name, _) in enumerate(signatures(source)[kernel]) if name in names)


@cache  # groups are in many kernels
def _parameter(text: str) -> tuple[str, Kind]:
    *words, name = re.findall(r"\w+", text)
    kind = next(word for word in words if word not in ("__global", "const"))
    return name, kind if "*" in text else _NUMBERS[kind]


def kinds(arguments: tuple[Any, ...]) -> tuple[Kind, ...]:
    """The kind of each argument: of a buffer what it holds, of None (no buffer) and of a number its type."""
    return tuple([getattr(argument, "kind", argument.__class__) for argument in arguments])


def check(source: str, kernel: str, given: tuple[Kind, ...]) -> None:
    """TypeError where a kernel takes other arguments than these; None does for any buffer."""
    wanted = signatures(source)[kernel]
    if len(given) != len(wanted):
        raise TypeError(f"kernel {kernel} takes {len(wanted)} arguments, not {len(given)}")
    for number, ((name, kind), one) in enumerate(zip(wanted, given, strict=True)):
        if one != kind and not (one is type(None) and isinstance(kind, str)):
            raise TypeError(f"kernel {kernel}: argument {number}, {name}, is {_said(one)}, not {_said(kind)}")


def _said(kind: Kind) -> str:
    if isinstance(kind, type):
        return kind.__name__
    return f"a buffer of {kind}" if kind else "a buffer of no kind"
