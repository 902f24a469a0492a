"""Faults that nobody chose: drawn by a seed from all places where the code computes.

An operator becomes its opposite, a comparison turns round, a condition is negated, a constant is off by 1 %,
an index by one: in kernels, and in the host's code that kernels are given things by. Which of the places are
taken the seed and each place's own text decide, so that a change elsewhere leaves the draw as it was.
"""

from __future__ import annotations

import ast
import hashlib
import io
import re
import tokenize
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from clrt.base.resources import PACKAGE, kernel_folder

SEED: Final = 1
# scene/lights.py computes next to nothing: its places are unions of types
HOST: Final = ("flatten", "spectra", "engine/film.py", "engine/job.py", "engine/wavefront.py",
               "engine/schedule.py", "engine/adaptive.py", "engine/coverage.py", "scene/transforms.py",
               "scene/materials.py", "scene/camera.py", "scene/arealights.py", "scene/adaptive.py")
# what no picture is made with: queries by rays, a warning, a chart, the check of other media
_ELSEWHERE: Final = ("query.cl", "crossings.cl", "crossings.clh", "asked.clh", "overlaps.py", "facets.py",
                     "plot.py", "hidden.py")  # fmt: skip
_TURNED: Final = {
    "+": "-", "-": "+", "*": "/", "/": "*", "<": ">=", ">": "<=", "<=": ">", ">=": "<", "==": "!=",
    "!=": "==", "&&": "||", "||": "&&", "+=": "-=", "-=": "+=", "*=": "/=", "and": "or", "or": "and",
    "min": "max", "max": "min", "&": "|", "|": "&",
}  # fmt: skip
_C_TOKEN: Final = re.compile(
    r"(?P<skip>//[^\n]*|/\*.*?\*/|^[ \t]*#(?:\\\n|[^\n])*|\"[^\"\n]*\")"
    r"|(?P<number>(?<![\w.])(?:\d+\.\d*|\.\d+|\d+(?=[eE]))(?:[eE][-+]?\d+)?f?(?![\w.]))"
    r"|(?P<index>\[[^\[\]\n]+\])|(?P<word>\b(?:min|max|if)\b)"
    r"|(?P<operator>(?<=\s)(?:\+=|-=|\*=|<=|>=|==|!=|&&|\|\||[-+*/<>&|])(?=\s))",
    re.MULTILINE | re.DOTALL,
)
# what stands before the size of an array that is declared
_DECLARED: Final = re.compile(r"\s*(?!return\b)(?:\w+ )+(?:\w+(?:\[[^\]]*\])*, )*\w+(?:\[[^\]]*\])*")


@dataclass(frozen=True)
class Place:
    """A fault: the text of `file` from `start` to `end` becomes `new`."""

    file: str  # "kernels/..." or "clrt/..."
    line: int
    column: int
    start: int
    end: int
    old: str
    new: str
    around: str  # the line, and where in it

    def edit(self, text: str) -> str:
        """The file's text with the fault."""
        return text[: self.start] + self.new + text[self.end :]

    @property
    def name(self) -> str:
        return f"{self.file}:{self.line}:{self.column}: {self.old} becomes {self.new}"


def drawn(count: int, seed: int = SEED) -> list[Place]:
    """So many faults of all that there are, those of kernels and of the host in the share that they have."""
    chosen = sorted(places(), key=lambda place: _rank(place, seed))[:count]
    return sorted(chosen, key=lambda place: (place.file, place.start))


def places() -> Iterator[Place]:
    """Every fault that could be planted, file by file."""
    for root, folder in ((kernel_folder(), "kernels"), (PACKAGE, "clrt")):
        for path in _files(root, folder):
            name, text = f"{folder}/{path.relative_to(root).as_posix()}", path.read_text("utf-8")
            for start, end, new in _in_c(text) if folder == "kernels" else _in_python(text):
                at = text.rfind("\n", 0, start) + 1
                line = f"{text[at : text.find(chr(10), start)].strip()} {start - at}"
                number = text.count("\n", 0, start) + 1
                yield Place(name, number, start - at + 1, start, end, text[start:end], new, line)


def _files(root: Path, folder: str) -> list[Path]:
    found: list[Path] = []
    for name in ("*.cl*",) if folder == "kernels" else HOST:
        found += root.glob(name if "." in name else f"{name}/*.py")
    return sorted(path for path in found if path.name not in _ELSEWHERE)


def _in_c(text: str) -> Iterator[tuple[int, int, str]]:
    for found in _C_TOKEN.finditer(text):
        kind, old = found.lastgroup, found.group()
        if kind == "number" and float(old.rstrip("f")):
            yield found.start(), found.end(), f"(1.01f * {old})"
        elif kind == "index" and not _declared(text, found.start()):
            yield found.start(), found.end(), f"[{old[1:-1]} + 1]"
        elif kind == "operator" or (kind == "word" and old != "if"):
            if old not in "&*" or text[found.start() - 2] not in "(,=":  # else it may be of a pointer
                yield found.start(), found.end(), _TURNED[old]
        elif kind == "word" and (condition := _in_brackets(text, found.end())):
            start, end = condition
            yield start, end, f"(!{text[start:end]})"


def _declared(text: str, at: int) -> bool:
    """Whether what stands in the brackets there is the size of an array."""
    before = text[text.rfind("\n", 0, at) + 1 : at]
    return _DECLARED.fullmatch(before) is not None or re.search(r"\(\*\w+\)$", before) is not None


def _in_brackets(text: str, at: int) -> tuple[int, int] | None:
    """Where the bracket that follows begins and ends; None where none does."""
    start = text.find("(", at, at + 3)
    depth = 0
    for k in range(start, min(len(text), start + 300)) if start >= 0 else ():
        depth += {"(": 1, ")": -1}.get(text[k], 0)
        if depth == 0:
            return start, k + 1
    return None


def _in_python(text: str) -> Iterator[tuple[int, int, str]]:
    yield from sorted({*_operators(text), *_conditions_and_indices(text)})  # of functions within others once


def _conditions_and_indices(text: str) -> Iterator[tuple[int, int, str]]:
    lines = [line.encode() for line in text.splitlines(keepends=True)]

    def part(node: ast.expr) -> tuple[int, int, str]:
        ends = (node.lineno, node.col_offset), (node.end_lineno or 0, node.end_col_offset or 0)
        start, end = (len(b"".join([*lines[: n - 1], lines[n - 1][:at]]).decode()) for n, at in ends)
        return start, end, text[start:end]

    for function in ast.walk(ast.parse(text)):
        for node in function.body if isinstance(function, (ast.FunctionDef, ast.AsyncFunctionDef)) else ():
            for inner in ast.walk(node):
                if isinstance(inner, (ast.If, ast.While, ast.IfExp)):
                    start, end, old = part(inner.test)
                    yield start, end, f"(not ({old}))"
                elif isinstance(inner, ast.Subscript) and isinstance(inner.ctx, ast.Load):
                    for start, end, old in map(part, _indices(inner.slice)):
                        yield start, end, f"({old}) + 1"


def _indices(node: ast.expr | None) -> Iterator[ast.expr]:
    """What of a subscript is a number by its looks: a name may be that of a key."""
    if isinstance(node, ast.Tuple):
        for inner in node.elts:
            yield from _indices(inner)
    elif isinstance(node, ast.Slice):
        yield from (*_indices(node.lower), *_indices(node.upper))
    elif isinstance(node, (ast.BinOp, ast.UnaryOp)) or (
        isinstance(node, ast.Constant) and type(node.value) is int
    ):
        yield node


def _operators(text: str) -> Iterator[tuple[int, int, str]]:
    lines = [0]
    for line in text.splitlines(keepends=True):
        lines.append(lines[-1] + len(line))
    before: tokenize.TokenInfo | None = None
    annotation = False
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        start, end = lines[token.start[0] - 1] + token.start[1], lines[token.end[0] - 1] + token.end[1]
        # what stands in a signature or a declaration is a type, whose | and [] compute nothing
        if token.type == tokenize.NEWLINE:
            annotation = False
        elif token.string in ("def", "class", "import", "from") or (
            token.string == ":" and before is not None and _declares(token.line)
        ):
            annotation = True
        if not annotation:
            names = tokenize.NAME, tokenize.NUMBER
            binary = before is not None and (before.type in names or before.string in ")]")
            if token.type == tokenize.NUMBER and "." in token.string and float(token.string):
                yield start, end, f"(1.01 * {token.string})"
            elif token.string in _TURNED and binary and token.type in (tokenize.OP, tokenize.NAME):
                yield start, end, _TURNED[token.string]
        before = token


def _declares(line: str) -> bool:
    return re.match(r"\s*[\w.]+: ", line) is not None


def _rank(place: Place, seed: int) -> str:
    """A random number of the place, which does not change with the others."""
    return hashlib.sha256(f"{seed} {place.file} {place.around} {place.new}".encode()).hexdigest()
