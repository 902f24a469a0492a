"""What surfaces are made of: coefficients, tints and indices, as a scene states them."""

from __future__ import annotations

from operator import attrgetter
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import numpy as np
from msgspec import Meta

from clrt.base.hints import Rows
from clrt.base.places import At, listed
from clrt.base.records import Record
from clrt.base.suggest import did_you_mean
from clrt.scene.textures import PICTURED, ImageTexture, NormalMap, Placement
from clrt.spectra.colors import Color, Colored, CurveColor, LightColor, check_color, full
from clrt.spectra.curves import D_LINE, VISIBLE, ior_at
from clrt.spectra.indices import GLASSES, INDEX, IOR, LEAST, MOST, Dispersion, Ior, Metal, check_conductor
from clrt.spectra.spectrum import Spectrum, check_points

__all__ = ["IOR", "Checker", "ImageTexture", "Material", "NormalMap", "Placement", "rgb"]

SMOOTHEST: Final = 0.01  # roughness below which a mirror is a perfect one
_COLOR: Final = (
    "color must be a number >= 0, 3 numbers >= 0, spectrum, {type = 'image', ...} or {type = 'checker', ...}"
)
_TINT: Final = "must be a number >= 0, 3 numbers >= 0, spectrum or {type = 'image', ...}"
Tint = Annotated[ImageTexture | Color, Meta(description=_TINT)]
Glow = Annotated[ImageTexture | LightColor, Meta(description=_TINT)]
if TYPE_CHECKING:
    Squares = Rows
    Bumps = NormalMap | Any
else:
    Squares = Annotated[tuple[Color, Color], Meta(description="colors must be 2 colours")]
    Bumps = Annotated[NormalMap, Meta(description="must be a table such as {file = 'bumps.png'}")]
_MAY_BE: Final = (*PICTURED, "normal_map")
_values: Final = attrgetter(*_MAY_BE)
_PICTURES: Final = {ImageTexture, NormalMap}
Coefficient = Annotated[float, Meta(ge=0, description="must be a number >= 0")]


def rgb(color: Color) -> tuple[float, float, float]:
    """A plain colour as three linear Rec.709 numbers; a single number is a grey. Spectra: `spectra.bands`."""
    assert not isinstance(color, (str, Spectrum)), "what a spectrum's colour is depends on its place"
    if isinstance(color, (int, float)):
        return (float(color),) * 3
    red, green, blue = color
    return float(red), float(green), float(blue)


class Checker(Record, frozen=True, kw_only=True, tag="checker", tag_field="type"):
    """Squares of two colours: of edge `size` on flat shapes, `divisions` of them around a sphere."""

    colors: Squares = (0.9, 0.1)
    size: Annotated[float, Meta(gt=0, description="must be a length > 0")] = 1.0
    divisions: Annotated[
        int, Meta(ge=1, le=1 << 16, description="must be a whole number from 1 to 65536")
    ] = 16

    @classmethod
    def prepared(cls, table: dict[str, Any]) -> dict[str, Any]:
        """`table` with every spectrum in its full form."""
        colors = table.get("colors")
        if isinstance(colors, (list, tuple)):
            table = table | {"colors": [full(color) for color in colors]}
        return super().prepared(table)

    def check(self, at: At) -> None:
        for index, color in enumerate(self.colors):
            check_color(color, "reflectance", at.key("colors").item(index))


def check_ior(ior: Ior, at: At) -> None:
    """Raise for an unknown name, or an index not from `LEAST` to `MOST` at every visible wavelength."""
    if isinstance(ior, str):
        names = (*IOR, *GLASSES)
        if ior not in names:
            text = f"ior must be {INDEX} or one of {listed(names)}{did_you_mean(ior, names)}"
            raise at.error(ior, text)
    elif isinstance(ior, tuple):
        check_points(ior, at, LEAST, MOST)
    elif isinstance(ior, Dispersion):
        ior.check(at)
        values = ior_at(ior, VISIBLE)
        good = (values >= LEAST) & (values <= MOST)
        if not good.all():
            worst = int(good.argmin())
            raise at.error(float(values[worst]), f"the index at {VISIBLE[worst]:g} nm must be {INDEX}")
    elif not LEAST <= ior <= MOST:
        raise at.error(ior, f"ior must be {INDEX} or one of {listed((*IOR, *GLASSES))}")


class Material(Colored, frozen=True, kw_only=True):
    """Coefficients, tints and the index of refraction of a surface.

    `ambient`, `reflection` and `transmission` are None where they are not given; `ka`, `kr`, `kt` are the
    numbers that then hold. Colours are linear Rec.709, a single number is a grey. `absorption` is the share
    of light lost in the medium per unit of length, as the logarithm of what passes; where media overlap, the
    one of the highest `priority` is there.
    """

    color: Annotated[Checker | ImageTexture | Color, Meta(description=_COLOR)] = 0.8
    ambient: Coefficient | None = None
    diffuse: Coefficient = 1.0
    specular: Coefficient = 0.0
    shininess: Coefficient = 32.0
    reflection: Coefficient | None = None
    transmission: Coefficient | None = None
    ior: Ior = 1.5
    fresnel: Annotated[
        bool | Literal["schlick"], Meta(description="fresnel must be true, false or 'schlick'")
    ] = False
    highlight_color: Tint = 1.0
    reflection_color: Tint = 1.0
    transmission_color: Tint = 1.0
    emission: Glow = 0.0
    absorption: CurveColor = 0.0
    priority: Annotated[
        int,
        Meta(ge=-(1 << 15), lt=1 << 15, description="priority must be a whole number from -32768 to 32767"),
    ] = 0
    thin: bool = False
    conductor: Metal | None = None
    roughness: Annotated[float, Meta(ge=0, le=1, description="must be a number from 0 to 1")] = 0.0
    normal_map: Bumps | None = None

    def check(self, at: At) -> None:
        Colored.check(self, at)
        if isinstance(self.color, Checker):
            self.color.check(at.key("color"))
        for name, picture in self.pictures.items():
            picture.check(at.key(name))
        check_ior(self.ior, at.key("ior"))
        if self.conductor is not None:
            check_conductor(self.conductor, at.key("conductor"))
            if self.kt > 0:
                raise at.key("transmission").error(self.transmission, "a conductor transmits nothing; use 0")
            if self.fresnel == "schlick":
                raise at.key("fresnel").error("schlick", "a conductor has its own Fresnel reflection")

        if self.roughness > 0 and self.kt > 0:
            text = "what is rough transmits nothing; use transmission = 0, or roughness = 0"
            raise at.key("roughness").error(self.roughness, text)

    @property
    def ka(self) -> float:
        """Ambient coefficient: `ambient`, or `diffuse` where that is not given."""
        return self.diffuse if self.ambient is None else self.ambient

    @property
    def kr(self) -> float:
        """Mirror coefficient: `reflection`; where not given 1 with Fresnel or a conductor, else 0."""
        given = self.fresnel is True or self.conductor is not None
        return float(given) if self.reflection is None else self.reflection

    @property
    def kt(self) -> float:
        """Transmission coefficient: `transmission`; where not given 1 with `fresnel = true`, else 0.

        A conductor's is 0.
        """
        given = self.fresnel is True and self.conductor is None
        return float(given) if self.transmission is None else self.transmission

    @property
    def pictures(self) -> dict[str, ImageTexture | NormalMap]:
        """The fields that are pictures, by name."""
        values = _values(self)
        if _PICTURES.isdisjoint(map(type, values)):  # as in most of many materials
            return {}
        return {name: value for name, value in zip(_MAY_BE, values, strict=True) if type(value) in _PICTURES}

    @property
    def alpha(self) -> float:
        """Width of the lobe of a rough mirror, `roughness` squared; 0 where it is too smooth to differ."""
        return self.roughness**2 if self.roughness >= SMOOTHEST and self.kr > 0 else 0.0

    @property
    def dispersive(self) -> bool:
        """Whether the index of refraction depends on the wavelength."""
        return not isinstance(self.ior, (int, float)) and self.ior not in IOR

    @property
    def ior_d(self) -> float:
        """Index of refraction as a number: of a dispersive glass that at helium's d line, 587.56 nm."""
        return float(ior_at(self.ior, np.array(D_LINE)))

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

    @property
    def returned(self) -> float:
        """`gain` as it is judged: of a mirror given by a tint what it returns of light that falls head-on.

        Its highlight counts with the light of the whole lobe, 2/(shininess + 1) of its peak.
        """
        if self.fresnel != "schlick":
            return self.gain
        highlight, mirror = map(_most, (self.highlight_color, self.reflection_color))
        lobe = min(2 / (self.shininess + 1), 1.0)
        return self.diffuse + max(self.specular * lobe * highlight, self.kr * mirror) + self.kt


def _most(tint: Tint) -> float:
    """The largest part of a tint; 1 of spectra and pictures, of which it is not known here."""
    return 1.0 if isinstance(tint, (str, Spectrum, ImageTexture)) else max(rgb(tint))
