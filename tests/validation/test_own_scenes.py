"""`clrt validate SCENE`: somebody's own scenes, and which oracles agree with clrt on them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import trimesh

import compare_samples as samples
from clrt.base.resources import validation_module
from clrt.cli import main

cases = validation_module("cases")
worker = validation_module("suite.worker")
gate = validation_module("compare.oracle").gate
Comparison = validation_module("types").Comparison
client = validation_module("oracle_povray.client")
Printed = pytest.CaptureFixture[str]


def validate(capsys: Printed, *arguments: str) -> tuple[int, str, str]:
    code = main(["validate", *arguments])
    said = capsys.readouterr()
    return code, said.out, said.err


def test_a_scene_that_nobody_knows(tmp_path: Path, capsys: Printed) -> None:
    scene, report = tmp_path / "own.toml", tmp_path / "out.html"
    samples.scene().save(scene)
    code, out, _ = validate(capsys, str(scene), "--report", str(report))
    assert code == 0, out
    words = " ".join(out.split())
    assert "pictures, oracle64 1 1 ok" in words and "pictures, mitsuba-table 1 1 ok" in words
    assert "own.toml: mitsuba-bsdf cannot express it: shapes[1]: Mitsuba has no Phong highlight" in words
    assert "own.toml: mitsuba-spectral cannot express it: the scene is in RGB" in words
    assert "proven on " in words and "own.toml" in report.read_text()


def test_of_an_adaptive_scene_an_even_picture_is_judged(tmp_path: Path) -> None:
    """Mitsuba's side knew no such key: a TypeError."""
    samples.scene().replace({"camera.spp": 9, "adaptive": {"spp": 36}}).save(tmp_path / "own.toml")
    name = cases.own_case(str(tmp_path / "own.toml"))
    found = worker.run_case(worker.Task(name, ("oracle64", "mitsuba-table")))
    assert found.passed and not found.unproven and "samples" not in found.ours.layers


def test_a_scene_in_another_format_and_one_that_ships(tmp_path: Path, capsys: Printed) -> None:
    nff = tmp_path / "ball.nff"
    nff.write_text(
        "b 0.1 0.2 0.4\nv\nfrom 0 -5 1\nat 0 0 0\nup 0 0 1\nangle 40\nhither 1\nresolution 64 48\n"
        "l 3 -4 5\nf 0.8 0.4 0.2 0.7 0.2 20 0 1\np 3\n-1 0 -1\n1 0 -0.8\n0 0.4 0.9\n"
        "p 4\n-3 -3 -1.3\n3 -3 -1.3\n3 3 -1.3\n-3 3 -1.3\n"
    )
    code, out, _ = validate(capsys, str(nff), "tetrahedron")
    assert code == 0 and "pictures, oracle64 2 2 ok" in " ".join(out.split()), out


@pytest.mark.parametrize(("text", "says"), [
    (None, "own.toml: there is no such file"), ("shapes = []", "camera: missing; a picture needs a [camera]"),
    ("shapes = [", "own.toml"),
])  # fmt: skip
def test_what_cannot_be_rendered(tmp_path: Path, capsys: Printed, text: str | None, says: str) -> None:
    scene = tmp_path / "own.toml"
    if text is not None:
        scene.write_text(text)
    code, out, err = validate(capsys, str(scene))
    assert code == 2 and out == "" and says in err and err.count("\n") == 1


@pytest.mark.shared
@pytest.mark.parametrize("name", ["thesis/example.txt", "spd/tetra_c_s6.nff"])
def test_foreign_scenes(name: str, shared_folder: Path, capsys: Printed) -> None:
    """The colours of the thesis' program are no sums over rays: kinds of rays are not compared there."""
    code, out, _ = validate(capsys, str(shared_folder / "data" / name))
    assert code == 0, out
    told = "Mitsuba's side got what clrt had read of it: only clrt reads .nff" in " ".join(out.split())
    assert told == name.endswith(".nff")  # it has no words for the other


@pytest.mark.shared
@pytest.mark.parametrize(("name", "povray"), [
    ("balls_c_s3", True), ("mount_c_s6", True), ("tetra_c_s6", True), ("teapot_c_s12", False),
    ("tree_c_s11", True),
])  # fmt: skip
def test_foreign_scenes_that_two_other_programs_judge(
    name: str, povray: bool, shared_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As the command does it, in pictures half as wide. POV-Ray has no faces of four corners."""
    monkeypatch.setattr(cases, "WIDTH", 80)
    case = cases.own_case(str(shared_folder / "data" / "spd" / f"{name}.nff"))
    asked = ("oracle64", "mitsuba-table", "povray") if not client.missing() else ("oracle64", "mitsuba-table")
    found = worker.run_case(worker.Task(case, asked))
    wrong = {oracle: comparison.worst for oracle, (_, comparison) in found.results.items()
             if not comparison.passed}  # fmt: skip
    assert wrong == {}, wrong
    assert found.results.keys() == {oracle for oracle in asked if oracle != "povray" or povray}


_BALL = """
ambient = 0.1
background = 0.2
camera = {{ origin = [0, {size}, {far}], target = [0, 0, 0], fov = 40, width = {width}, height = {height} }}
[[lights]]
type = "point"
position = [{far}, {far}, {far}]
intensity = {light}
[[shapes]]
type = "sphere"
center = [0, 0, 0]
radius = {size}
[[shapes]]
type = "plane"
point = [0, -{size}, 0]
normal = [0, 1, 0]
"""


def _ball(size: float = 1.0, width: int = 96, height: int = 72, light: float = 1.0) -> str:
    return _BALL.format(size=size, far=5 * size, width=width, height=height, light=light)


def test_a_scene_of_a_few_rows_has_one_at_least(tmp_path: Path) -> None:
    """A height of 0 was refused, which nobody had written."""
    scene = tmp_path / "wide.toml"
    scene.write_text(_ball(width=2000, height=3))
    case = cases.case_named(cases.own_case(str(scene)))
    assert (case.width, case.height) == (160, 1)


@pytest.mark.skipif(bool(client.missing()), reason="POV-Ray is not installed")
def test_what_povray_cannot_show_at_the_ends_of_scale_is_not_asked_of_it(
    tmp_path: Path, capsys: Printed
) -> None:
    """It was called unproven: a horizon nearer than ours, which is none once all is scaled, hits too near,
    and a picture that 16 bits cannot hold."""
    texts = {"usual": _ball(), "large": _ball(size=1e5), "small": _ball(size=1e-4),
             "dark": _ball(light=1e-7).replace("0.1", "0").replace("0.2", "0")}  # fmt: skip
    for name, text in texts.items():
        (tmp_path / f"{name}.toml").write_text(text)
    code, out, _ = validate(capsys, *(str(tmp_path / f"{name}.toml") for name in texts))
    words = " ".join(out.split())
    assert code == 0, out
    assert "pictures, povray 3 3 ok" in words and "pictures, oracle64 4 4 ok" in words
    assert "dark.toml: povray cannot express it: POV-Ray's 16 bits cannot hold so dark a picture" in words


_TILES = """
ambient = 0.3
background = 0.5
camera = { origin = [0, 1, 5], target = [0, 0.6, 0], fov = 50, width = 96, height = 72 }
[[lights]]
type = "point"
position = [3, 5, 4]
[[shapes]]
type = "plane"
point = [0, 0, 0]
normal = [0, 1, 0]
material = { color = { type = "checker", size = 0.02 } }
"""


def test_checks_finer_than_pixels_are_said_to_be_the_cause(tmp_path: Path, capsys: Printed) -> None:
    scene = tmp_path / "tiles.toml"
    scene.write_text(_TILES)
    code, out, _ = validate(capsys, str(scene))
    words = " ".join(out.split())
    assert code == 1 and "; aliasing: details finer than pixels, as of a texture, checker or crowd" in words
    assert "of the pixels the oracle's own picture jumps when its samples move" in words


def test_what_is_wrong_elsewhere_is_no_aliasing() -> None:
    def comparison(*names: str) -> Any:
        return Comparison({}, tuple(gate(name, 0.4, 0.3, "low") for name in names), {})

    (cause,) = worker.aliasing([comparison("edges", "PSNR"), comparison()])
    assert cause.name == "aliasing" and "at 40% of the pixels" in cause.text and not cause.proven
    for wrong in ([comparison("edges"), comparison("edges", "within 1e-4")], [comparison("PSNR")],
                  [comparison()], [comparison("edges", "another shape")]):  # fmt: skip
        assert not list(worker.aliasing(wrong))


_ROOM = """
ambient = 0.1
background = 0.2
camera = { origin = [0, 1.2, 5], target = [0, 0, 0], fov = 40, width = 96, height = 72 }
[[lights]]
type = "rectangle"
center = [0, 3, 0]
u = [0.5, 0, 0]
v = [0, 0, 0.5]
radiance = 6.0
samples = 9
[[shapes]]
type = "box"
min = [-1, -1, -1]
max = [0, 0.3, 0]
[[shapes]]
type = "plane"
point = [0, -1, 0]
normal = [0, 1, 0]
"""


def test_a_room_under_an_area_light_and_a_model(tmp_path: Path, capsys: Printed) -> None:
    """As somebody would write them who has never seen a case of the matrix."""
    room, ring = tmp_path / "room.toml", tmp_path / "ring.glb"
    room.write_text(_ROOM)
    trimesh.creation.torus(0.8, 0.3, major_sections=24, minor_sections=12).export(ring)
    code, out, _ = validate(capsys, str(room), str(ring))
    words = " ".join(out.split())
    assert code == 0, out
    assert "pictures, oracle64 2 2 ok" in words and "pictures, mitsuba-table 2 2 ok" in words
    assert "room.toml: povray cannot express it: lights[0]: POV-Ray has no rectangle light" in words
