"""A Mitsuba file before it means anything: its parts in order, includes and parameters in their places."""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from clrt.base.errors import located, show
from clrt.base.files import read_text_bytes, resolve
from clrt.base.limits import Limits, written
from clrt.base.mark import unmarked
from clrt.base.places import At
from clrt.formats.mitsuba.spectra import SPECTRA
from clrt.formats.mitsuba.values import OBJECTS, VALUES, Plugin, snake
from clrt.formats.xml_tree import MOST, Element, filled, parse, unknown

_TREES: Final = ("embree_", "kd_")  # begin the values of a scene itself: how its trees are built
_NOWHERE: Final = ("default", "include", "alias", "path")
_PATHS: Final = 64
_AGAIN: Final = 1 << 18  # points of curves that are taken more than once: 250 bytes each


@dataclass(eq=False)
class Context:
    """What reading a file knows: where it lies, its objects by id, and what has no counterpart here."""

    folder: Path
    source: str
    limits: Limits
    ids: dict[str, Element] = field(default_factory=dict)
    included: dict[Path, int] = field(default_factory=dict)  # the line that names a file
    left_out: dict[str, None] = field(default_factory=dict)
    first_version: bool = False  # a file of Mitsuba's first version
    depths: dict[int, int | None] = field(default_factory=dict)  # of integrators
    filled: int = 0  # letters that parameters have added
    used: set[tuple[str, int]] = field(default_factory=set)
    again: int = 0
    read: int = 0  # bytes of the file and of those that it includes
    paths: list[str] = field(default_factory=list)  # folders, too, in which files may lie

    def file(self, element: Element) -> str:
        """The name of a file that a value names, which lies in the scene's folder."""
        path = self.found(element.get("value"), At(f"{element.source}:{element.line}", element.name))
        return path.relative_to(self.folder.resolve()).as_posix()

    def found(self, name: str, at: At) -> Path:
        """The file of a name, in the first folder of `paths` that has it, else in the scene's."""
        name = name.replace("\\", "/")
        names = (f"{folder}/{name}" for folder in self.paths)
        there = (found for found in names if os.path.isfile(self.folder / found))
        return resolve(next(there, name), self.folder, at)

    def look_in(self, element: Element) -> None:
        """Look for files first in the folder that a <path> names, if it lies in the scene's."""
        name, root = element.get("value").replace("\\", "/"), os.path.realpath(self.folder)
        folder = os.path.realpath(os.path.join(root, name)) if "\0" not in name else ""
        if not (os.path.isdir(folder) and Path(folder).is_relative_to(root)):
            self.left_out[f"the <path> {show(name[:60])}, which is no folder in the scene's"] = None
        elif (inside := os.path.relpath(folder, root)) not in self.paths:
            self.paths.insert(0, inside)
        if len(self.paths) > _PATHS:
            raise element.says(f"more than {_PATHS} folders of <path>; put files together")

    def elements(self, plugin: Plugin, tag: str) -> list[Element]:
        """The objects of kind `tag` within another, or referred to there, as often as they stand."""
        found = [(child, self.referred(child)) for child in plugin.objects]
        for child, element in found:
            child.asked |= element.tag == tag
        return [element for _, element in found if element.tag == tag]

    def first(self, plugin: Plugin, tag: str) -> Element | None:
        """The first object of kind `tag` within another; there should be no more."""
        for child in plugin.objects:
            element = self.referred(child)
            if element.tag == tag:
                child.asked = True
                return element
        return None

    def called(self, plugin: Plugin, name: str) -> Element | None:
        """The object that stands in place of a value of that name, or what it refers to."""
        for child in plugin.objects:
            if snake(child.keys.get("name", "")) == name:
                child.asked = True
                return self.referred(child)
        return None

    def check(self, plugin: Plugin, known: dict[str, str]) -> None:
        """Raise for a value that a plugin has not; what it has, but we have not, is left out.

        known: what each value becomes, "" of those without a counterpart, "0" of those that change nothing
        where they are 0, "-" of those that never do.
        """
        plugin.element.understood = True
        for name, element in plugin.values.items():
            if name not in known:
                what = f"value of {plugin.element.tag} {show(plugin.type)} called"
                self.other(element, what, name, [*known])
            elif known[name] == "" or (known[name] == "0" and element.keys.get("value", "").strip("+-.0")):
                self.left_out[f"{name.replace('_', ' ')} of {plugin.type}"] = None

    def other(self, element: Element, what: str, name: str, known: list[str]) -> None:
        """A name that Mitsuba 3 has not: SceneError, but in files of its first version, which had more."""
        if not self.first_version:
            raise unknown(element, what, name, known)
        self.left_out[f"the {what} {show(name[:40])}"] = None

    def without(self, plugin: Plugin, known: list[str], others: Collection[str]) -> None:
        """Leave out an object of a type that only Mitsuba has: one of `others`, or as in `other`."""
        if plugin.type in others:
            self.left_out[f"the {plugin.element.tag} {plugin.type}"] = None
        else:
            self.other(plugin.element, plugin.element.tag, plugin.type, [*known, *others])

    def lend_spectra(self, plugin: Plugin) -> None:
        """Give a plugin the spectra that it refers to as if they stood there."""
        for child in plugin.objects:
            if child.tag == "ref" and self.referred(child).keys.get("type") in SPECTRA:
                plugin.values.setdefault(snake(child.keys.get("name", "")), self.referred(child))
                child.asked = True

    def lost(self, tops: list[Element]) -> None:
        """Name what nobody asked for in objects that are understood, once all is read."""
        for top in tops:
            for element in top.walk():
                for child in element.children if element.understood else ():
                    if child.tag in OBJECTS and not child.asked:
                        tag = self.referred(child).tag
                        name = child.keys.get("name", "")
                        what = f"the {tag} {show(name[:40])}" if name else f"a further {tag}"
                        self.left_out[f"{what} of {element.get('type')}"] = None

    def take(self, value: Any, use: str, element: Element) -> None:
        """Count the points of the curves in a colour or a material that is put to one `use` more than once:
        each use costs their time, or their memory."""
        for curve in _curves(value):
            if (use, id(curve)) in self.used:
                self.again += len(curve)
            self.used.add((use, id(curve)))
        if self.again > _AGAIN:
            text = f"curves that several refer to have more than {written(_AGAIN)} points, each counted"
            raise element.says(f"{text} as often as it is referred to; give them fewer points")

    def named(self, element: Element, name: str, meant: Element) -> None:
        """Know an object by an id that an element gives it; SceneError where another one has it."""
        other = self.ids.setdefault(name, meant)
        if other is not meant:
            raise element.says(f"the id {show(name)} stands twice, first in line {other.line}; rename one")

    def referred(self, element: Element) -> Element:
        """The element, or what a <ref> refers to."""
        if element.tag != "ref":
            return element
        name = element.get("id")
        if name not in self.ids:
            raise unknown(element, "object with the id", name, [*self.ids])
        return self.ids[name]


def _curves(value: Any) -> Iterator[list[Any]]:
    """The curves in a colour, a texture or a material that have more points than a colour has numbers."""
    if isinstance(value, dict):
        for inner in value.values():
            yield from _curves(inner)
    elif isinstance(value, list):
        if len(value) > 3:
            yield value
        else:
            for inner in value:
                yield from _curves(inner)


def opened(data: bytes, context: Context) -> tuple[list[Element], dict[str, str]]:
    """The objects at the top of a file, includes among them, and its processing instructions."""
    root, notes = parse(unmarked(data), context.limits, context.source)
    if root.tag != "scene":
        raise root.says(f"a Mitsuba file holds a <scene>, not <{root.tag}>")
    version = root.keys.get("version", "3.0.0")
    if not re.fullmatch(r"[0-9]+(\.[0-9]+){2}", version):
        raise root.says(f"version: {show(version)} is not allowed; it must be like 3.0.0")
    context.first_version = int(version.partition(".")[0]) == 0
    parameters: dict[str, str] = {}
    aliases: list[Element] = []
    context.read = len(data)
    tops = [*_objects(root, context, parameters, aliases)]
    for top in tops:
        for element in top.walk():
            if "id" in element.keys and element.tag != "ref":
                context.named(element, element.keys["id"], element)
    for alias in aliases:
        name = alias.get("id")
        if name not in context.ids:
            raise unknown(alias, "object with the id", name, [*context.ids])
        context.named(alias, alias.get("as"), context.ids[name])
    return tops, notes


def _objects(
    root: Element, context: Context, parameters: dict[str, str], aliases: list[Element],
    included: bool = False,
) -> Iterator[Element]:
    """The root's children without those that only say how to read others."""
    for child in root.children:
        for element in child.walk():  # which goes on with the children that are there then
            context.filled += filled(element, parameters)
            if context.filled > MOST:
                raise element.says(f"parameters filled in add more than {written(MOST)} letters; write less")
            if element.tag == "default":
                parameters.setdefault(element.get("name"), element.get("value"))
            if any(inner.tag == "include" for inner in element.children):
                children, element.children = element.children, []
                for inner in children:
                    if inner.tag == "include":
                        context.filled += filled(inner, parameters)
                        beside = _included(inner, context, included)
                        element.children += _objects(beside, context, parameters, aliases, included=True)
                    else:
                        element.children.append(inner)
        if child.tag == "include":
            beside = _included(child, context, included)
            yield from _objects(beside, context, parameters, aliases, included=True)
        elif child.tag == "alias":
            aliases.append(child)
        elif child.tag == "path":
            context.look_in(child)
        elif child.tag in OBJECTS or (child.tag == "spectrum" and "id" in child.keys):
            yield child
        elif child.tag in VALUES and snake(child.get("name")).startswith(_TREES):
            pass
        elif child.tag not in _NOWHERE:
            raise unknown(child, "element", child.tag, [*OBJECTS, *_NOWHERE])


def _included(element: Element, context: Context, included: bool) -> Element:
    """The root of an included file."""
    if included:
        raise element.says("an included file includes no other; name both in the scene's file")
    at = At(f"{element.source}:{element.line}", "filename")
    path = context.found(element.get("filename"), at)
    if path in context.included:  # all of it would stand twice at one place, and few bytes ask for much
        before = context.included[path]
        raise element.says(f"{show(path.name)} is included twice, first in line {before}; leave one out")
    context.included[path] = element.line
    data = read_text_bytes(path, context.limits)
    context.read += len(data)
    context.limits.check("text_bytes", context.read, located(context.source, "", path.name))
    root, _ = parse(unmarked(data), context.limits, path.name)
    if root.tag == "scene":
        return root
    above = Element("scene", {}, root.line, root.source)
    above.children = [root]
    return above
