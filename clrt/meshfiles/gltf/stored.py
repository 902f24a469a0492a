"""The numbers and pictures within a glTF file: views of its buffers, as its accessors and views say."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final

import numpy as np

from clrt.meshfiles.broken import BrokenMesh
from clrt.meshfiles.gltf.datauri import BUFFERS, data_of, head_of, is_data
from clrt.meshfiles.gltf.document import Accessor, Buffer, Document, Image, Sparse, decode, item, parse
from clrt.meshfiles.gltf.textures import HEAD

Fetch = Callable[[str], bytes]

_TYPES: Final = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS: Final = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_INDICES: Final = (5121, 5123, 5125)  # whole numbers without a sign


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
            values = accessor.sparse.values
            places = self._places(accessor.sparse, accessor.count, where)
            plain = plain.copy()
            plain[places] = self._stored(
                values.bufferView, values.byteOffset, len(places), width, kind, where
            )
        return plain

    def indices(self, number: int) -> np.ndarray:
        """The indices (n,) in an accessor, as int64. The largest of their type is none: the specification,
        3.7.2.1. Some programs begin a new strip there, others leave its triangle out."""
        where, kind = f"accessors[{number}]", self.accessor(number, "SCALAR").componentType
        if kind not in _INDICES:
            raise BrokenMesh(f"{where} must hold whole numbers to be indices")
        found = self.plain(number).reshape(-1)
        most = np.iinfo(_TYPES[kind]).max
        if (found == most).any():
            raise BrokenMesh(f"{where} has the index {most}; of its componentType {most - 1} is the largest")
        return found.astype(np.int64)

    def _places(self, sparse: Sparse, most: int, where: str) -> np.ndarray:
        """Which of an accessor's `most` numbers are replaced, (n,) int64; none of them twice."""
        at, kind = sparse.indices, sparse.indices.componentType
        if kind not in _INDICES:
            text = f"{where}.sparse.indices.componentType is {kind}"
            raise BrokenMesh(f"{text}; it must be one of {', '.join(map(str, _INDICES))}")
        stored = self._stored(at.bufferView, at.byteOffset, sparse.count, 1, np.dtype(_TYPES[kind]), where)
        places = stored[:, 0].astype(np.int64)
        if len(places) and places.max() >= most:
            raise BrokenMesh(f"{where} replaces numbers that it does not have")
        if (np.diff(places) <= 0).any():
            row = int(np.argmax(np.diff(places) <= 0))
            text = f"{where}.sparse.indices has {places[row + 1]} after {places[row]}"
            raise BrokenMesh(f"{text}; each must be larger than the one before")
        return places

    def _stored(
        self, view: int, offset: int, count: int, width: int, kind: np.dtype, where: str
    ) -> np.ndarray:
        """A view (count, width) of a buffer; BrokenMesh where it would reach beyond."""
        found = item(self.document.bufferViews, view, "bufferViews")
        data = self._buffer(found.buffer, self.fetch)
        size = width * kind.itemsize
        stride = found.byteStride or size  # 0, as some write it, is none
        end = offset + (stride * (count - 1) + size if count else 0)
        if found.byteOffset + found.byteLength > len(data) or end > found.byteLength:
            raise BrokenMesh(f"{where} reaches beyond the {len(data)} bytes of its buffer, or of its view")
        if stride < size:
            raise BrokenMesh(f"bufferViews[{view}].byteStride is {stride}; what {where} holds takes {size}")
        return np.ndarray((count, width), kind, data, found.byteOffset + offset, (stride, kind.itemsize))

    def first(self, image: Image, number: int) -> bytes:
        """The first bytes of a picture within the file; none where there is none, as who shows it says."""
        if image.uri is not None:
            return head_of(image.uri, HEAD)
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
        """The bytes that a buffer declares; BrokenMesh where there are fewer. More may follow them."""
        if number not in self._buffers:
            buffer, where = item(self.document.buffers, number, "buffers"), f"buffers[{number}]"
            data = self._contents(number, buffer, fetch, where)
            declared = len(data) if buffer.byteLength is None else buffer.byteLength
            if declared > len(data):
                text = f"{where}.byteLength is {declared}, and it has {len(data)} bytes"
                raise BrokenMesh(f"{text}; it may be cut short")
            self._buffers[number] = data[:declared]
        return self._buffers[number]

    def _contents(self, number: int, buffer: Buffer, fetch: Fetch, where: str) -> memoryview:
        if buffer.uri is not None:
            uri = buffer.uri
            return memoryview(data_of(uri, where, BUFFERS) if is_data(uri) else fetch(uri))
        if number or self.chunk is None:
            raise BrokenMesh(f"{where} has no data")
        return self.chunk


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
            return data_of(image.uri, where) if is_data(image.uri) else _refuse(where, image.uri)
        return bytes(stored.viewed(image, where))

    return len(images), picture


def _refuse(where: str, name: str) -> bytes:
    raise BrokenMesh(f"{where} is not within the file; name its own file")


def _scaled(plain: np.ndarray) -> np.ndarray:
    """Whole numbers as parts of the largest."""
    return np.maximum(plain / np.iinfo(plain.dtype).max, -1.0)
