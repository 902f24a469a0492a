"""`clrt explain`: a tree for people, JSON for programs, files; and what cannot be explained is one line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from clrt.cli import main
from tests.cli.test_terminal import SCENE, fault


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    Path("scene.toml").write_text(SCENE.replace("0.9", "0.5"))
    return "scene.toml"


def test_a_tree_is_printed(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", "bubble", "70", "50", "--width", "160", "--spp", "1"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("pixel (70, 50) of bubble.toml, 160 x ")
    assert "camera ray 0 meets" in said and "100.0 %" in said and "└── " in said
    assert main(["explain", "bubble", "70", "50", "--width", "160", "--spp", "1", "--least", "60"]) == 0
    folded = capsys.readouterr().out
    assert "more ray" in folded and "(--least 0 shows all)" in folded and len(folded) < len(said)


def test_json_is_printed(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", scene, "1", "1", "--json"]) == 0
    table = json.loads(capsys.readouterr().out)
    assert table["pixel"] == [1, 1] and len(table["tree"]) == sum(
        table["rays"][kind] for kind in ("camera", "reflection", "transmission", "ambient")
    )


def test_files_are_written(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", scene, "1", "1", "-o", "a.json", "-o", "a.html"]) == 0
    assert capsys.readouterr().out.startswith("a.json, a.html: pixel (1, 1)")
    assert json.loads(Path("a.json").read_text()) and "<!DOCTYPE html>" in Path("a.html").read_text()
    assert main(["explain", scene, "1", "1", "-o", "a.json", "--quiet"]) == 0
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["9999", "0"], "x: 9999 is not allowed; it must be a whole number, at least 0, at most"),
        (["0", "-1"], "y: -1 is not allowed"),
        (["a", "0"], "'a' is not a whole number"),
        (["0"], "the following arguments are required: Y"),
        (["0", "0", "-o", "a.png"], "a.png: the name must end in .json, .html or .glb"),
        (["0", "0", "-o", "none/a.json"], "there is no folder"),
        (["0", "0", "-o", "a.json", "-o", "./a.json"], "a file of its own"),
        (["0", "0", "--least", "101"], "--least: 101.0 is not allowed; it must be from 0 to 100 percent"),
        (["0", "0", "--least", "nan"], "--least: nan is not allowed"),
    ],
)
def test_faults_are_one_line(
    scene: str, words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert said in fault(capsys, "explain", scene, *words)
    assert sorted(path.name for path in Path().iterdir()) == ["scene.toml"]


def test_names_steer_no_terminal(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    evil = r'name = "\u001B[31m[red]x[/red]\u202E"'
    Path("scene.toml").write_text(SCENE.replace('type = "sphere"', f'type = "sphere"\n{evil}'))
    assert main(["explain", scene, "4", "4", "--width", "9", "--height", "9"]) == 0
    said = capsys.readouterr().out
    assert "\x1b" not in said and "\u202e" not in said


def test_a_pixel_of_too_many_feelers_is_refused(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Each feeler is kept with what it meets: 20,000 samples and 100 ambient rays took all memory."""
    lamp = {"type": "rectangle", "center": [0, 3, 0], "u": [1, 0, 0], "v": [0, 0, 1], "two_sided": True}
    floors = [{"type": "plane", "point": [0, y, 0], "normal": [0, -y, 0]} for y in (-1, 9)]
    camera = {"origin": [0, 2, 5], "target": [0, 0, 0], "width": 16, "height": 12}
    lit = {"max_depth": 1, "ambient": 0.3, "ambient_samples": 100, "camera": camera, "shapes": floors}
    Path("lit.json").write_text(json.dumps({**lit, "lights": [{**lamp, "samples": 20000}]}))
    said = fault(capsys, "explain", "lit.json", "8", "8")
    assert "explain: the pixel has more than 100000 shadow feelers; lower samples of lights" in said
    assert main(["explain", "lit.json", "8", "8", "--set", "lights[0].samples=4", "-q"]) == 0
