"""Videos through PyAV (extra `clrt[video]`): frames in, one file out, whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any, Final

import numpy as np

from clrt.base.atomic import check_replaceable, replacing
from clrt.base.errors import ClrtError
from clrt.base.install import install_extra

# suffix -> codec, its pixels, options; all but .mkv lose something
_CODECS: Final[dict[str, tuple[str, str, dict[str, str]]]] = {
    ".mp4": ("libx264", "yuv420p", {"crf": "18"}),
    ".webm": ("libvpx-vp9", "yuv420p", {"crf": "24", "b": "0"}),
    ".mkv": ("ffv1", "bgr0", {}),
}
SUFFIXES: Final = tuple(_CODECS)
# what H.273 calls them: Rec.709's primaries, sRGB's curve; Rec.709's matrix, and not the full range, of YUV
_RGB: Final = {"color_primaries": 1, "color_trc": 13}
_YUV: Final = _RGB | {"colorspace": 1, "color_range": 1}


def check_video(path: str | os.PathLike[str], width: int, height: int) -> None:
    """ClrtError where no video of that size can be written there."""
    suffix = Path(path).suffix.lower()
    if suffix not in _CODECS:
        raise ClrtError(f"{path}: unknown suffix {suffix!r} of a video; use one of {', '.join(_CODECS)}")
    _av()
    if not _takes(suffix, width, height):
        even = "an even" if _CODECS[suffix][1] == "yuv420p" and (width % 2 or height % 2) else "another"
        other = "; or use .mkv" if suffix != ".mkv" and _takes(".mkv", width, height) else ""
        raise ClrtError(f"{path}: {suffix} needs {even} width and height, not {width} x {height}{other}")
    check_replaceable(path)


def _takes(suffix: str, width: int, height: int) -> bool:
    """Whether the codec takes pictures of that size; it alone knows."""
    av = _av()
    codec, pixels, options = _CODECS[suffix]
    if pixels == "yuv420p" and (width % 2 or height % 2):
        return False
    trial = av.CodecContext.create(codec, "w")
    trial.width, trial.height, trial.pix_fmt = width, height, pixels
    trial.time_base, trial.options = Fraction(1, 25), dict(options)
    try:
        trial.open()
    except (av.FFmpegError, ValueError, OverflowError):
        return False
    return True


@contextmanager
def writing(
    path: str | os.PathLike[str], width: int, height: int, rate: Fraction | float = 25
) -> Iterator[Callable[[np.ndarray], None]]:
    """Give a function that takes the next frame, uint8 (height, width, 3) in sRGB; `rate` frames a second.

    The file takes its name when the block ends. `.mkv` is FFV1, which keeps every bit. The others say that
    they are Rec.709 with sRGB's curve: without, players guess by the size, and greens become others.
    """
    check_video(path, width, height)
    av = _av()
    codec, pixels, options = _CODECS[Path(path).suffix.lower()]
    with replacing(path) as temporary:
        try:
            with av.open(str(temporary), "w") as container:
                exact = Fraction(rate).limit_denominator(1001)
                stream = container.add_stream(codec, rate=exact, options=options)
                stream.width, stream.height, stream.pix_fmt = width, height, pixels
                yuv = pixels.startswith("yuv")
                for name, number in (_YUV if yuv else _RGB).items():
                    setattr(stream.codec_context, name, number)

                def put(frame: np.ndarray) -> None:
                    picture = av.VideoFrame.from_ndarray(np.ascontiguousarray(frame), format="rgb24")
                    if yuv:
                        picture = picture.reformat(format=pixels, dst_colorspace="ITU709")
                    container.mux(stream.encode(picture))

                yield put
                container.mux(stream.encode())
        except av.FFmpegError as error:
            raise ClrtError(f"{path}: the video cannot be written: {error}") from None


def _av() -> Any:
    try:
        import av
    except ModuleNotFoundError:
        raise ClrtError(f"videos need PyAV; install it with: {install_extra('video')}") from None
    return av
