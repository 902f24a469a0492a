"""Values in Mitsuba's XML: numbers, vectors, colours, transforms; and who asks for which."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from clrt.base import notices
from clrt.base.errors import decimal, fault, show
from clrt.formats.mitsuba.spectra import SPECTRA, closed, flat
from clrt.formats.xml_tree import Element, unknown

Rgb = tuple[float, float, float]
Array = np.ndarray
VALUES: Final = (
    "float", "integer", "boolean", "string", "rgb", "srgb", "spectrum", "blackbody", "point", "vector",
    "transform",
)  # fmt: skip
OBJECTS: Final = (
    "integrator", "sensor", "film", "rfilter", "sampler", "shape", "bsdf", "emitter", "texture", "medium",
    "phase", "volume", "ref",
)  # fmt: skip
UNIT: Final[Array] = np.eye(4)
"""The transform of what states none: itself, so that nobody need compare."""
UNIT.flags.writeable = False
_ROUNDED: Final = 1e-3  # by which a unit axis of few digits may be off
_CAMEL: Final = re.compile(r"(?<=[a-z])(?=[A-Z])")
_HEX: Final = re.compile(r"\s*#[0-9a-fA-F]{6}\s*")
_BOOLEAN: Final = {"true": True, "false": False}


@dataclass(eq=False)
class Plugin:
    """An object of the file: its `type`, its values by name, the objects within it, and what asked for them.

    Names are those of Mitsuba 3; those of its first version (`toWorld`) become these.
    """

    element: Element
    type: str
    values: dict[str, Element] = field(default_factory=dict)
    objects: list[Element] = field(default_factory=list)
    _matrices: dict[str, Array] = field(default_factory=dict)

    @classmethod
    def of(cls, element: Element) -> Plugin:
        """The object that an element describes."""
        plugin = cls(element, element.get("type"))
        for child in element.children:
            if child.tag in VALUES:
                before = plugin.values.setdefault(snake(child.get("name")), child)
                if before is not child:
                    raise child.says(f"{child.name} stands twice, first in line {before.line}; leave one out")
            elif child.tag in OBJECTS:
                plugin.objects.append(child)
            elif child.tag != "default":
                raise unknown(child, "element", child.tag, [*VALUES, *OBJECTS])
        return plugin

    def number(self, name: str, default: float) -> float:
        """A float or an integer."""
        element = self.values.get(name)
        return default if element is None else _number(element, element.get("value"))

    def whole(self, name: str, default: int, least: int) -> int:
        """A whole number, at least `least`."""
        value = self.number(name, default)
        if value != math.floor(value) or value < least:
            raise self.values[name].says(fault("", name, value, f"it must be a whole number >= {least}"))
        return int(value)

    def flag(self, name: str, default: bool) -> bool:
        """A boolean."""
        element = self.values.get(name)
        if element is None:
            return default
        value = element.get("value").strip().lower()
        if value not in _BOOLEAN:
            raise element.says(fault("", name, value, "it must be true or false"))
        return _BOOLEAN[value]

    def text(self, name: str, default: str) -> str:
        """A text."""
        element = self.values.get(name)
        return default if element is None else element.get("value").strip()

    def one_of(self, name: str, default: str, known: dict[str, str]) -> str:
        """What a word stands for."""
        word = self.text(name, default)
        if word not in known:
            raise unknown(self.values[name], name.replace("_", " "), word, [*known])
        return known[word]

    def vector(self, name: str, default: Rgb) -> Rgb:
        """A point or a vector."""
        element = self.values.get(name)
        return default if element is None else vector(element, 0.0)

    def color(self, name: str, default: float) -> Any:
        """A colour as scene files have it: a number, three, or [nm, value] pairs."""
        element = self.values.get(name)
        for child in () if element is not None else self.objects:
            if snake(child.keys.get("name", "")) == name and child.keys.get("type") in SPECTRA:
                child.asked, element = True, child
        return default if element is None else color(element, name)

    def numbers(self, name: str) -> list[float]:
        """Numbers with commas or spaces between, one at least; SceneError where there are none."""
        element = self.values.get(name)
        if element is None:
            raise self.element.says(f"the {self.element.tag} {self.type} needs its {name}")
        words = element.get("value").replace(",", " ").split()
        return numbers(element, element.get("value"), max(len(words), 1))

    def to_world(self, name: str = "to_world") -> Array:
        """The transform of that name, (4, 4) float64."""
        if name not in self.values:
            return UNIT
        if name not in self._matrices:
            self._matrices[name] = transform(self.values[name])
        return self._matrices[name]


def snake(name: str) -> str:
    """A name as Mitsuba 3 writes it: `toWorld` is `to_world`."""
    return _CAMEL.sub("_", name).lower()


def _number(element: Element, text: str) -> float:
    try:
        value = decimal(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise element.says(fault("", element.name, text, "it must be a number"))
    return value


def numbers(element: Element, text: str, *counts: int) -> list[float]:
    """Numbers, with commas or spaces between, as many as one of `counts`."""
    words = text.replace(",", " ").split()
    if len(words) not in counts:
        many = " or ".join(map(str, counts))
        raise element.says(fault("", element.name, text, f"it must be {many} numbers, not {len(words)}"))
    return [_number(element, word) for word in words]


def vector(element: Element, default: float) -> Rgb:
    """x, y, z, or a value of three numbers or one."""
    if "value" in element.keys:
        found = numbers(element, element.keys["value"], 1, 3)
        x, y, z = found * 3 if len(found) == 1 else found
        return x, y, z
    for key in element.keys:
        if key not in ("x", "y", "z", "name", "angle"):
            raise unknown(element, "part of a vector called", key, ["x", "y", "z", "value"])
    x, y, z = (_number(element, element.keys.get(key, str(default))) for key in "xyz")
    return x, y, z


_OF_LIGHT: Final = ("radiance", "intensity", "irradiance")


def color(element: Element, name: str = "") -> Any:
    """A colour as scene files have it. name: of the value that it is, if not the element's own."""
    of_light = (name or snake(element.keys.get("name", ""))) in _OF_LIGHT
    if element.tag == "blackbody" or (element.tag == "spectrum" and "filename" in element.keys):
        kind = "a blackbody of the first version" if element.tag == "blackbody" else "a spectrum from a file"
        raise element.says(f'{element.name}: {kind} is not read; write <spectrum value="400:0.1, 700:0.2"/>')
    if "type" in element.keys:
        return _spectrum(element, of_light)
    text = element.get("value")
    if _HEX.fullmatch(text) and element.tag in ("rgb", "srgb"):
        return _decoded(element, [part / 255 for part in bytes.fromhex(text.strip()[1:])])
    if element.tag == "spectrum" and ":" in text:
        pairs = [pair.split(":") for pair in text.replace(",", " ").split()]
        return closed([numbers(element, " ".join(pair), 2) for pair in pairs])
    found = numbers(element, text, 1, 3)
    if len(found) > 1 or element.tag == "srgb":
        return _decoded(element, found if len(found) > 1 else found * 3)
    return flat(found[0]) if element.tag == "spectrum" and of_light else found[0]


def _spectrum(element: Element, of_light: bool) -> Any:
    """The colour of a spectrum that is a plugin."""
    plugin = Plugin.of(element)
    if plugin.type not in SPECTRA:
        raise unknown(element, element.tag, plugin.type, [*SPECTRA])
    make, known = SPECTRA[plugin.type]
    for name, value in plugin.values.items():
        if name not in known:
            raise unknown(value, f"value of {element.tag} {show(plugin.type)} called", name, [*known])
    return make(plugin, of_light)


def _decoded(element: Element, parts: list[float]) -> list[float]:
    """The linear colour of three numbers, which an <srgb> has encoded."""
    if element.tag != "srgb":
        return parts
    if not all(0 <= part <= 1 for part in parts):
        raise element.says(fault("", element.name, element.get("value"), "each part must be from 0 to 1"))
    from clrt.images.file import uncurved

    return [float(part) for part in uncurved(np.array(parts))]


def transform(element: Element) -> Array:
    """A transform's steps, the first acting first, as (4, 4) float64."""
    matrix = np.eye(4)
    with np.errstate(all="ignore"):
        for step in element.children:
            name = snake(step.tag)
            if name not in _STEPS:
                raise unknown(step, "step of a transform called", step.tag, [*_STEPS])
            matrix = _STEPS[name](step) @ matrix
    if not np.isfinite(matrix).all():
        raise element.says("the numbers of a transform must not leave the range of float64")
    return matrix


def moved(way: Sequence[float]) -> Array:
    """The matrix that moves by x, y, z."""
    matrix = np.eye(4)
    matrix[:3, 3] = way
    return matrix


def _translated(step: Element) -> Array:
    return moved(vector(step, 0.0))


def _scaled(step: Element) -> Array:
    return np.diag([*vector(step, 1.0), 1.0])


def _rotated(step: Element) -> Array:
    axis, angle = np.array(vector(step, 0.0)), math.radians(_number(step, step.get("angle")))
    length = float(np.linalg.norm(axis))
    if length == 0:
        raise step.says("the axis of a rotation must not be zero")
    if abs(length - 1) > _ROUNDED and angle != 0:
        text = f"a rotation about an axis of length {length:.6g}: Mitsuba 3 shears then; here it turns"
        notices.warn(f"{step.source}:{step.line}", "", text)
    x, y, z = axis / length
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    matrix = np.eye(4)
    matrix[:3, :3] += math.sin(angle) * across + (1 - math.cos(angle)) * across @ across
    return matrix


def _given(step: Element) -> Array:
    found = numbers(step, step.get("value"), 9, 16)
    if len(found) == 16:
        if found[12:] != [0.0, 0.0, 0.0, 1.0]:
            raise step.says("the last row of a matrix must be 0 0 0 1")
        return np.array(found).reshape(4, 4)
    matrix = np.eye(4)
    matrix[:3, :3] = np.array(found).reshape(3, 3)
    return matrix


def looks(step: Element) -> tuple[Rgb, Rgb, Rgb]:
    """Origin, target and up of a <lookat>, which need say no up: then any will do, and Mitsuba's is taken."""
    origin, target = (tuple(numbers(step, step.get(key), 3)) for key in ("origin", "target"))
    up = tuple(numbers(step, step.keys.get("up", "0 0 0"), 3))
    return origin, target, up if any(up) else _beside(origin, target)  # type: ignore[return-value]


def _beside(origin: Sequence[float], target: Sequence[float]) -> tuple[float, ...]:
    """Across the way from one to the other, as Mitsuba has it (Duff et al. 2017, eq. 5)."""
    way = np.subtract(target, origin)
    x, y, z = way / (np.linalg.norm(way) or 1.0)
    sign = math.copysign(1.0, z)
    a = -1 / (sign + z)
    return sign * x * x * a + 1, sign * x * y * a, -sign * x


def _aimed(step: Element) -> Array:
    """Mitsuba's own: z towards the target, x to the left."""
    origin, target, up = (np.array(part) for part in looks(step))
    forward = target - origin
    left = np.cross(up, forward)
    lengths = float(np.linalg.norm(forward)), float(np.linalg.norm(left))
    if 0.0 in lengths:
        raise step.says("the target of a <lookat> must not be at its origin, nor up parallel to its view")
    forward, left = forward / lengths[0], left / lengths[1]
    matrix = np.eye(4)
    matrix[:3] = np.stack([left, np.cross(forward, left), forward, origin], axis=1)
    return matrix


_STEPS: Final = {
    "translate": _translated, "scale": _scaled, "rotate": _rotated, "matrix": _given,
    "lookat": _aimed, "look_at": _aimed,
}  # fmt: skip


def rows(matrix: Array) -> list[list[float]]:
    """A matrix as a scene file has it."""
    return [[float(value) for value in row] for row in matrix]
