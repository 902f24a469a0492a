"""A mesh file as a scene: as its author means it to look, with a camera and a light where there is none."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np

from clrt.base import notices
from clrt.base.errors import SceneError, fault, located, show
from clrt.base.limits import Limits
from clrt.base.places import At, listed
from clrt.base.records import table_of
from clrt.base.suggest import did_you_mean
from clrt.meshfiles.facets import Facets, shown
from clrt.meshfiles.look import Look, Names
from clrt.meshfiles.model import Piece, read_model
from clrt.scene.mesh import mesh_of_file
from clrt.scene.scene import Camera, Material, Mesh, PointLight, Scene, read_scene

_TOWARDS_CAMERA = np.array([0.5, 0.4, 1.0])
_TOWARDS_LIGHT = np.array([-0.3, 1.0, 0.9])
_PLAIN: Final = Material(diffuse=0.8, specular=0.2)  # of what has no material
_AMBIENT, _BACKGROUND = 0.2, 0.05


def load(path: Path, limits: Limits, smooth: bool | None = None, camera: str | None = None) -> Scene:
    """What is in an .obj, .ply, .glb, .gltf or .stl file; y is up.

    The file's own materials, lights and camera are kept (`camera`: the one of this name, not the first). What
    it lacks is added: a camera that has all in view from the front, the right and above, one light, a matte
    material. `smooth` True interpolates vertex normals, False shades flat, None does as the file says.
    """
    at = At(path.name)
    model = read_model(path, at, limits, smooth)
    if model is None:
        return _of_mesh(path, limits, smooth, camera)
    look = model.look
    # read and checked already: a scene takes them as they are
    resolved = path.resolve()  # as a scene notes it
    materials, made_of = _materials(look, model.pieces, path)
    shapes = [
        mesh_of_file(
            resolved,
            piece.arrays,
            at,
            file=path.name,
            part=piece.number,
            name=piece.name,
            smooth=smooth,
            material=material,
        )
        for piece, material in zip(model.pieces, made_of, strict=True)
    ]
    center, radius = _middle(model.low, model.high, path)
    light = _AMBIENT if not look.lights else _BACKGROUND
    passing = any("transmission" in table for table in look.materials.values())
    tables: dict[str, Any] = {
        "camera": _own_camera(look, camera, path) or _camera(center, radius),
        "materials": materials,
        "lights": look.lights or [_light(center, radius)],
        "ambient": light,
        "background": _BACKGROUND,
        "shadow": "tinted" if passing else "opaque",
        "shapes": shapes,
    }
    with notices.without("diffuse + max("):  # of coefficients that nobody stated here
        scene = read_scene(tables, folder=path.parent, source=path.name, limits=limits)
    _tell(path, look, camera)
    return scene


def _materials(look: Look, pieces: Sequence[Piece], path: Path) -> tuple[dict[str, Any], list[Any]]:
    """The materials by name, and what each piece has: a name, or a material of its own where it has no name.

    Times the colours of vertices a material is another one. Its first form has the author's name: the plain
    one, where some piece has that. The others have a number behind it.
    """
    names = Names()
    tables = {names.new(name): table for name, table in look.materials.items()}
    taken = {look.called.get(piece.used) for piece in pieces if not _colored(piece)}
    called: dict[tuple[Any, ...], str] = {}
    found: list[Any] = []
    for piece in pieces:
        name = look.called.get(piece.used)
        key = name, piece.color, piece.colors
        if name is None:
            found.append(_painted(table_of(_PLAIN), None, piece, path) if _colored(piece) else _PLAIN)
        elif not _colored(piece):
            found.append(name)
        else:
            if key not in called:
                called[key] = names.new(name) if name in taken else name
                taken.add(name)
                tables[called[key]] = _painted(look.materials[name], look.facets.get(name), piece, path)
            found.append(called[key])
    return tables, found


def _colored(piece: Piece) -> bool:
    """Whether its vertices have colours."""
    return piece.color is not None or piece.colors is not None


def _painted(table: dict[str, Any], facets: Facets | None, piece: Piece, path: Path) -> dict[str, Any]:
    """A material times the colours of a piece's vertices; `facets` is what it was made of, if of those."""
    key = "emission" if table.get("color") == 0.0 else "color"  # of what is unlit
    if key == "emission" and key not in table:  # nothing of it is there
        return table
    value = table.get(key, 1.0)
    if piece.colors is not None:
        image = {"type": "image", "file": path.name, "part": piece.colors, "wrap": "clamp"}
        if facets is not None:
            return replace(facets, picture=image).table()
        return table | {key: shown(image, _rgb(value))}
    assert piece.color is not None
    if facets is not None:
        return facets.painted(piece.color).table()
    if isinstance(value, dict):
        return table | {key: shown(value, piece.color)}
    return table | {key: [part * by for part, by in zip(_rgb(value), piece.color, strict=True)]}


def _rgb(color: Any) -> tuple[float, float, float]:
    red, green, blue = [color] * 3 if isinstance(color, float) else color
    return red, green, blue


def _own_camera(look: Look, name: str | None, path: Path) -> dict[str, Any] | None:
    """The file's camera of that name, or its first; None where it has none."""
    if name is None:
        return next(iter(look.cameras.values()), None)
    if name not in look.cameras:
        known = f"its cameras are {listed(look.cameras)}{did_you_mean(name, look.cameras)}"
        text = known if look.cameras else "it has no camera"
        raise SceneError(fault(path.name, "camera", name, text))
    return look.cameras[name]


def _tell(path: Path, look: Look, camera: str | None) -> None:
    """One warning of all that has no counterpart."""
    said = list(look.left_out)
    if camera is None and len(look.cameras) > 1:
        others = map(show, [*look.cameras][1:])
        said.append(f"the cameras {listed(others, 5)}")
    if said:
        notices.warn(path.name, "", f"left out, since there is no counterpart: {listed(said)}")


def _of_mesh(path: Path, limits: Limits, smooth: bool | None, camera: str | None) -> Scene:
    """The mesh of a file that says nothing of how it looks."""
    if camera is not None:
        raise SceneError(fault(path.name, "camera", camera, "it has no camera"))
    mesh = Mesh(file=path.name, smooth=smooth, material=_PLAIN)
    scene = Scene(
        folder=path.parent,
        source=path.name,
        limits=limits,
        ambient=_AMBIENT,
        background=_BACKGROUND,
        shapes=(mesh,),
    )
    read = scene.shapes[0]
    assert isinstance(read, Mesh)
    vertices = read.data().vertices
    center, radius = _middle(vertices.min(axis=0), vertices.max(axis=0), path)
    return msgspec.structs.replace(scene, camera=_camera(center, radius), lights=(_light(center, radius),))


def _middle(low: np.ndarray, high: np.ndarray, path: Path) -> tuple[np.ndarray, float]:
    center, radius = (low + high) / 2, float(np.linalg.norm(high - low)) / 2
    if not radius > 0:
        raise SceneError(located(path.name, "", "all its vertices are at one point"))
    return center, radius


def _camera(center: np.ndarray, radius: float) -> Camera:
    """One that has a ball in view."""
    camera = Camera(origin=(0.0, 0.0, 1.0), target=(0.0, 0.0, 0.0))
    half = math.atan(math.tan(math.radians(camera.fov / 2)) * camera.height / camera.width)
    origin = center + _TOWARDS_CAMERA / np.linalg.norm(_TOWARDS_CAMERA) * 1.02 * radius / math.sin(half)
    return msgspec.structs.replace(camera, origin=_vector(origin), target=_vector(center))


def _light(center: np.ndarray, radius: float) -> PointLight:
    light = center + _TOWARDS_LIGHT / np.linalg.norm(_TOWARDS_LIGHT) * 6 * radius
    return PointLight(position=_vector(light))


def _vector(point: np.ndarray) -> tuple[float, float, float]:
    x, y, z = point.tolist()
    return x, y, z
