"""Mitsuba's blendbsdf: the sum of two materials, as far as one material of a scene file can be it.

What scatters light adds up. A material sends rays one way, and has one highlight: of two of them the one
that shows more stays, with all that it goes with, and the other is named.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from clrt.meshfiles.facets import fresnel_of
from clrt.spectra.bands import conductor, reflectance
from clrt.spectra.curves import normal_reflectance
from clrt.spectra.spectrum import Spectrum

Table = dict[str, Any]
_RAYS: Final = ("reflection", "reflection_color", "roughness", "conductor", "transmission",
                "transmission_color", "ior", "ext_ior", "thin", "fresnel")  # fmt: skip
_HIGHLIGHT: Final = ("specular", "highlight_color", "shininess")
_SHARED: Final = ("diffuse", "specular", "reflection", "transmission")  # coefficients, which a share scales


def blended(parts: list[tuple[float, Table]], left_out: dict[str, None]) -> Table:
    """The sum of two materials, each with its share; `left_out` gets what of them is not in it."""
    if any(share == 0 for share, _ in parts):
        return max(parts, key=lambda part: part[0])[1]
    maps = [one["normal_map"] for _, one in parts if "normal_map" in one]
    if len(maps) == 1 or any(one != maps[0] for one in maps):
        left_out["that only a part of a blendbsdf has the normal map"] = None
    table: Table = {"diffuse": 0.0} | ({"normal_map": maps[0]} if maps else {})
    scaled = [one | {key: share * one[key] for key in _SHARED if key in one} for share, one in parts]
    matte = [part for part in scaled if part.get("diffuse", 0.0) > 0]
    if matte:
        table |= _sum_of(matte, left_out)
    shown = [part for part in scaled if part.get("specular", 0.0) > 0]
    table |= _strongest(shown, _HIGHLIGHT, [_lit(part) for part in shown], left_out)
    sent = [part for part in scaled if max(part.get("reflection", 0.0), part.get("transmission", 0.0)) > 0]
    table |= _strongest(sent, _RAYS, [_sent(part) for part in sent], left_out)
    if not sent and any(part.get("fresnel") == "schlick" for part in shown):  # that of a highlight
        table["fresnel"] = "schlick"
    return table


def _sum_of(parts: list[Table], left_out: dict[str, None]) -> Table:
    """Their diffuse parts; of two of which one has a picture the stronger."""
    if len(parts) == 2 and any(isinstance(part["color"], dict) for part in parts):
        left_out["the weaker diffuse of a blendbsdf"] = None
        parts = [max(parts, key=lambda part: part["diffuse"])]
    whole = sum(part["diffuse"] for part in parts)
    if len(parts) == 1:
        return {"diffuse": whole, "color": parts[0]["color"]}
    colors = [part["diffuse"] * np.array(rgb(part["color"])) for part in parts]
    return {"diffuse": whole, "color": [float(c) for c in np.sum(colors, axis=0) / whole]}


def _strongest(
    parts: list[Table], keys: tuple[str, ...], strengths: list[float], left_out: dict[str, None]
) -> Table:
    """These keys of the strongest part; of two that differ by nothing but their coefficients, both."""
    found = [{key: part[key] for key in keys if key in part} for part in parts]
    if not found:
        return {}
    plain = [{key: value for key, value in one.items() if key not in _SHARED} for one in found]
    if len(found) == 2 and plain[0] == plain[1]:
        sums = {key: sum(one.get(key, 0.0) for one in found) for key in _SHARED if key in found[0] | found[1]}
        return plain[0] | sums
    best = int(np.argmax(strengths))
    for k, one in enumerate(found):
        if k != best:
            name = "highlight" if keys is _HIGHLIGHT else "glass" if one.get("transmission") else "reflection"
            left_out[f"the weaker {name} of a blendbsdf"] = None
    return found[best]


def _lit(part: Table) -> float:
    """How much light a highlight has, over all directions; less where it is wider."""
    lobe: float = part["specular"] * _mean(part.get("highlight_color", 1.0))
    return lobe / (part.get("shininess", 32.0) + 1)


def _sent(part: Table) -> float:
    """How much of the light from straight on goes on in mirrored and transmitted rays."""
    mirrored = part.get("reflection", 0.0) * _mean(part.get("reflection_color", 1.0))
    passed = part.get("transmission", 0.0) * _mean(part.get("transmission_color", 1.0))
    if part.get("fresnel") is True:
        share = fresnel_of(part.get("ior", 1.5))
        mirrored, passed = share * mirrored, (1 - share) * passed
    if "conductor" in part:
        mirrored *= float(np.mean(normal_reflectance(*conductor(part["conductor"], None))))
    return float(mirrored + passed)


def _mean(color: Any) -> float:
    """The mean of a colour; of a picture that of its tint."""
    return float(np.mean(rgb(color.get("tint", 1.0) if isinstance(color, dict) else color)))


def rgb(color: Any) -> tuple[float, float, float]:
    """A plain colour in three numbers; of a curve what it looks like under D65."""
    if isinstance(color, (int, float)):
        return (float(color),) * 3
    if isinstance(color[0], list):
        color = reflectance(Spectrum(samples=tuple((nm, part) for nm, part in color)), None).tolist()
    red, green, blue = color
    return red, green, blue
