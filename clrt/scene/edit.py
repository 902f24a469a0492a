"""Scenes that differ from another in a few places: what `Scene.replace` is given, as drafts of records."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np

from clrt.base.errors import show
from clrt.base.places import At, known_keys, listed
from clrt.base.records import Record
from clrt.base.suggest import did_you_mean

Step = str | int
Numbers = dict[str | None, set[int]]  # of shapes, by their names

_STEP: Final = re.compile(r'(?:^|\.)(?:"(?P<quoted>[^"]*)"|(?P<key>[^.\[\]"]+))|\[(?P<index>[0-9]{1,9})\]')
_FORM: Final = 'a place in a scene is written like camera.fov, materials."my glass".ior or shapes[3].center'


class Draft:
    """A scene's changed fields, not yet checked: `values` by name.

    Of `materials`, `lights` and `shapes` what is not `touched` (names or numbers, by field; absent where the
    whole field is new) are the very objects of the scene before.
    """

    def __init__(
        self, scene: Any, changes: Mapping[str, Any], fields: Sequence[str], ready: Callable[..., Any]
    ) -> None:
        """ready: `unfiled.made_ready`."""
        self._scene, self._ready = scene, ready
        self.values: dict[str, Any] = {}
        self.touched: dict[str, set[Step]] = {}
        self._copied: set[str] = set()  # of `values`: what was given stays as it is, and each is copied once
        self._numbers: dict[str, Numbers] = {}  # of `values`, once one is looked up by its name
        for path, value in changes.items():
            at = At(scene.source)
            (top, *rest) = steps_of(path, at)
            known_keys({top: None}, fields, at)
            old = self.values.get(str(top), getattr(scene, str(top)))
            if old is None and top == "adaptive":  # of whose keys none has to be stated
                old = {}
            if not rest:
                self.values[str(top)] = value
                self.touched.pop(str(top), None)
                self._copied.discard(str(top))
                self._numbers.pop(str(top), None)
            elif top in ("materials", "lights", "shapes"):
                self._edit_one_of(str(top), old, rest, value, at.key(str(top)))
            else:
                record = getattr(scene, str(top))
                if isinstance(record, Record) and isinstance(old, (Record, Mapping)):
                    known_keys({rest[0]: None}, record.__struct_fields__, at.key(str(top)))
                    old = kept(old, type(record), (str(rest[0]),))
                self.values[str(top)] = _changed(old, rest, value, at.key(str(top)))

    def _edit_one_of(self, top: str, old: Any, steps: Sequence[Step], value: Any, at: At) -> None:
        """Change a part of one of many, or put another in its place."""
        whole = top in self.values and top not in self.touched
        number, *rest = steps
        if not isinstance(old, (Mapping, list, tuple)):  # what was given for all of them
            raise at.says(f"{show(old)} has no part {show(str(number))}")
        if top not in self._copied:
            old = dict(old) if isinstance(old, Mapping) else list(old)
            self.values[top] = old
            self._copied.add(top)
        if not isinstance(old, Mapping) and isinstance(number, str):
            if top not in self._numbers:
                self._numbers[top] = _numbers_of(old)
            number = _named(old, self._numbers[top], number, at)
        present = number in old if isinstance(old, Mapping) else number < len(old)  # type: ignore[operator]
        if not present and not (isinstance(old, Mapping) and not rest and isinstance(number, str)):
            raise at.says(_absent(old, number))
        place = at.item(number) if isinstance(number, int) else at.key(number)
        one = old[number] if present else None
        if top == "shapes" and present and rest:
            before = None if whole else self._scene.shapes[number]
            one = self._ready(self._scene, before, one, rest[0], ... if rest[1:] else value, place)
        new = _changed(one, rest, value, place)
        if top in self._numbers:
            self._numbers[top][_name_of(old[number])].discard(number)
            self._numbers[top].setdefault(_name_of(new), set()).add(number)  # type: ignore[arg-type]
        old[number] = new
        if not whole:
            self.touched.setdefault(top, set()).add(number)


def places(scene: Any, paths: Iterable[str]) -> dict[str, tuple[Step, ...]]:
    """The steps of each path, the same however a place is written: a shape's name is its number."""
    found: dict[str, tuple[Step, ...]] = {}
    numbers: Numbers = {}
    for path in paths:
        top, *rest = steps_of(path, At(scene.source))
        if top == "shapes" and rest and isinstance(rest[0], str):
            numbers = numbers or _numbers_of(scene.shapes)
            rest[0] = _named(scene.shapes, numbers, rest[0], At(scene.source).key("shapes"))
        found[path] = (top, *rest)
    return found


def steps_of(path: str, at: At) -> list[Step]:
    """The keys and numbers of a path; the first is a key."""
    steps: list[Step] = []
    position = 0
    while position < len(path):
        found = _STEP.match(path, position)
        if found is None or (not steps and found["index"]):
            break
        key = found["quoted"] if found["key"] is None else found["key"].strip()
        steps.append(int(found["index"]) if found["index"] else key)
        position = found.end()
    if position < len(path) or not steps:
        raise at.says(f"{show(path)} names no place; {_FORM}")
    return steps


def _changed(old: Any, steps: Sequence[Step], value: Any, at: At) -> Any:
    """What stands at a place with something in it changed: records become tables, tuples lists."""
    if not steps:
        return value
    step, *rest = steps
    if isinstance(old, Record):
        old = fields_of(old)
        known_keys({step: None}, old, at)
    if isinstance(old, Mapping) and isinstance(step, str):
        if step not in old and rest:
            raise at.says(_absent(old, step))
        return {**old, step: _changed(old.get(step), rest, value, at.key(step))}
    if isinstance(old, (tuple, list, np.ndarray)) and isinstance(step, int):
        if step >= len(old):
            raise at.says(_absent(old, step))
        before = old[step].tolist() if isinstance(old, np.ndarray) else old[step]
        part = _changed(before, rest, value, at.item(step))
        new = old.copy() if isinstance(old, np.ndarray) and _is_like(part, before) else [*old]
        new[step] = part
        return new
    if old is None:
        raise at.says(f"there is none whose {show(str(step))} could be set; give it whole")
    raise at.says(f"{show(old)} has no part {show(str(step))}")


def _is_like(part: Any, before: Any) -> bool:
    """Whether numpy puts this in another's place as it is: it makes of most things what they are not."""
    if isinstance(before, list):
        same = isinstance(part, (list, tuple)) and len(part) == len(before)
        return same and all(map(_is_like, part, before))
    whole = type(part) is int and -(1 << 31) <= part < 1 << 31
    return whole or (isinstance(before, float) and type(part) is float)


def fields_of(record: Record) -> dict[str, Any]:
    """A record as the table that it could be read from, its values as they are."""
    table = {"type": record.type} if record.__struct_config__.tag else {}
    return table | {name: record.stated(name) for name in record.__struct_fields__}


def kept(old: Record | Mapping[str, Any] | None, kind: type[Record], said: Iterable[str]) -> dict[str, Any]:
    """What a record of this kind, or its table, still states where the fields `said` are stated anew."""
    if old is None:
        return {}
    table = fields_of(old) if isinstance(old, Record) else old
    others = {other for name in said for other in kind.instead_of(name, table)}
    return {name: value for name, value in table.items() if value is not None and name not in others}


def _name_of(shape: Any) -> str | None:
    name = shape.get("name") if isinstance(shape, Mapping) else getattr(shape, "name", None)
    return name if isinstance(name, str) else None


def _numbers_of(shapes: Sequence[Any]) -> Numbers:
    found: Numbers = {}
    for number, shape in enumerate(shapes):
        found.setdefault(_name_of(shape), set()).add(number)
    return found


def _named(shapes: Sequence[Any], numbers: Numbers, name: str, at: At) -> int:
    """The number of the one shape of that name."""
    found = numbers.get(name, set())
    if len(found) != 1:
        known = [*_texts(map(_name_of, shapes))]
        many = f"{len(found)} shapes have that name; say which by its number"
        none = f"no shape has the name {show(name)}{did_you_mean(name, known)}"
        if at.path == "lights":
            raise at.says("lights have no names; they are numbered from 0: lights[0]")
        raise at.says(many if found else f"{none}; shapes are numbered from 0: shapes[0]")
    return next(iter(found))


def _texts(names: Iterable[Any]) -> Iterator[str]:
    return (name for name in names if isinstance(name, str))


def _absent(old: Any, step: Step) -> str:
    """That there is nothing at a step."""
    if isinstance(old, Mapping):
        known = [*_texts([*old])]
        hint = did_you_mean(step, known) or (f" (there is {listed(known)})" if known else "")
        return f"there is no {show(str(step))}{hint}"
    if isinstance(step, int):
        there = f"; there are {len(old)}, numbered from 0" if len(old) else ""
        return f"there is no number {step}{there}"
    return f"{show(step)} is no number of one of {len(old)}"
