"""Flat scenes made of others: with an image for a sky, and in any number of bands."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from clrt import layout
from clrt.flatten.flatten import FlatScene


def with_sky(flat: FlatScene) -> FlatScene:
    """The same scene with a lat-long image of 13 x 6 pixels around it."""
    height, width = 6, 13
    info = flat.scene.copy()
    info["background_width"], info["background_height"] = width, height
    return replace(flat, scene=info, background=numbers(height * width * 3))


def in_bands(flat: FlatScene, n: int) -> FlatScene:
    """The same scene with n bands, each of whose values is an RGB value times a number from 0 to 1.25.

    What Schlick's approximation reflects is a conductor there.
    """
    sections: dict[str, Any] = {
        name: _in_bands(getattr(flat, name), record, n)
        for name, record in (("scene", "SceneInfo"), ("materials", "Material"), ("lights", "Light"))
    }
    if flat.primaries is not None:
        sections["primaries"] = _in_bands(flat.primaries, "Primaries", n)
    materials = sections["materials"]
    metal = materials["fresnel"] == layout.FRESNEL["SCHLICK"]
    materials["fresnel"][metal] = layout.FRESNEL["CONDUCTOR"]
    materials["eta"][metal] = 0.1 + 2 * numbers(n)
    materials["k"][metal] = 5 * numbers(2 * n)[n:]
    matrix = numbers(4 * n).reshape(4, n) - np.float32(0.25)
    return replace(flat, **sections, response=matrix[:3], xyz=matrix[1:])


def _in_bands(records: np.ndarray, name: str, n: int) -> np.ndarray:
    out = np.zeros(records.shape, layout.dtype(name, n))
    for field, kind in layout.RECORDS[name]:
        if kind == "float@BANDS":
            factor = 1.25 * numbers(len(records) * n).reshape(-1, n)
            out[field] = records[field][:, np.arange(n) % 3] * factor.astype(np.float32)
        elif "@" not in kind:
            out[field] = records[field]
    return out


def numbers(n: int) -> np.ndarray:
    """n numbers in [0, 1), float32."""
    value = np.arange(n, dtype=np.uint32) * np.uint32(2654435761) >> np.uint32(8)
    return value.astype(np.float32) * np.float32(2.0**-24)
