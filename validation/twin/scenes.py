"""Small scenes that together hold every primitive and every term of the image model."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from clrt.base.errors import ClrtWarning
from clrt.base.scratch import scratch
from clrt.flatten.flatten import FlatScene, flatten
from clrt.formats import load_dict
from clrt.images.file import write
from clrt.scene.scene import Scene

from .media_scenes import media, media_within
from .mip_scenes import at_levels
from .spectral_scenes import dispersion, dispersion_beside, dispersion_within, metals
from .variants import numbers, with_sky

Table = dict[str, Any]

_GLASS: Table = {
    "diffuse": 0.05, "specular": 0.4, "shininess": 80, "fresnel": True, "transmission_color": [0.9, 1, 0.8],
}
_PLAIN_GLASS: Table = {"diffuse": 0.1, "reflection": 0.2, "transmission": 0.7, "ior": "diamond"}
_MIRROR: Table = {
    "color": [0.2, 0.3, 0.1], "specular": 0.6, "reflection": 0.7, "reflection_color": [1, 0.8, 0.5],
}
_SCHLICK: Table = {
    "diffuse": 0.1, "specular": 0.8, "highlight_color": [0.9, 0.6, 0.3], "shininess": 12.5,
    "reflection": 0.9, "reflection_color": [0.95, 0.6, 0.2], "fresnel": "schlick",
}
_MATT: Table = {"color": [0.7, 0.5, 0.3], "ambient": 0.8, "emission": [0.01, 0.02, 0.05]}
_CHECKER: Table = {
    "color": {"type": "checker", "colors": [[0.9, 0.8, 0.1], 0.2], "size": 0.37}, "specular": 0.2,
}
_THIN: Table = {"diffuse": 0.1, "fresnel": True, "thin": True, "transmission_color": [0.5, 0.9, 0.6]}
_FLOOR: Table = {"type": "plane", "point": [0, -1.2, 0], "normal": [0.02, 1, 0.01], "material": _CHECKER}
# 126 times as long as wide: rays leave it by more than its corners ask for
_SHARD_CORNERS = [[-1, -0.5, 0.9], [1, 0.5, 0.5], [0.3, 0.17, 0.64]]
_SHARD: Table = {"type": "mesh", "vertices": _SHARD_CORNERS, "faces": [[0, 1, 2]]}
_LIGHTS: list[Table] = [
    {"type": "point", "position": [3, 4, 5], "intensity": [30, 28, 25], "falloff": "inverse-square"},
    {"type": "directional", "direction": [1, -2, -0.7], "intensity": 0.4},
    {"type": "point", "position": [-4, 1, 2], "intensity": [0.1, 0.2, 0.4]},
]
_CAMERA: Table = {"origin": [0.3, 0.6, 4.2], "target": [0, -0.1, 0], "width": 36, "height": 27}


def _quadrics() -> Table:
    bent = [{"rotate": [[1, 0, 0], 30]}, {"translate": [0.4, 1, -0.5]}]
    saddle = {
        "coefficients": [1, -1, 1, 0.1, 0, 0.05, 0, 0, 0, -0.08], "clip": [[-1, -0.5, -1], [1, 0.5, 1]],
    }
    unbounded = [0.1, 0.1, 0, 0, 0, 0, 0, 0, 0.5, 3]
    rod = {"p0": [-1.3, -1, 0.2], "p1": [-1, 0.1, 0.4], "radius": 0.3, "caps": True}
    spike = {"p0": [0, -1.1, 0.4], "r0": 0.5, "p1": [0.1, 0.6, 0.3], "r1": 0}
    stump = {"p0": [1, -1, 1], "r0": 0.3, "p1": [1.1, -0.6, 1], "r1": 0.1, "caps": True}
    dish = {"apex": [1.2, -0.4, 0], "axis": [0.1, 1, 0.2], "focal": 0.15, "height": 0.8}
    return {"shapes": [
        {"type": "ellipsoid", "center": [-1.5, 0.7, 0], "radii": [0.5, 0.3, 0.6], "material": _GLASS},
        {"type": "cylinder", **rod, "material": _MATT},
        {"type": "cone", **spike, "material": _SCHLICK},
        {"type": "cone", **stump, "material": _GLASS},
        {"type": "paraboloid", **dish, "material": _MIRROR},
        {"type": "quadric", **saddle, "transform": bent, "material": _MATT},
        {"type": "quadric", "coefficients": unbounded, "material": _MATT},
    ]}


def _flat() -> Table:
    arrow = [[-1.2, -0.6, 0.3], [-0.2, -0.7, 0.3], [-0.1, 0.9, 0.3], [-0.6, -0.1, 0.3], [-1.1, 0.8, 0.3]]
    sheet = [[-0.4, -1, 1.4], [1.2, -1, 1.2], [1.1, 0.7, 1.1]]
    disk = {"type": "disk", "center": [1, 0.4, -0.6], "normal": [-4, 1, 10], "radius": 0.7}
    return {"shapes": [
        _FLOOR, {"type": "polygon", "points": arrow, "material": _SCHLICK},
        {"type": "polygon", "points": sheet, "material": _THIN},
        {**disk, "material": _CHECKER},
        {"type": "box", "min": [-0.3, -1.1, -0.8], "max": [0.7, 0.1, 0.2], "material": _PLAIN_GLASS,
         "transform": [{"rotate": [[0.2, 1, 0], 25]}, {"scale": [1.1, 0.9, -1]}]},
        {"type": "plane", "point": [0, 0, -3], "normal": [0, 0.1, 1], "material": _MIRROR},
    ]}


def _spheres() -> Table:
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": _GLASS}
    globe = {**_CHECKER, "color": {"type": "checker", "divisions": 7}}
    return {"shapes": [
        ball, {**ball, "center": [0, 0, 0.1], "radius": 0.6, "material": {**_PLAIN_GLASS, "ior": 1.0}},
        {"type": "sphere", "center": [1, 0.6, -1.5], "radius": 0.8, "material": globe},
        {"type": "sphere", "center": [0.3, 0.1, 0], "radius": 0.4, "material": _SCHLICK,
         "transform": [{"rotate": [[0, 1, 0], 40]}, {"scale": [2, 2, 2]}, {"translate": [-1.9, 0.2, -0.5]}]},
        {"type": "sphere", "center": [0, 0, 0], "radius": 0.5, "material": _MATT,
         "transform": [{"scale": [0.4, 1.5, 0.7]}, {"translate": [1.3, -0.3, 0.6]}]},
        {"type": "sphere", "center": [-0.9, -0.8, 0.9], "radius": 0.35, "material": _MIRROR}, _FLOOR,
    ]}


def _rings(rows: int, columns: int) -> Table:
    """A sphere of quads and triangles, coarse enough that shading normals and faces disagree much."""
    angle = [(math.pi * i / rows, 2 * math.pi * j / columns) for i in range(1, rows) for j in range(columns)]
    points = [[math.sin(a) * math.cos(b), math.cos(a), math.sin(a) * math.sin(b)] for a, b in angle]
    top, bottom = len(points), len(points) + 1
    faces: list[list[int]] = []
    for j in range(columns):
        k = (j + 1) % columns
        faces += [[top, k, j], [bottom, top - columns + j, top - columns + k]]
        starts = [row * columns for row in range(rows - 2)]
        faces += [[at + j, at + k, at + columns + k, at + columns + j] for at in starts]
    return {"type": "mesh", "vertices": [*points, [0, 1, 0], [0, -1, 0]], "faces": faces}


def _meshes() -> Table:
    def at(x: float, y: float, scale: float) -> list[Table]:
        return [{"scale": [scale] * 3}, {"translate": [x, y, 0]}]

    return {"shapes": [
        _FLOOR, {**_rings(4, 5), "smooth": True, "material": _GLASS, "transform": at(-0.9, -0.1, 0.8)},
        {**_rings(5, 6), "material": _PLAIN_GLASS, "transform": at(0.8, 0.4, 0.7)},
        {**_rings(3, 3), "smooth": True, "material": _MIRROR, "transform": at(0.6, -0.9, 0.4)},
        {**_rings(3, 4), "smooth": True, "material": _SCHLICK, "transform": [{"scale": [-0.4, 0.5, 0.4]}]},
        {**_SHARD, "material": _MIRROR}, {**_SHARD, "material": _GLASS, "transform": at(0.4, 0.3, 0.8)},
    ]}


def _inside_glass() -> Table:
    """Under water with bubbles, below the surface: total internal reflection, with and without Fresnel."""
    air = {**_GLASS, "ior": "air"}
    nested = {"type": "sphere", "center": [0.9, 0, 0.2]}
    return {
        "medium_ior": 1.333, "depth_color": [0.3, 0.1, 0.2], "max_depth": 3, "min_weight": 0.02,
        "camera": {**_CAMERA, "spp": 4, "jitter": 5},
        "shapes": [
            {"type": "sphere", "center": [-0.7, 0, 0], "radius": 0.8, "material": air},
            {**nested, "radius": 0.7, "material": {**_PLAIN_GLASS, "ior": 1.0}},
            {**nested, "radius": 0.5, "material": {**_PLAIN_GLASS, "reflection": 0}},
            {"type": "plane", "point": [0, 1.4, 0], "normal": [0, -1, 0], "material": air},
            _FLOOR,
        ],
    }


def _tinted() -> Table:
    panes = [
        {
            "type": "disk", "center": [0.1 * i, 0.5 + 0.3 * i, 0.4], "normal": [0.3, 1, 0.2], "radius": 1.2,
            "material": {**_THIN, "transmission_color": [0.9, 1 - 0.3 * i, 0.2 + 0.3 * i]},
        }
        for i in range(3)
    ]
    return {"shadow": "tinted", "shapes": [
        *panes, _FLOOR, {"type": "sphere", "center": [0.7, 0, 0], "radius": 0.6, "material": _GLASS},
        {"type": "sphere", "center": [-0.9, 0.2, 0], "radius": 0.5, "material": _MATT},
    ]}


def _ambient() -> Table:
    camera = {**_CAMERA, "width": 20, "height": 15, "jitter": 11}
    mirror, glass = {**_MIRROR, "diffuse": 0.5}, {**_PLAIN_GLASS, "ambient": 0.5}
    return {"ambient_samples": 5, "max_depth": 3, "camera": camera, "shapes": [
        _FLOOR, {"type": "sphere", "center": [-0.7, 0, 0], "radius": 0.8, "material": mirror},
        {"type": "sphere", "center": [0.8, -0.2, 0.3], "radius": 0.6, "material": glass},
    ]}


def _rough() -> Table:
    """Every kind of mirror, rough: on balls, coarse smooth meshes and within each other's reflections."""
    def at(x: float, y: float, scale: float) -> list[Table]:
        return [{"scale": [scale] * 3}, {"translate": [x, y, 0]}]

    gold = {"diffuse": 0.0, "conductor": {"eta": 0.2, "k": 3.1}, "roughness": 0.3}
    coat = {"fresnel": True, "transmission": 0.0, "ior": 1.7, "roughness": 0.5, "reflection": 0.9}
    ball = {"type": "sphere", "radius": 0.5}
    return {"camera": {**_CAMERA, "spp": 4, "jitter": 4}, "max_depth": 3, "shapes": [
        {**_FLOOR, "material": {**_MIRROR, "roughness": 0.15}},
        {**ball, "center": [-1.2, 0.3, 0], "material": {**_SCHLICK, "roughness": 1.0}},
        {**ball, "center": [0, 0.6, -0.4], "material": gold},
        {**ball, "center": [1.2, 0.3, 0], "material": coat},
        {**_rings(4, 5), "smooth": True, "material": {**gold, "roughness": 0.7},
         "transform": at(-0.7, -0.6, 0.5)},
        {**_rings(3, 4), "smooth": True, "material": {**_MIRROR, "roughness": 0.009},
         "transform": at(0.6, -0.7, 0.4)},
    ]}


def _one_sided() -> Table:
    flat, meshes = _flat()["shapes"][1:4], _meshes()["shapes"][2:]
    return {"one_sided": "opaque", "shapes": [*_quadrics()["shapes"], *flat, *meshes]}


def _counted() -> Table:
    return {**_spheres(), "conformance": "spd", "one_sided": "opaque", "max_depth": 3}


def _orthographic() -> Table:
    view = {"type": "orthographic", "size": 4, "near": 0.5, "mirror": True, "shift": [-0.5, 0.25]}
    camera = {**_CAMERA, **view}
    return {**_spheres(), "camera": camera}


def _lens() -> Table:
    """Wide open, near in focus, beyond the near plane and before it."""
    return {**_flat(), "camera": {**_CAMERA, "aperture": 0.25, "near": 0.3, "jitter": 9, "mirror": True}}


def _filter() -> Table:
    """Weights of both signs, some of which cancel."""
    return {**_flat(), "camera": {**_CAMERA, "filter": "mitchell", "spp": 4, "jitter": 9}}


def _orthographic_lens() -> Table:
    camera = {**_orthographic()["camera"], "aperture": 0.3, "focus": 3.1, "spp": 4}
    return {**_spheres(), "camera": camera}


def _sky() -> Table:
    camera = {**_CAMERA, "near": 1.0, "fov": 110, "fov_axis": "vertical", "mirror": True}
    return {"camera": camera, "shapes": [
        {"type": "sphere", "center": [0, 0, 1], "radius": 1, "material": {**_MIRROR, "reflection": 0.9}},
        {"type": "ellipsoid", "center": [-2, 0, 0.5], "radii": [1, 0.3, 0.5], "material": _GLASS}]}


def _lamps() -> Table:
    """Every kind of light, on surfaces that scatter in every way."""
    spot = {"type": "spot", "position": [2, 3, 4], "target": [0, 0, 0]}
    disk = {"type": "disk", "center": [-0.5, 1, -0.3], "normal": [0.2, -0.3, -0.1], "radius": 0.5}
    lights = [
        {**spot, "intensity": [0.5, 0.6, 0.7]},
        {**spot, "angle": 9, "penumbra": 0, "intensity": [20, 8, 8], "falloff": "inverse-square"},
        {**spot, "position": [0.3, -0.1, 0], "angle": 90, "penumbra": 1, "intensity": 0.4},
        {"type": "rectangle", "center": [-1, 1.2, 1], "u": [0.7, 0, 0.2], "v": [0.1, 0.2, 0.6], "samples": 4},
        {**disk, "samples": 3, "two_sided": True},
        {"type": "sphere", "center": [1.5, 0.5, 1.7], "radius": 0.4, "radiance": [3, 4, 5], "samples": 5},
        # around the camera and all that it sees, shining inwards
        {"type": "sphere", "center": [0.5, 0, 0], "radius": 9, "radiance": 0.2, "samples": 1,
         "two_sided": True},
        {"type": "sphere", "center": [-0.9, -0.8, 0.9], "radius": 0.5, "samples": 2, "visible": False},
    ]  # fmt: skip
    shapes = [*_spheres()["shapes"][1:], *_meshes()["shapes"][3:]]
    return {"lights": lights, "max_depth": 3, "camera": {**_CAMERA, "spp": 4}, "shapes": shapes}


def _lamps_gathered() -> Table:
    """Lights seen by ambient rays, through glass, in mirrors, from within."""
    panel = {"type": "rectangle", "center": [-0.5, 1, 0.5], "u": [0.7, 0, 0.2], "v": [0, 0.2, 0.6]}
    lights = [{**panel, "samples": 2}, {"type": "sphere", "center": [0.3, 0.9, 5.5], "radius": 0.5,
                                        "samples": 2, "radiance": [0.3, 0.2, 0.1], "two_sided": True}]
    camera = {**_CAMERA, "spp": 4, "jitter": 3, "width": 16, "height": 12}
    return {**_tinted(), "lights": lights, "ambient_samples": 3, "max_depth": 2, "camera": camera}


def _textured(name: str, **keys: Any) -> Table:
    return {"type": "image", "file": f"{name}.exr", **keys}


def _pictures() -> Table:
    """Every shape, wrap, filter and colour, smooth and flat meshes, maps of normals on all of them."""
    map_of = {"file": "normals.exr"}
    tiled = {"color": _textured("colors", scale=[2.3, -1.7], offset=[0.4, 0.1]), "normal_map": map_of}
    near = {"color": _textured("colors", filter="nearest", wrap="mirror", scale=[3, 2])}
    clamped = {"color": _textured("colors", wrap="clamp", offset=[0.3, -0.2]), "specular": 0.5,
               "highlight_color": _textured("colors"), "normal_map": {**map_of, "scale": -1.5, "placement": {
                   "scale": [1.6, -2.1], "offset": [0.2, 0.7], "wrap": "mirror"}}}
    shiny = {**_SCHLICK, "reflection_color": _textured("colors", wrap="mirror"), "normal_map": map_of}
    lit = {"emission": _textured("colors", encoding="srgb"), "roughness": 0.3, "reflection": 0.4}
    glass = {**_THIN, "transmission_color": _textured("colors")}
    uv = [[0.31 * i, 0.7 - 0.17 * i * i] for i in range(22)]
    smooth = {**_rings(5, 5), "uv": uv[:22], "smooth": True}
    shapes = [
        {**shape, "material": (tiled, near, clamped, shiny, lit, glass)[number % 6]}
        for number, shape in enumerate([*_quadrics()["shapes"], *_flat()["shapes"], *_spheres()["shapes"]])
    ]
    return {"max_depth": 3, "shapes": [
        *shapes,
        {**smooth, "material": tiled, "transform": [{"scale": [-0.5, 0.6, 0.5]}, {"translate": [0, 1, 0]}]},
        {**smooth, "smooth": False, "material": shiny, "transform": [{"translate": [1.9, 1, -1]}]},
        {**_rings(3, 3), "material": _MATT, "transform": [{"translate": [-2, 1, -1]}]},
    ]}


def _pictures_dispersed() -> Table:
    """In lists of media, bands, narrow rays, tinted shadows and ambient rays."""
    glass = {**_GLASS, "ior": "SF10", "transmission_color": _textured("colors")}
    camera = {**_CAMERA, "width": 16, "height": 12}
    floor = {**_FLOOR, "material": {"color": _textured("colors"), "emission": _textured("colors")}}
    return {
        "spectrum": {"bands": 5, "group": 2}, "shadow": "tinted", "ambient_samples": 2, "max_depth": 3,
        "camera": camera, "shapes": [
            floor, {"type": "sphere", "center": [0, 0, 0], "radius": 0.8, "material": glass},
            {"type": "sphere", "center": [0.7, 0, 0], "radius": 0.6, "material": glass},
            {"type": "sphere", "center": [-0.9, 0.2, 0.7], "radius": 0.3, "material": floor["material"]},
        ],
    }


def _empty() -> Table:
    return {"lights": [], "shapes": []}


_SCENES = {
    "spheres": _spheres, "flat shapes": _flat, "quadrics": _quadrics, "meshes": _meshes,
    "inside glass": _inside_glass, "media": media, "media from within": media_within,
    "tinted shadows": _tinted, "ambient samples": _ambient, "lights": _lamps,
    "lights gathered": _lamps_gathered,
    "one-sided": _one_sided, "counted rays": _counted, "orthographic": _orthographic, "sky image": _sky,
    "rough mirrors": _rough, "lens": _lens, "orthographic lens": _orthographic_lens, "filter": _filter,
    "nothing": _empty, "pictures": _pictures, "pictures dispersed": _pictures_dispersed,
    "pictures at levels": lambda: at_levels(_pictures()),
    "levels dispersed": lambda: at_levels(_pictures_dispersed()),
    "metals": metals, "dispersion": dispersion, "dispersion from within": dispersion_within,
    "dispersion beside none": dispersion_beside,
}  # fmt: skip


def scenes() -> dict[str, tuple[Scene, FlatScene]]:
    """Name -> the scene and its arrays (those of the sky hold an image that the scene does not name)."""
    light = {"ambient": [0.2, 0.25, 0.3], "background": [0.1, 0.2, 0.4], "lights": _LIGHTS}
    common = {**light, "max_depth": 4, "camera": _CAMERA}
    out = {}
    with scratch() as folder, warnings.catch_warnings():
        _write_pictures(folder)
        warnings.simplefilter("ignore", ClrtWarning)  # glass that makes light and overlaps is right here
        for name, table in _SCENES.items():
            scene = load_dict({**common, **table()}, folder=folder)
            flat = flatten(scene)
            out[name] = scene, with_sky(flat) if name == "sky image" else flat
    return out


def _write_pictures(folder: Path) -> None:
    """Pictures of 11 x 7 colours, and of normals of which some lean beyond the horizon."""
    colors = numbers(11 * 7 * 3).reshape(7, 11, 3)
    write(folder / "colors.exr", [np.ascontiguousarray(colors[:, :, ::-1])])
    write(folder / "normals.exr", [colors])
