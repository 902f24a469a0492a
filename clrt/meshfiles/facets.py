"""Surfaces of other programs, made of microscopic facets, as materials of a scene.

Base colour, metalness and roughness are those of glTF, of Blender's Principled BSDF and of MTL's `Pm`, `Pr`.
What they become, with the equations, is in docs/models.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Final

Table = dict[str, Any]
Rgb = tuple[float, float, float]

SMOOTHEST: Final = 0.01  # roughness below which a mirror is a perfect one (clrt.scene.materials)
ROUGHEST: Final = 0.5  # roughness from which on the faint mirror of what is no metal is left out
_LEAST_LOBE: Final = 0.05  # of highlights: no smaller alpha, so that a pixel does not miss them
_DARKEST: Final = 1e-6  # of what passes through a medium: 0 would take an infinite absorption
_WHITE: Final = [1.0, 1.0, 1.0]
_UNBENT: Final = 1e-3  # the least index of refraction (clrt.scene.materials)


@dataclass(frozen=True, kw_only=True)
class Facets:
    """A surface: `f0` is what it reflects head-on where it is no metal, `alpha` how much of it is there.

    `weight` is the share of what is reflected where it is no metal, at all angles (glTF's `specularFactor`).
    `transmission` is the share of what is no metal that light passes, `lets` the colour that it lets pass, if
    not `base`; `solid` whether it then enters a medium, of `absorption` per unit of length. `picture` (an
    image of a scene file) multiplies `base`, `glow` the `emission`.
    """

    base: Rgb = (1.0, 1.0, 1.0)
    picture: Table | None = None
    glow: Table | None = None
    normal_map: Table | None = None
    metallic: float = 0.0
    roughness: float = 1.0
    ior: float = 1.5
    f0: Rgb | None = None
    weight: float = 1.0
    alpha: float = 1.0
    transmission: float = 0.0
    lets: Rgb | None = None
    solid: bool = False
    absorption: Rgb = (0.0, 0.0, 0.0)
    emission: Rgb = (0.0, 0.0, 0.0)

    @property
    def passes(self) -> float:
        """The share of light that is transmitted by what is no metal."""
        return self.transmission * (1.0 - self.metallic)

    @property
    def lost(self) -> list[str]:
        """What of it no material here has: what passes is not scattered, and no metal lets light pass."""
        rough, alloyed = self.roughness >= SMOOTHEST, self.metallic > 0
        lost = ["the roughness of glass"] * rough + ["the metal of what is glass, too"] * alloyed
        return lost if self.passes > 0 else []

    def painted(self, color: Rgb) -> Facets:
        """The surface with a base of so many times the colour."""
        red, green, blue = (part * by for part, by in zip(self.base, color, strict=True))
        return replace(self, base=(red, green, blue))

    def table(self) -> Table:
        """The material, as a scene file has it."""
        if self.passes > 0:
            table = self._glass()
        else:
            table = self._surface(self.alpha)
        share = 1.0 if self.passes > 0 else self.alpha
        if any(self.emission) and share > 0:
            table["emission"] = shown(self.glow, _scaled(self.emission, share))
        return table | ({"normal_map": self.normal_map} if self.normal_map is not None else {})

    def _surface(self, share: float) -> Table:
        """What is no glass; a `share` of it is there, and the rest lets light pass as it is."""
        table = self._matte(share)
        strength = share * self._strength()
        if strength > 0 and self._mirrors(share < 1):
            table |= {"reflection": strength, "reflection_color": table["highlight_color"]}
            table |= {"roughness": self.roughness} if self.roughness >= SMOOTHEST else {}
        return table | ({"transmission": 1.0 - share, "thin": True} if share < 1 else {})

    def _mirrors(self, passes: bool) -> bool:
        """Whether it shows what is around it; where light `passes`, no rough mirror is to be had."""
        if passes:
            return self.roughness < SMOOTHEST
        return self.metallic > 0 or self.roughness < ROUGHEST

    def _matte(self, share: float) -> Table:
        """What scatters light, with the highlights of lights; a `share` of it."""
        strength = self._strength() or 1.0
        pairs = zip(self._f0(), self.base, strict=True)
        tint: Any = [_mix(self._weight() * here, base, self.metallic) / strength for here, base in pairs]
        if self.picture is not None and self.metallic > 0:
            red, green, blue = (part * self.metallic / strength for part in self.base)
            tint = shown(self.picture, (red, green, blue))
        specular, shininess = _lobe(self.roughness)
        specular *= self._strength()
        return {
            "color": shown(self.picture, self.base),
            "diffuse": share * self._diffuse(),
            "fresnel": "schlick",
            "specular": share * specular,
            "shininess": shininess,
            "highlight_color": tint,
        }

    def _glass(self) -> Table:
        share = self.passes
        specular, shininess = _lobe(self.roughness)
        table: Table = {
            "color": shown(self.picture, self.base),
            "diffuse": (1.0 - share) * self._diffuse(),
            "fresnel": True,
            "ior": max(self.ior, _UNBENT),
            "reflection": share,
            "transmission": share,
            "transmission_color": shown(self.picture, self.base) if self.lets is None else list(self.lets),
            # in place of the lamp's mirror image
            "specular": min(specular * self._weight() * max(self._f0()), share),
            "shininess": shininess,
        }
        if not self.solid:
            return table | {"thin": True}
        return table | ({"absorption": list(self.absorption)} if any(self.absorption) else {})

    def _f0(self) -> Rgb:
        return (fresnel_of(self.ior),) * 3 if self.f0 is None else self.f0

    def _weight(self) -> float:
        """None of what does not bend light: Schlick's curve would go to 1 there, too."""
        return 0.0 if self.ior == 1.0 and not any(self._f0()) else self.weight

    def _strength(self) -> float:
        """What is reflected of light that grazes it, of all of it."""
        return 1.0 if self._weight() == 1.0 else _mix(self._weight(), 1.0, self.metallic)

    def _diffuse(self) -> float:
        return (1.0 - self.metallic) * (1.0 - self._weight() * max(self._f0()))


def unlit(picture: Table | None, color: Rgb, alpha: float) -> Table:
    """A surface that sends its colour whatever the lights; a share `alpha` of it is there."""
    table: Table = {"color": 0.0, "diffuse": 0.0}
    table |= {"emission": shown(picture, _scaled(color, alpha))} if alpha > 0 else {}
    return table | ({"transmission": 1.0 - alpha, "thin": True} if alpha < 1 else {})


def _scaled(color: Rgb, share: float) -> Rgb:
    red, green, blue = (share * part for part in color)
    return red, green, blue


def shown(picture: Table | None, color: Rgb) -> Any:
    """What stands for a colour: `color`, or the picture times it, and times a tint that the picture has."""
    if picture is None:
        return list(color)
    tint = [part * by for part, by in zip(color, picture.get("tint", _WHITE), strict=True)]
    return picture | ({"tint": tint} if "tint" in picture or tint != _WHITE else {})


def fresnel_of(ior: float) -> float:
    """What a surface reflects head-on, in air; 1 of an index 0, which glTF has for infinity."""
    return ((ior - 1.0) / (ior + 1.0)) ** 2


def absorption_of(color: Rgb, distance: float) -> Rgb:
    """Absorption per unit of length of a medium in which white light has `color` after a `distance` > 0."""
    red, green, blue = (-math.log(min(max(part, _DARKEST), 1.0)) / distance + 0.0 for part in color)
    return red, green, blue


def _lobe(roughness: float) -> tuple[float, float]:
    """Coefficient and exponent of Phong's highlight that is as high and as bright as GGX's, head-on."""
    square = max(roughness * roughness, _LEAST_LOBE) ** 2
    return 0.25 / square, max(1.0, 0.5 / square - 0.5)


def _mix(a: float, b: float, share: float) -> float:
    return a * (1.0 - share) + b * share
