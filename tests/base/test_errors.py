"""Exceptions of clrt travel: from a pool's process to the caller, into copies."""

from __future__ import annotations

import copy
import importlib
import inspect
import multiprocessing
import pickle
import pkgutil
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import clrt
from clrt.base.errors import decimal
from clrt.base.places import At, PlacedError
from clrt.base.resources import validation_module
from clrt.formats.tokens import Tokens
from clrt.meshfiles.obj.maps import finite

ARGUMENTS: dict[str, tuple[Any, ...]] = {
    "PlacedError": (At("a.toml", "shapes").item(3), "is wrong", "radius"),
    "_Differs": (("a difference",),),
}
"""What classes that are not made of a text are made of."""


def _modules(package: ModuleType) -> Iterator[ModuleType]:
    yield package
    for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        if not found.name.endswith("__main__") and ".corpus" not in found.name:
            try:
                yield importlib.import_module(found.name)
            except ImportError:  # of an optional package: what is raised there is seen where there is one
                continue


def _classes() -> list[type[BaseException]]:
    found: dict[str, type[BaseException]] = {}
    for package in (clrt, validation_module("types").__package__):
        root = importlib.import_module(package) if isinstance(package, str) else package
        for module in _modules(root):
            for _, kind in inspect.getmembers(module, inspect.isclass):
                if issubclass(kind, BaseException) and kind.__module__.startswith(root.__name__):
                    found[f"{kind.__module__}.{kind.__qualname__}"] = kind
    return list(found.values())


CLASSES = _classes()


def test_all_are_found() -> None:
    names = {kind.__name__ for kind in CLASSES}
    assert names >= {"ClrtError", "PlacedError", "MemoryLimitError", "BrokenMesh", "TooLarge", "ClrtWarning"}
    assert names >= {"_Differs", "MitsubaError", "_Untouched"}


@pytest.mark.parametrize("kind", CLASSES, ids=lambda kind: kind.__name__)
def test_every_exception_can_be_pickled_and_copied(kind: type[BaseException]) -> None:
    error = kind(*ARGUMENTS.get(kind.__name__, ("is wrong",)))
    error.add_note("a note")
    for again in (
        *(pickle.loads(pickle.dumps(error, protocol)) for protocol in range(pickle.HIGHEST_PROTOCOL + 1)),
        copy.copy(error), copy.deepcopy(error),
    ):  # fmt: skip
        assert type(again) is kind and str(again) == str(error) and again.__notes__ == ["a note"]
        if isinstance(error, PlacedError):
            assert (again.text, again.path) == (error.text, error.path) == ("is wrong", "shapes[3].radius")
            assert (again.at.source, again.at.path) == ("a.toml", "shapes[3]")
    if isinstance(error, clrt.ClrtError):
        other = error.reworded("in\nother words")
        assert type(other) is kind and str(other) == "in other words" and vars(other) == vars(error)


def test_numbers_as_all_programs_read_them(tmp_path: Path) -> None:
    def tokens(text: str) -> Tokens:
        (tmp_path / "a.nff").write_text(text, encoding="utf-8")
        return Tokens(tmp_path / "a.nff", clrt.Limits())

    assert [decimal(word) for word in ("1", "-0.5e3", ".5", "+7.")] == [1, -500, 0.5, 7]
    for word in ("1_0", "0.0_5", "\u0663", "\uff11", "x", ""):
        with pytest.raises(ValueError, match=r"number|could not convert"):
            decimal(word)
    for read in (finite, lambda word: tokens(word).number("a width")):
        with pytest.raises((ValueError, clrt.SceneError), match="number"):
            read("\u0663")


def test_an_error_in_a_pool_reaches_the_caller() -> None:
    bad = {"shapes": [{"type": "sphere", "radius": -1}]}
    says = r"shapes\[0\]: the key 'center' is missing"
    with multiprocessing.get_context("spawn").Pool(1) as pool, pytest.raises(clrt.SceneError, match=says):
        pool.apply_async(clrt.load_dict, [bad]).get(timeout=60)
