"""docs/explain.md: its commands print what it says, its code runs, its pictures are of these pixels."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

import clrt
from clrt.cli import main

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGE = (DOCS / "explain.md").read_text("utf-8")
SHOWN = re.findall(r"^    \$ clrt (explain .+)\n((?:    .+\n)+)", PAGE, re.MULTILINE)


def test_five_places_are_explained() -> None:
    assert len(SHOWN) == 5 and len(re.findall(r"^### \d\.", PAGE, re.M)) == 5
    drawn = re.findall(r">\d: pixel \((\d+), (\d+)\)<", (DOCS / "explain-rays.svg").read_text("utf-8"))
    assert drawn == [tuple(command.split()[2:4]) for command, _ in SHOWN]


def test_the_picture_shows_what_is_explained() -> None:
    # of nine samples where the tree is of one: an edge is another colour there, as 0.60 was for 0.93;
    # these differ by 2 percent at most
    tracer = clrt.Tracer("showcase")
    for command, _ in SHOWN:
        x, y = map(int, command.split()[2:4])
        assert tracer.render(crop=(x, y, 1, 1)).pixels[0, 0] == pytest.approx(
            tracer.explain(x, y, spp=1).value, rel=0.1
        )


@pytest.mark.parametrize(("command", "said"), SHOWN)
def test_the_page_says_what_the_command_says(
    command: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(shlex.split(command)) == 0
    assert capsys.readouterr().out == re.sub("^    ", "", said, flags=re.M)


def test_the_other_commands_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("trimesh", reason="needs the optional dependency clrt[mesh]")
    monkeypatch.chdir(tmp_path)
    commands = re.findall(r"^    clrt (explain .+?)(?:  +#.*)?$", PAGE, re.MULTILINE)
    assert len(commands) == 3
    for command in commands:
        assert main(shlex.split(command)) == 0


def test_the_code_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (block,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    exec(block, {})
    assert (tmp_path / "why.html").stat().st_size > 1000


def test_every_key_of_the_json_is_on_the_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import json

    assert main(["explain", "bubble", "20", "10", "--width", "64", "--json"]) == 0
    table = json.loads(capsys.readouterr().out)
    words = set(re.findall(r"\w+", PAGE))
    assert [key for key in table if key not in words and key != "clrt"] == []
