"""What exactly is wrong with a table that msgspec refused: the place, the value and the rule."""

from __future__ import annotations

import math
import re
import typing
from collections.abc import Iterator, Sequence
from ctypes import c_float
from functools import cache
from typing import Annotated, Any, NoReturn

import msgspec
import numpy as np
from msgspec import Meta

from clrt.base.missing import advice
from clrt.base.places import At, known_keys

FLOAT32_MAX = float(np.finfo(np.float32).max)

REFUSALS = (msgspec.ValidationError, OverflowError, RecursionError, UnicodeEncodeError)
"""What `msgspec.convert` and `single` raise for a bad value (the last: half a surrogate pair)."""


def single(value: Any) -> Any:
    """`value` with its floats rounded to float32; OverflowError where that is not finite."""
    if isinstance(value, float):
        rounded = c_float(value).value
        if not math.isfinite(rounded):
            raise OverflowError
        return rounded
    if isinstance(value, int) and abs(value) > FLOAT32_MAX:
        raise OverflowError
    if isinstance(value, (list, tuple)):
        return [single(item) for item in value]
    if isinstance(value, dict):
        return {key: single(item) for key, item in value.items()}
    return value


def explain(cls: type[msgspec.Struct], table: dict[str, Any], at: At) -> NoReturn:
    """Raise the error for what is wrong with `table` (msgspec's own text has neither value nor rule)."""
    hints = field_types(cls)
    tag_field, tag = cls.__struct_config__.tag_field, cls.__struct_config__.tag
    if tag_field and table.get(tag_field) != tag:
        raise at.key(tag_field).error(table.get(tag_field), f"type must be {tag!r}")
    known_keys(table, [*hints, tag_field] if tag_field else hints, at)
    for field in msgspec.structs.fields(cls):
        if field.required and field.name not in table:
            raise at.says(f"the key {field.name!r} is missing; {describe(hints[field.name], field.name)}")
    for name, value in table.items():
        if name in hints:
            _check_value(hints[name], value, at.key(name), name)
    raise at.error(table, f"must be a {cls.__name__}")


def _check_value(hint: Any, value: Any, at: At, name: str) -> None:
    for inner, struct, table in _tables(hint, value, at, name):
        try:
            msgspec.convert(table, struct)
            msgspec.convert(single(table), struct)
        except REFUSALS:
            explain(struct, table, inner)
    right = describe(hint, name)
    _check_numbers(value, at)
    for candidate, note in ((value, ""), (single(value), " (in float32, which is what devices compute in)")):
        try:
            msgspec.convert(candidate, hint)
        except UnicodeEncodeError:
            raise at.error(value, f"{right}, and its text valid Unicode") from None
        except msgspec.ValidationError as error:
            suffix = re.search(r" - at `\$(.*?)`$", str(error))
            path = suffix.group(1) if suffix else ""
            wrong = _follow(value, path)
            raise at.inner(path).error(wrong, right + (_other_kind(wrong, hint, name) or note)) from None


def _other_kind(value: Any, hint: Any, name: str) -> str:
    """What a value is that should be a number or a name, where its rule alone would puzzle; else "".

    What other renderers have is asked for by a key or a `type`; the same word means something else elsewhere.
    """
    kinds = leaves(hint)
    numbers = float in kinds or int in kinds
    if isinstance(value, str):
        is_number = numbers and str not in kinds
        if is_number:
            return "; this is a text, and numbers have no quotes"
        return advice(value, []) if name == "type" else ""
    if isinstance(value, bool) and numbers:
        return "; this is true or false, not a number"
    return ""


def _tables(
    hint: Any, value: Any, at: At, name: str
) -> Iterator[tuple[At, type[msgspec.Struct], dict[str, Any]]]:
    """The tables directly in a field's value, with the class each must be read as.

    Raises for one of no type that may stand there.
    """
    structs = records_in(hint)
    if not structs:
        return
    items = enumerate(value) if isinstance(value, (list, tuple)) else ()
    found = (
        [(at, value)]
        if isinstance(value, dict)
        else [(at.item(i), v) for i, v in items if isinstance(v, dict)]
    )
    # the last rule is that of the parts
    rules = [meta.description for meta in metas(hint) if meta.description and not isinstance(value, dict)]
    right = rules[-1] if rules else describe(hint, name)
    for place, table in found:
        struct = of_type(table, structs)
        if struct is not None:
            yield place, struct, table
        elif "type" in table:
            known = [str(kind.__struct_config__.tag) for kind in structs]
            raise place.key("type").error(table["type"], right + advice(table["type"], known))
        else:
            raise place.error(table, right)


def records_in(hint: Any) -> tuple[type[Any], ...]:
    """The records among the types that an annotation joins."""
    return tuple(t for t in leaves(hint) if isinstance(t, type) and issubclass(t, msgspec.Struct))


def of_type(table: dict[str, Any], records: Sequence[type[Any]]) -> type[Any] | None:
    """The one of `records` that a table is of by its `type`, or by being the only one without."""
    for record in records:
        config = record.__struct_config__
        if config.tag == (table.get(config.tag_field) if config.tag_field else None):
            return record
    return None


def _check_numbers(value: Any, at: At) -> None:
    if isinstance(value, (list, tuple)):
        for index, item in enumerate(value):
            _check_numbers(item, at.item(index))
    elif isinstance(value, dict):
        for key, item in value.items():
            _check_numbers(item, at.key(str(key)))
    elif isinstance(value, (int, float)):
        if not -FLOAT32_MAX <= value <= FLOAT32_MAX:
            raise at.error(value, f"numbers must be finite and at most {FLOAT32_MAX:.3g} (float32)")


def _follow(value: Any, path: str) -> Any:
    """The part of `value` at a path of indices such as `[2][0]`."""
    for index in re.findall(r"\[(\d+)\]", path):
        value = value[int(index)]
    return value


@cache
def field_types(cls: type[msgspec.Struct]) -> dict[str, Any]:
    """The annotated types of a record's fields by name."""
    hints = typing.get_type_hints(cls, include_extras=True)
    return {name: hints[name] for name in cls.__struct_fields__}


def describe(hint: Any, name: str) -> str:
    """The rule that an annotation states, as a clause for messages."""
    for meta in metas(hint):
        if meta.description:
            return (
                meta.description if not meta.description.startswith("must") else f"{name} {meta.description}"
            )
    return f"{name} must be {_words(hint)}"


def metas(hint: Any) -> list[Meta]:
    if typing.get_origin(hint) is Annotated:
        own = [meta for meta in hint.__metadata__ if isinstance(meta, Meta)]
        return own + metas(hint.__origin__)
    return [meta for part in typing.get_args(hint) if not isinstance(part, str) for meta in metas(part)]


def leaves(hint: Any) -> list[Any]:
    """The types that an annotation joins."""
    parts = [hint.__origin__] if typing.get_origin(hint) is Annotated else typing.get_args(hint)
    return [leaf for part in parts for leaf in leaves(part)] if parts else [hint]


def _words(hint: Any) -> str:
    words = {float: "a number", int: "a whole number", bool: "true or false", str: "a text"}
    parts = [words.get(leaf, f"{leaf!r}" if isinstance(leaf, str) else "") for leaf in leaves(hint)]
    return " or ".join(part for part in parts if part)
