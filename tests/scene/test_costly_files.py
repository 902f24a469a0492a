"""Files that once took far more time or memory than they have bytes, and pictures that were read in part."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

import clrt
from clrt.base.errors import SceneError
from clrt.base.limits import Limits
from clrt.base.resources import validation_module
from clrt.images.file import read_samples
from clrt.images.jpeg import MOST_SCANS
from clrt.meshfiles.obj.mtl import read_mtl
from tests.cost import bounded
from tests.growth import seconds

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def file(folder: Path, name: str, text: str | bytes) -> Path:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def test_empty_lines_of_a_mesh(tmp_path: Path) -> None:
    pytest.importorskip("trimesh", reason="needs the optional dependency clrt[mesh]")
    assert bounded("load", file(tmp_path, "lines.obj", TRIANGLE + "\n" * 300_000)).error == ""
    gltf = json.dumps({"asset": {"version": "2.0"}, "scenes": [{}]}) + "\n" * 300_000
    assert "has no faces" in bounded("load", file(tmp_path, "lines.gltf", gltf)).error


def test_materials_of_a_mesh_are_still_found(tmp_path: Path) -> None:
    pytest.importorskip("trimesh", reason="needs the optional dependency clrt[mesh]")
    text = TRIANGLE.replace("f ", "\n \tusemtl a\nf ")
    assert "materials and colours" in bounded("load", file(tmp_path, "a.obj", text)).warnings[0]


@pytest.mark.parametrize("start", ["", "-0.", "0x", "1e"])
def test_a_number_of_many_digits(tmp_path: Path, start: str) -> None:
    found = bounded("load", file(tmp_path, "a.toml", f"max_depth = {start}{'1' * 4_000_000}"))
    assert f"is a number of {(4_000_000 + len(start)):,} characters".replace(",", " ") in found.error


def test_numbers_of_no_more_digits_than_are_read(tmp_path: Path) -> None:
    text = f"min_weight = 0.{'1' * 4000}\n[materials.{'a' * 5000}]\n[materials.'{'1' * 9000}']"
    assert bounded("load", file(tmp_path, "a.toml", text)).error == ""


@pytest.mark.parametrize("character", ["#", "\\u0041", "\\\\"])
def test_a_long_text_beside_an_error(tmp_path: Path, character: str) -> None:
    text = f'a = "{character * (4_000_000 // len(character))}" # "\nmax_depth = -1\n'
    assert "a.toml:1: unknown key 'a'" in bounded("load", file(tmp_path, "a.toml", text)).error


def test_many_small_meshes(tmp_path: Path) -> None:
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    smooth = {"type": "mesh", "smooth": True, "vertices": corners[:3], "faces": [[0, 1, 2]]}
    assert bounded("load", file(tmp_path, "a.json", json.dumps({"shapes": [smooth] * 20_000}))).error == ""
    plane = {"type": "mesh", "vertices": corners, "faces": [[0, 1, 2, 3]]}
    assert bounded("load", file(tmp_path, "a.json", json.dumps({"shapes": [plane] * 8_000}))).error == ""


MANY = {
    "uv": {"faces": [[0, 1, 2, 3]]},
    "uv of what has no area": {"faces": [[0, 0, 1, 1]], "smooth": True},
    "uv of darts": {"faces": [[0, 1, 4, 3], [0, 1, 2, 4, 3]], "smooth": True},
    "uv of hourglasses": {"faces": [[0, 2, 1, 3]], "smooth": True},
    "uv of triangles and others": {"faces": [[0, 1, 2], [0, 1, 2, 3]]},
}


@pytest.mark.parametrize("case", MANY)
def test_many_small_meshes_with_pictures(tmp_path: Path, case: str) -> None:
    square = [[0, 0], [1, 0], [1, 1], [0, 1], [0.3, 0.2]]
    mesh = {"type": "mesh", "vertices": [[*point, 0] for point in square], "uv": square} | MANY[case]
    assert bounded("read", file(tmp_path, "a.json", json.dumps({"shapes": [mesh] * 15_000}))).error == ""


def test_short_lines_of_a_material() -> None:
    """What a line says is kept in place: it once took 10 times as long as a line that is passed over."""
    said, passed = (b"newmtl a\n" + line * 50_000 for line in (b"Ns 1\n", b"Ka 1\n"))
    ratios = [seconds(lambda: read_mtl(said, "a")) / seconds(lambda: read_mtl(passed, "a")) for _ in range(3)]
    assert min(ratios) < 5


XYZ = "property float x\nproperty float y\nproperty float z\n"
LIST = "property list uchar int vertex_indices\n"
ROWS = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2"


def ply(more: str, body: str, faces: int = 1) -> str:
    head = f"ply\nformat ascii 1.0\nelement vertex 3\n{XYZ}element face {faces}\n{LIST}"
    return f"{head}{more}end_header\n{body}"


def declared(kind: str, count: int) -> str:
    return "".join(f"property {kind} p{k}\n" for k in range(count))


BINARY = np.array(ROWS.split()[:9], "<f4").tobytes() + b"\3" + np.arange(3, dtype="<i4").tobytes()
PLY: dict[str, tuple[str | bytes, str]] = {
    "lists": (
        ply(f"element more 1\n{declared('list uchar uchar', 1500)}", "")
        .replace("ascii", "binary_little_endian").encode() + BINARY + b"\1\0" * 1500,
        "declares 1501 lists; at most 16 are read",
    ),
    "rows of many values": (
        ply(declared("char", 5000), ROWS[:18] + "1 2\n" * 4999 + "1\n", 5000),
        "declares 25 010 012 rows and values in them",
    ),
    "values of few letters": (
        ply(f"{LIST[:-2]}\n{declared('char', 400)}", ROWS[:18] + f"3 0 1 2 0{' 1' * 400}\n" * 6000, 6000),
        "declares 2 418 012 rows and values in them; of a text of its size at most",
    ),
    "behind what is no end": (
        ply(f"comment an_end_header\n{declared('list char char', 17)}", ROWS), "declares 18 lists",
    ),
    "no end": (ply("", ROWS).replace("end_header", "end_headers"), "header does not end"),
    "no count": (ply("", ROWS).replace("face 1", "face +1"), "declares '+1' of 'face', which is no count"),
    "one face": (
        ply("property list uchar float texcoord\n", f"{ROWS} 6 0 0 1 0 0 1"), "has 2 lists of one face",
    ),
    "empty lines": (ply("", f"{ROWS}\n" + "\n" * 3_000_000), ""),
}  # fmt: skip


@pytest.mark.parametrize("case", PLY)
def test_what_a_ply_declares(tmp_path: Path, case: str) -> None:
    pytest.importorskip("trimesh", reason="needs the optional dependency clrt[mesh]")
    text, error = PLY[case]
    found = bounded("load", file(tmp_path, "a.ply", text))
    assert error in found.error and bool(error) == bool(found.error)
    if error:
        with pytest.raises(SceneError, match=re.escape(error)):
            clrt.load(tmp_path / "a.ply")


def test_one_mesh_at_many_places(tmp_path: Path) -> None:
    corpus = validation_module("hostile.run").CORPUS
    text = (corpus / "many_places.gltf").read_bytes()
    assert bounded("read", file(tmp_path, "a.gltf", text)).error == ""


def test_a_large_mesh_that_is_named_too_often(tmp_path: Path) -> None:
    """Its arrays are not made: 5.6 million triangles of 1.3 MB, which one scene may have, but not two."""
    indices, points = np.tile(np.uint32([0, 1, 2]), 80).tobytes(), np.eye(3, dtype=np.float32).tobytes()
    table = {
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [*range(70_000)]}], "nodes": [{"mesh": 0}] * 70_000,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 1}, "indices": 0}]}],
        "accessors": [{"bufferView": 0, "componentType": 5125, "count": 240, "type": "SCALAR"},
                      {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 960},
                        {"buffer": 0, "byteOffset": 960, "byteLength": 36}],
        "buffers": [{"byteLength": 996, "uri": "data:application/octet-stream;base64,"
                     + base64.b64encode(indices + points).decode()}],
    }  # fmt: skip
    file(tmp_path, "many.gltf", json.dumps(table))
    mesh = {"type": "mesh", "file": "many.gltf"}
    for often, smooth in (2000, None), (4, True):
        text = json.dumps({"shapes": [{**mesh, "smooth": smooth}] * often})
        found = bounded("read", file(tmp_path, "a.json", text))
        total = f"{often * 5_600_000:,}".replace(",", " ")
        assert f"a.json: shapes[0].file: primitives: {total} is above the limit" in found.error
    others = [{**mesh, "smooth": True}, mesh, {**mesh, "smooth": []}, [], None]  # none counts with another
    with pytest.raises(SceneError, match=r"shapes\[2\]"):
        clrt.load_dict({"shapes": others}, folder=tmp_path, limits=Limits(primitives=5_600_000 * 2))


def test_flaws_of_small_meshes_are_found() -> None:
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [3, 0, 0], [0, 1, 1]]
    for faces, says in (
        ([[0, 1, 2], [0, 1, 2, 3], [0, 1, 4, 5]], r"faces\[2\]: .* must span an area"),
        ([[0, 1, 2, 3], [0, 1, 2, 6]], r"faces\[1\]: .* must lie in one plane"),
    ):
        with pytest.raises(SceneError, match=says):
            clrt.load_dict({"shapes": [{"type": "mesh", "vertices": corners, "faces": faces}]})


@pytest.fixture
def jpeg(tmp_path: Path) -> bytes:
    spec = oiio.ImageSpec(64, 64, 3, "uint8")
    output = oiio.ImageOutput.create("jpg")
    path = str(tmp_path / "made.jpg")
    assert output.open(path, spec) and output.write_image(np.full((64, 64, 3), 0.25, np.float32))
    output.close()
    return Path(path).read_bytes()


def test_a_jpeg_that_ends_early(tmp_path: Path, jpeg: bytes) -> None:
    whole = read_samples(file(tmp_path, "a.jpg", jpeg))
    again = read_samples(file(tmp_path, "a.jpg", jpeg + b"\xff\xd8 a film"))
    assert whole.tobytes() == again.tobytes()
    for end in range(4, len(jpeg)):
        with pytest.raises(SceneError, match=r"a\.jpg: cannot be read"):
            read_samples(file(tmp_path, "a.jpg", jpeg[:end]))


def test_a_jpeg_with_many_scans(tmp_path: Path, jpeg: bytes) -> None:
    scan = jpeg[jpeg.rindex(b"\xff\xda") : -2]
    end = jpeg[-2:]
    read_samples(file(tmp_path, "a.jpg", jpeg))
    with pytest.raises(SceneError, match=rf"a\.jpg: has more than {MOST_SCANS} scans; save it"):
        read_samples(file(tmp_path, "a.jpg", jpeg[:-2] + scan * MOST_SCANS + end))


def test_a_jpeg_of_too_few_bytes_for_its_size(tmp_path: Path, jpeg: bytes) -> None:
    frame = jpeg.index(b"\xff\xc0") + 5
    wide = jpeg[:frame] + bytes([0x1F, 0xFF] * 2) + jpeg[frame + 4 :]
    found = bounded("picture", file(tmp_path, "a.jpg", wide))
    assert "are not a whole picture of 8191 x 8191 pixels" in found.error
    with pytest.raises(SceneError, match=r"a\.jpg: cannot be read: its \d+ bytes are not a whole picture"):
        read_samples(tmp_path / "a.jpg")


def test_markers_of_a_jpeg_that_stand_alone_or_after_fill_bytes(tmp_path: Path, jpeg: bytes) -> None:
    whole = read_samples(file(tmp_path, "a.jpg", jpeg))
    comment = b"\xff\xff\xff\xfe\x00\x06\xff\xda\xff\xd9"
    again = read_samples(file(tmp_path, "a.jpg", jpeg[:2] + comment + jpeg[2:]))
    assert whole.tobytes() == again.tobytes()
