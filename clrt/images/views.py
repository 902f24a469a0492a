"""Views: how light becomes a display's colours, other than by the sRGB curve alone, through OpenColorIO.

The views are those that OpenColorIO's built-in configuration has for an sRGB display, ACES 2.0 among them.
They come with OpenImageIO, and need neither files nor variables of the environment ($OCIO is not read).
"""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from clrt.base.arguments import public
from clrt.base.errors import ClrtError, fault, show
from clrt.base.suggest import nearest
from clrt.images.file import encode, own_colours

if TYPE_CHECKING:
    import OpenImageIO as oiio
else:
    from clrt.images import library as oiio

CONFIG: Final = "ocio://default"
DISPLAY: Final = "sRGB - Display"
_LINEAR: Final = "Linear Rec.709 (sRGB)"
_BRIGHTEST: Final = 65504.0  # far beyond what any view tells from white
_SIDE: Final = 1 << 20  # pixels at a time


@public
def views() -> tuple[str, ...]:
    """The names of all views, for `Image.save`. ClrtError where the installed OpenImageIO has none."""
    return _views(CONFIG)


@cache
def _views(name: str) -> tuple[str, ...]:
    own_colours()
    config = oiio.ColorConfig(name)
    names: tuple[str, ...] = () if config.geterror() else tuple(config.getViewNames(DISPLAY))
    if not names or _LINEAR not in config.getColorSpaceNames():
        text = "OpenImageIO 3.2 or newer has them; install that, or leave the view out"
        raise ClrtError(f"view: OpenImageIO {oiio.VERSION_STRING} has no built-in views: {text}")
    return names


def check_view(view: str) -> str:
    """The name of a view. ClrtError lists them all for another."""
    known = views()
    if view not in known:
        near = nearest(view, known, cutoff=0.6)
        hint = f"did you mean {near!r}? " if near else ""
        raise ClrtError(f"view: {show(view)} is none; {hint}there are " + ", ".join(map(repr, known)))
    return view


def check_shown(path: str | os.PathLike[str], bits: int, view: object) -> None:
    """ClrtError where a picture file of so many bits cannot hold a view, or there is no such view."""
    if view is None:
        return
    if not isinstance(view, str):
        raise ClrtError(fault("", "view", view, "it must be the name of a view: clrt.views() has them"))
    if bits == 32:
        suffix = Path(path).suffix
        raise ClrtError(f"{path}: view = {show(view)}, but {suffix} holds the radiance itself; leave it out")
    check_view(view)


def encode_view(
    pixels: np.ndarray, exposure: float = 0.0, bits: int = 8, view: str | None = None
) -> np.ndarray:
    """Linear float32 (h, w, 3) -> uint8 or uint16 as an sRGB display shows them in the view.

    `exposure` is in stops, and comes first. NaN becomes 0; what the display cannot show is clipped. Rounded
    as `file.encode` rounds, which it is without a view.
    """
    if view is None:
        return encode(pixels, exposure, bits)
    check_view(view)
    encoded = np.empty(pixels.shape, np.uint8 if bits == 8 else np.uint16)
    rows = max(1, _SIDE // pixels.shape[1])
    for row in range(0, len(pixels), rows):
        light = pixels[row : row + rows].astype(np.float64) * 2.0**exposure
        light = np.fmin(np.fmax(light, -_BRIGHTEST), _BRIGHTEST)
        shown = _shown(np.where(np.isnan(pixels[row : row + rows]), 0.0, light).astype(np.float32), view)
        top = (1 << bits) - 1
        encoded[row : row + rows] = np.floor(top * np.clip(shown.astype(np.float64), 0.0, 1.0) + 0.5)
    return encoded


def _shown(light: np.ndarray, view: str) -> Any:
    source = oiio.ImageBuf(np.ascontiguousarray(light))
    out = oiio.ImageBufAlgo.ociodisplay(source, DISPLAY, view, fromspace=_LINEAR, colorconfig=CONFIG)
    if out.has_error:
        raise ClrtError(f"view: {view!r}: {out.geterror()}")
    return out.get_pixels(oiio.FLOAT)
