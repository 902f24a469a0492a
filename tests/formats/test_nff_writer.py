"""Scenes as NFF files: what is written is read back, and by a second reader; what NFF lacks is refused."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

import clrt
from clrt.cli import main
from clrt.formats.nff.writer import to_nff
from clrt.scene.scene import Scene
from tests.growth import check_growth
from tests.second_readers import nff

LEVEL = math.sqrt(2) / 4
SCENE: dict[str, Any] = {
    "max_depth": 4, "ambient": LEVEL, "background": [0.1, 0.2, 0.3],
    "camera": {"origin": [2, 1, 1], "target": [0, 0.5, 0], "fov": 50, "width": 64, "height": 48},
    "materials": {
        "red": {"color": [1, 0.25, 0.1], "diffuse": 0.7, "specular": 0.2, "reflection": 0.2, "shininess": 9},
        "clear": {"color": 0.5, "diffuse": 0.1, "transmission": 0.8, "ior": "water"},
    },
    "lights": [{"type": "point", "position": [1, 2, 3], "intensity": 0.4},
               {"type": "point", "position": [4, 5, 6], "intensity": [0.5, 0.6, 0.7]}],
    "shapes": [
        {"type": "sphere", "center": [1, 2, 3], "radius": 0.1, "material": "clear"},
        {"type": "cylinder", "p0": [0, 0, 0], "p1": [0, 1, 2], "radius": 1e-5, "material": "red"},
        {"type": "cone", "p0": [0, 0, 0], "r0": 1.5, "p1": [0, 2, 2], "r1": 0, "material": "red"},
        {"type": "polygon", "points": [[0, 1, 0], [1, 1, 0], [4, 0, 0], [1, 4, 0]], "material": "red"},
        {"type": "mesh", "vertices": [[0, 0, 1], [2, 0, 1], [2, 2, 1], [0, 2, 1]],
         "faces": [[0, 1, 2, 3], [0, 2, 3]]},
        {"type": "mesh", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]],
         "normals": [[0, 0, 1], [0, 0.6, 0.8], [0.6, 0, 0.8]]},
    ],
}  # fmt: skip


def changed(**changes: Any) -> Scene:
    return clrt.load_dict(SCENE).replace({name.replace("__", "."): value for name, value in changes.items()})


def corners(shape: Any) -> list[np.ndarray]:
    """The outlines, with normals where there are some."""
    data = shape.data()
    rows = data.vertices if data.normals is None else np.c_[data.vertices, data.normals]
    return [rows[face] for face in data.faces]


def test_what_is_written_is_read_back(tmp_path: Path) -> None:
    """But for names, and the first point of a polygon: it has to be one that turns as the outline does."""
    source, out = tmp_path / "a.toml", tmp_path / "a.nff"
    scene = clrt.load_dict(SCENE)
    scene.save(source)
    assert main(["convert", str(source), str(out)]) == 0
    back = clrt.load(out)
    ours, theirs = scene.camera, back.camera
    assert ours is not None and theirs is not None and theirs.fov_axis == "vertical"
    assert (theirs.origin, theirs.target, theirs.up) == (ours.origin, ours.target, ours.up)
    np.testing.assert_allclose(theirs.half_extents(64, 48), ours.half_extents(64, 48), rtol=1e-12)
    assert (back.ambient, back.background, back.max_depth) == (scene.ambient, scene.background, 4)
    assert [light.position for light in back.lights] == [light.position for light in scene.lights]
    assert [light.intensity for light in back.lights] == [(0.4, 0.4, 0.4), (0.5, 0.6, 0.7)]
    for one, other in zip(scene.shapes, back.shapes, strict=True):
        a, b = scene.material_of(one), back.material_of(other)
        assert (a.ka, a.diffuse, a.specular, a.kr, a.shininess, a.kt, a.ior_d) == (
            b.ka, b.diffuse, b.specular, b.kr, b.shininess, b.kt, b.ior_d)  # fmt: skip
        assert b.color == (a.color if isinstance(a.color, tuple) else (a.color,) * 3)
        assert one.type == other.type
    for one, other in zip(scene.shapes[:3], back.shapes[:3], strict=True):
        assert other == replace(one, material=other.material)
    points = scene.shapes[3].points
    assert back.shapes[3].points == (*points[1:], points[0])
    for one, other in zip(scene.shapes[4:], back.shapes[4:], strict=True):
        for mine, read in zip(corners(one), corners(other), strict=True):
            np.testing.assert_array_equal(mine, read)
    assert to_nff(back) == out.read_text()


def test_a_second_reader_finds_what_the_scene_says() -> None:
    said = nff(to_nff(clrt.load_dict(SCENE)))
    (view,) = said["view"]
    assert view["from"] == (2, 1, 1) and view["resolution"] == (64, 48) and view["hither"][0] > 0
    rows = 2 * math.tan(math.radians(25)) / 64  # spacing of pixels a unit away
    assert math.isclose(2 * math.tan(math.radians(view["angle"][0] / 2)) / 47, rows)
    assert said["l"] == [((1, 2, 3), (0.4,) * 3), ((4, 5, 6), (0.5, 0.6, 0.7))]
    assert said["f"] == [(0.5, 0.5, 0.5, 0.1, 0, 32, 0.8, 1.333), (1, 0.25, 0.1, 0.7, 0.2, 9, 0, 1.5),
                         (0.8, 0.8, 0.8, 1, 0, 32, 0, 1.5)]  # fmt: skip
    assert said["s"] == [(0, (1, 2, 3, 0.1))]
    assert said["c"] == [(1, (0, 0, 0, 1e-5, 0, 1, 2, 1e-5)), (1, (0, 0, 0, 1.5, 0, 2, 2, 0))]
    assert [(fill, len(points)) for fill, points in said["p"]] == [(1, 4), (2, 4), (2, 3)]
    assert said["pp"] == [(2, [(0, 0, 0, 0, 0, 1), (1, 0, 0, 0, 0.6, 0.8), (0, 1, 0, 0.6, 0, 0.8)])]


def test_a_scene_in_the_dark_and_a_picture_of_one_row() -> None:
    scene = changed(lights=[], ambient=0, background=1, camera__height=1, camera__fov_axis="vertical")
    said = nff(to_nff(scene))
    assert said["l"] == [] and said["b"] == [(1, 1, 1)]
    assert math.isclose(said["view"][0]["angle"][0], 50)


def test_a_concave_outline_takes_a_time_in_proportion_to_its_corners() -> None:
    """Of a bay with n corners, which all but the last turn the wrong way, and a square around it."""

    def bay(n: int) -> list[tuple[float, float, float]]:
        turn = np.linspace(0.99 * math.pi, 0.01 * math.pi, n)
        around = [(1.5, 0.0, 0.0), (1.5, 2.0, 0.0), (-1.5, 2.0, 0.0), (-1.5, 0.0, 0.0)]
        return [*zip(np.cos(turn).tolist(), np.sin(turn).tolist(), [0.0] * n, strict=True), *around]

    def make(n: int) -> Callable[[], object]:
        scene = changed(shapes=[{"type": "polygon", "points": bay(n)}])
        return lambda: to_nff(scene)

    check_growth(make, 2000)
    points = bay(20)
    ((_, written),) = nff(make(20)())["p"]  # type: ignore[arg-type]
    assert written == [*points[18:], *points[:18]]


def test_an_outline_that_begins_straight_is_written_as_it_is() -> None:
    points = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)]
    ((_, written),) = nff(to_nff(changed(shapes=[{"type": "polygon", "points": points}])))["p"]
    assert written == points


def test_a_picture_as_background_is_refused_wherever_it_lies(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "in").mkdir()
    clrt.Image(np.ones((4, 8, 3), np.float32)).save(tmp_path / "in" / "sky.png")
    scene = clrt.load_dict({**SCENE, "background": "sky.png"}, folder=tmp_path / "in")
    scene.save(tmp_path / "in" / "a.toml")
    monkeypatch.chdir(tmp_path)
    assert main(["convert", "in/a.toml", "a.nff"]) == 2
    said = capsys.readouterr().err
    assert "a.toml: background: NFF has red, green and blue only" in said and said.count("\n") == 1


IDENTITY = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 5], [0, 0, 0, 1]]


@pytest.mark.parametrize(("changes", "says"), [
    ({"max_depth": 5}, "max_depth: NFF has no words for 5; readers take 4"),
    ({"ambient": 0.5}, "ambient: NFF has no words for 0.5; readers take 0.35355339059327"),
    ({"shadow": "tinted"}, "shadow: NFF has no words for 'tinted'; readers take 'opaque'"),
    ({"one_sided": "opaque"}, "one_sided: NFF has no words for 'opaque'"),
    ({"background": "D65"}, "background: NFF has red, green and blue only"),
    ({"camera": None}, "camera: missing; an NFF file has a view"),
    ({"camera": {"pose": IDENTITY}}, "camera: NFF has no words for pose and K"),
    ({"camera.K": [[64, 0, 32], [0, 64, 24], [0, 0, 1]]}, "camera: NFF has no words for pose and K"),
    ({"camera.near": 0.5}, "camera.near: NFF has no words for 0.5; readers take 0.0"),
    ({"camera.spp": 16}, "camera.spp: NFF has no words for 16; readers take 1"),
    ({"camera.filter": "tent"}, "camera.filter: NFF has no words for 'tent'; readers take 'box'"),
    ({"lights[1]": {"type": "directional", "direction": [0, 0, 1]}}, "lights[1]: NFF has no directional"),
    ({"lights[0].falloff": "inverse-square"}, "lights[0].falloff: NFF has no words for 'inverse-square'"),
    ({"lights[0].intensity": "D65"}, "lights[0].intensity: NFF has red, green and blue only"),
    ({"materials.red.reflection": 0}, "shapes[1].material.kr: NFF has no words for 0.0; readers take 0.2"),
    ({"materials.red.ambient": 0}, "shapes[1].material.ka: NFF has no words for 0.0; readers take 0.7"),
    ({"spectrum": {"bands": 8}}, "spectrum: NFF has no words for Spectral("),
    ({"materials.red.thin": True}, "shapes[1].material.thin: NFF has no words for True"),
    ({"materials.clear.fresnel": "schlick"}, "shapes[0].material.fresnel: NFF has no words for 'schlick'"),
    ({"materials.clear.color": {"type": "checker"}}, "shapes[0].material.color: NFF has red, green and blue"),
    ({"shapes[0].transform": [{"translate": [1, 0, 0]}]}, "shapes[0].transform: NFF moves nothing"),
    ({"shapes[1].caps": True}, "shapes[1].caps: NFF's cones and cylinders are open"),
    ({"shapes[0]": {"type": "box", "min": [0, 0, 0], "max": [1, 1, 1]}}, "shapes[0]: NFF has no box"),
])  # fmt: skip
def test_what_nff_cannot_say_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], changes: dict[str, Any], says: str
) -> None:
    source, out = tmp_path / "a.toml", tmp_path / "a.nff"
    clrt.load_dict(SCENE).replace(changes).save(source)
    assert main(["convert", str(source), str(out)]) == 2
    said = capsys.readouterr().err
    assert f"a.toml: {says}" in said and said.count("\n") == 1 and not out.exists()
