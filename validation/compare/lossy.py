"""What an EXR's own compression loses: measured on the right picture, by storing it as the file is stored.

DWAA, DWAB, B44 and B44A are to pictures of radiance what JPEG is to others. The header says which, but not
how hard DWA was told to press; the usual 45 is taken.
"""

from __future__ import annotations

import itertools
from typing import Final

import numpy as np
from scipy import ndimage

from clrt.base.limits import Limits
from clrt.base.scratch import scratch
from clrt.images.exrlayers import read_layers
from clrt.images.file import read_samples, write
from clrt.judging.verdict import LOSSY

from .metrics import Array, held, largest, parts

_AROUND: Final = 15  # pixels a side: what lies in one block of 8 x 8 with the middle one, wherever it begins
_ROWS: Final = 256  # no compression joins more; so many, or twice as many, ... are stored at a time
_STORED: Final = 1 << 20  # pixels at a time; of wide pictures parts of rows
_LARGEST: Final = 65504.0  # half float
_FREE: Final = Limits(**dict.fromkeys(("file_bytes", "image_pixels", "image_bytes"), 1 << 62))


def said(bits: int) -> str:
    """What to tell of a file of these bits, one of LOSSY."""
    less = "differences of no more than it makes at its usual level count as none; zip and piz lose nothing"
    return f"an EXR of the compression {LOSSY[bits]}, which loses: {less}"


def loss(right: Array, bits: int) -> Array:
    """(h, w): the most that the compression of `bits`, one of LOSSY, changes near each pixel of a picture
    (h, w, 3), or of a layer (h, w)."""
    height, width = right.shape[:2]
    found = np.empty((height, width), np.float32)
    together = min(max(height, 8), _ROWS)  # of rows that are longer still the compressions end badly
    columns = min(width, _STORED // together // 8 * 8)  # they are of blocks of 8 x 8
    rows = max(_STORED // columns // _ROWS, 1) * _ROWS
    for top, left in itertools.product(range(0, height, rows), range(0, width, columns)):
        part = slice(top, top + rows), slice(left, left + columns)
        off = np.abs(_stored(right[part], LOSSY[bits]) - right[part])
        found[part] = off if off.ndim == 2 else largest(off)
    found = np.nextafter(found, np.float32(np.inf))  # rounded, it may be less than the difference itself
    around: Array = ndimage.maximum_filter(found, _AROUND)
    return around


def _stored(right: Array, compression: str) -> Array:
    """Rows of a picture or layer as a file of this compression holds them."""
    values = np.clip(right, -_LARGEST, _LARGEST).astype(np.float16)
    with scratch() as folder:
        file = folder / "stored.exr"
        if values.ndim == 3:
            write(file, [values], metadata={"compression": compression})
            return read_samples(file, _FREE)
        both = [np.zeros((*values.shape, 3), np.float16), values[..., None]]
        write(file, both, ("R", "G", "B", "depth.V"), {"compression": compression})
        return read_layers(file, _FREE, ["depth"])[0]["depth"]


def told_apart(
    values: Array, reference: Array, bits: int, right: Array | None = None, times: float = 1.0
) -> Array:
    """Values with the reference's where a file of these bits, one of LOSSY, does not tell them apart.

    right: the one of the two that was not in that file; None: the reference. times: how much brighter these
    two are than what was stored, or how much more may be lost.
    """
    lost = loss(reference if right is None else right, bits)
    out = held(values, reference)
    for part, other, most in zip(parts(out), parts(reference), parts(lost), strict=True):
        off = np.abs(part - other)
        near = (off if off.ndim == 2 else largest(off)) <= times * most
        part[near] = other[near]
    return out
