"""Plain data in, checked frozen records out.

Every record of a scene, whether it came from a file, a dict or a Python object, passes through `read`: the one
place that decides whether a value can be trusted. Types and ranges stand in the records' annotations (they also make
the JSON schema); rules that join several values stand in each record's `check`.
"""

from __future__ import annotations

import difflib
import math
import re
import typing
from collections.abc import Iterable, Mapping
from ctypes import c_float
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, NoReturn, TypeVar

import msgspec
import numpy as np
from msgspec import Meta

from clrt.errors import SceneError, fault, located, show

FLOAT32_MAX = float(np.finfo(np.float32).max)

Vector = Annotated[tuple[float, float, float], Meta(description="must be 3 numbers")]
Grey = Annotated[float, Meta(ge=0)]
# A range on the single number would belong here, but msgspec 0.22 crashes on a ranged float beside a tuple of fixed
# length; `check_colors` holds the rule instead.
Color = Annotated[
    float | tuple[Grey, Grey, Grey], Meta(description="a colour must be a number >= 0 or 3 numbers >= 0")
]


@dataclass(frozen=True)
class At:
    """A place in a scene, for messages: the file's name and a path such as `shapes[3].radius`."""

    source: str = ""
    path: str = ""

    def key(self, name: str) -> At:
        return At(self.source, f"{self.path}.{name}" if self.path else name)

    def item(self, index: int) -> At:
        return At(self.source, f"{self.path}[{index}]")

    def inner(self, suffix: str) -> At:
        """The place below this one that msgspec calls `$suffix`."""
        return At(self.source, self.path + suffix)

    def error(self, value: object, right: str) -> SceneError:
        """'VALUE is not allowed; RIGHT' at this place."""
        return SceneError(fault(self.source, self.path, value, right))

    def says(self, text: str) -> SceneError:
        return SceneError(located(self.source, self.path, text))


class Record(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A table of a scene: frozen, keyword-only, no unknown keys."""

    def check(self, at: At) -> None:
        """Raise `SceneError` for what the annotations cannot say; subclasses add to it."""
        for name in _color_fields(self.__class__):
            check_color(getattr(self, name), at.key(name))

    @property
    def type(self) -> str:
        """The table's `type`, such as "sphere"."""
        return str(self.__struct_config__.tag)


R = TypeVar("R", bound=Record)


def read(cls: type[R], data: object, at: At) -> R:
    """The checked record of class `cls` that `data` (a mapping or a record of that class) describes."""
    table = plain(data, cls, at)
    try:
        record = msgspec.convert(table, cls)
        msgspec.convert(_single(table), cls)  # the ranges must hold for what the device will see, too
    except (msgspec.ValidationError, OverflowError, RecursionError):
        _explain(cls, table, at)
    record.check(at)
    return record


def plain(data: object, cls: type, at: At) -> dict[str, Any]:
    """`data` as a dict of built-in types: numpy arrays become lists, records become dicts."""
    if not isinstance(data, (Mapping, cls)):
        raise at.error(data, f"must be a table of keys or a {cls.__name__}")
    try:
        return msgspec.to_builtins(dict(data) if isinstance(data, Mapping) else data, enc_hook=_from_numpy)
    except (TypeError, ValueError, RecursionError) as error:
        raise at.says(f"cannot be read: {error}") from None


def tagged(kinds: Mapping[str, type[Record]], data: object, at: At, noun: str) -> type[Record]:
    """The class among `kinds` that `data` is of, or says it is with its key `type`."""
    for kind in kinds.values():
        if type(data) is kind:
            return kind
    if not isinstance(data, Mapping):
        raise at.error(data, f"a {noun} must be a table with a type ({listed(kinds)})")
    name = data.get("type")
    if name is None:
        raise at.says(f"the key 'type' is missing; a {noun} is one of {listed(kinds)}")
    if not isinstance(name, str) or name not in kinds:
        raise at.key("type").error(name, f"a {noun} is one of {listed(kinds)}{did_you_mean(name, kinds)}")
    return kinds[name]


def known_keys(table: Mapping[Any, Any], known: Iterable[str], at: At) -> None:
    """Raise for the first key of `table` that is not among `known`, naming the nearest that is."""
    names = list(known)
    for key in table:
        if key not in names:
            raise at.says(f"unknown key {show(key)}{did_you_mean(key, names)} (keys here: {listed(names)})")


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """'; did you mean ...?' with the nearest of `known`, or nothing where there is none."""
    near = difflib.get_close_matches(str(name).lower()[:80], list(known), n=1, cutoff=0.0)
    return f"; did you mean {near[0]!r}?" if near else ""


def listed(names: Iterable[str], most: int = 30) -> str:
    """The names, comma-separated; '...' after the first `most`."""
    shown = [*names]
    return ", ".join(shown[:most]) + (", ..." if len(shown) > most else "")


def check_color(color: object, at: At) -> None:
    """Raise for a grey below 0 (3 numbers are checked by their annotation)."""
    if isinstance(color, (int, float)) and not color >= 0:
        raise at.error(color, describe(Color, "a colour"))


def is_zero(vector: Iterable[float]) -> bool:
    """Whether a vector has no direction in float32: its squared length vanishes or overflows."""
    length = sum(c_float(c_float(x).value ** 2).value for x in vector)
    return not 0.0 < length < FLOAT32_MAX


def float32(values: Any) -> np.ndarray:
    """The values as the device will see them, in float64 for the arithmetic of checks."""
    return np.asarray(values, np.float32).astype(np.float64)


def _from_numpy(value: object) -> object:
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"a {type(value).__name__} cannot be part of a scene")


def _single(value: Any) -> Any:
    """`value` with its floats rounded to float32; OverflowError where that is not finite."""
    if isinstance(value, float):
        rounded = c_float(value).value
        if not math.isfinite(rounded):
            raise OverflowError
        return rounded
    if isinstance(value, int) and abs(value) > FLOAT32_MAX:
        raise OverflowError
    if isinstance(value, list):
        return [_single(item) for item in value]
    if isinstance(value, dict):
        return {key: _single(item) for key, item in value.items()}
    return value


def _explain(cls: type[Record], table: dict[str, Any], at: At) -> NoReturn:
    """Raise the error for what is wrong with `table`; msgspec's own text has neither the value nor the rule."""
    hints = field_types(cls)
    tag_field = cls.__struct_config__.tag_field
    known_keys(table, [*hints, tag_field] if tag_field else hints, at)
    for field in msgspec.structs.fields(cls):
        if field.required and field.name not in table:
            raise at.says(f"the key {field.name!r} is missing; {describe(hints[field.name], field.name)}")
    for name, value in table.items():
        if name in hints:
            _check_value(hints[name], value, at.key(name), name)
    raise at.error(table, f"must be a {cls.__name__}")


def _check_value(hint: Any, value: Any, at: At, name: str) -> None:
    for inner, struct, table in _tables(hint, value, at):
        try:
            msgspec.convert(table, struct)
            msgspec.convert(_single(table), struct)
        except (msgspec.ValidationError, OverflowError, RecursionError):
            _explain(struct, table, inner)
    right = describe(hint, name)
    _check_numbers(value, at, right)
    for candidate, note in ((value, ""), (_single(value), " (in float32, which is what devices compute in)")):
        try:
            msgspec.convert(candidate, hint)
        except msgspec.ValidationError as error:
            suffix = re.search(r" - at `\$(.*?)`$", str(error))
            path = suffix.group(1) if suffix else ""
            raise at.inner(path).error(_follow(value, path), right + note) from None


def _tables(hint: Any, value: Any, at: At) -> list[tuple[At, type[Record], dict[str, Any]]]:
    """The tables directly in a field's value, with the class each must be read as."""
    structs = [t for t in _leaves(hint) if isinstance(t, type) and issubclass(t, Record)]
    if not structs:
        return []
    items = enumerate(value) if isinstance(value, list) else ()
    found = (
        [(at, value)]
        if isinstance(value, dict)
        else [(at.item(i), v) for i, v in items if isinstance(v, dict)]
    )
    return [(place, structs[0], table) for place, table in found]


def _check_numbers(value: Any, at: At, right: str) -> None:
    if isinstance(value, list):
        for index, item in enumerate(value):
            _check_numbers(item, at.item(index), right)
    elif isinstance(value, (int, float)):
        if not -FLOAT32_MAX <= value <= FLOAT32_MAX:
            raise at.error(value, f"numbers must be finite and at most {FLOAT32_MAX:.3g} (float32)")


def _follow(value: Any, path: str) -> Any:
    """The part of `value` at a path of indices such as `[2][0]`."""
    for index in re.findall(r"\[(\d+)\]", path):
        value = value[int(index)]
    return value


@cache
def field_types(cls: type[Record]) -> dict[str, Any]:
    """The annotated types of a record's fields by name."""
    hints = typing.get_type_hints(cls, include_extras=True)
    return {name: hints[name] for name in cls.__struct_fields__}


@cache
def _color_fields(cls: type[Record]) -> tuple[str, ...]:
    rule = describe(Color, "")
    return tuple(
        name for name, hint in field_types(cls).items() if rule in [meta.description for meta in _metas(hint)]
    )


def describe(hint: Any, name: str) -> str:
    """The rule that an annotation states, as a clause for messages."""
    for meta in _metas(hint):
        if meta.description:
            return (
                meta.description if not meta.description.startswith("must") else f"{name} {meta.description}"
            )
    return f"{name} must be {_words(hint)}"


def _metas(hint: Any) -> list[Meta]:
    if typing.get_origin(hint) is Annotated:
        own = [meta for meta in hint.__metadata__ if isinstance(meta, Meta)]
        return own + _metas(hint.__origin__)
    return [meta for part in typing.get_args(hint) if not isinstance(part, str) for meta in _metas(part)]


def _leaves(hint: Any) -> list[Any]:
    parts = [hint.__origin__] if typing.get_origin(hint) is Annotated else typing.get_args(hint)
    return [leaf for part in parts for leaf in _leaves(part)] if parts else [hint]


def _words(hint: Any) -> str:
    words = {float: "a number", int: "a whole number", bool: "true or false", str: "a text"}
    parts = [words.get(leaf, f"{leaf!r}" if isinstance(leaf, str) else "") for leaf in _leaves(hint)]
    return " or ".join(part for part in parts if part)
