"""Cameras and lights of glTF models, as docs/models.md says."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.errors import SceneError
from clrt.scene.scene import Camera, DirectionalLight, PointLight, SpotLight
from tests.model_samples import CAMERA, METAL, POINT, SPOT, SUN, model, shining, write_glb

HALF = math.sqrt(0.5)
TURNED = [0.0, HALF, 0.0, HALF]  # a quarter to the left: -z to -x


@pytest.mark.parametrize(
    ("camera", "node", "expected"),
    [
        (CAMERA, {"translation": [0, 1, 6], "scale": [3, 3, 3]}, {
            "origin": [0, 1, 6], "target": [0, 1, 0], "up": [0, 1, 0], "fov": math.degrees(0.75),
            "fov_axis": "vertical", "near": 0.5, "width": 640, "height": 427,
        }),
        # turned away from the model: aimed as far away as the model is large
        ({"type": "perspective", "perspective": {"yfov": 1.0}},
         {"translation": [-9, 1, 0], "rotation": TURNED}, {
            "origin": [-9, 1, 0], "target": [-9 - math.sqrt(33), 1, 0], "up": [0, 1, 0],
            "fov": math.degrees(1.0), "fov_axis": "vertical", "width": 640, "height": 480,
        }),
        ({"type": "orthographic", "orthographic": {"xmag": 2.0, "ymag": -4.0, "znear": 0, "zfar": 9}},
         {"translation": [0, 1, 6]}, {
            "type": "orthographic", "origin": [0, 1, 6], "target": [0, 1, 0], "up": [0, 1, 0],
            "size": 4.0, "width": 240, "height": 480,
        }),
        ({"type": "perspective", "perspective": {"yfov": 1.0, "aspectRatio": 1e9}},
         {"translation": [0, 1, 6], "scale": [-1, 1, 1]}, {
            "origin": [0, 1, 6], "target": [0, 1, 0], "up": [0, 1, 0], "fov": math.degrees(1.0),
            "fov_axis": "vertical", "mirror": True, "width": 640, "height": 10,
        }),
    ],
)  # fmt: skip
def test_cameras(
    tmp_path: Path, camera: dict[str, Any], node: dict[str, Any], expected: dict[str, Any]
) -> None:
    """The middle of `FLOOR` and one `WALL` is (0, 1, 0), half their diagonal the root of 33."""
    table = model([METAL], ({"camera": 0, **node},), cameras=[camera])
    found = clrt.load(write_glb(tmp_path / "a.glb", table)).camera
    right = Camera(**expected)
    assert found is not None
    for name in right.__struct_fields__:
        value = right.stated(name)
        exact = value is None or isinstance(value, (str, bool))
        assert found.stated(name) == (value if exact else pytest.approx(value, abs=1e-12)), name


def test_one_of_several_cameras(tmp_path: Path) -> None:
    nodes = tuple(
        {"camera": 0, "translation": [k, 1, 6], **({"name": name} if name else {})}
        for k, name in enumerate(("front", "front", ""))
    )
    path = write_glb(tmp_path / "a.glb", model([METAL], nodes, cameras=[CAMERA]))
    with pytest.warns(clrt.ClrtWarning, match="no counterpart: the cameras 'front-2', 'camera 2'") as said:
        scene = clrt.load(path)
    assert len(said) == 1 and scene.camera is not None and scene.camera.origin == (0, 1, 6)
    for name, x in (("front-2", 1), ("camera 2", 2)):
        other = clrt.load(path, camera=name).camera
        assert other is not None and other.origin == (x, 1, 6)
    with pytest.raises(SceneError, match=r"a\.glb: camera: 'fornt' .*are front, front-2, camera 2; did you"):
        clrt.load(path, camera="fornt")
    for table in (model([METAL]), model([])):
        write_glb(path, table)
        with pytest.raises(SceneError, match=r"a\.glb: camera: 'x' is not allowed; it has no camera"):
            clrt.load(path, camera="x")
    bare = tmp_path / "b.stl"  # a format that says nothing of how it looks
    bare.write_bytes(b"\0" * 80 + np.uint32(1).tobytes() + np.eye(4, 3, dtype="<f4").tobytes() + b"\0\0")
    with pytest.raises(SceneError, match=r"b\.stl: camera: 'x' is not allowed; it has no camera"):
        clrt.load(bare, camera="x")


def test_lights(tmp_path: Path) -> None:
    nodes = (
        shining(0, translation=[1, 2, 3], scale=[5, 5, 5]), shining(1, rotation=TURNED),
        shining(2, translation=[0, 4, 0], rotation=[-HALF, 0, 0, HALF]),
    )  # fmt: skip
    scene = clrt.load(write_glb(tmp_path / "a.glb", model([METAL], nodes, (POINT, SUN, SPOT))))
    point, sun, spot = scene.lights
    pi = math.pi
    assert point == PointLight(
        position=(1, 2, 3), intensity=(20 / pi, 10 / pi, 5 / pi), falloff="inverse-square"
    )
    assert isinstance(sun, DirectionalLight) and sun.intensity == (2 / pi,) * 3
    np.testing.assert_allclose(sun.direction, [-1, 0, 0], atol=1e-15)
    assert isinstance(spot, SpotLight) and spot.falloff == "inverse-square"
    assert (spot.position, spot.intensity) == ((0, 4, 0), (50 / pi,) * 3)
    assert spot.angle == pytest.approx(math.degrees(0.5)) and spot.penumbra == 0.5
    np.testing.assert_allclose(spot.target, [0, 4 - math.sqrt(33), 0], atol=1e-12)
    assert (scene.ambient, scene.background, scene.shadow) == (0.05, 0.05, "opaque")
