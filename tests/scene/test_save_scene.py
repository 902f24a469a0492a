"""Scenes that are saved: as they were when they are loaded again, and whole or not at all."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import clrt
from clrt.scene.scene import Scene
from tests.scene_samples import every_kind


@pytest.mark.parametrize("suffix", [".toml", ".json"])
def test_saving_and_loading_gives_an_equal_scene(tmp_path: Path, suffix: str) -> None:
    scene = every_kind()
    scene.save(tmp_path / f"a{suffix}")
    again = clrt.load(tmp_path / f"a{suffix}")
    assert again == scene
    again.save(tmp_path / f"b{suffix}")
    assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()
    assert sorted(file.name for file in tmp_path.iterdir()) == [f"a{suffix}", f"b{suffix}"]


def test_what_would_not_be_read_again_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is written all the same: limits may be raised, as they may have been when it was read."""
    many = clrt.load_dict({"materials": {f"m{k}": {"diffuse": 0.5} for k in range(1 << 17)}, "shapes": []})
    with pytest.warns(clrt.ClrtWarning, match=r"a\.toml: it is not read again .*: tables: .* as JSON"):
        many.save(tmp_path / "a.toml")
    with pytest.raises(clrt.LimitError, match="tables: "):
        clrt.load(tmp_path / "a.toml")
    assert clrt.load(tmp_path / "a.toml", limits=clrt.Limits(tables=1 << 20)) == many
    many.save(tmp_path / "a.json")
    assert clrt.load(tmp_path / "a.json") == many
    monkeypatch.setattr("clrt.scene.save.Limits", lambda: clrt.Limits(text_bytes=1000))
    with pytest.warns(clrt.ClrtWarning, match=r"a\.json: it is not read again .*: text_bytes: "):
        many.save(tmp_path / "a.json")


def test_saving_elsewhere_keeps_the_meshes(tmp_path: Path) -> None:
    pytest.importorskip("trimesh", reason="needs the optional dependency clrt[mesh]")
    (tmp_path / "in").mkdir()
    (tmp_path / "out").mkdir()
    (tmp_path / "in" / "tri.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    scene = clrt.load_dict({"shapes": [{"type": "mesh", "file": "tri.obj"}]}, folder=tmp_path / "in")
    scene.save(tmp_path / "in" / "a.toml")
    scene.save(tmp_path / "out" / "a.toml")
    scene.save(tmp_path / "a.toml")
    assert clrt.load(tmp_path / "in" / "a.toml") == scene
    assert clrt.load(tmp_path / "a.toml").shapes[0].file == "in/tri.obj"
    inline = clrt.load(tmp_path / "out" / "a.toml").shapes[0]
    assert inline.file is None
    np.testing.assert_array_equal(inline.data().vertices, scene.shapes[0].data().vertices)
    np.testing.assert_array_equal(inline.data().faces, scene.shapes[0].data().faces)


def test_saving_away_from_the_background_image_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "sky.exr").write_bytes(b"")
    scene = Scene(background="sky.exr", folder=tmp_path / "in")
    assert scene.background_path == tmp_path.resolve() / "in" / "sky.exr"
    scene.save(tmp_path / "a.json")
    assert json.loads((tmp_path / "a.json").read_text()) == {"background": "in/sky.exr"}
    (tmp_path / "out").mkdir()
    with pytest.raises(clrt.SceneError, match=r"background: 'sky.exr' is not in .*out"):
        scene.save(tmp_path / "out" / "a.json")
    assert list((tmp_path / "out").iterdir()) == []


@pytest.mark.parametrize("place", ["background", "material"])
def test_beside_a_copy_of_its_image_a_scene_may_be_saved(tmp_path: Path, place: str) -> None:
    for folder in ("in", "out"):
        (tmp_path / folder).mkdir()
    clrt.Image(np.full((4, 8, 3), 0.5, np.float32)).save(tmp_path / "in" / "sky.png")
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
    material = {"material": {"color": {"type": "image", "file": "sky.png"}}}
    table = {"background": "sky.png"} if place == "background" else {"shapes": [ball | material]}
    scene, copy = clrt.load_dict(table, folder=tmp_path / "in"), tmp_path / "out" / "sky.png"
    for other in (b"other", b""):
        copy.write_bytes(other)
        with pytest.raises(clrt.SceneError, match=r"'sky.png' in .*out is another file than the one in "):
            scene.save(tmp_path / "out" / "a.toml")
    copy.write_bytes((tmp_path / "in" / "sky.png").read_bytes())
    scene.save(tmp_path / "out" / "a.toml")
    assert clrt.load(tmp_path / "out" / "a.toml").to_dict() == scene.to_dict()
    copy.unlink()
    copy.mkdir()
    with pytest.raises(clrt.SceneError, match="is another file"):
        scene.save(tmp_path / "out" / "a.toml")


def test_an_interrupted_save_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.json"
    Scene().save(path)
    old = path.read_bytes()

    def fail(*args: object) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", fail)
    with pytest.raises(clrt.ClrtError, match="No space left"):
        every_kind().save(path)
    assert path.read_bytes() == old
    assert [file.name for file in tmp_path.iterdir()] == ["a.json"]
