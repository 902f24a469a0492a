"""Colours of vertices and faces as a picture: linear between a triangle's corners.

Each triangle has four texels of its own, in a square: its corners' colours a, b, c and, opposite of a,
b + c - a. Four texels so chosen are interpolated to what is linear in both directions; u and v of the corners
are the middles of their texels. The fourth colour may be below 0 or above 1; what a triangle shows is not.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from clrt.meshfiles.parts import Arrays, Placed

_OFF: Final = np.array([[0.5, 0.5], [1.5, 0.5], [0.5, 1.5]])  # where the corners are in their square, texels


def spread(placed: Placed) -> Placed:
    """Parts with colours on corners of their own, where they lie in their file's `picture`.

    Parts without that a shape joins with such ones are white.
    """
    if not any(part.corners is not None for part in placed.parts):
        return placed
    plain = {number for number, part in enumerate(placed.parts) if part.corners is None}
    joined = [{*placed.which[places].tolist()} for _, _, places in placed.groups] if plain else []
    white = {number for group in joined if group - plain for number in group & plain}
    all_parts = [
        replace(part, corners=partial(np.ones, (part.faces, 3, 3))) if number in white else part
        for number, part in enumerate(placed.parts)
    ]
    placed = replace(placed, parts=all_parts)
    count = sum(part.faces for part in placed.parts if part.corners is not None)
    first, parts = 0, []
    for part in placed.parts:
        if part.corners is None:
            parts.append(part)
            continue
        read = partial(_apart, part.read, first, count)
        parts.append(replace(part, vertices=3 * part.faces, read=read, uv=True))
        first += part.faces
    return replace(placed, parts=parts)


def picture(placed: Placed) -> np.ndarray | None:
    """The colours of all corners, (height, width, 3) float32, linear; None where nothing has any."""
    found = [*_corners(placed)]
    if not found:
        return None
    a, b, c = np.concatenate(found).astype(np.float32).transpose(1, 0, 2)
    rows, columns = _size(len(a))
    out = np.zeros((rows * columns, 2, 2, 3), np.float32)
    out[: len(a), 0, 0], out[: len(a), 0, 1], out[: len(a), 1, 0] = a, b, c
    out[: len(a), 1, 1] = b + c - a
    return out.reshape(rows, columns, 2, 2, 3).transpose(0, 2, 1, 3, 4).reshape(2 * rows, 2 * columns, 3)


def _corners(placed: Placed) -> Iterator[np.ndarray]:
    for part in placed.parts:
        if part.corners is not None:
            yield part.corners()


def _size(count: int) -> tuple[int, int]:
    """Rows and columns of squares for so many triangles."""
    columns = math.isqrt(max(count - 1, 0)) + 1
    return -(-count // columns), columns


def _apart(read: Callable[[], Arrays], first: int, count: int) -> Arrays:
    vertices, faces, normals, _ = read()
    rows, columns = _size(count)
    number = first + np.arange(len(faces))
    square = 2.0 * np.stack([number % columns, number // columns], axis=1)
    uv = (square[:, None] + _OFF) / (2.0 * columns, 2.0 * rows)
    corners = faces.reshape(-1)
    own = np.arange(faces.size, dtype=np.int32).reshape(-1, 3)
    return vertices[corners], own, None if normals is None else normals[corners], uv.reshape(-1, 2)
