"""`clrt.compare`: do two pictures show the same, how far are they apart, and why.

What measures and explains is the validation package, which is reached when it is needed.
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from clrt.base import arguments
from clrt.base.arguments import public
from clrt.base.atomic import check_replaceable
from clrt.base.errors import ClrtError, exhausted, fault
from clrt.base.frozen import FrozenDict
from clrt.base.install import install_extra
from clrt.base.limits import Limits, advising
from clrt.base.resources import validation_module
from clrt.device.settings import Settings
from clrt.formats.shipped import as_scene
from clrt.images.file import decode, open_picture, read_samples
from clrt.images.header import find_picture
from clrt.images.image import Image
from clrt.scene.scene import Scene

if TYPE_CHECKING:
    import OpenImageIO as oiio
else:
    from clrt.images import library as oiio

PICTURES: Final = (".exr", ".png", ".tif", ".tiff", ".jpg", ".jpeg", ".bmp", ".hdr")
RADIANCE: Final = 32  # bits of a sample that does not end at white
COMPARING: Final = 110  # bytes of memory for a pixel of the larger picture; blocks of a fixed size come to it
HALF: Final = 30  # of floats of 16 bits, which hold 11 of a value
SHARED_EXPONENT: Final = 24  # of Radiance's .hdr: 8 bits of what the pixel's largest channel has
LOSSY: Final = {20: "dwaa", 21: "dwab", 22: "b44", 23: "b44a"}
"""Of an EXR, by the compression that its header names, which changes what it stores."""
SECONDS: Final = 30.0  # of processor time, that causes are looked for in a scene


@dataclass(frozen=True, eq=False)
class Verdict:
    """What `compare` found. True in conditions where the pictures show the same.

    verdict: "identical", "equal", "same picture", "similar" or "different". figures: by name, as
    `clrt compare` prints them. gates: what was asked of them, each with `name`, `value`, `limit`, `passed`,
    `better` ("low" or "high"). causes: the likeliest first, each with `name`, `text`, `left` (share of the
    error that is left when it is undone) and `proven`; () where the pictures agree or nothing helps.
    picture, reference: what was compared, linear float32 (height, width, 3), read-only.
    """

    verdict: str
    passed: bool
    figures: Mapping[str, float]
    gates: tuple[Any, ...]
    causes: tuple[Any, ...]
    notes: tuple[str, ...]
    picture: np.ndarray
    reference: np.ndarray
    names: tuple[str, str] = ("picture", "reference")

    def __bool__(self) -> bool:
        return self.passed

    def __str__(self) -> str:
        """The verdict in a line: "different: SSIM 0.19 (at least 0.998); cause: vertical flip"."""
        failed = [gate for gate in self.gates if not gate.passed]
        said = [", ".join(_said(gate) for gate in failed[:3])] if failed else []
        said += [f"{certainty(cause)}: {cause.name}" for cause in self.causes[:1]]
        return f"{self.verdict}: {'; '.join(said)}" if said else self.verdict

    @public
    def save_report(self, path: str | os.PathLike[str]) -> Path:
        """Write the verdict as one page of HTML that needs nothing else: figures, causes, both pictures.

        Returns the absolute path. ClrtError where the file cannot be written, or has another suffix.
        """
        path = arguments.path("path", path)
        check_page(path)
        return _write_page(self, path)


def _write_page(verdict: Verdict, path: Path) -> Path:
    with needing_extra("a report"):
        written: Path = validation_module("suite.comparison").write_page(verdict, path)
    return written


def check_page(path: str | os.PathLike[str]) -> None:
    """ClrtError where a report cannot be written to `path`, which stays as it is."""
    if Path(path).suffix.lower() not in (".html", ".htm"):
        raise ClrtError(f"{path}: the report is a page; give a name that ends in .html")
    check_replaceable(path)


def _said(gate: Any) -> str:
    if gate.name == "size":
        return str(gate.detail)
    side = "at most" if gate.better == "low" else "at least"
    return f"{gate.name} {gate.value:.5g} ({side} {gate.limit:g})"


def certainty(cause: Any) -> str:
    """What a cause is called: "cause", "likely cause" or "possible cause"."""
    return "cause" if cause.proven else "likely cause" if cause.certain and cause.likely else "possible cause"


@public
def compare(
    a: Any,
    b: Any,
    gates: Mapping[str, float] | None = None,
    *,
    mask: bool = False,
    seconds: float = SECONDS,
    device: int | str | None = None,
    limits: Limits | None = None,
) -> Verdict:
    """Judge picture `a` by `b`, what it should show.

    a: an `Image`, an array, or a picture's file. b: likewise, or a scene (a `Scene`, a file, a dict): it is
    then rendered in a's size, and changed and rendered again to find out what went wrong, for no more than
    `seconds` of processor time. Arrays are (height, width, 3): floats are linear Rec.709, uint8 and uint16
    are sRGB, which ends at white, as do files of integers: the other is then clipped there, too, and a note
    says how much of it.
    gates: limits by the names of figures, such as {"SSIM": 0.99, "pixels that differ": 0.001}, in place of
    the usual ones. mask: leave edges out, where correct programs differ. limits: of files, of what a
    scene may ask for, and of the memory that comparing takes (`host_bytes`; see COMPARING).
    ClrtError for arguments of another kind, files that cannot be read, and where packages of
    `clrt[validation]` are missing.
    """
    wanted, limits = None, arguments.optional_instance("limits", limits, Limits)
    if gates is not None:
        given = arguments.mapping("gates", gates)
        wanted = {name: arguments.number(f"gates[{name!r}]", value) for name, value in given.items()}
        for name, value in wanted.items():
            if math.isnan(value):
                raise ClrtError(fault("", f"gates[{name!r}]", value, "it must be a number"))
    mask, seconds = arguments.flag("mask", mask), arguments.number("seconds", seconds)
    if not seconds >= 0:
        raise ClrtError(fault("", "seconds", seconds, "it must be a number >= 0"))
    device = arguments.device("device", device)
    scene = None
    with advising("clrt.compare"), needing_extra("comparing pictures"):
        (picture, bits), (judged, bits_of_b) = _stored("a", a, limits), _picture_or_scene("b", b, limits)
        pictures = validation_module("compare.pictures")
        if isinstance(judged, Scene):
            reference = validation_module("compare.reference")
            scene = reference.reference_of(judged, picture.shape[:2], device, Settings(limits=limits))
            judged = scene.render()
        check_room(picture, judged, limits)
        both = bits, bits_of_b
        found = pictures.compare_pictures(picture, judged, mask, scene, None, seconds, wanted, both)
    for pixels in (picture, judged):
        pixels.flags.writeable = False
    return Verdict(
        found.verdict, found.passed, FrozenDict(found.metrics), found.gates, found.causes, found.notes,
        picture, judged, (_name(a, "picture"), _name(b, "reference")),
    )  # fmt: skip


@contextmanager
def needing_extra(what: str) -> Iterator[None]:
    """ClrtError says what to install where a package of `clrt[validation]` is missing."""
    try:
        yield
    except ModuleNotFoundError as error:
        needs = f"{what} needs the package {error.name}"
        raise ClrtError(f"{needs}; install what it needs with: {install_extra('validation')}") from None
    except ImportError as error:  # scikit-image has nothing to import where Python drops docstrings (-OO)
        if exhausted(error):
            raise
        why = "; leave out python -OO (PYTHONOPTIMIZE=2)" if sys.flags.optimize > 1 else ""
        raise ClrtError(f"{what} needs a package that cannot be imported: {error}{why}") from None


def _name(given: Any, otherwise: str) -> str:
    return os.fspath(given) if isinstance(given, (str, os.PathLike)) else otherwise


def check_room(picture: np.ndarray, reference: np.ndarray, limits: Limits) -> None:
    """LimitError where comparing two pictures would take more memory than `Limits.host_bytes`."""
    most = max(image.shape[0] * image.shape[1] for image in (picture, reference))
    with advising("clrt.compare"):
        limits.check("host_bytes", COMPARING * most, place="comparing")


def _picture_or_scene(name: str, given: Any, limits: Limits) -> tuple[Any, int]:
    """Pixels and their bits, or the scene that a dict, or a file that is no picture's, describes."""
    file = isinstance(given, (str, os.PathLike))
    if file and arguments.path(name, given).suffix.lower() in PICTURES:
        return _stored(name, given, limits)
    if not (file or isinstance(given, (Scene, Mapping))):
        return _stored(name, given, limits)
    scene = as_scene(given, limits)
    if scene.camera is None:
        raise ClrtError(f"{given if file else name}: camera: missing; a picture needs a [camera]")
    return scene, RADIANCE


@public
def as_pixels(name: str, given: Any) -> np.ndarray:
    """Linear float32 (height, width, 3) of what `compare` takes for a picture; of an array's a copy."""
    return _stored(name, given, Limits())[0]


def bits_of_file(path: str | os.PathLike[str], limits: Limits | None = None) -> int:
    """Bits of a sample of a picture's file: 8 or 16 of sRGB, which ends at white; of radiance RADIANCE,
    HALF, SHARED_EXPONENT or one of LOSSY."""
    if os.fspath(path).lower().endswith(".hdr"):
        return SHARED_EXPONENT
    with open_picture(path, limits or Limits()) as (source, _):
        channels = find_picture(source, os.fspath(path))
        spec = source.spec()
        # each channel of an EXR has a type of its own, and depth's is longer than its colours'
        half = oiio.HALF in [spec.channelformat(channel).basetype for channel in range(*channels)]
        compression = str(spec.getattribute("compression"))
        for bits, name in LOSSY.items():
            if compression == name and (half or name.startswith("dwa")):  # B44 leaves longer floats alone
                return bits
        return HALF if half else {oiio.UINT8: 8, oiio.UINT16: 16}.get(spec.format.basetype, RADIANCE)


def _stored(name: str, given: Any, limits: Limits) -> tuple[np.ndarray, int]:
    """`as_pixels`, and the bits of a sample as it was given."""
    if isinstance(given, Image):
        return given.pixels, RADIANCE
    if isinstance(given, (str, os.PathLike)):
        path = arguments.path(name, given)
        if path.suffix.lower() not in PICTURES:
            raise ClrtError(f"{path}: not a picture's file ({', '.join(PICTURES)}); only b may be a scene")
        return read_samples(path, limits), bits_of_file(path, limits)
    right = "it must be a clrt.Image, an array (height, width, 3) or a picture's file"
    if isinstance(given, Scene):
        raise ClrtError(f"{name}: a scene; only b, what the picture should show, may be one")
    if not isinstance(given, (np.ndarray, list, tuple)) and not hasattr(given, "__array__"):
        raise ClrtError(fault("", name, given, right))
    arguments.unmasked(name, given)
    try:
        array = np.asarray(given)
    except (ValueError, TypeError):  # rows of several lengths
        raise ClrtError(fault("", name, given, right)) from None
    if array.ndim != 3 or array.shape[2] != 3 or array.dtype.kind not in "fu" or 0 in array.shape:
        raise ClrtError(f"{name}: {array.dtype} {array.shape} is not floats or sRGB bytes of "
                        "shape (h, w, 3)")  # fmt: skip
    if array.dtype.kind == "u":
        if array.dtype.itemsize > 2:
            raise ClrtError(f"{name}: {array.dtype} is not allowed; sRGB values are uint8 or uint16")
        return decode(array), 8 * array.dtype.itemsize
    with np.errstate(over="ignore"):  # what is beyond float32 is infinite, and never the same
        return array.astype(np.float32, order="C"), RADIANCE
