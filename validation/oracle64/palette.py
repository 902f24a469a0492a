"""Colours and indices of a scene as the numbers that rays carry: three of Rec.709, or one for each band."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from clrt.scene.scene import IOR, Scene
from clrt.spectra.spectrum import Spectrum

from . import spectra
from .vectors import Array, Ints

D_LINE = 587.5618  # nm: where RGB pictures take an index


@dataclass(frozen=True)
class Palette(ABC):
    """How many numbers a colour has, and how they come from what a scene says.

    Transmission where the index is a curve splits bands into groups; RGB is one group.
    """

    bands: int
    group_of: Ints  # (bands,)
    center: Array  # (groups,): wavelengths, nm

    @staticmethod
    def of(scene: Scene) -> Palette:
        """The palette of a scene's mode."""
        wanted = scene.spectrum
        if wanted is None:
            return Colors(3, np.zeros(3, int), np.array([D_LINE]))
        return _bands_of(wanted)

    @property
    def groups(self) -> int:
        return len(self.center)

    @abstractmethod
    def reflectance(self, value: Any) -> Array:
        """Of surfaces, (bands,)."""

    @abstractmethod
    def light(self, value: Any) -> Array:
        """Of lights, ambient light, background, emission (bands,)."""

    @abstractmethod
    def curve(self, value: Any) -> Array:
        """Of absorption (bands,)."""

    @abstractmethod
    def complex_index(self, n: Any, k: Any) -> tuple[Array, Array]:
        """A metal's (bands,) and (bands,) from two curves over nm."""

    @property
    def linear(self) -> bool:
        """Whether what is developed part by part sums to what is developed as a whole."""
        return True

    @abstractmethod
    def developed(self, light: Array) -> Array:
        """Radiances (..., bands) as linear Rec.709 (..., 3)."""

    @abstractmethod
    def under_white(self, share: Array) -> Array:
        """Reflectances (..., bands) as the linear Rec.709 (..., 3) that they have under D65."""

    def light_image(self, image: Array) -> Array:
        """A background (h, w, 3) in linear Rec.709 as (h, w, bands)."""
        return np.asarray(image @ np.stack([self.light(tuple(primary)) for primary in np.eye(3)]))

    def index(self, value: Any) -> Array:
        """An index of refraction (groups,)."""
        if not self.is_curve(value):
            return np.full(self.groups, IOR[value] if isinstance(value, str) else float(value))
        return spectra.index(value, self.center)

    def is_curve(self, value: Any) -> bool:
        """Whether transmission into this index splits."""
        return not (isinstance(value, (int, float)) or (isinstance(value, str) and value in IOR))

    def metal(self, value: Any) -> NDArray[np.complex128]:
        """A conductor's index eta + ik (bands,); 1 where there is none."""
        if value is None:
            return np.ones(self.bands, complex)
        if isinstance(value, str):
            n, k = (spectra.tabled(value, column) for column in ("eta", "k"))
        elif isinstance(value.eta, float) and isinstance(value.k, float):
            return np.full(self.bands, value.eta + 1j * value.k)
        else:
            n, k = (_numbers(part) for part in (value.eta, value.k))
        eta, kappa = self.complex_index(n, k)
        return np.asarray(eta + 1j * kappa)


def _numbers(value: Any) -> spectra.Curve:
    """A constant, or the curve through (nm, value) pairs."""
    points = np.array(value if isinstance(value, tuple) else [(500.0, value), (600.0, value)], float)
    return lambda nm: np.interp(nm, points[:, 0], points[:, 1])


def _plain(value: Any) -> Array | None:
    """A number or three of them as (3,); None for a spectrum."""
    is_plain = isinstance(value, (int, float)) or (isinstance(value, tuple) and len(value) == 3)
    return np.broadcast_to(np.asarray(value, float), (3,)) if is_plain else None


def _lamp_in(value: Any) -> tuple[Any, float] | None:
    """A lamp and its scale, apart: of scale 0 it has no Y to divide by. None for another spectrum."""
    if isinstance(value, str):
        return value, 1.0
    if value.name is None and value.blackbody is None:
        return None
    return Spectrum(name=value.name, blackbody=value.blackbody), value.scale


@dataclass(frozen=True)
class Colors(Palette):
    """RGB: a spectrum is the colour that it has, cut off below 0 and, of surfaces, above 1."""

    def reflectance(self, value: Any) -> Array:
        plain = _plain(value)
        if plain is not None:
            return plain
        most = spectra.curve_of(value)(spectra.NM).max()  # no channel gives more than every band may
        return np.clip(self._seen(spectra.means_of(value, spectra.NM, 1.0)), 0.0, max(1.0, most))

    def _seen(self, share: Array) -> Array:
        """The colour under D65 of what reflects these shares, nanometre by nanometre."""
        observer, white = spectra.matching(spectra.NM), spectra.means_of("D65", spectra.NM, 1.0)
        return np.asarray(spectra.TO_RGB @ (observer @ (white * share) / (observer[1] @ white)))

    def light(self, value: Any) -> Array:
        plain = _plain(value)
        if plain is not None:
            return plain
        lamp, scale = _lamp_in(value) or (value, None)
        found = spectra.xyz(lamp)
        return np.maximum(spectra.TO_RGB @ (found if scale is None else found / found[1] * scale), 0.0)

    def curve(self, value: Any) -> Array:
        plain = _plain(value)
        return self._mean(spectra.means_of(value, spectra.NM, 1.0)) if plain is None else plain

    def _mean(self, values: Array) -> Array:
        """Means (3,) under what red, green and blue stand for, by how well D65 lets them be seen."""
        nm = spectra.NM
        weight = spectra.basis(nm) * spectra.means_of("D65", nm, 1.0) * spectra.matching(nm).sum(axis=0)
        return np.asarray(weight @ values / weight.sum(axis=1))

    def complex_index(self, n: Any, k: Any) -> tuple[Array, Array]:
        """The k that gives, with the mean n, the colour that the metal has straight on."""
        nm = spectra.NM
        index = n(nm) + 1j * k(nm)
        straight = np.abs((index - 1) / (index + 1)) ** 2
        eta = self._mean(spectra.means(lambda at: np.interp(at, nm, index.real), nm, 1.0))
        color = self._seen(spectra.means(lambda at: np.interp(at, nm, straight), nm, 1.0))
        share = np.clip(color, 0.0, 0.995)
        return eta, np.sqrt(np.maximum((share * (eta + 1) ** 2 - (eta - 1) ** 2) / (1 - share), 0.0))

    def developed(self, light: Array) -> Array:
        return light

    def under_white(self, share: Array) -> Array:
        return share


@dataclass(frozen=True)
class Bands(Palette):
    """Bands of equal width: means of lights, midpoints of all else."""

    wanted: Any  # the scene's `spectrum`

    @cached_property
    def width(self) -> float:
        low, high = self.wanted.range
        return float(high - low) / self.bands

    @cached_property
    def middle(self) -> Array:
        return np.asarray(self.wanted.range[0] + self.width * (np.arange(self.bands) + 0.5))

    @cached_property
    def to_xyz(self) -> Array:
        """(3, bands)."""
        observer = spectra.matching(self.middle)
        return np.asarray(observer / observer[1].sum())

    def reflectance(self, value: Any) -> Array:
        plain = _plain(value)
        if plain is not None:
            return np.asarray(plain @ spectra.basis(self.middle))
        if not isinstance(value, str) and value.line is not None:
            holds = np.floor((value.line - self.wanted.range[0]) / self.width) == np.arange(self.bands)
            return holds * value.scale
        return spectra.curve_of(value)(self.middle)

    def light(self, value: Any) -> Array:
        plain = _plain(value)
        if plain is not None:
            return plain @ spectra.basis(self.middle) * self._lamp("D65")
        if lamp := _lamp_in(value):
            return self._lamp(lamp[0]) * lamp[1]
        return spectra.means_of(value, self.middle, self.width)

    @cached_property
    def _lamps(self) -> dict[Any, Array]:
        return {}

    def _lamp(self, value: Any) -> Array:
        """Means that have the XYZ of the whole spectrum, at Y = 1; each is found once, for it takes long."""
        if value not in self._lamps:
            self._lamps[value] = self._found_lamp(value)
        return self._lamps[value]

    def _found_lamp(self, value: Any) -> Array:
        whole = spectra.xyz(value)
        means = spectra.means_of(value, self.middle, self.width) / whole[1]
        whole = whole / whole[1]
        observer = spectra.matching(self.middle)
        system = self.to_xyz * means @ observer.T
        if np.linalg.cond(system) < 1e8:
            factor = 1 + np.linalg.solve(system, whole - self.to_xyz @ means) @ observer
            if factor.min() > 0 and factor.max() < 2:
                return np.asarray(means * factor)
        return np.asarray(means / (self.to_xyz[1] @ means))

    def curve(self, value: Any) -> Array:
        return self.reflectance(value)

    def complex_index(self, n: Any, k: Any) -> tuple[Array, Array]:
        return n(self.middle), k(self.middle)

    @property
    def linear(self) -> bool:
        return self.wanted.response != "thesis-2011"

    def developed(self, light: Array) -> Array:
        if not self.linear:
            return self._as_thesis(light)
        balance = np.eye(3)
        if self.wanted.white_balance:
            white = spectra.xyz(self.wanted.white)
            balance = spectra.bradford(white / white[1])
        return np.asarray(light @ (spectra.TO_RGB @ balance @ self.to_xyz).T)

    def under_white(self, share: Array) -> Array:
        return np.asarray((share * self._lamp("D65")) @ (spectra.TO_RGB @ self.to_xyz).T)

    def _as_thesis(self, light: Array) -> Array:
        """The thesis program's colours: a ratio of three sums, times the integral, shown without a curve."""
        curves = [
            np.exp(-(((self.middle - mean) / deviation) ** 2) / 2) / deviation
            for mean, deviation in ((610, 25), (540, 30), (445, 25))
        ]
        sums = light @ np.stack(curves, axis=1)
        largest = np.max(sums, axis=-1, keepdims=True)
        shown = np.divide(sums, largest, out=np.zeros_like(sums), where=largest > 0)
        shown = shown * (light.sum(axis=-1) * self.width)[..., None]
        return np.where(shown <= 0.04045, shown / 12.92, ((np.maximum(shown, 0) + 0.055) / 1.055) ** 2.4)


@cache
def _bands_of(wanted: Any) -> Bands:
    """The bands that a scene's `spectrum` asks for."""
    group_of = np.arange(wanted.bands) // wanted.group
    low, high = wanted.range
    edges = low + (high - low) / wanted.bands * np.arange(wanted.bands + 1)
    starts = np.arange(0, wanted.bands, wanted.group)
    ends = np.minimum(starts + wanted.group, wanted.bands)
    return Bands(wanted.bands, group_of, (edges[starts] + edges[ends]) / 2, wanted)
