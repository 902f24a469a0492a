"""Parts as plugins of Mitsuba's, in plain data: dicts, numbers, lists; matrices and meshes as numpy arrays.

A mesh, which Mitsuba reads from files only, is {"type": "mesh", "vertices", "faces", "normals"}: the worker
builds it in memory, the XML writer puts it into a PLY file.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from .forms import Array
from .parts import Geometry, Part

Plugin = dict[str, Any]
NATIVE, FLAT, SMOOTH = 0, 1, 2


def rgb(value: Any) -> Plugin:
    """A colour (3,) or number."""
    return {"type": "rgb", "value": [float(band) for band in np.broadcast_to(value, 3)]}


def shape(part: Part, **inner: Any) -> Plugin:
    """The plugin of one part, with what lies within it (`bsdf`, `emitter`)."""
    flip = {"flip_normals": True} if part.flip else {}
    if part.mesh is not None:
        mesh = part.mesh
        return {
            "type": "mesh",
            "vertices": mesh.vertices,
            "faces": mesh.faces,
            "normals": mesh.normals,
            **inner,
        }
    to_world = part.to_world
    assert to_world is not None
    if part.kind in ("disk", "rectangle"):
        return {"type": part.kind, "to_world": to_world, **flip, **inner}
    if part.kind == "sphere":
        radius = float(np.linalg.norm(to_world[:3, 0]))
        return {"type": "sphere", "center": to_world[:3, 3].tolist(), "radius": radius, **flip, **inner}
    origin, end = to_world[:3, 3], to_world[:3, 3] + to_world[:3, 2]
    ends = {"p0": origin.tolist(), "p1": end.tolist(), "radius": float(np.linalg.norm(to_world[:3, 0]))}
    return {"type": "cylinder", **ends, **flip, **inner}


def packed(world: Geometry) -> dict[str, Any]:
    """All parts in as few plugins as may be, and what each of their primitives is.

    `shapes`: the plugins; `first` (shapes,): a plugin's first row in `owner` (the scene's shape), `form` (row
    in `forms`, or -1) and `kind` (NATIVE; FLAT: the mesh's normals are the surface's; SMOOTH: they are for
    shading); `size`, `fine`, `center`: the scene's. Shapes are moved so that this centre is at 0, where
    float32 is finest.
    """
    parts = [shifted(part, -world.center) for part in world.parts]
    groups: list[tuple[Plugin, list[Part], list[int], int]] = []
    groups += [(shape(part), [part], [1], NATIVE) for part in parts if part.mesh is None]
    meshes = [part for part in parts if part.mesh is not None]
    for smooth in (False, True):
        alike = [part for part in meshes if part.smooth == smooth]
        counts = [len(part.mesh.faces) for part in alike if part.mesh is not None]
        if sum(counts):
            groups.append((_joined(alike), alike, counts, SMOOTH if smooth else FLAT))
    whose = [part for _, alike, _, _ in groups for part in alike]
    lengths = [count for _, _, counts, _ in groups for count in counts]
    forms = [part.form for part in whose if part.form is not None]
    number = {id(form): row for row, form in enumerate(forms)}
    sizes = [sum(counts) for _, _, counts, _ in groups]
    return {
        "size": world.size,
        "fine": world.fine,
        "center": world.center,
        "shapes": [plugin for plugin, _, _, _ in groups],
        "first": np.cumsum([0, *sizes])[:-1],
        "owner": np.repeat(np.array([part.owner for part in whose], int), lengths),
        "kind": np.repeat(np.array([kind for _, _, _, kind in groups], int), sizes),
        "form": np.repeat(np.array([number.get(id(part.form), -1) for part in whose], int), lengths),
        "forms": np.array([form.packed() for form in forms]).reshape(-1, 38),
    }


def shifted(part: Part, by: Array) -> Part:
    """The part elsewhere; its form stays where it was."""
    if part.mesh is not None:
        return replace(part, mesh=replace(part.mesh, vertices=part.mesh.vertices + by))
    assert part.to_world is not None
    to_world = part.to_world.copy()
    to_world[:3, 3] += by
    return replace(part, to_world=to_world)


def _joined(parts: list[Part]) -> Plugin:
    meshes = [part.mesh for part in parts if part.mesh is not None]
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    pictured = any(mesh.uv is not None for mesh in meshes)
    return {
        "type": "mesh",
        "vertices": np.concatenate([mesh.vertices for mesh in meshes]),
        "normals": np.concatenate([mesh.normals for mesh in meshes]),
        **({"texcoords": np.concatenate(list(map(_texcoords, meshes)))} if pictured else {}),
        "faces": np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]),
        **({"attributes": _attributes(meshes)} if any(mesh.colors is not None for mesh in meshes) else {}),
    }


def _attributes(meshes: list[Any]) -> dict[str, Array]:
    """Colours of vertices and of faces, 0 where the others are meant: their sum is what is shown."""
    found: dict[str, list[Array]] = {"vertex_color": [], "face_color": []}
    for mesh in meshes:
        for name, count in (("vertex_color", len(mesh.vertices)), ("face_color", len(mesh.faces))):
            given = mesh.colors is not None and len(mesh.colors) == count
            found[name].append(mesh.colors if given else np.zeros((count, 3)))
    return {name: np.concatenate(parts) for name, parts in found.items()}


def _texcoords(mesh: Any) -> Array:
    return np.zeros((len(mesh.vertices), 2)) if mesh.uv is None else np.asarray(mesh.uv)
