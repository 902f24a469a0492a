"""One term of the model a case, so that a fault in it shows there and nearly nowhere else."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .parts import CAMERA, CLOSED, FLOOR, LIGHTS, Place, Table, room, slanting, with_material

_MATTE: Table = {"color": [0.6, 0.5, 0.4], "diffuse": 0.7}
_GLASS: Table = {"color": 0.3, "diffuse": 0.1, "reflection": 0.15, "transmission": 0.75}
_SHINY: Table = {**_MATTE, "specular": 0.35, "shininess": 40}


def scenes() -> Iterator[tuple[str, Table, set[str]]]:
    """Name, scene and what nobody can see from the scene's tables."""
    for name, table in {**_local(), **_bounces(), **_lights(), **_settings()}.items():
        yield name, table, set()
    yield "light behind", _behind(), {"light behind the surface"}
    yield "light behind, tinted", _behind(transmission=0.4, thin=True), {"light behind the surface"}
    yield "equal distances", ties(), {"equal distances"}


def _pair(material: Table, other: Table | None = None, **changes: Any) -> Table:
    """A ball of a material before the wall, and a smaller one that casts a shadow on it."""
    ball = {"type": "sphere", "center": [-0.3, -0.4, 0], "radius": 1.7}
    small = {"type": "sphere", "center": [1.3, 1.3, 1.6], "radius": 0.6}
    return room([with_material(ball, material), with_material(small, other or _MATTE)], **changes)


def _local() -> dict[str, Table]:
    """What a hit sends back by itself."""
    checker = {"type": "checker", "colors": [[0.7, 0.6, 0.5], [0.4, 0.5, 0.6]]}
    flat = {"color": {**checker, "size": 0.83}, "diffuse": 0.8}
    return {
        "ambient": _pair({"color": [0.8, 0.6, 0.4], "ambient": 0.7, "diffuse": 0.0}, lights=[]),
        "ambient by default": _pair({"color": [0.8, 0.6, 0.4], "diffuse": 0.6}),
        "emission": _pair({"emission": [0.3, 0.2, 0.1], "diffuse": 0.1}),
        "diffuse": _pair({"color": [0.9, 0.5, 0.2], "diffuse": 0.8, "ambient": 0.0}),
        "highlight": _pair({**_SHINY, "highlight_color": [1, 0.7, 0.4]}),
        "sharp highlight": _pair({**_SHINY, "shininess": 250, "specular": 0.5}),
        "broad highlight": _pair({**_SHINY, "shininess": 2.5, "diffuse": 0.2, "specular": 0.4}),
        "flat highlight": _pair({**_SHINY, "shininess": 0, "specular": 0.1, "diffuse": 0.4}),
        "checkered sphere": _pair({"color": {**checker, "divisions": 10}, "diffuse": 0.8}),
        "checkered plane": room([{"type": "plane", "point": [0.3, -2.2, 0.1], "normal": [0.05, 1, 0.1],
                                  "material": flat}]),
        "checkered disk": room([{"type": "disk", "center": [0.2, 0.1, 0], "normal": [0.3, 0.2, -1],
                                 "radius": 2.2,
                                 "material": flat}]),
        "checkered polygon": room([with_material(
            slanting([(-2, -1.8), (2, -1.7), (1.5, 1.9), (-1.6, 1.6)], 0.1, 0.05), flat)]),
    }  # fmt: skip


def _bounces() -> dict[str, Table]:
    """What a hit passes on."""
    metal = {"color": 0.3, "diffuse": 0.1, "reflection_color": [0.9, 0.6, 0.3], "fresnel": "schlick"}
    gold = {"diffuse": 0.0, "conductor": {"eta": 0.2, "k": 3.1}}
    coat = {"color": 0.3, "diffuse": 0.2, "fresnel": True, "transmission": 0.0, "ior": 1.6}
    return {
        "rough mirror": _pair({"color": 0.3, "diffuse": 0.1, "reflection": 0.8, "roughness": 0.3,
                               "reflection_color": [0.9, 0.8, 0.7]}),
        "rough metal": _pair({**gold, "roughness": 0.2}, {**gold, "roughness": 0.6, "reflection": 0.9}),
        "rough metal, 4 samples": _pair({**gold, "roughness": 0.3}, max_depth=2, camera={
            **CAMERA, "spp": 4, "jitter": 2, "width": 80, "height": 60}),
        "rough coat": _pair({**coat, "roughness": 0.25}, medium_ior=1.2),
        "rough schlick": _pair({**metal, "reflection": 0.8, "roughness": 0.4}),
        "rough smooth mesh": room([with_material(CLOSED["smooth mesh"]((0, 0, 0), 1.8),
                                                 {**gold, "roughness": 0.5})]),
        "mirror": _pair({"color": 0.3, "diffuse": 0.1, "reflection": 0.8}),
        "tinted mirror": _pair({"color": 0.3, "diffuse": 0.1, "reflection": 0.8,
                                "reflection_color": [1, 0.7, 0.4]}),
        "schlick mirror": _pair({**metal, "reflection": 0.9}),
        "schlick highlight": _pair({**metal, "specular": 0.8, "shininess": 5,
                                    "highlight_color": [0.8, 0.4, 0.1]}),
        "transmission": _pair({"diffuse": 0.0, "transmission": 0.85}),
        "tinted transmission": _pair({"diffuse": 0.0, "transmission": 0.9,
                                      "transmission_color": [1, 0.8, 0.5]}),
        "both": _pair(_GLASS),
        "fresnel": _pair({"diffuse": 0.0, "fresnel": True, "ior": 1.7}),
        "fresnel shares": _pair({"diffuse": 0.1, "fresnel": True, "reflection": 0.6, "transmission": 0.8,
                                 "ior": 2.0}),
        "thin": _pair({"color": 0.3, "diffuse": 0.1, "fresnel": True, "thin": True, "ior": 2.2,
                       "transmission_color": [0.9, 1, 0.8]}),
        "thin, constant": _pair({**_GLASS, "thin": True}),
        "equal indices": _pair({**_GLASS, "ior": 1.0, "fresnel": True, "transmission": 0.8}),
        "mirror in the dark": _pair({"diffuse": 0.0, "reflection": 0.9}, lights=[], ambient=0.5),
    }  # fmt: skip


def _lights() -> dict[str, Table]:
    point: Table = {"type": "point", "position": [-3, 5, 6]}
    sun: Table = {"type": "directional", "direction": [0.5, -0.9, -0.8]}
    panes = [
        {"type": "disk", "center": [-1.2 + 1.1 * i, 1.6, 1.0], "normal": [-0.4, 0.8, 0.9], "radius": 0.8,
         "material": {"diffuse": 0.1, "fresnel": True, "thin": True,
                      "transmission_color": [1 - 0.3 * i, 0.8, 0.4 + 0.3 * i]}}
        for i in range(3)
    ]  # fmt: skip
    crossed = [*panes, {"type": "disk", "center": [-0.4, 2.2, 1.8], "normal": [-0.4, 0.8, 0.9], "radius": 0.9,
                        "material": {"diffuse": 0.2, "transmission": 0.6, "thin": True}}]  # fmt: skip
    lens = {"type": "sphere", "center": [1.6, -0.9, 0.6], "radius": 0.8,
            "material": {"diffuse": 0.05, "fresnel": True, "transmission_color": [0.8, 1, 0.8]}}  # fmt: skip
    post = {"type": "cylinder", "p0": [-1.8, -2.4, 0], "p1": [-1.8, 0, 0], "radius": 0.3, "caps": True,
            "material": _MATTE}  # fmt: skip
    spot: Table = {"type": "spot", "position": [-3, 5, 6], "target": [-0.2, -0.3, 0.5]}
    spots = [{**spot, "angle": 17, "penumbra": 0.5, "intensity": [0.5, 0.7, 0.8]},
             {**spot, "position": [4, 5, 3], "angle": 24, "penumbra": 0, "intensity": [22, 15, 9],
              "falloff": "inverse-square"}]  # fmt: skip
    hidden: Table = {"visible": False}
    panel = {"type": "rectangle", "center": [-3, 4, 4], "u": [-0.2, 0.5, -0.8], "v": [1, 0, 0.4],
             "samples": 6, "radiance": [6, 5, 4], **hidden}  # fmt: skip
    plate = {"type": "disk", "center": [2.6, 0.4, 2], "normal": [1, 0.2, 0.3], "radius": 0.7, "samples": 5,
             "radiance": [1, 2, 3], "two_sided": True, **hidden}  # fmt: skip
    bulb = {"type": "sphere", "center": [1, 3, 3], "radius": 0.9, "samples": 4, "radiance": 2, **hidden}
    inside = {**bulb, "center": [0.7, 1.3, 1.6], "radius": 0.6, "radiance": 0.4}  # and a ball in it
    around = {"type": "sphere", "center": [0, 0, 0], "radius": 30, "samples": 3, "radiance": 0.3,
              "two_sided": True, **hidden}  # fmt: skip
    bright = {"diffuse": 0.4, "reflection": 0.5}
    four: Table = {"camera": {**CAMERA, "spp": 4, "jitter": 2, "width": 80, "height": 60}}
    mesh = {"type": "mesh", "vertices": [[0.5, -2.2, 1], [2.6, -2.1, -0.3], [1.7, 0.9, 0.4], [1.5, -2, -1.2]],
            "faces": [[0, 1, 2], [1, 3, 2], [3, 0, 2]], "material": _MATTE}  # fmt: skip
    sheet = with_material(slanting([(-2.4, -1.4), (-0.9, -1.3), (-0.7, 0.9), (-2.3, 1.1)], 0.2, 0.3), _MATTE)
    pane = {**slanting([(-0.6, 0.4), (1.1, 0.2), (1.4, 1.9), (-0.4, 2.1)], 0.3, 1.4),
            "material": panes[1]["material"]}  # fmt: skip
    # few of each kind between points and lamp: what a shaft finds is met alone, without the tree
    standing = [mesh, sheet, pane, crossed[0], crossed[3], lens, post]
    wide = {**panel, "radiance": [50, 45, 40]}
    return {
        "what stands before a rectangle": room(standing, lights=[wide], max_depth=1),
        "what stands before a rectangle, tinted": room(standing, lights=[wide, {**bulb, "radiance": 4}],
                                                       max_depth=1, shadow="tinted"),
        "rectangle": _pair(_SHINY, lights=[panel]),
        "disk and sphere": _pair(_SHINY, lights=[plate, {**bulb, "radiance": 1.5}, inside]),
        "within a sphere of light": _pair(_SHINY, lights=[around]),
        "lights that are seen": _pair(bright, lights=[
            {**plate, "visible": True, "radiance": [0.7, 0.9, 0.8]},
            {**bulb, "center": [-2, 1, 1.5], "visible": True, "radiance": 0.8},
            {**panel, "center": [1.4, 2, -1], "u": [1, 0.2, 0], "v": [0, 0.6, 0.4], "visible": True,
             "radiance": [0.9, 0.8, 0.7]}]),
        "lights seen from all sides": _pair(
            {**_GLASS, "specular": 0.3}, ambient_samples=2, max_depth=3, **four, lights=[
                {**around, "radius": 12, "visible": True, "samples": 2},
                {**plate, "visible": True, "samples": 2},
                {**panel, "center": [-1.7, 1.4, 1.8], "u": [0.5, 0, 0], "v": [0, -0.4, 0], "visible": True,
                 "samples": 2, "radiance": 0.6}]),
        "lights with extent in mirrors": _pair(bright, lights=[panel, bulb], max_depth=2, **four),
        "lights with extent and ambient rays": _pair(_MATTE, lights=[plate, around], ambient_samples=2,
                                                     max_depth=1, **four),
        "spots": _pair(_SHINY, lights=spots),
        "spots on matte": _pair(_MATTE, lights=spots),
        "point light": _pair(_SHINY, lights=[{**point, "intensity": [0.9, 0.8, 0.7]}]),
        "inverse square": _pair(_SHINY,
                                lights=[{**point, "intensity": [60, 55, 50], "falloff": "inverse-square"}]),
        "directional light": _pair(_SHINY, lights=[{**sun, "intensity": [0.7, 0.8, 0.6]}]),
        "five lights": _pair(_SHINY, lights=[
            {**point, "position": [x, 4, 5], "intensity": [0.1 + 0.02 * x, 0.2, 0.2 - 0.02 * x]} for x in (-4,
                                                                                                           -2,
                                                                                                           0,
                                                                                                           2,
                                                                                                           4)]),
        "light inside": _pair({**_MATTE, "transmission": 0.1},
                              lights=[*LIGHTS,
                                      {"type": "point", "position": [-0.3, -0.4, 0.2], "intensity": 0.3}]),
        "no light": _pair(_MATTE, lights=[], ambient=0.7),
        "tinted shadows": room([*crossed, lens, post], shadow="tinted", lights=[{**point, "intensity": 0.8}]),
        "glass blocks": room([*crossed, lens, post], lights=[{**point, "intensity": 0.8}]),
    }  # fmt: skip


def _settings() -> dict[str, Table]:
    """What holds for the whole scene."""
    table = {"type": "disk", "center": [0, -2.4, 0], "normal": [0, 1, 0], "radius": 5, "material": FLOOR}
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1.8}
    pane = slanting([(-2.2, -2), (2.2, -1.8), (2.4, 1.9), (-2, 2)], 0.1, 0.8)
    few = {"ambient_samples": 3, "max_depth": 2, "lights": LIGHTS[:1]}
    cone = {"type": "cone", "p0": [-1.6, -2, 0], "r0": 0.9, "p1": [-1.6, 1.8, 0.3], "r1": 0.3,
            "material": _MATTE}
    flat_mesh = {"type": "mesh",
                 "vertices": [[0.5, -2, 1], [2.7, -2, -0.5], [1.6, 1.5, 0.3], [1.6, -2, -1.5]],
                 "faces": [[0, 1, 2], [1, 3, 2], [3, 0, 2]], "material": _MATTE}  # fmt: skip
    facing = {"type": "disk", "center": [0, 1.2, 1], "normal": [0.5, 0.2, 1], "radius": 0.7,
              "material": _MATTE}
    back = {**facing, "center": [0.1, -1.2, 1], "normal": [0.3, 0.1, -1]}
    return {
        "depth colour": _pair(_GLASS, {**_GLASS, "reflection": 0.5}, max_depth=2,
                              depth_color=[0.9, 0.2, 0.5]),
        "no bounces": _pair(_GLASS, max_depth=0, depth_color=[0.2, 0.5, 0.3]),
        "one bounce": _pair({**_GLASS, "fresnel": True, "transmission": 1.0, "reflection": 1.0}, max_depth=1),
        "least weight": _pair({**_GLASS, "reflection": 0.4, "diffuse": 0.2,
                               "transmission_color": [0.7, 0.9, 1],
                               "reflection_color": [0.8, 1, 0.9]}, _GLASS, min_weight=0.2, max_depth=6),
        "medium": _pair({"diffuse": 0.05, "fresnel": True, "ior": "glass"}, medium_ior=1.333),
        "background": {**room([]), "background": [0.2, 0.5, 0.7],
                       "shapes": [with_material(ball, {"diffuse": 0.1, "reflection": 0.8}), table]},
        "one-sided": room([cone, flat_mesh, facing, back,
                           with_material({**ball, "center": [0, 0, 9]}, _MATTE)],
                          one_sided="opaque", lights=LIGHTS[:1]),
        "ambient rays": _pair(_MATTE, {"diffuse": 0.4, "reflection": 0.4}, **few),
        "ambient rays on a mesh": room([with_material(CLOSED["smooth mesh"]((0, -0.2, 0), 1.9), _MATTE)],
                                       **few),
        "ambient rays through glass": room([with_material(pane,
                                                          {"diffuse": 0.3, "transmission": 0.5,
                                                           "thin": True}),
                                            with_material(ball, _MATTE)], **few),
    }  # fmt: skip


def _behind(**changes: Any) -> Table:
    """Faces turned from a light: by their true normal, by their shading normal, and seen from behind."""
    material = {**_SHINY, **changes}

    def tent(x: float, lean: float) -> Table:
        points: list[Place] = [(x - 0.9, -1.8, 0), (x + 0.9, -1.8, 0.2), (x + 0.9, 1.6, lean + 0.2),
                               (x - 0.9, 1.6, lean)]
        normals = [[-0.8, 0.1, 0.6], [0.8, 0.1, 0.6], [0.8, 0.3, 0.6], [-0.8, 0.3, 0.6]]
        return {"type": "mesh", "vertices": points, "faces": [[0, 1, 2, 3]], "normals": normals,
                "material": material}

    low = {"type": "point", "position": [-7, -1.5, -1.2], "intensity": 0.5}
    aside = {"type": "directional", "direction": [-1, -0.1, -0.3], "intensity": 0.4}
    shadow = "tinted" if "transmission" in changes else "opaque"
    return room([tent(-2.2, -1.2), tent(0, 0.4), tent(2.2, 1.2)], lights=[low, aside], shadow=shadow)


def ties(moved: float = 0.0) -> Table:
    """Two squares, two disks and two triangles in the same place: the one that comes first is seen.

    moved: how far back the others are instead, where they are not seen either.
    """
    triangle = {"type": "mesh", "vertices": [[0.3, -1.8, 0.4], [2.7, -1.6, 0], [1.5, 0.1, 0.3]],
                "faces": [[0, 1, 2]]}
    square = slanting([(-2.6, -1.4), (-0.4, -1.5), (-0.5, 1.3), (-2.5, 1.4)], 0.2, -0.1)
    disk = {"type": "disk", "center": [1.5, 1.2, 0.2], "normal": [0.2, 0.3, 1], "radius": 1.1}
    lower, upper = {**_MATTE, "color": [0.7, 0.5, 0.2]}, {**_MATTE, "color": [0.2, 0.4, 0.7]}
    pairs = []
    for shape in (square, disk, triangle):
        other = {**shape, "transform": [{"translate": [0, 0, -moved]}]} if moved else shape
        pairs += [with_material(shape, lower), with_material(other, upper)]
    return room(pairs, camera={**CAMERA, "origin": [0.4, 0.6, 8.5]})
