"""Mitsuba's cameras, lights, surroundings and integrator as a scene file has them."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any, Final

import numpy as np

from clrt.base.errors import fault, show
from clrt.formats.mitsuba.file import Context
from clrt.formats.mitsuba.spectra import times
from clrt.formats.mitsuba.values import Array, Plugin, looks
from clrt.formats.xml_tree import Element, unknown
from clrt.scene.pinhole import ahead
from clrt.scene.transforms import is_similarity

Table = dict[str, Any]
MOST_SAMPLES: Final = 16
"""Samples a pixel that are taken over: a path tracer needs many times as many."""
_FILTERS: Final = {
    "box": "box", "tent": "tent", "gaussian": "gaussian", "mitchell": "mitchell", "catmullrom": "mitchell",
    "lanczos": "mitchell",
}  # fmt: skip
_FILTER: Final = "gaussian"  # of a film that says nothing
_SAMPLERS: Final = ("independent", "stratified", "multijitter", "orthogonal", "ldsampler", "sobol", "halton",
                    "hammersley")  # fmt: skip
_ANY: Final = dict.fromkeys(("samples_per_pass", "block_size", "timeout", "strict_normals"), "-") | {
    "hide_emitters": "x"}  # fmt: skip
_PATHS: Final = _ANY | {"max_depth": "x", "rr_depth": "-"}
_DIRECT: Final = ("direct", "direct_projective")  # whatever max_depth they are given
_PROJECTIVE: Final = _PATHS | dict.fromkeys(
    ("sppc", "sppp", "sppi", "guiding", "guiding_proj", "guiding_rounds", "project_seed"), "-"
)
_INTEGRATORS: Final[dict[str, dict[str, str] | None]] = {
    "path": _PATHS, "volpath": _PATHS, "volpathmis": _PATHS, "ptracer": _PATHS,
    "prb": _PATHS, "prb_basic": _PATHS, "prbvolpath": _PATHS,
    "direct_projective": _PROJECTIVE, "prb_projective": _PROJECTIVE,
    # its max_depth is how many primitives that have no surface a ray meets
    "volprim_rf_basic": _PATHS | {"max_depth": "-", "srgb_primitives": "-"},
    "direct": _ANY | dict.fromkeys(("shading_samples", "emitter_samples", "bsdf_samples"), "-"),
    "aov": _ANY | {"aovs": "-"}, "moment": _ANY, "depth": _ANY, "stokes": _ANY,
} | dict.fromkeys(
    ("whitted", "bdpt", "emission", "photonmapper", "sppm", "pssmlt", "mlt", "irrcache")
)  # fmt: skip
"""Their values; None where Mitsuba 3 has no such integrator: of these, which others have, all are taken."""
_VIEW: Final = dict.fromkeys(
    ("to_world", "fov", "fov_axis", "focal_length", "principal_point_offset_x", "principal_point_offset_y",
     "near_clip"), "x",
) | dict.fromkeys(
    ("far_clip", "focus_distance", "shutter_open", "shutter_close"), "-"
) | {"srf": ""}  # fmt: skip
_OTHER_SENSORS: Final = ("radiancemeter", "irradiancemeter", "distant", "batch")
_LENS: Final = {"aperture_radius": "x", "focus_distance": "x"}
_SENSORS: Final[dict[str, dict[str, str]]] = {
    "perspective": _VIEW, "thinlens": _VIEW | _LENS, "orthographic": _VIEW,
}  # fmt: skip
_FILMS: Final = ("hdrfilm", "ldrfilm", "specfilm")
_FILM: Final = {"width": "x", "height": "x"} | dict.fromkeys(
    ("crop_width", "crop_height", "crop_offset_x", "crop_offset_y", "sample_border"), ""
) | dict.fromkeys(
    ("component_format", "file_format", "banner", "gamma", "high_quality_edges", "compensate"), "-"
) | {"pixel_format": "x"}  # fmt: skip
_DIAGONAL: Final = math.hypot(36.0, 24.0)  # mm, of the film that a focal length is about
_HALF_TURN: Final = np.diag([-1.0, 1.0, -1.0, 1.0])


def camera(plugin: Plugin, context: Context) -> Table | None:
    """The camera of a sensor; None where it is another instrument."""
    if plugin.type not in _SENSORS:
        context.without(plugin, [*_SENSORS], _OTHER_SENSORS)
        return None
    context.check(plugin, _SENSORS[plugin.type])
    orthographic = plugin.type == "orthographic"
    table: Table = _film(plugin, context) | _samples(plugin, context) | _place(plugin)
    width, height = table["width"], table["height"]
    if near := plugin.number("near_clip", 0.0):  # in the sensor's own units
        table["near"] = near * float(np.linalg.norm(plugin.to_world()[:3, 2]))
    if orthographic:
        across, up = np.linalg.norm(plugin.to_world()[:3, :2], axis=0).tolist()
        if abs(across - up) > 1e-6 * across:
            context.left_out["the stretch of an orthographic view"] = None
        return table | {"type": "orthographic", "size": 2 * across}
    table |= _angle(plugin, width, height)
    shift = [plugin.number(f"principal_point_offset_{axis}", 0.0) for axis in "xy"]
    if any(shift):
        table["shift"] = [shift[0] * width, shift[1] * height]
    if plugin.type == "thinlens":
        table["aperture"] = plugin.number("aperture_radius", 0.0)
        table["focus"] = plugin.number("focus_distance", plugin.number("far_clip", 10000.0))
    return table


def _place(plugin: Plugin) -> Table:
    """Where it is and looks to. Mitsuba's +x is to the left; where it is to the right, it is a mirror's."""
    element = plugin.values.get("to_world")
    if element is not None and [step.tag.lower() for step in element.children] == ["lookat"]:
        told = zip(("origin", "target", "up"), looks(element.children[0]), strict=True)
        return {key: list(value) for key, value in told}
    matrix = plugin.to_world()
    origin, target, up = matrix[:3, 3], _target(plugin), _unit(plugin, 1)
    mirror = {"mirror": True} if np.linalg.det(matrix[:3, :3]) < 0 else {}
    return {"origin": origin.tolist(), "target": target.tolist(), "up": up.tolist()} | mirror


def _target(plugin: Plugin) -> Array:
    """What lies ahead of a plugin that looks along its z axis."""
    return ahead(plugin.to_world()[:3, 3], _unit(plugin, 2))


def _unit(plugin: Plugin, axis: int) -> Array:
    """An axis of to_world, of length 1."""
    way: Array = plugin.to_world()[:3, axis]
    length = np.linalg.norm(way)
    if not 0.0 < length < math.inf:
        raise plugin.element.says("to_world must not flatten space")
    return way / length


def _angle(plugin: Plugin, width: int, height: int) -> Table:
    """The angle of view along the axis that a camera here has."""
    known = ("x", "y", "diagonal", "smaller", "larger")
    axis = plugin.text("fov_axis", "x").lower()  # which Mitsuba does not tell apart
    if axis not in known:
        raise unknown(plugin.values["fov_axis"], "fov axis", axis, [*known])
    if axis in ("smaller", "larger"):
        axis = "x" if (axis == "larger") == (width >= height) else "y"
    if "fov" in plugin.values:
        degrees = plugin.number("fov", 0.0)
    else:
        length = plugin.values.get("focal_length")
        text = "50mm" if length is None else length.get("value")
        try:
            degrees = 2 * math.degrees(math.atan(_DIAGONAL / (2 * float(text.removesuffix("mm")))))
        except (ValueError, ZeroDivisionError):
            assert length is not None
            raise length.says(fault("", "focal_length", text, "it must be like 50mm")) from None
        axis = "diagonal"
    if not 0 < degrees < 180:
        raise plugin.element.says(fault("", "fov", degrees, "it must be an angle from 0 to 180 degrees"))
    if axis == "diagonal":
        tangent = math.tan(math.radians(degrees / 2)) * width / math.hypot(width, height)
        return {"fov": 2 * math.degrees(math.atan(tangent))}
    return {"fov": degrees} | ({"fov_axis": "vertical"} if axis == "y" else {})


def _within(plugin: Plugin, tag: str, known: Collection[str], context: Context) -> Plugin | None:
    """The plugin of this tag within another; ClrtError where its type is none of those known, but in files of
    the first version."""
    element = context.first(plugin, tag)
    if element is None:
        return None
    found = Plugin.of(element)
    if found.type not in known:
        context.other(element, tag, found.type, [*known])
    return found


def _film(plugin: Plugin, context: Context) -> Table:
    found: Table = {"width": 768, "height": 576}
    film = _within(plugin, "film", _FILMS, context)
    if film is None:
        return found | {"filter": _FILTER}
    context.check(film, _FILM)
    if (pixels := film.text("pixel_format", "rgb")).lower().startswith("luminance"):
        context.left_out[f"pixel format {show(pixels)}"] = None
    found = {name: film.whole(name, found[name], 1) for name in found}
    kind = _within(film, "rfilter", _FILTERS, context)
    if kind is None:
        return found | {"filter": _FILTER}
    context.check(kind, dict.fromkeys(("radius", "stddev", "b", "c", "lobes"), ""))
    kept = _FILTERS.get(kind.type, _FILTER)
    return found if kept == "box" else found | {"filter": kept}


def _samples(plugin: Plugin, context: Context) -> Table:
    sampler = _within(plugin, "sampler", _SAMPLERS, context)
    if sampler is None:
        return {}
    same = dict.fromkeys(("seed", "jitter", "dimension", "scramble"), "-")
    context.check(sampler, {"sample_count": "x"} | same)
    root = math.isqrt(min(sampler.whole("sample_count", 4, 1), MOST_SAMPLES))
    return {"spp": root * root}


def depth(element: Element, context: Context) -> int | None:
    """`max_depth` of an integrator: paths of length 2 see the light on the first surface. None: not said.

    Many may refer to one: each is read once.
    """
    if id(element) not in context.depths:
        context.depths[id(element)] = _depth(Plugin.of(element), context)
    return context.depths[id(element)]


def _depth(plugin: Plugin, context: Context) -> int | None:
    if plugin.type not in _INTEGRATORS:
        context.other(plugin.element, "integrator", plugin.type, [*_INTEGRATORS])
    known = _INTEGRATORS.get(plugin.type)
    if known is not None:
        context.check(plugin, known)
    if plugin.flag("hide_emitters", False):
        context.left_out["that emitters are hidden"] = None
    found = None
    if plugin.type in _DIRECT:
        found = 0
    elif "max_depth" in plugin.values and (known is None or known["max_depth"] == "x"):
        most = plugin.whole("max_depth", -1, -1)
        found = None if most < 0 else min(max(most - 2, 0), context.limits.depth)
    if found is not None:
        return found
    inner = context.first(plugin, "integrator")  # each may be referred to: all of them were a tree
    return None if inner is None else depth(inner, context)


def emitter(plugin: Plugin, context: Context, scene: Table) -> None:
    """Put a light, or what surrounds a scene, into it. What falls on a white wall is pi times the model's."""
    if plugin.type not in _EMITTERS:
        context.without(plugin, [*_EMITTERS], _OTHER_EMITTERS)
        return
    context.check(plugin, _EMITTERS[plugin.type] | {"sampling_weight": "-"})
    context.lend_spectra(plugin)
    if plugin.type in ("constant", "envmap") and "background" in scene:
        context.left_out["surroundings but the last"] = None
    if plugin.type == "constant":
        # all of it falls on each surface, less what is in the way
        scene["background"] = scene["ambient"] = plugin.color("radiance", 1.0)
    elif plugin.type == "envmap":
        if "filename" not in plugin.values:
            raise plugin.element.says("an envmap needs its filename")
        scene["background"] = context.file(plugin.values["filename"])
        scene |= {"ambient_samples": 16, "ambient": 0.5}
        if not np.allclose(plugin.to_world(), _HALF_TURN, atol=1e-6):
            context.left_out["turns of an envmap"] = None
    else:
        if plugin.type == "spot" and not is_similarity(plugin.to_world()):
            context.left_out["the stretch of a spot"] = None
        scene["lights"].append(_LIGHTS[plugin.type](plugin))


def _point(plugin: Plugin) -> Table:
    place = plugin.to_world()[:3, 3].tolist()
    position = list(plugin.vector("position", place))
    intensity = times(plugin.color("intensity", 1.0), 1 / math.pi)
    return {"type": "point", "position": position, "intensity": intensity, "falloff": "inverse-square"}


def _directional(plugin: Plugin) -> Table:
    way = plugin.vector("direction", tuple(_unit(plugin, 2).tolist()))
    # of an axis that is scaled the length counts, of a direction not
    length = 1.0 if "direction" in plugin.values else float(np.linalg.norm(plugin.to_world()[:3, 2]))
    return {"type": "directional", "direction": list(way),
            "intensity": times(plugin.color("irradiance", 1.0), length / math.pi)}  # fmt: skip


def _spot(plugin: Plugin) -> Table:
    matrix: Array = plugin.to_world()
    angle = plugin.number("cutoff_angle", 20.0)
    inner = plugin.number("beam_width", 0.75 * angle)
    inner = min(inner, angle)  # a wider beam ends at the cutoff there, too
    if not 0 < angle <= 90 or inner < 0:
        text = "it must be from 0 to 90 degrees, and beam_width not below 0"
        raise plugin.element.says(fault("", "cutoff_angle", angle, text))
    return {
        "type": "spot", "position": matrix[:3, 3].tolist(),
        "target": _target(plugin).tolist(),
        "intensity": times(plugin.color("intensity", 1.0), 1 / math.pi), "angle": angle,
        "penumbra": 1 - inner / angle, "falloff": "inverse-square",
    }  # fmt: skip


ON_SHAPES: Final = ("area", "directionalarea")
_OTHER_EMITTERS: Final = ("projector", "sunsky", "timed_sunsky", "sky", "sun", "collimated", *ON_SHAPES)
_LIGHTS: Final = {"point": _point, "directional": _directional, "spot": _spot}
_EMITTERS: Final[dict[str, dict[str, str]]] = {
    "point": dict.fromkeys(("position", "to_world", "intensity"), "x"),
    "directional": dict.fromkeys(("direction", "to_world", "irradiance"), "x"),
    "spot": dict.fromkeys(("to_world", "intensity", "cutoff_angle", "beam_width"), "x") | {"texture": ""},
    "constant": {"radiance": "x", "to_world": "-"},
    "envmap": {"filename": "x", "to_world": "x", "scale": "", "mis_compensation": "-"},
}
