"""Pictures and maps as small PNGs that a page holds inside itself, and that its script reads values from.

A reference is stored as the exclusive or of its bytes and ours: exact, and next to nothing where both agree.
Maps are bytes on scales that show small values as well as large ones; the page has the inverse of each scale.
"""

from __future__ import annotations

import base64
import io
from typing import Any

import numpy as np

from clrt.images.file import encode

from ..types import Comparison, OracleImage

FLOOR = 1e-5  # smallest difference that is shown; rounding is below
DECADES = 5.5  # from FLOOR to the largest
_LEVELS = 127  # of each sign


def signed_bytes(difference: np.ndarray) -> np.ndarray:
    """Differences as bytes: 128 for less than FLOOR, then a logarithmic scale up for + and down for -."""
    size = np.abs(np.nan_to_num(difference, nan=np.inf))
    with np.errstate(divide="ignore"):
        level = 1 + np.round((_LEVELS - 1) * np.log10(size / FLOOR) / DECADES)
    level = np.where(size < FLOOR, 0, np.clip(level, 1, _LEVELS))
    return (128 + np.where(difference < 0, -level, level)).astype(np.uint8)


def root_bytes(values: np.ndarray) -> np.ndarray:
    """Values from 0 to 1 as bytes: 255 times their root."""
    return np.round(255 * np.sqrt(np.clip(np.nan_to_num(values, nan=1.0), 0, 1))).astype(np.uint8)


def picture_bytes(pixels: np.ndarray) -> np.ndarray:
    """A linear picture as the sRGB bytes that a saved one has."""
    return encode(np.asarray(pixels, np.float32))


def png(array: np.ndarray) -> str:
    """Base64 of a PNG of bytes (h, w) or (h, w, 3)."""
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(array).save(file, "PNG", optimize=True)
    return base64.b64encode(file.getvalue()).decode("ascii")


def case_pictures(ours: OracleImage, results: dict[str, tuple[OracleImage, Comparison]]) -> dict[str, Any]:
    """What the page's viewer needs of a case; {} where the pictures were not kept.

    An oracle whose picture is of another size has none here.
    """
    if not ours.pixels.size:
        return {}
    mine = picture_bytes(ours.pixels)
    oracles = {}
    for name, (image, comparison) in results.items():
        maps = comparison.maps
        if image.pixels.shape != ours.pixels.shape or not maps:
            continue
        oracles[name] = {
            "reference": png(picture_bytes(image.pixels) ^ mine),
            "difference": png(signed_bytes(maps["difference"])),
            "ssim": png(root_bytes(1 - maps["ssim"])),
            "mask": png((maps["mask"] > 0).astype(np.uint8) * 255),
        }
        if "flip" in maps:
            oracles[name]["flip"] = png(root_bytes(maps["flip"]))
    height, width = mine.shape[:2]
    return {"width": width, "height": height, "ours": png(mine), "oracles": oracles}
