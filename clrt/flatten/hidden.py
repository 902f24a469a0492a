"""A camera that sees nothing but one surface, inside of it or below the floor: a hint, and cheap."""

from __future__ import annotations

from typing import Final

import numpy as np

from clrt.base import notices
from clrt.flatten.camera import flatten_camera, near_corners
from clrt.flatten.inside import count_inside
from clrt.flatten.rims import has_rim
from clrt.scene.mesh import Mesh
from clrt.scene.scene import Plane, Quadric, Scene, Shape

_MOST_WALLS: Final = 32  # shapes that are looked at
_MOST_FACES: Final = 1 << 18  # of a mesh
_MOST_ANGLES: Final = 1 << 21  # points times faces of a mesh


def warn_of_hidden_view(scene: Scene, low: np.ndarray, high: np.ndarray) -> None:
    """Warn of the first opaque shape that parts the camera from every light and every other finite shape.

    low, high: (n, 3) float64, the boxes of the shapes, infinite where there is none. A room, which is around
    both the camera and something else, is none of these, nor is a surface that can be seen through.
    """
    if scene.camera is None or scene.one_sided == "opaque":
        return
    eyes = near_corners(flatten_camera(scene.camera))
    around = ((low < eyes.min(axis=0)) & (eyes.max(axis=0) < high)).all(axis=1)
    finite = np.isfinite(low).all(axis=1) & np.isfinite(high).all(axis=1)
    for k in np.flatnonzero(around)[:_MOST_WALLS]:
        shape, others = scene.shapes[k], finite.copy()
        others[k] = False
        if _is_wall(scene, shape) and _parts(scene, shape, eyes, (low[others] + high[others]) / 2):
            where = "the camera is on the other side" if isinstance(shape, Plane) else "the camera is inside"
            text = f"it hides all lights and other shapes: {where}; move the camera's origin, or the shape"
            notices.warn(scene.source, f"shapes[{k}]", text)
            return


def _is_wall(scene: Scene, shape: Shape) -> bool:
    """Whether nothing is seen through a shape, and it has an inside."""
    material = scene.material_of(shape)
    if material.kt > 0 or shape.is_open or isinstance(shape, Quadric):
        return False
    return not isinstance(shape, Mesh) or (shape.primitives <= _MOST_FACES and not has_rim(shape))


def _parts(scene: Scene, shape: Shape, eyes: np.ndarray, middles: np.ndarray) -> bool:
    """Whether the eyes (n, 3) are on one side of the shape and the middles, and all lights, on the other."""
    places = [light.place for light in scene.lights]
    points = [place[:3] for place in places if place[3]]
    others = np.concatenate([np.reshape(points, (-1, 3)), middles])
    far = [place[:3] for place in places if not place[3]]
    if len(others) + len(far) == 0:
        return False
    if isinstance(shape, Mesh) and (len(others) + len(eyes)) * shape.primitives > _MOST_ANGLES:
        return False
    inside = count_inside(shape, eyes) > 0
    if inside.any() != inside.all() or not (inside.all() or isinstance(shape, Plane)):
        return False
    beyond = [np.dot(d, shape.normal) < 0 if isinstance(shape, Plane) else False for d in far]
    return bool((np.append(count_inside(shape, others) > 0, beyond) != inside[0]).all())
