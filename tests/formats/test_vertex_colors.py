"""Colours of vertices and faces of PLY files: linear between corners, one on a face."""

from __future__ import annotations

import runpy
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.limits import Limits
from clrt.base.places import At
from clrt.base.resources import scene_folder
from clrt.images.file import decode, uncurved
from clrt.meshfiles.file import open_mesh
from tests.vertex_color_samples import CORNERS, VIEW, expected, seen, write_ply
from validation.oracle64 import render64


@pytest.mark.parametrize("faces", [False, True])
@pytest.mark.parametrize("names", ["r g b", "diffuse_red diffuse_green diffuse_blue"])
def test_colors_of_a_ply_by_other_names(tmp_path: Path, names: str, faces: bool) -> None:
    path = write_ply(tmp_path / "scan.ply", faces)
    usual, text = seen(clrt.load(path))[0], path.read_text()
    for name, other in zip(("red", "green", "blue"), names.split(), strict=True):
        text = text.replace(f"uchar {name}\n", f"uchar {other}\n")
    path.write_text(text)
    np.testing.assert_array_equal(seen(clrt.load(path))[0], usual)
    clrt.load_dict({"shapes": [{"type": "mesh", "file": "scan.ply", "part": 0}]}, folder=tmp_path)
    with pytest.warns(clrt.ClrtWarning, match="its materials and colours are ignored"):
        clrt.load_dict({"shapes": [{"type": "mesh", "file": "scan.ply"}], "ambient": 1}, folder=tmp_path)


def test_usual_names_of_colors_come_first(tmp_path: Path) -> None:
    path = write_ply(tmp_path / "scan.ply")
    usual, lines = seen(clrt.load(path))[0], path.read_text().splitlines()
    at = lines.index("element face 3")
    rows = lines.index("end_header") + 1
    more = [f"property uchar {name}" for name in "rgb"]
    points = [f"{line} 1 2 3" for line in lines[rows : rows + 5]]
    path.write_text("\n".join([*lines[:at], *more, *lines[at:rows], *points, *lines[rows + 5 :], ""]))
    np.testing.assert_array_equal(seen(clrt.load(path))[0], usual)


WHITE = {
    "uchar": 255, "ushort": 65535, "uint16": 65535, "int": 255, "uint": 255, "float": 1.0, "double": 1.0,
}  # fmt: skip
WRONG = [
    ("char", -1), ("short", -255), ("int", 65280), ("uint", 2**32 - 1), ("float", 255.0), ("double", -0.5),
    ("float", float("nan")),
]  # fmt: skip
TYPES = {"uchar": "u1", "char": "i1", "short": "<i2", "ushort": "<u2", "uint16": "<u2", "int": "<i4",
         "uint": "<u4", "float": "<f4", "double": "<f8"}  # fmt: skip


def write_colors(path: Path, kind: str, values: list[Any], binary: bool) -> Path:
    """A triangle whose corners have these values for red, declared as `kind`; green is 0, blue a byte."""
    head = f"ply\nformat {'binary_little_endian' if binary else 'ascii'} 1.0\nelement vertex 3\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz")
    head += f"property {kind} red\nproperty {kind} green\nproperty uchar blue\n"
    head += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    rows = [(0, 0, 0, values[0], 0, 9), (1, 0, 0, values[1], 0, 9), (0, 1, 0, values[2], 0, 9)]
    if not binary:
        text = "".join(" ".join(map(str, row)) + "\n" for row in rows)
        path.write_text(f"{head}{text}3 0 1 2\n")
        return path
    fields = [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("r", TYPES[kind]), ("g", TYPES[kind]), ("b", "u1")]
    face = np.array([(3, (0, 1, 2))], [("n", "u1"), ("i", "<i4", 3)])
    path.write_bytes(head.encode() + np.array(rows, fields).tobytes() + face.tobytes())
    return path


def texels(path: Path) -> np.ndarray:
    """The linear colours (m, 3, 3) of a file's corners, for a model."""
    corners = open_mesh(path.read_bytes(), path, At(path.name), Limits(), apart=True).parts[0].corners
    assert corners is not None
    return corners()


@pytest.mark.parametrize("binary", [False, True])
@pytest.mark.parametrize("kind", WHITE)
def test_colors_are_parts_of_what_is_white_in_their_type(tmp_path: Path, kind: str, binary: bool) -> None:
    share, white = np.array([1.0, 0.8, 0.0]), WHITE[kind]
    values = [type(white)(round(part * white, 6)) for part in share.tolist()]
    found = texels(write_colors(tmp_path / "a.ply", kind, values, binary))
    assert found.dtype == np.float32
    np.testing.assert_allclose(found[0, :, 0], uncurved(share), rtol=1e-6)
    others = decode(np.array([[0, 9]] * 3, np.uint8))
    np.testing.assert_array_equal(found[0, :, 1:], others)


@pytest.mark.parametrize(
    ("kind", "value", "binary"),
    [
        *((*wrong, binary) for wrong in WRONG for binary in (False, True)),
        ("uchar", 256, False), ("uchar", 0.5, False), ("ushort", 65536, False),
    ],
)  # fmt: skip
def test_numbers_that_are_no_colors_are_refused(tmp_path: Path, kind: str, value: Any, binary: bool) -> None:
    path = write_colors(tmp_path / "a.ply", kind, [0, value, 0], binary)
    says = rf"a\.ply: cannot be read as a mesh: vertex 1 has red = \S+, declared as {kind}; of that .* 0 to"
    with pytest.raises(clrt.SceneError, match=says):
        clrt.load(path)
    with pytest.warns(clrt.ClrtWarning, match="its materials and colours are ignored"):
        clrt.load_dict({"shapes": [{"type": "mesh", "file": "a.ply"}], "ambient": 1}, folder=tmp_path)


def test_colors_of_faces_with_more_corners(tmp_path: Path) -> None:
    """trimesh puts triangles first, then halves of quadrilaterals, then fans."""
    text = write_ply(tmp_path / "a.ply", faces=True).read_text()
    head = text[: text.index("end_header")].replace("element face 3", "element face 4")
    points = "".join(f"{x} {y} 0\n" for x, y, *_ in CORNERS)
    rows = "4 0 1 2 3 255 0 0\n3 2 4 3 0 255 0\n5 0 1 2 4 3 0 0 255\n4 0 2 4 3 9 9 9\n"
    (tmp_path / "a.ply").write_text(f"{head}end_header\n{points}{rows}")
    found = texels(tmp_path / "a.ply")
    red, green, blue, grey = (255, 0, 0), (0, 255, 0), (0, 0, 255), (9, 9, 9)
    right = np.array([green, red, grey, red, grey, blue, blue, blue], np.uint8)
    np.testing.assert_array_equal(found, np.repeat(decode(right)[:, None], 3, axis=1))


def test_colors_behind_a_long_header(tmp_path: Path) -> None:
    path = write_ply(tmp_path / "scan.ply")
    usual, text = seen(clrt.load(path))[0], path.read_text()
    path.write_text(text.replace("element vertex", "comment so\n" * 50_000 + "element vertex"))
    np.testing.assert_array_equal(seen(clrt.load(path))[0], usual)
    path.write_text(text.replace("element vertex", "comment so\n" * 100_000 + "element vertex"))
    with pytest.raises(clrt.SceneError, match="its header does not end within 1048576 bytes"):
        clrt.load(path)


def test_a_texture_of_a_ply_is_named(tmp_path: Path, recwarn: pytest.WarningsRecorder) -> None:
    path = write_ply(tmp_path / "scan.ply")
    colored = path.read_text().replace("element vertex", "comment TextureFile a b.png\nelement vertex")
    grey = colored.replace("uchar red", "uchar rod")
    uv = colored.replace("float z\n", "float z\nproperty float s\nproperty float t\n")
    for text in (colored, grey):
        path.write_text(text)
        clrt.load(path)
        (said,) = [str(warning.message) for warning in recwarn]
        assert said == "scan.ply: left out, since there is no counterpart: the texture 'a b.png'"
        recwarn.clear()
    lines = uv.splitlines()
    first = lines.index("end_header") + 1
    for k, (x, y, *color) in enumerate(CORNERS):
        lines[first + k] = f"{x} {y} 0 {k} 1 {' '.join(map(str, color))}"
    path.write_text("\n".join(lines) + "\n")
    clrt.load(path)
    (said,) = [str(warning.message) for warning in recwarn]
    assert said.endswith("the texture 'a b.png', colours beside uv")
    with pytest.warns(clrt.ClrtWarning, match="its materials and colours are ignored"):
        clrt.load_dict({"shapes": [{"type": "mesh", "file": "scan.ply"}], "ambient": 1}, folder=tmp_path)


@pytest.mark.parametrize("faces", [False, True])
def test_colors_of_vertices_and_faces(faces: bool, tmp_path: Path) -> None:
    scene = clrt.load(write_ply(tmp_path / "scan.ply", faces))
    albedo, position = seen(scene)
    right = expected(position[..., 0], position[..., 1], faces)
    known = np.isfinite(right).all(axis=-1)
    assert known.sum() > 100
    # places in a picture of 4 texels are rounded by some 4 x 2^-23; colours change by 1 a texel
    np.testing.assert_allclose(albedo[known], 0.8 * right[known], atol=4e-6)


def test_the_picture_returns_from_a_scene_file(tmp_path: Path) -> None:
    """As `clrt convert scan.ply scan.toml` writes it; the same bits, and those of the float64 oracle."""
    scene = clrt.load(write_ply(tmp_path / "scan.ply"))
    scene.save(tmp_path / "scan.toml")
    again = clrt.load(tmp_path / "scan.toml")
    table = again.to_dict()["shapes"][0]
    assert table["file"] == "scan.ply" and table["part"] == 0
    assert table["material"]["color"] == {"type": "image", "file": "scan.ply", "part": 0, "wrap": "clamp"}
    small = {"camera.width": 24, "camera.height": 18}
    one, other = (clrt.render(part.replace(small)) for part in (scene, again))
    assert one.hash == other.hash
    oracle = render64(scene.replace(small))
    assert np.quantile(np.abs(oracle.pixels - one.pixels), 0.95) <= 1e-5  # edges aside


def test_what_is_not_there_is_said(tmp_path: Path) -> None:
    write_ply(tmp_path / "scan.ply")
    mesh: dict[str, Any] = {"type": "mesh", "file": "scan.ply", "part": 0}
    image = {"type": "image", "file": "scan.ply"}

    def load(number: int | None, limits: Limits | None = None) -> None:
        color = image if number is None else image | {"part": number}
        table = {**VIEW, "shapes": [mesh | {"material": {"color": color}}]}
        clrt.render(clrt.load_dict(table, folder=tmp_path, limits=limits))

    with pytest.raises(clrt.ClrtError, match="of a model's file say which picture"):
        load(None)
    with pytest.raises(clrt.ClrtError, match=r"images\[1\] is not there; it has its colours"):
        load(1)
    with pytest.raises(clrt.LimitError, match="texture_bytes"):
        load(0, Limits(texture_bytes=100))
    text = (tmp_path / "scan.ply").read_text().replace("uchar red", "uchar rod")
    (tmp_path / "scan.ply").write_text(text)
    with pytest.raises(clrt.ClrtError, match="uv"):
        load(0)
    mesh.clear()
    mesh.update({"type": "sphere", "center": [0, 0, 0], "radius": 1})
    with pytest.raises(clrt.ClrtError, match="it has no colours of vertices or faces"):
        load(0)


def test_the_shell_is_what_its_script_writes() -> None:
    """But for the last bits of sines, which differ between machines."""
    script = runpy.run_path(str(scene_folder() / "generate_shell.py"))
    vertices, _, triangles, _ = script["shell"]()
    (shell,) = clrt.load(scene_folder() / "shell.ply").shapes
    found = shell.data().vertices  # type: ignore[union-attr]
    np.testing.assert_allclose(found, vertices[triangles.reshape(-1)], atol=1e-6)


def test_tints_clip_corners_only(tmp_path: Path) -> None:
    """Colours times a tint are reflectances up to 1 and lights of any size; normals they are not."""
    write_ply(tmp_path / "scan.ply")
    image = {"type": "image", "file": "scan.ply", "part": 0, "wrap": "clamp"}

    def shown(material: dict[str, Any], layer: str) -> tuple[np.ndarray, np.ndarray]:
        mesh = {"type": "mesh", "file": "scan.ply", "part": 0, "material": material}
        scene = clrt.load_dict({**VIEW, "shapes": [mesh]}, folder=tmp_path)
        layers = clrt.render(scene, layers=(layer, "position")).layers
        place = np.asarray(layers["position"])
        right = expected(place[..., 0], place[..., 1])
        known = np.isfinite(right).all(axis=-1)
        return np.asarray(layers[layer])[known], right[known]

    found, right = shown({"color": 0.0, "diffuse": 0.0, "emission": image | {"tint": [4, 4, 4]}}, "emission")
    np.testing.assert_allclose(found, 4 * right, atol=2e-5)
    found, right = shown({"color": image | {"tint": [0.5, 0.5, 0.5]}, "diffuse": 1.0}, "albedo")
    np.testing.assert_allclose(found, 0.5 * right, atol=4e-6)
    found, _ = shown({"color": image | {"tint": [4, 4, 4]}, "diffuse": 1.0}, "albedo")
    assert found.min() >= 0 and 0.9 < found.max() <= 1
    with pytest.raises(clrt.ClrtError, match=r"scan\.ply: colours of vertices or faces are no normals"):
        shown({"normal_map": {"file": "scan.ply", "part": 0}}, "albedo")


HEADER = (
    "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n"
    "property list uchar int vertex_indices\nend_header\n"
)
ENDS = [HEADER[HEADER.index(after) :] for after in ("element f", "end_h")]
NO_ELEMENTS = ("element", "element\t", "element ", "elementvertex 3")
CUTS = [
    *(apart.join([*HEADER.split(apart)[:n], *HEADER.split(apart)[n + 1 :]])
      for apart in (" ", "\n") for n in range(HEADER.count(apart) + 1)),
    *(HEADER[:n] + end for n in range(0, 60, 3) for end in ENDS),
    *(HEADER.replace("element vertex 3", said) for said in NO_ELEMENTS),
]  # fmt: skip


@pytest.mark.parametrize("number", range(len(CUTS)))
def test_headers_that_lack_something_are_read_or_refused(number: int, tmp_path: Path) -> None:
    file = tmp_path / "a.ply"
    file.write_text(CUTS[number] + "0 0 0 255 0 0\n1 0 0 255 0 0\n0 1 0 255 0 0\n3 0 1 2\n")
    for data in ({"shapes": [{"type": "mesh", "file": "a.ply"}]}, None):
        with suppress(clrt.ClrtError):
            clrt.load(file) if data is None else clrt.load_dict(data, folder=tmp_path)
