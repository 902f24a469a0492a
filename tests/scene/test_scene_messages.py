"""What newcomers write into scenes: the message names the cause, the line, and what clrt has not."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

import clrt
from clrt.base import missing
from clrt.formats.lines import json_line, toml_line
from clrt.scene.scene import Document, Scene

ROOT = Path(__file__).resolve().parents[2]
BALL = {"type": "sphere", "center": [0, 0, 0], "radius": 1}

TOML = """\
max_depth = 5
[camera]
origin = [0.0, 0.0, 5.0]
target = [0.0, 0.0, 0.0]  # [the middle
[materials.glass]
ior = "glass"
color = {name = "gold"}
[[lights]]
type = "point"
position = [
  3.0, 5.0,
  4.0  # ]
]
[[shapes]]
type = "sphere"
center = [0.0, 0.0, 0.0]
radius = 1.0
[[shapes]]
type = "plane"
point = [0.0, 0.0, 0.0]
normal = [0.0, 1.0, 0.0]
[shapes.material]
diffuse = 0.5
highlight."color" = 1
"""


def message(scene: dict[str, Any]) -> str:
    with pytest.raises(clrt.SceneError) as caught:
        clrt.load_dict(scene)
    return str(caught.value)


def of_file(folder: Path, text: str, suffix: str = ".toml") -> str:
    file = folder / f"room{suffix}"
    file.write_text(text)
    with pytest.raises(clrt.SceneError) as caught:
        clrt.load(file)
    return str(caught.value)


@pytest.mark.parametrize(
    ("scene", "says"),
    [
        ({"fog": 1}, "unknown key 'fog'; clrt has no fog and clouds"),
        ({"shapes": [{**BALL, "motion": [1, 0, 0]}]}, "clrt has no motion blur"),
        ({"shapes": [{"type": "torus"}]}, "clrt has no curved shapes of higher order"),
        ({"shapes": [{"type": "CSG"}]}, "clrt has no constructive solid geometry"),
        ({"lights": [{"type": "area"}]}, "clrt calls it 'rectangle'"),
        ({"lights": [{"type": "tube light"}]}, "clrt has no lights of other forms"),
        ({"materials": {"m": {"bump-map": "x.png"}}}, "clrt has no bump and displacement maps"),
        ({"materials": {"m": {"texture": "x.png"}}}, "clrt calls it 'color'"),
        ({"materials": {"m": {"metal": "gold"}}}, "clrt calls it 'conductor'"),
        ({"camera": {"origin": [0, 0, 5], "target": [0, 0, 0], "lens": 1}}, "clrt calls it 'aperture'"),
        ({"camera": {"origin": [0, 0, 5], "target": [0, 0, 0], "type": "fisheye"}}, "clrt has no fisheye"),
        ({"camera": {"origin": [0, 0, 5], "look_at": [0, 0, 0]}}, "clrt calls it 'target'"),
        ({"camera": {"origin": [0, 0, 5], "target": [0, 0, 0], "ambient": 1}}, "before the first [table]"),
        ({"shapes": [{**BALL, "radius": "0.8"}]}, "a radius must be > 0; this is a text"),
        ({"shapes": [{**BALL, "center": [0, "1", 0]}]}, "center must be 3 numbers; this is a text"),
        ({"shapes": [{**BALL, "radius": True}]}, "this is true or false, not a number"),
        ({"max_depth": 2.5}, "2.5 is not allowed; max_depth must be a whole number from 0 to 65536"),
        ({"lights": {"type": "point"}}, "in TOML each is a [[lights]]: two brackets"),
        ({"shapes": {"type": "sphere"}}, "in TOML each is a [[shapes]]: two brackets"),
    ],
)  # fmt: skip
def test_the_message_names_the_cause(scene: dict[str, Any], says: str):
    assert says in message(scene)


@pytest.mark.parametrize("word", ["fog", "metal", "xyzzy", "wobble"])
def test_no_far_fetched_guess(word: str):
    assert "did you mean" not in message({word: 1})
    assert "did you mean" not in message({"materials": {"m": {word: 1}}})


def test_every_missing_feature_has_a_row_of_the_page():
    page = (ROOT / missing.PAGE).read_text()
    rows = re.findall(r"^\| ([^|]+?) \|", page, re.MULTILINE)
    assert [row for row in rows if row in missing.FEATURES] == list(missing.FEATURES)
    assert missing.PAGE in (ROOT / "README.md").read_text()


def every_key() -> set[str]:
    """Every key, type and name of a choice that scene files know."""
    from clrt.scene.schema import schema

    words: set[str] = set()

    def walk(part: Any) -> None:
        if isinstance(part, dict):
            words.update(part.get("properties", {}))
            words.update(word for word in (*part.get("enum", ()), part.get("const")) if isinstance(word, str))
            for value in part.values():
                walk(value)
        elif isinstance(part, list):
            for value in part:
                walk(value)

    walk(schema())
    return words


def test_words_are_of_one_feature_and_none_is_a_key_of_clrt():
    words = [word for known in missing.FEATURES.values() for word in known]
    assert len(words) == len(set(words))
    keys = every_key()
    assert {"radius", "fov", "conductor", "sphere", "opaque"} <= keys
    assert not keys & {*words}
    assert set(missing.OTHER_WORDS.values()) <= keys
    assert not keys & set(missing.OTHER_WORDS) and not set(words) & set(missing.OTHER_WORDS)


def test_the_scene_s_own_keys_are_those_of_scenes():
    tables = {"adaptive", "camera", "materials", "lights", "shapes", "spectrum"}
    assert set(Document.__struct_fields__) - tables == missing.SCENE_KEYS
    assert set(Document.__struct_fields__) <= set(Scene.__struct_fields__)


@pytest.mark.parametrize(
    ("path", "line"),
    [
        ("max_depth", 1), ("camera", 2), ("camera.target[2]", 4), ("camera.up", 2),
        ("materials.glass.ior", 6),
        ("materials.glass.color.name", 7), ("lights[0]", 8), ("lights[0].position[1]", 10),
        ("shapes[0].radius", 17),
        ("shapes[1]", 18), ("shapes[1].normal", 21), ("shapes[1].material", 22),
        ("shapes[1].material.diffuse", 23),
        ("shapes[1].material.highlight.color", 24), ("shapes[7]", None), ("", None),
        ("materials.'a b'", None),
    ],
)  # fmt: skip
def test_the_line_of_a_place_in_toml(path: str, line: int | None):
    assert toml_line(TOML, path) == line


def test_rows_of_arrays_are_no_headers():
    assert toml_line("a = [\n  [5]\n]\n[b]\nc = 1\n", "b.c") == 5
    assert toml_line("a = [\n  [5]\n]\n", "5") is None


def test_no_line_is_better_than_a_wrong_one():
    text = 'name = """\n[camera]\n"""\n[camera]\nfov = 1\n'
    assert toml_line(text, "camera.fov") is None


def test_the_line_of_a_place_in_json():
    text = json.dumps({"a b": [1, {"x": 2}], "shapes": [BALL, {**BALL, "radius": -1}], "last": {}}, indent=1)
    rows = text.split("\n")
    lines = {
        "shapes": next(n for n, row in enumerate(rows, 1) if '"shapes"' in row),
        "shapes[1].radius": next(n for n, row in enumerate(rows, 1) if "-1" in row),
        "last": len(rows) - 1,
        "shapes[0]": next(n for n, row in enumerate(rows, 1) if '"shapes"' in row) + 1,
    }
    assert {path: json_line(text, path) for path in lines} == lines
    assert json_line(text, "shapes[1].type[0]") == json_line(text, "shapes[1].type")
    assert json_line(text, "shapes[5]") == lines["shapes"]
    assert json_line(text, "nothing") is None


def test_messages_of_files_name_the_line(tmp_path: Path):
    bad = TOML.replace("radius = 1.0", "radius = -1.0").replace('highlight."color" = 1', "")
    assert of_file(tmp_path, bad).startswith("room.toml:17: shapes[0].radius: -1.0 is not allowed; a radius")
    assert of_file(tmp_path, TOML).startswith("room.toml:24: shapes[1].material: unknown key 'highlight'")
    assert of_file(tmp_path, "max_depth = 1\nfog = 1\n").startswith("room.toml:2: unknown key 'fog'")
    table = json.dumps({"max_depth": 1, "shapes": [{**BALL, "radius": "0.8"}]}, indent=1)
    assert re.match(r"room.json:\d+: shapes\[0\].radius: '0.8'", of_file(tmp_path, table, ".json"))


def test_a_key_that_stands_twice_is_named(tmp_path: Path):
    twice = of_file(tmp_path, "max_depth = 1\nambient = 0\nmax_depth = 2\n")
    assert "at line 3" in twice and twice.endswith("; 'max_depth' is there already")
    assert "'camera' is there already" in of_file(tmp_path, "[camera]\nfov = 1\n[camera]\n")
    assert "is there already" in of_file(tmp_path, "lights = [{}]\n[[lights]]\n")
    assert "'max_depth' stands twice" in of_file(tmp_path, '{"max_depth": 1, "max_depth": 2}', ".json")
    assert "already" not in of_file(tmp_path, "max_depth = \n")
