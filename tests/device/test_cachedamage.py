"""Damaged kernels: what is opened, what is removed, and that nothing else is."""

from __future__ import annotations

import os
import struct
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from clrt.device import binaries, cachedamage, cachefolder, cachelock, platforms, trial


def laid_out(folder: Path, count: int) -> list[Path]:
    """Files as PoCL keeps them, of so many programs with a kernel each; all are whole."""
    head = (b"\x7fELF\x02" + bytes(35) + struct.pack("<Q10xHH", 64, 0, 0)).ljust(64, b"\0")
    bitcode = b"BC\xc0\xde" + struct.pack("<III", 0, 1, 0)
    files = []
    for number in range(count):
        program = folder / f"A{'ABCDEFGHIJKLMNOP'[number % 16]}" / ("ABCDEFGHIJKLMNOP"[number // 16] * 37)
        for file, data in {"twice/16-1-1/twice.so": head, "program.bc": bitcode}.items():
            files.append(program / file)
            files[-1].parent.mkdir(parents=True, exist_ok=True)
            files[-1].write_bytes(data)
    return files


def test_only_what_is_new_is_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files, opened, whole = laid_out(tmp_path, 20), [], cachedamage.whole

    def looked_at(file: Path) -> bool:
        opened.append(file)
        return whole(file)

    monkeypatch.setattr(cachedamage, "whole", looked_at)
    time.sleep(0.02)  # longer than a tick of a file system's clock
    assert cachedamage.remove_damaged(tmp_path) == [] and sorted(opened) == sorted(files)
    opened.clear()
    assert cachedamage.remove_damaged(tmp_path) == [] and opened == []
    damaged = [files[4], files[11]]  # in place, and by another file in its place with the time of long ago
    damaged[0].write_bytes(b"")
    (tmp_path / "other").write_bytes(b"BC")
    os.utime(tmp_path / "other", (1, 1))
    (tmp_path / "other").replace(damaged[1])
    programs = sorted(file.relative_to(tmp_path).parts[0] for file in damaged)
    found = cachedamage.remove_damaged(tmp_path)
    assert [program.parent.name for program in found] == programs
    assert set(damaged) <= set(opened)
    assert {file.relative_to(tmp_path).parts[0] for file in opened} == set(programs)
    assert not any(program.exists() for program in found)


def test_a_program_that_is_put_there_is_opened(tmp_path: Path) -> None:
    """Though its files are as old as they were elsewhere: that moves them says nothing to their own times."""
    laid_out(tmp_path / "cache", 2)
    (old, damaged), kept = sorted((tmp_path / "cache").iterdir()), tmp_path / "kept"
    damaged.rename(kept)
    for file in kept.rglob("*.so"):
        file.write_bytes(b"")
    time.sleep(0.02)
    assert cachedamage.remove_damaged(tmp_path / "cache") == []
    time.sleep(0.02)
    kept.rename(damaged)
    assert [program.parent for program in cachedamage.remove_damaged(tmp_path / "cache")] == [damaged]
    assert old.exists()


def test_what_is_not_the_drivers_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The folder may be one that holds all kinds of things: whoever set POCL_CACHE_DIR chose it."""
    cache, elsewhere = tmp_path / "cache", tmp_path / "elsewhere"
    laid_out(cache, 2), laid_out(elsewhere, 2)
    digest = "A" * 37
    for folder in ("project/build", f"AB/{digest}x", f"project/{digest}", "ABC/build", f"AC/{digest}/a/b/c"):
        place = cache / folder / "lib/x86"
        place.mkdir(parents=True)
        (place / "libfoo.so").symlink_to("libfoo.so.1")
        (place / "libc.so").write_text("GROUP ( /lib/libc.so.6 )")
        (cache / folder / "program.bc").write_text("not of LLVM")
        (cache / folder / "thesis.txt").write_text("mine")
    (cache / "launched" / "clrt.lock").mkdir(parents=True)
    for mine in "looked", "launched/clrt.lock/notes", "looking-oldoldol":
        (cache / mine).write_text("mine")
    (cache / "AP").symlink_to(elsewhere)
    (cache / "AA" / ("B" * 37)).symlink_to(elsewhere / "AA" / digest)  # a program of the driver: unlinked
    (elsewhere / "AA" / digest / "program.bc").write_bytes(b"")
    monkeypatch.setenv(cachefolder.VARIABLE, str(cache))
    with cachelock.compiling("005af56b4a3230b5", "arrange", 1, True):
        mark = cachefolder.ours("launched", "005af56b4a3230b5-arrange-1-True")
    assert mark.exists()
    before = set(tmp_path.rglob("*"))
    assert cachedamage.remove_damaged(cache) == [cache / "AA" / ("B" * 37)]
    gone = before - set(tmp_path.rglob("*"))
    assert {path.relative_to(cache) for path in gone if path.parent.parent != elsewhere} == {
        Path("AA", "B" * 37), mark.relative_to(cache)
    }  # fmt: skip
    assert {file.read_text() for file in cache.rglob("*") if file.name in ("looked", "notes")} == {"mine", ""}


def test_folders_may_be_deeper_than_python_goes(deep: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In a program's folder, damaged or not, and in place of a lock: what cannot be removed stays."""
    monkeypatch.setenv(cachefolder.VARIABLE, str(deep))
    files, here = laid_out(deep, 2), Path.cwd()
    whole, damaged = files[0].parent, files[-1].parent
    assert whole != damaged
    lock = cachefolder.ours("clrt.lock")
    for place in (whole, damaged, lock):
        place.mkdir(parents=True, exist_ok=True)
        os.chdir(place)
        try:
            for _ in range(sys.getrecursionlimit() + 100):
                os.mkdir("d")
                os.chdir("d")
        finally:
            os.chdir(here)
    files[-1].write_bytes(b"")
    with cachelock.lock():
        assert len(cachedamage.remove_damaged(deep)) == 1
    assert len([*cachefolder.regular_files(deep)]) >= len(files) - 1


def test_a_folder_of_processes_that_is_linked_stops_nobody(tmp_path: Path) -> None:
    (tmp_path / "AA").symlink_to("/proc")
    (tmp_path / "AB").mkdir()
    (tmp_path / "AB" / ("A" * 37)).symlink_to("/proc")
    assert len(cachedamage.remove_damaged(tmp_path)) == 1


def test_after_a_start_of_the_machine_all_is_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file may be lost with its power though it was whole when it was looked at, and keep its time."""
    laid_out(tmp_path, 3)
    time.sleep(0.02)
    cachedamage.remove_damaged(tmp_path)
    monkeypatch.setattr(cachedamage, "whole", lambda file: False)
    assert cachedamage.remove_damaged(tmp_path) == []
    monkeypatch.setattr(time, "monotonic_ns", lambda: 0)
    assert len(cachedamage.remove_damaged(tmp_path)) == 3


@pytest.mark.parametrize("planted", ["folder", "pipe", "link", "time to come"])
def test_what_lies_where_the_last_look_is_noted_stops_nobody(tmp_path: Path, planted: str) -> None:
    files, looked = laid_out(tmp_path, 3), tmp_path / ".clrt" / "looked"
    looked.parent.mkdir()
    if planted == "folder":
        (looked / "full").mkdir(parents=True)
    elif planted == "pipe" and hasattr(os, "mkfifo"):
        os.mkfifo(looked)
    elif planted == "link":
        looked.symlink_to(tmp_path / "nowhere")
    else:
        looked.touch()
        os.utime(looked, (2e10, 2e10))
        files[1].write_bytes(b"")
        assert len(cachedamage.remove_damaged(tmp_path)) == 1
    assert cachedamage.remove_damaged(tmp_path) == []
    files[-1].write_bytes(b"")
    assert len(cachedamage.remove_damaged(tmp_path)) == 1
    assert not list(looked.parent.glob("looking-*"))


def test_what_the_driver_leaves_behind_goes_when_it_is_old(tmp_path: Path) -> None:
    stay = {"tempfile_fulful", "tempfile_newnew", "other_oldold", "tempfile_mine.txt"}
    (tmp_path / ".clrt").mkdir()
    for name in (*stay, "tempfile_oldold", ".clrt/looking-oldoldol"):
        (tmp_path / name).write_bytes(b"x" if name == "tempfile_fulful" else b"")
        if name != "tempfile_newnew":
            os.utime(tmp_path / name, (1, 1))
    cachedamage.remove_damaged(tmp_path)
    assert {file.name for file in tmp_path.iterdir()} == stay | {".clrt"}
    assert [file.name for file in (tmp_path / ".clrt").iterdir()] == ["looked"]


def folder_instead(file: Path) -> None:
    file.mkdir()


def link_to_itself(file: Path) -> None:
    file.symlink_to(file)


ODD = (folder_instead, link_to_itself, os.mkfifo) if hasattr(os, "mkfifo") else (folder_instead,)


@pytest.mark.parametrize("make", ODD)
def test_what_is_no_file_is_damage_and_nobody_waits_for_it(
    make: Callable[[Path], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Found in a cache folder, these end the driver's process, or are read for ever."""
    for name in ("split.so", "program.bc"):
        make(tmp_path / name)
        assert not cachedamage.whole(tmp_path / name)
        with pytest.raises(OSError, match=r"regular|symbolic"):
            cachefolder.contents(tmp_path / name)
    monkeypatch.setenv(cachefolder.VARIABLE, str(tmp_path))
    cachefolder.make(cachefolder.ours())
    make(cachefolder.ours("clrt.lock.holder"))
    make(cachefolder.ours("clrt.lock"))  # held by nobody, it would keep all from removing damage
    with cachelock.lock() as got:
        assert got and cachelock._holder(cachefolder.ours("clrt.lock.holder")) == 0
    monkeypatch.setattr(trial, "_tried", lambda info: "")
    info = platforms.DeviceInfo(0, "name", "platform", "1.0", "CPU", 2, 1 << 30, "7")
    trial.verdict(info)
    (verdict,) = cachefolder.ours("verdicts").iterdir()
    verdict.unlink()
    make(verdict)
    assert trial.verdict(info) == ("", True)
    make(tmp_path / "binary")
    assert binaries._read(tmp_path / "binary", b"name") == b""


def test_bitcode_that_goes_on_with_nothing_is_damage(tmp_path: Path) -> None:
    """As a disk leaves it that lost what was written last; 40 GB of zeros were read eight bytes at a time."""
    file = tmp_path / "program.bc"
    file.write_bytes(b"BC\xc0\xde" + struct.pack("<III", 8, 1, 0))
    assert cachedamage.whole(file)
    os.truncate(file, 40 << 30)
    assert not cachedamage.whole(file)
