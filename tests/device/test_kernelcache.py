"""The folder of compiled kernels: who may write to it, its name, and what is never in it."""

from __future__ import annotations

import os
import subprocess
import sys
import types
from pathlib import Path

import pytest

from clrt.device import kernelcache


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


@pytest.mark.parametrize("folders", [1200, 300])
@pytest.mark.usefixtures("hasty")
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


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="Windows has no numbers of users")
def test_nothing_is_made_in_a_folder_of_somebody_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As root with the HOME of a user, who could not write to his ~/.cache any more."""
    status = Path.stat
    numbers = {"st_uid": 12345}

    def owned(path: Path, **more: bool) -> object:
        found = status(path, **more)
        fields = {name: getattr(found, name) for name in ("st_uid", "st_gid", "st_mode")}
        return types.SimpleNamespace(**fields | (numbers if path == tmp_path else {}))

    monkeypatch.setattr(Path, "stat", owned)
    assert "belongs to user 12345" in kernelcache.problem(tmp_path / ".cache" / "clrt" / "kernels")
    monkeypatch.undo()
    assert list(tmp_path.iterdir()) == []


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


@pytest.mark.usefixtures("hasty")
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
