"""Files that are no scenes, or cannot be read or written: one line that says which, where and why."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import clrt
from clrt.scene.scene import Scene
from tests.scene.test_bad_input import check_message

# (file name, contents, parts of the message)
FILES: list[tuple[str, bytes, list[str]]] = [
    ("a.toml", b"max_depth = 3\nambient = = 2\n", ["a.toml", "wrong syntax", "line 2"]),
    ("a.toml", b"max_depth = 3\nmax_depth = 4\n", ["a.toml", "wrong syntax", "line 2"]),
    ("a.toml", b"ambient = nan\n", ["a.toml", "ambient", "nan", "finite"]),
    ("a.toml", b"ambient = 1979-05-27\n", ["a.toml", "ambient", "1979-05-27"]),
    ("a.toml", b"max_depth = 3\nambient = '\xff'\n", ["a.toml", "line 2", "UTF-8"]),
    (
        "a.toml",
        b"[[shapes]]\ntype = 'sphere'\ncenter = [0,0,0]\nradius = -1.0\n",
        ["a.toml", "shapes[0].radius"],
    ),
    ("a.json", b'{"max_depth": 3,\n "ambient": }', ["a.json", "wrong syntax", "line 2"]),
    ("a.json", b'{"ambient": 1, "ambient": 2}', ["a.json", "'ambient' stands twice"]),
    ("a.json", b'{"ambient": NaN}', ["a.json", "NaN", "finite"]),
    ("a.json", b'{"ambient": 1e999}', ["a.json", "ambient", "inf", "finite"]),
    ("a.json", b'{"ambient": ' + b"9" * 5000 + b"}", ["a.json", "digits"]),
    ("a.json", b"[1, 2]", ["a.json", "[1, 2]", "a table of keys"]),
    ("a.toml", rb'a = "C:\Users\me"', ["a.toml", "wrong syntax", "a backslash begins an escape"]),
    ("a.json", rb'{"a": "C:\dir"}', ["a.json", "wrong syntax", "a backslash begins an escape"]),
    ("a.json", b"", ["a.json", "wrong syntax", "line 1"]),
    ("a.json", b'{"materials": {"a\\nb": {"ior": 0}}}', ["a.json", "materials.'a\\nb'.ior", "0"]),
    ("a.json", b'{"materials": {"\\ud800": {"ior": 0}}}', ["a.json", "materials.'\\ud800'.ior", "0"]),
    ("a.json", b'{"ambient": ' + b"[" * 100_000 + b"]" * 100_000 + b"}", ["a.json", "nesting"]),
    ("a.toml", b"ambient = " + b"[" * 80 + b"]" * 80, ["a.toml", "nesting"]),
    ("a.toml", b"ambient = " + b"[" * 5000 + b"]" * 5000, ["a.toml", "nesting"]),
    ("a.xyz", b"0 0 0", ["a.xyz", "suffix '.xyz'", ".toml, .json, .nff, .txt, .xml, .obj"]),
    ("a", b"", ["suffix ''", ".toml"]),
    ("a.obj", b"this is no mesh\n", ["a.obj"]),
    ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", ["a.obj"]),
    ("a.obj", b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", ["a.obj", "vertices[0]", "nan", "finite"]),
    ("a.obj", b"v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n", ["a.obj", "at one point"]),
    ("a.ply", b"ply\nformat ascii 1.0\n", ["a.ply", "cannot be read as a mesh"]),
    ("a.glb", b"glTF\0\0\0", ["a.glb", "cannot be read as a mesh"]),
    ("a.stl", b"solid", ["a.stl"]),
    ("a.gltf", b'{"buffers": [{"uri": "../x.bin", "byteLength": 4}]}', ["a.gltf"]),
]


def test_a_folder_is_no_scene(tmp_path: Path) -> None:
    with pytest.raises(clrt.ClrtError) as caught:
        clrt.load(tmp_path)
    check_message(str(caught.value), ["this is a folder", ".toml"])


@pytest.mark.parametrize(("name", "contents", "parts"), FILES)
def test_bad_file(name: str, contents: bytes, parts: list[str], tmp_path: Path) -> None:
    if Path(name).suffix in (".obj", ".ply", ".glb", ".stl", ".gltf"):
        pytest.importorskip("trimesh", reason="needs the optional dependency clrt[mesh]")
    (tmp_path / name).write_bytes(contents)
    with pytest.raises(clrt.ClrtError) as caught:
        clrt.load(tmp_path / name)
    check_message(str(caught.value), parts)


def test_files_that_are_none(tmp_path: Path) -> None:
    for path in (tmp_path / "no.toml", tmp_path / "no" / "no.toml", tmp_path / ("x" * 300 + ".toml")):
        with pytest.raises(clrt.SceneError, match=r"\.toml: (there is no such file|cannot be read)"):
            clrt.load(path)
    (tmp_path / "folder.toml").mkdir()
    os.mkfifo(tmp_path / "pipe.toml")  # reading it would wait for ever
    for name in ("folder.toml", "pipe.toml"):
        with pytest.raises(clrt.SceneError, match="not a file"):
            clrt.load(tmp_path / name)


def test_options_are_those_of_the_format(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text("")
    (tmp_path / "a.nff").write_text("")
    with pytest.raises(clrt.SceneError, match=r"no option 'conformance' for \.toml files"):
        clrt.load(tmp_path / "a.toml", conformance="spd")
    with pytest.raises(clrt.SceneError, match=r"no option 'conformanc' .*did you mean 'conformance'"):
        clrt.load(tmp_path / "a.nff", conformanc="spd")
    with pytest.raises(clrt.SceneError, match="conformance: 'sdp' is not allowed"):
        clrt.load(tmp_path / "a.nff", conformance="sdp")


def test_a_missing_trimesh_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    monkeypatch.setitem(__import__("sys").modules, "trimesh", None)
    with pytest.raises(clrt.SceneError, match=r"pip install trimesh"):
        clrt.load(tmp_path / "a.obj")


@pytest.mark.parametrize("name", ["a.txt", "a.png", "a"])
def test_saving_under_a_foreign_suffix_is_an_error(name: str, tmp_path: Path) -> None:
    with pytest.raises(clrt.SceneError, match=r"saved as \.toml or \.json"):
        Scene().save(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_saving_where_nothing_can_be_written(tmp_path: Path) -> None:
    (tmp_path / "folder.toml").mkdir()
    for path in (tmp_path / "no" / "a.toml", tmp_path / "folder.toml"):
        with pytest.raises(clrt.ClrtError, match=str(path)):
            Scene().save(path)
