"""Materials as arrays with one row a shape, and checker colours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from clrt.scene.scene import Checker, ImageTexture, Scene

from .batch import Batch
from .flat import Planes
from .palette import Palette
from .vectors import Array, Bools, Ints, dot, unit

PLAIN, SQUARES, GLOBE = 0, 1, 2


@dataclass(frozen=True)
class Surfaces:
    """Coefficients and colours in the letters of the model's equation; colours are (s, bands), numbers
    (s,)."""

    color: Array  # F
    other_color: Array  # F of a checker's odd cells
    ka: Array
    kd: Array
    ks: Array
    m: Array
    kr: Array
    kt: Array
    alpha: Array  # GGX's, 0 of perfect mirrors
    eta: Array  # (s, groups)
    metal: NDArray[np.complex128]  # (s, bands): a conductor's index eta + ik, else 1
    highlight: Array  # H
    mirror: Array  # M
    clear: Array  # kt Tt, what a tinted shadow is multiplied by
    tint: Array  # Tt
    emission: Array  # e
    fresnel: Bools
    conductor: Bools
    curved: Bools  # the index is a curve
    schlick: Bools
    thin: Bools
    checker: Ints  # PLAIN, SQUARES or GLOBE
    size: Array  # of SQUARES
    divisions: Array  # of a GLOBE
    corner: Array  # where SQUARES start (s, 3)

    @classmethod
    def of(cls, scene: Scene, palette: Palette, batches: list[Batch], shape_of: Ints) -> Surfaces:
        """The surfaces of a scene; `batches` tell where a checker starts."""
        rows = [_row(palette, shape, scene.material_of(shape)) for shape in scene.shapes]
        columns = {name: [row[name] for row in rows] for name in (rows[0] if rows else _NAMES)}
        colors = {name: np.array(columns[name], float).reshape(-1, palette.bands) for name in _COLORS}
        flags = {name: np.array(columns[name], bool) for name in _FLAGS}
        numbers = {name: np.array(columns[name], float) for name in _NUMBERS}
        clear = numbers["kt"][:, None] * colors["tint"]
        corner = np.zeros((len(rows), 3))
        for batch in batches:
            if isinstance(batch, Planes):
                corner[shape_of[batch.ids]] = batch.point
        checker = np.array(columns["checker"], int)
        eta = np.array(columns["eta"], float).reshape(-1, palette.groups)
        metal = np.array(columns["metal"], complex).reshape(-1, palette.bands)
        more = {"eta": eta, "metal": metal, "clear": clear, "checker": checker, "corner": corner}
        return cls(**colors, **flags, **numbers, **more)

    def reflectance(self, shape: Ints, point: Array, outward: Array) -> Array:
        """F (m, bands) at points of shapes with these outward normals."""
        odd = np.zeros(len(shape), bool)
        flat, round_ = self.checker[shape] == SQUARES, self.checker[shape] == GLOBE
        odd[flat] = _odd_square(point[flat] - self.corner[shape[flat]], outward[flat], self.size[shape[flat]])
        odd[round_] = _odd_field(outward[round_], self.divisions[shape[round_]])
        return np.where(odd[:, None], self.other_color[shape], self.color[shape])


_COLORS = ("color", "other_color", "highlight", "mirror", "tint", "emission")
_NUMBERS = ("ka", "kd", "ks", "m", "kr", "kt", "alpha", "size", "divisions")
_FLAGS = ("fresnel", "schlick", "thin", "conductor", "curved")
_NAMES = (*_COLORS, *_NUMBERS, *_FLAGS, "eta", "metal", "checker")


def _row(palette: Palette, shape: Any, material: Any) -> dict[str, Any]:
    color = material.color
    checked = isinstance(color, Checker)
    first, second = (color.colors[0], color.colors[1]) if checked else (color, color)
    first, second = _plain(first), _plain(second)
    kind = PLAIN if not checked else GLOBE if type(shape).__name__ == "Sphere" else SQUARES
    metal = material.conductor
    tints = {"color": first, "other_color": second, "highlight": _plain(material.highlight_color),
             "mirror": _plain(material.reflection_color), "tint": _plain(material.transmission_color)}
    return {
        **{name: palette.reflectance(tint) for name, tint in tints.items()},
        "emission": palette.light(_plain(material.emission)), "ka": material.ka, "kd": material.diffuse,
        "ks": material.specular, "m": material.shininess, "kr": material.kr, "kt": material.kt,
        "alpha": material.roughness**2 if material.roughness >= 0.01 and material.kr > 0 else 0.0,
        "eta": palette.index(material.ior), "curved": palette.is_curve(material.ior),
        "conductor": metal is not None, "metal": palette.metal(metal),
        "thin": material.thin, "fresnel": material.fresnel is True, "schlick": material.fresnel == "schlick",
        "checker": kind, "size": color.size if checked else 1.0,
        "divisions": color.divisions if checked else 1,
    }  # fmt: skip


def _plain(color: Any) -> Any:
    """A colour, or 1 in place of a picture, which `images` looks up."""
    return 1.0 if isinstance(color, ImageTexture) else color


def _odd_square(offset: Array, normal: Array, size: Array) -> Bools:
    """Whether offsets in planes fall into odd squares.

    One side of the squares lies along the axis that the plane is most nearly parallel to.
    """
    axis = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
    across = unit(axis - dot(axis, normal)[:, None] * normal)
    up = np.cross(normal, across)
    cell = np.floor(dot(offset, across) / size) + np.floor(dot(offset, up) / size)
    return np.asarray(cell % 2 == 1)


def _odd_field(normal: Array, divisions: Array) -> Bools:
    """Whether normals of a sphere fall into odd fields: `divisions` round the equator, half as many down."""
    u, v = (np.minimum(at, 1 - 1e-15) for at in longitude_latitude(normal))  # at 1 the last field goes on
    return np.asarray((np.floor(u * divisions) + np.floor(v * divisions / 2)) % 2 == 1)


def longitude_latitude(direction: Array) -> tuple[Array, Array]:
    """u and v in [0, 1] of unit vectors: -z is the middle, u grows towards +x, v downwards from +y."""
    u = 0.5 + np.arctan2(direction[..., 0], -direction[..., 2]) / (2 * np.pi)
    return u, np.arccos(np.clip(direction[..., 1], -1, 1)) / np.pi
