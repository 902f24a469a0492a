"""A shape's `transform`: a 4x4 matrix, or a list of steps applied in order."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from msgspec import Meta

from clrt.base.hints import Rows
from clrt.base.places import At
from clrt.base.records import Record, Vector, cross, float32, is_zero

Axis = Literal["x", "y", "z"]
Row = tuple[float, float, float, float]
_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}

if TYPE_CHECKING:
    Turn = Rows
else:
    Turn = Annotated[
        tuple[Vector | Axis, float],
        Meta(description="must be [axis, degrees], the axis 3 numbers or 'x', 'y', 'z'"),
    ]


class Step(Record, frozen=True, kw_only=True):
    """One of: `translate = [x, y, z]`, `rotate = [axis, degrees]` (counter-clockwise seen from the
    axis' tip), `scale = s` or `scale = [x, y, z]`."""

    translate: Vector | None = None
    rotate: Turn | None = None
    scale: Annotated[float | Vector, Meta(description="scale must be a number or 3 numbers")] | None = None

    def check(self, at: At) -> None:
        given = [name for name in ("translate", "rotate", "scale") if getattr(self, name) is not None]
        if len(given) != 1:
            raise at.says(
                f"a step must have exactly one of translate, rotate, scale, not {len(given)} of them"
            )
        if self.rotate is not None and not isinstance(self.rotate[0], str) and is_zero(self.rotate[0]):
            raise at.key("rotate").error(self.rotate, "the axis of a rotation must not be zero")

    @property
    def matrix(self) -> np.ndarray:
        """The step as a (4, 4) float64 matrix for column vectors."""
        matrix = np.eye(4)
        if self.translate is not None:
            matrix[:3, 3] = self.translate
        if self.scale is not None:
            matrix[:3, :3] *= self.scale if isinstance(self.scale, (int, float)) else np.asarray(self.scale)
        if self.rotate is not None:
            axis, degrees = self.rotate
            matrix[:3, :3] = _rotation(_AXES[axis] if isinstance(axis, str) else axis, degrees)
        return matrix


if TYPE_CHECKING:
    Transform = Rows
else:
    Transform = Annotated[
        tuple[Row | Step, ...],
        Meta(
            description="transform must be a 4x4 matrix (row by row) or a list of "
            "{translate}, {rotate}, {scale}"
        ),
    ]


def check(transform: Any, at: At) -> None:
    """Raise `SceneError` unless the transform is 4 rows or all steps, affine, and can be undone."""
    if any(isinstance(part, Step) for part in transform):
        for index, part in enumerate(transform):
            if not isinstance(part, Step):
                raise at.item(index).error(part, "a step must be {translate}, {rotate} or {scale}")
            part.check(at.item(index))
    elif transform and len(transform) != 4:
        raise at.error(transform, "a transform must be 4 rows of 4 numbers or a list of steps")
    if len(transform) == 1 and transform[0].translate and all(abs(x) < 1e30 for x in transform[0].translate):
        return  # as millions of shapes may have it
    if len(transform) == 4 and not isinstance(transform[0], Step) and _is_plain(transform):
        return
    with np.errstate(over="ignore", invalid="ignore"):
        matrix = float32(matrix_of(transform))
    if matrix[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
        raise at.item(3).error(matrix[3].tolist(), "the last row of a transform must be [0, 0, 0, 1]")
    if not np.isfinite(matrix).all():
        raise at.says("the transform overflows float32; use smaller numbers")
    linear = matrix[:3, :3].tolist()
    size = math.hypot(*linear[0], *linear[1], *linear[2])
    volume = sum(a * b for a, b in zip(linear[0], cross(linear[1], linear[2]), strict=True))
    if abs(volume) > 1e-5 * size**3:  # the least stretch is volume / size^2 or more
        return
    stretch = np.linalg.svd(matrix[:3, :3], compute_uv=False)
    if stretch[2] <= 1e-7 * stretch[0]:
        raise at.error(_stated(transform), "a transform must not be singular (flatten space)")


def _stated(transform: Any) -> Any:
    """A transform as a scene file states it, for messages."""
    if not isinstance(transform[0], Step):
        return transform
    keys = ("translate", "rotate", "scale")
    return [{key: value for key in keys if (value := getattr(step, key)) is not None} for step in transform]


def _is_plain(rows: Any) -> bool:
    """Whether it is clear of four rows that `check` would find nothing: numpy takes longer, and there may be
    many."""
    a, b, c, last = rows
    if last != (0.0, 0.0, 0.0, 1.0) or not math.hypot(*a, *b, *c) < 1e30:
        return False
    cube = math.hypot(*a[:3], *b[:3], *c[:3]) ** 3
    volume = sum(x * y for x, y in zip(a, cross(b[:3], c[:3]), strict=False))
    return abs(volume) > 2e-5 * cube > 1e-30  # float32 has fewer digits, and ends at less


def matrix_of(transform: Any) -> np.ndarray:
    """The (4, 4) float64 matrix of a checked transform; None is the identity. The first step acts first."""
    if not transform:
        return np.eye(4)
    if not isinstance(transform[0], Step):
        return np.asarray(transform, np.float64)
    matrix: np.ndarray = transform[0].matrix
    for step in transform[1:]:
        matrix = step.matrix @ matrix
    return matrix + 0.0  # of zeros only one kind


def is_similarity(matrix: np.ndarray) -> bool:
    """Whether a (4, 4) matrix keeps spheres round: its 3x3 part is a scaled rotation or mirror (to 1e-6)."""
    product = matrix[:3, :3] @ matrix[:3, :3].T
    square = np.trace(product) / 3
    return bool(np.abs(product - square * np.eye(3)).max() <= 1e-6 * square)


def _rotation(axis: Vector, degrees: float) -> np.ndarray:
    """Rodrigues' formula; exact for multiples of 90 degrees about a coordinate axis."""
    x, y, z = np.asarray(axis, np.float64) / np.linalg.norm(axis)
    quarter, rest = divmod(degrees, 90.0)
    if rest == 0.0:
        cos, sin = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarter) % 4]
    else:
        cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    along = np.outer((x, y, z), (x, y, z))
    return cos * np.eye(3) + sin * across + (1.0 - cos) * along
