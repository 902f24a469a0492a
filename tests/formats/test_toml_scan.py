"""What a TOML file declares is counted as the parser would count it."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

import clrt
from clrt import LimitError, Limits
from clrt.base.errors import SceneError
from clrt.base.files import read_text_bytes
from clrt.base.toml_scan import check
from clrt.formats.native import value_list
from clrt.meshfiles.planar import flaws, is_sound, same_turn


def most(text: str, limit: str) -> int:
    """The least value of a limit that lets the text pass."""
    tomllib.loads(text)
    for value in range(100):
        try:
            check(text, Limits(**{limit: value}), "a.toml")
        except LimitError as error:
            assert re.match(rf"a\.toml: {limit}: \d+ is above the limit of {value};", str(error))
        else:
            return value
    pytest.fail("no limit is enough")


@pytest.mark.parametrize(
    ("text", "depth"),
    [
        ("", 1),
        ("a = 1", 1),
        ("a = [1]", 2),
        ("[a]\nb = [[1]]", 3),
        ("[[a]]", 3),
        ("a.b.c = 1.5", 3),
        ('a . "b" . \'c\' = 1', 3),
        ("[a.b.c.d]", 4),
        ("x = {a.b.c.d = 1}", 4),
        ('a = "[[[[" # [[[[\n', 1),
        ("a = '[[[['\nb = '''[[[['x''''\nc = \"\"\"[[[[\\\"\"\"x\"\"\"\"\"", 1),
        ('a = "\\"[[["', 1),
    ],
)
def test_depth(text: str, depth: int) -> None:
    assert most(text, "nesting") == depth


@pytest.mark.parametrize(
    ("text", "tables"),
    [
        ("a = 1\nb = 1.5", 0),
        ("a = [1, [2, 3]]\nb = {}", 2),
        ("[a]\n[b]\n", 2),
        ("[a.b.c]", 3),
        ("[a.b]\n[a.c]", 3),
        ("a.b = 1\na.c = 1", 2),
        ("[a]\nb.c.d = 1.5\ne = 2.5", 3),
        # an item of an array of tables is forgotten with the next
        ("[[a]]\nb = [1]\n" * 5, 2),
        ("[[a]]\n[a.b]\nc = [1]\n" * 5, 3),
        ("[[a]]\nb = [1]\n[[c]]\nb = [1]\n" + "[[a]]\nb = []\n[[c]]\n" * 3, 4),
        # but not where the names are not known, nor those of outer tables
        ('[["a"]]\n' + '[["b"]]\n' * 2, 3),
        ("[[a.b]]\n" * 2, 3),
        # in inline tables, and those around them
        ("x = {a = [], b = {}}", 2),
        ("x = {a.b = 1, c.d.e = 2}", 3),
        ("x = [{a = []}, {b = []}, {c = []}]", 1),
        ("x = {a = [], b = {c = [], d = {e = []}}}", 5),
    ],
)
def test_tables(text: str, tables: int) -> None:
    assert most(text, "tables") == tables


@pytest.mark.parametrize(
    "text", ["a = [", "a = ]]]", '"""', "'''", '"\\', "a.b", "a = {b = [", "]a = [1]", "\x00é"]
)
def test_what_is_no_toml_is_left_to_the_parser(text: str) -> None:
    check(text, Limits(), "a.toml")
    with pytest.raises(tomllib.TOMLDecodeError):
        tomllib.loads(text)


def test_limits_of_text(tmp_path: Path) -> None:
    file = tmp_path / "a.toml"
    file.write_text("ambient = 0.25\n")
    assert read_text_bytes(file, Limits(text_bytes=15)) == b"ambient = 0.25\n"
    for limits in (Limits(text_bytes=14), Limits(file_bytes=14)):
        with pytest.raises(LimitError, match=r"(text|file)_bytes: 15 is above the limit of 14"):
            clrt.load(file, limits=limits)
    file.write_text("a." * 100_000 + "b = 1")
    with pytest.raises(LimitError, match="nesting: 100 001 is above the limit of 16"):
        clrt.load(file)


def test_the_key_that_stands_twice_is_named(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text('{"a": 1, "b": 2, "b": 3, "a": 4}')
    with pytest.raises(SceneError, match="the key 'b' stands twice"):
        clrt.load(tmp_path / "a.json")


def test_few_words_are_warned_of(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("word\n" * 100)
    with pytest.warns(clrt.ClrtWarning) as found:
        clrt.load(tmp_path / "a.txt")
    assert len(found) == 21 and str(found[-1].message) == "a.txt: 80 more warnings like these"


SQUARE = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]


def test_polygons_of_few_points_are_judged_alike() -> None:
    import numpy as np

    bent = [*SQUARE[:3], [0.0, 1.0, 0.01]]
    line = [[float(i), 0.0, 0.0] for i in range(4)]
    dart = [[0.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 2.0, 0.0], [1.0, 1.0, 0.0]]
    assert is_sound(SQUARE) and not is_sound(bent) and not is_sound(line)
    assert not is_sound(SQUARE * 3)  # too many points to be judged here
    assert [bool(f[0]) for f in flaws(np.array([SQUARE]))] == [False, False]
    assert [bool(f[0]) for f in flaws(np.array([bent]))] == [False, True]
    assert [bool(f[0]) for f in flaws(np.array([line]))] == [True, False]
    turned = [dart[3], *dart[:3]]  # its first corner is the one that turns the other way
    assert same_turn(dart) and not same_turn([*turned[3:], *turned[:3]])
    assert same_turn(line) and same_turn(SQUARE[:3])
    many = [[np.cos(t), np.sin(t), 0.0] for t in np.linspace(0, 6, 20)]
    assert same_turn(many)
    scene = clrt.load_dict({"shapes": [{"type": "polygon", "points": many}]})
    assert scene.shapes[0].primitives == 1


def test_a_number_is_no_longer_than_python_reads() -> None:
    check(f"a = {'1' * 4300}\nb = 'x{'1' * 5000}'\n{'c' * 5000} = 1", Limits(), "a.toml")
    with pytest.raises(SceneError, match=r"a\.toml: '-0\.1+\.\.\. is a number of 5 003 characters; 4300"):
        check(f"a = [1, -0.{'1' * 5000}]", Limits(), "a.toml")


@pytest.mark.parametrize("suffix", ["toml", "json"])
def test_a_high_limit_of_nesting_is_not_python_s(tmp_path: Path, suffix: str) -> None:
    limits, deep = Limits(nesting=10**6), "[" * 5000 + "]" * 5000
    (tmp_path / f"a.{suffix}").write_text(f"a = {deep}" if suffix == "toml" else deep)
    with pytest.raises(LimitError, match="nesting: deeper than Python's own readers follow"):
        clrt.load(tmp_path / f"a.{suffix}", limits=limits)
    with pytest.raises(LimitError, match="nesting: deeper than Python's own readers follow"):
        value_list(deep, limits, "--set a")
