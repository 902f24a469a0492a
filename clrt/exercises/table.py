"""The exercises, as `exercises.toml` has them: each a fault in the kernels, and what is told about it."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

import msgspec

from clrt.base.errors import ClrtError

_FOLDER: Final = Path(__file__).parent
SCENES: Final = _FOLDER / "scenes"
HINTS: Final = 3


@dataclass(frozen=True)
class Exercise:
    """A fault: in the kernel file `file`, `wrong` stands where `right` should; `scene` shows it best."""

    title: str
    scene: str  # a name of `scenes()`
    file: str
    right: str
    wrong: str
    picture: str  # what is seen
    hints: tuple[str, ...]  # HINTS of them: each tells more
    lesson: str  # what to take away
    number: int = 0  # from 1

    def planted(self, text: str) -> str:
        """The text of `file` with the fault. ClrtError where there is no place, or more than one."""
        if text.count(self.right) != 1:
            raise ClrtError(f"{self.file}: exercise {self.number} needs this once: {self.right}")
        return text.replace(self.right, self.wrong)


@cache
def exercises() -> tuple[Exercise, ...]:
    """All exercises, the easy ones first."""
    rows = tomllib.loads((_FOLDER / "exercises.toml").read_text(encoding="utf-8"))["exercise"]
    return tuple(
        msgspec.convert({**row, "number": number}, Exercise) for number, row in enumerate(rows, start=1)
    )


def exercise(number: int) -> Exercise:
    """The exercise of that number. ClrtError where there is none."""
    if not 1 <= number <= len(exercises()):
        raise ClrtError(f"there is no exercise {number}; they are numbered 1 to {len(exercises())}")
    return exercises()[number - 1]


@cache
def scenes() -> dict[str, Path]:
    """The scenes that exercises are judged by, name -> file: together they show every fault."""
    return {file.stem: file for file in sorted(SCENES.glob("*.toml"))}
