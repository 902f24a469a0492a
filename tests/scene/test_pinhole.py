"""Cameras by pose and K: what follows from them, and what they refuse."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.flatten.flatten import flatten_camera
from validation.oracle64 import render64

POSE = np.array(
    [[0.8, 0, 0.6, -5.1], [0.36, -0.8, -0.48, 4.08], [0.48, 0.6, -0.64, 5.44], [0, 0, 0, 1]]
)
K = np.array([[215, 0, 70], [0, 180, 66.5], [0, 0, 1.0]])
STATED: dict[str, Any] = {"pose": POSE.tolist(), "K": K.tolist(), "width": 160, "height": 120}
BALL = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {"emission": 1}}
PLACED: dict[str, Any] = {"origin": [1, 2, 3], "target": [0, 0.5, 0], "up": [0, 1, 0]}
MIRRORED: dict[str, Any] = {
    "up": (1, 0, 1), "mirror": True, "fov": 30, "fov_axis": "vertical", "width": 160, "height": 120
}  # fmt: skip


def near(one: Any, other: Any) -> bool:
    return np.allclose(one, other)


def by_hand(pose: np.ndarray, k: np.ndarray, width: int, height: int) -> np.ndarray:
    """Directions (h, w, 3) through the pixels' middles, as the textbook has them."""
    y, x = np.mgrid[:height, :width] + 0.5
    seen = np.stack([x, y, np.ones_like(x)], axis=-1) @ np.linalg.inv(k).T @ pose[:3, :3].T
    return np.asarray(seen / np.linalg.norm(seen, axis=-1, keepdims=True))


def test_rays_are_those_of_the_textbook() -> None:
    tracer = clrt.Tracer({"camera": STATED, "shapes": [BALL]})
    for camera, pose, k in (
        (None, POSE, K),
        (clrt.Camera(pose=POSE, K=K, width=160, height=120), POSE, K),
        (clrt.Camera(**PLACED, fov=30, shift=(3, -2), width=160, height=120), None, None),
        (clrt.Camera(**PLACED | MIRRORED), None, None),
    ):
        origins, directions = tracer.camera_rays(camera)
        if camera is not None:
            pose, k = np.array(camera.pose), np.array(camera.K)
        assert np.allclose(origins, pose[:3, 3], atol=1e-6)
        assert np.abs(directions - by_hand(pose, k, 160, 120)).max() < 4e-7, "of float32 a few units"


def test_every_camera_has_both_and_is_the_camera_that_they_make() -> None:
    plain = clrt.Camera(**PLACED, fov=40, width=64, height=48, shift=(1.5, 0))
    assert plain.pose is not None and plain.K is not None
    same = clrt.Camera(pose=plain.pose, K=plain.K, width=64, height=48)
    one, other = flatten_camera(plain)[0], flatten_camera(same)[0]
    for name in ("origin", "forward", "right", "up", "half_width", "half_height", "shift_x", "shift_y"):
        assert np.allclose(one[name], other[name], rtol=0, atol=1e-7), name
    assert same.fov == pytest.approx(40) and same.origin == (1, 2, 3)
    assert plain.K == same.K and clrt.Camera(**PLACED, K=plain.K).K == plain.K, "what one says another takes"
    assert np.allclose(np.linalg.det(np.array(plain.pose)[:3, :3]), 1)
    assert clrt.Camera(**PLACED, type="orthographic").K is None
    assert clrt.Camera(origin=(0, 0, 0), target=(0, 0, 0)).pose is None, "it will be refused where it is used"
    far = np.array(POSE)
    far[:3, 3] *= 1e7
    moved = flatten_camera(clrt.load_dict({"camera": {"pose": far}}).camera)[0]
    assert np.allclose(moved["forward"][:3], POSE[:3, 2], atol=1e-6)


def test_pictures_of_other_sizes_show_as_much() -> None:
    camera = clrt.load_dict({"camera": STATED}).override(width=80, height=90).camera
    assert camera is not None and near(camera.K, np.diag([0.5, 0.75, 1]) @ K)
    small, half = flatten_camera(camera)[0], flatten_camera(clrt.Camera(**STATED), 80, 90)[0]
    assert all(np.array_equal(small[name], half[name]) for name in small.dtype.names)
    assert half["shift_x"] == np.float32(5) and half["half_width"] == np.float32(80 / 215)


@pytest.mark.parametrize(
    "more",
    [{"fov": 40}, {"fov": 40, "fov_axis": "vertical"}, {"type": "orthographic", "size": 3}, {"K": K},
     {"fov": 40, "aperture": 0.1}],
)  # fmt: skip
def test_a_shift_is_the_same_part_of_pictures_of_all_sizes(more: dict[str, Any]) -> None:
    """As pixels of each picture it showed another view; at the camera's own size its bits stay."""
    view = {"origin": (0, 0, 5), "target": (0, 0, 0), "shift": (48.1, -12.3), **more}
    scene = clrt.load_dict({"camera": {**view, "width": 160, "height": 120}, "shapes": [BALL]})
    camera = scene.camera
    assert camera is not None and (camera.has_k or camera.offset(160, 120) == (48.1, -12.3))
    small = scene.override(width=40, height=30).camera
    assert small is not None
    for record in (flatten_camera(camera, 40, 30), flatten_camera(small)):
        assert np.allclose(record["shift_x"], camera.offset(160, 120)[0] / 4)
        assert np.allclose(record["shift_y"], camera.offset(160, 120)[1] / 4)
    whole, alike = clrt.render(scene, 40, 30, spp=1), clrt.render(scene.override(width=40, height=30), spp=1)
    assert np.array_equal(whole.pixels, alike.pixels)
    part = clrt.render(scene, 40, 30, spp=1, crop=(5, 3, 20, 11)).pixels
    assert np.array_equal(part, whole.pixels[3:14, 5:25])
    assert np.abs(render64(scene, 40, 30, 1).pixels - whole.pixels).max() < 1e-3
    fine = clrt.render(scene, 160, 120, spp=1).pixels
    coarse = fine.reshape(30, 4, 40, 4, 3).mean(axis=(1, 3))
    assert 0 < whole.pixels.mean() < 1 and np.abs(coarse - whole.pixels).mean() < 0.04


@pytest.mark.parametrize("suffix", ["toml", "json"])
def test_it_is_written_as_it_was_stated(tmp_path: Path, suffix: str) -> None:
    scene = clrt.load_dict({"camera": STATED, "shapes": [BALL]})
    assert scene.to_dict()["camera"] == STATED, "and nothing that follows from it"
    scene.save(tmp_path / f"scene.{suffix}")
    assert clrt.load(tmp_path / f"scene.{suffix}") == scene


def test_one_way_of_saying_it_takes_the_place_of_the_other() -> None:
    scene = clrt.load_dict({"camera": PLACED, "shapes": [BALL]})
    posed = scene.replace({"camera.pose": POSE, "camera.K": K, "camera.width": 160, "camera.height": 120})
    assert posed.to_dict()["camera"] == STATED
    wide = posed.replace({"camera.fov": 60, "camera.pose[0][3]": -5})
    assert wide.camera is not None and wide.camera.fov == 60 and wide.camera.origin == (-5, 4.08, 5.44)
    back = wide.replace({f"camera.{key}": value for key, value in PLACED.items()})
    assert back.to_dict()["camera"] == {**PLACED, "fov": 60, "width": 160, "height": 120}
    with pytest.raises(clrt.SceneError, match="'target' is missing; a camera has origin and target, or a po"):
        posed.replace({"camera.origin": [1, 2, 3]})


def test_a_camera_given_its_own_k_shows_the_same() -> None:
    """Whether its shift is within that or beside it, as docs/live-scenes.md says; OpenCV's is the whole."""
    for camera in ({**PLACED, "fov": 40}, STATED):
        scene = clrt.load_dict({"camera": {**camera, "shift": [10, 5]}, "shapes": [BALL]})
        assert scene.camera is not None and scene.camera.K is not None
        again = scene.replace({"camera.K": scene.camera.K})
        assert np.allclose(*(clrt.Tracer(s).camera_rays()[1] for s in (scene, again)), atol=1e-6)
        assert again.camera is not None
        whole = np.array(again.camera.K) - np.pad(np.array(again.camera.shift)[:, None], ((0, 1), (2, 0)))
        expected = by_hand(np.array(again.camera.pose), whole, again.camera.width, again.camera.height)
        assert np.allclose(clrt.Tracer(again).camera_rays()[1], expected, atol=1e-6)


def changed(matrix: np.ndarray, place: tuple[int, int], value: float) -> list[list[float]]:
    other = matrix.copy()
    other[place] = value
    return other.tolist()


@pytest.mark.parametrize(("camera", "says"), [
    ({}, "camera: the key 'origin' is missing; a camera has origin and target, or a pose"),
    ({"pose": POSE[:3]}, "camera.pose: "),
    ({"pose": "x"}, "camera.pose: 'x' is not allowed; pose must be a 4 x 4 matrix, camera to world"),
    ({"pose": np.full((4, 4), np.nan)}, "camera.pose[0][0]: nan is not allowed; numbers must be finite"),
    ({"pose": POSE.T}, "a pose ends with the row 0, 0, 0, 1; is this one transposed?"),
    ({"pose": changed(POSE, (3, 3), 2)}, "camera.pose[3]: (0.0, 0.0, 0.0, 2.0) is not allowed; a pose ends"),
    ({"pose": POSE @ np.diag([2, 2, 2, 1])}, "must be of length 1 and at right angles: a rotation; a scale"),
    ({"pose": POSE @ np.diag([1, -1, 1, 1])}, "x is right, y down and z forward; the axes of this one are"),
    ({"pose": POSE, "origin": [0, 0, 0]}, "camera.origin: (0.0, 0.0, 0.0) is not allowed; pose says it alre"),
    ({"pose": POSE, "up": [0, 1, 0]}, "camera.up: (0.0, 1.0, 0.0) is not allowed; pose says it already"),
    ({"pose": POSE, "mirror": True}, "camera.mirror: True is not allowed; pose says where x is"),
    ({"pose": POSE, "aperture": 0.1}, "camera.focus: missing; a camera with a pose has no target"),
    ({**PLACED, "K": [[1, 0], [0, 1]]}, "camera.K: "),
    ({**PLACED, "K": changed(K, (0, 0), 0)}, "camera.K[0][0]: 0.0 is not allowed; a focal length, in pixels"),
    ({**PLACED, "K": changed(K, (1, 1), -180)}, "camera.K[1][1]: -180.0 is not allowed; a focal length"),
    ({**PLACED, "K": changed(K, (0, 1), 0.5)}, "camera.K[0][1]: 0.5 is not allowed; it must be 0"),
    ({**PLACED, "K": changed(K, (1, 0), 0.5)}, "camera.K[1][0]: 0.5 is not allowed; it must be 0"),
    ({**PLACED, "K": changed(K, (2, 2), 0)}, "camera.K[2]: (0.0, 0.0, 0.0) is not allowed; K ends with the"),
    ({**PLACED, "K": changed(K, (1, 2), 1e30)}, "camera.K[1][2]: 1e+30 is not allowed; the principal point"),
    ({**PLACED, "K": K, "fov": 30}, "camera.fov: 30.0 is not allowed; K says it already; leave out fov"),
    ({**PLACED, "K": K, "fov_axis": "vertical"}, "camera.fov_axis: 'vertical' is not allowed; K says both"),
    ({**PLACED, "K": K, "type": "orthographic"}, "camera.K: an orthographic camera has none; give its size"),
])  # fmt: skip
def test_what_is_refused(camera: dict[str, Any], says: str) -> None:
    for make in (dict, lambda **keys: clrt.Camera(**keys)):
        with pytest.raises(clrt.SceneError) as caught:
            clrt.load_dict({"camera": make(**camera), "shapes": [BALL]})
        assert says in str(caught.value) and "\n" not in str(caught.value)


def test_paths_and_circles() -> None:
    one, other = (clrt.Camera(pose=POSE, K=k, width=160, height=120) for k in (K, np.diag([2, 2, 1]) @ K))
    path = clrt.camera_path([one, other], 3)
    assert near(path[1].K, np.diag([1.5, 1.5, 1]) @ K) and near(path[2].K, other.K)
    assert near(path[1].pose, POSE)
    with pytest.raises(clrt.ClrtError, match="one with a pose has no target to go around"):
        clrt.turntable(one, 3)
    with pytest.raises(clrt.ClrtError, match=r"keys\[1\].type: 'orthographic'"):
        clrt.camera_path([one, clrt.Camera(**PLACED, type="orthographic")], 3)
    around = clrt.turntable(clrt.Camera(**PLACED, K=K), 4)
    assert near(around[2].K, K) and around[2].origin == pytest.approx((-1, 2, -3))
