"""Scenes as arrays: numbering, transforms, what float32 cannot hold, and the hash."""

from __future__ import annotations

import math
import time
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

import clrt
from clrt import layout
from clrt.base.errors import SceneError
from clrt.flatten.flatten import FlatScene, flatten
from clrt.scene.scene import Scene

KINDS = {number: name for name, number in layout.KINDS.items()}
SPHERE = {"type": "sphere", "center": [1.0, 2.0, 3.0], "radius": 0.5}
PLANE = {"type": "plane", "point": [0.0, -1.0, 0.0], "normal": [0.0, 2.0, 0.0]}
CYLINDER = {"type": "cylinder", "p0": [0.0, 0.0, 0.0], "p1": [0.0, 2.0, 0.0], "radius": 0.5}
SQUARE = {"type": "polygon", "points": [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]]}
BOX = {"type": "box", "min": [0.0, 0.0, 0.0], "max": [1.0, 2.0, 3.0]}
DISK = {"type": "disk", "center": [0.0, 1.0, 0.0], "normal": [0.0, 3.0, 4.0], "radius": 2.0}
MIXED = {
    "type": "mesh",
    "vertices": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1]],
    "faces": [[0, 1, 4], [0, 1, 2, 3], [1, 2, 4]],
}
MIRROR = [{"scale": [-1.0, 1.0, 1.0]}]
UNEVEN = [{"scale": [1.0, 2.0, 1.0]}]


def flat(*shapes: dict[str, Any], **scene: Any) -> FlatScene:
    return flatten(Scene(shapes=shapes, **scene))


def kinds(scene: FlatScene) -> list[str]:
    count = int(scene.scene["primitives"][0])
    return [KINDS[kind] for kind in scene.primitives["kind"][:count]]


def newell(points: np.ndarray) -> np.ndarray:
    normal = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    return normal / np.linalg.norm(normal)


def corners(scene: FlatScene, polygon: int) -> np.ndarray:
    record = scene.polygons[polygon]
    return scene.vertices[record["first"] : record["first"] + record["count"], :3].astype(np.float64)


def test_primitives_are_numbered_in_the_order_of_shapes_caps_and_faces() -> None:
    cone = {"type": "cone", "p0": [0, 0, 0], "r0": 1.0, "p1": [0, 1, 0], "r1": 0.0, "caps": True}
    scene = flat(SPHERE, CYLINDER | {"caps": True}, PLANE, MIXED, cone, BOX, SPHERE)
    assert kinds(scene) == [
        "SPHERE", "QUADRIC", "DISK", "DISK", "PLANE", "TRIANGLE", "POLYGON", "TRIANGLE", "QUADRIC", "DISK",
        *["POLYGON"] * 6, "SPHERE",
    ]  # fmt: skip
    assert scene.primitives["shape"].tolist() == [0, 1, 1, 1, 2, 3, 3, 3, 4, 4, *[5] * 6, 6]
    assert scene.primitives["index"].tolist() == [0, 0, 0, 1, 0, 0, 0, 1, 1, 2, 1, 2, 3, 4, 5, 6, 1]
    assert scene.unbounded.tolist() == [4]
    assert scene.finite.tolist() == [n for n in range(17) if n != 4]
    assert len(scene.boxes) == 16 and scene.n_shapes == 7
    assert scene.disks["normal"][:2, 1].tolist() == [-1.0, 1.0]
    assert scene.disks["center_radius"][2].tolist() == [0.0, 0.0, 0.0, 1.0]


def test_a_scene_without_shapes_and_lights_has_empty_counts_but_no_empty_section() -> None:
    scene = flat()
    info = scene.scene[0]
    assert info["primitives"] == info["unbounded"] == info["lights"] == 0
    assert len(scene.finite) == len(scene.boxes) == 0
    sections = [entry.name for entry in fields(FlatScene) if entry.name in layout.WORLD]
    assert len(sections) == 14  # all but the tree, which the device builds
    for name in sections:
        array, element = getattr(scene, name), layout.dtype(layout.WORLD[name])
        assert len(array) == 1 and array.dtype == element.base and array.shape[1:] == element.shape, name


def test_a_plane_and_a_disk_keep_their_point_and_get_unit_normals() -> None:
    scene = flat(PLANE, DISK)
    assert scene.planes["point"][0].tolist() == [0.0, -1.0, 0.0, 0.0]
    assert scene.planes["normal"][0].tolist() == [0.0, 1.0, 0.0, 0.0]
    np.testing.assert_allclose(scene.disks["normal"][0], [0.0, 0.6, 0.8, 0.0], rtol=1e-7)
    assert scene.disks["center_radius"][0].tolist() == [0.0, 1.0, 0.0, 2.0]


def test_a_smooth_mesh_becomes_fans_with_normals_at_each_corner() -> None:
    scene = flat(MIXED | {"smooth": False}, MIXED | {"smooth": True}, MIXED | {"smooth": True})
    assert kinds(scene) == ["TRIANGLE", "POLYGON", "TRIANGLE", *["TRIANGLE"] * 8]
    assert scene.triangles["normals"].tolist() == [-1, -1, *range(0, 24, 3)]
    fan = scene.triangles[3:5]
    vertices = np.array(MIXED["vertices"], float)
    np.testing.assert_array_equal(fan["v0"][:, :3], vertices[[0, 0]])
    np.testing.assert_array_equal(fan["v1"][:, :3], vertices[[1, 2]])
    np.testing.assert_array_equal(fan["v2"][:, :3], vertices[[2, 3]])
    np.testing.assert_allclose(np.linalg.norm(scene.normals[:, :3], axis=1), 1.0, rtol=1e-6)
    assert scene.normals.shape == (24, 4)
    np.testing.assert_array_equal(scene.normals[3 + 2], scene.normals[6 + 1])  # vertex 2, in both of the fan
    assert (scene.normals[3 + 1] != scene.normals[6 + 2]).any()  # vertices 1 and 3


def test_given_normals_are_scaled_to_length_one_and_go_through_the_inverse_transpose() -> None:
    mesh = MIXED | {"normals": [[0.0, 3.0, 3.0]] * 5, "transform": [{"scale": [1.0, 1.0, 0.5]}]}
    scene = flat(mesh)
    expected = np.array([0.0, 1.0, 2.0]) / math.sqrt(5.0)
    np.testing.assert_allclose(scene.normals[:, :3], np.tile(expected, (12, 1)), rtol=1e-6)


@pytest.mark.parametrize("transform", [None, MIRROR, [{"rotate": ["x", 40.0]}, {"scale": [-1.0, 2.0, -3.0]}]])
def test_boxes_have_outward_faces_in_their_order_that_share_corners_to_the_bit(transform: Any) -> None:
    scene = flat(BOX | {"transform": transform})
    matrix = Scene(shapes=[BOX | {"transform": transform}]).shapes[0].matrix
    middle = matrix[:3, :3] @ [0.5, 1.0, 1.5] + matrix[:3, 3]
    for number in range(6):
        outward = np.zeros(3)
        outward[number // 2] = -1.0 if number % 2 == 0 else 1.0
        face = corners(scene, number)
        normal = scene.polygons["normal"][number, :3]
        np.testing.assert_allclose(newell(face - face[0]), normal, atol=1e-6)
        assert normal @ (face.mean(axis=0) - middle) > 0
        expected = np.linalg.inv(matrix[:3, :3]).T @ outward
        np.testing.assert_allclose(normal, expected / np.linalg.norm(expected), atol=1e-6)
    assert len(set(map(tuple, scene.vertices.tolist()))) == 8


def test_mirrors_turn_the_winding_and_keep_the_first_corner() -> None:
    tilted = SQUARE | {"transform": [{"rotate": ["y", 30.0]}, *MIRROR]}
    mesh = MIXED | {"transform": MIRROR}
    plain, mirrored = flat(SQUARE, MIXED), flat(tilted, mesh)
    np.testing.assert_allclose(plain.polygons["normal"][0, :3], [0, 0, 1])
    np.testing.assert_allclose(mirrored.polygons["normal"][0, :3], [-0.5, 0, math.sqrt(0.75)], atol=1e-7)
    np.testing.assert_allclose(corners(mirrored, 0)[0], [0, 0, 0], atol=1e-7)
    np.testing.assert_allclose(mirrored.polygons["normal"][1, :3], [0, 0, 1])
    flip = np.array([-1.0, 1.0, 1.0])
    np.testing.assert_array_equal(corners(mirrored, 1), corners(plain, 1)[[0, 3, 2, 1]] * flip)
    for triangle, mirror in zip(plain.triangles, mirrored.triangles, strict=True):
        a, b, c = (triangle[name][:3].astype(float) for name in ("v0", "v1", "v2"))
        x, y, z = (mirror[name][:3].astype(float) for name in ("v0", "v1", "v2"))
        np.testing.assert_array_equal(x, a * flip)
        np.testing.assert_allclose(np.cross(y - x, z - x), np.cross(b - a, c - a) * flip)


def test_smooth_normals_follow_the_turned_winding() -> None:
    mesh = MIXED | {"normals": [[0, 0, 1], [1, 0, 0], [0, 1, 0], [1, 1, 1], [0, 1, 1]], "transform": MIRROR}
    scene = flat(mesh)
    by_vertex = {tuple(v): n for v, n in zip(MIXED["vertices"], mesh["normals"], strict=True)}
    for triangle in scene.triangles:
        for i, name in enumerate(("v0", "v1", "v2")):
            x, y, z = triangle[name][:3].tolist()
            normal = np.array(by_vertex[(-x, y, z)], float) * [-1, 1, 1]
            got = scene.normals[triangle["normals"] + i, :3]
            np.testing.assert_allclose(got, normal / np.linalg.norm(normal), atol=1e-6)


def test_newell_normals_are_those_of_the_rounded_corners() -> None:
    """A small polygon far away: float32 tilts it, and the normal must tilt with it."""
    points = np.array([[0.0, 0.0, 0.0], [0.01, 0.0, 0.003], [0.01, 0.01, 0.003], [0.0, 0.01, 0.0]])
    points += np.array([1000.1, 7.0, 500.7])
    scene = flat(SQUARE | {"points": points.tolist()})
    rounded = points.astype(np.float32).astype(float)
    np.testing.assert_allclose(scene.polygons["normal"][0, :3], newell(rounded - rounded[0]), atol=1e-7)
    assert np.abs(newell(rounded - rounded[0]) - newell(points - points[0])).max() > 1e-4
    assert scene.polygons["normal"][0, 3] == rounded.max()


def test_a_sphere_stays_one_under_similarities_only() -> None:
    turned = SPHERE | {
        "transform": [{"rotate": [[1, 2, 3], 50.0]}, {"scale": 2.0}, {"translate": [1, 0, 0]}, *MIRROR]
    }
    scene = flat(turned, SPHERE | {"transform": UNEVEN})
    assert kinds(scene) == ["SPHERE", "QUADRIC"]
    matrix = Scene(shapes=[turned]).shapes[0].matrix
    np.testing.assert_allclose(scene.spheres["center_radius"][0, :3], (matrix @ [1, 2, 3, 1])[:3], rtol=1e-6)
    assert scene.spheres["center_radius"][0, 3] == 1.0
    assert scene.quadrics["center"][0, :3].tolist() == [1.0, 4.0, 3.0]
    assert scene.quadrics["reach"][0, :3] == pytest.approx([1.5, 5.0, 3.5], rel=1e-4)


def test_a_disk_turns_and_grows_with_a_similarity() -> None:
    scene = flat(DISK | {"transform": [{"scale": 3.0}, {"rotate": ["x", 90.0]}]})
    np.testing.assert_allclose(scene.disks["center_radius"][0], [0, 0, 3, 6], atol=1e-6)
    np.testing.assert_allclose(scene.disks["normal"][0, :3], [0, -0.8, 0.6], atol=1e-6)
    mirrored = flat(DISK | {"transform": [{"scale": [1.0, -1.0, 1.0]}]})
    np.testing.assert_allclose(mirrored.disks["normal"][0, :3], [0, -0.6, 0.8], atol=1e-6)


@pytest.mark.parametrize("shape", [DISK, CYLINDER | {"caps": True}])
def test_what_would_need_an_elliptic_disk_is_refused_by_name(shape: dict[str, Any]) -> None:
    scene = Scene(shapes=[SPHERE, shape | {"transform": UNEVEN}], source="room.toml")
    with pytest.raises(SceneError, match=r"^room\.toml: shapes\[1\]\.transform: .*one scale for all axes$"):
        flatten(scene)
    assert kinds(flat(CYLINDER | {"transform": UNEVEN})) == ["QUADRIC"]


@pytest.mark.parametrize(
    ("shape", "text"),
    [
        (SPHERE | {"center": [2.0, 0, 0], "transform": [{"scale": 3e38}]}, r"beyond 1e\+15"),
        (SPHERE | {"center": [3.4e38, 0, 0], "radius": 3e37}, r"beyond 1e\+15"),
        (MIXED | {"transform": [{"scale": 3e38}, {"translate": [3e38, 0, 0]}]}, r"beyond 1e\+12"),
        (SQUARE | {"transform": [{"scale": 3e38}]}, r"beyond 1e\+15"),
        (CYLINDER | {"transform": [{"scale": 3e38}]}, r"beyond 1e\+15"),
        (
            SQUARE
            | {"transform": [{"scale": 1e-4}, {"translate": [1e5, 0, 0]}, {"translate": [0, 1e5, 1e5]}]},
            "no area",
        ),
    ],
)
def test_what_float32_cannot_hold_is_refused_by_name(shape: dict[str, Any], text: str) -> None:
    scene = Scene(shapes=[SPHERE, CYLINDER, shape], source="room.toml")
    with pytest.raises(SceneError, match=rf"^room\.toml: shapes\[2\]: .*{text}") as caught:
        flatten(scene)
    assert "\n" not in str(caught.value)


def test_a_face_of_a_mesh_that_float32_flattens_to_a_line_is_kept_and_never_hit() -> None:
    far = [{"scale": 1e-4}, {"translate": [1e5, 1e5, 1e5]}]
    scene = flat(MIXED | {"transform": far}, SPHERE)
    assert kinds(scene) == ["TRIANGLE", "POLYGON", "TRIANGLE", "SPHERE"]
    assert scene.polygons["normal"][0, :3].tolist() == [0, 0, 0]


def test_the_hash_is_stable_and_sees_every_change() -> None:
    light = {"type": "point", "position": [1, 2, 3]}
    first = flat(SPHERE, PLANE, lights=[light]).hash
    assert first == flat(SPHERE, PLANE, lights=[light]).hash and len(first) == 64
    others = [
        flat(PLANE, SPHERE, lights=[light]),
        flat(SPHERE | {"radius": math.nextafter(0.5, 1) + 1e-7}, PLANE, lights=[light]),
        flat(SPHERE | {"material": {"color": 0.81}}, PLANE, lights=[light]),
        flat(SPHERE, PLANE, lights=[light | {"falloff": "inverse-square"}]),
        flat(SPHERE, PLANE, lights=[light], ambient=0.1),
        flat(SPHERE, PLANE),
    ]
    assert len({first, *(scene.hash for scene in others)}) == 7


def test_what_is_hit_has_a_normal() -> None:
    """Slivers that are lines in float32, which rounding gives an area where a ray sees them."""
    draw = np.random.default_rng(5)
    start = draw.uniform(-2, 2, (4000, 3)).astype(np.float32)
    step = draw.uniform(-1, 1, (4000, 3)).astype(np.float32) / 256
    corners = np.stack([start, start + step * 3, start + step * 8], axis=1)
    ends = corners.reshape(-1, 3)
    mesh = {"type": "mesh", "vertices": ends.tolist(), "faces": np.arange(len(ends)).reshape(-1, 3).tolist()}
    tracer = clrt.Tracer(clrt.load_dict({"shapes": [mesh]}))
    aims = (corners[:, :2].mean(axis=1) + corners[:, 2]) / 2
    hits = 0
    for _ in range(8):
        origins = draw.normal(size=(4000, 3)) * 6
        found = tracer.intersect(origins, aims - origins, fields=("primitive", "normal"))
        seen = found.primitive >= 0
        assert np.isfinite(found.normal).all()
        hits += int(seen.sum())
    assert hits > 10  # others are seen though they are as thin


def test_a_mesh_of_half_a_million_triangles_takes_no_loop_over_them() -> None:
    side = 500
    x, y = np.meshgrid(np.arange(side + 1.0), np.arange(side + 1.0))
    vertices = np.stack([x, y, np.sin(x * y)], axis=-1).reshape(-1, 3)
    first = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).reshape(-1)
    low = np.stack([first, first + 1, first + side + 2], axis=1)
    high = np.stack([first, first + side + 2, first + side + 1], axis=1)
    scene = Scene(shapes=[{"type": "mesh", "vertices": vertices, "faces": np.concatenate([low, high])}])
    start = time.process_time()  # others may hold the core meanwhile
    result = flatten(scene)
    assert time.process_time() - start < 4.0  # 0.3 s
    assert len(result.boxes) == 2 * side * side
    last = result.triangles[-1]
    np.testing.assert_array_equal(last["v0"][:3], vertices[high[-1, 0]].astype(np.float32))
