"""What newcomers write into scenes: the message names the cause, the line, and what clrt has not."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import clrt
from clrt.base import missing
from clrt.base.errors import SceneError
from clrt.base.explain import describe, field_types
from clrt.base.records import Record
from clrt.cli import main
from clrt.formats.lines import json_line, toml_line
from clrt.scene.scene import Document, Material, NormalMap, Scene
from clrt.spectra.indices import Dispersion

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


_TINT = "must be a number >= 0, 3 numbers >= 0, spectrum"
_COLOR = f"color {_TINT}, {{type = 'image', ...}} or {{type = 'checker', ...}}"
_REFLECTANCE = "a colour must be a number >= 0 or 3 numbers >= 0, a reflectance's name or a spectrum"
_LIGHT = "a colour must be a number >= 0 or 3 numbers >= 0, a light's name or a spectrum"
_BACKGROUND = "background must be a colour, a light's name, a spectrum or the path of a lat-long image"
_IMAGE = {"type": "image", "file": "a.png"}


@pytest.mark.parametrize(
    ("material", "place", "right"),
    [
        ({"normal_map": "ok.png"}, "normal_map: 'ok.png'",
         "normal_map must be a table such as {file = 'bumps.png'}"),
        ({"normal_map": {"file": "a.png", "placement": "clamp"}}, "normal_map.placement: 'clamp'",
         "placement must be a table such as {scale = [2, 2]}"),
        ({"ior": {"sellmeier": 5}}, "ior.sellmeier: 5", "sellmeier must be a table {B = [...], C = [...]}"),
        ({"color": {**_IMAGE, "type": "texture"}}, "color.type: 'texture'", _COLOR),
        ({"color": {**_IMAGE, "type": "bitmap"}}, "color.type: 'bitmap'", f"{_COLOR}; clrt calls it 'image'"),
        ({"color": {"type": "noise"}}, "color.type: 'noise'",
         f"{_COLOR}; clrt has no procedural textures ({missing.PAGE})"),
        ({"color": {"type": ["image"]}}, "color.type: ['image']", _COLOR),
        ({"emission": {**_IMAGE, "type": "picture"}}, "emission.type: 'picture'",
         f"emission {_TINT} or {{type = 'image', ...}}"),
        ({"color": {"file": "ok.png"}}, "color: {'file': 'ok.png'}", _COLOR),
        ({"color": {"colors": [0.1, 0.2]}}, "color: {'colors': [0.1, 0.2]}", _COLOR),
        ({"color": {"type": "checker", "colors": [0.1, _IMAGE]}}, "color.colors[1].type: 'image'",
         _REFLECTANCE),
        ({"color": {**_IMAGE, "filter": "cubic"}}, "color.filter: 'cubic'",
         "filter must be 'linear', 'nearest' or 'mipmap'"),
        ({"color": {**_IMAGE, "encoding": "aces"}}, "color.encoding: 'aces'",
         "encoding must be 'srgb' or 'linear'"),
    ],
)  # fmt: skip
def test_what_may_be_a_picture_says_how(material: dict[str, Any], place: str, right: str):
    assert message({"materials": {"m": material}}) == f"materials.m.{place} is not allowed; {right}"


def test_where_only_a_spectrum_may_stand_its_type_is_said(capsys: pytest.CaptureFixture[str]):
    assert main(["plot-spectrum", '{type = "image"}']) == 2
    assert "NAME: type: 'image' is not allowed; type must be 'spectrum'" in capsys.readouterr().err


def test_a_misspelt_key_of_a_spectrum_is_one():
    says = "materials.m.color: unknown key 'nmae'; did you mean 'name'?"
    assert message({"materials": {"m": {"color": {"nmae": "gold"}}}}).startswith(says)


@pytest.mark.parametrize(
    ("scene", "says"),
    [
        ({"background": _IMAGE}, f"background.type: 'image' is not allowed; {_BACKGROUND}"),
        ({"background": {"file": "a.exr"}}, f"background: {{'file': 'a.exr'}} is not allowed; {_BACKGROUND}"),
        ({"lights": [{"type": "point", "position": [0, 1, 0], "intensity": _IMAGE}]},
         f"lights[0].intensity.type: 'image' is not allowed; {_LIGHT}"),
        ({"spectrum": 5}, "spectrum: 5 is not allowed; spectrum must be a table such as {bands = 24}"),
        ({"shadow": "fog"}, "shadow: 'fog' is not allowed; shadow must be 'opaque' or 'tinted'"),
    ],
)  # fmt: skip
def test_what_may_be_no_picture_says_what_it_may_be(scene: dict[str, Any], says: str):
    assert message(scene) == says


@pytest.mark.parametrize("key", ["color", "emission", "highlight_color"])
def test_a_picture_is_not_written_as_its_name(key: str):
    hint = "; a picture is {type = 'image', file = 'in/ok.png'}"
    for value in ("in/ok.png", {"name": "in/ok.png"}):
        assert message({"materials": {"m": {key: value}}}).endswith(hint)
    for word in ("gould", "D65x"):
        assert "picture" not in message({"materials": {"m": {key: word}}})
    checker = {"type": "checker", "colors": ["ok.png", 0.2]}
    point = {"type": "point", "position": [0, 1, 0], "intensity": "ok.png"}
    for scene in ({"ambient": "ok.png"}, {"lights": [point]}, {"materials": {"m": {"color": checker}}}):
        assert "a picture is" not in message(scene)


def records(kind: type[Record] = Record) -> Iterator[type[Record]]:
    """All kinds of tables that scenes have."""
    for inner in kind.__subclasses__():
        yield inner
        yield from records(inner)


def test_every_rule_says_what_a_value_must_be():
    """Of tables a class' name would say nothing, and nothing even less."""
    ours = {kind for kind in records() if kind.__module__.startswith("clrt.")}
    found = {kind for kind in ours if not issubclass(kind, Document)}  # whose tables are read one by one
    assert {Material, NormalMap, Dispersion} <= found
    for kind in found:
        for name, hint in field_types(kind).items():
            assert not describe(hint, name).endswith(("must be ", "must be")), f"{kind.__name__}.{name}"


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


@pytest.mark.parametrize(
    ("path", "line"),
    [("shape", 2), ("shape[0].x", 3), ("a", 4), ("a.b", 4), ("a.b.c", 5), ("a.z", None), ("d", 6),
     ("d.e[1]", 10), ("d.e", 8), ("d.'e'", 6), ("shape[7]", None), ("shape.x", None), ("f", 13), ("f.g", 12)],
)  # fmt: skip
def test_the_line_of_a_whole_array_or_table(path: str, line: int | None):
    """Where it begins; an item or a key that is not there has no line by that."""
    text = "k = 1\n[[shape]]\nx = 1\n[a.b]\nc = 2\n[d]\nx = 1\n[[d.e]]\nx = 1\n"
    text += "[[d.e]]\n[[shape]]\n[f.g.h]\n[f]\n"
    tomllib.loads(text)
    assert toml_line(text, path) == line


@pytest.mark.parametrize(
    ("text", "says"),
    [("[[shape]]\ntype = 'sphere'\n", r"a\.toml:4: unknown key 'shape'"),
     ("[[materials]]\ncolor = 1\n", r"a\.toml:4: materials: \[\{'color': 1\}\] is not allowed"),
     ("[[camera.fov]]\na = 1\n", r"a\.toml:4: camera\.fov: "),
     ("[shape.x]\na = 1\n", r"a\.toml:4: unknown key 'shape'"),
     ("[lights.x]\na = 1\n", r"a\.toml:4: lights: ")],
)  # fmt: skip
def test_what_is_wrong_with_a_whole_array_is_told_with_its_line(tmp_path: Path, text: str, says: str):
    (tmp_path / "a.toml").write_text(f"[camera]\norigin = [0, 0, 5]\ntarget = [0, 0, 0]\n{text}")
    with pytest.raises(SceneError, match=f"^{says}"):
        clrt.load(tmp_path / "a.toml")


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


@pytest.mark.parametrize(
    ("word", "known", "says"),
    [
        ("keyframe", ["keyframes", "closed"], "did you mean 'keyframes'?"),
        ("glossiness", ["roughness"], "clrt calls it 'roughness', 1 less it"),
        ("fovy", ["fov"], "clrt calls it 'fov', with fov_axis = \"vertical\""),
        ("spot_angle", ["angle"], "clrt calls it 'angle', from the axis, half of a whole cone"),
        ("object", ["shapes", "lights"], "clrt calls it 'shapes'"), ("emitter", ["lights"], "'lights'"),
        ("tube", ["sphere", "cylinder"], "'cylinder'"), ("quad", ["polygon"], "'polygon'"),
        ("quad", ["rectangle", "point"], "'rectangle'"),
        ("tube", ["rectangle", "point"], "lights of other forms"),
    ],
)  # fmt: skip
def test_words_of_others_have_advice_of_their_place(word: str, known: list[str], says: str) -> None:
    assert says in missing.advice(word, known)


def test_a_camera_has_no_position_and_a_light_has():
    with pytest.raises(clrt.ClrtError, match="camera: unknown key 'position'; clrt calls it 'origin'"):
        clrt.load_dict({"camera": {"position": [0, 0, 5]}, "shapes": []})
    assert clrt.load_dict({"lights": [{"type": "point", "position": [0, 1, 0]}], "shapes": []}).lights
