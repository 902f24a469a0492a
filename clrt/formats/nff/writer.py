"""A scene in Eric Haines' Neutral File Format, as `reader` reads it back; what that cannot say is refused."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, Final

from clrt.base.atomic import write_text
from clrt.base.errors import show
from clrt.base.places import At
from clrt.meshfiles.planar import clear_turn, same_turn
from clrt.scene.scene import Camera, Material, Mesh, PointLight, Scene, rgb

_SAID: Final = ("background", "camera", "lights", "materials", "shapes", "version")  # in lines of their own
_COEFFICIENTS: Final = ("ambient", "reflection", "transmission")  # compared as the numbers that hold
_HITHER: Final = 1e-4  # of the way to the target: nothing is to lie before it


def write_nff(scene: Scene, path: str | os.PathLike[str]) -> None:
    """Write the text to `path`, whole or not at all. ClrtError where it cannot be written or expressed."""
    write_text(path, to_nff(scene))


def to_nff(scene: Scene) -> str:
    """The scene as text. SceneError says what NFF has no words for; names are left out."""
    at, count = At(scene.source), len(scene.lights)
    level = math.sqrt(count) / (2 * count) if count else 0.0
    other = Scene(max_depth=4, ambient=level)
    _compare(scene, other, [name for name in other.to_dict() | scene.to_dict() if name not in _SAID], at)
    lines = [f"b {_color(scene.background, at.key('background'))}", *_view(scene.camera, at.key("camera"))]
    for number, light in enumerate(scene.lights):
        lines.append(_light(light, at.key("lights").item(number)))
    fill = ""
    for number, shape in enumerate(scene.shapes):
        place = at.key("shapes").item(number)
        before, fill = fill, _fill(scene.material_of(shape), place.key("material"))
        lines += [fill] * (fill != before)
        lines += _shape(shape, place)
    return "\n".join(lines) + "\n"


def _compare(one: Any, other: Any, names: Iterable[str], at: At) -> None:
    """SceneError for the first value that is not the one that readers of NFF take."""
    for name in names:
        mine, theirs = getattr(one, name), getattr(other, name)
        if mine != theirs:
            raise at.key(name).says(f"NFF has no words for {show(mine)}; readers take {show(theirs)}")


def _view(camera: Camera | None, at: At) -> list[str]:
    """The angle spans the rows' centres, top to bottom; ours spans their outer edges."""
    if camera is None:
        raise at.says("missing; an NFF file has a view")
    if camera.has_pose or camera.has_k:
        raise at.says("NFF has no words for pose and K; give origin, target and fov")
    plain, said = Camera(), ("origin", "target", "up", "fov", "fov_axis", "width", "height", "pose", "K")
    _compare(camera, plain, [name for name in camera.__struct_fields__ if name not in said], at)
    tangent = camera.half_extents(camera.width, camera.height)[1]
    angle = 2 * math.degrees(math.atan(tangent * max(camera.height - 1, 1) / camera.height))
    assert camera.up is not None  # a scene's camera has one
    hither = _HITHER * math.dist(camera.origin, camera.target)
    return ["v", f"from {_numbers(camera.origin)}", f"at {_numbers(camera.target)}",
            f"up {_numbers(camera.up)}", f"angle {angle!r}", f"hither {hither!r}",
            f"resolution {camera.width} {camera.height}"]  # fmt: skip


def _light(light: Any, at: At) -> str:
    if not isinstance(light, PointLight):
        raise at.says(f"NFF has no {light.type} light")
    _compare(light, PointLight(position=light.position), ["falloff"], at)
    return f"l {_numbers(light.position)} {_color(light.intensity, at.key('intensity'))}"


def _fill(m: Material, at: At) -> str:
    plain = Material(color=m.color, diffuse=m.diffuse, specular=m.specular, reflection=m.specular,
                     shininess=m.shininess, transmission=m.kt, ior=m.ior)  # fmt: skip
    names = [name for name in m.__struct_fields__ if name not in _COEFFICIENTS]
    _compare(m, plain, [*names, "ka", "kr"], at)
    color = _color(m.color, at.key("color"))
    return f"f {color} {_numbers((m.diffuse, m.specular, m.shininess, m.kt, m.ior_d))}"


def _shape(shape: Any, at: At) -> Iterator[str]:
    if getattr(shape, "transform", None) is not None:
        raise at.key("transform").says("NFF moves nothing; move the points themselves")
    if shape.type == "sphere":
        yield f"s {_numbers((*shape.center, shape.radius))}"
    elif shape.type in ("cylinder", "cone"):
        if shape.caps:
            raise at.key("caps").says("NFF's cones and cylinders are open")
        ends = (shape.radius, shape.radius) if shape.type == "cylinder" else (shape.r0, shape.r1)
        yield f"c {_numbers((*shape.p0, ends[0], *shape.p1, ends[1]))}"
    elif shape.type == "polygon":
        yield _polygon(shape.points)
    elif isinstance(shape, Mesh):
        data = shape.data()
        for face in data.faces:
            corners = data.vertices[face].tolist()
            if data.normals is None:
                yield _polygon(corners)
            else:
                pairs = zip(corners, data.normals[face].tolist(), strict=True)
                yield "\n".join([f"pp {len(face)}", *(_numbers((*p, *n)) for p, n in pairs)])
    else:
        raise at.says(f"NFF has no {shape.type}")


def _polygon(points: Sequence[Sequence[float]]) -> str:
    """From a corner on that turns as the whole outline does: it tells which side is the outer one."""
    every = [list(point) for point in points]
    if not same_turn(every):
        start = clear_turn(every)
        every = every[start:] + every[:start]
    return "\n".join([f"p {len(every)}", *map(_numbers, every)])


def _color(color: Any, at: At) -> str:
    if not isinstance(color, (int, float, tuple)):
        raise at.says("NFF has red, green and blue only")
    return _numbers(rgb(color))


def _numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)
