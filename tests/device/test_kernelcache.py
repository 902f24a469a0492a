"""The folder of compiled kernels: who may have written it, what of it is damaged, who waits for whom."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from clrt.device import binaries, cachefolder, damage, kernelcache, platforms, trial, turns


def test_a_folder_that_others_may_write_to_is_not_used(tmp_path: Path) -> None:
    good = tmp_path / "good"
    assert kernelcache.problem(good) == ""
    assert good.stat().st_mode & 0o777 == 0o700
    for mode in (0o777, 0o770, 0o1777, 0o702):
        good.chmod(mode)
        assert "is not yours alone" in kernelcache.problem(good), oct(mode)
    good.chmod(0o755)
    assert kernelcache.problem(good) == ""
    above = tmp_path / "above"
    above.mkdir()
    above.chmod(0o777)  # anybody could put another folder in its place
    assert f"others may write to {above}" in kernelcache.problem(above / "folder")
    above.chmod(0o1777)  # as /tmp: nobody can
    assert kernelcache.problem(above / "folder") == ""
    (tmp_path / "link").symlink_to(good)
    good.chmod(0o777)
    assert "is not yours alone" in kernelcache.problem(tmp_path / "link")


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
    files, opened, whole = laid_out(tmp_path, 20), [], damage.whole

    def looked_at(file: Path) -> bool:
        opened.append(file)
        return whole(file)

    monkeypatch.setattr(damage, "whole", looked_at)
    time.sleep(0.02)  # longer than a tick of a file system's clock
    assert damage.remove_damaged(tmp_path) == [] and sorted(opened) == sorted(files)
    opened.clear()
    assert damage.remove_damaged(tmp_path) == [] and opened == []
    damaged = [files[4], files[11]]  # in place, and by another file in its place with the time of long ago
    damaged[0].write_bytes(b"")
    (tmp_path / "other").write_bytes(b"BC")
    os.utime(tmp_path / "other", (1, 1))
    (tmp_path / "other").replace(damaged[1])
    programs = sorted(file.relative_to(tmp_path).parts[0] for file in damaged)
    found = damage.remove_damaged(tmp_path)
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
    assert damage.remove_damaged(tmp_path / "cache") == []
    time.sleep(0.02)
    kept.rename(damaged)
    assert [program.parent for program in damage.remove_damaged(tmp_path / "cache")] == [damaged]
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
    with turns.compiling("005af56b4a3230b5", "arrange", 1, True):
        mark = cachefolder.ours("launched", "005af56b4a3230b5-arrange-1-True")
    assert mark.exists()
    before = set(tmp_path.rglob("*"))
    assert damage.remove_damaged(cache) == [cache / "AA" / ("B" * 37)]
    gone = before - set(tmp_path.rglob("*"))
    assert {path.relative_to(cache) for path in gone if path.parent.parent != elsewhere} == {
        Path("AA", "B" * 37), mark.relative_to(cache)
    }  # fmt: skip
    assert {file.read_text() for file in cache.rglob("*") if file.name in ("looked", "notes")} == {"mine", ""}


@pytest.fixture
def deep(tmp_path: Path) -> Iterator[Path]:
    """A folder that is emptied however the test ends: pytest, this run's or a later one's, cannot."""
    yield tmp_path
    subprocess.run(["rm", "-rf", *map(str, tmp_path.iterdir())], check=True)


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
    with turns.lock():
        assert len(damage.remove_damaged(deep)) == 1
    assert len([*cachefolder.regular_files(deep)]) >= len(files) - 1


def test_a_folder_s_name_may_be_relative(tmp_path: Path) -> None:
    """PoCL shows no device where it is "."."""

    def devices(**more: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-P", "-m", "clrt", "devices"]
        run = {"cwd": tmp_path, "capture_output": True, "text": True, "check": False}
        return subprocess.run(command, env={**os.environ, "CLRT_DEVICE": "", **more}, **run)

    done = devices(POCL_CACHE_DIR=".")
    assert done.returncode == 0 and "(CPU, " in done.stdout, done
    done = devices(POCL_DEVICES="none", CLRT_DRIVER="pocl")
    assert done.returncode == 2 and "no OpenCL device" in done.stderr and "unset POCL_DEVICES" in done.stderr


def test_a_folder_of_processes_that_is_linked_stops_nobody(tmp_path: Path) -> None:
    (tmp_path / "AA").symlink_to("/proc")
    (tmp_path / "AB").mkdir()
    (tmp_path / "AB" / ("A" * 37)).symlink_to("/proc")
    assert len(damage.remove_damaged(tmp_path)) == 1


def test_after_a_start_of_the_machine_all_is_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file may be lost with its power though it was whole when it was looked at, and keep its time."""
    laid_out(tmp_path, 3)
    time.sleep(0.02)
    damage.remove_damaged(tmp_path)
    monkeypatch.setattr(damage, "whole", lambda file: False)
    assert damage.remove_damaged(tmp_path) == []
    monkeypatch.setattr(time, "monotonic_ns", lambda: 0)
    assert len(damage.remove_damaged(tmp_path)) == 3


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
        assert len(damage.remove_damaged(tmp_path)) == 1
    assert damage.remove_damaged(tmp_path) == []
    files[-1].write_bytes(b"")
    assert len(damage.remove_damaged(tmp_path)) == 1
    assert not list(looked.parent.glob("looking-*"))


@pytest.mark.parametrize("folders", [1200, 300])
def test_the_cache_s_name_may_be_of_any_length_and_depth(deep: Path, folders: int) -> None:
    """The driver ends the process where a file's name in it has more than 1,024 bytes."""
    place = deep.joinpath(*["d"] * folders)
    found = kernelcache.problem(place)
    size = len(str(place))
    assert (f"has {size} bytes, and the driver takes {kernelcache.LONGEST}; set POCL" in found) == (
        size > kernelcache.LONGEST
    )
    assert place.is_dir() == (found == "") and len(found) < 300
    longest = deep / ("n" * (kernelcache.LONGEST // 3))
    longest = longest / longest.name
    longest /= "n" * (kernelcache.LONGEST - len(str(longest)) - 1)
    assert len(str(longest)) == kernelcache.LONGEST
    command = [sys.executable, "-P", "-m", "clrt", "hash", "room", "--width", "4"]
    variables = {**os.environ, "POCL_CACHE_DIR": str(longest)}
    done = subprocess.run(command, env=variables, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    assert any(longest.rglob("*.so")) or any((longest / ".clrt" / "binaries").iterdir())


def test_what_the_driver_leaves_behind_goes_when_it_is_old(tmp_path: Path) -> None:
    stay = {"tempfile_fulful", "tempfile_newnew", "other_oldold", "tempfile_mine.txt"}
    (tmp_path / ".clrt").mkdir()
    for name in (*stay, "tempfile_oldold", ".clrt/looking-oldoldol"):
        (tmp_path / name).write_bytes(b"x" if name == "tempfile_fulful" else b"")
        if name != "tempfile_newnew":
            os.utime(tmp_path / name, (1, 1))
    damage.remove_damaged(tmp_path)
    assert {file.name for file in tmp_path.iterdir()} == stay | {".clrt"}
    assert [file.name for file in (tmp_path / ".clrt").iterdir()] == ["looked"]


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="Windows has no numbers of users")
def test_a_folder_of_somebody_else_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Seen by another user, for only root can give files away."""
    owner = os.geteuid()
    assert kernelcache.problem(tmp_path) == ""
    monkeypatch.setattr(os, "geteuid", lambda: owner + 12345)
    assert f"belongs to user {owner}" in kernelcache.problem(tmp_path)


def test_such_a_folder_is_passed_over_with_a_warning(tmp_path: Path) -> None:
    tmp_path.chmod(0o777)
    code = "from clrt.device import kernelcache; print(kernelcache.prepare())"
    done = subprocess.run(
        [sys.executable, "-W", "always", "-c", code], env={**os.environ, "POCL_CACHE_DIR": str(tmp_path)},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert Path(done.stdout.strip()).name.startswith("clrt-kernels-") and str(tmp_path) not in done.stdout
    assert "is not yours alone" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_commands_that_read_do_not_wait_and_others_say_for_whom(tmp_path: Path) -> None:
    hold = (
        "import os, time; from clrt.device import kernelcache, turns; kernelcache.prepare()\n"
        "with turns.lock(): print(os.getpid(), flush=True); time.sleep(60)"
    )
    environment = {**os.environ, "POCL_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", hold]
    holder = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)
    try:
        assert holder.stdout
        number = int(holder.stdout.readline())
        start = time.perf_counter()
        run = {"env": environment, "capture_output": True, "text": True}
        done = subprocess.run([sys.executable, "-m", "clrt", "devices"], **run, check=True)
        assert time.perf_counter() - start < 30 and "waiting" not in done.stderr
        waits = "import clrt; from clrt.device import turns; clrt.devices()\nwith turns.lock(): pass"
        command = [sys.executable, "-c", waits]
        waiting = subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True)
        assert waiting.stderr
        assert f"waiting for process {number}, which compiles kernels" in waiting.stderr.readline()
    finally:
        holder.kill()
        holder.wait()
    assert waiting.wait(60) == 0  # the lock of a process that died is free
    waiting.stderr.close()


def test_programs_of_their_own_are_compiled_side_by_side(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    kernelcache.prepare()
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path))
    told: list[str] = []
    monkeypatch.setattr(turns, "watchers", [told.append])
    with turns.compiling("one"), turns.compiling("another", "kernel", 16) as known:
        assert not known
    assert not [text for text in told if text.startswith("waiting")]
    with turns.compiling("one") as known:
        assert known


def test_a_kernel_is_compiled_by_one_process_at_a_time_and_others_beside(tmp_path: Path) -> None:
    hold = (
        "import os, sys; from clrt.device import kernelcache, turns; kernelcache.prepare()\n"
        "with turns.compiling('one', 'kernel', 16): print(os.getpid(), flush=True); sys.stdin.read()"
    )
    meet = (
        "from clrt.device import kernelcache, turns; kernelcache.prepare()\n"
        "with turns.compiling('one', {}) as known: print(known)"
    )
    environment = {**os.environ, "POCL_CACHE_DIR": str(tmp_path)}
    run = {"env": environment, "stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    processes = [subprocess.Popen([sys.executable, "-c", hold], text=True, **run)]
    assert processes[0].stdout and processes[0].stdin
    number = int(processes[0].stdout.readline())
    for which in ("'other', 16", "'kernel', 16"):
        processes.append(subprocess.Popen([sys.executable, "-c", meet.format(which)], text=True, **run))
    assert processes[1].communicate() == ("False\n", "")
    assert processes[2].stderr
    assert f"waiting for process {number}, which compiles kernels" in processes[2].stderr.readline()
    processes[0].stdin.close()
    assert processes[2].communicate()[0] == "True\n"
    assert processes[0].wait() == 0
    processes[0].stdout.close()


def test_watchers_are_told_what_goes_on(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    kernelcache.prepare()
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path))
    told: list[str] = []
    monkeypatch.setattr(turns, "watchers", [told.append])
    with turns.compiling("a kernel"):
        assert told == ["compiling kernels"]
    assert told == ["compiling kernels", ""]
    with turns.compiling("a kernel") as known:
        assert known and len(told) == 2


def test_no_pickles_are_written_or_read(tmp_path: Path) -> None:
    """pyopencl would keep its own beside clrt's: whoever may write there could run code here."""
    code = "import clrt, sys; clrt.render(clrt.load(sys.argv[1])); print('rendered')"
    scene = tmp_path / "scene.json"
    clrt_scene = '{"camera": {"origin": [0, 0, 4], "target": [0, 0, 0], "width": 4, "height": 4}}'
    scene.write_text(clrt_scene)
    for before in ("", "import pyopencl; "):
        cache = tmp_path / f"cache{len(before)}"
        done = subprocess.run(
            [sys.executable, "-c", before + code, str(scene)], capture_output=True, text=True, check=True,
            env={**os.environ, "XDG_CACHE_HOME": str(cache)},
        )  # fmt: skip
        assert done.stdout == "rendered\n"
        others = [file for file in cache.rglob("*") if file.is_file() and "clrt" not in file.parts]
        assert not others, others
    done = subprocess.run(
        [sys.executable, "-c", code, str(scene)], capture_output=True, text=True, check=True,
        env={**os.environ, "XDG_CACHE_HOME": "/proc"},
    )  # fmt: skip
    assert done.stdout == "rendered\n" and "Traceback" not in done.stderr


def test_nothing_else_imports_pyopencl() -> None:
    root = Path(__file__).resolve().parents[2]
    for folder in ("clrt", "validation"):
        for file in (root / folder).rglob("*.py"):
            if file.name != "opencl.py":
                assert "import pyopencl as" not in file.read_text(), file


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
        assert not damage.whole(tmp_path / name)
        with pytest.raises(OSError, match=r"regular|symbolic"):
            cachefolder.contents(tmp_path / name)
    monkeypatch.setenv(cachefolder.VARIABLE, str(tmp_path))
    cachefolder.make(cachefolder.ours())
    make(cachefolder.ours("clrt.lock.holder"))
    make(cachefolder.ours("clrt.lock"))  # held by nobody, it would keep all from removing damage
    with turns.lock() as got:
        assert got and turns._holder(cachefolder.ours("clrt.lock.holder")) == 0
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
    assert damage.whole(file)
    os.truncate(file, 40 << 30)
    assert not damage.whole(file)
