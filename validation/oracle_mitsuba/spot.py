"""Where rays meet surfaces, as those who shade them see it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Spot:
    """Where rays hit, seen from the ray's side."""

    shape: Array  # (n,)
    point: Array
    outward: Array
    n: Array  # geometric normal
    ns: Array  # shading normal
    enters: Array  # (n,) bool: the ray comes from outside
    step: Array  # (n,): off the surface
    back: Array  # (n, 3): from there, back along the rays
    F: Array
    H: Array  # tints of highlight, mirror and transmission, and emission (n, 3)
    M: Array
    Tt: Array
    e: Array
    form: Array  # (n,)
    eta_i: Array  # (n,): index of refraction on the ray's side
    eta_t: Array  # (n,): and beyond
    media: Array  # (n,): states of media.Media on the ray's side
    beyond: Array  # (n,)
    cone: Array  # (n, 2): of what goes on from here, as in Rays

    def take(self, rows: Array) -> Spot:
        return Spot(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))

    @property
    def start_before(self) -> Array:
        return np.asarray(self.point + self.step[:, None] * self.n - self.back)

    @property
    def start_behind(self) -> Array:
        return np.asarray(self.point - self.step[:, None] * self.n)
