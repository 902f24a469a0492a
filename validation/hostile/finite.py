"""Numbers that are not finite in what hostile inputs make kernels compute, and those that may be.

Light, and what surfaces pass on of it, may be so much that it overflows: such a pixel is as bright as can be
(docs/design.md). So a scene in which something is not finite is rendered again with nothing brighter than 1.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np

import clrt
from clrt.engine.tripwire import NotFinite

_LIGHT: Final = ("ambient", "background", "depth_color")
_SHARES: Final = ("color", "ambient", "diffuse", "specular", "reflection", "transmission", "emission",
                  "highlight_color", "reflection_color", "transmission_color")  # fmt: skip


def rendered(
    scene: clrt.Scene, device: int | str | None, checkpoint: Path | None, how: dict[str, Any]
) -> str:
    """Render; what the tripwire says, also where nothing can overflow, or of the pixels; "" for nothing."""
    try:
        pixels = clrt.render(scene, device=device, checkpoint=checkpoint, **how).pixels
    except NotFinite:
        try:
            pixels = clrt.render(tamed(scene), device=device, **how).pixels
        except NotFinite as error:
            return str(error)
    broken = np.count_nonzero(~np.isfinite(pixels))
    return f"{broken} values" if broken else ""


def tamed(scene: clrt.Scene) -> clrt.Scene:
    """The scene with no light, coefficient or colour above 1, but for a background image's."""
    table = scene.to_dict()
    image = {"background"} if scene.background_path is not None else set()
    for key in set(_LIGHT) - image:
        table[key] = _capped(table.get(key, 0.0))
    table["lights"] = [_tamed_light(light) for light in table.get("lights", ())]
    used = [shape.get("material") for shape in table.get("shapes", ())]
    for material in filter(lambda one: isinstance(one, dict), [*table.get("materials", {}).values(), *used]):
        material.update({key: _capped(material[key]) for key in _SHARES if key in material})
    return clrt.load_dict(table, folder=scene.folder, source=scene.source, limits=scene.limits)


def _tamed_light(light: dict[str, Any]) -> dict[str, Any]:
    name = "radiance" if light["type"] in ("rectangle", "disk", "sphere") else "intensity"
    return {**light, name: _capped(light.get(name, 1.0))}


def _capped(value: Any) -> Any:
    """Numbers, of (nm, value) pairs the values, a spectrum's scale and a checker's colours: at most 1."""
    if isinstance(value, dict):
        capped = {key: _capped(value[key]) for key in ("scale", "samples", "colors") if key in value}
        return {**value, **capped}
    if isinstance(value, (list, tuple)):
        pairs = len(value[0]) == 2 if isinstance(value[0], (list, tuple)) else False
        return [[nm, min(part, 1.0)] for nm, part in value] if pairs else [_capped(part) for part in value]
    return min(value, 1.0) if isinstance(value, (int, float)) else value
