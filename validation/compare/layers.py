"""The layers of somebody else's .exr, under the names that clrt's own layers have in such a file.

`diffuse.R`, `diffuse.G`, `diffuse.B` are a colour, `depth.V` (or `depth.Z`) and `shape.ID` one number. Others
mean by `depth.Z` what clrt calls `z`: whether it is along the ray or planar is for who compares it to tell.
Names that nobody here knows, and layers of other parts than the picture's own, are passed over.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

import numpy as np
import OpenImageIO as oiio

from clrt.base.errors import SceneError
from clrt.base.limits import Limits
from clrt.images.file import open_picture
from clrt.images.header import find_picture

TERMS: Final = ("emission", "ambient", "diffuse", "highlight")
_COLOURS: Final = (*TERMS, "direct", "reflection", "transmission", *(f"generation_{n}" for n in range(64)))


def read_layers(path: Path, limits: Limits) -> dict[str, np.ndarray]:
    """Float (h, w, 3) or (h, w) by name. {} where the file stores another window than its picture's.

    SceneError for a file that is no picture or damaged, LimitError for one of too many samples.
    """
    with open_picture(path, limits) as (source, _):
        find_picture(source, os.fspath(path))
        spec = source.spec()
        window = (spec.x, spec.y, spec.width, spec.height)
        if window != (spec.full_x, spec.full_y, spec.full_width, spec.full_height) or spec.depth > 1:
            return {}
        numbers = {name: number for number, name in enumerate(spec.channelnames)}
        wanted = {name: [numbers[channel] for channel in channels]
                  for name, channels in _CHANNELS if all(c in numbers for c in channels)}  # fmt: skip
        if not wanted:
            return {}
        needed = 4 * spec.width * spec.height * spec.nchannels
        limits.check("image_bytes", needed, os.fspath(path))
        samples = source.read_image(source.current_subimage(), 0, 0, spec.nchannels, oiio.FLOAT)
        if samples is None:
            raise SceneError(f"{path}: its layers cannot be read")
        return {name: samples[..., channels if len(channels) > 1 else channels[0]].copy()
                for name, channels in wanted.items()}  # fmt: skip


_CHANNELS: Final = (
    *((name, tuple(f"{name}.{axis}" for axis in "RGB")) for name in _COLOURS),
    ("depth.Z", ("depth.Z",)), ("depth", ("depth.V",)), ("shape", ("shape.ID",)),
)  # fmt: skip
