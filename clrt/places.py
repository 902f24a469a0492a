"""Where in a scene something stands, and how a message speaks of it."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from clrt.errors import SceneError, fault, located, show
from clrt.missing import advice


class PlacedError(SceneError):
    """A fault at a known place of a scene, so that who has the file's text can name the line.

    `key` is the key of the table `at` that is to blame, where that should not be in the message's place.
    """

    def __init__(self, at: At, text: str, key: str = "") -> None:
        super().__init__(located(at.source, at.path, text))
        self.at, self.text = at, text
        self.path = at.key(key).path if key else at.path


@dataclass(frozen=True)
class At:
    """A place in a scene, for messages: the file's name and a path such as `shapes[3].radius`."""

    source: str = ""
    path: str = ""

    def key(self, name: str) -> At:
        name = name if re.fullmatch(r"[\w-]{1,60}", name) else show(name)  # a file may call things anything
        return At(self.source, f"{self.path}.{name}" if self.path else name)

    def item(self, index: int) -> At:
        return At(self.source, f"{self.path}[{index}]")

    def inner(self, suffix: str) -> At:
        """The place below this one that msgspec calls `$suffix`."""
        return At(self.source, self.path + suffix)

    def error(self, value: object, right: str) -> PlacedError:
        """'VALUE is not allowed; RIGHT' at this place."""
        return self.says(fault("", "", value, right))

    def says(self, text: str) -> PlacedError:
        return PlacedError(self, text)


def known_keys(table: Mapping[Any, Any], known: Iterable[str], at: At) -> None:
    """Raise for the first key of `table` that is not among `known`, naming the nearest that is."""
    names = list(known)
    for key in table:
        if key not in names:
            hint = advice(key, names) or did_you_mean(key, names)
            text = f"unknown key {show(key)}{hint} (keys here: {listed(names)})"
            raise PlacedError(at, text, str(key))


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """'; did you mean ...?' with the nearest of `known`, or nothing where none is near."""
    names = {str(candidate).lower(): candidate for candidate in known}
    near = difflib.get_close_matches(str(name).lower()[:80], list(names), n=1, cutoff=0.6)
    return f"; did you mean {names[near[0]]!r}?" if near else ""


def listed(names: Iterable[str], most: int = 30) -> str:
    """The names, comma-separated; '...' after the first `most`."""
    shown = [*names]
    return ", ".join(shown[:most]) + (", ..." if len(shown) > most else "")
