"""Cameras and samples, and optics that take a place of their own: bubbles, prisms, mirrors of mirrors."""

from __future__ import annotations

from collections.abc import Iterator

from .parts import CAMERA, CLOSED, LIGHTS, Table, room, with_material

_MATTE: Table = {"color": [0.6, 0.5, 0.4], "diffuse": 0.7}
_MIRROR: Table = {"color": 0.3, "diffuse": 0.1, "reflection": 0.85, "reflection_color": [1, 0.95, 0.9]}
_GLASS: Table = {"diffuse": 0.0, "fresnel": True, "ior": "glass"}
_CONSTANT: Table = {"color": 0.3, "diffuse": 0.1, "transmission": 0.8, "ior": "glass"}
INTERNAL = "total internal reflection"


def scenes() -> Iterator[tuple[str, Table, set[str]]]:
    """Name, scene and what nobody can see from the scene's tables."""
    for name, changes in _CAMERAS.items():
        said = {"fov"} if "K" in changes else set()
        said |= {"origin", "target"} if "pose" in changes else set()
        yield name, _things({key: CAMERA[key] for key in CAMERA if key not in said} | changes), set()
    for name, table in _internal().items():
        yield name, table, {INTERNAL}
    yield "under water", _under_water(), {INTERNAL, "camera in glass"}
    yield "facing mirrors", _facing_mirrors(), {"deep mirrors"}
    yield "corner of mirrors", _corner(), {"deep mirrors"}
    yield "nested glass", _nested(), set()
    yield "sky image", _sky("sky.exr"), set()
    yield "studio image", _sky("studio.exr"), set()
    adaptive = {"spp": 16, "threshold": 0.003}
    yield "adaptive", {**_things(CAMERA), "adaptive": adaptive}, set()
    yield "image through glass", _sky("sky.exr", {"diffuse": 0.0, "transmission": 0.9}), set()


_CAMERAS: dict[str, Table] = {
    "vertical view": {"fov": 34, "fov_axis": "vertical"},
    "wide view": {"fov": 95, "origin": [0.3, 0.4, 4.2]},
    "orthographic": {"type": "orthographic", "size": 6.2},
    "orthographic, vertical": {"type": "orthographic", "size": 4.4, "fov_axis": "vertical", "near": 1.0},
    "mirrored camera": {"mirror": True},
    "shifted camera": {"shift": [-0.5, 0.37]},
    "slanting camera": {"up": [0.4, 1, 0.3], "origin": [1.5, 2, 8]},
    "camera from above": {"origin": [0.5, 9, 0.8], "target": [0.5, 0, 0.8]},
    "near": {"near": 5.0},
    "4 samples": {"spp": 4},
    "4 jittered samples": {"spp": 4, "jitter": 7},
    "jittered": {"jitter": 3},
    "16 samples": {"spp": 16},
    "16 jittered samples": {"spp": 16, "jitter": 12},
    "64 samples": {"spp": 64},
    "lens": {"aperture": 0.03, "focus": 6.5},
    "lens beyond near": {"aperture": 0.04, "near": 3.0, "mirror": True, "shift": [2, -1], "spp": 4,
                         "jitter": 2},
    "pose and oblong pixels": {
        "pose": [[0.8, 0, 0.6, -5.1], [0.36, -0.8, -0.48, 4.08], [0.48, 0.6, -0.64, 5.44], [0, 0, 0, 1]],
        "K": [[215, 0, 70], [0, 180, 66.5], [0, 0, 1]],
    },
    "K and a lens": {"K": [[190, 0, 90], [0, 230, 55], [0, 0, 1]], "aperture": 0.03, "focus": 6.5,
                     "spp": 4, "jitter": 5},
    "orthographic lens": {"type": "orthographic", "size": 6.2, "aperture": 0.03, "focus": 7.0, "near": 0.5},
    "tent": {"spp": 9, "filter": "tent"},
    "gaussian": {"spp": 9, "filter": "gaussian", "jitter": 5},
    "mitchell": {"spp": 16, "filter": "mitchell"},
}


def _things(camera: Table) -> Table:
    """Something of each kind, nothing symmetrical."""
    shapes = [
        with_material(CLOSED["sphere"]((-1.4, -0.2, 0.3), 1.0),
                      {**_MATTE, "specular": 0.3, "reflection": 0.3}),
        with_material(CLOSED["box"]((1.3, 0.3, 0.0), 1.1), {"color": [0.3, 0.5, 0.6], "diffuse": 0.8}),
        with_material(CLOSED["ellipsoid"]((0.2, -1.4, 1.4), 0.7), {**_GLASS, "ior": 1.2, "diffuse": 0.2}),
    ]
    return room(shapes, camera=camera, max_depth=3)


def _internal() -> dict[str, Table]:
    """Rays that cannot leave: bubbles and prisms, with Fresnel's shares and with constant ones."""
    bubble: Table = {"type": "sphere", "center": [0, 0, 0], "radius": 1.9}
    prism: Table = {
        "type": "mesh",
        "vertices": [[x, y, z] for z in (1.2, -1.2) for x, y in ((-2, -1.5), (2, -1.2), (0.2, 1.8))],
        "faces": [[0, 1, 2], [5, 4, 3], [0, 3, 4, 1], [1, 4, 5, 2], [2, 5, 3, 0]],
        "transform": [{"rotate": [[0.2, 1, 0], 40.0]}],
    }  # fmt: skip
    table: dict[str, Table] = {}
    for name, shape, medium in (("bubble", bubble, 1.4), ("prism", prism, 1.0)):
        ior = 1.0 if name == "bubble" else 1.5
        for kind, material in (("fresnel", _GLASS), ("constant", _CONSTANT),
                               ("both", {**_CONSTANT, "reflection": 0.1})):
            shapes = [with_material(shape, {**material, "ior": ior})]
            table[f"{name}, {kind}"] = room(shapes, medium_ior=medium)
    return table


def _under_water() -> Table:
    """Looking up at the surface from below: a window of sky, and the bottom mirrored around it."""
    surface = {"type": "disk", "center": [0, 0.8, 0], "normal": [0, -1, 0], "radius": 9,
               "material": {**_GLASS, "ior": "air"}}
    bottom = {"type": "disk", "center": [0, -2, 0], "normal": [0, 1, 0], "radius": 9,
              "material": {**_MATTE, "ambient": 1.0}}  # fmt: skip
    ball = with_material(CLOSED["sphere"]((0.5, -1, -1), 0.7), _MATTE)
    camera = {**CAMERA, "origin": [0, -1.2, 4], "target": [0, 0.6, 0], "fov": 70}
    lamp = {"type": "point", "position": [1, 0.3, 1], "intensity": 0.6}
    return {"max_depth": 4, "background": [0.5, 0.6, 0.7], "ambient": 0.3, "medium_ior": 1.333,
            "camera": camera, "lights": [lamp], "shapes": [surface, bottom, ball]}  # fmt: skip


def _facing_mirrors() -> Table:
    """Two mirrors face to face, and a ball between them, twenty times over."""
    walls = [{"type": "plane", "point": [0, 0, z], "normal": [0, tilt, -z], "material": _MIRROR}
             for z, tilt in ((-3, 0.05), (5, 0.1))]  # fmt: skip
    floor = {"type": "plane", "point": [0, -2, 0], "normal": [0, 1, 0], "material": _MATTE}
    ball = with_material(CLOSED["sphere"]((0.8, -0.9, -0.5), 1.0), {**_MATTE, "color": [0.3, 0.5, 0.6]})
    camera = {**CAMERA, "origin": [-0.7, 0.2, 4], "target": [0.2, -0.3, 0], "fov": 55}
    return {"max_depth": 20, "background": 0.4, "ambient": 0.25, "camera": camera,
            "lights": [{"type": "point", "position": [-2, 3, 1], "intensity": 0.5}],
            "shapes": [*walls, floor, ball]}  # fmt: skip


def _corner() -> Table:
    """Three mirrors at right angles send everything back."""
    def side(*normal: float) -> Table:
        return {"type": "plane", "point": [0, 0, 0], "normal": normal, "material": _MIRROR}

    ball = with_material(CLOSED["squashed sphere"]((1.6, 1.2, 1.4), 0.7), _MATTE)
    camera = {**CAMERA, "origin": [4, 3.2, 4.5], "target": [0.4, 0.5, 0.4], "fov": 50}
    lamp = {"type": "point", "position": [4, 5, 3], "intensity": 0.7}
    return {"max_depth": 6, "background": 0.3, "ambient": 0.25, "camera": camera, "lights": [lamp],
            "shapes": [side(1, 0, 0), side(0, 1, 0), side(0, 0, 1), ball]}  # fmt: skip


def _nested() -> Table:
    """A bubble in glass in water, and a ball in a box of glass."""
    def sphere(at: list[float], radius: float, material: Table) -> Table:
        return {"type": "sphere", "center": at, "radius": radius, "material": material}

    return room([
        sphere([-1.3, 0, 0], 1.4, {**_GLASS, "ior": 1.5, "diffuse": 0.05}),
        sphere([-1.3, 0, 0], 1.1, {**_GLASS, "ior": 1.0}),
        with_material(CLOSED["box"]((1.7, 0, 0), 1.6), {**_GLASS, "ior": 1.3}),
        sphere([1.7, 0, 0], 0.5, _MATTE),
    ], max_depth=6, lights=LIGHTS[:1])  # fmt: skip


def _sky(image: str, only: Table | None = None) -> Table:
    """A lat-long image all round, seen straight, mirrored and through glass, or through a ball of `only`.

    The file is one that ships.
    """
    table: Table = {
        "max_depth": 3, "background": image, "ambient": 0.2, "lights": LIGHTS,
        "camera": {**CAMERA, "origin": [3, 0.5, 7], "fov": 70},
        "shapes": [
            with_material(CLOSED["sphere"]((-1.2, 0, 0), 1.5), {**_MIRROR, "reflection": 0.9}),
            with_material(CLOSED["turned ellipsoid"]((2, -0.3, 0.5), 1.4), _GLASS),
        ],
    }
    if only:
        table["shapes"] = [with_material(CLOSED["sphere"]((0, 0, 0), 1.5), only)]
    return table
