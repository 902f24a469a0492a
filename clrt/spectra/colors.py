"""Fields of records that hold colours or spectra: how they are written, read and checked."""

from __future__ import annotations

import typing
from functools import cache
from types import UnionType
from typing import TYPE_CHECKING, Annotated, Any, Union

import msgspec
from msgspec import Meta

from clrt.base.errors import show
from clrt.base.explain import field_types, records_in
from clrt.base.places import At, listed
from clrt.base.records import Record
from clrt.base.suggest import did_you_mean
from clrt.spectra.spectrum import LAMPS, REFLECTANCES, Spectrum

Grey = Annotated[float, Meta(ge=0)]
RGB = tuple[Grey, Grey, Grey]
_RULES = {
    "reflectance": "a colour must be a number >= 0 or 3 numbers >= 0, a reflectance's name or a spectrum",
    "light": "a colour must be a number >= 0 or 3 numbers >= 0, a light's name or a spectrum",
    "background": "background must be a colour, a light's name, a spectrum or the path of a lat-long image",
    "curve": "must be a number >= 0 or 3 numbers >= 0 or a spectrum without a name",
}
_OTHERS = {"type", "file", "colors"}  # keys of tables that are no spectra, or say that they are
_NAMES = {"reflectance": REFLECTANCES, "light": LAMPS, "background": LAMPS, "curve": ()}
# A range on the single number would belong here, but msgspec 0.22 crashes on a ranged float beside a tuple
# of fixed length; `check_color` holds the rule instead. The rule tells fields of colours from others.
if TYPE_CHECKING:
    Color = float | RGB | str | Spectrum | Any
else:
    Color = Annotated[float | RGB | str | Spectrum, Meta(description=_RULES["reflectance"])]
if TYPE_CHECKING:
    Background = float | RGB | str | Spectrum | Any
else:
    Background = Annotated[float | RGB | str | Spectrum, Meta(description=_RULES["background"])]
if TYPE_CHECKING:
    LightColor = float | RGB | str | Spectrum | Any
else:
    LightColor = Annotated[float | RGB | str | Spectrum, Meta(description=_RULES["light"])]
if TYPE_CHECKING:
    CurveColor = float | RGB | Spectrum | Any
else:
    CurveColor = Annotated[float | RGB | Spectrum, Meta(description=_RULES["curve"])]


class Colored(Record, frozen=True, kw_only=True):
    """A record with fields of the types above."""

    @classmethod
    def prepared(cls, table: dict[str, Any]) -> dict[str, Any]:
        """`table` with every spectrum in its full form."""
        named = {name: full(table[name]) for name in color_fields(cls) if name in table}
        return super().prepared(table | named)

    def check(self, at: At) -> None:
        """Raise for what a colour's annotation cannot say."""
        for name, kind in color_fields(self.__class__).items():
            color = getattr(self, name)
            right = color >= 0 if type(color) is float else type(color) is tuple  # which most are
            if not right:
                check_color(color, kind, at.key(name), pictured=name in _pictured(self.__class__))


@cache
def color_fields(cls: type[msgspec.Struct]) -> dict[str, str]:
    """The fields that hold colours, each with its kind: "reflectance", "light" or "curve" (a plain one)."""
    kinds = {name: _kind(hint) for name, hint in field_types(cls).items()}
    return {name: kind for name, kind in kinds.items() if kind}


@cache
def _pictured(cls: type[msgspec.Struct]) -> frozenset[str]:
    """The fields that may be pictures instead: records that name a file."""
    fields = field_types(cls).items()
    return frozenset(
        name for name, hint in fields if any("file" in kind.__struct_fields__ for kind in records_in(hint))
    )


def _kind(hint: Any) -> str:
    if typing.get_origin(hint) is Annotated:
        rules = [meta.description for meta in hint.__metadata__ if isinstance(meta, Meta)]
        found = next((kind for kind, rule in _RULES.items() if rule in rules), "")
        return found or _kind(hint.__origin__)
    if typing.get_origin(hint) in (Union, UnionType):
        return next(filter(None, map(_kind, typing.get_args(hint))), "")
    return ""


def full(value: Any) -> Any:
    """A spectrum's table with its type; (nm, value) pairs as such a table."""
    if isinstance(value, dict):
        return {"type": "spectrum", **value} if _OTHERS.isdisjoint(value) else value
    if isinstance(value, (list, tuple)) and value and all(isinstance(pair, (list, tuple)) for pair in value):
        return {"type": "spectrum", "samples": value}
    return value


def check_color(color: object, kind: str, at: At, pictured: bool = False) -> None:
    """Raise for a grey below 0 (3 numbers are checked by their annotation), a wrong name or spectrum.

    `pictured`: a picture may stand there, too.
    """
    if isinstance(color, (int, float)) and not color >= 0:
        raise at.error(color, "a colour must be a number >= 0 or 3 numbers >= 0")
    if isinstance(color, Spectrum):
        color.check(at)
        if color.blackbody is not None and kind in ("reflectance", "curve"):
            right = "a light, whose radiance has no part in 1; give a curve: {samples = [[nm, value], ...]}"
            raise at.key("blackbody").error(color.blackbody, f"this is {right}")
        color, at = color.name, at.key("name")
    elif kind == "background":
        return  # an unknown name is a file's
    if isinstance(color, str) and color not in _NAMES[kind]:
        picture = f"; a picture is {{type = 'image', file = {show(color)}}}" if "." in color else ""
        raise at.error(color, _right_name(color, kind) + (picture if pictured else ""))


def _right_name(name: str, kind: str) -> str:
    known = _NAMES[kind]
    if not known:
        return "a plain curve has no name; give a number, 3 numbers, or [nm, value] pairs"
    other = next((k for k, names in _NAMES.items() if k != kind and name in names), None)
    is_other = f"this is a {other}, and here stands a {kind}, which" if other else f"a {kind}'s name"
    shown = listed([n for n in known if not n.startswith("patch-")]) + (
        ", patch-1 to patch-24" if kind == "reflectance" else ""
    )
    return f"{is_other} is one of {shown}{did_you_mean(name, known)}"
