"""Layers of all samples of a pixel: which part of them hits anything, and mattes of shapes and materials."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from clrt.base.layers import RANKS, Samples, find
from clrt.flatten.flatten import FlatScene
from clrt.flatten.lightsurfaces import visible_lights
from clrt.images import cryptomatte
from clrt.scene.scene import Scene
from clrt.scene.shapes import Shape

_BLOCK: Final = 1 << 20  # samples that are counted at a time


def mattes(scene: Scene, layers: Sequence[str]) -> dict[str, np.ndarray]:
    """For those of the layers that are mattes, by shape (lights follow) what channels hold for its name."""
    return {name: cryptomatte.ids_of(names) for name, names in _named(scene, layers).items()}


def manifests(scene: Scene, layers: Sequence[str]) -> dict[str, str]:
    """What a file with these layers says of its mattes, by attribute."""
    found: dict[str, str] = {}
    seen = [*range(len(scene.shapes)), *(len(scene.shapes) + light for light in visible_lights(scene))]
    for name, names in _named(scene, layers).items():
        found |= cryptomatte.metadata(name, [names[number] for number in seen])
    return found


def _named(scene: Scene, layers: Sequence[str]) -> dict[str, list[str]]:
    """By layer of mattes the names of what each shape, and after them each light, counts as."""
    return {
        layer: [_name(shape, number, source.of) for number, shape in enumerate(scene.shapes)]
        + [f"lights[{number}]" for number in range(len(scene.lights))]
        for layer in layers
        for source in find(layer).sources
        if isinstance(source, Samples) and source.of
    }


def _name(shape: Shape, number: int, of: str) -> str:
    """A shape's name or its material's; without one its place in the scene, as messages have it."""
    if of == "shape":
        return shape.name or f"shapes[{number}]"
    if shape.material is None:
        return "(default)"
    return shape.material if isinstance(shape.material, str) else f"shapes[{number}].material"


def covered(
    layers: Sequence[str],
    flat: FlatScene,
    primitives: np.ndarray,
    ids: Mapping[str, np.ndarray],
    weights: np.ndarray | None = None,
) -> dict[str, np.ndarray]:
    """The layers of `Samples` among these, by name, at pixels whose samples hit `primitives` (n, samples).

    A miss is -1. ids: as `mattes` gives them. weights: of the samples, (samples,) or (n, samples); None:
    all count the same.
    """
    weights = np.ones(1) if weights is None else weights.astype(np.float64)
    weights = np.broadcast_to(weights, primitives.shape)
    # as the kernel `weighted_means` has it: where most of the weights cancel, all samples count alike
    some = weights.sum(axis=1) > 0.25 * np.abs(weights).sum(axis=1)
    weights = np.where(some[:, None], weights, 1.0)
    total = weights.sum(axis=1)
    found: dict[str, np.ndarray] = {}
    for name in layers:
        for source in find(name).sources:
            if isinstance(source, Samples):
                if source.of:
                    found[name] = _ranked(flat, primitives, ids[name], weights, total)
                else:
                    share = (weights * (primitives >= 0)).sum(axis=1) / total
                    found[name] = np.clip(share, 0.0, 1.0).astype(np.float32)
    return found


def _whole(part: np.ndarray, pixel: np.ndarray) -> np.ndarray:
    """Parts of pixels, sorted by these, of which none is below 0 and whose sums are as before, in [0, 1].

    Mitchell's filter subtracts what lies at its rim: the others share what that took. What becomes of a pixel
    does not depend on the others.
    """
    before, seen = np.bincount(pixel, part), np.bincount(pixel, np.maximum(part, 0))
    with np.errstate(invalid="ignore"):
        share = np.clip(before, 0, 1) / np.where(seen > 0, seen, 1)
    return np.maximum(part, 0) * share[pixel]


def _ranked(
    flat: FlatScene, primitives: np.ndarray, ids: np.ndarray, weights: np.ndarray, total: np.ndarray
) -> np.ndarray:
    """(n, 2 RANKS) float32: of the names that most of a pixel's samples hit, the id and their part."""
    out = np.zeros((len(primitives), RANKS, 2), np.float32)
    step = max(1, _BLOCK // primitives.shape[1])
    names, number = np.unique(ids.view(np.uint32), return_inverse=True)
    for start in range(0, len(primitives), step):
        met = primitives[start : start + step]
        pixel = np.nonzero(met >= 0)[0]
        name = number[flat.primitives["shape"][met[met >= 0]]]
        pairs, which = np.unique(pixel * len(names) + name, return_inverse=True)
        part = np.bincount(which, weights[start : start + step][met >= 0], len(pairs))
        pixel, name = np.divmod(pairs, len(names))
        part = _whole(part / total[start + pixel], pixel)
        order = np.lexsort((name, -part, pixel))
        pixel, name, part = pixel[order], name[order], part[order]
        rank = np.arange(len(pixel)) - np.searchsorted(pixel, pixel)
        kept = (rank < RANKS) & (part > 0)
        at = start + pixel[kept], rank[kept]
        out[(*at, 0)] = names[name[kept]].astype(np.uint32).view(np.float32)
        out[(*at, 1)] = part[kept]
    return out.reshape(len(primitives), -1)
