"""A mesh file as a scene: the mesh, a camera that has it all in view, and one light."""

from __future__ import annotations

import math
from pathlib import Path

import msgspec
import numpy as np

from clrt.base.errors import SceneError, located
from clrt.base.limits import Limits
from clrt.scene.scene import Camera, Material, Mesh, PointLight, Scene

_TOWARDS_CAMERA = np.array([0.5, 0.4, 1.0])
_TOWARDS_LIGHT = np.array([-0.3, 1.0, 0.9])


def load(path: Path, limits: Limits, smooth: bool | None = None) -> Scene:
    """The mesh in an .obj, .ply, .glb, .gltf or .stl file, seen from the front, the right and above; y is up.

    `smooth` True interpolates vertex normals, False shades flat, None does as the file says.
    """
    mesh = Mesh(file=path.name, smooth=smooth, material=Material(diffuse=0.8, specular=0.2))
    scene = Scene(
        folder=path.parent, source=path.name, limits=limits, ambient=0.2, background=0.05, shapes=(mesh,)
    )
    read = scene.shapes[0]
    assert isinstance(read, Mesh)
    vertices = read.data().vertices
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    center, radius = (low + high) / 2, float(np.linalg.norm(high - low)) / 2
    if not radius > 0:
        raise SceneError(located(path.name, "", "all its vertices are at one point"))
    camera = Camera(origin=(0.0, 0.0, 1.0), target=(0.0, 0.0, 0.0))
    half = math.atan(math.tan(math.radians(camera.fov / 2)) * camera.height / camera.width)
    origin = center + _TOWARDS_CAMERA / np.linalg.norm(_TOWARDS_CAMERA) * 1.02 * radius / math.sin(half)
    light = center + _TOWARDS_LIGHT / np.linalg.norm(_TOWARDS_LIGHT) * 6 * radius
    return msgspec.structs.replace(
        scene,
        camera=msgspec.structs.replace(camera, origin=_vector(origin), target=_vector(center)),
        lights=(PointLight(position=_vector(light)),),
    )


def _vector(point: np.ndarray) -> tuple[float, float, float]:
    x, y, z = point.tolist()
    return x, y, z
