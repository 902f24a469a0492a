"""Textures of a glTF file, as what stands for a colour in a scene file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Final, Literal

import msgspec
import numpy as np

from clrt.images.file import reader_of
from clrt.meshfiles.gltf.datauri import is_data
from clrt.meshfiles.gltf.document import Count, Document, Image, Table, decode, item
from clrt.meshfiles.look import Table as SceneTable
from clrt.meshfiles.look import not_there

_WRAPS: Final = {33071: "clamp", 33648: "mirror", 10497: "repeat"}
_NEAREST: Final = 9728
_NEITHER: Final = "textures that are neither PNG nor JPEG"

HEAD: Final = 8
"""Bytes that tell what kind of picture something is."""


class Transform(Table, frozen=True, gc=False):
    offset: tuple[float, float] = (0.0, 0.0)
    rotation: float = 0.0
    scale: tuple[float, float] = (1.0, 1.0)
    texCoord: Count | None = None


class InfoExtensions(Table, frozen=True, gc=False):
    KHR_texture_transform: Transform | None = None


class Info(Table, frozen=True, gc=False):
    """Where a material names a texture."""

    index: Count
    texCoord: Count = 0
    scale: float = 1.0
    extensions: InfoExtensions = InfoExtensions()


class Texture(Table, frozen=True, gc=False):
    source: Count | None = None
    sampler: Count | None = None


class Sampler(Table, frozen=True, gc=False):
    wrapS: Literal[33071, 33648, 10497] = 10497
    wrapT: Literal[33071, 33648, 10497] = 10497
    magFilter: Count = 0


@dataclass(frozen=True)
class Itself:
    """A file's `name`; `beside` gives the name of a file in its folder, None where there is none; `mean` the
    mean of the channels (3,) of a picture in such a file, or a part of it. `shows` says whether such a
    file is `readable`; `within` are the first bytes of a picture of a number within the file, b"" of none.
    """

    name: str
    beside: Callable[[str], str | None]
    mean: Callable[[str, int | None], np.ndarray]
    shows: Callable[[str], bool]
    within: Callable[[Image, int], bytes] = lambda image, number: b""


class _Metal(Table, frozen=True, gc=False):
    baseColorTexture: Any = None


class _Shown(Table, frozen=True, gc=False):
    """What of a material needs uv."""

    pbrMetallicRoughness: _Metal = _Metal()
    normalTexture: Any = None
    emissiveTexture: Any = None


def readable(head: bytes) -> bool:
    """Whether what begins so is a picture of a kind that is read; what has no bytes is not judged here."""
    return not head or reader_of(head) is not None


def textured_in(document: Document) -> Callable[[int], bool]:
    """What says whether the material of a number shows pictures; BrokenMesh where it is not there."""

    @cache
    def materials() -> tuple[msgspec.Raw, ...]:
        return decode(document.materials, tuple[msgspec.Raw, ...], "materials")

    @cache
    def textured(number: int) -> bool:
        shown = decode(item(materials(), number, "materials"), _Shown, f"materials[{number}]")
        pictures = shown.pbrMetallicRoughness.baseColorTexture, shown.normalTexture, shown.emissiveTexture
        return any(picture is not None for picture in pictures)

    return textured


def picture_count(document: Document) -> int:
    """How many pictures a document names: what is behind them is that of its vertices' colours."""
    return len(decode(document.images, tuple[msgspec.Raw, ...], "images"))


class Textures:
    """The textures of a document; what of them is not read goes to `left_out`."""

    def __init__(self, document: Document, itself: Itself, left_out: dict[str, None]) -> None:
        self._document, self._itself, self._left_out = document, itself, left_out
        self._textures: tuple[Texture, ...] | None = None
        self._images: tuple[Image, ...] = ()
        self._samplers: tuple[Sampler, ...] = ()
        self._readable: dict[int, bool] = {}  # of pictures within the file

    def picture(self, info: Info | None, uv: bool) -> SceneTable | None:
        """A texture as an image of a scene file; None where there is none, or it cannot be shown."""
        if info is None or not uv:
            return None
        moved = info.extensions.KHR_texture_transform or Transform()
        if (info.texCoord if moved.texCoord is None else moved.texCoord) != 0:
            return self._without("textures of second uv")
        source = self._source(info.index)
        if source is None:
            return None
        table = {"type": "image", **source}
        sampler = self._sampler(info.index)
        if sampler.wrapS != sampler.wrapT:
            self._without("a second way of wrapping")
        table |= {"wrap": _WRAPS[sampler.wrapS]} if sampler.wrapS != 10497 else {}
        table |= {"filter": "nearest"} if sampler.magFilter == _NEAREST else {}
        if moved.rotation != 0:
            self._without("the rotation of textures")
        table |= {"scale": list(moved.scale)} if moved.scale != (1.0, 1.0) else {}
        return table | ({"offset": list(moved.offset)} if moved.offset != (0.0, 0.0) else {})

    def mean(self, info: Info | None) -> tuple[float, float, float]:
        """The mean of a texture's numbers as they are stored; 1 where there is none. Of one that is left out
        what is no metal: factors of 1 beside it would make one of all."""
        source = self._source(info.index) if info is not None else None
        if source is None:
            return 1.0, 1.0, 1.0 if info is None else 0.0
        red, green, blue = self._itself.mean(source["file"], source.get("part")).tolist()
        return red, green, blue

    def _source(self, number: int) -> SceneTable | None:
        """The `file`, and `part`, of a texture's picture."""
        if self._textures is None:
            document = self._document
            self._textures = decode(document.textures, tuple[Texture, ...], "textures")
            self._images = decode(document.images, tuple[Image, ...], "images")
            self._samplers = decode(document.samplers, tuple[Sampler, ...], "samplers")
        source = item(self._textures, number, "textures").source
        image = Image() if source is None else item(self._images, source, "images")
        if source is None:  # mimeType is not asked: several exporters write image/jpg
            return self._without(_NEITHER)
        if image.uri is None or is_data(image.uri):
            if source not in self._readable:
                self._readable[source] = readable(self._itself.within(image, source))
            found = {"file": self._itself.name, "part": source}
            return found if self._readable[source] else self._without(_NEITHER)
        file = self._itself.beside(image.uri) or self._itself.beside(image.uri.replace("\\", "/"))
        if file is None:
            return self._without(not_there(image.uri))
        return {"file": file} if self._itself.shows(file) else self._without(_NEITHER)

    def _sampler(self, number: int) -> Sampler:
        assert self._textures is not None
        sampler = self._textures[number].sampler
        return Sampler() if sampler is None else item(self._samplers, sampler, "samplers")

    def _without(self, what: str) -> SceneTable | None:
        """None; and `what` is left out."""
        self._left_out[what] = None
        return None


