"""Files that a scene names, which are others by the time that it is loaded again: a Tracer follows them."""

from __future__ import annotations

import os
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base import files

CAMERA = {"origin": [0, 0, 4], "target": [0, 0, 0], "width": 8, "height": 6}
PICTURE = {"type": "image", "file": "a.exr"}


def sphere(**material: Any) -> dict[str, Any]:
    return {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": material}


LIGHT = {"type": "point", "position": [3, 1, 4]}
SCENES: dict[str, dict[str, Any]] = {
    "color": {"camera": CAMERA, "ambient": 1.0, "shapes": [sphere(color=PICTURE)]},
    "normal_map": {"camera": CAMERA, "lights": [LIGHT], "shapes": [sphere(normal_map={"file": "a.exr"})]},
    "background": {"camera": CAMERA, "background": "a.exr", "shapes": [sphere(reflection=0.9)]},
}


def put(folder: Path, value: float, sides: tuple[int, int] = (4, 4)) -> None:
    pixels = np.full((*sides, 3), value, np.float32)
    pixels[..., 0] *= 0.7  # a normal map of one grey leans alike in all directions
    clrt.Image(pixels).save(folder / "a.exr")


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("sides", [(4, 4), (2, 6)])
def test_a_scene_that_is_loaded_again_has_the_pictures_of_then(
    name: str, sides: tuple[int, int], tmp_path: Path
) -> None:
    put(tmp_path, 0.3)
    tracer = clrt.Tracer(clrt.load_dict(SCENES[name], folder=tmp_path))
    seen = {tracer.render().hash}
    for value in (0.4, 0.6, 0.8):
        put(tmp_path, value, sides)
        scene = clrt.load_dict(SCENES[name], folder=tmp_path)
        assert tracer.update(scene) == "tables"
        seen.add(tracer.render().hash)
        assert tracer.render().hash == clrt.render(scene).hash
    assert len(seen) == 4


@pytest.mark.parametrize("name", SCENES)
def test_pictures_that_are_what_they_were_are_not_read_again(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put(tmp_path, 0.3)
    for back in (10, 5):  # the second time with other times, as if it had been written then
        os.utime(tmp_path / "a.exr", ns=(0, back * 10**9))
        monkeypatch.setattr(files, "_JUST_NOW", 0)
        scene = clrt.load_dict(SCENES[name], folder=tmp_path)
        tracer = clrt.Tracer(scene)
        before = tracer.flat
        again = scene.replace({"ambient": 0.5})
        assert tracer.update(again) == "tables" and tracer.render().hash == clrt.render(again).hash
        held = "background" if name == "background" else "texels"
        assert getattr(tracer.flat, held) is getattr(before, held)
        os.utime(tmp_path / "a.exr", ns=(0, back * 10**9 + 1))
        tracer.update(clrt.load_dict(SCENES[name], folder=tmp_path))
        assert getattr(tracer.flat, held) is not getattr(before, held)


def test_of_what_was_written_just_now_no_version_can_be_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is written into it within the same tick of the clock leaves the same times; nor of no file."""
    file = tmp_path / "a"
    assert files.version(file) is None
    file.write_text("one")
    assert files.version(file) is None
    monkeypatch.setattr(files, "_JUST_NOW", 0)
    assert files.version(file) == files.version(file) is not None


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_keeps_its_folder(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever folder is current when it is rendered, copied or pickled."""
    for folder, value in (("x", 0.2), ("y", 0.9)):
        (tmp_path / folder).mkdir()
        put(tmp_path / folder, value)
    monkeypatch.chdir(tmp_path / "x")
    made = [clrt.load_dict(SCENES[name]), clrt.load_dict(SCENES[name], folder=Path())]
    right = clrt.render(made[0]).hash
    monkeypatch.chdir(tmp_path / "y")
    made += [pickle.loads(pickle.dumps(made[0])), made[0].replace({"max_depth": 4})]
    assert {clrt.render(scene).hash for scene in made} == {right}
    other = clrt.load_dict(SCENES[name])
    tracer = clrt.Tracer(made[0])
    assert tracer.update(other) == "tables" and tracer.render().hash == clrt.render(other).hash != right


def test_scenes_whose_meshes_were_others_are_not_equal(tmp_path: Path) -> None:
    scenes = []
    for z in (0, 0, 3):
        (tmp_path / "m.obj").write_text(f"v -1 -1 {z}\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n")
        scenes.append(clrt.load_dict({"shapes": [{"type": "mesh", "file": "m.obj"}]}, folder=tmp_path))
    assert scenes[0] == scenes[1] and scenes[0] != scenes[2]
    assert scenes[2] == scenes[2].replace({"max_depth": 5})
