"""Colours of a scene as what a picture of three channels carries: red, green and blue, or three of its
bands."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from . import published, spectra
from .records import Conductor, Material, Spectral, Spectrum, index

Array = np.ndarray
Triple = tuple[int, int, int]
LAMPS = ("name", "blackbody")  # kinds of lights that have no unit: Y = 1
D65 = Spectrum("name", "D65")


def plain(value: Any) -> Array | None:
    """A number or three of them as (3,); None for a spectrum."""
    return None if isinstance(value, Spectrum) else np.array(np.broadcast_to(np.asarray(value, float), (3,)))


class Colors:
    """RGB mode."""

    def reflectance(self, value: Any) -> Array:
        found = plain(value)
        if found is None:
            largest = spectra.curve(value)(spectra.NM).max()
            found = np.clip(self._under_d65(spectra.by_nm(value)), 0, max(1.0, largest))
        return found

    def light(self, value: Any) -> Array:
        found = plain(value)
        if found is None:
            lamp = value.kind in LAMPS
            xyz = spectra.xyz(replace(value, scale=1.0) if lamp else value)
            found = np.maximum(spectra.to_rgb() @ (xyz / xyz[1] * value.scale if lamp else xyz), 0)
        return found

    def absorption(self, value: Any) -> Array:
        found = plain(value)
        return self._mean(spectra.by_nm(value)) if found is None else found

    def eta(self, material: Material) -> float:
        return material.ior_d

    def metal(self, value: Any) -> tuple[Array, Array]:
        """eta and k (3,) of a conductor."""
        if (
            isinstance(value, Conductor)
            and not isinstance(value.eta, tuple)
            and not isinstance(value.k, tuple)
        ):
            return np.full(3, float(value.eta)), np.full(3, float(value.k))
        eta, k = curves(value, spectra.NM)
        mean = self._mean(_by_nm(eta))
        share = np.clip(self._under_d65(_by_nm(spectra.straight(eta, k))), 0, 0.995)
        square = (share * (mean + 1) ** 2 - (mean - 1) ** 2) / (1 - share)
        return mean, np.sqrt(np.maximum(square, 0))

    def background(self, image: Array) -> Array:
        return image

    reflects = shines = background

    def _under_d65(self, share: Array) -> Array:
        white = spectra.by_nm(D65)
        xyz = spectra.observer() @ (share * white) / (spectra.observer()[1] @ white)
        return np.asarray(spectra.to_rgb() @ xyz)

    def _mean(self, values: Array) -> Array:
        weight = spectra.primaries(spectra.NM) * spectra.by_nm(D65) * spectra.observer().sum(axis=0)
        return np.asarray((weight * values).sum(axis=1) / weight.sum(axis=1))


def curves(value: Any, nm: Array) -> tuple[Array, Array]:
    """eta and k of a conductor at wavelengths."""
    if isinstance(value, str):
        return published.metal(value, nm)
    eta, k = (
        np.interp(nm, *np.array(part, float).T) if isinstance(part, tuple) else np.full(len(nm), float(part))
        for part in (value.eta, value.k)
    )
    return eta, k


def _by_nm(values: Array) -> Array:
    """Means about each nanometre of a curve given there, linear between."""
    near = np.concatenate([values[:1], values, values[-1:]])
    return np.asarray((near[:-2] + 6 * near[1:-1] + near[2:]) / 8)


class Bands:
    """Three bands of a spectral scene."""

    def __init__(self, wanted: Spectral, picked: Triple = (0, 0, 0)) -> None:
        self.wanted, self.picked = wanted, list(picked)
        self.edges = np.linspace(*wanted.range, wanted.bands + 1)
        self.middle = (self.edges[1:] + self.edges[:-1]) / 2

    def reflectance(self, value: Any) -> Array:
        numbers = plain(value)
        if numbers is not None:
            return np.asarray((numbers @ spectra.primaries(self.middle))[self.picked])
        if value.kind == "line":
            holds = np.searchsorted(self.edges, value.value, side="right") - 1
            return np.asarray((np.arange(self.wanted.bands) == holds) * value.scale)[self.picked]
        return spectra.curve(value)(self.middle)[self.picked]

    absorption = reflectance

    def light(self, value: Any) -> Array:
        numbers = plain(value)
        if numbers is not None:
            return np.asarray((numbers @ spectra.primaries(self.middle) * self._lamp(D65))[self.picked])
        found = self._lamp(value) if value.kind in LAMPS else spectra.means(value, self.edges)
        return np.asarray(found)[self.picked]

    def eta(self, material: Material) -> float:
        """At the middle of the range of the group that all three bands are in."""
        first = self.picked[0] // self.wanted.group * self.wanted.group
        last = min(first + self.wanted.group, self.wanted.bands)
        assert not material.varies or all(first <= band < last for band in self.picked)
        return float(index(material, np.array([(self.edges[first] + self.edges[last]) / 2]))[0])

    def metal(self, value: Any) -> tuple[Array, Array]:
        eta, k = curves(value, self.middle)
        return eta[self.picked], k[self.picked]

    def background(self, image: Array) -> Array:
        return np.asarray(image @ (spectra.primaries(self.middle) * self._lamp(D65))[:, self.picked])

    shines = background

    def reflects(self, rgb: Array) -> Array:
        """Reflectances (n, 3) of texels (n, 3)."""
        return np.asarray(rgb @ spectra.primaries(self.middle)[:, self.picked])

    def _lamp(self, value: Spectrum) -> Array:
        """Bands whose XYZ is the light's, scaled to Y = 1 and then by its own scale, which may be 0."""
        lamp = replace(value, scale=1.0)
        whole = spectra.xyz(lamp)
        share = spectra.means(lamp, self.edges) / whole[1]
        seen = spectra.seen(self.middle)
        share_of = seen / seen[1].sum()
        matrix = (share_of * share) @ seen.T
        factor = np.zeros(len(share))
        if np.linalg.cond(matrix) < 1e8:
            factor = 1 + np.linalg.solve(matrix, whole / whole[1] - share_of @ share) @ seen
        if np.all(factor > 0) and np.all(factor < 2):
            return np.asarray(value.scale * share * factor)
        return np.asarray(value.scale * share / (share_of[1] @ share))

    @cached_property
    def to_rgb(self) -> Array:
        """Bands to linear Rec.709 (3, bands)."""
        seen = spectra.seen(self.middle)
        matrix = spectra.to_rgb()
        if self.wanted.white_balance:
            matrix = matrix @ spectra.white_balance(self.wanted.white)
        return np.asarray(matrix @ (seen / seen[1].sum()))


def triples(wanted: Spectral, one_by_one: bool) -> list[Triple]:
    """Bands to render together; all are among them."""
    last = wanted.bands - 1
    if one_by_one:
        return [(band, band, band) for band in range(wanted.bands)]
    return [(band, min(band + 1, last), min(band + 2, last)) for band in range(0, wanted.bands, 3)]
