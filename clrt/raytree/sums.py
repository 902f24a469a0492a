"""What rays bring, added up as the film does it: float32, queue after queue, ray after ray, mean, colour."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Final

import numpy as np

from clrt import layout
from clrt.spectra.colorimetry import finished

if TYPE_CHECKING:
    from clrt.raytree.tree import Ray

_REC709: Final = (0.2126, 0.7152, 0.0722)  # luminance of linear red, green and blue


def pixel_of(
    rays: Sequence[Ray], samples: int, bands: int, response: np.ndarray | None, weights: Sequence[float] = ()
) -> np.ndarray:
    """The pixel (3,) float32: kernels `gather`, `resolve` and `develop` in film.cl.

    weights: of the samples; each is then summed by itself, and the pixel is their weighted mean (filter.cl).
    """
    with np.errstate(all="ignore"):
        if not weights:
            return developed(_bounded(_summed(rays, bands) / np.float32(samples)), response)
        apart: list[list[Ray]] = [[] for _ in weights]
        for ray in rays:
            apart[ray.sample].append(ray)
        total = np.zeros(bands, np.float32)
        alike = cancel(weights)
        for weight, own in zip(np.array(weights, np.float32), apart, strict=True):
            total += (np.float32(1) if alike else weight) * _bounded(_summed(own, bands))
        return developed(_bounded(total / (np.float32(samples) if alike else _added(weights))), response)


def cancel(weights: Sequence[float]) -> bool:
    """Do samples count alike, because three quarters of their weights or more cancel?"""
    return not _added(weights) > np.float32(0.25) * _added([abs(weight) for weight in weights])


def _added(weights: Sequence[float]) -> np.float32:
    """Their sum as the kernel finds it, in float32 and in their order."""
    return np.float32(np.add.accumulate(np.array(weights, np.float32))[-1])


def _bounded(light: np.ndarray) -> np.ndarray:
    return np.where(light <= np.float32(layout.BRIGHTEST), light, np.float32(layout.BRIGHTEST))


def _summed(rays: Sequence[Ray], bands: int) -> np.ndarray:
    """What rays bring, added up queue by queue: (bands,) float32."""
    film = np.zeros(bands, np.float32)
    for _, queue in groupby(rays, key=lambda ray: (ray.generation, ray.queue)):
        total, found = np.zeros(bands, np.float32), False
        for ray in queue:
            if ray.brings is not None:
                found = True
                here, values = carried(ray, bands)
                total[here] += values
        if found:
            film += total
    return film


def developed(means: np.ndarray, response: np.ndarray | None) -> np.ndarray:
    """(3,) float32 of a pixel's bands, each row of the response added up from the first band on."""
    if response is None:
        return finished(means)
    rows = response[:, 0] * means[0]
    for band in range(1, len(means)):
        rows = rows + response[:, band] * means[band]
    return finished(rows)


def carried(ray: Ray, bands: int) -> tuple[slice, np.ndarray]:
    """The bands that a ray carries, and what it brings of each: float32."""
    values = np.array(ray.brings or (), np.float32)
    last = min(ray.first_band + len(values), bands)
    return slice(ray.first_band, last), values[: last - ray.first_band]


def luminance_of(
    values: Sequence[float], first_band: int, bands: int, response: np.ndarray | None
) -> float:
    """How bright light in these bands is; not more than the kernels can hold, and 0 for what is no number."""
    rows = np.array(_REC709) if response is None else np.ones(bands)
    if response is not None and len(response) == 3:  # the thesis program's own colours are no sum of bands
        rows = np.array(_REC709) @ response
    light = np.nan_to_num(np.array(values, float), posinf=layout.BRIGHTEST)
    part = rows[first_band : first_band + len(light)]
    return float(part @ light[: len(part)])
