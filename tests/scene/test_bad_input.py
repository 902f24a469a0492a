"""Bad scenes: each is one `ClrtError` of one line that names file, place, value and what would be right."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.scene.scene import Camera, Material, Mesh, PointLight, Scene, Sphere

BALL = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
CAMERA = {"origin": [0, 0, 5], "target": [0, 0, 0]}
QUAD = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]


def ball(**keys: Any) -> dict[str, Any]:
    return {"shapes": [BALL, {**BALL, **keys}]}


def shape(kind: str, **keys: Any) -> dict[str, Any]:
    return {"shapes": [{"type": kind, **keys}]}


def mesh(**keys: Any) -> dict[str, Any]:
    return shape("mesh", **{"vertices": QUAD, "faces": [[0, 1, 2]], **keys})


def camera(**keys: Any) -> dict[str, Any]:
    return {"camera": {**CAMERA, **keys}}


def spot(**keys: Any) -> dict[str, Any]:
    return {"lights": [{"type": "spot", "position": [1, 2, 3], "target": [0, 0, 0], **keys}]}


def lamp(kind: str, **keys: Any) -> dict[str, Any]:
    of = {
        "rectangle": {"u": [1, 0, 0], "v": [0, 1, 0]},
        "disk": {"normal": [0, 0, 1], "radius": 1},
        "sphere": {"radius": 1},
    }
    return {"lights": [{"type": kind, "center": [0, 3, 0], **of[kind], **keys}]}


def material(**keys: Any) -> dict[str, Any]:
    return {"materials": {"m": keys}}


# (scene, parts of the message that must stand in this order)
BAD: list[tuple[dict[str, Any], list[str]]] = [
    # keys and types
    ({"max_dept": 3}, ["unknown key 'max_dept'", "did you mean 'max_depth'"]),
    ({"folder": "/"}, ["unknown key 'folder'"]),
    (ball(radus=2), ["shapes[1]", "unknown key 'radus'", "did you mean 'radius'"]),
    (material(colour=1), ["materials.m", "unknown key 'colour'", "did you mean 'color'"]),
    (camera(fow=40), ["camera", "unknown key 'fow'", "did you mean 'fov'"]),
    (shape("spere"), ["shapes[0].type", "'spere'", "sphere, plane", "did you mean 'sphere'"]),
    (shape(["sphere"]), ["shapes[0].type", "['sphere']"]),
    ({"shapes": [{"center": [0, 0, 0]}]}, ["shapes[0]", "'type' is missing", "sphere"]),
    ({"shapes": [3]}, ["shapes[0]", "3 is not allowed", "a table with a type"]),
    ({"shapes": {}}, ["shapes", "{}", "must be a list"]),
    ({"lights": "sun"}, ["lights", "'sun'", "must be a list"]),
    ({"lights": [{"type": "ies"}]}, ["lights[0].type", "'ies'", "clrt has no measured lights"]),
    (spot(angle=0), ["lights[0].angle", "0", "an angle from the axis, above 0 and up to 90 degrees"]),
    (spot(angle=90.5), ["lights[0].angle", "90.5", "up to 90 degrees"]),
    (spot(angle=math.nan), ["lights[0].angle", "nan", "finite"]),
    ({"lights": [{"type": "point", "position": [3, 5, 1e25]}]},
     ["lights[0].position", "(3.0, 5.0, 1e+25)", "a light reaches 1e+18 at most", "a directional one"]),
    (spot(position=[0, -2e18, 0]), ["lights[0].position", "-2e+18", "1e+18 at most"]),
    (lamp("rectangle", u=[1e30, 0, 0], v=[0, 1e3, 0]), ["lights[0].u", "1e+30", "1e+18 at most"]),
    (lamp("disk", center=[0, 3e38, 0]), ["lights[0].center", "3e+38", "1e+18 at most"]),
    (lamp("sphere", center=[0, 1.1e18, 0], visible=False), ["lights[0].center", "1e+18 at most"]),
    (spot(penumbra=1.5), ["lights[0].penumbra", "1.5", "a part of the angle, from 0 to 1"]),
    (spot(penumbra=-0.1), ["lights[0].penumbra", "-0.1", "from 0 to 1"]),
    (spot(target=[1, 2, 3]), ["lights[0].target", "(1.0, 2.0, 3.0)", "not be at its position"]),
    (lamp("rectangle", u=[0, 0, 0]), ["lights[0].u", "(0.0, 0.0, 0.0)", "a half side must not be zero"]),
    (lamp("rectangle", v=[-2, 0, 0]), ["lights[0].v", "(-2.0, 0.0, 0.0)", "must not be parallel"]),
    (lamp("rectangle", v=[0, 1e-38, 0]), ["lights[0].v", "1e-38", "nor the area 0"]),
    (lamp("rectangle", u=[1e30, 0, 0], v=[0, 1e30, 0]), ["lights[0].v", "or infinite in float32"]),
    (lamp("rectangle", u=[1, 0]), ["lights[0].u", "[1, 0]", "3 numbers"]),
    (lamp("disk", radius=0), ["lights[0].radius", "0", "a radius must be > 0"]),
    (lamp("disk", radius=1e-20), ["lights[0].radius", "1e-20", "area is 0 or infinite"]),
    (lamp("disk", normal=[0, 0, 0]), ["lights[0].normal", "must not be zero"]),
    (lamp("sphere", radius=-1), ["lights[0].radius", "-1", "a radius must be > 0"]),
    (lamp("sphere", samples=0), ["lights[0].samples", "0", "a whole number from 1 to 65535"]),
    (lamp("disk", samples=65536), ["lights[0].samples", "65536", "from 1 to 65535"]),
    (lamp("disk", samples=2.5), ["lights[0].samples", "2.5", "a whole number"]),
    (lamp("sphere", radiance=-1), ["lights[0].radiance", "-1", "a colour"]),
    (lamp("sphere", intensity=1), ["lights[0]", "'intensity'", "radiance"]),
    (lamp("sphere", two_sided=1), ["lights[0].two_sided", "1"]),
    (spot(falloff="square"), ["lights[0].falloff", "'square'", "'none' or 'inverse-square'"]),
    (spot(cone_angle=20), ["lights[0]", "'cone_angle'", "clrt calls it 'angle'"]),
    ({"lights": [{"type": "spotlight"}]}, ["lights[0].type", "'spotlight'", "clrt calls it 'spot'"]),
    ({"lights": [{"type": "point"}]}, ["lights[0]", "'position' is missing", "3 numbers"]),
    ({"materials": []}, ["materials", "[]", "named materials"]),
    ({"camera": 5}, ["camera", "5 is not allowed"]),
    ({"version": 2}, ["version", "2", "must be 1"]),
    (shape("sphere", center=[0, 0, 0]), ["shapes[0]", "'radius' is missing", "> 0"]),
    (ball(radius="big"), ["shapes[1].radius", "'big'", "a radius must be > 0"]),
    (ball(radius=True), ["shapes[1].radius", "True", "a radius must be > 0"]),
    (ball(center=[0, 0]), ["shapes[1].center", "[0, 0]", "3 numbers"]),
    (ball(center=[0, None, 0]), ["shapes[1].center[1]", "None", "3 numbers"]),
    (ball(name=3), ["shapes[1].name", "3", "a text"]),
    (ball(material=3), ["shapes[1].material", "3", "the name of a material or a table"]),
    (ball(name=Path("m")), ["shapes[1]", "cannot be part of a scene"]),
    ({"max_depth": 2.5}, ["max_depth", "2.5", "a whole number from 0 to 65536"]),
    ({"max_depth": -1}, ["max_depth", "-1", "from 0 to 65536"]),
    ({"shadow": "soft"}, ["shadow", "'soft'", "'opaque' or 'tinted'"]),
    ({"one_sided": True}, ["one_sided", "True", "'none' or 'opaque'"]),
    ({"ambient_samples": -4}, ["ambient_samples", "-4"]),
    # numbers
    (ball(radius=-1.0), ["shapes[1].radius", "-1.0", "a radius must be > 0"]),
    (ball(radius=0), ["shapes[1].radius", "0", "a radius must be > 0"]),
    (ball(radius=1e-50), ["shapes[1].radius", "1e-50", "a radius must be > 0", "float32"]),
    (ball(radius=1e39), ["shapes[1].radius", "1e+39", "at most 3.4e+38"]),
    (ball(radius=10**400), ["shapes[1].radius", "1000000", "at most 3.4e+38"]),
    (ball(radius=math.nan), ["shapes[1].radius", "nan", "finite"]),
    (ball(center=[0, math.inf, 0]), ["shapes[1].center[1]", "inf", "finite"]),
    (ball(center=(0, math.inf, 0)), ["shapes[1].center[1]", "inf", "finite"]),
    (ball(center=(0, 0, 1e39)), ["shapes[1].center[2]", "1e+39", "at most 3.4e+38"]),
    (ball(transform=({"translate": (0, math.nan, 0)},)), ["shapes[1].transform[0].translate[1]", "nan"]),
    (ball(center=np.array([0, 0, np.nan])), ["shapes[1].center[2]", "nan", "finite"]),
    ({"ambient": -0.5}, ["ambient", "-0.5", "a colour must be a number >= 0"]),
    ({"ambient": [0, -1, 0]}, ["ambient[1]", "-1", "a colour"]),
    ({"background": [1, 2]}, ["background", "[1, 2]", "a colour, a light's name, a spectrum or the path"]),
    ({"medium_ior": 0}, ["medium_ior", "0", "from 0.001 to 1e+06"]),
    ({"medium_ior": 1e-30}, ["medium_ior", "1e-30", "from 0.001 to 1e+06"]),
    ({"lights": [{"type": "point", "position": [0, 0, 0], "intensity": -1}]}, ["lights[0].intensity", "-1"]),
    ({"lights": [{"type": "directional", "direction": [0, 0, 0]}]}, ["lights[0].direction", "not be zero"]),
    (material(roughness=-0.1), ["materials.m.roughness", "-0.1", "a number from 0 to 1"]),
    (material(roughness=1.5), ["materials.m.roughness", "1.5", "a number from 0 to 1"]),
    (material(roughness=math.nan), ["materials.m.roughness", "nan", "finite"]),
    (material(roughness="satin"), ["materials.m.roughness", "'satin'", "a number from 0 to 1"]),
    (material(roughness=0.3, transmission=0.5), ["materials.m.roughness", "0.3", "transmits nothing"]),
    (material(roughness=0.005, fresnel=True), ["materials.m.roughness", "0.005", "transmission = 0"]),
    (camera(aperture=-0.1), ["camera.aperture", "-0.1", "a radius from 0 to 1e18"]),
    (camera(aperture=math.nan), ["camera.aperture", "nan", "finite"]),
    (camera(aperture="f/2"), ["camera.aperture", "'f/2'", "a radius from 0 to 1e18"]),
    (camera(aperture=1e19), ["camera.aperture", "1e+19", "a radius from 0 to 1e18"]),
    (camera(aperture=2.0, focus=1e-6), ["camera.aperture", "2.0", "at most 1e+06 times", "1e-06"]),
    (camera(filter="lanczos"), ["camera.filter", "'lanczos'", "'box', 'tent', 'gaussian' or 'mitchell'"]),
    (camera(filter=2), ["camera.filter", "2", "'box', 'tent', 'gaussian' or 'mitchell'"]),
    ({"adaptive": {"threshold": -0.01}}, ["adaptive.threshold", "-0.01", "from 0 to 1"]),
    ({"adaptive": {"threshold": math.nan}}, ["adaptive.threshold", "nan", "finite"]),
    ({"adaptive": {"spp": 0}}, ["adaptive.spp", "0", "a power of 4"]),
    ({"adaptive": 64}, ["adaptive", "64", "must be a table such as {spp = 64, threshold = 0.01}"]),
    ({**camera(), "adaptive": {"spp": 50}}, ["adaptive.spp", "50", "camera.spp = 1", "16 or 64"]),
    (camera(size=1e19), ["camera.size", "1e+19", "at most 1e18"]),
    (camera(origin=[0, -3e38, 0]), ["camera.origin", "-3e+38", "within 1e+18"]),
    (camera(near=1e19), ["camera.near", "1e+19", "a distance from 0 to 1e18"]),
    (camera(focus=0), ["camera.focus", "0", "a distance > 0 along the view"]),
    (camera(focus=-2.5), ["camera.focus", "-2.5", "a distance > 0 along the view"]),
    (camera(focus=1e-50), ["camera.focus", "1e-50", "a distance > 0 along the view"]),
    (camera(focus=math.inf), ["camera.focus", "inf", "finite"]),
    (material(ior="glas"), ["materials.m.ior", "'glas'", "air, water", "did you mean 'glass'"]),
    (material(ior=-1.5), ["materials.m.ior", "-1.5", "from 0.001 to 1e+06"]),
    (material(fresnel="yes"), ["materials.m.fresnel", "'yes'", "'schlick'"]),
    (material(color=-1), ["materials.m.color", "-1", "number >= 0"]),
    (material(emission=[1, 1, 1e39]), ["materials.m.emission[2]", "1e+39"]),
    (material(priority=1.5), ["materials.m.priority", "1.5", "whole number"]),
    (material(priority=40000), ["materials.m.priority", "40000", "from -32768 to 32767"]),
    (material(absorption=-0.1), ["materials.m.absorption", "-0.1", ">= 0"]),
    (material(absorption=[0, float("nan"), 0]), ["materials.m.absorption[1]", "nan"]),
    (material(ior=float("nan")), ["materials.m.ior", "nan"]),
    ({"medium_ior": float("nan")}, ["medium_ior", "nan"]),
    (material(color={"type": "cheker"}), ["materials.m.color.type", "'cheker'", "'checker'"]),
    (material(color={"type": "checker", "size": 0}), ["materials.m.color.size", "0", "> 0"]),
    (material(color={"type": "checker", "siz": 1}), ["materials.m.color", "'siz'", "'size'"]),
    (material(color={"type": "checker", "colors": [1, -1]}), ["materials.m.color.colors[1]", "-1"]),
    # materials by name, checkers
    (ball(material="glass"), ["shapes[1].material", "'glass'", "no materials"]),
    (
        {**ball(material="glas"), "materials": {"glass": {}, "red": {}}},
        ["shapes[1].material", "'glas'", "glass, red", "did you mean 'glass'"],
    ),
    (ball(material={"shine": 3}), ["shapes[1].material", "'shine'", "'shininess'"]),
    (
        shape("box", min=[0, 0, 0], max=[1, 1, 1], material={"color": {"type": "checker"}}),
        ["shapes[0].material", "a checker is for spheres", "not a box"],
    ),
    (
        ball(material={"color": {"type": "checker"}}, transform=[{"scale": [1, 2, 1]}]),
        ["shapes[1].transform", "must stay round"],
    ),
    # shapes
    (shape("plane", point=[0, 0, 0], normal=[0, 0, 0]), ["shapes[0].normal", "must not be zero"]),
    (
        shape("plane", point=[0, 0, 0], normal=[1e-50, 0, 0]),
        ["shapes[0].normal", "1e-50", "must not be zero"],
    ),
    (shape("plane", point=[0, 0, 0], normal=[0, 1, 0], transform=[]), ["shapes[0].transform", "infinite"]),
    (shape("polygon", points=QUAD[:2]), ["shapes[0].points", "3 or more"]),
    (shape("polygon", points=[[0, 0, 0], [1, 1, 1], [2, 2, 2]]), ["shapes[0].points", "not lie on a line"]),
    (shape("polygon", points=[[1, 1, 1]] * 3), ["shapes[0].points", "span an area"]),
    (shape("polygon", points=[*QUAD[:3], [0, 1, 0.01]]), ["shapes[0].points", "one plane", "0.0001"]),
    (shape("quadric", coefficients=[0] * 9 + [1]), ["shapes[0].coefficients", "must not be 0"]),
    (shape("quadric", coefficients=[1] * 9), ["shapes[0].coefficients", "10 numbers"]),
    (
        shape("quadric", coefficients=[1] * 10, clip=[[0, 0, 0], [1, -1, 1]]),
        ["shapes[0].clip", "above the first on every axis", "y is not"],
    ),
    (shape("ellipsoid", center=[0, 0, 0], radii=[1, 0, 1]), ["shapes[0].radii[1]", "0", "> 0"]),
    (shape("cylinder", p0=[1, 1, 1], p1=[1, 1, 1], radius=1), ["shapes[0].p1", "must not be at p0"]),
    (shape("cylinder", p0=[1e9, 0, 0], p1=[1e9 + 1, 0, 0], radius=1), ["shapes[0].p1", "must not be at p0"]),
    (shape("cone", p0=[0, 0, 0], p1=[0, 0, 1], r0=0, r1=0), ["shapes[0].r1", "one of the radii"]),
    (shape("cone", p0=[0, 0, 0], p1=[0, 0, 1], r0=-1, r1=1), ["shapes[0].r0", "-1", ">= 0"]),
    (shape("paraboloid", apex=[0, 0, 0], axis=[0, 0, 0], focal=1, height=1), ["shapes[0].axis", "zero"]),
    (shape("paraboloid", apex=[0, 0, 0], axis=[0, 1, 0], focal=0, height=1), ["shapes[0].focal", "> 0"]),
    (shape("disk", center=[0, 0, 0], normal=[0, 0, 0], radius=1), ["shapes[0].normal", "zero"]),
    (shape("box", min=[0, 0, 0], max=[1, 1, 0]), ["shapes[0].max", "every axis", "z is not"]),
    # transforms
    (ball(transform=[{"translte": [1, 0, 0]}]), ["shapes[1].transform[0]", "'translte'", "'translate'"]),
    (ball(transform=[{"scale": 0}]), ["shapes[1].transform", "singular"]),
    (ball(transform=[{"scale": [1, 1, 0]}]), ["transform: [{'scale': (1.0, 1.0, 0.0)}] is not", "singular"]),
    (ball(transform=[{"scale": 1, "translate": [0, 0, 0]}]), ["shapes[1].transform[0]", "exactly one of"]),
    (ball(transform=[{}]), ["shapes[1].transform[0]", "exactly one of"]),
    (ball(transform=[{"rotate": [[0, 0, 0], 30]}]), ["shapes[1].transform[0].rotate", "zero"]),
    (ball(transform=[{"rotate": ["w", 30]}]), ["shapes[1].transform[0].rotate[0]", "'w'", "'x', 'y', 'z'"]),
    (ball(transform=[{"rotate": 30}]), ["shapes[1].transform[0].rotate", "30", "[axis, degrees]"]),
    (ball(transform=[{"scale": 1e30}, {"scale": 1e30}]), ["shapes[1].transform", "overflows"]),
    (ball(transform=np.eye(3).tolist()), ["shapes[1].transform", "4x4"]),
    (ball(transform=np.eye(4)[:3].tolist()), ["shapes[1].transform", "4 rows"]),
    (ball(transform=np.zeros((4, 4))), ["shapes[1].transform[3]", "[0, 0, 0, 1]"]),
    (ball(transform=[[1, 1, 0, 0], [2, 2, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]), ["transform", "singular"]),
    (ball(transform=[[1, 0, 0, 0], {"scale": 2}]), ["shapes[1].transform[0]", "a step must be"]),
    # meshes
    (shape("mesh"), ["shapes[0]", "'vertices' is missing", "a file"]),
    (shape("mesh", vertices=QUAD), ["shapes[0]", "'faces' is missing"]),
    (mesh(vertexes=[]), ["shapes[0]", "unknown key 'vertexes'", "'vertices'"]),
    (mesh(file="a.obj"), ["shapes[0]", "file and vertices, faces exclude each other"]),
    (mesh(faces=[[0, 1, 4]]), ["shapes[0].faces[0][2]", "4", "from 0 to 3"]),
    (mesh(faces=[[0, 1, 2], [0, 1, 2, -1]]), ["shapes[0].faces[1][3]", "-1", "from 0 to 3"]),
    (mesh(faces=[[0, 1, 2], [0, 1]]), ["shapes[0].faces[1]", "[0, 1]", "3 or more"]),
    (mesh(faces=[[0, 1, 2.5]]), ["shapes[0].faces[0][2]", "vertex numbers"]),
    (mesh(faces=[[0, 1, 10**30]]), ["shapes[0].faces", "vertex number"]),
    (mesh(faces=3), ["shapes[0].faces", "vertex numbers"]),
    (mesh(faces=np.array([[0.0, 1.0, 2.0]])), ["shapes[0].faces", "float64", "integers"]),
    (mesh(vertices=[[0, 0, 0], [1, 0, "x"], [0, 1, 0]]), ["shapes[0].vertices[1][2]", "3 numbers"]),
    (mesh(vertices=[[0, 0, 0], [1, 0], [0, 1, 0]]), ["shapes[0].vertices[1]", "3 numbers"]),
    (mesh(vertices=[[0, 0, 0], [1, 0, math.nan], [0, 1, 0]]), ["shapes[0].vertices[1]", "nan", "finite"]),
    (mesh(vertices=np.full((3, 3), 1e39)), ["shapes[0].vertices[0]", "1e+39", "finite"]),
    (mesh(vertices=np.zeros((3, 2))), ["shapes[0].vertices", "(3, 2)", "(n, 3)"]),
    (mesh(vertices=np.array(["a", "b"])), ["shapes[0].vertices", "(n, 3)"]),
    (mesh(vertices=[], faces=[[0, 1, 2]]), ["shapes[0].faces[0][0]", "no vertices"]),
    (mesh(normals=[[0, 0, 1]]), ["shapes[0].normals", "1 normals for 4 vertices"]),
    (mesh(normals=[[0, 0, 1]] * 3 + [[0, 0, 0]]), ["shapes[0].normals[3]", "must not be zero"]),
    (
        mesh(vertices=[*QUAD[:3], [0, 1, 0.1]], faces=[[0, 1, 2], [0, 1, 2, 3]]),
        ["shapes[0].faces[1]", "one plane, or smooth"],
    ),
    (mesh(faces=[[0, 1, 0, 1]]), ["shapes[0].faces[0]", "span an area"]),
    # cameras
    ({"camera": {"origin": [0, 0, 0]}}, ["camera", "'target' is missing"]),
    (camera(target=[0, 0, 5]), ["camera.target", "must not be at the camera's origin"]),
    (camera(up=[0, 0, 3]), ["camera.up", "must not be parallel"]),
    (camera(up=[0, 0, 0]), ["camera.up", "must not be zero"]),
    (camera(fov=180), ["camera.fov", "180", "between 0 and 180"]),
    (camera(fov=0), ["camera.fov", "0", "between 0 and 180"]),
    (camera(type="fisheye"), ["camera.type", "'fisheye'", "'perspective' or 'orthographic'"]),
    (camera(width=0), ["camera.width", "0", "from 1 to 65536"]),
    (camera(height=2**31 - 1), ["camera.height", "2147483647", "from 1 to 65536"]),
    (camera(width=10**30), ["camera.width", "1000000", "from 1 to 65536"]),
    (camera(spp=3), ["camera.spp", "3", "1 or 4"]),
    (camera(spp=0), ["camera.spp", "0", "square number"]),
    (camera(jitter=-1), ["camera.jitter", "-1", "a seed"]),
    (camera(size=0), ["camera.size", "0", "> 0"]),
    (camera(near=-1), ["camera.near", "-1", "from 0 to"]),
    # files
    ({"background": "sky.exr"}, ["background", "'sky.exr'", "no such file"]),
    ({"background": "../../etc/hostname"}, ["background", "'../../etc/hostname'", "in the scene's folder"]),
    ({"background": "/etc/hostname"}, ["background", "'/etc/hostname'", "in the scene's folder"]),
    ({"background": "a\0b"}, ["background", "a file"]),
    ({"background": ""}, ["background", "''", "no such file"]),
    (shape("mesh", file="no.obj"), ["shapes[0].file", "'no.obj'", "no such file"]),
    (shape("mesh", file=""), ["shapes[0].file", "''", "the path of a mesh file"]),
    (shape("mesh", file="scene.xyz"), ["shapes[0].file", "'scene.xyz'", ".obj, .ply"]),
    (shape("mesh", file="../outside.obj"), ["shapes[0].file", "in the scene's folder"]),
    (shape("mesh", file="link.obj"), ["shapes[0].file", "it is a link to", "in the scene's folder"]),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with some files in it, and one beside it that no scene in it may read."""
    top = tmp_path_factory.mktemp("top")
    inside = top / "inside"
    inside.mkdir()
    (inside / "scene.xyz").write_text("1 2 3\n")
    (top / "outside.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (inside / "link.obj").symlink_to(top / "outside.obj")
    return inside


@pytest.mark.parametrize("suffix", [".obj", ".gltf", ".stl", ".ply"])
def test_the_file_that_was_named_may_be_a_link(suffix: str, tmp_path: Path) -> None:
    """As annexes and caches of models keep files; it was refused as one that lies elsewhere."""
    trimesh = pytest.importorskip("trimesh")
    store, view = tmp_path / "store", tmp_path / "view"
    store.mkdir(), view.mkdir()
    data = trimesh.creation.box().export(file_type="glb" if suffix == ".gltf" else suffix[1:])
    named = view / ("model" + suffix.replace(".gltf", ".glb"))
    (store / "blob").write_bytes(data if isinstance(data, bytes) else data.encode())
    named.symlink_to(store / "blob")
    scene = clrt.load(named)
    assert len(scene.shapes) == 1
    with pytest.raises(clrt.SceneError, match=r"it is a link to .*, and a file must lie in"):
        clrt.load_dict({"shapes": [{"type": "mesh", "file": named.name}]}, folder=view)


def check_message(message: str, parts: list[str]) -> None:
    assert "\n" not in message and len(message) < 500
    at = 0
    for part in parts:
        found = message.find(part, at)
        assert found >= 0, f"{part!r} is not in {message!r} (from {at})"
        at = found + len(part)


@pytest.mark.parametrize(
    ("table", "parts"), BAD, ids=lambda value: value[0] if isinstance(value, list) else ""
)
def test_bad_scene(table: dict[str, Any], parts: list[str], folder: Path) -> None:
    with pytest.raises(clrt.SceneError) as caught:
        clrt.load_dict(table, folder=folder, source="room.toml")
    check_message(str(caught.value), ["room.toml: ", *parts])


OBJECTS: list[tuple[Any, list[str]]] = [
    (lambda: Scene(shapes=[Sphere(center=(0, 0, 0), radius=-1)]), ["shapes[0].radius", "-1", "> 0"]),
    (lambda: Scene(shapes=[Sphere(center="abc", radius=1)]), ["shapes[0].center", "'abc'", "3 numbers"]),
    (lambda: Scene(shapes=[Sphere(center=object(), radius=1)]), ["shapes[0]", "class object"]),
    (lambda: Scene(shapes=[Material()]), ["shapes[0]", "Material", "a shape must be"]),
    (lambda: Scene(lights=[Sphere(center=(0, 0, 0), radius=1)]), ["lights[0]", "a light must be"]),
    (lambda: Scene(lights=[PointLight(position=(0, 0, math.nan))]), ["lights[0].position[2]", "nan"]),
    (lambda: Scene(materials={"m": Material(diffuse=-1)}), ["materials.m.diffuse", "-1", ">= 0"]),
    (lambda: Scene(materials={3: Material()}), ["materials", "3", "a text"]),
    (lambda: Scene(materials={"m": PointLight(position=(0, 0, 0))}), ["materials.m", "a Material"]),
    (lambda: Scene(camera=Camera(origin=(0, 0, 0), target=(0, 0, 1), spp=5)), ["camera.spp", "5", "4 or 9"]),
    (lambda: Scene(camera=Material()), ["camera", "a Camera"]),
    (lambda: Scene(max_depth="deep"), ["max_depth", "'deep'"]),
    (lambda: Scene(shapes=None), ["shapes", "None", "a list"]),
    (lambda: Scene(shapes=[Mesh(vertices=np.zeros((3, 3)))]), ["shapes[0]", "'faces' is missing"]),
    (lambda: Mesh(name="m", vertices=QUAD, faces=[[0, 1, 9]]).data(), ["m.faces[0][2]", "9", "0 to 3"]),
    (lambda: clrt.load_dict([]), ["[]", "a table of keys"]),
    (lambda: clrt.load_dict(None), ["None", "a table of keys"]),
]


@pytest.mark.parametrize(("make", "parts"), OBJECTS)
def test_objects_are_checked_as_strictly(make: Any, parts: list[str]) -> None:
    with pytest.raises(clrt.SceneError) as caught:
        make()
    check_message(str(caught.value), parts)


def test_an_object_that_contains_itself_is_an_error() -> None:
    center: list[Any] = [0, 0]
    center.append(center)
    with pytest.raises(clrt.SceneError, match=r"shapes\[0\]"):
        clrt.load_dict({"shapes": [{"type": "sphere", "center": center, "radius": 1}]})


def test_limits_say_what_to_change(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    three = {"shapes": [BALL] * 3, "lights": [{"type": "point", "position": [0, 0, 0]}] * 3}
    path.write_text(json.dumps(three))
    for name, value in (("file_bytes", 100), ("nesting", 3), ("primitives", 2), ("lights", 2)):
        with pytest.raises(clrt.LimitError) as caught:
            clrt.load(path, limits=clrt.Limits(**{name: value}))
        more = [f"--limit {name}=N", f"limits=Limits({name}=N)"]
        check_message(str(caught.value), ["a.json", name, f"limit of {value}", *more])
    assert len(clrt.load(path, limits=clrt.Limits(primitives=3, lights=3)).shapes) == 3
    with pytest.raises(clrt.LimitError, match=r"shapes\[0\]\.vertices: vertices: 4 is above the limit of 3"):
        clrt.load_dict(mesh(), limits=clrt.Limits(vertices=3))
    with pytest.raises(clrt.LimitError, match="primitives: 2 is above the limit of 1"):
        clrt.load_dict(mesh(faces=[[0, 1, 2]] * 2), limits=clrt.Limits(primitives=1))
