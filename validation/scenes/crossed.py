"""Features that meet in one ray: dispersed rays and all that asks for their bands, what lies behind
boundaries that are not seen, cameras in media of every form. An audit's faults went unnoticed for want of
them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .parts import CAMERA, CLOSED, LIGHTS, OPAQUE, Table, room, with_material

HIDDEN, INSIDE, WITHIN = "invisible boundary", "camera in glass", "surface in a medium"
_CLEAR: Table = {"diffuse": 0.0, "fresnel": True}
_FLINT: Table = {**_CLEAR, "ior": {"sellmeier": {"B": [1.6, 0.25], "C": [0.02, 0.06]}}}
_WAVES = {"samples": [[390, 0.1], [450, 0.8], [520, 0.2], [600, 0.9], [680, 0.15], [740, 0.7]]}
_LENS: Table = {"type": "sphere", "center": [-0.3, 0.1, 2.0], "radius": 1.6, "material": _FLINT}
_CORNERS: list[list[float]] = [[-4, -2.3], [4, -2.3], [4, 4], [-4, 4]]


def scenes() -> Iterator[tuple[str, Table, set[str]]]:
    """Name, scene and what nobody can see from the scene's tables."""
    for name, table in _dispersed().items():
        yield name, table, set()
    yield "things behind hidden boundaries", _behind(), {HIDDEN, WITHIN}
    yield "metal in glass", _metal_in_glass(), {WITHIN}
    yield "camera in equal media", _in_equal_media(), {INSIDE}
    yield "camera in a paraboloid", _in_paraboloid(), {INSIDE, WITHIN}
    yield "camera in a clipped quadric", _in_clipped_quadric(), {INSIDE, WITHIN}
    yield "near plane in glass", _near_plane(), {INSIDE}


def _screen(z: float, material: Table) -> Table:
    """A rectangle in front of the wall."""
    return {"type": "polygon", "points": [[*corner, z] for corner in _CORNERS], "material": material}


def _dispersed() -> dict[str, Table]:
    """A lens that splits rays, before something whose own bands then count."""

    def seen(*shapes: Table, **changes: Any) -> Table:
        return room([_LENS, *shapes], **{"spectrum": {"bands": 6}, "lights": LIGHTS[:1], **changes})

    pane = {"color": 0.2, "diffuse": 0.1, "transmission": 0.8, "thin": True, "transmission_color": _WAVES}
    checker = {"color": {"type": "checker", "colors": ["patch-13", "patch-16"], "size": 0.7}, "diffuse": 0.9}
    pool = {"type": "box", "min": [-2.9, -2.2, -1.5], "max": [2.9, 2.6, 3.9],
            "material": {**_CLEAR, "ior": "water", "absorption": {**_WAVES, "scale": 0.3}}}  # fmt: skip
    sunk = {**_LENS, "material": {**_FLINT, "priority": 1}}
    things = [with_material(CLOSED["sphere"]((2.2, 0.3, 0.0), 0.9), {"color": "patch-15", "diffuse": 0.8})]
    return {
        "dispersion and tinted shadows": seen(_screen(-1.4, pane), shadow="tinted"),
        "dispersion and ambient rays": seen(_screen(-2.4, {"color": _WAVES, "diffuse": 0.4, "ambient": 0.9}),
                                            ambient_samples=2, max_depth=3),
        "dispersion and a sky": {"max_depth": 3, "background": "sky.exr", "lights": LIGHTS[:1],
                                 "ambient": 0.2, "camera": {**CAMERA, "origin": [3, 0.5, 7], "fov": 50},
                                 "shapes": [{**_LENS, "center": [0, 0, 0]}], "spectrum": {"bands": 6}},
        "dispersion and a checker": seen(_screen(-2.2, checker)),
        "dispersion in coloured water": room([pool, sunk, *things], spectrum={"bands": 6}, lights=LIGHTS[:1],
                                             max_depth=3),
    }  # fmt: skip


def _behind() -> Table:
    """A block of glass, in it a curtain of weaker glass that cannot be seen, and behind that a thing of each
    kind."""
    block = {"type": "box", "min": [-2.8, -1.9, -1.6], "max": [2.8, 1.9, 2.0],
             "material": {**_CLEAR, "ior": 1.25, "priority": 2}}  # fmt: skip
    curtain = {"type": "box", "min": [-2.6, -1.7, 1.2], "max": [2.6, 1.7, 1.7],
               "material": {**_CLEAR, "ior": 1.9, "priority": 1}}  # fmt: skip
    return room([block, curtain, with_material(CLOSED["sphere"]((-1.7, 0.1, 0.0), 0.9), OPAQUE["checker"]),
                 with_material(CLOSED["sphere"]((0.1, -0.6, 0.0), 0.8), OPAQUE["mirror"]),
                 with_material(CLOSED["smooth mesh"]((1.7, 0.3, 0.0), 1.0), OPAQUE["metal"])],
                shadow="tinted")  # fmt: skip


def _metal_in_glass() -> Table:
    """Clear, convex and alone but for the metal: only that asks which medium is before it."""
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 2.0, "material": {**_CLEAR, "ior": 1.6}}
    metal = {"color": 0.3, "diffuse": 0.05, "conductor": {"eta": [[400, 1.5], [700, 1.1]], "k": 1.2}}
    return room([ball, {"type": "sphere", "center": [0.3, -0.2, 0.3], "radius": 1.1, "material": metal}])


def _eye(**changes: Any) -> Table:
    return {**CAMERA, "origin": [1.6, 0.2, 7.0], "target": [0, 0, 0], "fov": 60, **changes}


def _things() -> list[Table]:
    return [with_material(CLOSED["sphere"]((-1.5, -0.4, 0.0), 1.1), OPAQUE["shiny"]),
            with_material(CLOSED["box"]((1.4, 0.2, 0.0), 1.3), OPAQUE["matte"])]  # fmt: skip


def _in_equal_media() -> Table:
    """Two balls of one priority about the camera: it entered the smaller one last, so that one holds."""
    large = {**_CLEAR, "ior": 1.15, "absorption": [0.02, 0.1, 0.2]}
    small = {**_CLEAR, "ior": 1.5, "absorption": [0.5, 0.2, 0.05]}
    about = [1.4, 0.1, 7.2]
    return room([{"type": "sphere", "center": about, "radius": 1.1, "material": small},
                 {"type": "sphere", "center": [1.2, 0.3, 6.8], "radius": 2.6, "material": large}, *_things()],
                camera=_eye(), lights=LIGHTS[:1])  # fmt: skip


def _in_paraboloid() -> Table:
    """It opens towards the scene; the eye lies near its wall."""
    cup = {"type": "paraboloid", "apex": [0, 0, 9], "axis": [0, 0, -1], "focal": 0.5, "height": 4.0,
           "material": {**_CLEAR, "ior": 1.3, "absorption": [0.15, 0.05, 0.02]}}  # fmt: skip
    return room([cup, *_things()], camera=_eye(), lights=LIGHTS[:1])


def _in_clipped_quadric() -> Table:
    """Within the form of both: beyond the end of one, though within its box in the world; between the
    other's."""
    form = [1, 1, 1, 0, 0, 0, 0, 0, 0, -4]
    moved = {"translate": [1.5, 0.1, 7.0]}
    at: Table = {"transform": [moved]}
    turned: Table = {"transform": [{"rotate": ["x", 40.0]}, moved]}
    beyond: Table = {"type": "quadric", "coefficients": form, "clip": [[-2, -2, -2], [2, 2, -1.2]], **turned,
              "material": {**_CLEAR, "ior": 1.4, "absorption": [0.6, 0.1, 0.3], "priority": 2}}  # fmt: skip
    between: Table = {"type": "quadric", "coefficients": [1, 1, 0, 0, 0, 0, 0, 0, 0, -0.7], **at,
               "clip": [[-1, -1, -0.8], [1, 1, 0.8]],
               "material": {**_CLEAR, "ior": 1.2, "absorption": [0.02, 0.1, 0.3], "priority": 1}}  # fmt: skip
    return room([beyond, between, *_things()], camera=_eye(), lights=LIGHTS[:1])


def _near_plane() -> Table:
    """Some rays start in the block, which the eye itself is far from, and meet a ball in it."""
    block = {"type": "box", "min": [0.3, -0.9, 4.6], "max": [1.8, 1.2, 5.9],
             "material": {**_CLEAR, "ior": 1.3, "absorption": [0.5, 0.1, 0.2]}}  # fmt: skip
    ball = {"type": "sphere", "center": [1.0, 0.2, 5.05], "radius": 0.3, "material": OPAQUE["matte"]}
    return room([block, ball, *_things()], camera={**CAMERA, "near": 3.0}, lights=LIGHTS[:1])
