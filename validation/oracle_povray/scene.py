"""A scene in POV-Ray's language, and why one cannot be written in it.

Written for POV-Ray 3.7 from its reference manual. What the model and POV-Ray understand alike: primitives,
Phong's model, mirrors and clear bodies of constant shares. Its Fresnel terms, patterns and media are others.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable
from typing import Any, Final

import msgspec
import numpy as np

from clrt.base.atomic import write_text
from clrt.base.errors import ClrtError, located
from clrt.scene.scene import (
    Camera,
    Checker,
    DirectionalLight,
    Material,
    Mesh,
    PointLight,
    Quadric,
    Scene,
)

from ..oracle64.camera import basis

_FAR: Final = 1e5  # where a directional light stands
_DEEPEST: Final = 255  # its max_trace_level is 256 at most
_ENDS: Final = 1e7  # units from the camera on which it sees nothing
_USUAL: Final = (0.1, 1e3)  # reaches of scenes that are written as they are: it drops hits nearer than 1e-3
_LENGTHS: Final = ("origin", "target", "position", "center", "radius", "radii", "min", "max", "p0", "p1",
                   "r0", "r1", "point", "points")  # fmt: skip
"""Fields of cameras, lights and shapes that are places and lengths."""
_FADE: Final = 1e-3  # POV-Ray fades by 2 / (1 + (r / d)^2), which is 2 d^2 / r^2 where r is far above d


def not_in_pov(scene: Scene) -> str | None:
    """Why a scene cannot be expressed; None where it can."""
    camera = scene.camera
    if camera is None:
        return "the scene has no camera"
    tests = {
        "light in bands": scene.spectrum is not None, "background image": isinstance(scene.background, str),
        "ambient rays": scene.ambient_samples > 0, "depth colour": scene.depth_color != 0,
        "least weight": scene.min_weight > 0, "one-sided surfaces": scene.one_sided != "none",
        "ray counts by rule": scene.conformance != "none", "more than one sample": camera.spp != 1,
        "jitter": camera.jitter is not None, "lens": camera.aperture > 0, "filter": camera.filter != "box",
        "near plane": camera.near > 0 and camera.type == "perspective",
        "so many generations": scene.max_depth > _DEEPEST,
        "adaptive samples": scene.adaptive is not None,
        "colours by name or spectrum": not _plain((scene.ambient, scene.background)),
    }  # fmt: skip
    found = next((what for what, holds in tests.items() if holds), None)
    if found:
        return f"POV-Ray has no {found} as the model has them"
    for number, light in enumerate(scene.lights):
        if not isinstance(light, (PointLight, DirectionalLight)):
            return f"lights[{number}]: POV-Ray has no {light.type} light as the model has it"
        if not _plain((light.intensity,)):
            return f"lights[{number}].intensity: only red, green and blue are written"
    bodies = 0
    for number, shape in enumerate(scene.shapes):
        material = scene.material_of(shape)
        reason = _no_shape(shape) or _no_material(material)
        if not reason and material.kt > 0 and shape.type in _CUT and shape.is_open:
            reason = "open ends of what light passes, as the model has them"
        if reason:
            return f"shapes[{number}]: POV-Ray has no {reason}"
        bodies += material.is_medium
        if bodies and scene.medium_ior != 1:
            return "POV-Ray has no medium around all"
        if scene.max_depth > 1 and _total(scene, shape, material):
            why = "let reflection + transmission be 1, both white"
            return f"shapes[{number}]: POV-Ray has no total reflection of less than all: {why}"
    return None


def too_far(scene: Scene) -> str | None:
    """Why POV-Ray's picture lacks what is far away: the last pixels of an endless plane, or anything."""
    camera = scene.camera
    assert camera is not None
    endless = any(shape.type == "plane" for shape in scene.shapes)
    rows = max(camera.width, camera.height) if endless else 1
    reach = rows * _reach(scene) * _scale(scene)
    return None if reach < _ENDS else f"POV-Ray sees no farther than {_ENDS:g} units"


def _reach(scene: Scene) -> float:
    """The largest coordinate or length, about."""
    most = 0.0
    for one in (scene.camera, *scene.lights, *scene.shapes):
        found = [getattr(one, name, 0.0) for name in _LENGTHS]
        found += [one.data().vertices] if isinstance(one, Mesh) else []
        found += [one.clip] if isinstance(one, Quadric) and one.clip is not None else []
        reach = max(float(np.abs(np.asarray(value, float)).max()) for value in found)
        matrix = np.asarray(getattr(one, "matrix", np.eye(4)), float)
        moved = float(np.abs(matrix[:3, 3]).max())
        most = max(most, reach * float(np.linalg.norm(matrix[:3, :3], 2)) + moved)
    return most


def _scale(scene: Scene) -> float:
    """By how much all is scaled, so that it is neither too small nor too large for POV-Ray: a power of 10."""
    reach = _reach(scene)
    return 1.0 if reach == 0 or _USUAL[0] <= reach <= _USUAL[1] else 10.0 ** round(1 - math.log10(reach))


def _scaled(one: Any, by: float) -> Any:
    """A light or a shape that many times as large, and as far off."""
    stated = {name: getattr(one, name, None) for name in _LENGTHS}
    changes: dict[str, Any] = {name: _times(of, by) for name, of in stated.items() if of is not None}
    if isinstance(one, PointLight) and one.falloff == "inverse-square":
        changes["intensity"] = _times(one.intensity, by**2)
    elif isinstance(one, (Mesh, Quadric)) or getattr(one, "transform", None) is not None:
        matrix = np.array(one.matrix, float)
        matrix[:3] *= by if isinstance(one, (Mesh, Quadric)) else [1.0, 1.0, 1.0, by]
        changes["transform"] = matrix.tolist()
    return msgspec.structs.replace(one, **changes)


def _times(value: Any, by: float) -> Any:
    return (np.asarray(value, float) * by).tolist()


def _plain(values: Iterable[Any]) -> bool:
    return all(isinstance(value, (int, float, tuple)) for value in values)


def _no_shape(shape: Any) -> str:
    if shape.type not in _SHAPES:
        return f"{shape.type}"
    if shape.type == "mesh":
        data = shape.data()
        if any(len(face) != 3 for face in data.faces):
            return "faces of more than three corners"
        if shape.smooth and data.normals is None:
            return "normals of its own making as the model has them"
    return ""


def _no_material(m: Material) -> str:
    colours = (m.emission, m.highlight_color, m.reflection_color, m.transmission_color, m.absorption)
    if m.pictures:
        return "pictures on surfaces"
    if isinstance(m.color, Checker):
        return "checker as the model has it"
    if not _plain((m.color, *colours)) or m.conductor is not None or not isinstance(m.ior_d, float):
        return "spectra"
    if m.alpha > 0:
        return "rough mirrors"
    if m.fresnel:
        return "Fresnel terms as the model has them"
    if m.kt > 0 and (m.priority or np.any(np.asarray(m.absorption) != 0)):
        return "media as the model has them"
    if m.kt > 0 and (m.thin or m.ior_d == 1):
        return "bodies that light goes straight through: it does not count these as a generation"
    if m.specular > 0 and np.ptp(_rgb(m.highlight_color)) > 0:
        return "colour of a highlight of its own"
    local = m.diffuse > 0 or m.ka > 0 or np.any(_rgb(m.emission) > 0)
    if m.kt > 0 and local and (np.ptp(_rgb(m.transmission_color)) > 0 or _clear(m) >= 1):
        return "tint of what passes apart from the surface's colour"
    if np.any((_rgb(m.emission) > 0) & (_rgb(m.color) == 0)):
        return "emission of a colour that the surface does not reflect"
    return ""


def _total(scene: Scene, shape: Any, m: Material) -> bool:
    """Whether rays may be reflected totally with another weight than 1, which is POV-Ray's.

    What enters a ball leaves it, too, unless something else turns it there, or it is seen from within.
    """
    shares = m.kr * _rgb(m.reflection_color) + m.kt * _rgb(m.transmission_color)
    if m.kt == 0 or np.allclose(shares, 1, rtol=0, atol=1e-9):
        return False
    camera = scene.camera
    assert camera is not None
    others = [other for other in scene.shapes if other is not shape]
    return not (
        _is_ball(shape)
        and m.ior_d > 1
        and camera.type == "perspective"
        and math.dist(camera.origin, shape.center) > shape.radius
        and not any(_may_turn(scene.material_of(other)) and not _apart(shape, other) for other in others)
    )


def _may_turn(m: Material) -> bool:
    return m.kr > 0 or m.kt > 0


def _is_ball(shape: Any) -> bool:
    return shape.type == "sphere" and shape.transform is None


def _apart(ball: Any, other: Any) -> bool:
    """Whether two balls have no point in common; of other shapes it is not asked."""
    return _is_ball(other) and math.dist(ball.center, other.center) > ball.radius + other.radius


def to_pov(scene: Scene) -> str:
    """The scene as text. ClrtError says what it has no words for."""
    reason = not_in_pov(scene)
    if reason:
        raise ClrtError(located(scene.source, "", reason))
    assert scene.camera is not None
    by = _scale(scene)
    lights = scene.lights if by == 1 else [_scaled(light, by) for light in scene.lights]
    lines = [
        "#version 3.7;",
        f"global_settings {{ assumed_gamma 1 max_trace_level {scene.max_depth + 1} adc_bailout 0 "
        f"ambient_light rgb {_vector(_rgb(scene.ambient))} }}",
        f"background {{ color rgb {_vector(_rgb(scene.background))} }}",
        *_camera(scene.camera, by),
        *(_light(light) for light in lights),
    ]
    for shape in scene.shapes:
        material = scene.material_of(shape)
        if by != 1:
            shape = _scaled(shape, by)
        form, closed = _SHAPES[shape.type](shape)
        stays = shape.type == "mesh" or getattr(shape, "transform", None) is None
        moved = "" if stays else _matrix(shape.matrix)
        texture, interior = _texture(material), ""
        if material.kt > 0:
            interior = f" interior {{ ior {float(material.ior_d)!r} }}"
        blocks = material.kt > 0 and scene.shadow == "opaque"
        lines.append(f"{form} {texture}{interior} {moved}{' no_shadow' if blocks else ''} {closed}")
        if blocks:  # a twin that nobody sees casts the shadow
            dark = "texture { pigment { color rgb 0 } } no_image no_reflection no_radiosity"
            lines.append(f"{form} {dark} {moved} {closed}")
    return "\n".join(lines) + "\n"


def write_pov(scene: Scene, path: str | os.PathLike[str]) -> None:
    """Write the text to `path`, whole or not at all. ClrtError where it cannot be written or expressed."""
    write_text(path, to_pov(scene))


def _camera(camera: Camera, by: float) -> list[str]:
    """The camera of a scene that is `by` times as large."""
    forward, right, up = basis(camera)
    width, height = camera.width, camera.height
    orthographic = camera.type == "orthographic"
    half = by * camera.size / 2 if orthographic else np.tan(np.radians(camera.fov) / 2)
    across = half if camera.fov_axis == "horizontal" else half * width / height
    down = across * height / width
    shift = np.array(camera.shift, float)
    if camera.has_k:
        (fx, _, cx), (_, fy, cy), _ = camera.K  # type: ignore[misc]
        across, down = width / (2 * fx), height / (2 * fy)
        shift += width / 2 - cx, height / 2 - cy
    moved = 2 * shift[0] / width * across * right - 2 * shift[1] / height * down * up
    origin = by * np.asarray(camera.origin, float)
    if orthographic:
        origin, direction = origin + moved + by * camera.near * forward, forward
    else:
        direction = forward + moved
    return [
        f"camera {{ {'orthographic' if orthographic else 'perspective'} location {_vector(origin)}",
        f"  direction {_vector(direction)}",
        f"  right {_vector(2 * across * right)} up {_vector(2 * down * up)} }}",
    ]


def _light(light: Any) -> str:
    color = _rgb(light.intensity)
    if not isinstance(light, PointLight):
        way = np.asarray(light.direction, float)
        way = way / np.linalg.norm(way)
        place = f"{_vector(-_FAR * way)} color rgb {_vector(color)} parallel point_at <0, 0, 0>"
        return f"light_source {{ {place} }}"
    fade = ""
    if light.falloff == "inverse-square":
        color, fade = color / (2 * _FADE**2), f" fade_distance {_FADE!r} fade_power 2"
    return f"light_source {{ {_vector(light.position)} color rgb {_vector(color)}{fade} }}"


def _clear(m: Material) -> float:
    """The share that passes, which POV-Ray takes from the surface's own light."""
    return float(m.kt * _rgb(m.transmission_color)[0])


def _texture(m: Material) -> str:
    color, tint = _rgb(m.color), _rgb(m.transmission_color)
    local = m.diffuse > 0 or m.ka > 0 or bool(np.any(_rgb(m.emission) > 0))
    if m.kt > 0 and not local:
        pigment, rest = f"rgbf <{_numbers(tint)}, {float(m.kt)!r}>", 1.0
    else:
        clear = _clear(m) if m.kt > 0 else 0.0
        pigment, rest = f"rgbt <{_numbers(color)}, {clear!r}>", 1.0 - clear
    emission = np.divide(_rgb(m.emission), color, out=np.zeros(3), where=color > 0) / rest
    highlight = m.specular * _rgb(m.highlight_color)[0]
    finish = [
        f"ambient {m.ka / rest!r}", f"emission rgb {_vector(emission)}", f"diffuse {m.diffuse / rest!r}",
        "brilliance 1", "specular 0", f"phong {float(highlight)!r} phong_size {float(m.shininess)!r}",
        f"reflection {{ rgb {_vector(m.kr * _rgb(m.reflection_color))} }}",
    ]  # fmt: skip
    return f"texture {{ pigment {{ color {pigment} }} finish {{ {' '.join(finish)} }} }}"


def _rgb(value: Any) -> np.ndarray:
    return np.array(np.broadcast_to(np.asarray(value, float), 3))


def _numbers(values: Any) -> str:
    return ", ".join(repr(float(value)) for value in values)


def _vector(values: Any) -> str:
    return f"<{_numbers(values)}>"


def _matrix(matrix: np.ndarray) -> str:
    """POV-Ray's vectors are rows: its matrix is ours on its side, without the last column."""
    return f"matrix <{_numbers(np.asarray(matrix, float)[:3].T.ravel())}>"


def _polygon(shape: Any) -> tuple[str, str]:
    points = [*shape.points, shape.points[0]]
    return f"polygon {{ {len(points)}, {', '.join(map(_vector, points))}", "}"


def _mesh(shape: Any) -> tuple[str, str]:
    """Moved here: the normals that are blended are those of the moved mesh."""
    data, matrix = shape.data(), np.asarray(shape.matrix, float)
    corners, normals = np.asarray(data.vertices, float) @ matrix[:3, :3].T + matrix[:3, 3], data.normals
    if normals is not None:
        normals = np.asarray(normals, float) @ np.linalg.inv(matrix[:3, :3])
        normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    faces = []
    for face in data.faces:
        if normals is None:
            faces.append(f"triangle {{ {', '.join(_vector(corners[i]) for i in face)} }}")
        else:
            pairs = (f"{_vector(corners[i])}, {_vector(normals[i])}" for i in face)
            faces.append(f"smooth_triangle {{ {', '.join(pairs)} }}")
    return "mesh { " + "\n  ".join(faces), "}"


def _quadric(shape: Any) -> tuple[str, str]:
    a, b, c, d, e, f, g, h, i, j = (float(value) for value in shape.coefficients)
    groups = ((a, b, c), (2 * d, 2 * f, 2 * e), (2 * g, 2 * h, 2 * i))
    form = f"quadric {{ {', '.join(map(_vector, groups))}, {j!r}"
    if shape.clip is not None:
        low, high = shape.clip
        form += f" clipped_by {{ box {{ {_vector(low)}, {_vector(high)} }} }}"
    return form, "}"


def _plane(shape: Any) -> tuple[str, str]:
    normal = np.asarray(shape.normal, float)
    normal = normal / np.linalg.norm(normal)
    return f"plane {{ {_vector(normal)}, {float(normal @ np.asarray(shape.point, float))!r}", "}"


def _open(shape: Any) -> str:
    return "" if shape.caps else " open"


_CUT: Final = ("cylinder", "cone", "quadric")  # which may have open ends
_SHAPES: Final[dict[str, Callable[[Any], tuple[str, str]]]] = {
    "sphere": lambda s: (f"sphere {{ {_vector(s.center)}, {float(s.radius)!r}", "}"),
    "plane": _plane,
    "box": lambda s: (f"box {{ {_vector(s.min)}, {_vector(s.max)}", "}"),
    "disk": lambda s: (f"disc {{ {_vector(s.center)}, {_vector(s.normal)}, {float(s.radius)!r}", "}"),
    "ellipsoid": lambda s: (
        f"sphere {{ 0, 1 scale {_vector(s.radii)} translate {_vector(s.center)}", "}"),
    "cylinder": lambda s: (
        f"cylinder {{ {_vector(s.p0)}, {_vector(s.p1)}, {float(s.radius)!r}{_open(s)}", "}"),
    "cone": lambda s: (
        f"cone {{ {_vector(s.p0)}, {float(s.r0)!r}, {_vector(s.p1)}, {float(s.r1)!r}{_open(s)}", "}"),
    "polygon": _polygon,
    "mesh": _mesh,
    "quadric": _quadric,
}  # fmt: skip
