"""What surfaces are made of: coefficients, tints and indices, as a scene states them."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta

from clrt.places import At, did_you_mean, listed
from clrt.records import Color, Record, check_color

IOR = {"air": 1.0, "water": 1.333, "ice": 1.31, "glass": 1.5, "diamond": 2.419}
"""Indices of refraction by name (at the sodium line)."""

Coefficient = Annotated[float, Meta(ge=0, description="must be a number >= 0")]
Index = Annotated[
    Annotated[float, Meta(gt=0)] | str,
    Meta(description=f"ior must be a number > 0 or one of {listed(IOR)}"),
]


def rgb(color: float | tuple[float, float, float]) -> tuple[float, float, float]:
    """A colour as three linear Rec.709 numbers; a single number is a grey."""
    if isinstance(color, (int, float)):
        return (float(color),) * 3
    red, green, blue = color
    return float(red), float(green), float(blue)


class Checker(Record, frozen=True, kw_only=True, tag="checker", tag_field="type"):
    """Squares of two colours: of edge `size` on flat shapes, `divisions` of them around a sphere."""

    colors: Annotated[tuple[Color, Color], Meta(description="colors must be 2 colours")] = (0.9, 0.1)
    size: Annotated[float, Meta(gt=0, description="must be a length > 0")] = 1.0
    divisions: Annotated[
        int, Meta(ge=1, le=1 << 16, description="must be a whole number from 1 to 65536")
    ] = 16

    def check(self, at: At) -> None:
        for index, color in enumerate(self.colors):
            check_color(color, at.key("colors").item(index))


class Material(Record, frozen=True, kw_only=True):
    """Coefficients, tints and the index of refraction of a surface.

    `ambient`, `reflection` and `transmission` are None where they are not given; `ka`, `kr`, `kt` are the
    numbers that then hold. Colours are linear Rec.709, a single number is a grey. `absorption` is the share
    of light lost in the medium per unit of length, as the logarithm of what passes; where media overlap, the
    one of the highest `priority` is there.
    """

    color: Annotated[
        Color | Checker,
        Meta(description="color must be a number >= 0, 3 numbers >= 0 or {type = 'checker', ...}"),
    ] = 0.8
    ambient: Coefficient | None = None
    diffuse: Coefficient = 1.0
    specular: Coefficient = 0.0
    shininess: Coefficient = 32.0
    reflection: Coefficient | None = None
    transmission: Coefficient | None = None
    ior: Index = 1.5
    fresnel: Annotated[
        bool | Literal["schlick"], Meta(description="fresnel must be true, false or 'schlick'")
    ] = False
    highlight_color: Color = 1.0
    reflection_color: Color = 1.0
    transmission_color: Color = 1.0
    emission: Color = 0.0
    absorption: Color = 0.0
    priority: Annotated[
        int,
        Meta(ge=-(1 << 15), lt=1 << 15, description="priority must be a whole number from -32768 to 32767"),
    ] = 0
    thin: bool = False

    def check(self, at: At) -> None:
        Record.check(self, at)
        if isinstance(self.color, Checker):
            self.color.check(at.key("color"))
        if isinstance(self.ior, str) and self.ior not in IOR:
            raise at.key("ior").error(
                self.ior, f"ior must be a number > 0 or one of {listed(IOR)}{did_you_mean(self.ior, IOR)}"
            )

    @property
    def ka(self) -> float:
        """Ambient coefficient: `ambient`, or `diffuse` where that is not given."""
        return self.diffuse if self.ambient is None else self.ambient

    @property
    def kr(self) -> float:
        """Mirror coefficient: `reflection`; where not given 1 with `fresnel = true`, else 0."""
        return self._fresnel_default if self.reflection is None else self.reflection

    @property
    def kt(self) -> float:
        """Transmission coefficient: `transmission`; where not given 1 with `fresnel = true`, else 0."""
        return self._fresnel_default if self.transmission is None else self.transmission

    @property
    def _fresnel_default(self) -> float:
        return 1.0 if self.fresnel is True else 0.0

    @property
    def eta(self) -> float:
        """Index of refraction as a number."""
        return IOR[self.ior] if isinstance(self.ior, str) else self.ior

    @property
    def is_medium(self) -> bool:
        """Whether rays pass into what the surface encloses."""
        return self.kt > 0 and not self.thin

    @property
    def gain(self) -> float:
        """The largest share of arriving light that one hit can return; above 1 the surface makes light."""
        if self.fresnel is True:  # the Fresnel factor splits between the two, so only the larger counts
            return self.diffuse + max(self.specular, self.kr, self.kt)
        return self.diffuse + max(self.specular, self.kr) + self.kt
