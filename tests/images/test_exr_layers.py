"""Layers in .exr files: the names that other programs read, and layers back from them, old names too."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
import pytest

import clrt
from clrt.base.layers import LAYERS, find
from clrt.images import file as imagefile

H, W = 4, 5
PIXELS = np.arange(3 * H * W, dtype=np.float32).reshape(H, W, 3)
# What programs take for what: `A` and `Z` alone are alpha and depth, letters after a dot one layer's values
CHANNELS = {
    "direct": "direct.R direct.G direct.B", "generation_3": "generation_3.R generation_3.G generation_3.B",
    "depth": "depth.V", "z": "Z", "distance": "distance.V", "position": "position.X position.Y position.Z",
    "normal": "normal.X normal.Y normal.Z",
    "shading_normal": "shading_normal.X shading_normal.Y shading_normal.Z",
    "albedo": "albedo.R albedo.G albedo.B", "shape": "shape.ID", "material": "material.ID", "alpha": "A",
    "crypto_shape": " ".join(f"crypto_shape{level}.{c}" for level in ("00", "01", "02") for c in "RGBA"),
    "xyz": "xyz.X xyz.Y xyz.Z", "uv": "uv.U uv.V",
}  # fmt: skip


def made(name: str) -> np.ndarray:
    """Something to tell layers apart by."""
    known = find(name)
    size = (H, W) if known.values == 1 else (H, W, known.values or 2)
    values = np.random.default_rng(len(name)).integers(-1, 99, size)
    return values.astype(np.int32 if known.kind == "int" else np.float32)


def write(path: Path, channels: Mapping[str, Any], kind: str = "float", **more: Any) -> Path:
    """A file with these channels, of (h, w) each or a number, as others might write it."""
    spec = oiio.ImageSpec(W, H, len(channels), kind)
    spec.channelnames = tuple(channels)
    for name, value in more.items():
        setattr(spec, name, value)
    out = oiio.ImageOutput.create("exr")
    assert out.open(str(path), spec), out.geterror()
    planes = [np.broadcast_to(np.asarray(values, np.float32), (H, W)) for values in channels.values()]
    assert out.write_image(np.stack(planes, axis=2))
    out.close()
    return path


RGB = {"R": PIXELS[..., 0], "G": PIXELS[..., 1], "B": PIXELS[..., 2]}


@pytest.mark.parametrize("name", CHANNELS)
def test_channels_have_the_names_that_others_read(name: str, tmp_path: Path):
    layer = made(name)
    clrt.Image(PIXELS, {name: layer}).save(tmp_path / "a.exr")
    source = oiio.ImageInput.open(str(tmp_path / "a.exr"))
    stored = source.read_image(0, 0, 0, source.spec().nchannels, oiio.FLOAT)
    found = dict(zip(source.spec().channelnames, np.moveaxis(stored, 2, 0), strict=True))
    assert set(found) == {"R", "G", "B", *CHANNELS[name].split()}
    values = np.atleast_3d(layer)
    for number, channel in enumerate(CHANNELS[name].split()):
        assert np.array_equal(found[channel], values[..., number])


def test_all_layers_come_back(tmp_path: Path):
    layers = {name: made(name) for name in (*LAYERS, "generation_0", "generation_12")}
    layers |= {"mine": made("direct"), "number": made("shape").astype(np.float32)}
    layers["depth"][0] = np.inf
    image = clrt.Image(PIXELS, layers, metadata={"scene_hash": "abc"}, wavelengths=(400.5, 612.0))
    back = clrt.read_image(image.save(tmp_path / "a.exr"), layers="all")
    assert set(back.layers) == set(layers) and back.wavelengths == image.wavelengths
    for name, layer in layers.items():
        assert np.array_equal(back.layers[name], layer), name
        assert back.layers[name].dtype == layer.dtype, name
    assert back.hash == image.hash
    assert back.metadata == {"scene_hash": "abc", "version": clrt.__version__}
    assert back.save(tmp_path / "b.exr").read_bytes() == (tmp_path / "a.exr").read_bytes()
    some = clrt.read_image(tmp_path / "a.exr", layers=["z", "shape"])
    assert set(some.layers) == {"z", "shape"} and some.wavelengths == ()
    assert clrt.read_image(tmp_path / "a.exr", layers=[]).layers == {}
    assert np.array_equal(clrt.read_image(tmp_path / "a.exr"), PIXELS)


def test_files_from_before_are_read(tmp_path: Path):
    file = write(tmp_path / "a.exr", {**RGB, "depth.Z": 3.5, "shape.ID": 7, "normal.X": 0, "normal.Y": 1,
                                      "normal.Z": 0})  # fmt: skip
    layers = clrt.read_image(file, layers="all").layers
    assert set(layers) == {"depth", "shape", "normal"}
    assert (layers["depth"] == 3.5).all() and layers["shape"].dtype == np.int32


def test_layers_of_other_programs_are_read(tmp_path: Path):
    file = write(tmp_path / "a.exr", {
        **RGB, "A": 0.5, "View.Diffuse.R": 1, "View.Diffuse.G": 2, "View.Diffuse.B": 3, "View.Diffuse.A": 1,
        "View.Mist.V": 4, "View.Vector.X": 5, "View.Vector.W": 6, "depth": 7, "S0.500nm": 8, "T.1,5nm": 9,
    })  # fmt: skip
    image = clrt.read_image(file, layers="all")
    assert {name: layer.flat[0] for name, layer in image.layers.items() if layer.ndim == 2} == {
        "alpha": 0.5, "View.Mist": 4, "View.Vector.X": 5, "View.Vector.W": 6, "depth": 7, "T": 9,
        "View.Diffuse.A": 1,
    }  # fmt: skip
    assert image.layers["View.Diffuse"][0, 0].tolist() == [1, 2, 3] and image.wavelengths == (500.0,)
    assert image.layers["bands"].shape == (H, W, 1) and len(image.layers) == 9


VIEW = {f"View.Layer.Combined.{channel}": value for value, channel in enumerate("RGBA", 1)}


def test_a_view_layer_of_blender_is_read(tmp_path: Path):
    """Its passes have their own names; what they would take from others stays as it is."""
    file = write(tmp_path / "a.exr", {
        **VIEW, "View.Layer.Depth.Z": 5, "View.Layer.Normal.X": 6, "View.Layer.Normal.Y": 7,
        "View.Layer.Normal.Z": 8, "View.Layer.DiffCol.R": 9, "View.Layer.DiffCol.G": 10,
        "View.Layer.DiffCol.B": 11, "View.Layer.IndexOB.X": 12, "Other.Mist.V": 13, "View.Layer.Mist.V": 14,
        "Mist.V": 15, "View.Layer.A": 16, "depth.V": 17,
    })  # fmt: skip
    assert (clrt.read_image(file) == (1, 2, 3)).all()
    image = clrt.read_image(file, layers="all")
    assert (image.pixels == (1, 2, 3)).all()
    assert {name: layer.flat[0] for name, layer in image.layers.items() if layer.ndim == 2} == {
        "Depth": 5, "IndexOB": 12, "Other.Mist": 13, "View.Layer.Mist": 14, "Mist": 15, "alpha": 16,
        "View.Layer.Combined": 4, "depth": 17,
    }  # fmt: skip
    assert image.layers["DiffCol"][0, 0].tolist() == [9, 10, 11]
    assert image.layers["Normal"][0, 0].tolist() == [6, 7, 8] and len(image.layers) == 10
    some = clrt.read_image(write(file, {**VIEW, "View.Layer.Depth.Z": 5}), layers=["alpha"])
    assert some.layers.keys() == {"alpha"} and (some.layers["alpha"] == 4).all()


def test_the_picture_itself_goes_before_view_layers(tmp_path: Path):
    image = clrt.read_image(write(tmp_path / "a.exr", {**VIEW, **RGB, "Combined.A": 1}), layers="all")
    assert np.array_equal(image.pixels, PIXELS)
    assert image.layers.keys() == {"View.Layer.Combined", "View.Layer.Combined.A", "Combined"}


def test_what_a_compositor_made_is_the_picture(tmp_path: Path):
    """Blender writes it beside the view layers that it was made of, however many."""
    other = {f"{view}.Combined.{channel}": 9 for view in ("Back", "Front") for channel in "RGBA"}
    made = {"Composite.Combined.R": 1, "Composite.Combined.G": 2, "Composite.Combined.B": 3,
            "Composite.Combined.A": 4}  # fmt: skip
    image = clrt.read_image(write(tmp_path / "a.exr", {**made, **other, "Back.Depth.Z": 5}), layers="all")
    assert (image.pixels == (1, 2, 3)).all() and (image.layers["alpha"] == 4).all()
    assert (image.layers["Back.Combined"] == 9).all() and (image.layers["Back.Depth"] == 5).all()


def test_a_channel_beside_a_layer_of_its_name_is_another_layer(tmp_path: Path):
    """One of the two was lost without a word."""
    file = write(tmp_path / "a.exr", {**RGB, "N": 5, "N.X": 6, "N.Y": 7, "N.Z": 8, "normal": 9, "normal.X": 1,
                                      "normal.Y": 2, "normal.Z": 3, "bands": 4, "S0.500nm": 5})  # fmt: skip
    layers = clrt.read_image(file, layers="all").layers
    assert layers["N"][0, 0].tolist() == [6, 7, 8] and (layers["N."] == 5).all()
    assert layers["normal"][0, 0].tolist() == [1, 2, 3] and (layers["normal."] == 9).all()
    assert (layers["bands"] == 5).all() and (layers["bands."] == 4).all()


def combined(view: str) -> str:
    """The channels of a view layer's picture."""
    return " ".join(f"{view}.Combined.{channel}" for channel in "RGB")


def in_parts(path: Path, *parts: str) -> Path:
    """A file of several parts, each with channels of these names; their numbers count on from 1."""
    specs = []
    for number, channels in enumerate(parts):
        spec = oiio.ImageSpec(W, H, len(channels.split()), "float")
        spec.channelnames = tuple(channels.split())
        spec.attribute("oiio:subimagename", f"part {number}")
        specs.append(spec)
    out, value = oiio.ImageOutput.create("exr"), 0
    assert out.open(str(path), tuple(specs)), out.geterror()
    for number, spec in enumerate(specs):
        assert not number or out.open(str(path), spec, "AppendSubimage")
        values = value + 1 + np.arange(spec.nchannels, dtype=np.float32)
        assert out.write_image(np.broadcast_to(values, (H, W, spec.nchannels)).copy())
        value += spec.nchannels
    out.close()
    return path


@pytest.mark.parametrize(("parts", "pixel"), [
    ((combined("W"), combined("Composite")), (4, 5, 6)), (("Z", combined("V")), (2, 3, 4)),
    ((combined("V"), combined("W"), "R G B"), (7, 8, 9)),
    (("R G B", "Z"), (1, 2, 3)), (("V.Depth.Z", "V.Mist.V"), (1, 1, 1)),
], ids=("composite", "one view layer", "no name", "first", "grey"))  # fmt: skip
def test_the_picture_of_several_parts(parts: tuple[str, ...], pixel: tuple[int, ...], tmp_path: Path):
    """The first part with a picture was taken, whatever its view layer."""
    file = in_parts(tmp_path / "a.exr", *parts)
    assert clrt.read_image(file)[0, 0].tolist() == list(pixel)
    told = rf"a\.exr: it has {len(parts)} parts; layers are read of the one"
    with pytest.warns(clrt.ClrtWarning, match=told):
        clrt.read_image(file, layers="all")


def test_several_view_layers_in_parts_are_refused(tmp_path: Path):
    file = in_parts(tmp_path / "a.exr", combined("Front"), combined("Back"))
    with pytest.raises(clrt.SceneError, match=r"each of its view layers 'Front, Back' has a picture"):
        clrt.read_image(file)


def test_several_view_layers_are_refused(tmp_path: Path):
    two = {f"{view}.Combined.{channel}": 1 for view in ("Front", "Back") for channel in "RGBA"}
    says = r"a\.exr: each of its view layers '(Back, Front|Front, Back)' has a picture; save one of them"
    for layers in (None, "all"):
        with pytest.raises(clrt.SceneError, match=says):
            clrt.read_image(write(tmp_path / "a.exr", two), layers=layers)  # type: ignore[call-overload]
    del two["Back.Combined.G"]
    assert clrt.read_image(write(tmp_path / "a.exr", two), layers="all").layers.keys() >= {"alpha"}
    del two["Front.Combined.G"]
    with pytest.raises(clrt.SceneError, match="R, G and B are read, or a grey one alone"):
        clrt.read_image(write(tmp_path / "a.exr", two))


def test_a_part_of_the_window_is_placed(tmp_path: Path):
    """Half floats, stored three columns to the right of a larger picture's corner."""
    file = write(tmp_path / "a.exr", {**RGB, "Z": 2, "shape.ID": 5}, "half", x=3, y=1, full_width=9,
                 full_height=6)  # fmt: skip
    image = clrt.read_image(file, layers="all")
    assert image.pixels.shape == (6, 9, 3)
    assert (image.layers["z"][1:5, 3:8] == 2).all() and image.layers["z"].sum() == 2 * H * W
    assert image.layers["shape"].sum() == 5 * H * W


def test_other_formats_have_no_layers(tmp_path: Path):
    image = clrt.Image(PIXELS / 60)
    image.save(tmp_path / "a.png")
    assert clrt.read_image(tmp_path / "a.png", layers="all").layers == {}
    with pytest.raises(clrt.ClrtError, match=r"a\.png: has no layer 'z'; it has no layers"):
        clrt.read_image(tmp_path / "a.png", layers=["z"])


def test_faults_say_where(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    file = write(tmp_path / "a.exr", {**RGB, "Z": 2, "shape.ID": 5})
    with pytest.raises(clrt.ClrtError, match=r"has no layer 'light'; its layers are z, shape"):
        clrt.read_image(file, layers=["light"])
    with pytest.raises(clrt.ClrtError, match="has no layer 'shapes'; did you mean 'shape'"):
        clrt.read_image(file, layers=["shapes"])
    with pytest.raises(clrt.ClrtError, match="layers: 5 is not allowed"):
        clrt.read_image(file, layers=5)  # type: ignore[arg-type]
    with pytest.raises(clrt.LimitError, match="image_bytes"):
        clrt.read_image(file, clrt.Limits(image_bytes=700), layers="all")
    twice = write(tmp_path / "b.exr", {**RGB, "S0.500nm": 1, "S0.500,0nm": 2, "S0.510nm": 3})
    with pytest.raises(clrt.SceneError, match=r"b\.exr: two of its channels are the band of 500 nm"):
        clrt.read_image(twice, layers="all")
    for value, words in ((0.5, "is 0.5"), (np.nan, "is nan"), (1e9, "is 1e")):
        bad = np.zeros((H, W))
        bad[2, 1] = value
        write(file, {**RGB, "shape.ID": bad})
        with pytest.raises(clrt.SceneError, match=rf"layer shape, pixel \(1, 2\) {words}.*a whole number"):
            clrt.read_image(file, layers="all")
    clrt.Image(np.random.default_rng(1).random((900, 64, 3), np.float32), {
        "z": np.random.default_rng(2).random((900, 64), np.float32)}).save(file)  # fmt: skip
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) * 2 // 3])
    with pytest.raises(clrt.SceneError, match="cannot be read"):
        clrt.read_image(file, layers="all")
    monkeypatch.setattr(imagefile, "BLOCK", 1)
    file.write_bytes(whole)
    assert clrt.read_image(file, layers="all").layers["z"].shape == (900, 64)
