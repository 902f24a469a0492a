"""Data that a glTF file has in an address, `data:image/png;base64,...` (RFC 2397).

What does not follow that form is refused: its letters would be taken for the bytes themselves.
"""

from __future__ import annotations

import binascii
import re
from typing import Final
from urllib.parse import unquote_to_bytes

from clrt.base.errors import show
from clrt.meshfiles.broken import BrokenMesh

BUFFERS: Final = ("application/octet-stream", "application/gltf-buffer")
"""The media types of buffers: the specification, 3.6.1.1. That of a picture says nothing: its bytes do."""

_SCHEME: Final = "data:"
_LONGEST: Final = 200  # letters of what stands before the data
_TOKEN: Final = r"[\w!#$%&'*+.^`|~-]+"
_BEGIN: Final = re.compile(
    rf'{_SCHEME}(?P<type>{_TOKEN}/{_TOKEN})?(?:;{_TOKEN}=(?:{_TOKEN}|"[^",]*"))*(?P<base64>;base64)?',
    re.IGNORECASE | re.ASCII,
)
_NO_BYTE: Final = re.compile(r"%(?![0-9A-Fa-f]{2}).{0,2}", re.DOTALL)
_CUT: Final = re.compile(r"%[0-9A-Fa-f]?\Z")
_NO_LETTER: Final = re.compile(rb"[^A-Za-z0-9+/=]|=(?!=?\Z)")
_SPACE: Final = b" \t\n\v\f\r"  # RFC 2045: passed over wherever it stands
_LETTERS: Final = 16  # for each byte that is looked at: they may be percents, and ends of lines


def is_data(uri: str) -> bool:
    """Whether an address holds data of its own."""
    return uri[: len(_SCHEME)].lower() == _SCHEME


def data_of(uri: str, where: str, types: tuple[str, ...] = ()) -> bytes:
    """The data in an address; BrokenMesh where there is none, or it is of none of the media `types`.

    Of a type that is not stated nothing is asked: many programs leave it out.
    """
    kind, base64, start = _begin(uri, where)
    if types and kind and kind.lower() not in types:
        raise BrokenMesh(f"{where}.uri is of the type {show(kind[:60])}; it must be {' or '.join(types)}")
    wrong = _NO_BYTE.search(uri, start)
    if wrong:
        raise BrokenMesh(f"{where}.uri has {show(wrong[0])}; % stands before two digits, 0-9 and a-f")
    data = unquote_to_bytes(uri[start:])
    return _decoded(data, where) if base64 else data


def head_of(uri: str, count: int) -> bytes:
    """The first bytes of the data in an address, of which no more is decoded; none where it is broken."""
    try:
        _, base64, start = _begin(uri, "")
        text = unquote_to_bytes(_CUT.sub("", uri[start : start + _LETTERS * count]))
        if base64:
            letters = _letters(text)
            text = _decoded(letters[: len(letters) // 4 * 4], "")
    except BrokenMesh:
        return b""
    return text[:count]


def _begin(uri: str, where: str) -> tuple[str, bool, int]:
    """The media type, "" where none is stated, whether the data is in base64, and where it begins."""
    comma = uri.find(",", 0, _LONGEST)
    found = _BEGIN.fullmatch(uri, 0, comma) if comma >= 0 else None
    if found is None:
        begin = uri[: comma + 1 if comma >= 0 else 60]
        raise BrokenMesh(f"{where}.uri begins with {show(begin[:80])}; data begins like data:TYPE;base64,")
    return found["type"] or "", found["base64"] is not None, comma + 1


def _letters(text: bytes) -> bytes:
    return text.translate(None, _SPACE)


def _decoded(text: bytes, where: str) -> bytes:
    """What letters of base64 stand for. BrokenMesh where Python's decoder would pass over some."""
    letters = _letters(text)
    try:
        if len(letters) % 4 == 0 and not letters.endswith(b"==="):  # which Python passes over, too
            return binascii.a2b_base64(letters, strict_mode=True)
    except binascii.Error:
        pass
    why = f"it has {len(letters)} letters, not 4 for every 3 bytes; it may be cut short"
    if wrong := _NO_LETTER.search(letters):
        letter = show(wrong[0].decode("latin-1"))
        why = f"letter {wrong.start() + 1} is {letter}; it must be one of A-Z a-z 0-9 + / or end it as ="
    raise BrokenMesh(f"{where} is not in base64: {why}")
