"""Models as other programs write them: each is read, with its author's colours and parts."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import clrt
from clrt.scene.scene import ImageTexture, Mesh
from tests.foreign_models import MODELS
from tests.foreign_pygltf import BY_HAND


def loaded(name: str, folder: Path) -> clrt.Scene:
    """The scene of a model; no warning may be given."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", clrt.ClrtWarning)
        return clrt.load(MODELS[name](folder))


@pytest.mark.parametrize("name", MODELS)
def test_models_are_read_without_a_word(name: str, tmp_path: Path) -> None:
    scene = loaded(name, tmp_path)
    assert scene.shapes and scene.lights and scene.camera is not None
    for shape in scene.shapes:
        assert isinstance(shape, Mesh) and np.isfinite(shape.data().vertices).all()


def test_names_and_pictures(tmp_path: Path) -> None:
    wood, red = (loaded("Blender's way, obj", tmp_path).materials[name] for name in ("Material.001", "Red"))
    assert isinstance(wood.color, ImageTexture) and wood.color.file == "textures/wood 1.png"
    assert wood.color.scale == (2, 2) and red.color == (0.8, 0.03, 0.02)
    tiles = loaded("glTF, sparse, moved picture", tmp_path).materials["tiles"].color
    assert isinstance(tiles, ImageTexture) and tiles.scale == (4, 2) and tiles.offset == (0.1, 0.25)
    for name in ("trimesh, glb", "trimesh, obj and mtl"):
        scene = loaded(name, tmp_path)
        assert isinstance(scene.material_of(scene.shapes[0]).color, ImageTexture), name


def test_what_pygltflib_writes_is_the_scene_by_hand(tmp_path: Path) -> None:
    scene = loaded("pygltflib, solid glass and glow", tmp_path)
    (tmp_path / "hand.toml").write_text(BY_HAND)
    hand, size = clrt.load(tmp_path / "hand.toml"), {"width": 96, "height": 72}
    image = clrt.render(scene, **size, layers=["shape"])
    assert image.hash == clrt.render(hand, **size).hash and {*np.unique(image.layers["shape"])} == {-1, 0, 1}
    for change in ({"shapes[0].material.ior": 1.5}, {"shapes[1].material.emission": 0.0},
                   {"shapes[0].material.absorption": 0.0}):  # fmt: skip
        assert clrt.render(hand.replace(change), **size).hash != image.hash, f"{change} does not show"


def test_sparse_dents_are_there(tmp_path: Path) -> None:
    whole, dented = loaded("glTF, sparse, moved picture", tmp_path).shapes
    pairs = ((whole, -1.1), (dented, 1.1))
    points = [shape.data().vertices - (x, 0, 0) for shape, x in pairs]  # type: ignore[union-attr]
    far = [np.linalg.norm(vectors, axis=1) for vectors in points]
    assert far[0].min() > 0.999 and far[1].min() == pytest.approx(0.72, abs=1e-5)


@pytest.mark.parametrize(
    "name", ["trimesh, ply", "MeshLab's way, ply", "CloudCompare's way, ply", "FreeCAD's way, ply"]
)
def test_colors_are_kept(name: str, tmp_path: Path) -> None:
    scene = loaded(name, tmp_path)
    color = scene.material_of(scene.shapes[0]).color
    assert isinstance(color, ImageTexture) and color.part == 0 and color.file.endswith(".ply")
