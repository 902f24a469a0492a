"""Adaptive sampling: even pictures, and which of them each pixel shows."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import Any

import msgspec.structs
import numpy as np

from clrt.scene.scene import Scene

from .render import Result64, render64
from .vectors import Array, Bools

_BENT = 0.9  # cosine between normals of neighbours below which there is an edge


def even(scene: Scene, spp: int) -> Scene:
    """The scene with as many samples in every pixel."""
    assert scene.camera is not None
    camera = msgspec.structs.replace(scene.camera, spp=spp)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the scene was warned of when it was read
        return msgspec.structs.replace(scene, adaptive=None, camera=camera)


def adaptive64(scene: Scene, layers: Iterable[str] = ()) -> Result64:
    """The picture of a scene that is `adaptive`, with layers of each pixel's last grid; "samples" always.

    Its rays are not told apart, and `samples` are those of the first grid.
    """
    assert scene.camera is not None and scene.adaptive is not None
    names = tuple(dict.fromkeys((*layers, "shape", "normal", "samples")))
    spp, threshold = scene.camera.spp, scene.adaptive.threshold
    first = render64(even(scene, spp), layers=names)
    pixels, found = first.pixels.copy(), {name: values.copy() for name, values in first.layers.items()}
    chosen = _outlines(found) | _beside(pixels, threshold)
    while chosen.any() and spp < scene.adaptive.spp:
        spp *= 4
        finer = render64(even(scene, spp), layers=names)
        changed = chosen & _apart(pixels, finer.pixels, threshold)
        pixels[chosen] = finer.pixels[chosen]
        for name, values in finer.layers.items():
            found[name][chosen] = values[chosen]
        chosen = changed
    return Result64(pixels, found, samples=first.samples)


def _apart(one: Array, other: Array, threshold: float) -> Bools:
    roots = np.sqrt(np.clip(one, 0, 1)) - np.sqrt(np.clip(other, 0, 1))
    return np.asarray((roots**2 > threshold).any(axis=-1))


def _either(differ: Any, height: int, width: int) -> Bools:
    """Pixels that `differ` from a neighbour, asked of slices: upper and lower, left and right ones."""
    out = np.zeros((height, width), bool)
    for one, other in ((np.s_[:-1], np.s_[1:]), (np.s_[:, :-1], np.s_[:, 1:])):
        edge = differ(one, other)
        out[one] |= edge
        out[other] |= edge
    return out


def _beside(pixels: Array, threshold: float) -> Bools:
    return _either(lambda one, other: _apart(pixels[one], pixels[other], threshold), *pixels.shape[:2])


def _outlines(layers: dict[str, Any]) -> Bools:
    shape, normal = layers["shape"], layers["normal"]

    def differ(one: Any, other: Any) -> Bools:
        bent = (normal[one] * normal[other]).sum(axis=-1) < _BENT
        both = (shape[one] >= 0) & (shape[other] >= 0)
        return np.asarray((shape[one] != shape[other]) | (both & bent))

    return _either(differ, *shape.shape)
