"""Mitsuba itself, in its LLVM variant; imported by the worker process only, for an LLVM error ends the
process."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np

VARIANT = "llvm_ad_rgb"

mi: Any = import_module("mitsuba")
mi.set_variant(VARIANT)
mi.set_log_level(mi.LogLevel.Error)
dr: Any = import_module("drjit")


def realised(plugin: Any) -> Any:
    """Plain data (plugins.py) as what mitsuba.load_dict takes."""
    if isinstance(plugin, dict):
        if plugin.get("type") == "mesh":
            return _mesh(plugin)
        return {key: realised(value) for key, value in plugin.items()}
    if isinstance(plugin, np.ndarray):
        if plugin.ndim == 3:
            return mi.Bitmap(np.ascontiguousarray(plugin, np.float32))
        return (mi.ScalarTransform3f if plugin.shape == (3, 3) else mi.ScalarTransform4f)(plugin)
    return plugin


def load(plugin: dict[str, Any]) -> Any:
    """A plugin, or a scene, as given: Mitsuba's own optimisation reorders and merges shapes.

    {"type": "file", "path": ...} is the scene in an XML file. Embree, which finds Mitsuba's hits, shall be
    watertight: its other way through boxes rounds, and on processors without AVX-512 a ray missed a cylinder.
    """
    if plugin["type"] == "file":
        return mi.load_file(plugin["path"], optimize=False)
    if plugin["type"] == "scene":
        plugin = plugin | {"embree_use_robust_intersections": True}
    return mi.load_dict(realised(plugin), optimize=False)


def _mesh(plugin: dict[str, Any]) -> Any:
    vertices, faces, normals = (plugin[key] for key in ("vertices", "faces", "normals"))
    texcoords = plugin.get("texcoords")
    inner = mi.Properties()
    for key in ("bsdf", "emitter"):
        if key in plugin:
            inner[key] = load(plugin[key])
    mesh = mi.Mesh("mesh", len(vertices), len(faces), props=inner, has_vertex_normals=True,
                   has_vertex_texcoords=texcoords is not None)  # fmt: skip
    params = mi.traverse(mesh)
    params["vertex_positions"] = mi.Float(vertices.astype(np.float32).ravel())
    params["vertex_normals"] = mi.Float(normals.astype(np.float32).ravel())
    if texcoords is not None:
        params["vertex_texcoords"] = mi.Float(texcoords.astype(np.float32).ravel())
    params["faces"] = mi.UInt32(faces.astype(np.uint32).ravel())
    params.update()
    for name, values in plugin.get("attributes", {}).items():
        mesh.add_attribute(name, 3, values.astype(np.float32).ravel())
    return mesh


def rays(origin: np.ndarray, direction: np.ndarray) -> Any:
    """Rays (n, 3) as Mitsuba's."""
    return mi.Ray3f(point(origin), vector(direction))


def point(array: np.ndarray) -> Any:
    return mi.Point3f(np.ascontiguousarray(array.T, np.float32))


def vector(array: np.ndarray) -> Any:
    return mi.Vector3f(np.ascontiguousarray(array.T, np.float32))


def rows(array: Any, n: int) -> np.ndarray:
    """Mitsuba's vectors or colours as float64 (n, 3)."""
    found = np.array(array, np.float64)
    return np.broadcast_to(found.reshape(found.shape[0], -1), (found.shape[0], n)).T


def column(array: Any, n: int) -> np.ndarray:
    """Mitsuba's numbers as float64 (n,)."""
    return np.broadcast_to(np.array(array, np.float64).ravel(), (n,))


def words(array: Any, n: int) -> np.ndarray:
    """Mitsuba's unsigned integers, or pointers, as their numbers (n,)."""
    return np.broadcast_to(np.array(dr.reinterpret_array(mi.UInt32, array)).ravel(), (n,)).astype(np.int64)


def number(shape: Any) -> int:
    """What `words` shows where a hit's shape is this one."""
    return int(words(mi.ShapePtr(shape), 1)[0])
