"""Colours and indices of a scene as the numbers that rays carry: three of Rec.709, or one for each band."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from clrt.scene import IOR, Scene, rgb

from .vectors import Array, Ints


@dataclass(frozen=True)
class Palette:
    """How many numbers a colour has, and how they come from what a scene says.

    Transmission where the index is a curve splits bands into groups; RGB is one group.
    """

    bands: int
    group_of: Ints  # (bands,)
    center: Array  # (groups,): wavelengths, nm

    @classmethod
    def of(cls, scene: Scene) -> Palette:
        return cls(3, np.zeros(3, int), np.array([587.56]))

    @property
    def groups(self) -> int:
        return len(self.center)

    def reflectance(self, value: Any) -> Array:
        """Of surfaces, (bands,)."""
        return np.array(rgb(value))

    def light(self, value: Any) -> Array:
        """Of lights, ambient light, background, emission (bands,)."""
        return np.array(rgb(value))

    def light_image(self, image: Array) -> Array:
        """A background (h, w, 3) in linear Rec.709 as (h, w, bands)."""
        return image

    def curve(self, value: Any) -> Array:
        """A number, or a curve's values (bands,)."""
        return np.broadcast_to(np.asarray(value, float), (self.bands,))

    def index(self, value: Any) -> Array:
        """An index of refraction (groups,)."""
        number = IOR[value] if isinstance(value, str) else value
        return np.full(self.groups, float(number))

    def metal(self, value: Any) -> NDArray[np.complex128]:
        """A conductor's index eta + ik (bands,); 1 where there is none."""
        if value is None:
            return np.ones(self.bands, complex)
        return np.asarray(self.curve(value.eta) + 1j * self.curve(value.k))

    def is_curve(self, value: Any) -> bool:
        """Whether transmission into this index splits."""
        return False

    def developed(self, light: Array) -> Array:
        """Radiances (..., bands) as linear Rec.709 (..., 3)."""
        return light
