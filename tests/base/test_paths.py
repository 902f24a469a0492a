"""Names of files: of pipes, devices and folders, endless ones, ones that lead nowhere, those of inputs."""

from __future__ import annotations

import io
import json
import os
import shutil
import signal
import socket
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base import files
from clrt.base.atomic import check_replaceable, replacing, write_text
from clrt.base.limits import Limits
from clrt.cli import main
from tests.cli.test_terminal import SCENE, fault

ROOM = SCENE.replace("0.9", "0.5")


@contextmanager
def soon(seconds: int = 20) -> Iterator[None]:
    """What waits for ever fails here."""
    before = signal.signal(signal.SIGALRM, lambda *_: pytest.fail("it waits"))
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def _fifo(path: Path) -> Path:
    os.mkfifo(path)
    return path


def _socket(path: Path) -> Path:
    with socket.socket(socket.AF_UNIX) as made:
        here = os.getcwd()
        os.chdir(path.parent)  # its name may have 108 bytes only
        try:
            made.bind(path.name)
        finally:
            os.chdir(here)
    return path


def _linked(path: Path, to: str) -> Path:
    path.symlink_to(to)
    return path


def _folder(path: Path) -> Path:
    path.mkdir()
    return path


NOT_FILES = {
    "a named pipe": _fifo,
    "a socket": _socket,
    "a folder": _folder,
    "a device": lambda path: _linked(path, "/dev/zero"),
    "Too many levels": lambda path: _linked(path, path.name),
    "there is no such file": lambda path: _linked(path, "nowhere"),
    "File name too long": lambda path: path.with_name("x" * 300 + path.suffix),
    "too long": lambda path: Path("/".join([str(path.parent), *["x" * 200] * 30, path.name])),
}


@pytest.mark.parametrize("what", NOT_FILES)
def test_only_regular_files_are_read(
    what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "ball.toml").write_text(ROOM)
    made = {suffix: NOT_FILES[what](tmp_path / f"odd{suffix}") for suffix in (".toml", ".exr", ".json")}
    scene, picture, report = made.values()
    with soon():
        for command in (
            ["hash", scene], ["hash", picture], ["render", scene, "-o", tmp_path / "a.png"],
            ["convert", scene, tmp_path / "a.json"], ["compare", picture, tmp_path / "ball.toml"],
            ["compare", tmp_path / "ball.toml", picture], ["bench", "--compare", report],
        ):  # fmt: skip
            said = fault(capsys, *command)
            assert what in said or "no such file" in said, said
        for mesh in (".obj", ".ply", ".glb", ".gltf", ".stl", ".nff", ".txt"):
            with pytest.raises(clrt.SceneError, match=what):
                clrt.load(NOT_FILES[what](tmp_path / f"mesh{mesh}"))
    assert not (tmp_path / "a.png").exists() and not (tmp_path / "a.json").exists()


@pytest.mark.parametrize("what", NOT_FILES)
def test_a_scene_names_regular_files(what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sky, mesh = (NOT_FILES[what](tmp_path / name) for name in ("sky.exr", "mesh.obj"))
    shape = f'[[shapes]]\ntype = "mesh"\nfile = "{mesh.relative_to(tmp_path)}"\n'
    (tmp_path / "a.toml").write_text(f'background = "{sky.relative_to(tmp_path)}"\n{ROOM}')
    (tmp_path / "b.toml").write_text(ROOM + shape)
    with soon():
        assert "background: " in fault(capsys, "hash", tmp_path / "a.toml")
        assert "shapes[1].file: " in fault(capsys, "hash", tmp_path / "b.toml")


@pytest.mark.parametrize("what", [what for what in NOT_FILES if what != "there is no such file"])
def test_only_regular_files_are_replaced(
    what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "ball.toml").write_text(ROOM)
    made = {suffix: NOT_FILES[what](tmp_path / f"odd{suffix}") for suffix in (".png", ".json", ".ck")}
    before = sorted(tmp_path.iterdir())
    picture, table, checkpoint = made.values()
    scene, out = tmp_path / "ball.toml", tmp_path / "a.png"
    with soon():
        for command in (
            ["render", scene, "-o", picture], ["render", scene, "-o", out, "--stats", table],
            ["render", scene, "-o", out, "--checkpoint", checkpoint], ["convert", scene, table],
            ["bench", "--json", table], ["plot-spectrum", "D65", "-o", picture],
        ):  # fmt: skip
            assert str(tmp_path) in fault(capsys, *command)
        with pytest.raises(clrt.ClrtError):
            clrt.load(scene).save(table)
    assert sorted(tmp_path.iterdir()) == before


def test_a_nul_in_a_name(tmp_path: Path) -> None:
    image = clrt.Image(np.zeros((2, 2, 3), np.float32))
    for call in (
        lambda: clrt.load("a\0b.toml"),
        lambda: clrt.load(tmp_path / "a\0b.obj"),
        lambda: clrt.read_image("a\0.png"),
        lambda: image.save("a\0.png"),
        lambda: image.save(tmp_path / "\0" / "a.exr"),
        lambda: check_replaceable("\0"),
    ):
        with pytest.raises(clrt.ClrtError, match=r"\\x00"):
            call()


def test_a_file_that_becomes_a_pipe_is_not_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = _fifo(tmp_path / "a.toml")
    status = os.stat(__file__)
    monkeypatch.setattr(files.os, "stat", lambda name: status)
    with soon(), pytest.raises(clrt.SceneError, match="is a named pipe, not a file"):
        files.open_input(path)


def test_a_file_that_cannot_be_read_to_its_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.toml").write_text(ROOM)

    class Broken(io.BytesIO):
        def fileno(self) -> int:
            return 0

        def read(self, size: int | None = -1) -> bytes:
            raise OSError(5, "Input/output error")

    monkeypatch.setattr("clrt.base.files.open_input", lambda path: Broken())
    with pytest.raises(clrt.SceneError, match=r"a\.toml: cannot be read: Input/output error"):
        files.read_bytes(tmp_path / "a.toml", Limits())
    with pytest.raises(clrt.SceneError, match=r"a\.toml: cannot be read: Input/output error"):
        clrt.read_image(tmp_path / "a.toml")


def test_a_limit_takes_no_memory(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.toml").write_text(ROOM)
    most = 999_999_999_999_999_999
    assert files.read_bytes(tmp_path / "a.toml", Limits(file_bytes=most)) == ROOM.encode()
    large = [f"--limit={name}_bytes={most}" for name in ("file", "text")]
    assert "pixels: " in fault(capsys, "hash", tmp_path / "a.toml", "--width", 65536, *large)


@pytest.mark.parametrize("grown", [0, 1, 5000, 3 << 20])
def test_a_file_that_grows_while_it_is_read(grown: int, tmp_path: Path) -> None:
    data = np.random.default_rng(1).bytes(1000 + grown)
    (tmp_path / "a.bin").write_bytes(data)
    with (tmp_path / "a.bin").open("rb") as file:
        assert files._read(file, 1000, 1 << 30) == data
    with (tmp_path / "a.bin").open("rb") as file:
        assert files._read(file, 1000, 1500) == data[:1500]


def test_files_that_wait_for_what_is_to_come(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As some of /proc, which say that they are regular, and empty."""
    reading, writing = os.pipe()
    status = os.stat_result((stat.S_IFREG | 0o600, 1, 1, 1, 0, 0, 0, 0, 0, 0))
    for suffix in (".toml", ".json", ".nff", ".txt", ".obj", ".gltf", ".stl", ".exr", ".png", ".jpg"):
        path = tmp_path / f"a{suffix}"
        path.write_text("")
        with monkeypatch.context() as patched, soon():
            patched.setattr(files, "_opened", lambda name, flags: os.dup(reading))
            patched.setattr(files.os, "fstat", lambda number: status)
            assert files.read_bytes(path, Limits()) == b""
            if suffix not in (".toml", ".txt", ".nff"):  # an empty scene is one
                with pytest.raises(clrt.ClrtError, match=f"a{suffix}"):
                    clrt.read_image(path) if suffix in (".exr", ".png", ".jpg") else clrt.load(path)
    os.close(reading)
    os.close(writing)


def test_every_kind_of_file_has_a_name() -> None:
    kinds = [stat.S_IFDIR, stat.S_IFIFO, stat.S_IFSOCK, stat.S_IFCHR, stat.S_IFBLK]
    named = ["a folder", "a named pipe", "a socket", "a device", "a device"]
    assert [files.kind(kind) for kind in kinds] == named


def test_a_name_may_be_all_suffix(tmp_path: Path) -> None:
    path = tmp_path / ("a." + "x" * 253)
    with replacing(path) as temporary:
        temporary.write_text("new")
    assert path.read_text() == "new" and list(tmp_path.iterdir()) == [path]


SKY = np.full((4, 8, 3), 0.5, np.float32)
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


@pytest.fixture
def room(tmp_path: Path) -> Path:
    clrt.Image(SKY).save(tmp_path / "sky.exr")
    (tmp_path / "mesh.obj").write_text(OBJ)
    mesh = '[[shapes]]\ntype = "mesh"\nfile = "mesh.obj"\n'
    (tmp_path / "room.toml").write_text(f'background = "sky.exr"\n{ROOM}{mesh}')
    (tmp_path / "link.exr").symlink_to("sky.exr")
    os.link(tmp_path / "sky.exr", tmp_path / "hard.exr")
    shutil.copy(tmp_path / "room.toml", tmp_path / "room.json")
    return tmp_path / "room.toml"


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["-o", "sky.exr"], "sky.exr, which is read; give --output"),
        (["-o", "link.exr"], "sky.exr, which is read; give --output"),
        (["-o", "hard.exr"], "sky.exr, which is read; give --output"),
        (["-o", "a.png", "--stats", "room.toml"], "is the scene; give --stats"),
        (["-o", "a.png", "--stats", "mesh.obj"], "mesh.obj: --stats writes JSON; give it a name"),
        (["-o", "a.png", "--checkpoint", "room.toml"], "is the scene; give --checkpoint"),
        (["-o", "a.png", "--checkpoint", "mesh.obj"], "mesh.obj: --checkpoint writes what is finished"),
        (["-o", "a.png", "--checkpoint", "./a.png"], "is the file of --output; give --checkpoint"),
        (["-o", "a.png", "--stats", "x", "--checkpoint", "x"], "is the file of --stats; give --checkpoint"),
    ],
)
def test_outputs_do_not_replace_what_is_read(
    room: Path,
    options: list[str],
    says: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(room.parent)
    before = {file.name: file.read_bytes() for file in room.parent.iterdir()}
    assert says in fault(capsys, "render", "room.toml", *options)
    assert {file.name: file.read_bytes() for file in room.parent.iterdir()} == before


def test_convert_does_not_replace_its_scene(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "is the scene; give OUT" in fault(capsys, "convert", room, room)
    assert main(["convert", str(room), str(room.with_name("new.toml"))]) == 0


def test_a_report_replaces_only_reports(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("only.json", "only", "report.xml"):
        assert "ends in .html" in fault(capsys, "validate", "--report", room.with_name(name))
    page = room.with_suffix(".html")
    for text in (room.read_text(), "[1]", "3", "{}", "[" * 100_000):
        room.with_suffix(".json").write_text(text)
        said = fault(capsys, "validate", "--case", "spheres", "--report", page)
        assert f"{room.with_suffix('.json')}: stands where" in said
        assert room.with_suffix(".json").read_text() == text
    keys = ("passed", "command", "versions", "cases", "coverage", "more")
    room.with_suffix(".json").write_text(json.dumps(dict.fromkeys(keys)))
    assert "case" in fault(capsys, "validate", "--case", "no such case", "--report", page)  # the next fault
    room.with_suffix(".xml").write_text("<root/>")
    assert "room.xml: stands" in fault(capsys, "validate", "--case", "spheres", "--report", page)


def _numbers() -> list[Any]:
    """Command, option and how many numbers it takes, for each option that is a whole number."""
    from clrt.cli.options import parser, whole

    found = []
    for command, made in parser().commands.items():
        for action in made._actions:
            assert action.type not in (int,), f"{command} {action.option_strings}: an int has no bounds"
            if action.type is whole and action.option_strings:
                found.append((command, action.option_strings[0], action.nargs or 1))
    return found


NUMBERS = _numbers()
ARGUMENTS = {
    "render": ["room", "-o", "a.png"], "hash": ["room"], "compare": ["room", "room"], "validate": [],
    "bench": ["--only", "none"], "plot-spectrum": ["D65"], "sweep": ["room", "-o", "{index}.png"],
    "turntable": ["room", "-o", "{index}.png"], "explain": ["room", "1", "1"], "view": ["room"],
}  # fmt: skip


@pytest.mark.parametrize("text", ["100000000000000000000", "9" * 5000, "-2147483648", "1e3", "٣", "1_0", ""])
def test_numbers_are_of_32_bits(
    text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert len(NUMBERS) >= 15
    for command, option, count in NUMBERS:
        said = fault(capsys, command, *ARGUMENTS[command], f"{option}", *[text] * count)
        assert option in said
    assert "X: " in fault(capsys, "explain", "room", text, "1") if text else True
    assert not list(tmp_path.iterdir())


def test_numbers_at_the_bounds_are_faults_of_theirs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for command, option, count in NUMBERS:
        for text in ("2147483647", "-2147483647"):
            if command in ("render", "hash") and not (option == "--threads" and text[0] != "-"):
                fault(capsys, command, *ARGUMENTS[command], option, *[text] * count)
    for device in ("99999999999999999999", "9" * 5000, "٣"):
        fault(capsys, "hash", "room", "--device", device)
    for exposure in ("1e400", "-1e20", "nan"):
        fault(capsys, "render", "room", "-o", "a.png", f"--exposure={exposure}")
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
def test_what_is_replaced_keeps_its_permissions(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file, seen = tmp_path / "a.txt", []
    for mode in (0o600, 0o664, 0o444, 0o4755):
        file.write_text("old")
        file.chmod(mode)
        with replacing(file) as temporary:
            seen.append(temporary.stat().st_mode & 0o077)
            temporary.write_text("new")
        assert file.read_text() == "new" and file.stat().st_mode & 0o7777 == mode & 0o777
        file.unlink()
    assert seen == [0] * 4, "not even while it is written"

    def refused(*_: object) -> None:
        raise PermissionError

    file.write_text("old")
    monkeypatch.setattr(os, "chmod", refused)
    write_text(file, "new")
    assert file.read_text() == "new"


@pytest.mark.skipif(os.name != "posix", reason="folders are synced on POSIX")
def test_a_file_is_written_though_its_folder_cannot_be_synced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a folder to hand in to (mode 0300), or on a system that syncs no folders: the file was there, and
    told to be one that cannot be written."""
    opened = os.open

    def refused(path: Any, flags: int, *more: Any, **named: Any) -> int:
        if Path(path) == tmp_path:
            raise PermissionError(13, "Permission denied")
        return opened(path, flags, *more, **named)

    monkeypatch.setattr(os, "open", refused)
    write_text(tmp_path / "a.txt", "new")
    assert (tmp_path / "a.txt").read_text() == "new"
