"""OBJ files, as their description (Wavefront, "Object Files") has them, as far as they are faces."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from .patches import Array, Patch, Patches, Unreadable, fans, finite

_COUNTED = (b"v", b"vt", b"vn")
_NUMBERS = {b"v": (3, 4, 6), b"vt": (2, 3), b"vn": (3,)}  # how many a line may have
_WIDTHS = {b"v": 3, b"vt": 2, b"vn": 3}  # of which so many are of use
_PASSED_OVER = (b"o", b"g", b"s", b"l", b"p")  # names, and what has no surface
_MANY = 64  # materials up to which a file is always taken apart
_NAME = re.compile(rb"[ \t]*(?:usemtl|mtllib|[og])[ \t](?:(?!\s#(?:\s|$)).)*")  # in which `#25` is a word
_GOES_ON = re.compile(rb"((?:^[ \t]*(?:usemtl|mtllib|[og])[ \t]|#)[^\r\n]*)|\\(?:\r\n?|\n)", re.MULTILINE)
_WHOLE = re.compile(rb"[-+]?[0-9]+")

Corner = tuple[int, int | None, int | None]
"""Numbers from 0 of a vertex, and of its uv and its normal, if any."""


def patches(data: bytes) -> Patches:
    """The faces, those of one material a part; parts are numbered as their first faces follow each other."""
    counted: dict[bytes, list[list[float]]] = {key: [] for key in _COUNTED}
    faces: dict[tuple[bytes | None, bool, bool], list[list[Corner]]] = {}
    material, library = None, False
    for number, words in _lines(data):
        key = words[0]
        try:
            if key in counted:
                counted[key].append(_numbers(key, words[1:]))
            elif key == b"f":
                face = [_corner(word, counted) for word in words[1:]]
                forms = {(uv is not None, normal is not None) for _, uv, normal in face}
                if len(forms) > 1:
                    raise Unreadable("a face whose corners have not all the same")
                if len(face) > 2:  # else it has no surface
                    faces.setdefault((material, *forms.pop()), []).append(face)
            elif key == b"usemtl":
                material = b" ".join(words[1:])
            elif key == b"mtllib":
                library = True
            elif key not in _PASSED_OVER:
                raise Unreadable(key.decode("latin-1")[:20])
        except ValueError as error:
            raise Unreadable(f"line {number}: {error}") from None
    arrays = {
        key: finite(np.array(rows, float).reshape(-1, _WIDTHS[key]), key.decode())
        for key, rows in counted.items()
    }
    materials = list(dict.fromkeys(name for name, _, _ in faces))
    found = [(materials.index(key[0]), _patch(each, arrays)) for key, each in faces.items()]
    return Patches(found, _untold(materials, len(faces), library))


def _untold(materials: list[bytes | None], groups: int, library: bool) -> str:
    """Why parts cannot be numbered; "" where they can."""
    if materials == [None] and groups == 1:
        return ""
    if groups > len(materials):
        return "faces of one material with uv or normals, and others without"
    if not library:
        return "materials without a library"
    return "more than 64 materials" if len(materials) > _MANY else ""


def _lines(data: bytes) -> Iterator[tuple[int, list[bytes]]]:
    """The words of each line that has some, and its number; lines that go on in the next count as one."""
    whole = _GOES_ON.sub(lambda found: found[1] or b" ", data.removeprefix(b"\xef\xbb\xbf"))
    for number, line in enumerate(whole.splitlines(), 1):
        named = _NAME.match(line)
        words = (named[0] if named else line.partition(b"#")[0]).split()
        if words:
            yield number, words


def _numbers(key: bytes, words: list[bytes]) -> list[float]:
    if len(words) not in _NUMBERS[key]:
        raise Unreadable(f"{len(words)} numbers of {key.decode()}")
    found = [float(word) for word in words if b"_" not in word]
    if len(found) < len(words):
        raise Unreadable("numbers with _")
    if key == b"v" and len(found) == 4 and found[3] != 1:
        raise Unreadable("a weight other than 1")
    return found[: _WIDTHS[key]]


def _corner(word: bytes, counted: dict[bytes, list[list[float]]]) -> Corner:
    """`v`, `v/vt`, `v//vn` or `v/vt/vn`; numbers below 0 count back from the line where they stand."""
    parts = word.split(b"/")
    if len(parts) > 3 or not parts[0]:
        raise Unreadable(f"a corner {word.decode('latin-1')[:20]}")
    found: list[int | None] = []
    for key, part in zip(_COUNTED, [*parts, b"", b""], strict=False):
        if part and not _WHOLE.fullmatch(part):
            raise Unreadable(f"a corner {word.decode('latin-1')[:20]}")
        number = int(part) if part else None
        back = number is not None and number < 0
        found.append(None if number is None else number + len(counted[key]) if back else number - 1)
        if number is not None and (found[-1] or 0) < 0:
            raise Unreadable(f"{key.decode()} {number}, which is not there")
    first, uv, normal = found
    assert first is not None
    return first, uv, normal


def _patch(faces: list[list[Corner]], arrays: dict[bytes, Array]) -> Patch:
    """Faces whose corners all have the same."""
    flat = np.array([[-1 if n is None else n for n in corner] for face in faces for corner in face])
    for key, column in zip(_COUNTED, flat.T, strict=True):
        if column.max() >= len(arrays[key]):
            raise Unreadable(f"{key.decode()} {column.max() + 1}, and there are {len(arrays[key])}")
    starts = np.cumsum([0, *map(len, faces)])
    points = arrays[b"v"][flat[:, 0]]
    rows = fans(points, [range(*ends) for ends in pairwise(starts.tolist())])
    has_uv, has_normals = (flat[0, 1:] >= 0).tolist()
    uv = arrays[b"vt"][flat[rows, 1]] * (1, -1) + (0, 1) if has_uv else None  # v = 0 is at the bottom there
    return Patch(points[rows], arrays[b"vn"][flat[rows, 2]] if has_normals else None, uv)
