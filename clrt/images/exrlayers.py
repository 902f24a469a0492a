"""Layers as the channels of an .exr: what they are called there, and layers back from channels.

`name.channel` is how compositing programs group channels; `A` and `Z` without a name are a picture's alpha
and depth. Bands are named as in Fichet, Pacanowski and Wilkie 2021, "An OpenEXR layout for spectral images".
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from clrt.base import notices
from clrt.base.errors import ClrtError, SceneError, show
from clrt.base.layers import LAYERS, find
from clrt.base.limits import Limits
from clrt.base.suggest import nearest
from clrt.images.cryptomatte import PREFIX
from clrt.images.file import bytes_to_read, open_picture, row_blocks
from clrt.images.header import Window, check_meaning, check_samples, find_picture, names_within

if TYPE_CHECKING:
    import OpenImageIO as oiio

_BAND: Final = re.compile(r"S0\.([0-9]{1,9})(?:,([0-9]{1,9}))?nm")
OWN: Final = "clrt:"  # before the names of our attributes
_COLOURS: Final = (("R", "G", "B"), ("X", "Y", "Z"))  # of a layer of three, in order
_MOST: Final = 1 << 24  # whole numbers up to here are exact in float32


def channels(
    name: str, layer: np.ndarray, wavelengths: tuple[float, ...]
) -> tuple[tuple[str, ...], np.ndarray]:
    """Names of a layer's channels, and the layer as (height, width, channels).

    Numbers of shapes are exact in float32: there are at most 2^24 of them. Of bands S0 is radiance, a comma
    the point. ClrtError for a layer of the caller's whose numbers would be others in float32, or infinite.
    """
    known, layer = find(name), np.atleast_3d(layer)
    with np.errstate(over="ignore"):
        stored = layer.astype(np.float32, copy=False)
    whole = layer.dtype.kind in "iu"
    if (stored != layer).any() if whole else (np.isinf(stored) & np.isfinite(layer)).any():
        right = "whole numbers up to 2^24" if whole else "numbers up to 3.4e38"
        raise ClrtError(f"layers[{name!r}]: an .exr holds {right}")
    if not known.values:
        return tuple(f"S0.{nm:.6f}nm".replace(".", ",").replace(",", ".", 1) for nm in wavelengths), layer
    names = known.names(name)
    if len(names) != layer.shape[2]:  # of the caller's own
        own = {"f": ("Z",)}.get(layer.dtype.kind, ("ID",)) if layer.shape[2] == 1 else ("R", "G", "B")
        names = tuple(f"{name}.{channel}" for channel in own)
    return names, layer


def read_layers(
    path: str | os.PathLike[str], limits: Limits, wanted: Sequence[str] | None = None
) -> tuple[dict[str, np.ndarray], tuple[float, ...], dict[str, str]]:
    """Layers by name, as `Image` has them, the bands' wavelengths (nm) and our attributes of a picture file.

    wanted: their names; None: all that the file has. What is none of ours is a layer too: three channels
    R, G, B or X, Y, Z of one name, or a channel by itself; passes of a view layer whose picture is read, as
    Blender writes them, by their own names. Only an .exr has layers. SceneError for a damaged file and for
    numbers of shapes that are none, ClrtError for a layer that it has not.
    """
    name = os.fspath(path)
    with open_picture(path, limits) as (source, file):
        colours = find_picture(source, name)
        spec = source.spec()
        if source.format_name() != "openexr":
            _check_wanted(wanted, (), name)
            return {}, (), {}
        check_meaning(spec, name)
        window = Window.of(spec, "openexr", name, file)
        names = names_within(spec.channelnames, colours[0])
        places = dict[str, list[int]]()
        for layer, place in _places(names, range(*colours)):
            while layer in places:  # N beside N.X, N.Y and N.Z
                layer += "."
            places[layer] = place
        _check_wanted(wanted, tuple(places), name)
        places = {layer: place for layer, place in places.items() if wanted is None or layer in wanted}
        check_samples(spec, sorted(number for place in places.values() for number in place), name)
        pixels = max(window.width * window.height, spec.width * spec.height)
        limits.check("image_pixels", pixels, name)
        held = 4 * window.width * window.height * sum(map(len, places.values()))
        limits.check("image_bytes", held + bytes_to_read(spec, "openexr"), name)
        found = {layer: window.picture(len(place)) for layer, place in places.items()}
        for row, samples in row_blocks(source, spec, (0, spec.nchannels)) if found else ():
            if samples is None:
                raise SceneError(f"{path}: its layers cannot be read")
            for layer, place in places.items():
                window.put(found[layer], row, samples[..., place])
        attributes = dict(_attributes(spec))
        parts = spec.get_int_attribute("oiio:subimages", 1)
    if wanted is None and parts > 1:
        notices.warn(name, "", f"it has {parts} parts; layers are read of the one with its picture")
    bands = _wavelengths(names) if "bands" in found else ()
    for nm, after in pairwise(bands):
        if nm == after:
            raise SceneError(f"{path}: two of its channels are the band of {nm:g} nm")
    return {layer: _typed(layer, values, name) for layer, values in found.items()}, bands, attributes


def _places(names: Sequence[str], picture: range) -> Iterator[tuple[str, list[int]]]:
    """Each layer of a file with these channels, and the numbers of its channels in their order."""
    left = {name: number for number, name in enumerate(names) if number not in picture}
    bands = sorted((nm, channel) for channel in left if (nm := _nanometres(channel)))
    if bands:
        yield "bands", [left.pop(channel) for _, channel in bands]
    groups = {channel.rpartition(".")[0] for channel in left} - {""}
    taken = set()
    for layer in (*LAYERS, *sorted(groups - set(LAYERS))):
        known = find(layer)
        for ours in (known.names(layer), known.formerly) if known.sources else ():
            if ours and all(channel in left for channel in ours):
                yield layer, [left.pop(channel) for channel in ours]
                break
        else:
            for axes in _COLOURS:
                if all(f"{layer}.{axis}" in left for axis in axes):
                    taken.add(layer)
                    yield layer, [left.pop(f"{layer}.{axis}") for axis in axes]
    for channel, number in left.items():
        group, _, _ = channel.rpartition(".")
        alone = [other.rpartition(".")[0] for other in left].count(group) == 1
        named = group and alone and group not in LAYERS and group not in taken
        yield group if named else channel, [number]


def _nanometres(channel: str) -> float:
    """The middle of the band that a channel holds; 0 of another."""
    found = _BAND.fullmatch(channel)
    return float(f"{found[1]}.{found[2] or 0}") if found else 0.0


def _wavelengths(names: Sequence[str]) -> tuple[float, ...]:
    return tuple(sorted(nm for name in names if (nm := _nanometres(name))))


def _check_wanted(wanted: Sequence[str] | None, known: tuple[str, ...], file: str) -> None:
    for name in wanted or ():
        if name not in known:
            near = nearest(name, known, cutoff=0.6)
            held = f"its layers are {', '.join(known)}" if known else "it has no layers"
            hint = f"did you mean {near!r}?" if near else held
            raise ClrtError(f"{file}: has no layer {show(name)}; {hint}")


def _typed(layer: str, values: np.ndarray, file: str) -> np.ndarray:
    """(h, w) where a layer has one value; numbers as whole ones."""
    known = find(layer)
    if values.shape[2] == 1 and known.values:
        values = values[..., 0]
    if known.kind != "int" or not known.sources:
        return values
    bad = ~(np.abs(values) <= _MOST) | (values != np.floor(values))
    if bad.any():
        y, x = (int(index) for index in np.argwhere(bad)[0])
        text = f"pixel ({x}, {y}) is {values[y, x]:g}; it must be a whole number"
        raise SceneError(f"{file}: layer {layer}, {text}")
    return values.astype(np.int32)


def _attributes(spec: oiio.ImageSpec) -> Iterator[tuple[str, str]]:
    """What a file says of how its picture was made, and of its mattes."""
    for attribute in spec.extra_attribs:
        name, value = str(attribute.name), attribute.value
        if isinstance(value, str) and "\0" not in value and name != f"{OWN}image_hash":
            if name.startswith(PREFIX):
                yield name, value
            elif name.startswith(OWN):
                yield name.removeprefix(OWN), value


def attributes(metadata: Mapping[str, str]) -> dict[str, Any]:
    """Names and texts as they stand in a file: those of mattes under the names that others look for."""
    return {key if key.startswith(PREFIX) else f"{OWN}{key}": text for key, text in metadata.items()}
