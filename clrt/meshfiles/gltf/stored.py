"""The numbers and pictures within a glTF file: views of its buffers, as its accessors and views say."""

from __future__ import annotations

import base64
import binascii
import re
from collections.abc import Callable
from functools import partial
from typing import Final
from urllib.parse import unquote_to_bytes

import numpy as np

from clrt.meshfiles.broken import BrokenMesh
from clrt.meshfiles.gltf.document import Accessor, Document, Image, decode, item, parse
from clrt.meshfiles.gltf.textures import HEAD

Fetch = Callable[[str], bytes]

_TYPES: Final = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS: Final = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_LETTERS: Final = 64  # of an address that hold `HEAD` bytes, however they are written


class Stored:
    """What a file stores; `fetch` gives what a file beside it holds. BrokenMesh where it is not there."""

    def __init__(self, document: Document, chunk: memoryview | None, fetch: Fetch) -> None:
        self.document, self.chunk, self.fetch = document, chunk, fetch
        self._buffers: dict[int, memoryview] = {}

    def accessor(self, number: int, kind: str) -> Accessor:
        accessor = item(self.document.accessors, number, "accessors")
        if accessor.type != kind:
            raise BrokenMesh(f"accessors[{number}] is of type {accessor.type}; {kind} is needed here")
        return accessor

    def numbers(self, number: int) -> np.ndarray:
        """The numbers of an accessor as float64, whole ones scaled where the file says so."""
        plain, normalized = self.plain(number), self.document.accessors[number].normalized
        if plain.dtype.kind == "f" or not normalized:
            return plain.astype(np.float64)
        return _scaled(plain)

    def fractions(self, number: int) -> np.ndarray:
        """The numbers of an accessor as float64 where whole ones are always parts of the largest."""
        plain = self.plain(number)
        return plain.astype(np.float64) if plain.dtype.kind == "f" else _scaled(plain)

    def plain(self, number: int) -> np.ndarray:
        """The (count, width) numbers of an accessor as they are stored."""
        accessor = self.document.accessors[number]
        where = f"accessors[{number}]"
        kind, width = np.dtype(_TYPES[accessor.componentType]), _WIDTHS[accessor.type]
        if accessor.bufferView is None and accessor.sparse is None:
            raise BrokenMesh(f"{where} has no bufferView, so no numbers")
        if accessor.bufferView is None:
            plain = np.zeros((accessor.count, width), kind)
        else:
            plain = self._stored(accessor.bufferView, accessor.byteOffset, accessor.count, width, kind, where)
        if accessor.sparse is not None:
            other, count = accessor.sparse, accessor.sparse.count
            at, values = other.indices, other.values
            whole = np.dtype(_TYPES[at.componentType])
            places = self._stored(at.bufferView, at.byteOffset, count, 1, whole, where)
            if count and not 0 <= places.min() <= places.max() < accessor.count:
                raise BrokenMesh(f"{where} replaces numbers that it does not have")
            plain = plain.copy()
            stored = self._stored(values.bufferView, values.byteOffset, count, width, kind, where)
            plain[places[:, 0].astype(np.int64)] = stored
        return plain

    def _stored(
        self, view: int, offset: int, count: int, width: int, kind: np.dtype, where: str
    ) -> np.ndarray:
        """A view (count, width) of a buffer; BrokenMesh where it would reach beyond."""
        found = item(self.document.bufferViews, view, "bufferViews")
        data = self._buffer(found.buffer, self.fetch)
        size = width * kind.itemsize
        stride = size if found.byteStride is None else found.byteStride
        end = offset + (stride * (count - 1) + size if count else 0)
        if found.byteOffset + found.byteLength > len(data) or end > found.byteLength:
            raise BrokenMesh(f"{where} reaches beyond the {len(data)} bytes of its buffer, or of its view")
        if stride < size:
            raise BrokenMesh(f"bufferViews[{view}].byteStride is {stride}; what {where} holds takes {size}")
        return np.ndarray((count, width), kind, data, found.byteOffset + offset, (stride, kind.itemsize))

    def first(self, image: Image, number: int) -> bytes:
        """The first bytes of a picture within the file; none where there is none, as who shows it says."""
        if image.uri is not None:
            return _head_of(image.uri)
        try:
            return bytes(self.viewed(image, f"images[{number}]")[:HEAD])
        except BrokenMesh:
            return b""

    def viewed(self, image: Image, where: str) -> memoryview:
        """The bytes, not copied, of a picture in a view of a buffer; BrokenMesh if it is not within."""
        if image.bufferView is None:
            raise BrokenMesh(f"{where} has no data")
        view = item(self.document.bufferViews, image.bufferView, "bufferViews")
        whole = self._buffer(view.buffer, partial(_refuse, where))
        if view.byteOffset + view.byteLength > len(whole):
            raise BrokenMesh(f"{where} reaches beyond the {len(whole)} bytes of its buffer")
        return whole[view.byteOffset : view.byteOffset + view.byteLength]

    def _buffer(self, number: int, fetch: Fetch) -> memoryview:
        if number not in self._buffers:
            uri = item(self.document.buffers, number, "buffers").uri
            if uri is None:
                if number or self.chunk is None:
                    raise BrokenMesh(f"buffers[{number}] has no data")
                self._buffers[number] = self.chunk
            else:
                self._buffers[number] = memoryview(_data_of(uri, fetch, f"buffers[{number}]"))
        return self._buffers[number]

def pictures_in(data: bytes, binary: bool) -> tuple[int, Callable[[int], bytes]]:
    """How many pictures a .gltf, or a .glb, names; and what gives the bytes of one that is within it.

    That raises BrokenMesh where it is not.
    """
    document, chunk = parse(data, binary)
    images = decode(document.images, tuple[Image, ...], "images")
    stored = Stored(document, chunk, partial(_refuse, "a picture"))

    def picture(number: int) -> bytes:
        where, image = f"images[{number}]", item(images, number, "images")
        if image.uri is not None:
            return bytes(_data_of(image.uri, partial(_refuse, where), where))
        return bytes(stored.viewed(image, where))

    return len(images), picture


def _refuse(where: str, name: str) -> bytes:
    raise BrokenMesh(f"{where} is not within the file; name its own file")


def _data_of(uri: str, fetch: Fetch, where: str) -> bytes:
    """What an address holds: data of its own, or a file."""
    if uri[:5].lower() != "data:":
        return fetch(uri)
    kind, _, text = uri.partition(",")
    try:
        return base64.b64decode(text) if kind.endswith(";base64") else unquote_to_bytes(text)
    except (binascii.Error, ValueError):
        raise BrokenMesh(f"{where} is not in base64") from None


def _head_of(uri: str) -> bytes:
    """The first bytes of an address that holds data of its own, of which no more than these are decoded."""
    start = uri.find(",") + 1 or len(uri)
    text = uri[start : start + _LETTERS]
    if not uri[:start].endswith(";base64,"):
        return unquote_to_bytes(text)[:HEAD]
    letters = re.sub(r"[^A-Za-z0-9+/]", "", text)  # there may be line breaks
    return base64.b64decode(letters[: len(letters) // 4 * 4])[:HEAD]


def _scaled(plain: np.ndarray) -> np.ndarray:
    """Whole numbers as parts of the largest."""
    return np.maximum(plain / np.iinfo(plain.dtype).max, -1.0)
