"""What a picture file says of its own samples: which part is the picture, which way up, in which colours.

Whoever wrote the file relies on it, and viewers follow it: a reader that did not would show another picture
without a word. What the samples mean is followed, or refused; colours that are read as others are told of.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, BinaryIO, Final

import numpy as np

from clrt.base.errors import SceneError, show
from clrt.images import bmp, icc, png, tiff
from clrt.images.tiff import MEANING, MOST_PARTS, REC709, SAMPLES_A_PIXEL, first_values

if TYPE_CHECKING:
    import OpenImageIO as oiio
else:
    from clrt.images import library as oiio

_TURNED: Final = (5, 6, 7, 8)  # orientations; what is in none of these is upright
_ROWS_BACK: Final = (3, 4, 6, 7)
_COLUMNS_BACK: Final = (2, 3, 7, 8)
_COMPOSITE: Final = "Composite"  # Blender's name of what its compositor made of all view layers
_COMBINED: Final = ".Combined."  # Blender's name, after its view layer's, of what all others call R, G, B
_REDUCED: Final = 1  # bit of TIFF's NewSubfileType: a smaller copy of another page
_PHOTOMETRIC: Final = "tiff:PhotometricInterpretation"
_WHITE_IS_ZERO: Final = 0
_KNOWN: Final = (1, 2, 3, 5, 6)  # grey, RGB, palette, CMYK, YCbCr: the library makes RGB of them
_PALETTE: Final = 3
_PALETTE_BITS: Final = (1, 2, 4, 8)
_BITS: Final = {  # of a TIFF's samples, by their type as the library gives them
    "uint8": (1, 2, 4, 8), "uint16": (10, 12, 14, 16), "half": (16,), "float": (32,), "double": (64,),
}  # fmt: skip
_EXIF, _EXIF_SRGB = "Exif:ColorSpace", 1
_NEAR: Final = 0.03  # of a chromaticity: Radiance's own primaries, with the white E, are as near
_SRGB: Final = re.compile(r"(?i)srgb_rec709|srgb(_tx|_texture)?$|g22_rec709|gamma2\.2")  # 2.2: sRGB to 0.01
_LINEAR: Final = re.compile(r"(?i)lin_rec709|lin_srgb|linear|scene_linear")
_SRGB_PROFILE: Final = re.compile(r"(?i)srgb|^c2$|gray gamma 2\.2|sgray")  # c2: a short sRGB of the web
_REC709_PROFILE: Final = re.compile(r"(?i)srgb|rec\W?709|bt\W?709|sgray|linear gr[ae]y")
_RADIANCE: Final = re.compile(rb"^(EXPOSURE|COLORCORR|GAMMA|PRIMARIES)[ \t]*=[ \t]*([^\r\n]*)", re.MULTILINE)
_AXES: Final = re.compile(rb"([+-][XY])[ \t]+\d+[ \t]+([+-][XY])")
# what a row and a step within it lead along, from orientation 1 on; the Y of Radiance points up
_WAYS: Final = (b"-Y+X", b"-Y-X", b"+Y-X", b"+Y+X", b"+X-Y", b"-X-Y", b"-X+Y", b"+X+Y")
_HEAD: Final = 1 << 16  # bytes in which a Radiance header ends
_HEAD_ENDS: Final = re.compile(rb"\r?\n\r?\n")


def find_picture(source: Any, name: str) -> tuple[int, int]:
    """Go to the part of an open file that is its picture; the range of the channels with its colours.

    That is an EXR's first part with R, G and B, or those of its composite or only view layer, a TIFF's first
    page that is no reduced copy, else the first part. SceneError where that has neither these colours nor one
    channel alone, a grey.
    """
    reader, chosen, views = source.format_name(), None, dict[str, int]()
    for part in range(MOST_PARTS if reader in ("openexr", "tiff") else 1):
        if part and not source.seek_subimage(part, 0):
            source.geterror()  # there are no more: not an error
            break
        spec = source.spec()
        if reader == "openexr":
            views |= dict.fromkeys(_view_layers(spec.channelnames), part)
            fits = _unnamed(spec.channelnames) is not None
        else:
            fits = not spec.get_int_attribute("tiff:subfiletype") & _REDUCED
        if fits:
            chosen = part
            break
    if chosen is None:
        if len(views) > 1 and _COMPOSITE not in views:
            told = show(", ".join([*views][:9]))
            raise SceneError(f"{name}: each of its view layers {told} has a picture; save one of them alone")
        chosen = views.get(_COMPOSITE, next(iter(views.values()), 0))
    if source.current_subimage() != chosen:
        source.seek_subimage(chosen, 0)
    names = source.spec().channelnames
    channels = _colour_channels(names)
    if not range(*channels):
        if reader != "openexr":  # the names are the library's own
            told = f"its {len(names)} channels are neither R, G and B nor a grey one with its alpha"
            raise SceneError(f"{name}: {told}; save it as RGB")
        told = show(", ".join(names[:9]))
        raise SceneError(f"{name}: its channels are {told}; R, G and B are read, or a grey one alone")
    return channels


def check_meaning(spec: oiio.ImageSpec, name: str) -> None:
    """Raise SceneError for samples that are not colours of a flat picture."""
    if spec.deep:  # the library takes their bytes for those of flat ones
        raise SceneError(f"{name}: its pixels are deep, lists of samples; flatten it, flat pictures are read")
    if max(spec.depth, spec.tile_depth) > 1:
        layers = max(spec.depth, spec.tile_depth)
        raise SceneError(f"{name}: {layers} layers of pixels; flat pictures are read")
    meaning = spec.get_int_attribute(_PHOTOMETRIC, _KNOWN[0])
    # the library turns white and black round in samples of 8 bits, and in no others
    if meaning not in _KNOWN and (meaning != _WHITE_IS_ZERO or spec.format.basetype != oiio.UINT8):
        said = f"{meaning}, white is 0" if meaning == _WHITE_IS_ZERO else str(meaning)
        raise SceneError(f"{name}: its PhotometricInterpretation is {said}; save it as RGB")


def check_samples(spec: oiio.ImageSpec, channels: Iterable[int], name: str) -> None:
    """Raise SceneError for samples, of the channels that are read, that are neither 8 or 16 bits nor floats.

    Each channel of an EXR has a type of its own; the library makes fractions of 2^32 of whole numbers beside
    floats.
    """
    for channel in channels:
        kind = spec.channelformat(channel)
        if kind.basetype not in (oiio.UINT8, oiio.UINT16, oiio.HALF, oiio.FLOAT, oiio.DOUBLE):
            which = f" in channel {show(spec.channelnames[channel])}" if spec.channelformats else ""
            raise SceneError(f"{name}: samples of type {kind}{which}; 8 or 16 bits or floats are read")


def check_stored(spec: oiio.ImageSpec, file: BinaryIO, page: int, name: str) -> None:
    """Raise SceneError for samples of a TIFF that the library is not known to unpack rightly."""
    bits = spec.get_int_attribute("tiff:BitsPerSample") or spec.get_int_attribute("oiio:BitsPerSample")
    said = first_values(file, page, name)
    if said.get(MEANING) == _PALETTE:
        if spec.nchannels != 3:  # the samples themselves are read
            raise SceneError(f"{name}: its palette is missing or short; save it as RGB")
        if bits not in _PALETTE_BITS:
            raise SceneError(f"{name}: numbers of {bits} bits in its palette; 1, 2, 4 or 8 bits are read")
        if (each := said.get(SAMPLES_A_PIXEL, 1)) != 1:
            raise SceneError(f"{name}: {each} samples a pixel beside a palette; one alone is read")
    elif bits not in _BITS[str(spec.format)]:
        right = "1, 2, 4, 8, 10, 12, 14 or 16 bits or floats of 16, 32 or 64 are read"
        raise SceneError(f"{name}: samples of {bits} bits as {spec.format}; {right}")
    apart = spec.nchannels > 1 and _text(spec, "planarconfig") == "separate"
    if bits == 64 and spec.tile_width and not apart:
        raise SceneError(f"{name}: tiles of floats of 64 bits; strips of them are read, or floats of 32 bits")


@dataclass(frozen=True)
class Window:
    """Where the samples of a file stand in its picture of `width` x `height`, both as they are stored.

    The first sample stands at (left, top). What the file does not store is black, what it stores beyond the
    edges is left out: an EXR's display window is the picture. `orientation` as EXIF and TIFF number it.
    """

    left: int
    top: int
    width: int
    height: int
    orientation: int

    @staticmethod
    def of(spec: oiio.ImageSpec, reader: str, name: str, file: BinaryIO) -> Window:
        """The window of a file, open for reading; SceneError where it stores nothing of its picture."""
        orientation = spec.get_int_attribute("Orientation", 1)
        if reader == "hdr":  # the library takes two of the eight ways for each other
            orientation = _orientation(file)
        if reader != "openexr":  # others know no more than what they store
            return Window(0, 0, spec.width, spec.height, orientation)
        left, top = spec.x - spec.full_x, spec.y - spec.full_y
        beyond = left >= spec.full_width or top >= spec.full_height
        if beyond or left + spec.width <= 0 or top + spec.height <= 0:
            raise SceneError(f"{name}: its data window lies outside of its display window")
        return Window(left, top, spec.full_width, spec.full_height, orientation)

    def picture(self, channels: int = 3) -> np.ndarray:
        """Float32 (height, width, channels), or turned; black, to be filled."""
        turned = self.orientation in _TURNED
        size = (self.width, self.height) if turned else (self.height, self.width)
        return np.zeros((*size, channels), np.float32)

    def put(self, picture: np.ndarray, row: int, samples: np.ndarray) -> None:
        """Place samples (rows, width, channels or 1), `row` rows below the first one that is stored."""
        top, left = self.top + row, self.left
        rows = range(max(top, 0), min(top + samples.shape[0], self.height))
        columns = range(max(left, 0), min(left + samples.shape[1], self.width))
        if rows:
            inside = samples[rows[0] - top : rows[-1] + 1 - top, columns[0] - left : columns[-1] + 1 - left]
            stored = _as_stored(picture, self.orientation)
            stored[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1] = inside


def foreign_colours(spec: oiio.ImageSpec, file: BinaryIO, reader: str, page: int, name: str) -> str:
    """What a file, open for reading, declares of its colours that reading does not follow; '' for nothing.

    Integers are read as sRGB, floating samples as linear Rec.709.
    """
    integer = spec.format.basetype in (oiio.UINT8, oiio.UINT16)
    how = "they are read as sRGB" if integer else "they are read as linear Rec.709"
    profile = spec.getattribute("ICCProfile")
    if profile is not None:
        called = _text(spec, "ICCProfile:profile_description")
        # many are called after sRGB and have only its primaries
        linear = icc.is_linear(np.asarray(profile, np.uint8).tobytes())
        if not (_SRGB_PROFILE if integer else _REC709_PROFILE).search(called):
            return f"its colours are those of the profile {show(called)}; {how}"
        if linear if integer else not linear:
            curve = "linear" if linear else "curved"
            return f"its colours are those of the profile {show(called)}, {curve} ones; {how}"
    space = _text(spec, "oiio:ColorSpace")
    if space and not (_SRGB if integer else _LINEAR).match(space):
        return f"its colours are declared as {show(space)}; {how}"
    if reader == "bmp" and bmp.has_profile(file):
        return f"its colours are those of a profile; {how}"
    if profile is not None:  # it counts
        return ""
    if spec.get_int_attribute(_EXIF, _EXIF_SRGB) != _EXIF_SRGB:  # of Adobe RGB cameras say no more
        return f"its colours are not sRGB, as its Exif says; {how}"
    if reader == "tiff" and integer and tiff.has_other_curve(file, page, name):
        return f"its TransferFunction is not that of sRGB; {how}"
    primaries = _primaries(spec, file, reader, page, name)
    if primaries is not None and not _near(primaries):
        numbers = _numbers(primaries)
        told = show(primaries) if numbers is None else ", ".join(f"{value:.4g}" for value in numbers[:9])
        return f"its primaries are {told}; {how}"
    if _text(spec, "textureformat") == "CubeFace Environment":
        return "its header says that it is the six faces of a cube, of which no account is taken"
    for key, value in _radiance(file):
        said = f"{key}={value.decode('latin-1')}"
        return f"its header says {show(said)}, of which no account is taken"
    return ""


def _primaries(spec: oiio.ImageSpec, file: BinaryIO, reader: str, page: int, name: str) -> Any:
    """Those that a file declares, whatever they are; None where it does not."""
    if reader == "png":
        return png.primaries(file)
    if reader == "tiff":
        return tiff.primaries(file, page, name)
    if reader == "bmp":
        return bmp.primaries(file)
    return spec.getattribute("chromaticities")


def _orientation(file: BinaryIO) -> int:
    """The way up of a Radiance file, as EXIF numbers it."""
    axes = _AXES.match(_radiance_head(file)[1])
    return 1 if axes is None else _WAYS.index(axes[1] + axes[2]) + 1


def _radiance(file: BinaryIO) -> list[tuple[str, bytes]]:
    """Lines of a Radiance file's header that change its numbers."""
    head, _ = _radiance_head(file)
    if not head.startswith(b"#?"):
        return []
    found = [(match[1].decode(), match[2]) for match in _RADIANCE.finditer(head)]
    return [(key, value) for key, value in found if not _plain(key, value)]


def _radiance_head(file: BinaryIO) -> tuple[bytes, bytes]:
    """The lines of a Radiance file's header, and what follows the empty one; lines may end as on Windows."""
    file.seek(0)
    begins = file.read(_HEAD)
    head, *rest = _HEAD_ENDS.split(begins, maxsplit=1)
    return head, rest[0] if rest else b""


def _plain(key: str, value: bytes) -> bool:
    """Whether a line of the header leaves all as it is."""
    try:
        numbers = [float(word) for word in value.split()]
    except ValueError:
        return False
    if key == "PRIMARIES":
        return not any(numbers) or _near(numbers)
    return all(number == 1 for number in numbers)


def _near(primaries: Any) -> bool:
    """Whether they are those of Rec.709."""
    numbers = _numbers(primaries)
    if numbers is None or len(numbers) not in (6, 8):  # with the white, or without
        return False
    return bool((np.abs(numbers - REC709[: len(numbers)]) <= _NEAR).all())


def _numbers(value: Any) -> np.ndarray | None:
    """The numbers (n,) of an attribute; None where it holds others: any name may have any type in a file."""
    numbers = np.ravel(np.asarray(value))
    return numbers.astype(np.float64) if numbers.dtype.kind in "iuf" else None


def _as_stored(picture: np.ndarray, orientation: int) -> np.ndarray:
    """A view of an upright picture with the rows and columns of its file."""
    if orientation in _TURNED:
        picture = picture.swapaxes(0, 1)
    if orientation in _ROWS_BACK:
        picture = picture[::-1]
    return picture[:, ::-1] if orientation in _COLUMNS_BACK else picture


def _text(spec: oiio.ImageSpec, key: str) -> str:
    """A text of the file, bytes that are not UTF-8 as halves of characters; '' where it has none."""
    value = spec.getattribute(key)
    return "" if value is None else str(value)


def names_within(names: Sequence[str], first: int) -> list[str]:
    """Names of channels; in the view layer whose picture begins at `first` without its name, its alpha `A`.

    What would then have the name of another one keeps its own.
    """
    view, combined, _ = names[first].rpartition(_COMBINED)
    if not combined:
        return [*names]
    taken, found = set(names), []
    for name in names:
        short = name.removeprefix(f"{view}.")
        short = "A" if short == "Combined.A" else short
        found.append(name if short in taken else short)
        taken.add(short)
    return found


def _view_layers(names: Sequence[str]) -> dict[str, int]:
    """Blender's view layers with a picture, `ViewLayer.Combined.R`, G and B in a row: where that begins."""
    found = {}
    for first, name in enumerate(names):
        view, combined, channel = name.rpartition(_COMBINED)
        row = [f"{view}{_COMBINED}{colour}" for colour in "RGB"]
        if combined and channel == "R" and [*names[first : first + 3]] == row:
            found[view] = first
    return found


def _unnamed(names: Sequence[str]) -> int | None:
    """Where R, G and B begin, which have no layer's name; None where there are none."""
    upper = [name.upper() for name in names]
    for first in range(len(upper) - 2):
        if upper[first : first + 3] in (["R", "G", "B"], ["RED", "GREEN", "BLUE"]):
            return first
    return None


def _colour_channels(names: tuple[str, ...]) -> tuple[int, int]:
    """Range of the colour channels: R, G, B, those of the composite or the only view layer, or grey alone,
    which is Y or any; else an empty one."""
    plain = _unnamed(names)
    if plain is not None:
        return plain, plain + 3
    if views := _view_layers(names):
        begins = views.get(_COMPOSITE, next(iter(views.values())))
        return begins, begins + 3
    upper = [name.upper() for name in names]
    others = [number for number, name in enumerate(upper) if name not in ("A", "ALPHA")] or [0]
    if len(others) == 1:
        return others[0], others[0] + 1
    if "Y" in upper and not {"RY", "BY", "X"} & set(upper):
        return upper.index("Y"), upper.index("Y") + 1
    return 0, 0
