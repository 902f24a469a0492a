"""The corners of the loaders that well-meant files never reach: every line of them has a test."""

from __future__ import annotations

import os
from pathlib import Path
from types import MappingProxyType, SimpleNamespace
from typing import Annotated, Any

import numpy as np
import OpenImageIO as oiio
import pytest
from msgspec import Meta

import clrt
from clrt.base import limits
from clrt.base.atomic import replacing
from clrt.base.errors import ClrtError, SceneError
from clrt.base.explain import describe, explain
from clrt.base.files import read_bytes
from clrt.base.places import At
from clrt.images import file as imagefile
from clrt.meshfiles import file as meshfile
from clrt.meshfiles import parts as meshparts
from clrt.meshfiles.outlines import Outlines
from clrt.scene.scene import Mesh, Plane, Scene, Sphere

BALL = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
TRIANGLE = {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]]}


def test_a_pipe_is_not_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "scene.toml")
    with pytest.raises(SceneError, match=r"scene\.toml: is a named pipe, not a file"):
        read_bytes(tmp_path / "scene.toml", clrt.Limits())
    with pytest.raises(SceneError, match=r"gone\.toml: there is no such file"):
        read_bytes(tmp_path / "gone.toml", clrt.Limits())


def test_a_file_that_grows_while_it_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.toml"
    path.write_bytes(b"#" * 50)
    small = SimpleNamespace(st_mode=path.stat().st_mode, st_size=3)
    monkeypatch.setattr("clrt.base.files.os.fstat", lambda descriptor: small)
    with pytest.raises(clrt.LimitError, match="file_bytes: 11 is above the limit of 10"):
        read_bytes(path, clrt.Limits(file_bytes=10))


def test_only_regular_files_are_replaced(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.png")
    with pytest.raises(ClrtError, match=r"a\.png: is a named pipe"), replacing(tmp_path / "a.png"):
        pass
    (tmp_path / "file").write_text("")
    with pytest.raises(ClrtError, match="file is not a folder"), replacing(tmp_path / "file" / "x.png"):
        pass


def test_what_fails_at_the_end_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "a.txt"
    target.write_text("old")

    def refuse(source: Any, into: Any) -> None:
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(os, "replace", refuse)
    said = r"a\.txt: cannot be written: Input/output error"
    with pytest.raises(ClrtError, match=said), replacing(target) as temporary:
        temporary.write_text("new")
    assert [target] == list(tmp_path.iterdir()) and target.read_text() == "old"


def test_folders_are_synchronised_where_possible(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Windows cannot open a folder: there the replacement alone has to do."""
    synced: list[Path] = []
    monkeypatch.setattr("clrt.base.atomic._sync", synced.append)
    for name, folders in (("posix", [tmp_path]), ("nt", [])):
        monkeypatch.setattr("clrt.base.atomic.os", SimpleNamespace(**{**vars(os), "name": name}))
        with replacing(tmp_path / "a.txt"):
            pass
        assert [path for path in synced if path == tmp_path] == folders
        synced.clear()


def test_faults_of_importers_without_a_line_of_their_own(tmp_path: Path) -> None:
    (tmp_path / "a.nff").write_text("b -1 0 0\n")
    with pytest.raises(SceneError, match=r"^a\.nff: background\[0\]: -1\.0 is not allowed"):
        clrt.load(tmp_path / "a.nff")


@pytest.mark.parametrize(
    ("table", "text"),
    [
        ({"shapes": [{**BALL, "radius": 10**39}]}, r"shapes\[0\]\.radius: 10{39} is not allowed; .*float32"),
        ({"materials": {"m": {"color": {"type": "checker", "size": 10**39}}}}, r"m\.color\.size: 10{39}"),
        ({"shadow": "\ud800"}, r"shadow: .*valid Unicode"),
        ({"shapes": [{**BALL, "center": [0, {"x": 10**39}, 0]}]}, r"center\[1\]\.x: 10{39} is not allowed"),
        ({"shapes": [{**BALL, "center": [0, {"x": 1}, 0]}]}, r"center\[1\]: .* must be 3 numbers"),
    ],
)
def test_numbers_and_texts_that_only_fail_late(table: dict[str, Any], text: str) -> None:
    with pytest.raises(SceneError, match=text):
        clrt.load_dict(table)


def test_a_table_whose_fault_cannot_be_found_is_an_error_all_the_same() -> None:
    with pytest.raises(SceneError, match="must be a Sphere"):
        explain(Sphere, BALL, At("a.toml", "shapes[0]"))


def test_rules_without_words_are_described_by_their_type() -> None:
    assert describe(Annotated[float, Meta(ge=0)], "x") == "x must be a number"


def test_a_folder_that_refuses_new_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> int:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "open", refuse)
    with pytest.raises(ClrtError, match=r"a\.txt: .* refuses new files"), replacing(tmp_path / "a.txt"):
        pass


def test_limits_on_the_command_line() -> None:
    assert limits.parse("depth=99") == ("depth", 99)
    for text, said in (("dept=9", "did you mean 'depth'"), ("depth=", "NAME=N"), ("depth=-1", "'-1'")):
        with pytest.raises(ClrtError, match=said):
            limits.parse(text)
    with pytest.raises(ClrtError, match="whole number"):
        limits.parse("depth=" + "9" * 5000)


def test_scenes_and_meshes_equal_only_their_kind() -> None:
    scene = clrt.load_dict({"shapes": [BALL]})
    assert (scene == 3) is False and scene == clrt.load_dict({"shapes": [MappingProxyType(BALL)]})
    assert scene.override(max_depth=3).max_depth == 3
    mixed = {"vertices": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "faces": [[0, 1, 2], [0, 1, 2, 3]]}
    mesh, other = Mesh(**TRIANGLE), Mesh(**mixed)
    assert Scene(shapes=[other]) != Scene(shapes=[{"type": "mesh", **mixed, "faces": [[0, 1, 2]]}])
    assert not scene != clrt.load_dict({"shapes": [BALL]}) and not mesh != Mesh(**TRIANGLE)  # noqa: SIM202
    assert (mesh == 3) is False and mesh == Mesh(**TRIANGLE) and mesh != other
    assert Scene(shapes=[mesh]) != Scene(shapes=[other])
    assert Scene(shapes=[other]) == Scene(shapes=[Mesh(**mixed)])
    assert np.array_equal(Plane(point=(0, 0, 0), normal=(0, 1, 0)).matrix, np.eye(4))


def test_values_of_other_mappings_are_read() -> None:
    nested = MappingProxyType({"type": "checker", "size": np.float32(2)})
    scene = clrt.load_dict({"shapes": [{**BALL, "material": {"color": nested}}]})
    assert scene.material_of(scene.shapes[0]).color.size == 2  # type: ignore[union-attr]


def fake_mesh(vertices: Any, faces: Any, normals: Any = None) -> SimpleNamespace:
    cache = {"vertex_normals": normals} if normals is not None else {}
    return SimpleNamespace(
        vertices=vertices, faces=faces, vertex_normals=normals, visual=SimpleNamespace(defined=False),
        _cache=SimpleNamespace(cache=cache), metadata={},
    )  # fmt: skip


@pytest.mark.parametrize(
    ("mesh", "text"),
    [
        (fake_mesh([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]]), "3 numbers each"),
        (fake_mesh(TRIANGLE["vertices"], [[0, 1, 2]], [[0, 0, 1]]), "3 numbers each"),
        (fake_mesh(TRIANGLE["vertices"], [[0, 1, 2, 0]]), "must be triangles"),
        (fake_mesh(TRIANGLE["vertices"], [[0, 1, 3]]), "not among the 3"),
        (fake_mesh(TRIANGLE["vertices"], [[0, 1, -1]]), "not among the 3"),
    ],
)
def test_meshes_whose_arrays_do_not_fit_together(mesh: Any, text: str) -> None:
    with pytest.raises(ValueError, match=text):
        meshfile._part(mesh, Outlines())


def test_parts_without_normals_join_parts_that_have_them() -> None:
    bare = meshfile._part(fake_mesh(TRIANGLE["vertices"], TRIANGLE["faces"]), Outlines())
    given = meshfile._part(fake_mesh(TRIANGLE["vertices"], TRIANGLE["faces"], [[0, 1, 0]] * 3), Outlines())
    one = np.zeros(2, int)
    placed = meshparts.Placed([bare, given], np.arange(2), one, np.eye(4)[None])
    for smooth in (True, None):
        assert placed.sizes(smooth) == (6, 2)
        assert np.array_equal(placed.joined(smooth)[2], [[0, 0, 1]] * 3 + [[0, 1, 0]] * 3)
    assert placed.joined(False)[2] is None
    smoothed = meshparts.Placed([bare], one, one, np.eye(4)[None]).joined(True)
    assert np.array_equal(smoothed[2], [[0, 0, 1]] * 6) and smoothed[1].tolist() == [[0, 1, 2], [3, 4, 5]]


def test_pictures_of_other_kinds_of_samples(tmp_path: Path) -> None:
    path = tmp_path / "a.tif"
    writer = oiio.ImageOutput.create(str(path))
    writer.open(str(path), oiio.ImageSpec(2, 2, 3, "int8"))
    writer.write_image(np.ones((2, 2, 3), np.int8))
    writer.close()
    with pytest.raises(SceneError, match=r"a\.tif: samples of type int8; 8 or 16 bits or floats are read"):
        imagefile.read_image(path)


def test_pictures_of_many_layers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    closed: list[bool] = []
    spec = oiio.ImageSpec(2, 2, 3, "uint8")
    spec.depth = 5
    deep = SimpleNamespace(
        spec=lambda: spec, close=lambda: closed.append(True), format_name=lambda: "tiff",
        current_subimage=lambda: 0,
    )  # fmt: skip
    monkeypatch.setattr(imagefile.oiio, "ImageInput", SimpleNamespace(open=lambda *_: deep))
    (tmp_path / "a.tif").write_bytes(b"II*\0")
    with pytest.raises(SceneError, match="5 layers of pixels"):
        imagefile.read_image(tmp_path / "a.tif")
    assert closed


def test_a_picture_that_is_interrupted_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(imagefile.np, "concatenate", interrupted)
    with pytest.raises(KeyboardInterrupt):
        imagefile.write(tmp_path / "a.png", [np.zeros((2, 2, 3), np.uint8)])
    assert not list(tmp_path.iterdir())
    assert capfd.readouterr().err == ""
    imagefile._unfinished.clear()
    assert "libpng" in capfd.readouterr().err  # it has something to say of pictures without pixels


@pytest.mark.parametrize("fault", ["create", "write", "close"])
def test_pictures_that_cannot_be_written(fault: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "a.png"
    target.write_text("old")
    full = SimpleNamespace(
        open=lambda *_: True, write_scanlines=lambda *_: fault != "write", close=lambda: fault != "close",
        geterror=lambda: "disk full",
    )  # fmt: skip
    create = SimpleNamespace(create=lambda name: None if fault == "create" else full)
    monkeypatch.setattr(imagefile.oiio, "ImageOutput", create)
    with pytest.raises(ClrtError, match=r"a\.png:"):
        imagefile.write(target, [np.zeros((2, 2, 3), np.uint8)])
    assert target.read_text() == "old" and list(tmp_path.iterdir()) == [target]


def test_pictures_without_colour_names_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    writer = oiio.ImageOutput.create(str(path))
    spec = oiio.ImageSpec(2, 1, 4, "float")
    spec.channelnames = ("a", "b", "c", "d")
    writer.open(str(path), spec)
    writer.write_image(np.arange(8, dtype=np.float32).reshape(1, 2, 4))
    writer.close()
    with pytest.raises(SceneError, match="its channels are 'b, a, c, d'; R, G and B are read"):
        imagefile.read_image(path)


def test_half_a_character_is_not_saved(tmp_path: Path) -> None:
    scene = clrt.load_dict({"shapes": [{**BALL, "name": "\ud800"}]})
    with pytest.raises(SceneError, match=r"a\.toml: .*is half a character"):
        scene.save(tmp_path / "a.toml")
    assert not list(tmp_path.iterdir())
    scene.save(tmp_path / "a.json")  # where it can be written as an escape
    assert clrt.load(tmp_path / "a.json") == scene


def test_reading_a_mesh_reaches_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import trimesh

    found: list[Any] = []
    whole = trimesh.load_scene

    def spy(*arguments: Any, resolver: Any, **options: Any) -> Any:
        found.append(resolver)
        return whole(*arguments, resolver=resolver, **options)

    monkeypatch.setattr(trimesh, "load_scene", spy)
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    clrt.load(tmp_path / "a.obj")
    (resolver,) = found
    assert resolver.namespaced("x") is resolver and resolver.keys() == []
    with pytest.raises(SceneError, match="writes nothing"):
        resolver.write("b.obj", b"")
    with pytest.raises(SceneError, match="reads no other files"):
        resolver.get("b.obj")


def test_what_the_library_says_is_cut_short_and_need_not_be_text() -> None:
    def broken() -> str:
        return b"\xff".decode("utf-8")

    assert imagefile._words(SimpleNamespace(geterror=broken)) == "its contents are broken"
    assert imagefile._words(SimpleNamespace(geterror=lambda: "x" * 999)) == "x" * 300
