"""No output of a command takes the place of a file that the command reads, however its name is spelled."""

from __future__ import annotations

import hashlib
import io
import json
import os
import re
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base import inputs
from clrt.base.atomic import replacing
from clrt.base.files import read_bytes
from clrt.base.limits import Limits
from clrt.base.resources import validation_module
from clrt.bench.report import Report
from clrt.cli import main
from clrt.cli.options import parser
from clrt.cli.outputs import check_apart
from tests.bench_samples import measurement
from tests.cli.test_terminal import SCENE, fault

ROOM = SCENE.replace("0.9", "0.5")
MESHES = """
[[shapes]]
type = "mesh"
file = "mesh.obj"
[[shapes]]
type = "mesh"
file = "tree.gltf"
"""
BUFFER = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32).tobytes()

READS = {
    "room.toml": ["room.toml", "sky.exr", "mesh.obj", "tree.gltf", "tree.bin"],
    "tree.gltf": ["tree.gltf", "tree.bin"],
}
"""Scenes, and all that is read with each."""

WRITES: dict[str, list[tuple[list[str], str]]] = {
    "render": [
        (["render", "{scene}", "-o", "{out}"], ".png"),
        (["render", "{scene}", "-o", "new.png", "--stats", "{out}"], ""),
        (["render", "{scene}", "-o", "new.png", "--trace", "{out}"], ""),
        (["render", "{scene}", "-o", "new.png", "--checkpoint", "{out}"], ""),
        (["render", "{scene}", "-o", "{stem}.png", "--layers", "depth"], ".depth.png"),
        (["render", "{scene}", "-o", "{stem}.png", "--layers", "all"], ".depth.png"),
    ],
    "convert": [(["convert", "{scene}", "{out}"], ".json"), (["convert", "{scene}", "{out}"], ".toml"),
                (["convert", "{scene}", "{out}"], ".xml")],
    "explain": [(["explain", "{scene}", "0", "0", "-o", "{out}"], ending) for ending in (".json", ".html")],
    "sweep": [
        (["sweep", "{scene}", "--set", "ambient=0.1", "-o", "{out}"], ".png"),
        (["sweep", "{scene}", "--set", "ambient=0,1", "-o", "n{{index}}.png", "--manifest", "{out}"], ""),
    ],
    "turntable": [
        (["turntable", "{scene}", "--frames", "1", "-o", "{out}"], ".mkv"),
        (["turntable", "{scene}", "--frames", "2", "-o", "n{{index}}.png", "--manifest", "{out}"], ""),
    ],
    "bench": [
        (["bench", "--scene", "{scene}", "--quick", "--rounds", "1", "--json", "{out}"], ""),
        (["bench", "--scene", "{scene}", "--quick", "--rounds", "1", "--trace", "{out}"], ""),
        (["bench", "--scene", "ball.toml", "{scene}", "--quick", "--chart", "{out}"], ".svg"),
    ],
    "validate": [], "plot-spectrum": [],  # which read no scene of the user's; see below
    # write nothing
    "hash": [], "check": [], "compare": [], "devices": [], "doctor": [], "scenes": [], "selftest": [],
    "exercise": [],  # makes a folder that is not there
    "view": [],
}  # fmt: skip
"""Every command; for each of its outputs a command line, and how the output's name has to end."""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    clrt.Image(np.full((4, 8, 3), 0.5, np.float32)).save("sky.exr")
    Path("mesh.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    Path("tree.bin").write_bytes(BUFFER)
    Path("tree.gltf").write_text(json.dumps(gltf("tree.bin")))
    Path("ball.toml").write_text(ROOM)
    Path("room.toml").write_text(f'background = "sky.exr"\n{ROOM}{MESHES}')
    monkeypatch.setattr(clrt, "render", lambda *_, **__: pytest.fail("it renders"))
    monkeypatch.setattr("clrt.engine.tracer.Tracer.explain", lambda *_, **__: pytest.fail("it explains"))
    monkeypatch.setattr("clrt.bench.suite.run", lambda *_: pytest.fail("it measures"))
    return tmp_path


def gltf(buffer: str) -> dict[str, Any]:
    return {
        "asset": {"version": "2.0"}, "buffers": [{"uri": buffer, "byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    }  # fmt: skip


_NUMBERS = count()
_FOLDER = "is the name of a folder; give the name of a file to write"


def spelled(name: str, ending: str) -> Iterator[str]:
    """Names of the file that have this ending: itself, with slashes and detours, links."""
    here = Path.cwd()
    for link in (os.symlink, os.link):
        made = f"link{next(_NUMBERS)}{ending}"
        link(here / name if link is os.symlink else name, made)
        yield from (made, f"{made}/", f"./{made}")
    if name.endswith(ending):
        yield from (name, f"./{name}", f"{name}/", f"{name}//", f"{name}/.", f"./{name}/./", str(here / name),
                    f"../{here.name}/{name}", f"{here}//{name}/", f"/proc/self/cwd/{name}")  # fmt: skip


def test_every_command_is_known() -> None:
    assert set(parser().commands) == set(WRITES)


@pytest.mark.parametrize("command", [command for command in WRITES if WRITES[command]])
@pytest.mark.parametrize("scene", READS)
def test_outputs_are_no_inputs(
    command: str, scene: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = {name: Path(name).read_bytes() for name in (*READS["room.toml"], "ball.toml")}
    for words, ending in WRITES[command]:
        for name in READS[scene]:
            for out in spelled(name, ending):
                stem = out.rstrip("/.").removesuffix(".depth.png")
                given = [word.format(scene=scene, out=out, stem=stem) for word in words]
                said = fault(capsys, *given)
                refused = ["a file of its own", *([_FOLDER] if out.endswith("/") else [])]
                refused += ["; give it a name such as "] if Path(out).suffix and not ending else []
                assert any(words in said for words in refused), (given, said)
                assert {name: Path(name).read_bytes() for name in before} == before, given


@pytest.mark.parametrize("command", [*filter(WRITES.get, WRITES), "plot-spectrum"])
def test_a_name_that_ends_in_a_slash_is_a_folder_s(
    command: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = sorted(Path().iterdir())
    for words, ending in WRITES[command] or [(["plot-spectrum", "D65", "-o", "{out}"], ".png")]:
        if "{out}" in words:
            given = [word.format(scene="room.toml", out=f"a{ending}/") for word in words]
            assert fault(capsys, *given) == f"clrt: error: a{ending}/: {_FOLDER}\n"
    assert sorted(Path().iterdir()) == before


def test_a_buffer_may_be_called_anything(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, words in (("new.png", ["render", "tree.gltf", "-o"]), ("new.json", ["convert", "tree.gltf"])):
        Path(name).write_bytes(BUFFER)
        Path("tree.gltf").write_text(json.dumps(gltf(name)))
        assert f"{name}, which is read; give " in fault(capsys, *words, name)
        assert Path(name).read_bytes() == BUFFER


def test_two_outputs_are_two_files(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for old in (False, True):
        for stats in ("new.png", "./new.png", "new.png/", f"{folder}/new.png//"):
            assert "is the file of --output; give --stats" in fault(
                capsys, "render", "room.toml", "-o", "new.png", "--stats", stats
            )
        assert Path("new.png").exists() == old
        Path("new.png").write_bytes(b"old")


def test_a_report_does_not_replace_the_one_it_is_compared_with(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Report({}, (measurement((1.0,)),)).save("old.json")
    before = Path("old.json").read_bytes()
    for name in spelled("old.json", ".json"):
        assert "is the report of --compare" in fault(capsys, "bench", "--compare", "old.json", "--json", name)
    assert Path("old.json").read_bytes() == before


def test_a_page_does_not_replace_a_scene_whose_rays_are_counted(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scenes = [f"{name}.nff" for name in validation_module("spd").PUBLISHED]
    for name in scenes:
        Path(name).write_text("b 0 0 0\n")
    Path("page.html").symlink_to(scenes[-1])
    assert f"{scenes[-1]}, which is read" in fault(capsys, "validate", "--spd", ".", "--report", "page.html")
    assert Path(scenes[-1]).read_text() == "b 0 0 0\n"


def test_xml_is_written_with_all_its_meshes_or_none(folder: Path) -> None:
    """They lie in a folder beside it, where a mesh that the scene reads, and which stays, may lie, too."""
    pytest.importorskip("trimesh", reason="needs the optional dependency clrt[mesh]")
    assert main(["convert", "room.toml", "new.xml"]) == 0
    *others, last = sorted(Path("new_meshes").glob("*.ply"))
    Path("room.toml").write_text(ROOM + MESHES.replace("mesh.obj", str(last)))
    for file in others:
        file.write_bytes(b"old")
    held = last.read_bytes()
    assert main(["convert", "room.toml", "new.xml"]) == 0
    assert last.read_bytes() == held
    named = [folder / name for name in re.findall(r'value="(new_meshes/[^"]*)"', Path("new.xml").read_text())]
    assert named and all(hashlib.sha256(file.read_bytes()).hexdigest()[:16] in file.name for file in named)


def test_what_was_read_is_never_replaced(folder: Path) -> None:
    """Whatever a command forgets to ask for beforehand."""
    with inputs.watched():
        read_bytes("mesh.obj", Limits())
        for name in spelled("mesh.obj", ".obj"):
            refused = _FOLDER if name.endswith("/") else r"is mesh\.obj, which is read"
            with pytest.raises(clrt.ClrtError, match=refused), replacing(name):
                pass
        with inputs.watched(False):
            read_bytes("room.toml", Limits())
        with replacing("room.toml") as temporary:
            temporary.write_text("new")
    assert Path("room.toml").read_text() == "new"


def test_programs_may_save_a_scene_where_it_came_from(folder: Path) -> None:
    scene = clrt.load("room.toml")
    scene.save("room.toml")
    assert clrt.load("room.toml") == scene
    assert inputs.noted() == {}


def test_a_name_that_no_file_can_have_is_itself() -> None:
    assert inputs.identity("a\0b") == "a\0b"


@pytest.mark.parametrize(
    ("words", "refused", "taken"),
    [
        (["render", "ball.toml", "-o", "new.png", "--stats"], "x.png", "stats.txt"),
        (["render", "ball.toml", "-o", "new.png", "--trace"], "x.CSV", "trace"),
        (["render", "ball.toml", "-o", "new.png", "--checkpoint"], "x.exr", "new.part"),
        (["turntable", "ball.toml", "-o", "n{index}.png", "--manifest"], "x.json", "m.txt"),
        (["bench", "--quick", "--json"], "x.svg", "now"),
    ],
)
def test_a_name_that_promises_something_else_is_refused(
    words: list[str], refused: str, taken: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """In one line that names the option; names that promise nothing are taken."""
    assert f"{refused}: {words[-1]} writes " in fault(capsys, *words, refused)
    check_apart({words[-1]: taken}, {})


@pytest.mark.parametrize(
    "words",
    [
        *(["render", "ball.toml", "-o", "a.png", name] for name in ("--stats", "--trace", "--checkpoint")),
        ["render", "ball.toml", "-o", "-", "--stats"],
        ["sweep", "ball.toml", "--set", "camera.fov=20,30", "-o", "n{index}.png", "--manifest"],
        ["turntable", "ball.toml", "-o", "n{index}.png", "--manifest"], ["bench", "--quick", "--json"],
        ["bench", "--quick", "--trace"], ["selftest", "--quick", "--junit"],
        ["selftest", "--quick", "--bundle"], ["exercise", "start", "1"],
    ],
)  # fmt: skip
def test_a_stream_where_there_is_none_is_refused(
    words: list[str], folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It was the name of a file, or a folder."""
    before = sorted(Path().iterdir())
    assert " -: it is no stream; give it a name, such as " in fault(capsys, *words, "-")
    assert sorted(Path().iterdir()) == before


PICTURED = """
[materials.m.color]
type = "image"
file = "{file}"
"""


def pictured(name: str, file: str) -> None:
    """A scene with a picture on its surface."""
    Path(name).write_text(ROOM + PICTURED.format(file=file))


SERIES = {
    "a later scene reads it": ["render", "first.toml", "second.toml", "-o", "{name}.png"],
    "as an input of the first": ["render", "second.toml", "first.toml", "-o", "{name}.png"],
    "a value of a later picture": ["sweep", "second.toml", "--set", "materials.m.color.file=sky.exr,s0.exr",
                                   "-o", "s{index}.exr"],
    "a layer of another scene": ["render", "ball.toml", "ball.depth.toml", "-o", "out/{name}.png",
                                 "--layers", "depth"],
    "one of all layers of another scene": ["render", "ball.toml", "ball.depth.toml", "-o", "out/{name}.png",
                                           "--layers", "all"],
}  # fmt: skip


@pytest.mark.parametrize("words", SERIES.values(), ids=SERIES)
def test_no_picture_of_several_takes_what_another_needs(
    words: list[str], folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nothing is rendered then: what a later scene reads counts before the first is."""
    for name in ("first.png", "s0.exr"):
        clrt.Image(np.full((4, 8, 3), 0.5, np.float32)).save(name)
    pictured("first.toml", "sky.exr")
    pictured("second.toml", "first.png")
    Path("ball.depth.toml").write_text(ROOM)
    Path("out").mkdir()
    before = {path: path.read_bytes() for path in Path().rglob("*") if path.is_file()}
    assert "a file of its own" in fault(capsys, *words)
    assert {path: path.read_bytes() for path in Path().rglob("*") if path.is_file()} == before


def test_a_fault_of_a_later_scene_is_told_before_the_first_is_rendered(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("broken.toml").write_text("ambient = 'red'")
    assert "broken.toml:1: ambient" in fault(capsys, "render", "ball.toml", "broken.toml", "-o", "{name}.png")


def test_several_scenes_of_which_one_is_standard_input(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It can be read once, and is known when its turn comes."""
    asked: list[str] = []

    def render(scene: clrt.Scene, **_: Any) -> clrt.Image:
        asked.append(scene.source)
        return clrt.Image(np.full((4, 8, 3), 0.5, np.float32), stats={"traced": 1, "device": "none"})

    monkeypatch.setattr(clrt, "render", render)
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(ROOM.encode())))
    assert main(["render", "ball.toml", "-", "-o", "{name}{index}.png", "--quiet"]) == 0
    assert asked == ["ball.toml", "standard input"]
