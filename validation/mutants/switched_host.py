"""Many faults in one copy of the host's code: each place computes either, as a number in a module says.

A process that has loaded its kernels renders a hundred small pictures in the time that a new one takes to
load them. So one process has all faults, one of which counts, and leaves a mark where it comes by a place.
"""

from __future__ import annotations

import ast
import importlib
import sys
from collections.abc import Collection, Iterable, Iterator
from functools import _lru_cache_wrapper
from typing import Any, Final

from .generated import Place

MODULE: Final = "clrt_chosen_fault"
"""What the copy imports; its file is to hold TEXT."""
TEXT: Final = '''"""Which fault counts (0: none), and the places that were come by since it was chosen."""

number = 0
reached = set()


def counts(which):
    """Whether this fault is there."""
    reached.add(which)
    return which == number
'''
_KEEP: Final = ("clrt.base.", "clrt.device.")  # rooms without faults, which hold the driver
_COUNTS: Final = "_fault_counts"
_FUNCTIONS: Final = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)
# which stand where only they may stand
_FIXED: Final = (ast.Slice, ast.Starred, ast.JoinedStr, ast.FormattedValue, *_FUNCTIONS[:2], ast.ClassDef)

Step = tuple[str, int]  # the field of a node, and which of its list
Way = tuple[Step, ...]


class Switch:
    """The module that says which fault counts. One a process, made before a case is read.

    modules: those with faults, which are imported now.
    """

    def __init__(self, modules: Collection[str]) -> None:
        for name in modules:
            importlib.import_module(name)
        self._module: Any = importlib.import_module(MODULE)

    def choose(self, number: int) -> None:
        """The fault that is there from now on; 0: none. What was computed before is forgotten."""
        for name, module in list(sys.modules.items()):
            if name.startswith("clrt.") and not name.startswith(_KEEP):
                for held in list(vars(module).values()):
                    if isinstance(held, _lru_cache_wrapper):
                        held.cache_clear()
        self._module.number = number
        self._module.reached.clear()

    def reached(self) -> frozenset[int]:
        """The faults whose places were come by since then."""
        return frozenset(self._module.reached)


def with_all(text: str, faults: Iterable[tuple[int, Place]]) -> tuple[str, set[int]]:
    """A module's text in which each of these faults (number, place) can be chosen, and the numbers of those
    that cannot be: outside of functions a module computes but once."""
    tree = ast.parse(text)
    planted: dict[Way, list[tuple[int, ast.AST]]] = {}
    left = set()
    for number, place in faults:
        try:
            wrong = ast.parse(place.edit(text))
        except SyntaxError:  # where a constant has to stand
            left.add(number)
            continue
        way = _chosen_at(tree, _apart(tree, wrong))
        if way is None:
            left.add(number)
        else:
            planted.setdefault(way, []).append((number, _at(wrong, way)[-1]))
    if not planted:
        return text, left
    new = _switched(tree, (), planted)
    assert isinstance(new, ast.Module)
    first = next(k for k, node in enumerate(new.body)
                 if not (isinstance(node, ast.Expr) or _of_future(node)))  # fmt: skip
    new.body.insert(first, ast.parse(f"from {MODULE} import counts as {_COUNTS}").body[0])
    return ast.unparse(ast.fix_missing_locations(new)) + "\n", left


def _of_future(node: ast.stmt) -> bool:
    return isinstance(node, ast.ImportFrom) and node.module == "__future__"


def _children(node: ast.AST) -> Iterator[tuple[Step, ast.AST]]:
    for field, value in ast.iter_fields(node):
        for k, child in enumerate(value if isinstance(value, list) else [value]):
            if isinstance(child, ast.AST):
                yield (field, k), child


def _apart(one: ast.AST, other: ast.AST) -> Way:
    """The way to the smallest node in which all is that differs between two trees."""
    mine, others = dict(_children(one)), dict(_children(other))
    if type(one) is not type(other) or mine.keys() != others.keys():
        return ()
    differ = [step for step in mine if ast.dump(mine[step]) != ast.dump(others[step])]
    if len(differ) != 1:
        return ()
    return (differ[0], *_apart(mine[differ[0]], others[differ[0]]))


def _at(tree: ast.AST, way: Way) -> list[ast.AST]:
    """The nodes along a way."""
    nodes = [tree]
    for step in way:
        nodes.append(dict(_children(nodes[-1]))[step])
    return nodes


def _chosen_at(tree: ast.Module, way: Way) -> Way | None:
    """The way to the smallest expression or statement around that can be written twice, in a function;
    None where there is none, or the text is the same."""
    nodes = _at(tree, way)
    if any(isinstance(node, ast.pattern) for node in nodes):
        return None  # of `match`: a constant has to stand there
    for k in range(len(way), 0, -1):
        node = nodes[k]
        of_value = isinstance(node, ast.expr) and isinstance(getattr(node, "ctx", ast.Load()), ast.Load)
        if (of_value or isinstance(node, ast.stmt)) and not isinstance(node, _FIXED):
            inside = any(isinstance(nodes[j], _FUNCTIONS) and way[j][0] == "body" for j in range(k))
            return way[:k] if inside else None
    return None


def _switched(node: ast.AST, way: Way, planted: dict[Way, list[tuple[int, ast.AST]]]) -> ast.AST:
    """The node with the faults in it, from the innermost on."""
    def one(field: str, k: int, child: Any) -> Any:
        return _switched(child, (*way, (field, k)), planted) if isinstance(child, ast.AST) else child

    fields = {}
    for field, value in ast.iter_fields(node):
        some = value if isinstance(value, list) else [value]
        made = [one(field, k, child) for k, child in enumerate(some)]
        fields[field] = made if isinstance(value, list) else made[0]
    new = type(node)(**fields)
    for number, wrong in planted.get(way, ()):
        counts = ast.parse(f"{_COUNTS}({number})", mode="eval").body
        if isinstance(wrong, ast.stmt):
            assert isinstance(new, ast.stmt)
            new = ast.If(counts, [wrong], [new])
        else:
            assert isinstance(wrong, ast.expr) and isinstance(new, ast.expr)
            new = ast.IfExp(counts, wrong, new)
    return new
