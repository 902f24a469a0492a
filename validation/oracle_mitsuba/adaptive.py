"""Adaptive sampling by the model's rule, from even pictures (worker process)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from .records import Scene

Array = np.ndarray
BESIDE = ((0, 1), (0, -1), (1, 1), (1, -1))  # axis and step of a pixel's four neighbours


def refined(scene: Scene, even: Callable[[Scene], dict[str, Any]]) -> dict[str, Any]:
    """Picture, `t`, `shape` and layer `samples` of the last of the even pictures that each pixel gets.

    `even`: such a picture, with the outward `normal` of what each pixel's first sample hits.
    """
    assert scene.camera is not None and scene.adaptive is not None
    finest, threshold = scene.adaptive.get("spp", 64), scene.adaptive.get("threshold", 0.01)
    count = scene.camera.spp
    answer = even(scene)
    names = ("pixels", "t", "shape")
    shown = {name: np.array(answer[name]) for name in names}
    samples = np.full(shown["t"].shape, count)
    more = _differs(answer, threshold)
    while count < finest and more.any():
        count *= 4
        answer = even(replace(scene, camera=replace(scene.camera, spp=count)))
        again = more & _far(shown["pixels"], answer["pixels"], threshold)
        for name in names:
            shown[name][more] = answer[name][more]
        samples[more] = count
        more = again
    return {**shown, "by_ray": {}, "layers": {"samples": samples}}


def _far(a: Array, b: Array, threshold: float) -> Array:
    return np.asarray(((_shade(a) - _shade(b)) ** 2).max(axis=2) > threshold)


def _shade(light: Array) -> Array:
    return np.asarray(np.minimum(np.maximum(light, 0), 1) ** 0.5)


def _differs(answer: dict[str, Any], threshold: float) -> Array:
    """(h, w): whether a pixel has a neighbour of another shape, normal or colour."""
    pixels, shape, normal = answer["pixels"], answer["shape"], answer["normal"]
    found = np.zeros(shape.shape, bool)
    for axis, step in BESIDE:
        there, turned, color = (np.roll(of, step, axis) for of in (shape, normal, pixels))
        bent = (shape >= 0) & (there >= 0) & (np.einsum("hwk,hwk->hw", normal, turned) < 0.9)
        differs = (shape != there) | bent | _far(pixels, color, threshold)
        np.moveaxis(differs, axis, 0)[0 if step > 0 else -1] = False  # there it is the other side's
        found |= differs
    return found
