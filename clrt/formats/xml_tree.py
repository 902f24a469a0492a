"""XML as a tree of elements: no document types, so no entities of a file's own, and within `Limits`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final
from xml.parsers import expat

from clrt.base.errors import SceneError, located, show
from clrt.base.limits import Limits
from clrt.base.places import listed
from clrt.base.suggest import did_you_mean

_PARAMETER: Final = re.compile(r"\$(\w+)")
_ENCODINGS: Final = ("utf-8", "utf8", "us-ascii", "ascii")
_NONE: Final[list[Element]] = []
LONGEST: Final = 4096  # letters of an attribute whose parameters are filled in
MOST: Final = 1 << 24  # letters that parameters add to all attributes of a scene


class Element:
    """A tag with its attributes, what it holds, and where it stands.

    `understood` is set of an object whose kind has a counterpart here, `asked` of one that what holds it has
    asked for: what stands in the first and is not the second is lost, and so is named.
    """

    __slots__ = ("asked", "children", "keys", "line", "source", "tag", "understood")

    def __init__(self, tag: str, keys: dict[str, str], line: int, source: str) -> None:
        self.tag, self.keys, self.line, self.source = tag, keys, line, source
        self.children: list[Element] = _NONE  # most elements are empty, and there may be millions
        self.asked = self.understood = False

    @property
    def name(self) -> str:
        """What the element calls itself: its name, else its tag."""
        return self.keys.get("name", self.tag)

    def says(self, text: str) -> SceneError:
        """An error at the element's line."""
        return SceneError(located(f"{self.source}:{self.line}", "", text))

    def get(self, key: str) -> str:
        """An attribute; SceneError where it is missing."""
        if key not in self.keys:
            raise self.says(f'<{self.tag}> needs {key}="..."')
        return self.keys[key]

    def walk(self) -> Iterator[Element]:
        """The element, and all below it, in their order."""
        yield self
        for child in self.children:
            yield from child.walk()


def unknown(element: Element, what: str, value: str, known: list[str]) -> SceneError:
    """The error for a word that is none of those known here."""
    near, here = did_you_mean(value, known), f"known here: {listed(known)}" if known else "there is none"
    return element.says(f"there is no {what} {show(value)}{near} ({here})")


def parse(data: bytes, limits: Limits, source: str) -> tuple[Element, dict[str, str]]:
    """The root of a document, and its processing instructions by their target.

    SceneError for what is no XML, for a document type (which could declare entities) and for text between
    the tags; LimitError for elements nested deeper than `limits.nesting`, or more than `limits.primitives`.
    """
    top = Element("", {}, 0, source)
    stack, count = [top], 0
    notes: dict[str, str] = {}

    def start(tag: str, keys: dict[str, str]) -> None:
        nonlocal count
        count += 1
        limits.check("nesting", len(stack), source)
        limits.check("primitives", count, source)
        element, above = Element(tag, keys, parser.CurrentLineNumber, source), stack[-1]
        if above.children is _NONE:
            above.children = []
        above.children.append(element)
        stack.append(element)

    def end(tag: str) -> None:
        stack.pop()

    def text(words: str) -> None:
        if words.strip():
            here = Element("", {}, parser.CurrentLineNumber, source)
            raise here.says(f"the text {show(words.strip())} belongs to no value; write value='...'")

    def doctype(*_: object) -> None:
        here = Element("", {}, parser.CurrentLineNumber, source)
        raise here.says("a document type (<!DOCTYPE ...>) is not allowed: it could name other files")

    def note(target: str, words: str) -> None:
        notes.setdefault(target, words)

    def declaration(version: str, encoding: str | None, standalone: int) -> None:
        if encoding is not None and encoding.lower() not in _ENCODINGS:
            here = Element("", {}, parser.CurrentLineNumber, source)
            raise here.says(f"the encoding {show(encoding)} is not read; save the file as UTF-8")

    parser = expat.ParserCreate("utf-8")
    parser.XmlDeclHandler = declaration
    parser.buffer_text = True
    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler, parser.ProcessingInstructionHandler = text, note
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        broken = Element("", {}, error.lineno, source)
        raise broken.says(f"wrong syntax: {expat.ErrorString(error.code)}") from None
    (root,) = top.children
    return root, notes


def filled(element: Element, parameters: dict[str, str]) -> int:
    """Put parameters in place of each `$name` in the element's attributes; how many letters that adds.

    SceneError for unknown ones.
    """
    added = 0

    def value_of(found: re.Match[str]) -> str:
        if found[1] not in parameters:
            text = f"{show(found[0])} stands for nothing{did_you_mean(found[1], parameters)}"
            raise element.says(f'{text}; give it a <default name="..." value="..."/> before')
        return parameters[found[1]]

    for key, value in element.keys.items():
        if "$" in value:
            element.keys[key] = _PARAMETER.sub(value_of, value)
            if len(element.keys[key]) > LONGEST:  # a parameter may hold others, twice each
                raise element.says(f"{key} is longer than {LONGEST} letters with its parameters filled in")
            added += max(len(element.keys[key]) - len(value), 0)
    return added
