"""Exercises: each has one fault that its own scene shows, and only the right kernels pass the check."""

from __future__ import annotations

import errno
import json
import os
import shlex
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base import child
from clrt.base.resources import kernel_folder
from clrt.cli import exercise as of_exercises
from clrt.cli import main
from clrt.device.source import KERNEL_FILES, flatten_includes
from clrt.exercises import folder as folders
from clrt.exercises import judge
from clrt.exercises.table import HINTS, exercise, exercises, scenes
from tests import rotation
from tests.cli.test_terminal import fault

SEED = int(os.environ.get("CLRT_EXERCISE_SEED") or rotation.seed())
ALL = os.environ.get("CLRT_EXERCISES") == "all"
DRAWN = range(1, 31) if ALL else sorted(np.random.default_rng(SEED).choice(30, 3, replace=False) + 1)
"""Three of them, others after a change of the code: each compiles kernels that nobody has compiled before."""


@pytest.fixture
def begun(tmp_path: Path) -> folders.Started:
    return folders.start(1, tmp_path / "one")


def mend(started: folders.Started) -> None:
    file = started.exercise.file
    shutil.copy(kernel_folder() / file, started.kernels / file)


# --- what they are


def test_there_are_thirty_with_all_that_is_told() -> None:
    assert [one.number for one in exercises()] == list(range(1, 31))
    assert len({one.title for one in exercises()}) == 30
    assert {one.scene for one in exercises()} == set(scenes()) - {"bands"}
    for one in exercises():
        assert len(one.hints) == HINTS == 3 and one.lesson and len(one.picture) > 40
        assert one.right not in (one.picture, *one.hints)
        assert "/" not in one.file and (kernel_folder() / one.file).is_file()


def test_each_fault_has_one_place_in_the_program() -> None:
    right = flatten_includes(KERNEL_FILES, kernel_folder())
    for one in exercises():
        text = (kernel_folder() / one.file).read_text("utf-8")
        assert one.planted(text) != text and one.right in right
        with pytest.raises(clrt.ClrtError, match="needs this once"):
            one.planted(text + text)


def test_the_hints_name_the_file() -> None:
    """The second one at the latest, or the student reads all kernels."""
    assert [one.number for one in exercises() if not any(one.file in hint for hint in one.hints[:2])] == []


# --- a folder


def test_a_folder_has_one_fault_and_all_that_is_needed(begun: folders.Started) -> None:
    assert {file.name for file in begun.folder.iterdir()} == {
        "README.md", "exercise.json", "kernels", "scenes", "right.exr", "right.png",
    }  # fmt: skip
    names = {file.name for file in kernel_folder().iterdir()}
    assert {file.name for file in begun.kernels.iterdir()} == names
    own = {name: (kernel_folder() / name).read_bytes() for name in names}
    differ = [name for name in names if (begun.kernels / name).read_bytes() != own[name]]
    assert differ == [begun.exercise.file]
    readme = (begun.folder / "README.md").read_text("utf-8")
    assert begun.exercise.picture in readme and begun.exercise.right not in readme
    right = clrt.render(clrt.load(begun.folder / "scenes" / "table.toml"))
    assert np.array_equal(clrt.read_image(begun.folder / "right.exr"), right.pixels)
    assert folders.opened(begun.folder) == begun
    assert not [file for file in begun.folder.parent.iterdir() if file != begun.folder]


def test_a_full_disk_is_one_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(source: str, target: str, **more: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device", str(source), None, str(target))

    monkeypatch.setattr(shutil, "copyfile", full)
    said = fault(capsys, "exercise", "start", "1", tmp_path / "a")
    assert said == f"clrt: error: {tmp_path / 'a'}: cannot be made: No space left on device\n"
    assert not list(tmp_path.iterdir())


def test_hints_come_one_by_one(begun: folders.Started, capsys: pytest.CaptureFixture[str]) -> None:
    for number in (1, 2, 3, 3):
        assert main(["exercise", "hint", str(begun.folder)]) == 0
        said = capsys.readouterr().out
        assert said.startswith(f"hint {number} of 3") and begun.exercise.hints[number - 1] in said
    assert "again" in said and folders.opened(begun.folder).hints == 3


def test_the_list(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exercise", "list"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert len(said) == 31 and said[0] == " 1  The shadow is gone"
    assert main(["exercise", "list", "--json", "-v"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["exercise"] for row in rows] == list(range(1, 31)) and rows[0]["title"] == exercise(1).title


# --- the check


def test_what_is_mended_passes(begun: folders.Started, capsys: pytest.CaptureFixture[str]) -> None:
    mend(begun)
    assert main(["exercise", "check", str(begun.folder)]) == 0
    said = capsys.readouterr().out
    assert "mended; 6 pictures are right" in said and begun.exercise.lesson in said
    assert main(["exercise", "check", "--json", str(begun.folder)]) == 0
    (row,) = json.loads(capsys.readouterr().out)
    assert row["mended"] and row["exercise"] == 1 and row["pixel"] is None


@pytest.mark.debian_pocl  # it compiles kernels anew, which PoCL does soonest
@pytest.mark.parametrize("number", [pytest.param(int(n), id=f"{n}, seed {SEED}") for n in DRAWN])
def test_the_fault_fails_on_its_own_scene(number: int, tmp_path: Path) -> None:
    """So it fails the check of every other exercise too, which renders all scenes: it mends none."""
    started = folders.start(number, tmp_path / "drawn")
    (found,) = judge.judged(started.exercise, started.kernels)
    assert not found.right and found.scene == started.exercise.scene and found.share > 0.005
    other = exercise(number % 30 + 1)
    assert not all(found.right for found in judge.judged(other, started.kernels))


WRONG = {
    1: "((primitive) <= 0)",  # what is primitive 0 throws no shadow
    4: "radiance[b] = light->intensity[b] * to.factor",
    14: "floatP share = material->kt * material->tint[b];",
    15: "material->kt * material->tint[b]",
    18: "",
}


@pytest.mark.debian_pocl
@pytest.mark.parametrize("number", WRONG)
def test_what_mends_one_thing_and_breaks_another_is_no_mend(number: int, tmp_path: Path) -> None:
    """What the five scenes that show the faults do not show."""
    one = exercise(number)
    shutil.copytree(kernel_folder(), tmp_path / "kernels")
    text = (kernel_folder() / one.file).read_text("utf-8")
    assert text.count(one.right) == 1
    (tmp_path / "kernels" / one.file).write_text(text.replace(one.right, WRONG[number]))
    scene = "lamps" if number == 1 else "bands"  # where shadows are opaque
    picture = judge._picture(scene, tmp_path / "kernels", None)
    assert not judge.compared(scene, judge.right_picture(scene), picture).right


def test_rounding_is_told_apart() -> None:
    row = {"folder": "f", "exercise": 1, "hints": 0, "error": None, "scene": "table", "share": 0.15,
           "pixel": (1, 2), "mended": False}  # fmt: skip
    for largest, told in (6e-8, True), (0.2, False):
        said = " ".join(of_exercises._words({**row, "largest": largest}))
        assert ("by no more than 6e-08, as of the right formula in another order" in said) == told
    right, mine = (clrt.Image(np.full((2, 3, 3), value, np.float32)) for value in (4.0, 4.0 + 1e-5))
    assert 1e-6 < judge.compared("a", right, mine).largest < 4e-6


def test_any_bit_counts() -> None:
    right = clrt.Image(np.full((2, 3, 3), 0.5, np.float32))
    assert judge.compared("table", right, right).right
    for value in (np.nextafter(np.float32(0.5), np.float32(1)), np.nan, np.inf, -0.5):
        pixels = right.pixels.copy()
        pixels[1, 2, 0] = value
        found = judge.compared("table", right, clrt.Image(pixels))
        assert (found.right, found.pixel, found.share) == (False, (2, 1), 1 / 6)


def test_another_scene_that_is_wrong_is_named(
    begun: folders.Started, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    wrong = judge.Finding("glass", 0.25, (7, 9))
    monkeypatch.setattr(judge, "judged", lambda *_: iter([judge.Finding("table", 0.0, None), wrong]))
    monkeypatch.setattr(of_exercises, "_by_child", lambda name, given, _: of_exercises._checked(name, given))
    assert main(["exercise", "check", str(begun.folder)]) == 1
    said = capsys.readouterr().out
    assert "not yet; 25 % of the pixels of scenes/glass.toml" in said and "more was changed" in said
    file = shlex.quote(str(begun.folder / "scenes" / "glass.toml"))  # wherever the command is typed
    kernels = shlex.quote(str(begun.folder / "kernels"))
    assert f"CLRT_KERNELS={kernels} clrt explain {file} 7 9" in said


def test_a_class_is_checked_whatever_its_kernels_do(
    tmp_path: Path, begun: folders.Started, capsys: pytest.CaptureFixture[str]
) -> None:
    mend(begun)
    lost = shutil.copytree(begun.folder, tmp_path / "lost")
    (lost / "kernels" / "light.cl").unlink()
    nothing = tmp_path / "nothing"
    nothing.mkdir()
    names = [str(begun.folder), str(lost), str(nothing)]
    assert main(["exercise", "check", "--json", *names]) == 1
    mended, without, empty = json.loads(capsys.readouterr().out)
    assert mended["mended"] and mended["folder"] == names[0] and mended["error"] is None
    assert "light.cl: there is no such file" in without["error"] and "is no exercise" in empty["error"]
    assert main(["exercise", "check", "--timeout", "0.01", *names[:2]]) == 1
    said = capsys.readouterr().out
    assert said.count("not judged: no answer within 0.01 s") == 2 and said.endswith("0 of 2 mended\n")


def test_kernels_that_print_are_judged_too(
    tmp_path: Path, begun: folders.Started, capsys: pytest.CaptureFixture[str]
) -> None:
    """As students do who look for the fault; what they print is no part of the answer."""
    mend(begun)
    file = begun.folder / "kernels" / "film.cl"
    text = file.read_text()
    head = text.index("{", text.index("__kernel")) + 1
    said = '\n    if (get_global_id(0) == 0) printf("[{\\"mended\\": 0}]\\n");'
    file.write_text(text[:head] + said + text[head:])
    names = [str(begun.folder), str(shutil.copytree(begun.folder, tmp_path / "other"))]
    assert main(["exercise", "check", "--json", *names]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["mended"] for row in rows] == [True, True]


def test_a_process_that_ends_without_an_answer_is_a_finding(
    begun: folders.Started, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(child, "interpreter", lambda: "/bin/true")
    assert main(["exercise", "check", str(begun.folder), str(begun.folder)]) == 1
    assert "not judged: exit code 0" in capsys.readouterr().out
    assert main(["exercise", "check", str(begun.folder), "--json"]) == 1, "one folder is no other thing"
    assert json.loads(capsys.readouterr().out)[0]["error"] == "exit code 0"
    assert "exit code 0" in fault(capsys, "exercise", "check", begun.folder)


def test_a_process_that_dies_is_a_finding(
    tmp_path: Path, begun: folders.Started, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    script = tmp_path / "dies"
    script.write_text("#!/bin/sh\nkill -SEGV $$\n")
    script.chmod(0o755)
    monkeypatch.setattr(child, "interpreter", lambda: str(script))
    assert main(["exercise", "check", str(begun.folder), str(begun.folder)]) == 1
    assert "the kernels end the process (signal 11)" in capsys.readouterr().out
    assert "the kernels end the process (signal 11)" in fault(capsys, "exercise", "check", begun.folder)
    script.write_text("#!/bin/sh\nsleep 60\n")
    assert "no answer within 0.2 s" in fault(capsys, "exercise", "check", "--timeout", "0.2", begun.folder)


# --- what is not right


def test_numbers_and_folders_that_cannot_be(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for number in ("0", "31", "-1"):
        assert "numbered 1 to 30" in fault(capsys, "exercise", "start", "--", number, tmp_path / "a")
    assert "not a whole number" in fault(capsys, "exercise", "start", "one", tmp_path / "a")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").write_text("mine")
    assert "is not empty" in fault(capsys, "exercise", "start", "1", tmp_path / "full")
    assert (tmp_path / "full" / "mine.txt").read_text() == "mine"
    (tmp_path / "file").write_text("")
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    for name in ("file", "link", "file/x", "file/x/y"):
        assert "is no folder" in fault(capsys, "exercise", "start", "1", tmp_path / name)
    assert "cannot be made" in fault(capsys, "exercise", "start", "1", tmp_path / "file" / "b")
    assert "cannot be" in fault(capsys, "exercise", "start", "1", f"{tmp_path}/a\0b")
    assert "--timeout" in fault(capsys, "exercise", "check", "--timeout", "nan", tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"full", "file", "link"}


@pytest.mark.parametrize("value, reason", [
    (None, "it has no exercise.json"), ("", "exercise.json"), ("[1]", "exercise.json"),
    ("{", "exercise.json"), ({"exercise": 31}, "there is no exercise 31"), ({"hints": 9}, "9 hints"),
    ({"more": 1}, "more"),
    ({"exercise": "1"}, "int"), ({"kernels": "others"}, "begin again"),
])  # fmt: skip
def test_a_folder_that_is_no_exercise(
    value: Any, reason: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    right = {"exercise": 1, "hints": 0, "version": "0.1.0", "kernels": folders._digest()}
    if value is not None:
        text = json.dumps({**right, **value}) if isinstance(value, dict) else value
        (tmp_path / "exercise.json").write_text(text)
    for command in (["hint"], ["check"]):
        assert reason in fault(capsys, "exercise", *command, tmp_path)
