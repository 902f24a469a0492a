"""Names of many files from one pattern: `out/{index:03}_{camera.fov}.png`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, Final

from clrt.base.errors import ClrtError, show
from clrt.base.suggest import did_you_mean

_FIELD: Final = re.compile(r"\{\{|\}\}|\{([^{}:]*)(?::([^{}]*))?\}|[{}]")
_FORMAT: Final = re.compile(r"0?[0-9]{1,2}|[0-9]{0,2}\.[0-9]{1,2}[feg]")
_FOREIGN: Final = re.compile(r"[^\w.+-]+")
_APART: Final = re.compile(r"([/\\])")  # no value has one
_LONGEST: Final = 60  # characters of a value in a name


def frame_name(pattern: str, index: int, values: Mapping[str, Any]) -> str:
    """The pattern with `{index}` and `{PLACE}` replaced, numbers as `{index:03}` and `{camera.fov:.1f}` say.

    A value becomes letters, digits and `._+-`, and what is dots alone with it `_`, so that it cannot lead to
    another folder. `{{` is a brace.
    ClrtError for a place that is not among `values`, or a format that is none of numbers.
    """
    known: dict[str, Any] = {**values, "index": index}

    def field(found: re.Match[str]) -> str:
        text = found.group(0)
        if text in ("{{", "}}"):
            return text[0]
        name, form = found.group(1), found.group(2)
        if name is None:
            raise ClrtError(f"{pattern}: a brace that is not closed; {{{{ stands for one brace")
        if name not in known:
            hint = did_you_mean(name, known) or f" (there is {', '.join(known)})"
            raise ClrtError(f"{pattern}: {show(name)} is none of the values{hint}")
        return _text(known[name], form, pattern)

    made = zip(_APART.split(pattern), _APART.split(_FIELD.sub(field, pattern)), strict=True)
    return "".join(new.replace(".", "_") if new != old and not new.strip(".") else new for old, new in made)


def _text(value: Any, form: str | None, pattern: str) -> str:
    if form:
        if not _FORMAT.fullmatch(form):
            raise ClrtError(f"{pattern}: {show(form)} is no format of a number; use 03 or .2f")
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ClrtError(f"{pattern}: {show(form)} is a format of numbers, and {show(value)} is none")
        try:
            return format(value, form if form[-1].isalpha() or isinstance(value, int) else f"{form}g")
        except ValueError as error:
            raise ClrtError(f"{pattern}: {show(form)}: {error}") from None
    if isinstance(value, (list, tuple)):
        text = "_".join(_text(part, None, pattern) for part in value)
    else:
        text = f"{value:g}" if isinstance(value, float) else str(value)
    return _FOREIGN.sub("_", text)[:_LONGEST].replace("..", "__") or "_"
