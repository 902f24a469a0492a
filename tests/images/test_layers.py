"""Layers as pictures: the mapping that docs/layers.md states, through the API and the command."""

from __future__ import annotations

import colorsys
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

import clrt
from clrt import layout
from clrt.base.layers import LAYERS, PICTURES, Layer, check_layers, find
from clrt.cli import main

PAGE = Path(__file__).parents[2] / "docs" / "layers.md"
SCENE = """
max_depth = 1
background = [0.1, 0.2, 0.3]
[camera]
origin = [0.0, 0.0, 5.0]
target = [0.0, 0.0, 0.0]
width = 24
height = 16
[[lights]]
type = "point"
position = [3.0, 5.0, 4.0]
[[shapes]]
type = "sphere"
center = [-0.7, 0.0, 0.0]
radius = 1.0
material = {reflection = 0.4, diffuse = 0.5}
[[shapes]]
type = "sphere"
center = [0.9, 0.0, -1.0]
radius = 1.0
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "two.toml"
    path.write_text(SCENE)
    return path


@pytest.fixture(scope="module")
def image(tmp_path_factory: pytest.TempPathFactory) -> clrt.Image:
    path = tmp_path_factory.mktemp("scene") / "two.toml"
    path.write_text(SCENE)
    return clrt.render(clrt.load(path), layers="all")


def stored(path: Path) -> np.ndarray:
    """The samples of a file as they are in it."""
    source = oiio.ImageInput.open(str(path))
    return source.read_image(source.spec().format)


def page_rows() -> Iterator[str]:
    """The table of docs/layers.md: layers that hold the same stand in one row."""
    names: dict[Layer, list[str]] = {}
    for name, layer in LAYERS.items():
        names.setdefault(layer._replace(sources=()), []).append(f"`{name}`")
        if name == "transmission":
            names[find("generation_0")] = ["`generation_0`, `generation_1`, ..."]
    for layer, of in names.items():
        size = {0: "(h, w, n)", 1: "(h, w)"}.get(layer.values, f"(h, w, {layer.values})")
        kind = "" if layer.kind == "float" else f" {layer.kind}"
        yield f"| {' '.join(of)} | {size}{kind} | {layer.holds} | {PICTURES[layer.picture]} |"


def test_all_are_all_that_the_page_lists(image: clrt.Image):
    table, in_files, _ = PAGE.read_text().split("\n## ", 2)
    assert list(page_rows()) == re.findall(r"^\| `.*", table, re.MULTILINE)
    told = set(re.findall(r"`([\w.]+)`", in_files))
    own = [name for name in LAYERS if find(name).picture not in ("light", "none")]
    assert {*own, *(find(name).names(name)[0] for name in own)} <= told
    assert set(image.layers) == set(LAYERS) - {"xyz", "bands", "uv"} | {"generation_0", "generation_1"}
    for name, layer in image.layers.items():
        assert layer.dtype == layout.dtype(find(name).kind)
        assert layer.shape == ((16, 24) if find(name).values == 1 else (16, 24, find(name).values))
    assert {"xyz", "bands"} < set(check_layers(["all"], 3, spectral=True))
    assert check_layers("depth, normal", 3) == ("depth", "normal")
    assert check_layers(["depth", "all"], 3)[0] == "depth"


def test_light_is_saved_as_the_picture_is(image: clrt.Image, tmp_path: Path):
    image.save_layers(tmp_path / "a.png", exposure=1.0)
    clrt.Image(image.layers["reflection"]).save(tmp_path / "b.png", exposure=1.0)
    assert stored(tmp_path / "a.reflection.png").any()
    assert np.array_equal(stored(tmp_path / "a.reflection.png"), stored(tmp_path / "b.png"))


@pytest.mark.parametrize("bits", [8, 16])
def test_what_is_no_light_stands_in_the_file_as_it_is(image: clrt.Image, tmp_path: Path, bits: int):
    files = image.save_layers(tmp_path / "a.tif", exposure=2.0, bits=bits)
    assert [path.name for path in files] == [f"a.{name}.tif" for name in image.layers]
    top = (1 << bits) - 1
    hit = image.layers["shape"] >= 0
    assert 50 < hit.sum() < hit.size - 50

    depth = stored(tmp_path / "a.depth.tif")
    value = np.where(hit, image.layers["depth"][hit].min() / image.layers["depth"].astype(np.float64), 0)
    assert np.abs(depth - (top * value)[..., None]).max() <= 0.51 + top * 1e-6
    assert depth.max() == top and (depth[~hit] == 0).all() and (depth[hit] > 0).all()

    normal = stored(tmp_path / "a.normal.tif").astype(np.float64)
    assert np.abs(normal - top * (image.layers["normal"] + 1.0) / 2)[hit].max() <= 0.51 + top * 1e-6
    assert (normal[~hit] == 0).all()

    position = stored(tmp_path / "a.position.tif").astype(np.float64)[hit] / top
    points = image.layers["position"][hit].astype(np.float64)
    low, high = np.percentile(points, (5, 95), axis=0)
    assert np.allclose(position, np.clip((points - low) / (high - low), 0, 1), atol=0.51 / top + 1e-6)

    shape = stored(tmp_path / "a.shape.tif")
    colours = [np.unique(shape[image.layers["shape"] == k], axis=0) for k in (-1, 0, 1)]
    assert [len(found) for found in colours] == [1, 1, 1] and (colours[0] == 0).all()
    hues = [colorsys.rgb_to_hsv(*found[0] / top)[0] for found in colours[1:]]
    assert np.allclose(hues, [0, 0.6180339887], atol=2 / 255)


def test_layers_without_a_hit_are_black():
    nothing = np.zeros((4, 5, 3), np.float32)
    layers = {
        "depth": np.full((4, 5), np.inf, np.float32), "position": nothing, "normal": nothing,
        "shape": np.full((4, 5), -1, np.int32),
    }  # fmt: skip
    image = clrt.Image(nothing, layers)
    assert not any(image.layer(name).pixels.any() for name in layers)


def test_one_place_and_other_kinds_of_layers():
    point = np.broadcast_to(np.float32([1, 2, 3]), (2, 2, 3))
    ramp = np.float32([[0.0, 0.25], [0.5, 1.0]])
    image = clrt.Image(np.zeros((2, 2, 3), np.float32), {"position": point, "mine": ramp, "xyz": point})
    assert not image.layer("position").pixels.any()  # all hits in one place: no span to show
    assert np.array_equal(image.layer("mine").pixels[..., 1], ramp)
    assert np.array_equal(image.layer("xyz").pixels, np.full((2, 2, 3), 2, np.float32))
    assert image.layer("mine").metadata["layer"] == "mine"
    names = ("depth", "direct", "mine", "shape")
    assert [name for name in names if find(name).is_light] == ["direct", "mine"]


def test_faults_say_what_to_do(tmp_path: Path, image: clrt.Image):
    with pytest.raises(clrt.ClrtError, match=r"image\.layer\(name\) makes a picture of a layer"):
        clrt.Image(image.layers["depth"])
    with pytest.raises(clrt.ClrtError, match="'detph' is not in this image; it has direct, "):
        image.layer("detph")
    with pytest.raises(clrt.ClrtError, match="rendered without layers"):
        clrt.Image(image.pixels).layer("depth")
    with pytest.raises(clrt.ClrtError, match="holds its layers itself"):
        image.save_layers(tmp_path / "a.exr")
    with pytest.raises(clrt.ClrtError, match="unknown suffix"):
        image.save_layers(tmp_path / "a.gif")
    strange = clrt.Image(image.pixels, {"../up": image.layers["depth"]})
    with pytest.raises(clrt.ClrtError, match="cannot be a part of a file's name"):
        strange.save_layers(tmp_path / "a.png")
    five = {"bands": np.zeros((16, 24, 5), np.float32)}
    bands = clrt.Image(image.pixels, five, wavelengths=(1, 2, 3, 4, 5))
    with pytest.raises(clrt.ClrtError, match=r"5 values a pixel, which only an \.exr holds"):
        bands.layer("bands")
    assert bands.save_layers(tmp_path / "a.png") == []
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--stats", "a.depth.png"], "a.depth.png: --stats writes JSON; give it a name such as stats.json"),
        (["--checkpoint", "a.generation_0.png"], "a.generation_0.png: --checkpoint writes what is finished"),
    ],
)
def test_all_layers_do_not_take_the_place_of_other_files(
    file: Path, options: list[str], says: str, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """The checkpoint is removed in the end, and with it the layer."""
    monkeypatch.chdir(file.parent)
    before = sorted(file.parent.iterdir())
    assert main(["render", str(file), "-o", "a.png", "--layers", "all", *options]) == 2
    assert says in capsys.readouterr().err and sorted(file.parent.iterdir()) == before


def test_all_layers_need_names_that_fit(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = sorted(file.parent.iterdir())
    output = str(file.with_name("x" * 245 + ".png"))
    assert main(["render", str(file), "-o", output, "--layers", "all"]) == 2
    assert "cannot be written" in capsys.readouterr().err and sorted(file.parent.iterdir()) == before


def test_the_command_writes_layers_beside_the_picture(file: Path, capsys: pytest.CaptureFixture[str]):
    out = file.with_name("x.png")
    assert main(["render", str(file), "-o", str(out), "--layers", "depth,reflection"]) == 0
    assert capsys.readouterr().out.splitlines()[1] == "layers: x.depth.png, x.reflection.png"
    assert sorted(path.name for path in file.parent.iterdir()) == [
        "two.toml", "x.depth.png", "x.png", "x.reflection.png",
    ]  # fmt: skip
    assert main(["render", str(file), "-o", str(file.with_name("y.jpg")), "--layers", "all", "--quiet"]) == 0
    assert capsys.readouterr().out == ""
    assert {"y.normal.jpg", "y.generation_1.jpg"} < {path.name for path in file.parent.iterdir()}
    assert main(["render", str(file), "-o", str(file.with_name("z.exr")), "--layers", "all"]) == 0
    assert len(list(file.parent.glob("z*"))) == 1


def test_what_cannot_be_written_is_said_before_rendering(file: Path, capsys: pytest.CaptureFixture[str]):
    file.with_name("x.depth.png").mkdir()
    out = str(file.with_name("x.png"))
    assert main(["render", str(file), "-o", out, "--layers", "depth"]) == 2
    assert "x.depth.png" in capsys.readouterr().err
    assert main(["render", str(file), "-o", out, "--layers", "bands"]) == 2
    assert "bands needs an .exr" in capsys.readouterr().err
    assert not file.with_name("x.png").exists()
