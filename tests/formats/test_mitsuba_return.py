"""Scenes that clrt wrote as Mitsuba's XML and reads again; those that were changed in between."""

from __future__ import annotations

import errno
import json
import re
import shutil
import warnings
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base import atomic
from clrt.base.errors import ClrtError
from clrt.base.limits import Limits
from clrt.base.resources import shipped_scenes, validation_module
from clrt.cli import main
from clrt.formats.mitsuba import scene as mitsuba
from clrt.scene.scene import Mesh
from tests.random_scenes import random_scene

SCENES = Path(__file__).parents[2] / "scenes"
GREY = {"color": [0.5, 0.4, 0.3]}
CLEAN: dict[str, Any] = {
    "max_depth": 3,
    "camera": {"origin": [0, 2, 6], "target": [0, 0.5, 0], "fov": 40.0, "width": 48, "height": 36},
    "lights": [
        {"type": "point", "position": [2, 4, 3], "intensity": [20, 18, 15], "falloff": "inverse-square"},
        {"type": "directional", "direction": [1, -2, -1], "intensity": 0.5},
    ],
    "shapes": [
        {"type": "sphere", "center": [-1, 0.5, 0], "radius": 0.5,
         "material": {"fresnel": True, "diffuse": 0.0}},
        {"type": "sphere", "center": [1, 0.5, 0], "radius": 0.5,
         "material": {"diffuse": 0.0, "reflection": 0.9, "reflection_color": [1.0, 0.9, 0.8]}},
        {"type": "polygon", "points": [[-4, 0, -4], [-4, 0, 4], [4, 0, 4], [4, 0, -4]], "material": GREY},
        {"type": "cylinder", "p0": [0, 0, 0], "p1": [0, 0.7, 0], "radius": 0.2, "material": GREY},
    ],
}  # fmt: skip


def written(scene: clrt.Scene, path: Path) -> clrt.Scene:
    """The scene as it comes back."""
    keep = partial(mitsuba.with_itself, scene, path)
    validation_module("oracle_mitsuba.xml").write_xml(scene, path, keep)
    return clrt.load(path)


def without_itself(path: Path) -> None:
    """Leave the plugins alone."""
    head, _, tail = path.read_text().partition("<?clrt")
    path.write_text(head + tail.partition("?>")[2])


RGB_ONLY = "Mitsuba's XML is written with red, green and blue only; give colours as 3 numbers"
NO_PICTURES = "shapes[0].material.color: pictures on surfaces are not written; give plain colours"
# shipped scene that Mitsuba's XML has no words for -> what is said of it
REFUSED = {
    "booths": f"spectrum: {RGB_ONLY}",
    "cabinet": NO_PICTURES,
    "diamond": f"spectrum: {RGB_ONLY}",
    "metals": f"spectrum: {RGB_ONLY}",
    "rainbow": f"spectrum: {RGB_ONLY}",
    "rough-metals": f"shapes[1].material.conductor: {RGB_ONLY}",
    "spectrum": f"spectrum: {RGB_ONLY}",
    "still-life": NO_PICTURES,
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_mitsuba_has_no_words_for_is_refused(name: str, tmp_path: Path) -> None:
    file = shipped_scenes()[name]
    with pytest.raises(ClrtError) as error:
        written(clrt.load(file), tmp_path / "a.xml")
    assert str(error.value) == f"{file.name}: {REFUSED[name]}"


@pytest.mark.parametrize("name", sorted(shipped_scenes().keys() - REFUSED.keys()))
def test_shipped_scenes_return(name: str, tmp_path: Path) -> None:
    """Files, and scenes that scripts make."""
    scene = clrt.load(shipped_scenes()[name])
    again = written(scene, tmp_path / "a.xml")
    if scene.background_path is not None:
        assert again.background_path is not None
        assert again.background_path.read_bytes() == scene.background_path.read_bytes()
        plain = {"background": 0.0}
        scene, again = scene.replace(plain), again.replace(plain)
    tables = [one.to_dict() for one in (scene, again)]
    for index, shape in reversed([*enumerate(scene.shapes)]):
        if isinstance(shape, Mesh) and shape.file:  # it is within the scene now
            assert again.shapes[index].file is None  # type: ignore[union-attr]
            one, other = shape.data(), again.shapes[index].data()  # type: ignore[union-attr]
            assert np.array_equal(one.vertices, other.vertices) and np.array_equal(one.faces, other.faces)
            for table in tables:
                del table["shapes"][index]
    assert tables[0] == tables[1]


@pytest.mark.parametrize("seed", range(6))
def test_random_scenes_return(seed: int, tmp_path: Path) -> None:
    scene = random_scene(seed, 6)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert written(scene, tmp_path / "a.xml").to_dict() == scene.to_dict()


def test_the_same_picture(tmp_path: Path) -> None:
    """As it is, and by its plugins alone: this scene is one that Mitsuba has words for."""
    scene, file = clrt.load_dict(CLEAN), tmp_path / "a.xml"
    again = written(scene, file)
    with clrt.Tracer(scene) as tracer:
        before = tracer.render()
        tracer.update(again)
        assert tracer.render().hash == before.hash
        without_itself(file)
        read = clrt.load(file)
        assert read.to_dict() != scene.to_dict() and len(read.shapes) == 4
        tracer.update(read.replace({"camera.spp": 1}))
        assert np.abs(tracer.render().pixels - before.pixels).max() <= 2e-5  # angles and turns are rounded


@pytest.mark.parametrize("kind", ["box", "tent", "gaussian", "mitchell"])
@pytest.mark.parametrize("aperture", [0.0, 0.1])
def test_filters_return(kind: str, aperture: float, tmp_path: Path) -> None:
    """As the scene has them, and by Mitsuba's own plugins of these names."""
    camera = {**CLEAN["camera"], "filter": kind, "spp": 16, "aperture": aperture}
    scene, file = clrt.load_dict({**CLEAN, "camera": camera}), tmp_path / "a.xml"
    assert written(scene, file).to_dict() == scene.to_dict()
    without_itself(file)
    read = clrt.load(file).camera
    assert read is not None and read.filter == kind


def _ball(**material: Any) -> dict[str, Any]:
    return {"type": "sphere", "center": [0, 0.5, 0], "radius": 0.5, "material": material}


GLASS: dict[str, Any] = {"fresnel": True, "diffuse": 0.0}
PANEL: dict[str, Any] = {"type": "rectangle", "center": [0, 3, 0], "u": [1, 0, 0], "v": [0, 0, 1]}
WIDE = {"K": [[40, 0, 24], [0, 30, 18], [0, 0, 1]]}
ASIDE = {"K": [[40, 0, 20], [0, 40, 18], [0, 0, 1]], "aperture": 0.1}
LOST: list[tuple[str, dict[str, Any]]] = [
    ("camera.K: Mitsuba's pixels", {"camera": WIDE}),
    ("camera.K: Mitsuba's lens", {"camera": ASIDE}),
    ("camera.shift: Mitsuba's lens", {"camera": {"fov": 40.0, "aperture": 0.1, "shift": [3, 0]}}),
    ("camera.aperture: left out", {"camera": {"type": "orthographic", "size": 5.0, "aperture": 0.1}}),
    ("shapes[0].material.absorption: left out", {"shapes": [_ball(**GLASS, absorption=[1, 2, 3])]}),
    ("shapes[0].material: Fresnel's shares in place of Schlick's",
     {"shapes": [_ball(diffuse=0.0, fresnel="schlick", transmission=0.9)]}),
    ("priority: Mitsuba's media", {"shapes": [_ball(**GLASS), _ball(**GLASS, priority=1, ior=1.2)]}),
    ("lights[0].visible: Mitsuba's", {"lights": [{**PANEL, "visible": False}]}),
    ("lights[0].two_sided: Mitsuba's", {"lights": [{**PANEL, "two_sided": True}]}),
    ("conformance: Mitsuba", {"conformance": "spd"}),
]  # fmt: skip


@pytest.mark.parametrize(("note", "changes"), LOST, ids=[note for note, _ in LOST])
def test_what_mitsuba_lacks_is_named(note: str, changes: dict[str, Any], tmp_path: Path) -> None:
    """Mitsuba's picture of such a scene is another one, and whoever compares it has to know why."""
    place = {key: CLEAN["camera"][key] for key in ("origin", "target", "width", "height")}
    plain = {**CLEAN, "camera": {**place, "near": 0.1}}
    changed = {**plain, **changes, "camera": plain["camera"] | changes.get("camera", {})}
    for table, notes in ((plain, []), (changed, [note])):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            written(clrt.load_dict(table), tmp_path / "a.xml")
        lines = (tmp_path / "a.xml").read_text().splitlines()
        told = [line.strip().removeprefix("<!-- ") for line in lines if "<!--" in line]
        assert len(told) == len(notes) and all(map(str.startswith, told, notes))


def test_what_was_read_returns_by_its_plugins(tmp_path: Path) -> None:
    """Of a scene that came from Mitsuba nothing is lost on the way back."""
    written(clrt.load_dict(CLEAN), tmp_path / "a.xml")
    without_itself(tmp_path / "a.xml")
    first = clrt.load(tmp_path / "a.xml")
    written(first, tmp_path / "b.xml")
    without_itself(tmp_path / "b.xml")
    second = clrt.load(tmp_path / "b.xml")
    assert first.lights == second.lights and first.max_depth == second.max_depth
    for one, other in zip(first.to_dict()["shapes"], second.to_dict()["shapes"], strict=True):
        for a, b in zip(_numbers(one), _numbers(other), strict=True):
            assert a == pytest.approx(b, rel=1e-14, abs=1e-14)


def _numbers(value: Any) -> list[float]:
    if isinstance(value, dict):
        value = [part for key, part in sorted(value.items()) if key != "name"]
    if isinstance(value, list):
        return [number for part in value for number in _numbers(part)]
    return [float(value)] if isinstance(value, (int, float)) else []


def test_changed_files_are_read_by_their_plugins(tmp_path: Path) -> None:
    ball = {"type": "mesh", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]]}
    scene, file = clrt.load_dict({**CLEAN, "shapes": [*CLEAN["shapes"], ball]}), tmp_path / "a.xml"
    assert written(scene, file).to_dict() == scene.to_dict()
    text = file.read_text()
    file.write_text(text.replace("  <shape", "<shape").replace("><", ">\n<"))  # only white space
    assert clrt.load(file).to_dict() == scene.to_dict()
    file.write_text(text.replace('name="radius" value="0.5"', 'name="radius" value="0.25"', 1))
    with pytest.warns(clrt.ClrtWarning, match="changed after clrt had written it"):
        assert clrt.load(file).shapes[0].radius == 0.25  # type: ignore[union-attr]
    file.write_text(text.replace('"radius":0.5', '"radius":0.25', 1))  # in the scene itself
    with pytest.warns(clrt.ClrtWarning, match="changed after clrt had written it"):
        assert clrt.load(file).shapes[0].radius == 0.5  # type: ignore[union-attr]
    file.write_text(text)
    mesh = min((tmp_path / "a_meshes").iterdir())
    mesh.write_bytes(mesh.read_bytes().replace(b"float nz", b"float ny"))
    with pytest.warns(clrt.ClrtWarning, match="changed after"), pytest.raises(ClrtError):
        clrt.load(file)
    mesh.unlink()
    missing = pytest.raises(ClrtError, match="no such file")
    with pytest.warns(clrt.ClrtWarning, match="changed after"), missing:
        clrt.load(file)


def test_what_is_too_much_is_not_kept(tmp_path: Path) -> None:
    scene, file = clrt.load_dict(CLEAN), tmp_path / "a.xml"
    validation_module("oracle_mitsuba.xml").write_xml(scene, file)
    text = file.read_text()
    for most in (len(text) + 50, len(text) - 1):
        short = clrt.load_dict(CLEAN, limits=Limits(text_bytes=most))
        with pytest.warns(clrt.ClrtWarning, match="not the scene itself as well: text_bytes: "):
            assert mitsuba.with_itself(short, file, text) == text
    deep = clrt.load_dict(CLEAN, limits=Limits(nesting=2))
    with pytest.warns(clrt.ClrtWarning, match="not the scene itself as well: a.xml: nesting: "):
        assert mitsuba.with_itself(deep, file, text) == text


@pytest.mark.parametrize("corners", [3, 4])
def test_meshes_that_are_too_much_are_not_made_lists_of(
    corners: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A list takes several times its array, and is made before the text is known to be too long."""
    monkeypatch.setattr(mitsuba, "moved", lambda *_, **__: pytest.fail("lists are made"))
    places = [[x, y, 0] for x in (0, 1) for y in (0, 1)]
    faces = [[0, 2, 3, 1][:corners]]
    sheet = {"type": "mesh", "vertices": places, "faces": faces, "normals": [[0, 0, 1]] * 4}
    text, needs = '<scene version="3.0.0">\n</scene>\n', 8 * (24 + corners)
    scene = clrt.load_dict({"shapes": [sheet], "ambient": 1}, limits=Limits(text_bytes=needs - 1))
    with pytest.warns(clrt.ClrtWarning, match=f"text_bytes: {needs} is above"):
        assert mitsuba.with_itself(scene, Path("a.xml"), text) == text


def test_a_scene_stands_without_what_it_was_made_of(tmp_path: Path) -> None:
    """Meshes and the sky are in the XML and its folder; another file in the old one's place is none of it."""
    old, new = tmp_path / "old", tmp_path / "new"
    old.mkdir()
    for name in ("gem.obj", "sky.exr", "stone-vertices.ply"):
        shutil.copy(SCENES / name, old)
    meshes = [{"file": "gem.obj", **keys} for keys in ({}, {"smooth": True}, {"smooth": False}, {"part": 0})]
    shapes = [{"type": "mesh", **mesh, "transform": [{"translate": [2 * k, 0, 0]}]} for k, mesh in
              enumerate([*meshes, {"file": "stone-vertices.ply"}])]  # fmt: skip
    table = {**CLEAN, "background": "sky.exr", "shapes": [*CLEAN["shapes"], *shapes]}
    scene = clrt.load_dict(table, folder=old)
    with clrt.Tracer(scene) as tracer:
        before = tracer.render().hash
        tracer.update(written(scene, old / "a.xml"))
        assert tracer.render().hash == before
        shutil.copy(old / "stone-vertices.ply", old / "gem.ply")
        (old / "gem.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        clrt.Image(np.full((4, 8, 3), 0.1, np.float32)).save(old / "sky.exr")
        tracer.update(clrt.load(old / "a.xml"))
        assert tracer.render().hash == before
        new.mkdir()
        for part in ("a.xml", "a_meshes"):
            (old / part).rename(new / part)
        shutil.rmtree(old)
        tracer.update(clrt.load(new / "a.xml"))
        assert tracer.render().hash == before
    (sky,) = (new / "a_meshes").glob("sky-*.exr")
    clrt.Image(np.full((4, 8, 3), 0.1, np.float32)).save(sky)
    with pytest.warns(clrt.ClrtWarning, match="or a file that it names, was changed"):
        assert len(clrt.load(new / "a.xml").shapes) == 9


def test_what_would_need_files_that_no_plugin_names_is_not_kept(tmp_path: Path) -> None:
    """A picture of a material that no surface has: it may be away, or another, when the XML is read."""
    shutil.copy(SCENES / "wood.png", tmp_path)
    wood = {"color": {"type": "image", "file": "wood.png"}}
    scene = clrt.load_dict({**CLEAN, "materials": {"wood": wood}}, folder=tmp_path)
    with pytest.warns(clrt.ClrtWarning, match=r"itself as well: materials\.wood\.color: a picture, which"):
        again = written(scene, tmp_path / "a.xml")
    assert "<?clrt" not in (tmp_path / "a.xml").read_text() and len(again.shapes) == 4


def files(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*.*")}


@pytest.mark.parametrize("fails", range(4))
def test_a_conversion_that_fails_leaves_all_as_it_was(
    fails: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whichever file cannot be written; the one after names other meshes, beside which the old ones stay."""
    for number in (1, 2):
        table = {**CLEAN, "shapes": [{"type": "cone", "p0": [0, 0, 0], "p1": [0, k, 0], "r0": 1, "r1": 0.5}
                                     for k in (number, number + 2, number + 4)]}  # fmt: skip
        (tmp_path / f"{number}.json").write_text(json.dumps(table))
    real, out = atomic._sync, tmp_path / "out" / "a.xml"
    calls: list[bool] = []

    def full(path: Path) -> None:
        calls.append(path.is_file())
        if sum(calls) > fails:
            raise OSError(errno.ENOSPC, "No space left on device")
        real(path)

    out.parent.mkdir()
    monkeypatch.setattr(atomic, "_sync", full)
    assert main(["convert", str(tmp_path / "1.json"), str(out)]) == 2
    assert [*out.parent.iterdir()] == []
    monkeypatch.setattr(atomic, "_sync", real)
    assert main(["convert", str(tmp_path / "1.json"), str(out)]) == 0
    before = files(out.parent)
    calls.clear()
    monkeypatch.setattr(atomic, "_sync", full)
    assert main(["convert", str(tmp_path / "2.json"), str(out)]) == 2
    assert files(out.parent) == before
    monkeypatch.setattr(atomic, "_sync", real)
    assert main(["convert", str(tmp_path / "2.json"), str(out)]) == 0
    after = files(out.parent)
    old = {name: data for name, data in before.items() if name != "a.xml"}
    assert len(after) == 2 * len(before) - 1 and old.items() <= after.items()
    assert clrt.load(out).to_dict()["shapes"][0]["p1"] == [0, 2, 0]
    names = set(re.findall(r"a_meshes/[^\"]*", out.read_text().partition("<?clrt")[0]))
    assert names == after.keys() - before.keys()


def test_a_material_that_nothing_has_may_show_what_cannot_be_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copy(SCENES / "bowl.glb", tmp_path)
    table = {"materials": {"a": {"color": {"type": "image", "file": "bowl.glb", "part": 0}}, "b": {}},
             "camera": {"origin": [0, 0, 5], "target": [0, 0, 0]},
             "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "b"}]}  # fmt: skip
    (tmp_path / "a.json").write_text(json.dumps(table))
    assert main(["convert", str(tmp_path / "a.json"), str(tmp_path / "b.xml")]) == 0
    assert "it holds its plugins alone" in capsys.readouterr().err
    assert clrt.load(tmp_path / "b.xml").shapes


def test_convert_both_ways(tmp_path: Path) -> None:
    shutil.copy(SCENES / "sky.exr", tmp_path)
    (tmp_path / "a.toml").write_text(
        'background = "sky.exr"\n[camera]\norigin = [0, 0, 5]\ntarget = [0, 0, 0]\n'
        '[[shapes]]\ntype = "sphere"\ncenter = [0, 0, 0]\nradius = 1\nname = "?>"\n'
    )
    assert main(["convert", str(tmp_path / "a.toml"), str(tmp_path / "b.xml")]) == 0
    assert main(["convert", str(tmp_path / "b.xml"), str(tmp_path / "c.toml")]) == 0
    before, after = (clrt.load(tmp_path / name) for name in ("a.toml", "c.toml"))
    assert after.background_path is not None and after.background_path.parent == tmp_path / "b_meshes"
    assert after.background_path.read_bytes() == (tmp_path / "sky.exr").read_bytes()
    assert after.replace({"background": 0.0}).to_dict() == before.replace({"background": 0.0}).to_dict()


def test_a_sky_beside_a_scene_is_its_own(tmp_path: Path) -> None:
    """Not one of the same name that an earlier conversion has left."""
    (tmp_path / "a_meshes").mkdir()
    for name, value in (("a_meshes/sky.exr", 0.9), ("sky.exr", 0.1)):
        clrt.Image(np.full((4, 8, 3), value, np.float32)).save(tmp_path / name)
    scene = clrt.load_dict({**CLEAN, "background": "sky.exr"}, folder=tmp_path)
    sky = written(scene, tmp_path / "a.xml").background_path
    assert sky is not None and sky.read_bytes() == (tmp_path / "sky.exr").read_bytes()
    assert sky.parent == tmp_path / "a_meshes" and sky.name != "sky.exr"
    again = written(clrt.load(tmp_path / "a.xml"), tmp_path / "a.xml")
    assert again.background_path == sky and sky.exists()  # no copy of the copy


def test_what_an_older_xml_named_stays_and_is_told(tmp_path: Path) -> None:
    """Others read it: a scene that was made of that XML, or a copy of it."""
    clrt.Image(np.full((4, 8, 3), 0.3, np.float32)).save(tmp_path / "sky.exr")
    scene = clrt.load_dict({**CLEAN, "background": "sky.exr"}, folder=tmp_path)
    sky = written(scene, tmp_path / "a.xml").background_path
    assert sky is not None
    with pytest.warns(clrt.ClrtWarning, match=f"a_meshes/{sky.name}.* stay; delete them if no other scene"):
        written(scene.replace({"background": 0.2}), tmp_path / "a.xml")
    assert sky.exists()


def test_a_file_that_two_shapes_name(tmp_path: Path) -> None:
    """It returns; and where somebody has changed the lines to name one file, the plugins are read."""
    (tmp_path / "gem.obj").write_bytes((SCENES / "gem.obj").read_bytes())
    gem = {"type": "mesh", "file": "gem.obj"}
    both = [gem, {**gem, "transform": [{"translate": [3, 0, 0]}]}]
    camera = {"origin": [0, 0, 5], "target": [0, 0, 0]}
    scene = clrt.load_dict({"camera": camera, "ambient": 1, "shapes": both}, folder=tmp_path)
    path = tmp_path / "a.xml"
    again = written(scene, path)
    for one, other in zip(scene.shapes, again.shapes, strict=True):
        assert isinstance(one, Mesh) and isinstance(other, Mesh) and other.file is None
        assert np.array_equal(one.data().vertices, other.data().vertices)
    first, second = sorted(re.findall(r"a_meshes/shape_\d_\d-\w+\.ply", path.read_text()))
    path.write_text(path.read_text().replace(second, first))
    with pytest.warns(clrt.ClrtWarning):
        again = clrt.load(path)
    assert [shape.file for shape in again.shapes] == [first] * 2


@pytest.mark.filterwarnings("ignore::clrt.ClrtWarning")
def test_files_whose_names_hold_what_begins_a_parameter(tmp_path: Path) -> None:
    """Neither Mitsuba nor clrt could read what named them."""
    shutil.copy(SCENES / "sky.exr", tmp_path / "s$y.exr")
    mesh = {"type": "mesh", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]]}
    scene = clrt.load_dict({**CLEAN, "background": "s$y.exr", "shapes": [mesh]}, folder=tmp_path)
    scene.save(tmp_path / "a.json")
    assert main(["convert", str(tmp_path / "a.json"), str(tmp_path / "cost$new.xml")]) == 0
    named = re.findall('name="filename" value="([^"]*)"', (tmp_path / "cost$new.xml").read_text())
    assert len(named) == 2 and not any("$" in name for name in named)
    for text in (str, without_itself):
        text(tmp_path / "cost$new.xml")
        again = clrt.load(tmp_path / "cost$new.xml")
        assert again.background_path is not None
        assert again.background_path.read_bytes() == (SCENES / "sky.exr").read_bytes()
        assert len(again.shapes) == 1
