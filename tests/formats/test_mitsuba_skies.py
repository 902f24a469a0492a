"""Pictures of the sky in Mitsuba's XML: as they are, or decoded where Mitsuba would take them otherwise."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

import clrt
from clrt.cli import main

SKIES = {  # as stored, and how they are written
    "a.tif": {}, "a.bmp": {}, "turned.jpg": {"Orientation": 6}, "layers.exr": {}, "part.exr": {},
    "plain.exr": {}, "plain.png": {},
}  # fmt: skip


@pytest.mark.parametrize("name", SKIES)
def test_skies_that_mitsuba_does_not_read_are_written_as_it_does(name: str, tmp_path: Path) -> None:
    """What it would take for another picture, or refuse; the file is read again with the same bits."""
    values = np.random.default_rng(3).random((8, 16, 4), np.float32)
    exr = name.endswith(".exr")
    spec = oiio.ImageSpec(16, 8, 4 if name == "layers.exr" else 3, oiio.FLOAT if exr else oiio.UINT8)
    for key, value in SKIES[name].items():
        spec.attribute(key, value)
    if name == "layers.exr":
        spec.channelnames = ("R", "G", "B", "left.V")
    if name == "part.exr":
        spec.full_width, spec.full_height = 20, 10
    out = oiio.ImageOutput.create(str(tmp_path / name))
    assert out.open(str(tmp_path / name), spec) and out.write_image(values[..., : spec.nchannels].copy())
    out.close()
    camera = {"origin": [0, 0, 5], "target": [0, 0, 0], "width": 16, "height": 12}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of unlit colours
        scene = clrt.load_dict({"background": name, "camera": camera, "shapes": []}, folder=tmp_path)
        scene.save(tmp_path / "a.toml")
        assert main(["convert", str(tmp_path / "a.toml"), str(tmp_path / "b.xml")]) == 0
        (sky,) = (tmp_path / "b_meshes").iterdir()
        assert (sky.suffix == ".exr") == (name != "plain.png")
        assert (sky.read_bytes() == (tmp_path / name).read_bytes()) == name.startswith("plain")
        assert clrt.render(clrt.load(tmp_path / "b.xml")).hash == clrt.render(scene).hash
    stored, there = (clrt.read_image(file) for file in (tmp_path / name, sky))
    assert np.array_equal(stored, there)
