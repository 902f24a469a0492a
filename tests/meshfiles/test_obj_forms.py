"""OBJ files whose faces differ in what their corners have, against a reader of their own."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.meshfiles.obj.lines import formed, mixed_forms
from clrt.scene.scene import ImageTexture, Material, Mesh
from tests.model_samples import PICTURE

NAMES = ("a", "b")
FORMS = ("{0}", "{0}/{1}", "{0}//{2}", "{0}/{1}/{2}")
LIBRARY = "newmtl a\nKd 1 0 0\nnewmtl b\nKd 1 1 1\nmap_Kd a.png\n"
MESH = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nvn .5 0 .8\n"


def written(rng: np.random.Generator) -> str:
    """An OBJ, with a library or without, whose faces have corners of any of the four forms."""
    library = bool(rng.integers(2))
    lines = ["mtllib a.mtl"] if library else []
    lines += [f"v {x} {y} {x * x % 7}" for x, y in rng.permutation(120).reshape(60, 2) / 4]
    lines += [f"vt {u} {v}" for u, v in rng.integers(0, 9, (6, 2)) / 8]
    lines += [f"vn {x} {y} 1" for x, y in rng.integers(-4, 5, (6, 2)) / 4]
    for face in range(rng.integers(2, 9)):
        if library and rng.integers(2):
            lines.append(f"usemtl {rng.choice(NAMES)}")
        form, size = FORMS[rng.integers(4)], rng.integers(3, 6)
        numbers = zip(range(6 * face + 1, 6 * face + 1 + size), *rng.integers(1, 7, (2, size)), strict=True)
        lines.append("f " + " ".join(form.format(*corner) for corner in numbers))
    return "\n".join(lines) + "\n"


def corners(text: str) -> Iterator[tuple[Any, ...]]:
    """Of each corner its place, and what it must have: material, uv, normal; None where it has none."""
    known: dict[str, list[tuple[float, ...]]] = {"v": [], "vt": [], "vn": []}
    material = None
    for words in map(str.split, text.splitlines()):
        if words[0] in known:
            known[words[0]].append(tuple(map(float, words[1:])))
        elif words[0] == "usemtl":
            material = words[1]
        elif words[0] == "f":
            for corner in words[1:]:
                numbers = (*corner.split("/"), "", "")[:3]
                pairs = zip(known, numbers, strict=True)
                v, vt, vn = (known[kind][int(n) - 1] if n else None for kind, n in pairs)
                yield v, material, vt, vn


@pytest.mark.filterwarnings("ignore::clrt.ClrtWarning")
@pytest.mark.parametrize("seed", range(60))
def test_corners_keep_what_they_have(tmp_path: Path, seed: int) -> None:
    text = written(np.random.default_rng(seed))
    (tmp_path / "a.obj").write_text(text)
    (tmp_path / "a.mtl").write_text(LIBRARY)
    (tmp_path / "a.png").write_bytes(PICTURE)
    scene = clrt.load(tmp_path / "a.obj")
    found: dict[tuple[float, ...], list[Any]] = {}
    for shape in scene.shapes:
        assert isinstance(shape, Mesh)
        data, material = shape.data(), scene.material_of(shape)
        for face in data.faces:
            points = data.vertices[face]
            flat = np.cross(points[1] - points[0], points[2] - points[0])
            for k, corner in enumerate(face):
                uv = None if data.uv is None else data.uv[corner]
                normal = None if data.normals is None else data.normals[corner]
                found.setdefault(tuple(points[k].tolist()), []).append((material, uv, normal, flat))
    places = [place for place, *_ in corners(text)]
    assert sorted(found) == sorted(places)
    for place, name, uv, normal in corners(text):
        for material, its_uv, its_normal, flat in found[place]:
            assert isinstance(material, Material)
            assert isinstance(material.color, ImageTexture) == (name == "b" and uv is not None)
            assert name != "a" or material.color == (1.0, 0.0, 0.0)
            if uv is not None:
                assert its_uv == pytest.approx((uv[0], 1 - uv[1]))
            if normal is not None or its_normal is not None:
                way = flat if normal is None else np.array(normal)
                assert its_normal == pytest.approx(way / np.linalg.norm(way), abs=1e-6)


@pytest.mark.parametrize("faces", ["f 1//1 2//2 3//2 4//1\nf 5 6 7", "f 1/1 2/1 3/1\nf 5//1 6//2 7//1"])
def test_a_mesh_keeps_normals_of_some_of_its_faces(tmp_path: Path, faces: str) -> None:
    (tmp_path / "a.obj").write_text(f"{MESH}v 2 0 0\nv 3 0 0\nv 3 1 0\n{faces}\n")
    (shape,) = clrt.load(tmp_path / "a.obj").shapes
    assert isinstance(shape, Mesh) and shape.data().normals is not None


@pytest.mark.parametrize("word", ["1.#IND", "-1.#IND00", "1.#QNAN0", "-1.#INF", "1.#inf00", "1.#SNAN"])
def test_microsofts_numbers_that_are_none(tmp_path: Path, word: str) -> None:
    """In them `#` begins no comment: 3ds Max and others wrote them for normals that could not be made."""
    (tmp_path / "a.obj").write_text(f"v 0 0 0\nv 1 0 0\nv 0 1 {word}\nf 1 2 3\n")
    with pytest.raises(clrt.SceneError, match=r"vertices\[2\]: .* is not allowed; vertices must be finite"):
        clrt.load(tmp_path / "a.obj")
    (tmp_path / "a.obj").write_text(f"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 {word}\nf 1/1 2/1 3/1\n")
    with pytest.raises(clrt.SceneError, match=r"uv\[\d\]: .* is not allowed; uv must be finite"):
        clrt.load(tmp_path / "a.obj")
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0#first\nvn 1 0 0 # x\n"
    (tmp_path / "a.obj").write_text(f"{corners}vn {word} {word} {word}\nf 1//1 2//1 3//2\n")
    with pytest.warns(clrt.ClrtWarning, match="1 of its normals have no direction; those of the triangles"):
        (shape,) = clrt.load(tmp_path / "a.obj").shapes
    assert isinstance(shape, Mesh)
    assert sorted(map(tuple, shape.data().normals)) == [(0, 0, 1), (1, 0, 0), (1, 0, 0)]


def test_faces_of_the_old_kind_are_faces(tmp_path: Path) -> None:
    found = []
    for word in ("f", "fo"):
        (tmp_path / "a.obj").write_text(f"{MESH}f 1 2 3\n{word} 1 3 -1\nf 1 2 4\n")
        (shape,) = clrt.load(tmp_path / "a.obj").shapes
        assert isinstance(shape, Mesh)
        found.append(np.asarray(shape.data().faces))
    assert len(found[0]) == 3 and np.array_equal(*found)


def test_textures_stay_where_there_are_uv(tmp_path: Path) -> None:
    (tmp_path / "a.mtl").write_text(LIBRARY)
    (tmp_path / "a.png").write_bytes(PICTURE)
    faces = "usemtl b\no one\nf 1/1/1 2/1/2 3/1/1\no two\nf 2//1 3//2 4//1\n"
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\n{MESH}{faces}")
    with pytest.warns(clrt.ClrtWarning, match=r"counterpart: textures of 'b' where it has no uv$"):
        scene = clrt.load(tmp_path / "a.obj")
    assert {name: isinstance(m.color, ImageTexture) for name, m in scene.materials.items()} == {
        "b": True, "b-2": False,
    }  # fmt: skip
    scene.save(tmp_path / "a.toml")
    assert clrt.load(tmp_path / "a.toml") == scene


def test_faces_whose_corners_differ_keep_what_all_have() -> None:
    assert formed(b"f 1/2/3 4//5 6//7") == ((False, True), b"f 1//3 4//5 6//7")
    assert formed(b"f 1/2/3 4/5 6/7/") == ((True, False), b"f 1/2 4/5 6/7")
    for form in FORMS:
        plain = "f " + " ".join(form.format(k, k, k) for k in (12, 345, 6)) + "\n"
        assert not mixed_forms(f"{MESH}{plain}{plain}".encode())
        others = [f"f {other.format(7, 8, 9)}\n" for other in FORMS if other != form]
        assert all(mixed_forms(f"{MESH}{plain}{other}".encode()) for other in others)


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("l 1 2 3", "lines"), ("p 1", "points"),
        ("cstype bezier\ndeg 1 1\nsurf 0 1 0 1 1 2 3 4\nend", "free-form surfaces"), ("\tl 1 2", "lines"),
        ("f 1 2", "faces of fewer than 3 corners"),
    ],
)  # fmt: skip
def test_what_is_no_face_is_named(tmp_path: Path, line: str, says: str) -> None:
    (tmp_path / "a.mtl").write_text(LIBRARY)
    for head in ("", "mtllib a.mtl\nusemtl a\n"):
        (tmp_path / "a.obj").write_text(f"{head}{MESH}f 1 2 3\n{line}\n")
        with pytest.warns(clrt.ClrtWarning, match=rf"its {says} are left out$"):
            clrt.load(tmp_path / "a.obj")


@pytest.mark.parametrize("faces", ["", "l 1 2\n", "f 1 2\n", "f 1/1 2/1\nf 3//1 4//1\n"])
def test_materials_of_no_faces(tmp_path: Path, faces: str) -> None:
    (tmp_path / "a.mtl").write_text(LIBRARY)
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\n{MESH}usemtl a\n{faces}")
    with pytest.raises(clrt.ClrtError, match=r"^a\.obj: it has no faces$"):
        clrt.load(tmp_path / "a.obj")


def test_colours_of_vertices_beside_a_library_are_named(tmp_path: Path) -> None:
    (tmp_path / "a.mtl").write_text(LIBRARY)
    vertices = "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\n"
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\n{vertices}usemtl a\nf 1 2 3\n")
    with pytest.warns(clrt.ClrtWarning, match="counterpart: the colours of vertices$"):
        clrt.load(tmp_path / "a.obj")


@pytest.mark.parametrize(("corner", "word"), [("{0}//3", "vn"), ("{0}/2", "vt"), ("{0}/1/3", "vn")])
def test_numbers_that_are_not_there_are_named(tmp_path: Path, corner: str, word: str) -> None:
    face = "f " + " ".join(corner.format(k) for k in (1, 2, 3))
    (tmp_path / "a.obj").write_text(f"{MESH}{face}\n")
    with pytest.warns(clrt.ClrtWarning, match=f"its faces name {word} that are not there"):
        clrt.load(tmp_path / "a.obj")


@pytest.mark.parametrize(
    "line", ["# from C:\\temp\\", "g C:\\temp\\", "o C:\\", "usemtl a\\", "v 0 0 9 # C:\\"]
)
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_folders_end_no_line_over_the_next(line: str, end: str, tmp_path: Path) -> None:
    """A comment or a name that ends in a backslash went on in the next line, whose face was lost."""
    rows = ["v 0 0 0", "v 1 0 0", "v 0 1 0", "v 1 1 0", line, "f 1 2 3", "f 2 4 \\", "3 # C:\\", "f 1 2 4"]
    (tmp_path / "a.obj").write_bytes(end.join([*rows, ""]).encode())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", clrt.ClrtWarning)
        scene = clrt.load(tmp_path / "a.obj")
    assert sum(shape.primitives for shape in scene.shapes) == 3


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
def test_wide_letters_are_named(encoding: str, tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_bytes("\ufeffv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".encode(encoding))
    with pytest.raises(clrt.ClrtError, match=r"a\.obj: .*its text is UTF-16; save it as UTF-8"):
        clrt.load(tmp_path / "a.obj")
