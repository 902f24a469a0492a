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
MANY_SPHERES = 256  # from here on one `ellipsoids` plugin is faster than so many spheres
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
    x, y, z = (to_world[:3, k] for k in range(3))
    lengths = np.linalg.norm(to_world[:3, :3], axis=0)
    sheared = max(abs(x @ y), abs(y @ z), abs(z @ x)) > 1e-9 * lengths.max() ** 2
    origin = to_world[:3, 3]
    if part.kind == "sphere" and not sheared and np.ptp(lengths) <= 1e-9 * lengths.max():
        return {"type": "sphere", "center": origin.tolist(), "radius": float(lengths[0]), **flip, **inner}
    if part.kind == "cylinder" and not sheared and abs(lengths[0] - lengths[1]) <= 1e-9 * lengths[0]:
        ends = {"p0": origin.tolist(), "p1": (origin + z).tolist(), "radius": float(lengths[0])}
        return {"type": "cylinder", **ends, **flip, **inner}
    # Mitsuba's sphere and cylinder are wrong under other matrices; an instance of the unit one is right
    unit: Plugin = {"type": part.kind, **flip, **inner}
    return {"type": "instance", "to_world": to_world, "group": {"type": "shapegroup", "unit": unit}}


def scene(children: dict[str, Plugin]) -> Plugin:
    """A scene of plugins. What an instance repeats must stand beside it: it is moved there."""
    found: Plugin = {"type": "scene"}
    for name, child in children.items():
        if child.get("type") == "instance" and "group" in child:
            found[f"{name}_group"] = child["group"]
            child = {**child, "group": {"type": "ref", "id": f"{name}_group"}}
        found[name] = child
    return found


def packed(world: Geometry) -> dict[str, Any]:
    """All parts in as few plugins as may be, and what each of their primitives is.

    `shapes`: the plugins; `first` (shapes,): a plugin's first row in `owner` (the scene's shape), `form` (row
    in `forms`, or -1) and `kind` (NATIVE; FLAT: the mesh's normals are the surface's; SMOOTH: they are for
    shading); `size`, `center`: the scene's. Shapes are moved so that this centre is at 0, where float32 is
    finest.
    """
    parts = [shifted(part, -world.center) for part in world.parts]
    natives = [part for part in parts if part.mesh is None]
    spheres = [part for part in natives if part.kind == "sphere" and not part.flip]
    crowd = spheres if len(spheres) >= MANY_SPHERES else []
    alone = [part for part in natives if not (crowd and part in crowd)] if crowd else natives
    flat = [part for part in parts if part.mesh is not None and part.form is None and not part.smooth]
    smooth = [part for part in parts if part.mesh is not None and part.smooth]
    curved = [part for part in parts if part.mesh is not None and part.form is not None]

    shapes: list[Plugin] = [shape(part) for part in alone]
    rows = [_rows([part], [1], NATIVE) for part in alone]
    if crowd:
        shapes.append(_ellipsoids(crowd))
        rows.append(_rows(crowd, [1] * len(crowd), NATIVE))
    for group, kind in ((flat, FLAT), (smooth, SMOOTH), (curved, FLAT)):
        counts = [len(part.mesh.faces) for part in group if part.mesh is not None]
        if sum(counts):
            shapes.append(_joined(group))
            rows.append(_rows(group, counts, kind))
    forms = [part.form for part in parts if part.form is not None]
    number = {id(form): row for row, form in enumerate(forms)}
    whose = [part for group in rows for part in group[3]]
    form = np.array([number[id(part.form)] if part.form is not None else -1 for part in whose], int)
    lengths = [length for group in rows for length in group[4]]
    return {
        "size": world.size,
        "center": world.center,
        "shapes": shapes,
        "first": np.cumsum([0, *(len(group[0]) for group in rows[:-1])]) if rows else np.zeros(0, int),
        "owner": _concatenated([group[0] for group in rows]),
        "kind": _concatenated([group[1] for group in rows]),
        "form": np.repeat(form, lengths),
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


def _rows(
    parts: list[Part], counts: list[int], kind: int
) -> tuple[Array, Array, None, list[Part], list[int]]:
    owner = np.repeat([part.owner for part in parts], counts)
    return owner, np.full(len(owner), kind), None, parts, counts


def _concatenated(arrays: list[Array]) -> Array:
    return np.concatenate(arrays) if arrays else np.zeros(0, int)


def _joined(parts: list[Part]) -> Plugin:
    meshes = [part.mesh for part in parts if part.mesh is not None]
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    return {
        "type": "mesh",
        "vertices": np.concatenate([mesh.vertices for mesh in meshes]),
        "normals": np.concatenate([mesh.normals for mesh in meshes]),
        "faces": np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]),
    }


def _ellipsoids(parts: list[Part]) -> Plugin:
    """Spheres under any matrices: the sphere's image is that under the matrix' rotation and singular
    values."""
    matrices = np.array([part.to_world for part in parts])
    rotation, scale, _ = np.linalg.svd(matrices[:, :3, :3])
    rotation[np.linalg.det(rotation) < 0, :, 0] *= -1
    return {
        "type": "ellipsoids", "extent": 1.0, "centers": matrices[:, :3, 3], "scales": scale,
        "quaternions": np.array([quaternion(r) for r in rotation]),
    }  # fmt: skip


def quaternion(rotation: Array) -> Array:
    """The unit quaternion (x, y, z, w) of a rotation (3, 3): the eigenvector of Bar-Itzhack's matrix."""
    r = rotation
    k = np.array([
        [r[0, 0] - r[1, 1] - r[2, 2], r[1, 0] + r[0, 1], r[2, 0] + r[0, 2], r[2, 1] - r[1, 2]],
        [r[1, 0] + r[0, 1], r[1, 1] - r[0, 0] - r[2, 2], r[2, 1] + r[1, 2], r[0, 2] - r[2, 0]],
        [r[2, 0] + r[0, 2], r[2, 1] + r[1, 2], r[2, 2] - r[0, 0] - r[1, 1], r[1, 0] - r[0, 1]],
        [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], r[0, 0] + r[1, 1] + r[2, 2]],
    ])  # fmt: skip
    return np.asarray(np.linalg.eigh(k / 3)[1][:, -1])
