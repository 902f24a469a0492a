"""Where in a scene something stands, and how a message speaks of it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from clrt.base.errors import SceneError, fault, located, show
from clrt.base.missing import advice
from clrt.base.suggest import did_you_mean


class PlacedError(SceneError):
    """A fault at a known place of a scene, so that who has the file's text can name the line.

    `key` is the key of the table `at` that is to blame, where that should not be in the message's place.
    """

    def __init__(self, at: At, text: str, key: str = "") -> None:
        super().__init__(located(at.source, at.path, text))
        self.at, self.text = at, text
        self.path = at.key(key).path if key else at.path


class At:
    """A place in a scene, for messages: the file's name and a path such as `shapes[3].radius`.

    The path is put together when it is asked for: a scene has millions of places, and a message names one.
    """

    __slots__ = ("_above", "_part", "source")

    def __init__(self, source: str = "", path: str | int = "", above: At | None = None) -> None:
        self.source, self._part, self._above = source, path, above

    def __reduce__(self) -> tuple[Any, ...]:
        return At, (self.source, self._part, self._above)

    @property
    def path(self) -> str:
        if self._above is None:
            return str(self._part)
        above, name = self._above.path, self._part
        if isinstance(name, int):
            return f"{above}[{name}]"
        name = name if re.fullmatch(r"[\w-]{1,60}", name) else show(name)  # a file may call things anything
        return f"{above}.{name}" if above else name

    @property
    def name(self) -> str:
        """The last key or number of the path; cheap, unlike the path."""
        return str(self._part)

    def key(self, name: str) -> At:
        return At(self.source, name, self)

    def item(self, index: int) -> At:
        return At(self.source, index, self)

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
            raise PlacedError(at, text, key if isinstance(key, str) else show(key))


def listed(names: Iterable[str], most: int = 30) -> str:
    """The names, comma-separated; '...' after the first `most`."""
    shown = [*names]
    return ", ".join(shown[:most]) + (", ..." if len(shown) > most else "")
