"""What of a scene can be changed while it is looked at: numbers and colours, each at its place.

Names of files, spectra and all other texts have no knob, and what has none cannot be changed from a page.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, Final

from clrt.base.errors import ClrtError, show
from clrt.scene.lights import SpotLight
from clrt.scene.materials import IOR, Checker, Material
from clrt.scene.scene import Scene

MOST: Final = 200  # materials, and lights, that get knobs
_UNIT: Final = ("diffuse", "specular", "reflection", "transmission", "roughness")
_STANDS_FOR: Final = {"ambient": "ka", "reflection": "kr", "transmission": "kt"}  # where a value is None

Knob = dict[str, Any]
"""place; group and label for people; kind: number, log (of one > 0), whole, color, light; value; range."""


def knobs(scene: Scene) -> list[Knob]:
    """All of a scene: of its materials, its lights, and of what is around them."""
    found = [*_materials(scene), *_lights(scene)]
    found += _color("the scene", "background", "background", scene.background, "light")
    found += _color("the scene", "ambient", "ambient light", scene.ambient, "light")
    found.append(
        _knob("the scene", "max_depth", "bounces", scene.max_depth, "whole", 0, max(12, scene.max_depth))
    )
    return found


def checked(changes: object, allowed: Mapping[str, Knob]) -> dict[str, Any]:
    """Changes as `Scene.replace` takes them. ClrtError for a place without a knob, or what is no number."""
    if not isinstance(changes, dict):
        raise ClrtError(f"changes: {show(changes)} is not allowed; it must be a table of places")
    for place, value in changes.items():
        if place not in allowed:
            raise ClrtError(f"{show(place)}: cannot be changed here; edit the scene's file")
        whole = allowed[place]["kind"] == "whole"
        if allowed[place]["kind"] in ("color", "light"):
            right = isinstance(value, list) and len(value) == 3 and all(map(_is_number, value))
        else:
            right = isinstance(value, int) and not isinstance(value, bool) if whole else _is_number(value)
        if not right:
            raise ClrtError(
                f"{place}: {show(value)} is not allowed; it must be like {show(allowed[place]['value'])}"
            )
    return changes


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and -1e30 < value < 1e30


def _materials(scene: Scene) -> Iterator[Knob]:
    named = [(name, f'materials."{name}"', one) for name, one in scene.materials.items() if '"' not in name]
    for index, shape in enumerate(scene.shapes if len(named) < MOST else ()):
        if isinstance(shape.material, Material):
            named.append(
                (
                    f"of {shape.name or shape.type} (shapes[{index}])",
                    f"shapes[{index}].material",
                    shape.material,
                )
            )
            if len(named) >= MOST:
                break
    for name, place, material in named[:MOST]:
        yield from _material(name, place, material)


def _material(name: str, place: str, material: Material) -> Iterator[Knob]:
    group = f"material {name}"
    if isinstance(material.color, Checker):
        for index, one in enumerate(material.color.colors):
            yield from _color(group, f"{place}.color.colors[{index}]", f"colour {index + 1}", one, "color")
    else:
        yield from _color(group, f"{place}.color", "colour", material.color, "color")
    for key in _UNIT:
        value = getattr(material, key)
        value = getattr(material, _STANDS_FOR[key]) if value is None else value
        if not (key == "roughness" and material.kt > 0):
            yield _knob(group, f"{place}.{key}", key, value, "number", 0, max(1, value))
    yield _knob(
        group,
        f"{place}.shininess",
        "shininess",
        max(material.shininess, 1),
        "log",
        1,
        max(2000, material.shininess),
    )
    if isinstance(material.ior, (int, float)) or material.ior in IOR:
        yield _knob(
            group,
            f"{place}.ior",
            "index of refraction",
            material.ior_d,
            "number",
            min(1, material.ior_d),
            max(3, material.ior_d),
        )
    for key, used in (("highlight_color", material.specular), ("reflection_color", material.kr),
                      ("transmission_color", material.kt)):  # fmt: skip
        if used > 0:
            yield from _color(
                group, f"{place}.{key}", key.replace("_color", "'s colour"), getattr(material, key), "color"
            )
    yield from _color(group, f"{place}.emission", "emission", material.emission, "light")


def _lights(scene: Scene) -> Iterator[Knob]:
    for index, light in enumerate(scene.lights[:MOST]):
        group, place = f"{light.type} light (lights[{index}])", f"lights[{index}]"
        key = "radiance" if hasattr(light, "radiance") else "intensity"
        yield from _color(group, f"{place}.{key}", key, getattr(light, key), "light")
        for key in ("position", "center", "direction"):
            vector = getattr(light, key, None)
            if vector is None:
                continue
            reach = max(1.0, 2 * max(map(abs, vector)))
            for axis, value in enumerate(vector):
                yield _knob(
                    group, f"{place}.{key}[{axis}]", f"{key} {'xyz'[axis]}", value, "number", -reach, reach
                )
        if isinstance(light, SpotLight):
            yield _knob(group, f"{place}.angle", "angle", light.angle, "number", 1, 90)
            yield _knob(group, f"{place}.penumbra", "penumbra", light.penumbra, "number", 0, 1)
        radius = getattr(light, "radius", None)
        if radius is not None:
            yield _knob(group, f"{place}.radius", "radius", radius, "log", radius / 100, radius * 10)


def _color(group: str, place: str, label: str, value: Any, kind: str) -> Iterator[Knob]:
    """A knob for a colour that is stated by numbers; spectra, lamps and images have none."""
    if isinstance(value, (int, float)):
        value = [float(value)] * 3
    if isinstance(value, (tuple, list)) and len(value) == 3 and all(map(_is_number, value)):
        yield _knob(group, place, label, [float(v) for v in value], kind, 0, max(1.0, 4 * max(value)))


def _knob(group: str, place: str, label: str, value: Any, kind: str, low: float, high: float) -> Knob:
    # float32 noise of the scene's own numbers is none of a slider's
    shown = value if isinstance(value, (int, list)) else float(f"{value:.7g}")
    assert isinstance(shown, list) or math.isfinite(shown)
    return {
        "group": group,
        "place": place,
        "label": label,
        "value": shown,
        "kind": kind,
        "low": low,
        "high": high,
    }
