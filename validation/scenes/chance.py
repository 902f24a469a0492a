"""Scenes drawn from a seed: any shapes with any materials under any lights, which nobody thought of."""

from __future__ import annotations

from typing import Any

import numpy as np

from .parts import CHECKERED, CLOSED, OPEN, Table

_ALL = {**CLOSED, **OPEN}
_CHANCE_OF_CHECKER = 0.4
_CHANCE_OF_SPECTRA = 0.3  # of a scene; of a colour in it
_CHANCE_OF_ROUGHNESS = 0.1  # of a mirror or a metal
_CHANCE_OF_EXTENT = 0.15  # of a camera and of a light
_CHANCE_OF_FOCUS = 0.6  # of a lens
_FILTERS = ("tent", "gaussian", "mitchell")
_LAMPS = ("spot", "rectangle", "disk", "sphere")
_LIGHTS = ("D65", "A", "F2", "F11", "sun")
_METALS = ("gold", "silver", "copper", "aluminium", "iron")


def scene(seed: int, number: int, wide: bool = True) -> Table:
    """Scene `number` of a seed: the same on every machine.

    wide: some have a lens, a filter, spots and lights with extent in place of points.
    """
    draw = np.random.default_rng([seed, number])
    table: Table = {
        "max_depth": int(draw.integers(1, 6)), "background": _color(draw, 0.1, 0.6),
        "ambient": _color(draw, 0.05, 0.4),
        "ambient_samples": int(draw.choice([0, 0, 0, 0, 2])),
        "min_weight": float(draw.choice([0, 0, 0.01, 0.1])),
        "depth_color": _color(draw, 0, 0.5), "medium_ior": float(draw.choice([1.0, 1.0, 1.333])),
        "one_sided": str(draw.choice(["none", "none", "none", "opaque"])),
        "shadow": str(draw.choice(["opaque", "tinted"])), "camera": _camera(draw),
        "lights": [_light(draw) for _ in range(draw.integers(1, 4))],
        "shapes": [_shape(draw) for _ in range(draw.integers(3, 12))],
    }  # fmt: skip
    if table["ambient_samples"]:
        table["max_depth"] = min(table["max_depth"], 2)  # each ray of them spawns more
    floor = {"type": "plane", "point": [0, float(draw.uniform(-3, -1.5)), 0], "normal": [0, 1, 0]}
    table["shapes"].append({**floor, "material": _material(draw, True)})
    more = np.random.default_rng([seed, number, 1])  # what came later leaves what is above as it was
    for shape in table["shapes"]:
        _fill(more, shape["material"])
    if more.random() < _CHANCE_OF_SPECTRA:
        _colour(more, table)
    _roughen(np.random.default_rng([seed, number, 2]), table)
    if wide:
        _widen(np.random.default_rng([seed, number, 3]), table)
        _vary(np.random.default_rng([seed, number, 4]), table)
    return table


def _widen(draw: np.random.Generator, table: Table) -> None:
    """Lenses, filters, and in place of some lights spots and lights with extent."""
    if draw.random() < _CHANCE_OF_EXTENT:
        table["camera"]["aperture"] = round(float(draw.uniform(0.005, 0.04)), 4)
    if draw.random() < _CHANCE_OF_EXTENT:
        table["camera"] |= {"filter": str(draw.choice(_FILTERS)), "spp": int(draw.choice([4, 9]))}
    table["lights"] = [
        _lamp(draw, light) if draw.random() < _CHANCE_OF_EXTENT and _is_rgb(light) else light
        for light in table["lights"]
    ]


def _vary(draw: np.random.Generator, table: Table) -> None:
    """Lenses in focus before or behind the target; sphere lights that are two-sided or hidden."""
    camera = table["camera"]
    if "aperture" in camera and draw.random() < _CHANCE_OF_FOCUS:
        distance = float(np.linalg.norm(np.subtract(camera["target"], camera["origin"])))
        camera["focus"] = round(distance * float(draw.uniform(0.6, 1.5)), 4)
    for light in table["lights"]:
        if light["type"] == "sphere":
            light |= {"two_sided": bool(draw.random() < 0.3), "visible": bool(draw.random() < 0.8)}


def _is_rgb(light: Table) -> bool:
    return not isinstance(light["intensity"], (str, dict))


def _lamp(draw: np.random.Generator, light: Table) -> Table:
    """A light of another kind in place of one, as bright from the middle of the scene."""
    away = np.array(light.get("position") or np.multiply(light["direction"], -5.0))
    kind, color = str(draw.choice(_LAMPS)), np.array(light["intensity"])
    distance = float(np.linalg.norm(away))
    if light.get("falloff"):
        color = color / distance**2
    if kind == "spot":
        return {"type": "spot", "position": _numbers(away), "target": _numbers(draw.normal(size=3) * 0.5),
                "angle": round(float(draw.uniform(10, 60)), 2), "penumbra": float(draw.choice([0, 0.3, 1])),
                "intensity": _numbers(color)}  # fmt: skip
    radius = round(float(draw.uniform(0.1, 0.2)) * distance, 4)
    lamp: Table = {"type": kind, "center": _numbers(away), "samples": int(draw.integers(1, 5)),
                   "radiance": _numbers(color * (distance / radius) ** 2)}  # fmt: skip
    if kind != "sphere":
        lamp |= {"two_sided": bool(draw.random() < 0.3), "visible": bool(draw.random() < 0.8)}
    if kind != "rectangle":
        lamp["radius"] = radius
    if kind == "disk":
        lamp["normal"] = _numbers(-away)
    if kind == "rectangle":
        across = np.cross(away, draw.normal(size=3))
        u = across / np.linalg.norm(across) * radius
        lamp |= {"u": _numbers(u), "v": _numbers(np.cross(u, away) / distance * 0.8)}
    return lamp


def _roughen(draw: np.random.Generator, table: Table) -> None:
    """Mirrors and metals that are not smooth."""
    for material in (shape["material"] for shape in table["shapes"]):
        mirror = "conductor" in material or material.get("reflection", 0) > 0
        if draw.random() < _CHANCE_OF_ROUGHNESS and mirror and not material.get("transmission"):
            material["roughness"] = round(float(draw.uniform(0.05, 0.6)), 3)


def _fill(draw: np.random.Generator, material: Table) -> None:
    """Media that absorb, are stronger than others, and have named indices; metals."""
    if material.get("transmission", 0) > 0:
        if draw.random() < 0.5:
            material["absorption"] = _color(draw, 0, 0.5)
        if draw.random() < 0.5:
            material["priority"] = int(draw.integers(-1, 3))
        if draw.random() < 0.25:
            material["ior"] = str(draw.choice(["air", "water", "ice", "glass", "diamond"]))
    elif draw.random() < 0.15:
        numbers = {"eta": float(draw.uniform(0.2, 2)), "k": float(draw.uniform(0.5, 4))}
        material["conductor"] = str(draw.choice(_METALS)) if draw.random() < 0.5 else numbers
        if material.get("fresnel") == "schlick":
            del material["fresnel"]


def _colour(draw: np.random.Generator, table: Table) -> None:
    """Spectra in place of colours, at times carried in bands, and then indices that are curves."""
    bands = draw.random() < 0.6
    if bands:  # few: Mitsuba needs a picture for each where indices differ
        table["spectrum"] = {"bands": int(draw.integers(3, 6)), "group": int(draw.integers(1, 3))}
        table["min_weight"] = 0.0  # it is of all bands together, which a picture of one cannot know
        if draw.random() < 0.3:
            table["spectrum"] |= {"white": "A", "white_balance": True}
    for key in ("ambient", "background", "depth_color"):
        table[key] = _light_spectrum(draw, 0.3) if draw.random() < 0.4 else table[key]
    for light in table["lights"]:
        if "falloff" not in light and draw.random() < 0.5:
            light["intensity"] = _light_spectrum(draw, 0.5)
    for material in (shape["material"] for shape in table["shapes"]):
        plain = isinstance(material["color"], list)
        tints = [key for key in material if key.endswith("_color")]
        for key in [*(["color"] if plain else []), *tints]:
            if draw.random() < 0.4:
                material[key] = _reflectance(draw)
        if material.get("emission") and draw.random() < 0.5:
            material["emission"] = _light_spectrum(draw, 0.2)
        if "absorption" in material and draw.random() < 0.5:
            material["absorption"] = {"samples": _samples(draw, 0.5)}
        if bands and material.get("transmission", 0) > 0 and draw.random() < 0.5:
            glass = {"sellmeier": {"B": [float(draw.uniform(0.8, 1.6)), 0.25], "C": [0.02, 0.06]}}
            curve: Any = [[400, float(draw.uniform(1.6, 1.8))], [700, 1.5]]
            material["ior"] = [str(draw.choice(["BK7", "SF10", "SF11", "silica"])), glass,
                               {"cauchy": [1.5, 0.01]}, curve][draw.integers(4)]  # fmt: skip


def _samples(draw: np.random.Generator, most: float) -> list[list[float]]:
    return [[nm, round(float(draw.uniform(0, most)), 3)] for nm in (400, 480, 560, 640, 720)]


def _light_spectrum(draw: np.random.Generator, scale: float) -> Table:
    kinds: list[Table] = [
        {"name": str(draw.choice(_LIGHTS))}, {"blackbody": float(draw.uniform(2000, 9000))},
        {"gaussian": [float(draw.uniform(450, 650)), float(draw.uniform(20, 60))]},
        {"band": [float(draw.uniform(400, 500)), float(draw.uniform(550, 700))]},
        {"samples": _samples(draw, 1.0)},
    ]  # fmt: skip
    return {**kinds[draw.integers(len(kinds))], "scale": round(scale * float(draw.uniform(0.5, 1)), 3)}


def _reflectance(draw: np.random.Generator) -> Any:
    bell = {"gaussian": [float(draw.uniform(450, 650)), float(draw.uniform(40, 90))]}
    names = [f"patch-{draw.integers(1, 25)}", str(draw.choice(_METALS))]
    kinds: list[Any] = [*names, {"samples": _samples(draw, 0.9)}, bell]
    return kinds[draw.integers(len(kinds))]


def _camera(draw: np.random.Generator) -> Table:
    origin = draw.normal(size=3)
    origin *= draw.choice([1.0, 6.0, 8.0]) / np.linalg.norm(origin)
    origin[1] = abs(origin[1])
    camera: Table = {"origin": _numbers(origin), "target": _numbers(draw.normal(size=3) * 0.5)}
    if draw.random() < 0.2:
        camera |= {"type": "orthographic", "size": float(draw.uniform(4, 8))}
    else:
        camera |= {"fov": float(draw.uniform(30, 80))}
    if draw.random() < 0.3:
        camera |= {"mirror": True, "shift": _numbers(draw.uniform(-0.5, 0.5, 2)),
                   "near": float(draw.uniform(0, 2))}
    if draw.random() < 0.3:
        camera |= {"jitter": int(draw.integers(0, 1 << 32))}
    if draw.random() < 0.2:
        camera |= {"fov_axis": "vertical"}
    return camera


def _light(draw: np.random.Generator) -> Table:
    color = _color(draw, 0.2, 0.6)
    if draw.random() < 0.3:
        direction = draw.normal(size=3)
        return {"type": "directional",
                "direction": _numbers([direction[0], -abs(direction[1]), direction[2]]),
                "intensity": color}  # fmt: skip
    position = draw.normal(size=3) * 4
    if draw.random() < 0.3:
        return {"type": "point", "position": _numbers(position), "falloff": "inverse-square",
                "intensity": _numbers(np.array(color) * 12)}  # fmt: skip
    return {"type": "point", "position": _numbers(position), "intensity": color}


def _shape(draw: np.random.Generator) -> Table:
    name = str(draw.choice(list(_ALL)))
    x, y, z = draw.normal(size=3) * 1.3
    shape = _ALL[name]((round(float(x), 4), round(float(y), 4), round(float(z), 4)),
                       round(float(draw.uniform(0.3, 1.3)), 4))
    return {**shape, "material": _material(draw, name in CHECKERED)}


def _material(draw: np.random.Generator, checkered: bool) -> Table:
    table: Table = {"color": _color(draw, 0.1, 0.9), "diffuse": float(draw.uniform(0.1, 0.7))}
    if checkered and draw.random() < _CHANCE_OF_CHECKER:
        table["color"] = {"type": "checker", "colors": [_color(draw, 0.3, 0.6), _color(draw, 0.3, 0.6)],
                          "size": float(draw.uniform(0.4, 1.2)),
                          "divisions": int(draw.integers(3, 9))}  # fmt: skip
    if draw.random() < 0.4:
        table |= {"specular": float(draw.uniform(0.1, 0.5)), "shininess": float(10 ** draw.uniform(0, 2.3)),
                  "highlight_color": _color(draw, 0.4, 1)}  # fmt: skip
    kind = draw.random()
    if kind < 0.25:
        table |= {"reflection": float(draw.uniform(0.1, 0.8)), "reflection_color": _color(draw, 0.5, 1)}
        table["fresnel"] = "schlick" if kind < 0.1 else False
    elif kind < 0.5:
        table |= {"transmission": float(draw.uniform(0.3, 0.9)), "transmission_color": _color(draw, 0.6, 1),
                  "ior": float(draw.choice([1.0, 1.2, 1.5, 2.0, 0.8])), "thin": bool(draw.random() < 0.25),
                  "fresnel": bool(draw.random() < 0.5), "diffuse": 0.1}  # fmt: skip
        if draw.random() < 0.5:
            table["reflection"] = float(draw.uniform(0.05, 0.3)) if not table["fresnel"] else 1.0
    if draw.random() < 0.15:
        table |= {"emission": _color(draw, 0, 0.3), "ambient": 0.2}
    return table


def _color(draw: np.random.Generator, low: float, high: float) -> list[float]:
    return _numbers(draw.uniform(low, high, 3))


def _numbers(values: Any) -> list[float]:
    return [round(float(value), 4) for value in values]
