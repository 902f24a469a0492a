"""A rendered picture: linear pixels, layers, statistics; saving, showing and hashing it."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, overload

import numpy as np

from clrt.base import arguments
from clrt.base.arguments import public
from clrt.base.errors import ClrtError, fault, show
from clrt.base.frozen import FrozenDict
from clrt.base.interrupts import folders
from clrt.base.layers import find
from clrt.base.limits import Limits, advising
from clrt.base.scratch import noted, scratch
from clrt.base.suggest import nearest
from clrt.images import file as imagefile
from clrt.images.cryptomatte import manifest_of, matte
from clrt.images.exrlayers import OWN, channels, read_layers
from clrt.images.exrlayers import attributes as file_attributes
from clrt.images.file import check_writable, write
from clrt.images.layerpicture import layer_pixels
from clrt.images.views import check_shown, encode_view
from clrt.version import __version__

__all__ = ["Image", "check_writable", "pixel_hash", "read_image"]

_LONGEST = 255  # bytes of a name in an .exr
_NAMED = 20  # names that a message lists
_SPECTRAL_LAYOUT = {"spectralLayoutVersion": "1.0", "emissiveUnits": "relative"}  # see exrlayers


@dataclass(frozen=True, eq=False)
class Image:
    """What a render gives. Arrays are owned and read-only; `np.array(image)` is a copy to change.

    pixels: float32 (height, width, 3), linear Rec.709 radiance, unclamped, the top row first.
    layers: name -> array (height, width) or (height, width, 3) of the same size, as asked for; `bands` is
    (height, width, n). wavelengths: the middles of these n bands in nm; none in RGB mode.
    stats: rays by generation and kind, seconds by pass, device; plain numbers, texts, lists and dicts.
    metadata: what made the picture (scene hash, kernel hash, device, settings), as texts.
    ClrtError when an array has another shape or kind of number.
    """

    pixels: np.ndarray
    layers: Mapping[str, np.ndarray] = field(default_factory=dict)
    stats: Mapping[str, Any] = field(default_factory=dict)
    metadata: Mapping[str, str] = field(default_factory=dict)
    wavelengths: tuple[float, ...] = ()

    @public
    def __post_init__(self) -> None:
        pixels = _array("pixels", self.pixels)
        arguments.mapping("layers", self.layers)
        arguments.mapping("stats", self.stats)
        arguments.mapping("metadata", self.metadata)
        for name, text in self.metadata.items():
            _check_text("metadata", name)
            _check_text(f"metadata[{name!r}]", text)
        if not isinstance(self.wavelengths, (tuple, list)):
            raise ClrtError(f"wavelengths: {show(self.wavelengths)} is not allowed; it must be a tuple of nm")
        wavelengths = tuple(arguments.number("wavelengths", nm) for nm in self.wavelengths)
        named = {round(nm, 6) if 0 < nm < np.inf else 0.0 for nm in wavelengths}  # as channels of an .exr are
        if len(named) < len(wavelengths) or 0.0 in named:
            right = "they must be above 0, and 1e-6 nm apart"
            raise ClrtError(f"wavelengths: {show(self.wavelengths)} is not allowed; {right}")
        if pixels.dtype != np.float32 or pixels.ndim != 3 or pixels.shape[2] != 3 or 0 in pixels.shape:
            hint = "; image.layer(name) makes a picture of a layer" if pixels.ndim == 2 else ""
            raise ClrtError(f"pixels: {pixels.dtype} {pixels.shape} is not float32 (height, width, 3){hint}")
        layers = {name: _array(f"layers[{name!r}]", layer) for name, layer in self.layers.items()}
        for name, layer in layers.items():
            _check_text("layers", name)
            if not name:
                raise ClrtError(fault("", "layers", name, "a layer has a name"))
            values = {3, find(name).values} if find(name).values else {len(wavelengths)}
            fits = [(*pixels.shape[:2], number) for number in values]
            if layer.shape not in (*fits, pixels.shape[:2]) or layer.dtype.kind not in "fiu":
                form = f"{layer.dtype} {layer.shape}"
                raise ClrtError(f"layers[{name!r}]: {form} does not fit pixels {pixels.shape}")
        object.__setattr__(self, "pixels", pixels)
        object.__setattr__(self, "wavelengths", wavelengths)
        frozen = {"layers": layers, "stats": self.stats, "metadata": self.metadata}  # fmt: skip
        for name, table in frozen.items():
            object.__setattr__(self, name, _frozen(table))

    def __reduce__(self) -> tuple[Any, ...]:
        """As it was made: arrays that are copied or unpickled by themselves can be written to."""
        tables = (dict(table) for table in (self.layers, self.stats, self.metadata))
        return type(self), (self.pixels, *tables, self.wavelengths)

    @property
    def height(self) -> int:
        """Rows of pixels."""
        return int(self.pixels.shape[0])

    @property
    def width(self) -> int:
        """Columns of pixels."""
        return int(self.pixels.shape[1])

    @cached_property
    def hash(self) -> str:
        """`pixel_hash` of the pixels: equal for pictures that are equal bit for bit."""
        return pixel_hash(self.pixels)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.array(self.pixels, dtype=dtype, copy=copy)

    def __repr__(self) -> str:
        layers = f", layers {', '.join(self.layers)}" if self.layers else ""
        return f"<clrt.Image {self.width} x {self.height}{layers}, hash {self.hash[:12]}>"

    @public
    def save(
        self,
        path: str | os.PathLike[str],
        exposure: float = 0.0,
        bits: int | None = None,
        view: str | None = None,
    ) -> Path:
        """Write the picture; `path` is then the complete new file, or, after any error, what it was before.

        The suffix decides. `.exr`: the linear radiance and all layers as float32 (`direct.R`, `Z`,
        `normal.X`, `shape.ID`, ...: docs/layers.md), with the metadata as attributes `clrt:...`; `.png`,
        `.tif`: sRGB of `bits` = 8 (default) or 16; `.jpg`, `.bmp`: sRGB of 8 bits, all clipped to [0, 1],
        colours out of gamut as well. `exposure`, -100 to 100 stops, brightens sRGB pictures; `view` is the
        name of one of `clrt.views()`, in place of the sRGB curve alone. Returns the absolute path. ClrtError
        as `check_writable`, for arguments of another kind, and when the disk refuses.
        """
        path = arguments.path("path", path)
        exposure = arguments.number("exposure", exposure)
        bits = arguments.optional("bits", bits, 1, 32)
        bits = check_writable(path, exposure, bits)
        check_shown(path, bits, view)
        if bits == 32:
            _check_names("layers", self.layers, _LONGEST)
            _check_names("metadata", self.metadata, _LONGEST - len(OWN))
            groups = [channels(name, layer, self.wavelengths) for name, layer in self.layers.items()]
            names = ("R", "G", "B", *(name for group, _ in groups for name in group))
            write(path, [self.pixels, *(layer for _, layer in groups)], names, self._attributes())
        else:
            about = self._attributes() | ({} if view is None else {"clrt:view": view})
            write(path, [encode_view(self.pixels, exposure, bits, view)], metadata=about)
        return Path(path).resolve()

    @public
    def layer(self, name: str) -> Image:
        """A layer as a picture to look at, to show or to save: docs/layers.md says what stands for what.

        ClrtError where the image has no such layer, and for `bands`, which only an .exr holds.
        """
        name = arguments.text("name", name)
        if name not in self.layers:
            known = f"it has {', '.join(self.layers)}" if self.layers else "it was rendered without layers"
            raise ClrtError(f"layers: {show(name)} is not in this image; {known}")
        return Image(layer_pixels(name, self.layers[name]), metadata={**self.metadata, "layer": name})

    @public
    def matte(self, name: str, of: str = "shape") -> np.ndarray:
        """The part of each pixel that what has this name covers: float32 (height, width), 0 to 1.

        name: a shape's, or with of="material" a material's; `shapes[3]`, `shapes[3].material`, `lights[0]`
        where the scene gives none. The image needs the layer `crypto_shape` or `crypto_material`. ClrtError
        without it, and for a name that it does not know. A pixel knows the six names that cover most of it.
        """
        name = arguments.text("name", name)
        of = arguments.text("of", of)
        if of not in ("shape", "material"):
            raise ClrtError(fault("", "of", of, "it must be 'shape' or 'material'"))
        layer = f"crypto_{of}"
        if layer not in self.layers:
            raise ClrtError(f"layers: this image has no {layer}; render it with layers=[{layer!r}]")
        ranked = self.layers[layer]
        if ranked.dtype.kind != "f" or ranked.ndim != 3 or ranked.shape[2] % 2:
            form = f"{ranked.dtype} {ranked.shape}"
            right = "it must be float32 (height, width, 2 x ranks): names' hashes and what they cover"
            raise ClrtError(fault("", f"layers[{layer!r}]", form, right))
        known = manifest_of(layer, self.metadata)
        if known and name not in known:
            near = nearest(name, known, cutoff=0.6)
            hint = f"did you mean {near!r}?" if near else f"there are {', '.join([*known][:_NAMED])}"
            raise ClrtError(f"name: {show(name)} is no {of} of this image; {hint}")
        return matte(ranked.astype(np.float32, copy=False), name)

    @public
    def save_layers(
        self,
        path: str | os.PathLike[str],
        exposure: float = 0.0,
        bits: int | None = None,
        view: str | None = None,
    ) -> list[Path]:
        """Write every layer but `bands` beside the picture `path`: `x.png` makes `x.depth.png` ...

        As `save`; `exposure` and `view` are for light alone. An .exr holds its layers itself. Returns
        absolute paths.
        """
        path = arguments.path("path", path)
        exposure = arguments.number("exposure", exposure)
        bits = arguments.optional("bits", bits, 1, 32)
        shown = [name for name in self.layers if find(name).is_shown]
        files = [layer_file(path, name) for name in shown]
        for file in files:
            check_shown(file, check_writable(file, exposure, bits), view)
        saved = []
        for name, file in zip(shown, files, strict=True):
            how = (exposure, bits, view) if find(name).is_light else (0.0, bits)
            saved.append(self.layer(name).save(file, *how))
        return saved

    @public
    def to_xarray(self) -> Any:
        """The picture ("pixels") and its layers as an `xarray.Dataset`: their arrays are shared, not copied.

        Dimensions: y, x (pixels from the top left), then channel ("R", "G", "B"), axis ("x", "y", "z") of
        normals and positions, cie ("X", "Y", "Z"), wavelength (nm) of bands. Its attrs are `metadata`. Raises
        ClrtError without xarray.
        """
        from clrt.images.dataset import dataset

        return dataset(self)

    @public
    def show(self, exposure: float = 0.0) -> None:
        """Show the picture below a notebook's cell, else in the desktop's viewer; ClrtError without one.

        exposure: as for `save`.
        """
        exposure = arguments.number("exposure", exposure)
        if "ipykernel" in sys.modules:
            from IPython.display import Image as Picture
            from IPython.display import display

            display(Picture(data=self._png(exposure)))
            return
        viewer, shown = _viewer(), self._png(exposure)
        folder = noted(tempfile.mkdtemp, prefix="clrt-")
        file = Path(folder, f"{self.hash[:12]}.png")
        file.write_bytes(shown)
        folders.discard(folder)  # it stays: a viewer may still be starting when its command has returned
        subprocess.run([*viewer, str(file)], check=False)

    def _repr_png_(self) -> bytes:
        return self._png(0.0)

    def _png(self, exposure: float) -> bytes:
        with scratch() as folder:
            return self.save(folder / "image.png", exposure).read_bytes()

    def _attributes(self) -> dict[str, str]:
        attributes = {"version": __version__, "image_hash": self.hash, **self.metadata}
        return file_attributes(attributes) | (_SPECTRAL_LAYOUT if "bands" in self.layers else {})


def layer_file(path: str | os.PathLike[str], name: str) -> Path:
    """Where `save_layers` puts a layer: `x.depth.png` for depth beside `x.png`. ClrtError beside an .exr."""
    path = Path(path)
    if path.suffix.lower() == ".exr":
        raise ClrtError(f"{path}: an .exr holds its layers itself; or name a .png")
    if not path.name:
        raise ClrtError(f"{path}: is a folder; name a picture beside which {show(name)} is to stand, x.png")
    if Path(name).name != name:
        raise ClrtError(f"layers: {name!r} cannot be a part of a file's name")
    return path.with_name(f"{path.stem}.{name}{path.suffix}")


@overload
def read_image(
    path: str | os.PathLike[str], limits: Limits | None = None, layers: None = None
) -> np.ndarray: ...
@overload
def read_image(
    path: str | os.PathLike[str], limits: Limits | None = None, *, layers: str | Sequence[str]
) -> Image: ...
@overload
def read_image(
    path: str | os.PathLike[str], limits: Limits | None, layers: str | Sequence[str]
) -> Image: ...
@overload
def read_image(
    path: str | os.PathLike[str], limits: Limits | None, layers: str | Sequence[str] | None
) -> np.ndarray | Image: ...
@public
def read_image(
    path: str | os.PathLike[str], limits: Limits | None = None, layers: str | Sequence[str] | None = None
) -> np.ndarray | Image:
    """A picture file as linear Rec.709 float32 (height, width, 3), the top row first.

    layers: "all", or names of layers in an .exr; then it is an `Image` with these, as `Image.save` was given
    them, and with the metadata that clrt wrote. Other formats have none.
    Integer samples are decoded from sRGB, floating ones are taken as linear; a ClrtWarning says so where the
    file declares other colours. Grey becomes three equal channels, alpha is dropped. The picture is turned as
    the file says (EXIF's orientation), and is all of an EXR's display window, black where nothing is stored.
    Formats: EXR, Radiance HDR, PNG, JPEG, TIFF, BMP, told by their first bytes.
    SceneError when the file is missing, of another kind, damaged, or holds NaN or infinity; LimitError when
    it has more bytes or pixels than `limits` (default `Limits()`) allow; ClrtError for arguments of another
    kind.
    """
    limits = arguments.optional_instance("limits", limits, Limits)
    path = arguments.path("path", path)
    with advising("clrt.read_image"):
        if layers is None:
            return imagefile.read_image(path, limits)
        wanted = arguments.names("layers", layers)
        found, wavelengths, about = read_layers(path, limits, None if "all" in wanted else wanted)
        return Image(imagefile.read_image(path, limits), found, {}, about, wavelengths)


def pixel_hash(pixels: np.ndarray) -> str:
    """SHA-256, in hex, of the shape as little-endian int32 and then the pixels as little-endian float32."""
    digest = hashlib.sha256(np.asarray(pixels.shape, "<i4").tobytes())
    digest.update(np.ascontiguousarray(pixels, "<f4").data)
    return digest.hexdigest()


def _frozen(value: Any) -> Any:
    """Tables, and those in them, as copies that stay as they are; lists as copies."""
    if isinstance(value, Mapping):
        return FrozenDict({name: _frozen(one) for name, one in value.items()})
    return [_frozen(one) for one in value] if isinstance(value, list) else value


def _array(name: str, value: object) -> np.ndarray:
    """`value` as a read-only array: a copy, unless it is one already that shares its numbers with none.

    ClrtError for rows of different lengths.
    """
    arguments.unmasked(name, value)
    try:
        given = np.ascontiguousarray(value)
        if given.base is not None or (given is value and given.flags.writeable):
            given = given.copy()
        given.flags.writeable = False
        return given
    except (TypeError, ValueError, OverflowError):
        raise ClrtError(f"{name}: {show(value)} is not allowed; it must be an array of numbers") from None


def _check_names(what: str, names: Iterable[str], most: int) -> None:
    """ClrtError for a name that would be lost in an .exr."""
    for name in names:
        if len(name.encode()) > most:
            long = f"{len(name.encode())} bytes are too many for a name in an .exr; it takes {most}"
            raise ClrtError(f"{what}[{show(name)}]: {long}")


def _check_text(name: str, value: object) -> None:
    """ClrtError for what no picture file can hold as a text."""
    try:
        good = isinstance(value, str) and "\0" not in value and value.encode() is not None
    except UnicodeEncodeError:
        good = False
    if not good:
        raise ClrtError(fault("", name, value, r"it must be a text that UTF-8 can hold, without \x00"))


def _viewer() -> list[str]:
    if sys.platform == "darwin":
        return ["open"]
    if sys.platform == "win32":
        return ["cmd", "/c", "start", ""]
    if (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")) and shutil.which("xdg-open"):
        return ["xdg-open"]
    raise ClrtError("no desktop to show a picture on; save it with image.save('picture.png')")
