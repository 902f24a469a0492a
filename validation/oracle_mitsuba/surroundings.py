"""What lies around glass: a scene has lists of media, Mitsuba's boundaries the indices of their two sides."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .forms import Array
from .insides import starting
from .parts import Part
from .records import Scene

_POINTS = 64  # of a surface that are looked at


def around_glass(source: Scene, parts: Sequence[Part], notes: list[str]) -> list[float]:
    """The index of refraction outside each part: that of the innermost solid around it, or the scene's.

    Where one part of a surface lies in another medium than the rest it has the scene's, and a note says so.
    """
    materials = [source.material_of(shape) for shape in source.shapes]
    solid = np.array([material.kt > 0 and not material.thin for material in materials], bool)
    found = [float(source.medium_ior)] * len(parts)
    if not solid.any():
        return found
    ranked = len({material.priority for material, fills in zip(materials, solid, strict=True) if fills}) > 1
    for index, part in enumerate(parts):
        if materials[part.owner].kt == 0:
            continue
        number = np.where(solid, np.arange(len(materials)), -1)
        number[part.owner] = -1  # a surface is not around itself
        lists, which = starting(source, number, _points(part))
        around = {lists[k][-1:] for k in np.unique(which).tolist()}
        if len(around) > 1 and not ranked:  # else all that overlaps is named
            notes.append(f"shapes[{part.owner}]: partly in another medium, which Mitsuba's boundary has not")
        elif len(around) == 1 and around != {()}:
            ((inner,),) = around
            found[index] = float(materials[inner].ior_d)
    return found


def _points(part: Part) -> Array:
    """Some of its surface, (n, 3)."""
    if part.mesh is not None:
        corners = part.mesh.vertices
        return corners[:: max(1, len(corners) // _POINTS)]
    assert part.to_world is not None
    angle = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    rim = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    if part.kind == "sphere":
        local = np.concatenate([rim, rim[:, [0, 2, 1]], rim[:, [2, 0, 1]]])
    elif part.kind == "cylinder":
        local = np.concatenate([rim + np.array([0, 0, height]) for height in (0.0, 0.5, 1.0)])
    else:
        local = np.concatenate([rim, 0.5 * rim, np.zeros((1, 3))])
    return np.asarray(local @ part.to_world[:3, :3].T + part.to_world[:3, 3])
