"""Media: which shapes enclose one, in which of them a point lies, and whether rays need lists of them.

The rules are those of docs/model.md, "Media". Rays pass surfaces on the device; only where they start is
decided here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import msgspec
import numpy as np

from clrt import layout
from clrt.base.errors import LimitError, located
from clrt.flatten.inside import count_inside
from clrt.scene.scene import Box, Cone, Cylinder, Ellipsoid, Mesh, Plane, Scene, Shape, Sphere

_CONVEX: Final = (Sphere, Ellipsoid, Box, Cylinder, Cone)
_MOST_PAIRED: Final = 4096  # shapes beyond which nobody asks whether all of them stand apart


@dataclass(frozen=True, eq=False)
class Extents:
    """Each shape's material, by its number, and its box: `low`, `high` (n, 3) float64.

    The box is infinite where a shape has none, and the wrong way round where it has no primitives.
    """

    materials: tuple[int, ...]
    low: np.ndarray
    high: np.ndarray


@dataclass(frozen=True, eq=False)
class Media:
    """The shapes of a scene that enclose media, those of larger boxes first.

    `source` is what messages on the scene start with. `shapes` are their numbers, `bodies` they themselves,
    `numbers` (n,) int32 their media (of the record Material), `low`, `high` (n, 3) float64 their boxes,
    infinite where a shape has none.

    It travels to workers (clrt/cluster) without the scene, which names files: these are not there, or are
    others, and a scene is checked again where it is unpickled, though its picture may have samples of its
    own that it would refuse.
    """

    source: str
    bodies: tuple[Shape, ...]
    shapes: np.ndarray
    numbers: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def __getstate__(self) -> dict[str, Any]:
        """Bodies without their materials, and meshes as they were read: by their arrays, not their files."""
        read = {k: body.data() for k, body in enumerate(self.bodies) if isinstance(body, Mesh)}
        bodies = tuple(
            Mesh(transform=body.transform) if isinstance(body, Mesh)
            else msgspec.structs.replace(body, material=None)
            for body in self.bodies
        )  # fmt: skip
        return {**self.__dict__, "bodies": bodies, "read": read}

    def __setstate__(self, state: dict[str, Any]) -> None:
        read = state.pop("read")
        self.__dict__.update(state)
        for k, data in read.items():
            self.bodies[k].__dict__["_data"] = data

    def lists(self, points: np.ndarray) -> np.ndarray:
        """The media that rays from the points (n, 3) start in: (n, layout.MEDIA) int32, -1 where empty.

        LimitError where a point lies in more than fit.
        """
        out = np.full((len(points), layout.MEDIA), -1, np.int32)
        points = np.asarray(points, np.float64)
        finite = np.isfinite(points).all(axis=1)
        if not finite.any():
            return out
        low, high = points[finite].min(axis=0), points[finite].max(axis=0)
        if (low == high).all():
            out[finite] = self._lists(points[finite][:1], low, high)
        else:
            out[finite] = self._lists(points[finite], low, high)
        return out

    def near(self, points: np.ndarray) -> bool:
        """Whether a shape's box meets that of the points (n, 3), enlarged by more than float32 rounds."""
        margin = 1e-5 * np.abs(points).max()
        low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
        return bool(((self.low <= high) & (self.high >= low)).all(axis=1).any())

    def _lists(self, points: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """The same for finite points between the corners `low` and `high`."""
        out, size = np.full((len(points), layout.MEDIA), -1, np.int32), np.zeros(len(points), np.int64)
        axis = int(np.argmax(high - low))
        order = np.argsort(points[:, axis], kind="stable")
        along = points[order, axis]
        for k in np.flatnonzero(((self.low <= high) & (self.high >= low)).all(axis=1)):
            start = np.searchsorted(along, self.low[k, axis], "left")
            near = order[start : np.searchsorted(along, self.high[k, axis], "right")]
            if len(near) == 0:
                continue
            count = count_inside(self.bodies[k], points[near])
            for more in range(int(count.max())):
                which = near[count > more]
                if (size[which] == layout.MEDIA).any():
                    raise too_deep(self.source)
                out[which, size[which]] = self.numbers[k]
                size[which] += 1
        return out


def too_deep(source: str) -> LimitError:
    """What is raised where a ray would be in too many media at a time."""
    text = f"rays enter more than {layout.MEDIA} media that lie in one another; nest fewer"
    return LimitError(located(source, "shapes", text))


def media_of(scene: Scene, materials: np.ndarray, extents: Extents) -> Media:
    """The media of a scene; materials: its records."""
    low, high = extents.low, extents.high
    number = materials["medium"][list(extents.materials)].astype(np.int32)
    number[~(low <= high).all(axis=1)] = -1
    (shapes,) = np.nonzero(number >= 0)
    with np.errstate(over="ignore", invalid="ignore"):  # a plane's box is endless
        largest_first = np.argsort(-np.prod(high - low, axis=1)[shapes], kind="stable")
    shapes = shapes[largest_first]
    bodies = tuple(scene.shapes[k] for k in shapes.tolist())
    return Media(scene.source, bodies, shapes, number[shapes], low[shapes], high[shapes])


def needs_lists(scene: Scene, materials: np.ndarray, extents: Extents) -> bool:
    """Whether rays must carry lists of media for the picture to be right.

    Not where every medium is clear, convex and stands apart from all else that asks for an index: then a
    surface's own side tells what lies behind it. Nor where rays are counted.
    """
    if scene.conformance == "spd" or not (materials["medium"] >= 0).any():
        return False
    if (materials["absorption"][materials["medium"] >= 0] > 0).any():
        return True
    asking = [k for k, shape in enumerate(scene.shapes) if _asks_for_index(scene, shape)]
    if len(asking) > _MOST_PAIRED:
        return True
    low, high = extents.low, extents.high
    planes = [shape for shape in map(scene.shapes.__getitem__, asking) if isinstance(shape, Plane)]
    solid = np.array([k for k in asking if not isinstance(scene.shapes[k], Plane)], np.int64)
    for k in asking:
        shape = scene.shapes[k]
        if not scene.material_of(shape).is_medium:
            continue
        if not isinstance(shape, _CONVEX) or shape.is_open:
            return True
        meets = ((low[k] <= high[solid]) & (high[k] >= low[solid])).all(axis=1)
        if meets.sum() > 1 or not all(_beside(plane, low[k], high[k]) for plane in planes):
            return True
    return False


def _asks_for_index(scene: Scene, shape: Shape) -> bool:
    material = scene.material_of(shape)
    return material.is_medium or material.fresnel is True or material.conductor is not None


def _beside(plane: Plane, low: np.ndarray, high: np.ndarray) -> bool:
    """Whether a box lies on one side of a plane."""
    normal = np.asarray(plane.normal, np.float64)
    away = (0.5 * (low + high) - plane.point) @ normal
    return bool(abs(away) > np.abs(normal) @ (0.5 * (high - low)) * (1 + 1e-6))


def extents_of(materials: Sequence[int], sections: dict[str, np.ndarray]) -> Extents:
    """Those of shapes of materials of these numbers, from the boxes of their primitives."""
    n = len(materials)
    shape, boxes = sections["primitives"]["shape"], sections["boxes"]
    low, high = np.full((n, 3), np.inf), np.full((n, 3), -np.inf)
    owner = shape if len(boxes) == len(shape) else shape[sections["finite"]]  # ascending
    if len(owner):
        first = np.flatnonzero(np.diff(owner, prepend=-1))
        low[owner[first]] = np.minimum.reduceat(boxes["low"][:, :3], first)
        high[owner[first]] = np.maximum.reduceat(boxes["high"][:, :3], first)
    endless = shape[sections["unbounded"]]
    low[endless], high[endless] = -np.inf, np.inf
    return Extents(tuple(materials), low, high)
