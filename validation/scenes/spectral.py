"""Light in bands: spectra of lights and surfaces, metals, dispersion, and colours from bands."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .parts import CAMERA, LIGHTS, OPAQUE, Table, room, with_material

_BAND_COUNT = 6  # few, so that an oracle that needs a picture for each is soon done
_CLEAR: Table = {"diffuse": 0.0, "fresnel": True}
_MATTE: Table = {"color": [0.6, 0.5, 0.4], "diffuse": 0.7}
_BALL: Table = {"type": "sphere", "center": [-0.3, -0.4, 0], "radius": 1.7}
_SMALL: Table = {"type": "sphere", "center": [1.3, 1.3, 1.6], "radius": 0.6}
_FLINT: Table = {"sellmeier": {"B": [1.6, 0.25], "C": [0.02, 0.06]}}  # bends blue much more than red


def scenes() -> Iterator[tuple[str, Table, set[str]]]:
    """Name, scene and what nobody can see from the scene's tables."""
    for name, table in {**_lights(), **_surfaces(), **_responses(), **_metals(), **_dispersion()}.items():
        yield name, table, set()


def _pair(material: Table, other: Table | None = None, bands: int | None = _BAND_COUNT,
          **changes: Any) -> Table:  # fmt: skip
    """A ball of a material before the wall, and a smaller one that casts a shadow on it."""
    table = room([with_material(_BALL, material), with_material(_SMALL, other or _MATTE)], **changes)
    return table if bands is None else {"spectrum": {"bands": bands}, **table}


def _lit_by(*colors: Any) -> list[Table]:
    """Lights of these colours side by side."""
    return [{"type": "point", "position": [-5 + 3 * i, 6, 8], "intensity": color}
            for i, color in enumerate(colors)]  # fmt: skip


def _lights() -> dict[str, Table]:
    quiet = {"scale": 0.45}
    steps = [[400, 0.1], [480, 0.6], [560, 0.6], [560, 0.2], [700, 0.5]]
    curves = _lit_by({"gaussian": [590, 30], "scale": 0.3}, {"band": [430, 520], "scale": 0.6},
                     {"line": 546.1, "scale": 0.03}, {"samples": steps, "scale": 0.6})  # fmt: skip
    reflecting = {"color": 0.3, "diffuse": 0.2, "reflection": 0.6}
    return {
        "named lights": _pair(_MATTE, lights=_lit_by({"name": "A", **quiet}, {"name": "F11", **quiet}),
                              background={"name": "D65", "scale": 0.3},
                              ambient={"name": "sun", "scale": 0.2}),
        "black bodies": _pair(_MATTE, lights=_lit_by({"blackbody": 2400, **quiet},
                                                     {"blackbody": 9000, **quiet})),
        "curves of light": _pair(_MATTE, lights=curves),
        "glowing spectra": _pair({"color": 0.2, "diffuse": 0.5,
                                  "emission": {"blackbody": 1900, "scale": 0.3}}, reflecting,
                                 depth_color={"gaussian": [500, 40], "scale": 0.4}, max_depth=1,
                                 background={"band": [500, 700], "scale": 0.4}),
        "spectra in RGB": _pair({"color": "patch-14", "diffuse": 0.8}, {"color": "gold", "diffuse": 0.7},
                                None, lights=_lit_by({"name": "A", **quiet}, {"blackbody": 8000, **quiet}),
                                background={"gaussian": [520, 60], "scale": 0.4}),
    }  # fmt: skip


def _surfaces() -> dict[str, Table]:
    tints = {"reflection": 0.5, "reflection_color": {"gaussian": [620, 60]}, "specular": 0.3, "shininess": 20,
             "highlight_color": {"samples": [[400, 0.9], [700, 0.2]]}}  # fmt: skip
    pane = {"color": 0.2, "diffuse": 0.1, "transmission": 0.8, "transmission_color": {"band": [380, 570]}}
    checker = {"type": "checker", "colors": ["patch-3", [0.7, 0.3, 0.2]], "divisions": 8}
    absorbing = {**_CLEAR, "absorption": {"samples": [[400, 0.1], [500, 0.9], [650, 0.2]]}}
    return {
        "patches": _pair({"color": "patch-13", "diffuse": 0.9}, {"color": "patch-15", "diffuse": 0.9}),
        "spectral tints": _pair({**_MATTE, **tints}, pane),
        "spectral checker": _pair({"color": checker, "diffuse": 0.8}),
        "spectral absorption": _pair(absorbing, {**pane, "ior": 1.0, "absorption": [0.2, 0.9, 0.4]}),
        "RGB in bands": room([with_material(_BALL, OPAQUE["metal"]), with_material(_SMALL, OPAQUE["lamp"])],
                             spectrum={"bands": 9}),
        "tinted shadows in bands": _pair(_MATTE, pane, shadow="tinted", lights=LIGHTS[:1]),
        "ambient rays in bands": _pair(_MATTE, {"color": "patch-7", "diffuse": 0.8}, ambient_samples=2,
                                       max_depth=2, lights=LIGHTS[:1]),
    }  # fmt: skip


def _responses() -> dict[str, Table]:
    colored = {"color": "patch-16", "diffuse": 0.9}, {"color": "patch-18", "diffuse": 0.9}
    lamp = _lit_by({"name": "A", "scale": 0.8})
    return {
        "3 bands": _pair(*colored, bands=3),
        "24 bands": _pair(*colored, bands=24),
        "64 bands": _pair(*colored, bands=64),
        "another range": _pair(*colored, spectrum={"bands": 7, "range": [420, 680]}),
        "white balance": _pair(*colored, lights=lamp, background={"name": "A", "scale": 0.3},
                               ambient={"name": "A", "scale": 0.2},
                               spectrum={"bands": 8, "white": "A", "white_balance": True}),
        "4 samples in bands": _pair(*colored, camera={**CAMERA, "spp": 4}),
    }  # fmt: skip


def _metals() -> dict[str, Table]:
    def metal(conductor: Any, **more: Any) -> Table:
        return {"color": 0.2, "diffuse": 0.05, "conductor": conductor, **more}

    curve = {"eta": [[400, 1.4], [550, 0.4], [700, 0.2]], "k": [[400, 1.9], [700, 4.5]]}
    weak = metal({"eta": 1.7, "k": 0.6})
    water = {"type": "box", "min": [-2.6, -2.2, -1.9], "max": [2.6, 2.2, 2.4],
             "material": {**_CLEAR, "ior": 1.6, "absorption": 0.05}}  # fmt: skip
    sunk = room([water, with_material(_BALL, metal("copper")), with_material(_SMALL, weak)])
    return {
        "gold": _pair(metal("gold"), metal("silver")),
        "weak metals": _pair(weak, metal(curve, reflection=0.8, reflection_color=[1, 0.9, 0.7])),
        "metals in water": {**sunk, "spectrum": {"bands": _BAND_COUNT}},
        "metals in RGB": _pair(metal("copper"), weak, None),
        "a metal with a shine": _pair(metal("iron", specular=0.3, shininess=30)),
    }


def _dispersion() -> dict[str, Table]:
    prism = {"type": "mesh",
             "vertices": [[x, y, z] for z in (1.4, -1.4) for x, y in ((-1.9, -1.4), (1.9, -1.2), (0.2, 1.8))],
             "faces": [[0, 1, 2], [5, 4, 3], [0, 3, 4, 1], [1, 4, 5, 2], [2, 5, 3, 0]],
             "transform": [{"rotate": [[0.2, 1, 0], 40.0]}]}  # fmt: skip
    glass, flint = {**_CLEAR, "ior": "SF11"}, {**_CLEAR, "ior": _FLINT}
    constant = {"color": 0.3, "diffuse": 0.1, "transmission": 0.8, "reflection": 0.1, "ior": _FLINT}
    curved = {**_CLEAR, "ior": [[400, 1.9], [550, 1.6], [700, 1.5]], "absorption": [0.1, 0.3, 0.2]}
    bubble = {**_CLEAR, "ior": 1.0, "priority": 1}
    deep: Table = {"max_depth": 3, "lights": LIGHTS[:1]}
    outer = {**_BALL, "radius": 1.9}
    # a packet meets the ball from within the block, where each group goes its way, and from outside
    block = {"type": "box", "min": [-2.6, -2.2, -1.9], "max": [0, 2.2, 2.4], "material": flint}
    blue = {"diffuse": 0.0, "transmission": 0.9, "transmission_color": {"band": [380, 500]}, "ior": 1.2}
    return {
        "dispersion": _pair(glass, **deep),
        "dispersion, constant coefficients": _pair(constant, **deep),
        "dispersive prism": room([with_material(prism, flint)], spectrum={"bands": _BAND_COUNT}, **deep),
        "dispersive total reflection": room([with_material(prism, constant)],
                                            spectrum={"bands": _BAND_COUNT}, **deep),
        "dispersion by a curve": _pair(curved, **deep),
        "dispersion by Cauchy": _pair({**_CLEAR, "ior": {"cauchy": [1.5, 0.02]}}, **deep),
        "dispersion in groups": _pair(flint, spectrum={"bands": 7, "group": 3}, **deep),
        "dispersion and least weight": _pair(flint, _MATTE, min_weight=0.05, **deep),
        "dispersive sheet": _pair({**flint, "thin": True, "diffuse": 0.1, "color": 0.4}, **deep),
        "dispersion in dispersion": room(
            [with_material(outer, glass), with_material({**_SMALL, "center": [0, 0, 0.4]},
                                                        {**flint, "priority": 1}),
             {"type": "sphere", "center": [-0.9, 0.2, 0.5], "radius": 0.5, "material": bubble}],
            spectrum={"bands": _BAND_COUNT}, **deep),
        "dispersion beside none": room([block, with_material(_BALL, {**blue, "priority": 1})],
                                       spectrum={"bands": 7, "group": 3}, **deep),
        "dispersive coat": _pair({**constant, "transmission": 0.0, "fresnel": True}, _MATTE,
                                 spectrum={"bands": 7, "group": 3}, **deep),
        "camera in dispersive glass": room([with_material({**_BALL, "center": [0, 0, 8.3]}, flint)],
                                           spectrum={"bands": _BAND_COUNT}, **deep),
        "dispersive glass in RGB": _pair(glass, bands=None, **deep),
    }  # fmt: skip
