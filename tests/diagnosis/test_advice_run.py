"""What a message quotes as a command, and each example of `--help`, works when it is typed."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from functools import cache
from itertools import chain
from pathlib import Path

import pytest

import clrt
from clrt.cli.examples import EXAMPLES
from tests.cli_samples import with_options
from tests.diagnosis.test_advice import ROOT, messages

SCENE = """max_depth = 1
lights = [{type = "point", position = [3, 5, 4]}]
shapes = [{type = "sphere", center = [0, 0, 0], radius = 1}]
camera = {origin = [0, 0, 4], target = [0, 0, 0], width = 12, height = 8}
"""
PATH = "[[keyframes]]\n[[keyframes]]\norigin = [3, 1, 4]\n"

FILLED = {
    "clrt check --json *.toml": "clrt check --json [abr]*.toml",
    "clrt convert": "clrt convert room.toml room.pov",
    "clrt exercise start": "clrt exercise start 1 here",
    "clrt exercise start N DIR": "clrt exercise start 1 there",
    "clrt exercise start X DIR": "clrt exercise start 2 again",
    "clrt hash showcase --width 320": "clrt hash showcase --width 16",
    "clrt render showcase -o showcase.png": "clrt render showcase -o showcase.png --width 16",
}
"""What stands for a placeholder; and a smaller picture, where the time is the size's alone."""
SMALLER = {"sweep": {"width": 32}, "turntable": {"width": 32, "frames": 2}}
"""In the place of a command's own: its frames, and the path's, are 120."""

ELSEWHERE = {
    "clrt bench": "takes minutes",
    "clrt exercise check": "compiles kernels for as long as all others take",
    "clrt selftest": "takes minutes; --quick 6 s, and 30 s where kernels have to be compiled",
    "clrt validate": "renders with other programs",
    "clrt view": "does not end by itself",
}
"""By their beginning: what is not run here, and why; all of these have tests of their own."""


@cache
def quoted() -> list[str]:
    """Each command once."""
    texts = [text for folder in ("clrt", "validation") for _, text in messages(folder)]
    found = [piece for text in texts for piece in re.findall(r"`(clrt [^`]*)`", text)]
    return sorted({*found, *(line for line, _ in chain(*EXAMPLES.values()))})


def typed(command: str) -> str:
    """As somebody types it."""
    return FILLED.get(command) or with_options(command, **SMALLER.get(command.split()[1], {}))


RUN = [command for command in quoted() if not command.startswith(tuple(ELSEWHERE))]


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the files that examples name, and `clrt` beside it."""
    desk = tmp_path_factory.mktemp("advice") / "desk"
    (desk / "out").mkdir(parents=True)
    for name in ("room.toml", "a.toml", "b.toml"):
        (desk / name).write_text(SCENE)
    (desk / "path.toml").write_text(PATH)
    (desk / "balls.nff").write_text(
        "v\nfrom 0 0 4\nat 0 0 0\nup 0 1 0\nangle 40\nhither 0\nresolution 12 8\ns 0 0 0 1\n"
    )
    picture = clrt.render(clrt.load(desk / "room.toml"))
    for name in ("mine.png", "theirs.png", "picture.exr"):
        picture.save(desk / name)
    program = desk.parent / "bin" / "clrt"
    program.parent.mkdir()
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -P -m clrt "$@"\n')
    program.chmod(0o755)
    return desk


def run(desk: Path, command: str) -> subprocess.CompletedProcess[str]:
    paths = {"PATH": f"{desk.parent / 'bin'}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT)}
    return subprocess.run(
        ["/bin/sh", "-c", command], cwd=desk, env=os.environ | paths, capture_output=True, text=True,
        timeout=300, stdin=subprocess.DEVNULL, check=False, errors="replace",
    )  # fmt: skip


@pytest.mark.parametrize("command", RUN)
def test_what_is_quoted_works(desk: Path, command: str) -> None:
    done = run(desk, typed(command))
    assert done.returncode == 0, f"{typed(command)}\n{done.stdout}{done.stderr}"


def test_the_list_is_that_of_the_messages() -> None:
    assert {"clrt devices", "clrt scenes", "clrt exercise list", "clrt doctor"} <= set(RUN)
    assert set(FILLED) <= set(RUN), "what is no longer quoted needs no form"
    for beginning in ELSEWHERE:
        assert any(command.startswith(beginning) for command in quoted()), beginning


def test_what_a_limit_advises_lifts_it(desk: Path) -> None:
    plain = "clrt render room.toml -o out/room.png --spp 4"
    refused = run(desk, f"{plain} --limit work=1").stderr
    (least,), (option,) = (
        re.findall(r"work: ([\d ]+) is", refused),
        re.findall(r"with (--limit work=)N", refused),
    )
    number = int(least.replace(" ", ""))
    assert [run(desk, f"{plain} {option}{n}").returncode for n in (number - 1, number)] == [2, 0]
