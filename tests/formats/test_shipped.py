"""Scenes by what the user calls them: files, names of those that ship, dicts, and scenes themselves."""

from __future__ import annotations

from pathlib import Path

import pytest

import clrt
from clrt.base.resources import shipped_scenes
from clrt.formats.shipped import as_scene

SCENE = {"shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}]}


@pytest.mark.parametrize("name", ["tetrahedron", "scenes/tetrahedron.py", shipped_scenes()["tetrahedron"]])
def test_a_scene_that_a_script_makes(name: str | Path) -> None:
    scene = clrt.load(name)
    assert scene.source == "tetrahedron.py" and len(scene.shapes) == 2
    with pytest.raises(clrt.SceneError, match="there is no option 'smooth' for scenes that are generated"):
        clrt.load(name, smooth=True)


def test_other_scripts_are_not_run(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w')")
    with pytest.raises(clrt.ClrtError, match=r"a\.py"):
        clrt.load(tmp_path / "a.py")
    assert not (tmp_path / "ran").exists()


def test_what_stands_for_a_scene() -> None:
    scene = clrt.load_dict(SCENE)
    assert as_scene(scene) is scene and as_scene(SCENE) == scene
    assert as_scene("tetrahedron") == as_scene(Path("tetrahedron")) == clrt.load("tetrahedron")
    with pytest.raises(clrt.LimitError):
        as_scene("tetrahedron", clrt.Limits(primitives=3))
    with pytest.raises(clrt.ClrtError, match=r"scene: 5 is not allowed; it must be a clrt\.Scene, a dict"):
        as_scene(5)
