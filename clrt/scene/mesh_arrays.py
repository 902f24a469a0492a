"""The arrays of a mesh, checked: numbers float32 holds, vertices that are there, faces that are plane."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import Any

import msgspec
import numpy as np

from clrt.base.errors import one_line
from clrt.base.explain import FLOAT32_MAX, REFUSALS
from clrt.base.places import At
from clrt.base.records import check_kinds
from clrt.meshfiles.planar import flaws, is_sound

FEW = 8  # faces for which numpy takes far longer than Python
_ROWS = 1 << 16  # looked at at a time


def read_arrays(arrays: dict[str, Any], at: At, own: bool = False) -> dict[str, Any]:
    """The checked arrays of a mesh, read-only, by the keys of its table; own: arrays need not be copied."""
    arrays = {key: _array(value, at.key(key)) for key, value in arrays.items()}
    vertices = _points(arrays["vertices"], at.key("vertices"), "vertices", own)
    checked: dict[str, Any] = {
        "vertices": vertices,
        "faces": _faces(arrays["faces"], len(vertices), at.key("faces"), own),
    }
    if "normals" in arrays:
        normals = _points(arrays["normals"], at.key("normals"), "normals", own)
        if len(normals) != len(vertices):
            raise at.key("normals").says(
                f"{len(normals)} normals for {len(vertices)} vertices; give one each"
            )
        zero = np.flatnonzero(~(np.linalg.norm(normals.astype(np.float32), axis=1) > 0))
        if zero.size:
            raise (
                at.key("normals")
                .item(int(zero[0]))
                .error(normals[zero[0]].tolist(), "a normal must not be zero")
            )
        checked["normals"] = normals
    if "uv" in arrays:
        uv = _points(arrays["uv"], at.key("uv"), "uv", own, 2)
        if len(uv) != len(vertices):
            raise at.key("uv").says(f"{len(uv)} uv for {len(vertices)} vertices; give one each")
        checked["uv"] = uv
    return checked


def _points(value: object, at: At, noun: str, own: bool, width: int = 3) -> np.ndarray:
    """(n, width) float64, read-only; every number finite in float32. own: an array need not be copied."""
    if isinstance(value, np.ndarray):
        value = _plain(value, at)
        if value.dtype.kind not in "fiu" or value.ndim != 2 or value.shape[1] != width:
            raise at.says(
                f"an array of {value.dtype} {value.shape} is not allowed; {noun} must be numbers (n, {width})"
            )
        points = value.astype(np.float64, copy=not own)
    else:
        kind: Any = list[tuple[float, float, float]] if width == 3 else list[tuple[float, float]]
        rows = _rows(value, kind, at, f"{noun} must be {width} numbers each")
        points = np.array(rows, np.float64).reshape(-1, width)
    for start in range(0, len(points), _ROWS):
        good = np.abs(points[start : start + _ROWS]) <= FLOAT32_MAX
        if not good.all():
            row = start + int(np.argmin(good.all(axis=1)))
            raise at.item(row).error(points[row].tolist(), f"{noun} must be finite in float32")
    points.flags.writeable = False
    return points


def _array(value: object, at: At) -> object:
    """The array that others' tables, tensors and the like give of themselves."""
    if isinstance(value, (np.ndarray, np.generic)) or not hasattr(value, "__array__"):
        return value
    try:
        return np.asarray(value)
    except Exception as error:  # of whatever package it is
        why = one_line(str(error))[:80]
        raise at.says(f"a {type(value).__name__} is no array of numbers ({why})") from None


def _plain(array: np.ndarray, at: At) -> np.ndarray:
    """The array as one of numpy's own class: what others make of `*` or of rows is unknown."""
    if np.ma.is_masked(array):
        raise at.says(f"{np.ma.count_masked(array)} of its numbers are masked; fill them in")
    return np.asarray(array)


def _faces(value: object, vertices: int, at: At, own: bool) -> np.ndarray | tuple[np.ndarray, ...]:
    """(m, 3) int32 where all are triangles, else a tuple of int32 arrays; every index below `vertices`."""
    if isinstance(value, np.ndarray):
        value = _plain(value, at)
    if isinstance(value, np.ndarray) and value.dtype != object:
        if value.dtype.kind not in "iu" or value.ndim != 2:
            raise at.says(
                f"an array of {value.dtype} {value.shape} is not allowed; faces must be integers (m, 3)"
            )
        flat = value.reshape(-1)
        if value.shape[1] == 3 and value.size and flat.min() >= 0 and flat.max() < vertices:  # as most are
            return _frozen(flat, own).reshape(-1, 3)
        lengths = np.full(len(value), value.shape[1])
    else:
        if isinstance(value, np.ndarray):  # of objects
            value = list(value) if value.ndim else value
        if isinstance(value, Sequence) and not isinstance(value, (str, memoryview)):
            value = [face.tolist() if isinstance(face, np.ndarray) else face for face in value]
        rows = _rows(value, list[list[int]], at, "faces must be 3 or more vertex numbers each")
        lengths = np.fromiter(map(len, rows), np.int64, len(rows))
        try:
            flat = np.fromiter(chain.from_iterable(rows), np.int64, int(lengths.sum()))
        except OverflowError:
            raise at.says("a vertex number does not fit 64 bits") from None
    starts = np.concatenate(([0], np.cumsum(lengths)))
    short = np.flatnonzero(lengths < 3)
    if short.size:
        face = flat[starts[short[0]] : starts[short[0] + 1]].tolist()
        raise at.item(int(short[0])).error(face, "a face must have 3 or more vertices")
    wrong = np.flatnonzero((flat < 0) | (flat >= vertices))
    if wrong.size:
        face_number = int(np.searchsorted(starts, wrong[0], side="right")) - 1
        place = at.item(face_number).item(int(wrong[0] - starts[face_number]))
        right = (
            f"a vertex number must be from 0 to {vertices - 1}" if vertices else "the mesh has no vertices"
        )
        raise place.error(int(flat[wrong[0]]), right)
    flat = _frozen(flat, own)
    if (lengths == 3).all():
        return flat.reshape(-1, 3)
    return tuple(np.split(flat, starts[1:-1]))


def _frozen(flat: np.ndarray, own: bool) -> np.ndarray:
    flat = flat.astype(np.int32, copy=not own)
    flat.flags.writeable = False
    return flat


def _rows(value: object, kind: Any, at: At, right: str) -> Any:
    check_kinds(value, at)
    try:
        return msgspec.convert(msgspec.to_builtins(value, enc_hook=lambda item: item.tolist()), kind)
    except (*REFUSALS, TypeError, AttributeError) as error:
        path = str(error).rpartition("`$")[2].rstrip("`") if "`$" in str(error) else ""
        raise at.inner(path).says(f"not allowed ({str(error).partition(' - at ')[0]}); {right}") from None


def check_flat(vertices: np.ndarray, faces: np.ndarray | tuple[np.ndarray, ...], at: At) -> None:
    """Raise for the first face of more than 3 corners that is not plane or spans no area."""
    if isinstance(faces, np.ndarray):
        return  # a triangle is plane; one without area is never hit
    if len(faces) <= FEW and all(len(face) == 3 or is_sound(vertices[face].tolist()) for face in faces):
        return
    lengths = np.array([len(face) for face in faces])
    rounded = vertices.astype(np.float32).astype(np.float64)
    worst: list[tuple[int, str]] = []
    for length in np.unique(lengths[lengths > 3]):
        numbers = np.flatnonzero(lengths == length)
        collinear, bent = flaws(rounded[np.stack([faces[n] for n in numbers])])
        worst += [(int(numbers[i]), "must span an area") for i in np.flatnonzero(collinear)[:1]]
        worst += [
            (int(numbers[i]), "must lie in one plane, or smooth be true") for i in np.flatnonzero(bent)[:1]
        ]
    if worst:
        number, right = min(worst)
        raise at.item(number).error(faces[number].tolist(), f"the corners of a face {right}")
