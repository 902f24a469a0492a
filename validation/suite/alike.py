"""Pictures of other programs beside one of ours or of an oracle's: as alike as their files let them be."""

from __future__ import annotations

import dataclasses
from functools import partial
from typing import Final

import numpy as np

from clrt.images.file import decode, encode
from clrt.judging.verdict import HALF, LOSSY

from ..compare.causes import BYTE
from ..compare.layers import TERMS
from ..compare.lossy import told_apart
from ..compare.metrics import PLACE, encoded, extended, held, largest, widest
from ..compare.oracle import Limits, compare, gate
from ..ours import ray_key
from ..types import Case, Comparison, OracleImage
from .program import Program, Rendered

_FAR: Final = 65504.0  # the largest half
_NEAR_BYTES: Final = 0.999  # share of pixels within 1.5 steps of 255, outside edges


def is_of_bytes(pixels: np.ndarray) -> bool:
    """Whether a linear picture holds no more than 8 bits of sRGB do."""
    return bool(np.array_equal(decode(encode(pixels)), pixels))


def alike(
    rendered: Rendered, reference: OracleImage, program: Program, eight: bool
) -> tuple[OracleImage, OracleImage]:
    """The program's picture, and the reference as a file of the same kind would hold it.

    Both have no more layers than the program wrote: what it does not tell apart is not compared.
    """
    assert rendered.pixels is not None
    terms = {ray_key(0, f"camera {name}"): rendered.layers[name] for name in TERMS if name in rendered.layers}
    by_ray = {key: values for key, values in reference.by_ray.items() if key in terms}
    pixels, (distance, expected) = rendered.pixels.astype(np.float64), _depths(rendered, reference)
    if rendered.bits in (HALF, *LOSSY) and pixels.shape == reference.pixels.shape:
        apart = partial(told_apart, bits=rendered.bits) if rendered.bits in LOSSY else held
        pixels = apart(pixels, reference.pixels)
        terms = {key: apart(terms[key], values) for key, values in by_ray.items()}
        if distance is not None and expected is not None:
            distance = apart(distance.astype(np.float64), expected)
    theirs = OracleImage(pixels, {key: terms[key] for key in by_ray}, distance, _shape(rendered),
                         program.name, rendered.seconds)  # fmt: skip
    pixels = reference.pixels
    if eight:
        pixels = decode(encode(pixels.astype(np.float32))).astype(np.float64)
    elif program.integer:
        pixels = np.clip(pixels, 0.0, 1.0)
    wanted = OracleImage(pixels, by_ray, expected, reference.shape, reference.name, reference.seconds)
    return theirs, wanted


def _depths(rendered: Rendered, reference: OracleImage) -> tuple[np.ndarray | None, np.ndarray | None]:
    """The program's distances and those to compare them with: along the rays, or of `depth.Z` planar, as
    compositors have it, where these are nearer. Where a ray meets nothing, others have 0 or what is far."""
    along, planar = reference.t, reference.layers.get("z")
    distance = rendered.layers.get("depth", rendered.layers.get("depth.Z"))
    if distance is None or along is None or distance.shape != along.shape:
        return distance, along
    distance = np.where(np.isinf(along) & ((distance <= 0) | (distance >= _FAR)), np.inf, distance)
    if "depth" in rendered.layers or planar is None:
        return distance, along
    seen = np.isfinite(along) & np.isfinite(distance)
    off = [np.abs(distance[seen] - values[seen]).sum() for values in (along, planar)]
    return distance, planar if off[1] < off[0] else along


def _shape(rendered: Rendered) -> np.ndarray | None:
    shape = rendered.layers.get("shape")
    return None if shape is None else np.nan_to_num(shape, nan=-2).astype(np.int64)


def compared(theirs: OracleImage, wanted: OracleImage, case: Case, eight: bool,
              edges: np.ndarray | None, limit: Limits) -> Comparison:  # fmt: skip
    """The comparison; of pictures of 8 bits in their steps, which are larger than what is asked else.

    Its shares of pixels pass an object that is small enough: so none may lack a place.
    """
    if theirs.pixels.shape != wanted.pixels.shape:
        return compare(theirs, wanted, edges, case.spp, limit)
    off = extended(theirs.pixels) - extended(wanted.pixels)
    side = widest(off if edges is None else np.where(edges[..., None], 0.0, off))
    place = gate("widest place", side, PLACE, "low", "pixels a side of what is off by more than 8 of 255")
    found = _compared(theirs, wanted, case, eight, edges, limit)
    return dataclasses.replace(found, gates=(*found.gates, place))


def _compared(theirs: OracleImage, wanted: OracleImage, case: Case, eight: bool,
              edges: np.ndarray | None, limit: Limits) -> Comparison:  # fmt: skip
    if not eight:
        return compare(theirs, wanted, edges, case.spp, limit)
    rough = dataclasses.replace(limit, fine=None, coarse=None, mean=2e-3, masked=None, rays=None)
    near = largest(encoded(theirs.pixels) - encoded(wanted.pixels)) <= BYTE
    # what differs by rounding does not differ: FLIP and the mean see bytes that are cut off, not rounded
    rounded = np.where(near[..., None], wanted.pixels, theirs.pixels)
    found = compare(dataclasses.replace(theirs, pixels=rounded), wanted, edges, case.spp, rough)
    near = near if edges is None else near[~edges]
    share = float(np.mean(near)) if near.size else 0.0
    more = gate("within 1.5 steps of 255", share, _NEAR_BYTES, "high", "share of pixels, outside edges")
    return dataclasses.replace(found, gates=(*found.gates, more))
