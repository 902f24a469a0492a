"""A small scene with every term in it, its picture, and faults that someone might make."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from msgspec.structs import replace

import clrt
from clrt.base.resources import validation_module

WIDTH, HEIGHT = 96, 72

SCENE: dict[str, Any] = {
    "max_depth": 5,
    "ambient": 0.1,
    "background": [0.2, 0.3, 0.5],
    "camera": {"origin": [0.3, 1.6, 6.0], "target": [0.0, 0.8, 0.0], "fov": 40,
               "width": WIDTH, "height": HEIGHT},
    "lights": [
        {"type": "point", "position": [3, 5, 4], "intensity": 0.5},
        {"type": "directional", "direction": [1, -1.5, -1], "intensity": [0.4, 0.35, 0.3]},
    ],
    "shapes": [
        {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0],
         "material": {"color": [0.7, 0.75, 0.6], "diffuse": 0.9}},
        {"type": "sphere", "center": [-1.2, 1, -0.5], "radius": 1,
         "material": {"color": [0.8, 0.2, 0.1], "diffuse": 0.7, "specular": 0.3, "shininess": 40,
                      "reflection": 0.2}},
        {"type": "sphere", "center": [0.9, 0.8, 0.6], "radius": 0.8, "name": "glass",
         "material": {"diffuse": 0.05, "reflection": 0.1, "transmission": 0.8, "ior": 1.5, "specular": 0.1}},
        {"type": "box", "min": [-3, 0, -3], "max": [-2, 2.2, -2], "material": {"color": [0.2, 0.3, 0.8]}},
    ],
}  # fmt: skip


def scene() -> clrt.Scene:
    return clrt.load_dict(SCENE)


def ours(changed: clrt.Scene | None = None, **options: Any) -> Any:
    """The OracleImage of the scene, or of a changed one."""
    return validation_module("ours").render_ours(clrt.Tracer(changed or scene()), **options)


@cache
def picture() -> np.ndarray:
    return clrt.render(scene()).pixels


@cache
def edges() -> np.ndarray:
    """The scene's edge mask."""
    metrics = validation_module("compare.metrics")
    moved = [clrt.render(with_camera(shift=(0.05 * x, 0.05 * y))).pixels for x, y in metrics.DIAGONAL]
    return metrics.edge_mask(picture(), moved)


def with_camera(**changes: Any) -> clrt.Scene:
    base = scene()
    return replace(base, camera=replace(base.camera, **changes))


def with_material(shape: int, **changes: Any) -> clrt.Scene:
    base = scene()
    shapes = list(base.shapes)
    shapes[shape] = replace(shapes[shape], material=replace(base.material_of(shapes[shape]), **changes))
    return replace(base, shapes=tuple(shapes))


def with_lights(*factors: float) -> clrt.Scene:
    """Each light's intensity times a factor; 0 leaves it out."""
    base = scene()
    lights = [
        replace(light, intensity=tuple(factor * np.array(clrt.scene.scene.rgb(light.intensity))))
        for light, factor in zip(base.lights, factors, strict=True)
        if factor
    ]
    return replace(base, lights=tuple(lights))


def without_shape(index: int) -> clrt.Scene:
    base = scene()
    return replace(base, shapes=tuple(shape for i, shape in enumerate(base.shapes) if i != index))


# --- pictures of no scene

GREY = np.full((40, 50, 3), 0.4)
EDGES = np.zeros((40, 50), bool)
EDGES[:, :3] = True


def oracle(pixels: Any, **fields: Any) -> Any:
    """An OracleImage of these pixels and nothing else, unless given."""
    defaults = {"by_ray": {}, "t": None, "shape": None, "name": "an oracle", "seconds": 0.0}
    return validation_module("types").OracleImage(np.asarray(pixels, float), **(defaults | fields))


def failed(comparison: Any) -> set[str]:
    """Names of the gates that failed."""
    return {gate.name for gate in comparison.gates if not gate.passed}
