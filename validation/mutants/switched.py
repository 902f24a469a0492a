"""Many faults in one build of the kernels: a number in memory says which of them is there (0: none).

Building takes a hundred times as long as a small picture, so each place holds both texts, looks at a page of
memory at ADDRESS for which one counts, and leaves a mark there. That needs a driver that runs kernels in its
own process, as CPU drivers do. With no fault chosen the pictures have the bits of the kernels as they are.
"""

from __future__ import annotations

import ctypes
import mmap
import re
from collections.abc import Iterable
from typing import Final

from clrt.base.errors import DeviceError

from .generated import Place

ADDRESS: Final = 1 << 44
_FIXED: Final = 0x100000  # MAP_FIXED_NOREPLACE
_PLACES: Final = 4000  # of faults on the page, behind the number
# notes that the place is reached, and says whether its fault is there
_ON: Final = (
    f"(*(volatile __global uchar *)({ADDRESS + 16}ul + {{0}}) = 1, "
    f"*(volatile __global const int *){ADDRESS}ul == {{0}})"
)
# how tightly C's binary operators bind; their operands end where another binds as loosely
_BINDS: Final = {
    "*": 10, "/": 10, "%": 10, "+": 9, "-": 9, "<<": 8, ">>": 8, "<": 7, ">": 7, "<=": 7, ">=": 7, "==": 6,
    "!=": 6, "&": 5, "^": 4, "|": 3, "&&": 2, "||": 1, "?": 0, ":": 0, "=": -1, "+=": -1, "-=": -1, "*=": -1,
    "/=": -1, "&=": -1, "|=": -1, "^=": -1,
}  # fmt: skip
_TOKEN: Final = re.compile(
    r"(?P<skip>//[^\n]*|/\*.*?\*/)|(?P<open>[(\[])|(?P<close>[)\]])|(?P<end>[;,{}]|\breturn\b)"
    r"|(?P<operator>(?<=\s)(?:<<|>>|[-+*/<>=!&|^]=|&&|\|\||[-+*/%<>&|^?:=])(?=\s))",
    re.DOTALL,
)

Edit = tuple[int, int, Place, int]  # from, to, the fault, its number


class Switch:
    """The page that kernels look at. One a process."""

    def __init__(self) -> None:
        libc = ctypes.CDLL(None, use_errno=True)
        libc.mmap.restype, libc.mmap.argtypes = ctypes.c_void_p, [
            ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int, ctypes.c_int, ctypes.c_int, ctypes.c_long,
        ]  # fmt: skip
        private = mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | _FIXED
        at = libc.mmap(ADDRESS, mmap.PAGESIZE, mmap.PROT_READ | mmap.PROT_WRITE, private, -1, 0)
        if at != ADDRESS:
            raise DeviceError("there is no page for the number of a fault; faults can be planted one by one")
        self._number = ctypes.c_int.from_address(ADDRESS)
        self._marks = (ctypes.c_ubyte * _PLACES).from_address(ADDRESS + 16)

    def choose(self, number: int) -> None:
        """The fault that kernels launched from now on have; 0: none."""
        self._number.value = number
        ctypes.memset(self._marks, 0, _PLACES)

    def reached(self) -> frozenset[int]:
        """The faults whose places were looked at since then."""
        return frozenset(number for number, mark in enumerate(self._marks) if mark)


def with_all(text: str, faults: Iterable[tuple[int, Place]]) -> tuple[str, set[int]]:
    """A file's text in which each of these faults (number, place) can be chosen, and the numbers of those
    that found no place in it: they would cut into another one."""
    edits = [(*_extent(text, place), place, number) for number, place in faults]
    taken: list[Edit] = []
    left = set()
    for edit in sorted(edits, key=lambda edit: edit[0] - edit[1]):
        crossing = any(edit[0] < other[0] < edit[1] < other[1] or other[0] < edit[0] < other[1] < edit[1]
                       or edit[:2] == other[:2] for other in taken)  # fmt: skip
        if crossing or edit[0] < 0:
            left.add(edit[3])
        else:
            taken.append(edit)
    return _written(text, 0, len(text), taken), left


def _written(text: str, start: int, end: int, edits: list[Edit]) -> str:
    """The text from `start` to `end` with the edits in it, outer ones first."""
    inner = [edit for edit in edits if start <= edit[0] and edit[1] <= end]
    out, at = "", start
    for edit in sorted(inner, key=lambda edit: (edit[0], -edit[1])):
        if edit[0] >= at:
            rest = [other for other in inner if other is not edit]
            out += text[at : edit[0]] + _switched(text, edit, rest)
            at = edit[1]
    return out + text[at:end]


def _switched(text: str, edit: Edit, inner: list[Edit]) -> str:
    start, end, place, number = edit
    on = _ON.format(number)
    if place.old.startswith("["):
        return f"[({_written(text, start + 1, end - 1, inner)}) + {on}]"
    if place.new.startswith("(!"):
        return f"(!{_written(text, start, end, inner)} == {on})"
    if place.old in ("min", "max"):
        arguments = _written(text, place.end, end, inner)
        return f"({on} ? {place.new}{_in_a_line(arguments)} : {place.old}{arguments})"
    if place.old not in _BINDS:
        return f"({on} ? {place.new} : {place.old})"
    left, right = _written(text, start, place.start, inner), _written(text, place.end, end, inner)
    if place.old.endswith("=") and place.old not in ("==", "!=", "<=", ">="):
        operator, other = place.old[0], place.new[0]
        return f"{left}= {on} ? {_in_a_line(f'{left}{other} ({right})')} : {left}{operator} ({right})"
    return f"({on} ? {_in_a_line(left + place.new + right)} : {left}{place.old}{right})"


def _in_a_line(text: str) -> str:
    """A copy that moves no line below it: the compiler names lines."""
    return re.sub(r"//[^\n]*", "", text).replace("\n", " ")


def _extent(text: str, place: Place) -> tuple[int, int]:
    """What has to be written twice: the operator with its operands, the call, or the place itself."""
    if place.old in ("min", "max"):
        return place.start, _closing(text, place.end)
    if place.old not in _BINDS:
        return place.start, place.end
    binds = _BINDS[place.old]
    start, end = _left(text, place.start, binds), _right(text, place.end, binds)
    start += len(text[start:place.start]) - len(text[start:place.start].lstrip())
    end -= len(text[place.end:end]) - len(text[place.end:end].rstrip())
    whole = start < place.start and end > place.end and "\n#" not in text[start:end]
    return (start, end) if whole else (-1, -1)


def _right(text: str, at: int, binds: int) -> int:
    """Where the operand ends that begins at `at`."""
    depth = 0
    for found in _TOKEN.finditer(text, at):
        if found.lastgroup == "open":
            depth += 1
        elif found.lastgroup == "close":
            if depth == 0:
                return found.start()
            depth -= 1
        elif depth == 0 and _ends(found, binds + 1):
            return found.start()
    return len(text)


def _left(text: str, at: int, binds: int) -> int:
    """Where the operand begins that ends at `at`."""
    begin = max(text.rfind("\n}", 0, at), text.rfind("\n{", 0, at), 0)  # of the function
    depth = 0
    for found in reversed(list(_TOKEN.finditer(text, begin, at))):
        if found.lastgroup == "close":
            depth += 1
        elif found.lastgroup == "open":
            if depth == 0:
                return found.end()
            depth -= 1
        elif depth == 0 and _ends(found, binds):
            return found.end()
    return begin


def _ends(found: re.Match[str], binds: int) -> bool:
    """Whether an operand ends there: at something else, or at an operator that binds less than that."""
    if found.lastgroup == "operator":
        return _BINDS.get(found.group(), -1) < binds
    return found.lastgroup == "end"


def _closing(text: str, at: int) -> int:
    depth = 0
    for found in _TOKEN.finditer(text, at):
        depth += {"open": 1, "close": -1}.get(found.lastgroup or "", 0)
        if depth == 0 and found.lastgroup == "close":
            return found.end()
    return len(text)
