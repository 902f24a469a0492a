"""Picture files as the texels of surfaces: colours, light or normals, linear float32."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import partial
from typing import Literal

import numpy as np

from clrt.base.errors import SceneError
from clrt.base.limits import Limits
from clrt.images.file import decode, picture_shape, read_image, uncurved
from clrt.images.levels import level_sizes

Role = Literal["reflectance", "light", "normal"]
_MIDDLE = {np.uint8: 128.0, np.uint16: 32768.0}  # the number that stands for 0 in maps of normals


def texture_bytes(path: str | os.PathLike[str], limits: Limits, levels: bool = False) -> int:
    """Bytes of a picture's texels, by its header. SceneError and LimitError as `read_image`.

    levels: with those of its mip levels.
    """
    shape = picture_shape(path, limits)
    sizes = [shape, *level_sizes(*shape)] if levels else [shape]
    return sum(12 * height * width for height, width in sizes)


def read_texels(
    path: str | os.PathLike[str],
    role: Role,
    encoding: str | None,
    limits: Limits,
    tint: Sequence[float] = (1.0, 1.0, 1.0),
) -> np.ndarray:
    """Linear float32 (height, width, 3), rows from the top; a grey picture's channel three times.

    encoding: "srgb", "linear", or None: integers are sRGB, floats linear; of normals always linear.
    `tint` multiplies them. Reflectances are clipped to [0, 1], light to >= 0, normals lie about 0. Raises as
    `clrt.read_image`, also where decoded numbers are not finite.
    """
    return finished(read_plain(path, role, encoding, limits), role, tint, os.fspath(path))


def read_plain(
    path: str | os.PathLike[str], role: Role, encoding: str | None, limits: Limits
) -> np.ndarray:
    """As `read_texels`, but neither tinted nor clipped."""
    values: Callable[[np.ndarray], np.ndarray] | None = partial(_values, encoding) if encoding else None
    return read_image(path, limits, _normals if role == "normal" else values)


def finished(
    texels: np.ndarray, role: Role, tint: Sequence[float], name: str, corners: bool = False
) -> np.ndarray:
    """Plain texels, tinted and clipped in place; `name` is what a SceneError calls the picture.

    corners: they are those of triangles (clrt.meshfiles.vertex_colors), of whose squares each fourth may be
    out of range, since no triangle shows it.
    """
    if any(part != 1.0 for part in tint):
        with np.errstate(all="ignore"):
            texels *= np.array(tint, np.float32)
        if not np.isfinite(texels).all():
            raise SceneError(f"{name}: times its tint it leaves the range of float32")
    if corners:
        if role == "normal":
            raise SceneError(f"{name}: colours of vertices or faces are no normals")
        _clip_corners(texels, 1.0 if role == "reflectance" else np.inf)
    elif role == "reflectance":
        np.clip(texels, 0.0, 1.0, out=texels)
    elif role == "light":
        np.maximum(texels, 0.0, out=texels)
    return texels


def _clip_corners(texels: np.ndarray, most: float) -> None:
    """Clip the three corners in each square of texels; the fourth is then what keeps the square linear."""
    rows, columns = texels.shape[:2]
    squares = texels.reshape(rows // 2, 2, columns // 2, 2, 3)
    shown = squares[:, 0, :, 0], squares[:, 0, :, 1], squares[:, 1, :, 0]
    beyond = np.any([(corner < 0.0) | (corner > most) for corner in shown], axis=0)
    if not beyond.any():
        return
    for corner in shown:
        np.clip(corner, 0.0, most, out=corner)
    a, b, c = shown
    squares[:, 1, :, 1][beyond] = (b + c - a)[beyond]


def _values(encoding: str, samples: np.ndarray) -> np.ndarray:
    integer = samples.dtype.kind == "u"
    if encoding == "srgb":
        with np.errstate(invalid="ignore"):  # of negative numbers, of which the straight part is taken
            return decode(samples) if integer else uncurved(samples)
    return (samples / float(np.iinfo(samples.dtype).max)).astype(np.float32) if integer else samples


def _normals(samples: np.ndarray) -> np.ndarray:
    """Components of normals, but for -128/127, which `max` with -1 makes -1 once it was filtered."""
    if samples.dtype.kind != "u":
        return 2.0 * samples - 1.0
    middle = _MIDDLE[samples.dtype.type]
    return ((samples - middle) / (middle - 1.0)).astype(np.float32)
