"""A pixel's rays as a page draws them in three dimensions and lists them."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from clrt.base.errors import legible
from clrt.raytree.solids import triangles_of
from clrt.raytree.tree import RayTree
from clrt.raytree.ways import COLOURS, ways
from clrt.raytree.words import heading, lines, percent, summary, title

MOST: Final = 2000  # rays that a page lists and draws
_DIRECTIONS: Final = 240  # in which a shape's farthest point is kept


def told(tree: RayTree) -> dict[str, Any]:
    """Value, rays with their terms, their ways, and the shapes that they meet as points around them.

    Of more than `MOST` rays those of the first generations; `left_out` counts the others.
    """
    last = max(ray.generation for ray in tree.rays)
    while last and sum(ray.generation <= last for ray in tree.rays) > MOST:
        last -= 1
    kept = {ray.number for ray in tree.rays if ray.generation <= last}
    found, low, high = ways(tree)
    shapes = sorted({ray.hit.shape for ray in tree.rays if ray.hit is not None and ray.number in kept})
    return {
        "x": tree.x, "y": tree.y, "samples": tree.samples, "value": tree.value.tolist(),
        "total": tree.total.tolist(), "title": legible(title(tree)), "summary": summary(tree),
        "left_out": len(tree.rays) - len(kept), "low": low.tolist(), "high": high.tolist(),
        "colours": {kind: "rgb({}, {}, {})".format(*colour) for kind, colour in COLOURS.items()},
        "rays": [_ray(tree, ray) for ray in tree.rays if ray.number in kept],
        "ways": [
            {"kind": way.kind, "ray": way.ray, "start": way.start.tolist(), "end": way.end.tolist(),
             "share": float(way.share)}
            for way in found if way.ray in kept
        ],
        "solids": [solid for number in shapes for solid in _solid(tree, number, low, high)],
    }  # fmt: skip


def _ray(tree: RayTree, ray: Any) -> dict[str, Any]:
    return {
        "number": ray.number, "parent": ray.parent, "generation": ray.generation, "queue": ray.queue,
        "kind": ray.kind, "heading": legible(heading(tree, ray)),
        "brings": None if ray.brings is None else [float(v) for v in ray.brings],
        "branch": float(tree.branch_shares[ray.number]), "percent": percent(tree.branch_shares[ray.number]),
        "lines": [
            {"text": legible(line.text), "colour": line.colour,
             "percent": percent(line.share) if line.colour else ""}
            for line in lines(tree, ray)
        ],
    }  # fmt: skip


def _solid(tree: RayTree, number: int, low: np.ndarray, high: np.ndarray) -> list[dict[str, Any]]:
    """The points of a shape that are the farthest in some direction: its outline from wherever it is seen."""
    if number >= len(tree.scene.shapes):
        return []  # a light that is seen
    made = triangles_of(tree.scene.shapes[number], low, high)
    if made is None:
        return []
    points = made[0][np.unique(made[1])]
    if len(points) > _DIRECTIONS:
        # Fibonacci's lattice on the sphere (Gonzalez 2010)
        k = np.arange(_DIRECTIONS) + 0.5
        z, angle = 1 - 2 * k / _DIRECTIONS, np.pi * (1 + 5**0.5) * k
        ring = np.sqrt(1 - z * z)
        way = np.stack([ring * np.cos(angle), ring * np.sin(angle), z], axis=-1)
        points = points[np.unique((points @ way.T).argmax(axis=0))]
    return [{"name": legible(tree.names.shape(number)), "points": points.round(6).tolist()}]
