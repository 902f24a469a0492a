"""Scenes on their way to a worker: what they carry, and that they need nothing of where they come from."""

from __future__ import annotations

import multiprocessing
import pickle
import shutil
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.cluster import parcels
from clrt.flatten.flatten import flatten
from tests.farm_samples import SIZE, same

SCENES = Path(__file__).parents[2] / "scenes"
pytestmark = pytest.mark.usefixtures("fresh")


def test_a_scene_forgets_identities_on_its_way(mesh: clrt.Scene) -> None:
    """What is kept by the identity of an array means another one in another process."""
    flat = flatten(mesh)
    right = flat.hash
    copied = pickle.loads(pickle.dumps(flat))
    assert not {"hash", "digests"} & vars(copied).keys() and copied.hash == right
    parcel = parcels.packed(flat)
    assert len(parcel.recipe) < parcels.LARGE < sum(array.nbytes for array in parcel.arrays.values())
    assert parcels.unpacked(right, parcel.recipe, parcel.arrays).hash == right


def test_a_scene_with_media_needs_none_of_its_files_elsewhere(tmp_path: Path) -> None:
    """Where rays start within glass is found by the shapes: as they were read here, whatever lies there."""
    shutil.copy(SCENES / "wood.png", tmp_path)
    shutil.copy(SCENES / "gem.obj", tmp_path)
    glass = {"fresnel": True, "diffuse": 0.0, "absorption": 0.1}
    wood = {"color": {"type": "image", "file": "wood.png"}}
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {**glass, "priority": 1}}
    gem = {"type": "mesh", "file": "gem.obj", "transform": [{"scale": 1.5}], "material": glass}
    floor = {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0], "material": wood}
    flat = flatten(clrt.load_dict({"shapes": [ball, gem, floor]}, folder=tmp_path, source="a.toml"))
    parcel = parcels.packed(flat)
    for file in tmp_path.iterdir():
        file.unlink()
    there = parcels.unpacked(parcel.scene, parcel.recipe, parcel.arrays)
    points = np.random.default_rng(1).normal(size=(500, 3))
    assert flat.media is not None and there.media is not None
    found = flat.media.lists(points)
    assert len(np.unique(found[:, 0])) == 3 and np.array_equal(there.media.lists(points), found)


class Elsewhere(ProcessPoolExecutor):
    """A process that sees none of some files: they are gone before it gets its first order."""

    def __init__(self, files: list[Path]) -> None:
        super().__init__(1, multiprocessing.get_context("spawn"))
        self.files = files

    def submit(self, *arguments: Any, **more: Any) -> Any:
        while self.files:
            self.files.pop().unlink()
        return super().submit(*arguments, **more)


def test_a_picture_needs_none_of_its_files_elsewhere(tmp_path: Path) -> None:
    """Meshes from files, a picture on one of them and on a floor; a worker that has none of these."""
    for name in ("wood.png", "gem.obj"):
        shutil.copy(SCENES / name, tmp_path)
    corners = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    (tmp_path / "tile.obj").write_text(f"{corners}f 1/1 4/4 3/3 2/2\n")
    wood = {"color": {"type": "image", "file": "wood.png"}, "diffuse": 0.8}
    table = {
        "camera": {"origin": [0, 2, 5], "target": [0, 0, 0]},
        "lights": [{"type": "point", "position": [3, 5, 4]}],
        "background": [0.2, 0.3, 0.4],
        "shapes": [
            {"type": "mesh", "file": "gem.obj", "material": {"diffuse": 0.5, "reflection": 0.4}},
            {"type": "mesh", "file": "tile.obj", "transform": [{"translate": [2, 0, 0]}], "material": wood},
            {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0], "material": wood},
        ],
    }
    scene = clrt.load_dict(table, folder=tmp_path, source="a.toml")
    right = clrt.render(scene, **SIZE)
    for shape in (1, 2):
        gray = clrt.render(scene.replace({f"shapes[{shape}].material": {"diffuse": 0.8}}), **SIZE)
        assert gray.hash != right.hash, "the wood is seen"
    with Elsewhere([*tmp_path.iterdir()]) as executor:
        image = clrt.render(scene, executor=executor, **SIZE)
    assert [*tmp_path.iterdir()] == []
    same(image, right)
