"""The whole picture on the host, filled tile by tile."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from clrt import layout
from clrt.base.arguments import whole
from clrt.base.errors import ClrtError, fault, show
from clrt.base.layers import find


class Picture:
    """The pixels of a window (x, y, width, height) of a picture `full_width` wide, and its layers by name."""

    def __init__(
        self, window: tuple[int, int, int, int], full_width: int, names: Sequence[str], bands: int
    ) -> None:
        self.left, self.top, self.width, self.height = window
        self.full_width = full_width
        shape = (self.height, self.width)
        self.pixels = np.zeros((*shape, 3), np.float32)
        self.layers: dict[str, np.ndarray] = {}
        for name in names:
            layer = find(name)
            size = shape if layer.values == 1 else (*shape, layer.values or bands)
            self.layers[name] = np.zeros(size, layout.dtype(layer.kind))

    def put(self, pixels: np.ndarray, values: dict[str, np.ndarray]) -> None:
        """Place what was found for the pixels of these numbers: "image" and layers."""
        place = self.places(pixels)
        for name, found in values.items():
            if name == "image":
                _scatter(self.pixels, place, found)
            elif name in self.layers:
                _scatter(self.layers[name], place, found)

    def whole(self) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """The pixels and the layers, to which nobody writes any more."""
        for array in (self.pixels, *self.layers.values()):
            array.flags.writeable = False
        return self.pixels, self.layers

    def places(self, pixels: np.ndarray) -> np.ndarray:
        """Where in the flattened window the pixels of these numbers stand."""
        place = pixels.astype(np.intp)
        if (self.left, self.width) != (0, self.full_width):
            place = place // self.full_width * self.width + place % self.full_width - self.left
        place -= self.top * self.width
        return place


def picture_bytes(window: tuple[int, int, int, int], names: Sequence[str], bands: int) -> int:
    """Bytes that a Picture of that window with these layers takes, and the numbers of its pixels."""
    return 4 * window[2] * window[3] * (3 + 1 + sum(find(name).values or bands for name in names))


def _scatter(target: np.ndarray, place: np.ndarray, values: np.ndarray) -> None:
    """Put the values of pixels where they belong: whole pixels at a time, three times as fast."""
    # by name: of a pair numpy asks for a text, and drops the KeyboardInterrupt that may be raised there
    pixel = np.dtype(f"V{target.itemsize * (target.shape[2] if target.ndim == 3 else 1)}")
    whole = np.ascontiguousarray(values, target.dtype).view(pixel)
    target.view(pixel).reshape(-1)[place] = whole.reshape(-1)


def check_crop(crop: object, width: int, height: int) -> tuple[int, int, int, int]:
    """The window to render: `crop`, or all of it. ClrtError where it is not inside the picture."""
    if crop is None:
        return 0, 0, width, height
    if isinstance(crop, np.ndarray) and crop.shape == (4,):
        crop = crop.tolist()
    if not isinstance(crop, (tuple, list)) or len(crop) != 4:
        raise ClrtError(fault("", "crop", crop, "it must be 4 whole numbers: x, y, width and height"))
    x, y, w, h = (whole("crop", side, least=None) for side in crop)
    if w < 1 or h < 1 or x < 0 or y < 0 or x + w > width or y + h > height:
        text = " ".join(show(side) for side in (x, y, w, h))
        raise ClrtError(f"crop: {text} is not a part of the picture of {width} x {height} pixels")
    return x, y, w, h
