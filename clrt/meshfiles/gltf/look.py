"""Cameras, lights and materials of a glTF file, as tables of a scene file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Final, Literal

import numpy as np
from msgspec import Meta

from clrt.base.errors import show
from clrt.meshfiles.broken import BrokenMesh
from clrt.meshfiles.gltf.document import Document, Table, decode, item, unread
from clrt.meshfiles.gltf.materials import materials_of, spelt
from clrt.meshfiles.gltf.textures import Itself
from clrt.meshfiles.look import Look, Names, Used
from clrt.meshfiles.look import Table as SceneTable

_WIDTH, _HEIGHT = 640, 480  # pictures of cameras that say no aspect, and what those of others fit into
_MOST_ASPECT: Final = 64.0

Positive = Annotated[float, Meta(gt=0)]
NotNegative = Annotated[float, Meta(ge=0)]
Right = Annotated[float, Meta(ge=0, le=math.pi / 2 + 1e-6)]


class Perspective(Table, frozen=True, gc=False):
    yfov: Annotated[float, Meta(gt=0, lt=math.pi)]
    znear: NotNegative = 0.0
    aspectRatio: Positive | None = None


class Orthographic(Table, frozen=True, gc=False):
    xmag: float
    ymag: float
    znear: float = 0.0


class Camera(Table, frozen=True, gc=False):
    type: Literal["perspective", "orthographic"]
    perspective: Perspective | None = None
    orthographic: Orthographic | None = None
    name: str = ""


class Cone(Table, frozen=True, gc=False):
    innerConeAngle: Right = 0.0
    outerConeAngle: Right = math.pi / 4


class Light(Table, frozen=True, gc=False):
    type: Literal["point", "directional", "spot"]
    color: tuple[NotNegative, NotNegative, NotNegative] = (1.0, 1.0, 1.0)
    intensity: NotNegative = 1.0
    range: float | None = None  # 0 and less: none, as several exporters write it
    spot: Cone = Cone()


class Lights(Table, frozen=True, gc=False):
    lights: tuple[Light, ...] = ()


class Extensions(Table, frozen=True, gc=False):
    KHR_lights_punctual: Lights = Lights()


@dataclass(frozen=True, eq=False)
class Held:
    """A camera or a light that stands at a node: the node's number and name, whose it is, and where."""

    node: int
    name: str
    number: int
    matrix: np.ndarray

    def axis(self, column: int) -> np.ndarray:
        """An axis of the node in the world, of length 1; BrokenMesh where it has none."""
        axis = self.matrix[:3, column]
        length = float(np.linalg.norm(axis))
        if not 0 < length < math.inf:
            raise BrokenMesh(f"nodes[{self.node}] has a camera or a light, but no direction")
        return np.asarray(axis / length)


def look_of(
    document: Document,
    itself: Itself,
    materials: Used,
    cameras: Sequence[Held],
    lights: Sequence[Held],
    center: np.ndarray,
    radius: float,
) -> Look:
    """How the file's author means it to look; `materials` are those that are used: whether with uv."""
    look = materials_of(document, itself, materials)
    left_out = look.left_out
    known_cameras: tuple[Camera, ...] = ()
    known_lights: tuple[Light, ...] = ()
    if cameras:
        known_cameras = decode(document.cameras, tuple[Camera, ...], "cameras")
    if lights:
        known_lights = decode(document.extensions, Extensions, "lights").KHR_lights_punctual.lights
    names = Names()
    views: dict[str, SceneTable] = {}
    for held in reversed(cameras):  # the walk takes the last first
        camera = item(known_cameras, held.number, "cameras")
        reach = float((center - held.matrix[:3, 3]) @ -held.axis(2))
        name = names.new(held.name or camera.name or f"camera {len(views)}")
        views[name] = _camera(camera, held, reach if reach > 0 else radius)
    found = [(item(known_lights, held.number, "lights"), held) for held in reversed(lights)]
    if any((light.range or 0.0) > 0 for light, _ in found):
        left_out["the range of lights"] = None
    for extension in unread(document):
        if spelt(extension) not in left_out:  # of a material it is named already
            left_out[f"the extension {show(extension[:60])}"] = None
    placed = [_light(light, held, radius) for light, held in found]
    return replace(look, cameras=views, lights=placed)


def _camera(camera: Camera, held: Held, distance: float) -> SceneTable:
    """A camera that looks along -z of its node, at what is `distance` away; y is up."""
    origin, gaze, up = held.matrix[:3, 3], -held.axis(2), held.axis(1)
    if camera.type == "perspective":
        if camera.perspective is None:
            raise BrokenMesh(f"cameras[{held.number}] is of type perspective, but says nothing of that")
        lens, aspect = camera.perspective, camera.perspective.aspectRatio or _WIDTH / _HEIGHT
        view: SceneTable = {"fov": math.degrees(lens.yfov), "fov_axis": "vertical", "near": lens.znear}
    else:
        if camera.orthographic is None:
            raise BrokenMesh(f"cameras[{held.number}] is of type orthographic, but says nothing of that")
        width, height = abs(camera.orthographic.xmag), abs(camera.orthographic.ymag)
        if not (width > 0 and height > 0):
            raise BrokenMesh(f"cameras[{held.number}] has a view of no size")
        aspect = width / height
        view = {"type": "orthographic", "size": 2 * width, "near": max(camera.orthographic.znear, 0.0)}
    if np.linalg.det(held.matrix[:3, :3]) < 0:
        view["mirror"] = True
    columns, rows = _pixels(aspect)
    return {
        "origin": origin.tolist(),
        "target": (origin + gaze * distance).tolist(),
        "up": up.tolist(),
        "width": columns,
        "height": rows,
        **view,
    }


def _pixels(aspect: float) -> tuple[int, int]:
    """The largest picture of this aspect that fits into the usual one."""
    aspect = min(max(aspect, 1 / _MOST_ASPECT), _MOST_ASPECT)
    if aspect >= _WIDTH / _HEIGHT:
        return _WIDTH, round(_WIDTH / aspect)
    return round(_HEIGHT * aspect), _HEIGHT


def _light(light: Light, held: Held, radius: float) -> SceneTable:
    """A light; those that have a direction shine along -z of their node."""
    intensity = [part * light.intensity / math.pi for part in light.color]
    table: SceneTable = {"type": light.type, "intensity": intensity}
    if light.type == "directional":
        return table | {"direction": (-held.axis(2)).tolist()}
    position = held.matrix[:3, 3]
    table |= {"position": position.tolist(), "falloff": "inverse-square"}
    if light.type == "point":
        return table
    inner, outer = light.spot.innerConeAngle, light.spot.outerConeAngle
    if not 0 < outer >= inner:
        raise BrokenMesh(f"the cone of lights[{held.number}] ends where it begins")
    return table | {
        "target": (position - held.axis(2) * max(radius, 1.0)).tolist(),
        "angle": min(math.degrees(outer), 90.0),
        "penumbra": 1.0 - inner / outer,
    }
