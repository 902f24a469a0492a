"""Picture files through OpenImageIO: what each suffix holds, writing whole files, reading linear pixels.

The display encoding is computed here, in float64, and handed over as integers, so that a picture's bytes
depend on its pixels alone and not on a library's idea of colour.
"""

from __future__ import annotations

import errno
import math
import os
import re
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, Final

import numpy as np

from clrt.base import notices
from clrt.base.atomic import check_replaceable, replacing
from clrt.base.elsewhere import without
from clrt.base.errors import ClrtError, SceneError
from clrt.base.files import opened
from clrt.base.hush import hushed
from clrt.base.limits import Limits
from clrt.base.room import process_limit
from clrt.images.bmp import check_bmp
from clrt.images.exr import check_exr
from clrt.images.header import (
    Window,
    check_meaning,
    check_samples,
    check_stored,
    find_picture,
    foreign_colours,
)
from clrt.images.jpeg import check_jpeg
from clrt.images.png import check_png
from clrt.images.tiff import check_tiff

if TYPE_CHECKING:
    import OpenImageIO as oiio
else:
    from clrt.images import library as oiio

# suffix -> bit depths that it can hold, the default first; 32 is linear float, 8 and 16 are sRGB integers
DEPTHS = {
    ".exr": (32,), ".png": (8, 16), ".tif": (8, 16), ".tiff": (8, 16),
    ".jpg": (8,), ".jpeg": (8,), ".bmp": (8,),
}  # fmt: skip

# first bytes -> the OpenImageIO reader that gets the file: a name's suffix proves nothing
MAGIC = {
    b"\x89PNG\r\n\x1a\n": "png", b"\xff\xd8\xff": "jpeg", b"v/1\x01": "openexr", b"BM": "bmp", b"#?": "hdr",
    b"II*\0": "tiff", b"MM\0*": "tiff", b"II+\0": "tiff", b"MM\0+": "tiff",
}  # fmt: skip
KINDS: Final = "EXR, HDR, PNG, JPEG, TIFF or BMP"
"""What `MAGIC` tells, as messages call it."""
_OPEN = "/proc/self/fd/{}"
_own_colours = False  # whether OpenImageIO has its own table of colour spaces
_unfinished: list[oiio.ImageOutput] = []
_HEAD = 1 << 16  # bytes of a JPEG beside its pixels, and more
BLOCK = 1 << 20  # bytes read at a time, where 64 rows have fewer
_PART = 1 << 15  # values encoded at a time: larger arrays come from the system, cleared, each time
_STRAIGHT = 0.0031308  # below that the curve of sRGB is a line
ROWS = 64  # encoded and written at a time: copies of a whole large picture would dwarf the picture


def own_colours() -> None:
    """Let OpenImageIO take its own table of colour spaces, before it takes the file that $OCIO names.

    It asks for one where a picture says what its colours are, and nothing here depends on it: but the file
    may be a pipe, that of another program, or as large as the disk.
    """
    global _own_colours
    if not _own_colours and "OCIO" in os.environ:
        with without("OCIO"):
            oiio.ColorConfig.default_colorconfig().getColorSpaceNames()  # it is read when it is asked
    _own_colours = True


def load_colours() -> None:
    """Let OpenImageIO make its table of colour spaces, as it does for the first file in sRGB: 20 ms."""
    if "OCIO" not in os.environ:  # `own_colours` does it, while no other thread is in a driver
        oiio.ColorConfig.default_colorconfig().getColorSpaceNames()


def check_writable(path: str | os.PathLike[str], exposure: float = 0.0, bits: int | None = None) -> int:
    """Check, before any work is done, that a picture can be saved at `path`; return its bits per sample.

    ClrtError when the suffix is unknown, `bits` or `exposure` do not suit it, or the file cannot be written.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in DEPTHS:
        known = ", ".join(DEPTHS)
        raise ClrtError(f"{path}: unknown suffix {suffix!r} of a picture; use one of {known}")
    depths = DEPTHS[suffix]
    if bits is not None and bits not in depths:
        right = "say nothing of bits" if depths == (32,) else f"use {' or '.join(map(str, depths))}"
        raise ClrtError(f"{path}: {suffix} holds {' or '.join(map(str, depths))} bits, not {bits}; {right}")
    if not np.isfinite(exposure) or abs(exposure) > 100:
        raise ClrtError(f"{path}: exposure = {exposure} stops; use a number from -100 to 100")
    if exposure != 0 and depths == (32,):
        raise ClrtError(f"{path}: exposure = {exposure}, but {suffix} holds the radiance itself; use 0")
    check_replaceable(path)
    return bits or depths[0]


def encode(pixels: np.ndarray, exposure: float = 0.0, bits: int = 8) -> np.ndarray:
    """Linear float32 (h, w, 3) -> sRGB uint8 or uint16: clip to [0, 1], sRGB curve, floor(max v + 1/2).

    `exposure` is in stops: 1 doubles the light. NaN becomes 0. Curve: IEC 61966-2-1.
    """
    encoded = np.empty(pixels.shape, np.uint8 if bits == 8 else np.uint16)
    top, flat, found = (1 << bits) - 1, pixels.reshape(-1), encoded.reshape(-1)

    def encode_part(start: int) -> None:
        part = slice(start, start + _PART)
        linear = flat[part].astype(np.float64)
        linear *= 2.0**exposure
        np.fmin(np.fmax(linear, 0.0, out=linear), 1.0, out=linear)  # unlike clip, these drop a NaN
        curve = np.fmax(linear, _STRAIGHT)  # what is less is on the straight part; 0 is slow to raise
        np.power(curve, 1 / 2.4, out=curve)
        curve *= 1.055
        curve -= 0.055
        curve = np.where(linear <= _STRAIGHT, 12.92 * linear, curve)
        curve *= top
        curve += 0.5
        found[part] = curve  # truncated: floor, as it is positive

    parts = range(0, flat.size, _PART)
    try:
        with ThreadPoolExecutor(min(os.cpu_count() or 1, 4)) as threads:  # numpy lets them work together
            list(threads.map(encode_part, parts))
    except RuntimeError:  # there is no room for another thread
        for start in parts:
            encode_part(start)
    return encoded


def uncurved(values: np.ndarray) -> np.ndarray:
    """Linear float32 of values in [0, 1] that a file shall hold as they are: `encode` undone."""
    linear = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    return linear.astype(np.float32)


def decode(encoded: np.ndarray) -> np.ndarray:
    """sRGB uint8 or uint16 -> linear float32 of the same shape (the inverse curve of `encode`)."""
    value = np.arange(np.iinfo(encoded.dtype).max + 1, dtype=np.float64) / np.iinfo(encoded.dtype).max
    return uncurved(value)[encoded]


def write(
    path: str | os.PathLike[str],
    parts: Sequence[np.ndarray],
    channels: tuple[str, ...] = ("R", "G", "B"),
    metadata: Mapping[str, str] | None = None,
) -> None:
    """Write arrays (h, w, any number of channels) side by side, as they are; replace `path` as a whole.

    The first one is uint8, uint16, float16 or float32, and so are the samples. `channels` names them all;
    `metadata` becomes text attributes where the format has such (EXR, PNG).
    """
    own_colours()
    height, width, _ = parts[0].shape
    sample_type = {"float16": "half", "float32": "float"}.get(parts[0].dtype.name, parts[0].dtype.name)
    spec = oiio.ImageSpec(width, height, len(channels), sample_type)
    spec.channelnames = channels
    spec.attribute("DateTime", "")  # else EXR and TIFF get the time of day, and no two files would be equal
    if parts[0].dtype.kind == "u":
        spec.attribute("oiio:ColorSpace", "sRGB")
    if Path(path).suffix.lower() in (".jpg", ".jpeg"):
        least = 2 * spec.image_bytes() + _HEAD
        if process_limit("RLIMIT_FSIZE") < least:  # libjpeg ends the process at that, too
            text = f"ulimit -f: a JPEG may need {least >> 10} KiB; allow that, or save a .png"
            raise ClrtError(f"{path}: cannot be written: {text}")
        spec.attribute("Compression", "jpeg:95")
        spec.attribute("jpeg:subsampling", "4:4:4")
    spec.attribute("png:compressionLevel", 4)  # of 9: two thirds of the usual time, for 6 % more bytes
    for key, text in (metadata or {}).items():
        spec.attribute(key, text)
    with replacing(path) as temporary, _surely(temporary) as scratch, hushed():
        output = oiio.ImageOutput.create(Path(path).suffix.lower().removeprefix("."))
        if output is None:
            raise ClrtError(f"{path}: {_words(oiio)}")
        try:
            done = output.open(scratch, spec)
            for row in range(0, height if done else 0, ROWS):
                block = np.concatenate([p[row : row + ROWS].astype(parts[0].dtype) for p in parts], axis=2)
                done = done and output.write_scanlines(row, row + len(block), 0, block)
            done = output.close() and done
        except KeyboardInterrupt:
            _unfinished[:] = [output]  # libpng complains where it is given up: not before the end
            raise
        if not done:
            raise ClrtError(f"{path}: cannot be written: {_words(output)}")


@contextmanager
def _surely(file: Path) -> Iterator[str]:
    """A name for OpenImageIO to write to; what it wrote is whole in `file` when the block ends, or OSError.

    On a full disk its PNG writer says nothing, EXR and TIFF nothing about the last bytes, and JPEG ends the
    process. So it writes to memory, and we to the disk; where there are no files in memory, or files have a
    limit (`ulimit -f`), we read what it wrote.
    """
    limit = math.inf
    if hasattr(os, "memfd_create"):
        limit = process_limit("RLIMIT_FSIZE")  # which holds for files in memory, too
        with open(os.memfd_create("clrt"), "w+b") as memory, file.open("wb") as target:
            yield f"/proc/self/fd/{memory.fileno()}"
            shutil.copyfileobj(memory, target, 1 << 20)
        if limit == math.inf:
            return
    else:
        yield str(file)
    if file.stat().st_size >= limit:
        raise OSError(errno.EFBIG, os.strerror(errno.EFBIG))
    try:
        read_samples(file)
    except ClrtError as error:
        raise OSError(str(error)) from None


Decoder = Callable[[np.ndarray], np.ndarray]
"""Float32 of the same shape from samples of 8 or 16 bits or floats."""


def read_image(
    path: str | os.PathLike[str], limits: Limits | None = None, decoder: Decoder | None = None
) -> np.ndarray:
    """As `clrt.images.image.read_image`, which checks its arguments first; `decoder` as `read_samples`."""
    linear = read_samples(path, limits, decoder)
    for row in range(0, len(linear), ROWS):
        bad = np.argwhere(~np.isfinite(linear[row : row + ROWS]))
        if len(bad):
            y, x, channel = (int(index) for index in bad[0])
            value = linear[row + y, x, channel]
            raise SceneError(f"{path}: pixel ({x}, {row + y}) is {value}; a scene needs finite numbers")
    return linear


def read_samples(
    path: str | os.PathLike[str], limits: Limits | None = None, decoder: Decoder | None = None
) -> np.ndarray:
    """As `read_image`, but NaN and infinity pass: what is in the file, to compare or to hash.

    decoder: what makes linear numbers of samples; None: integers are sRGB, floats are taken as they are.
    """
    limits = limits or Limits()
    name = os.fspath(path)
    with open_picture(path, limits) as (source, file):
        channels, window = _checked(source, file, name, limits)
        spec = source.spec()
        check_samples(spec, range(*channels), name)
        if source.format_name() == "tiff":
            check_stored(spec, file, source.current_subimage(), name)
        integer = spec.format.basetype in (oiio.UINT8, oiio.UINT16)
        linear = window.picture()
        for row, samples in row_blocks(source, spec, channels):
            if samples is None:
                raise SceneError(f"{path}: cannot be read: {_words(source)}")
            plain = decode(samples) if integer and decoder is None else samples
            window.put(linear, row, plain if decoder is None else decoder(samples))
        foreign = foreign_colours(spec, file, source.format_name(), source.current_subimage(), name)
    if foreign and decoder is None:  # not before: what is written to standard error within is dropped
        notices.warn(name, "", foreign)
    return linear


def picture_shape(path: str | os.PathLike[str], limits: Limits) -> tuple[int, int]:
    """Height and width of a picture, by its header. Raises as `read_image` for what a header can say."""
    with open_picture(path, limits) as (source, file):
        _, window = _checked(source, file, os.fspath(path), limits)
        return window.height, window.width


def _checked(source: Any, file: BinaryIO, name: str, limits: Limits) -> tuple[tuple[int, int], Window]:
    """The range of the channels with the colours of an open file's picture, and where in it samples stand.

    SceneError where these are no colours, LimitError where the picture is too large.
    """
    channels = find_picture(source, name)
    spec = source.spec()
    check_meaning(spec, name)
    window = Window.of(spec, source.format_name(), name, file)
    limits.check("image_pixels", max(window.width * window.height, spec.width * spec.height), name)
    limits.check("image_bytes", bytes_to_read(spec, source.format_name()), name)
    return channels, window


def row_blocks(source: Any, spec: oiio.ImageSpec, channels: tuple[int, int]) -> Iterator[tuple[int, Any]]:
    """These channels of some rows at a time, after the number of the first; None where reading fails."""
    first, last = channels
    top, left = spec.y, spec.x  # of what is stored: an EXR may store a part of its picture, or more
    step = _rows_at_a_time(spec)
    for row in range(0, spec.height, step):
        rows = top + row, top + min(row + step, spec.height)
        if spec.tile_width:
            yield row, source.read_tiles(left, left + spec.width, *rows, 0, 1, first, last, spec.format)
        else:
            yield row, source.read_scanlines(*rows, 0, first, last, spec.format)


def _rows_at_a_time(spec: oiio.ImageSpec) -> int:
    """Whole tiles, and so many rows that narrow pictures do not take millions of calls."""
    least = max(ROWS, BLOCK // (spec.width * spec.nchannels * spec.channel_bytes()))
    tile = spec.tile_height or 1
    return -(-least // tile) * tile


def bytes_to_read(spec: oiio.ImageSpec, reader: str) -> int:
    """What reading takes: the pixels as float32, and what the decoder unpacks at a time, all channels of it.

    That is some rows of tiles, a TIFF's strip, at most 256 rows of an EXR or HDR; others may need all rows
    at once (an interlaced PNG, a progressive JPEG).
    """
    rows, width = spec.height, spec.width
    pixels = rows * width
    if reader == "openexr":  # its display window is the picture
        pixels = max(pixels, spec.full_width * spec.full_height)
    if spec.tile_width:  # OpenImageIO joins the tiles, then cuts out the channels
        rows, width = 2 * _rows_at_a_time(spec), -(-width // spec.tile_width) * spec.tile_width
    elif reader in ("openexr", "hdr"):
        rows = min(rows, max(256, _rows_at_a_time(spec)))
    elif reader == "tiff":
        rows = min(rows, _rows_at_a_time(spec) + spec.get_int_attribute("tiff:RowsPerStrip", rows))
    return 12 * pixels + width * rows * spec.nchannels * spec.channel_bytes()


_CHECKS: Final[dict[str, Callable[[BinaryIO, str], None]]] = {
    "jpeg": check_jpeg, "png": check_png, "bmp": check_bmp, "tiff": check_tiff,
    "openexr": check_exr,
}  # fmt: skip
"""What is looked at before the library opens a file."""


@contextmanager
def open_picture(path: str | os.PathLike[str], limits: Limits) -> Iterator[tuple[oiio.ImageInput, BinaryIO]]:
    """OpenImageIO's reader of a picture, closed in the end, and the file itself."""
    own_colours()
    with hushed(), opened(path, limits) as file:
        head = file.read(8)
        reader = reader_of(head)
        if reader is None:
            raise SceneError(f"{path}: not an {KINDS} picture")
        if reader in _CHECKS:
            _CHECKS[reader](file, os.fspath(path))
        keep_alpha_apart = oiio.ImageSpec()
        keep_alpha_apart.attribute("oiio:UnassociatedAlpha", 1)
        source = oiio.ImageInput.open(_name(path, file), keep_alpha_apart)
        if source is None or source.format_name() != reader:
            raise SceneError(f"{path}: cannot be read: {_words(oiio, reader)}")
        try:
            yield source, file
        finally:
            source.close()


def reader_of(head: bytes) -> str | None:
    """The OpenImageIO reader of what begins so, of which 8 bytes are enough; None of what is not read."""
    return next((name for magic, name in MAGIC.items() if head.startswith(magic)), None)


def _name(path: str | os.PathLike[str], file: BinaryIO) -> str:
    """A name for OpenImageIO, which opens files anew: that of the open file, where the system has such.

    What has been looked at is then what is read, even if another file, or a pipe, takes its name meanwhile.
    """
    name = _OPEN.format(file.fileno())
    if os.path.exists(name):
        return name
    name = os.fspath(path)
    try:
        name.encode("utf-8")
    except UnicodeEncodeError:
        raise SceneError(f"{path}: its name is not UTF-8, which the picture library needs") from None
    return name


def _words(library: Any, reader: str = "") -> str:
    """What OpenImageIO or its reader says went wrong, quotes of broken text cut short."""
    try:
        said = str(library.geterror())
    except UnicodeDecodeError:
        return "its contents are broken"
    if "format reader" in said:  # it tried all its readers, and forgot what this one said
        most = oiio.get_int_attribute("limits:channels")
        return f"as {reader} it is broken, or more than OpenImageIO takes ({most} channels)"
    if not said.strip():  # as of a strip of another size
        return "a part of it is broken, or unpacks to another size than it declares"
    return re.sub(_OPEN.format(r"\d+"), "the file", said)[:300]
