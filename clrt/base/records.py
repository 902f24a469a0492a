"""Plain data in, checked frozen records out.

Every record of a scene, whether it came from a file, a dict or a Python object, passes through `read`: the
one place that decides whether a value can be trusted. Types and ranges stand in the records' annotations
(they also make the JSON schema); rules that join several values stand in each record's `check`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from ctypes import c_float
from datetime import date, time, timedelta
from decimal import Decimal
from functools import cache, partial
from itertools import chain
from numbers import Rational
from typing import TYPE_CHECKING, Annotated, Any, TypeVar
from uuid import UUID

import msgspec
import numpy as np
from msgspec import NODEFAULT, Meta

from clrt.base.explain import REFUSALS, explain, field_types, leaves, metas, of_type, records_in, single
from clrt.base.hints import Numbers
from clrt.base.missing import advice
from clrt.base.places import At, listed
from clrt.base.suggest import did_you_mean

_TINY, _HUGE = 1e-30, 1e30  # well within float32
_ENTRIES = 1 << 27  # of an array; a view of one number may have as many as there are addresses
_TEXTS = (bytes, bytearray, memoryview, date, time, timedelta, Decimal, UUID)
"""Of which msgspec makes texts."""
_DEEP = 64  # levels of tables and lists in one another that anything here has
Triple = tuple[float, float, float]
if TYPE_CHECKING:
    Vector = Numbers
else:
    Vector = Annotated[tuple[float, float, float], Meta(description="must be 3 numbers")]


class Unstated(int):
    """A default number that can be told from the same number where somebody states it."""


class Record(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A table of a scene: frozen, keyword-only, no unknown keys."""

    def check(self, at: At) -> None:
        """Raise `SceneError` for what the annotations cannot say; subclasses add to it."""

    @classmethod
    def instead_of(cls, field: str, table: Mapping[str, Any]) -> tuple[str, ...]:
        """The fields that say otherwise, in what is stated, what this one says: who edits it drops them."""
        return ()

    def stated(self, field: str) -> Any:
        """A field's value as it was stated; for some there is one that follows from others."""
        return getattr(self, field)

    @classmethod
    def prepared(cls, table: dict[str, Any]) -> dict[str, Any]:
        """`table` with short forms, of its own fields and of records in them, written out in full."""
        kinds = _kinds(cls)
        return {name: _prepared(value, kinds.get(name, ())) for name, value in table.items()}

    def short(self) -> Any:
        """What `table_of` says of this record where it stands in another."""
        return table_of(self)

    @property
    def type(self) -> str:
        """The table's `type`, such as "sphere"."""
        return str(self.__struct_config__.tag)


R = TypeVar("R", bound=Record)


def read(cls: type[R], data: object, at: At) -> R:
    """The checked record of class `cls` that `data` (a mapping or a record of that class) describes."""
    simple = _read_simple(cls, data) if type(data) is dict and _rounds_safely(cls) else None
    if simple is not None:
        simple.check(at)
        return simple
    table = cls.prepared(plain(data, cls, at))
    try:
        record = msgspec.convert(table, cls)
        msgspec.convert(single(table), cls)  # the ranges must hold for what the device will see, too
    except REFUSALS:
        explain(cls, table, at)
    record.check(at)
    return record


def _read_simple(cls: type[R], table: dict[str, Any]) -> R | None:
    """What `read` makes of a right table of built-in types, but without copies of it; None for any other.

    Scenes have millions of such tables.
    """
    try:
        if not _is_simple(table.values()):
            return None
        return msgspec.convert(table, cls)
    except REFUSALS:
        pass
    try:
        return msgspec.convert(cls.prepared(table), cls)
    except REFUSALS:
        return None


def _is_simple(values: Iterable[Any]) -> bool:
    """Whether values are built-in types with numbers that keep their sign, and stay finite, as float32."""
    for value in values:
        kind = type(value)
        if kind is float:
            if not (_TINY < value < _HUGE or value == 0.0 or -_HUGE < value < -_TINY):
                return False
        elif kind is list or kind is tuple:
            if not _is_simple(value):
                return False
        elif kind is dict:
            if not _is_simple(value.values()):
                return False
        elif kind is int:
            if not -_HUGE < value < _HUGE:
                return False
        elif not (kind is str or kind is bool or value is None):
            return False
    return True


@cache
def _rounds_safely(cls: type[msgspec.Struct]) -> bool:
    """Whether rounding cannot leave a range of its floats: it is closed at a float32 number, or ends at 0."""
    hints = field_types(cls).values()
    found = [meta for h in hints if float in leaves(h) for meta in metas(h)]
    inner: list[type[msgspec.Struct]] = [record for h in hints for record in records_in(h)]
    closed = all(end is None or bool(float32(end) == end) for meta in found for end in (meta.ge, meta.le))
    return closed and not any(meta.gt or meta.lt for meta in found) and all(map(_rounds_safely, inner))


@cache
def _kinds(cls: type[Record]) -> dict[str, tuple[type[Record], ...]]:
    """The records that each field may hold."""
    return {name: records_in(hint) for name, hint in field_types(cls).items()}


def _prepared(value: Any, kinds: tuple[type[Record], ...]) -> Any:
    """A field's value, prepared where it is a table of one of `kinds` or a list of such."""
    if isinstance(value, (list, tuple)) and kinds:
        return [_prepared(item, kinds) for item in value]
    kind = of_type(value, kinds) if isinstance(value, dict) else None
    return kind.prepared(value) if kind else value


def table_of(record: Record) -> dict[str, Any]:
    """The plain dict that `read` makes an equal record of: no default values, tuples and arrays as lists."""
    table = {"type": record.type} if record.__struct_config__.tag else {}
    for name, default in _defaults(record.__class__).items():
        value = record.stated(name)
        stated = isinstance(default, Unstated) and not isinstance(value, Unstated)
        if value is not None and (isinstance(value, (list, np.ndarray)) or value != default or stated):
            table[name] = _as_builtin(value)
    return table


@cache
def _defaults(cls: type[Record]) -> dict[str, Any]:
    """The fields of a record and their defaults, what all shapes share last."""
    fields = sorted(msgspec.structs.fields(cls), key=lambda field: field.name in ("material", "transform"))
    made = {field.name: field.default_factory for field in fields if field.default_factory is not NODEFAULT}
    return {field.name: made[field.name]() if field.name in made else field.default for field in fields}


def _as_builtin(value: Any) -> Any:
    if isinstance(value, Record):
        return value.short()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [_as_builtin(item) for item in value]
    if isinstance(value, dict):
        return {key: _as_builtin(item) for key, item in value.items()}
    return value


def plain(data: object, cls: type, at: At) -> dict[str, Any]:
    """`data` as a dict of built-in types: numpy arrays become lists, records become dicts."""
    if not isinstance(data, (Mapping, cls)):
        raise at.error(data, f"must be a table of keys or a {cls.__name__}")
    check_kinds(data, at)
    try:
        found: dict[str, Any]
        found = msgspec.to_builtins(dict(data) if isinstance(data, Mapping) else data, enc_hook=_from_numpy)
    except RecursionError:
        raise at.says("it holds itself, or its tables and lists lie too deep in each other") from None
    except (TypeError, ValueError, OverflowError) as error:
        raise at.says(str(error)) from None
    if isinstance(data, Record):  # None is what nobody stated
        found = {name: value for name, value in found.items() if value is not None}
    value_of = data.get if isinstance(data, Mapping) else partial(getattr, data)
    return {name: value for name, value in found.items() if not isinstance(value_of(name, None), Unstated)}


def tagged(kinds: Mapping[str, type[R]], data: object, at: At, noun: str) -> type[R]:
    """The class among `kinds` that `data` is of, or says it is with its key `type`."""
    if type(data) is dict:  # most are
        known = data.get("type")
        if type(known) is str and known in kinds:
            return kinds[known]
    for kind in kinds.values():
        if type(data) is kind:
            return kind
    if not isinstance(data, Mapping):
        raise at.error(data, f"a {noun} must be a table with a type ({listed(kinds)})")
    name = data.get("type")
    if name is None:
        raise at.says(f"the key 'type' is missing; a {noun} is one of {listed(kinds)}")
    if not isinstance(name, str) or name not in kinds:
        hint = advice(name, [*kinds]) or did_you_mean(name, kinds)
        raise at.key("type").error(name, f"a {noun} is one of {listed(kinds)}{hint}")
    return kinds[name]


def single_of(number: float) -> float:
    """The number as the device will see it."""
    return c_float(number).value


def is_zero(vector: Iterable[float]) -> bool:
    """Whether a vector has no direction once its components are rounded to float32."""
    return not any(c_float(x).value for x in vector)


def cross(a: Iterable[float], b: Iterable[float]) -> Triple:
    """a x b, to the bit as `np.cross`, which takes many times as long for a single one."""
    (a0, a1, a2), (b0, b1, b2) = a, b
    return a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0


def float32(values: Any) -> np.ndarray:
    """The values as the device will see them, in float64 for the arithmetic of checks."""
    return np.asarray(values, np.float32).astype(np.float64)


def check_kinds(data: object, at: At) -> None:
    """Raise where a value that msgspec makes something else of stands somewhere in tables and lists.

    Level by level, for there may be many numbers; what is deeper is refused by itself.
    """
    level: list[Any] = [data]
    for depth in range(_DEEP):
        kinds = {*map(type, level)}
        if any(issubclass(kind, (set, frozenset)) for kind in kinds):
            raise at.says("a set has no order; give a list or a tuple")
        if found := next((kind for kind in kinds if issubclass(kind, _TEXTS)), None):
            place, value = next(pair for pair in _placed(data, at, depth) if type(pair[1]) is found)
            right = f"an object of class {found.__name__} cannot be part of a scene; give a text or a number"
            raise place.error(str(value) if isinstance(value, (date, time)) else value, right)
        if not any(issubclass(kind, (list, tuple, Mapping)) for kind in kinds):
            return
        inner = (value.values() if isinstance(value, Mapping) else value for value in level
                 if isinstance(value, (list, tuple, Mapping)))  # fmt: skip
        level = [*chain.from_iterable(inner)]


def _placed(data: Any, at: At, depth: int) -> Iterator[tuple[At, Any]]:
    """What stands so deep in tables and lists, each with its place."""
    if not depth:
        yield at, data
    elif isinstance(data, Mapping):
        for key, value in data.items():
            yield from _placed(value, at.key(str(key)), depth - 1)
    elif isinstance(data, (list, tuple)):
        for i, value in enumerate(data):
            yield from _placed(value, at.item(i), depth - 1)


def _from_numpy(value: object) -> object:
    if isinstance(value, (np.ndarray, np.generic)):
        if value.size > _ENTRIES:
            raise ValueError(f"an array {value.shape} has too many entries; a value has at most {_ENTRIES}")
        if value.dtype.kind in "mM":  # of which `tolist` makes whole numbers, where they are nanoseconds
            raise TypeError("a time or a date cannot be part of a scene; give a number")
        return (value.astype(np.float64) if value.dtype.kind == "f" else value).tolist()
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, Unstated):
        return int(value)
    if isinstance(value, Rational):
        return float(value)
    raise TypeError(f"an object of class {type(value).__name__} cannot be part of a scene")
