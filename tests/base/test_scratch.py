"""Files that nobody keeps: gone whatever ends the block, and one line where there is no place for them."""

from __future__ import annotations

import ast
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest

import clrt
from clrt.base import interrupts
from clrt.base import scratch as scratches
from clrt.base.atomic import write_text
from clrt.base.scratch import placed, scratch
from clrt.cli import main
from clrt.device import cachefolder, trial
from tests.base.test_interrupts import started


def test_nothing_is_left_whatever_ends_the_block() -> None:
    with pytest.raises(KeyboardInterrupt), scratch() as folder:
        (folder / "file").write_text("")
        raise KeyboardInterrupt
    assert not folder.exists() and not interrupts.folders
    with scratch() as folder:
        (folder / "file").write_text("")
        interrupts.sweep()  # a second signal: the process ends within the block
        assert not folder.exists()


def test_what_goes_with_the_block_is_not_told_as_saved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(interrupts, "saved", [])
    with scratch() as folder:
        write_text(folder / "a.txt", "")
        write_text(tmp_path / "b.txt", "")
    assert interrupts.saved == [tmp_path / "b.txt"]


def test_what_clrt_keeps_for_itself_is_not_told_as_saved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(interrupts, "saved", [])
    monkeypatch.setenv(cachefolder.VARIABLE, str(tmp_path))
    assert trial.kept_verdict("key", "device", lambda: "") == "" and [*tmp_path.rglob("*.json")]
    assert not interrupts.saved


def test_who_writes_into_a_folder_is_ended_before_it_goes() -> None:
    with scratch() as folder:
        place = f"pathlib.Path({str(folder)!r}, 'd', 'e')"
        code = f"import pathlib\nwhile True: {place}.mkdir(parents=True, exist_ok=True)"
        writer = subprocess.Popen([sys.executable, "-c", code])
        while not (folder / "d").exists():
            pass
        interrupts.helpers.add(writer.pid)
        interrupts.sweep()
        interrupts.helpers.discard(writer.pid)
        assert writer.wait(5) == -9 and not folder.exists()


def test_a_private_folder_of_kernels_goes_with_an_interrupted_command(tmp_path: Path) -> None:
    """Also where it is ended while kernels are compiled, by this process and by one beside it."""
    words = [sys.executable, "-m", "clrt", "render", "showcase", "--width", "8", "-o"]
    words += [str(tmp_path / "a.png")]
    variables = {**os.environ, "HOME": "/dev/null", "XDG_CACHE_HOME": "/dev/null/x", "TMPDIR": str(tmp_path)}
    variables.pop(cachefolder.VARIABLE, None)
    command = subprocess.Popen(words, env=variables, stderr=subprocess.PIPE)
    while not [*tmp_path.glob("clrt-kernels-*/*/*/*")]:
        assert command.poll() is None
        time.sleep(0.01)
    command.send_signal(signal.SIGINT)
    said = command.communicate()[1].decode().splitlines()
    assert (command.returncode, said[-1]) == (130, "clrt: interrupted; nothing was saved")
    assert not [*tmp_path.iterdir()]


MAKING = """
import os, tempfile, time
from pathlib import Path

os.environ.pop("POCL_CACHE_DIR", None)
os.mkdir("t")
tempfile.tempdir = os.path.abspath("t")
make = tempfile.mkdtemp

def slow(*given, **named):
    made = make(*given, **named)
    print("ready", flush=True)
    time.sleep(0.5)
    return made

def run(options):
    import numpy as np
    import clrt
    from clrt.base.scratch import scratch
    from clrt.device import cachefolder, kernelcache
    from clrt.exercises import folder
    from clrt.images import image

    image._viewer = lambda: ["true"]
    image.Image._png = lambda self, exposure: b""
    Path.write_bytes = lambda self, data: time.sleep(60)
    kernelcache.usual_folder = lambda: Path("/dev/null/x")
    folder.right_picture = lambda scene, device: None
    picture = clrt.Image(np.zeros((1, 1, 3), np.float32))
    tempfile.mkdtemp = slow
    WHAT
    time.sleep(60)
"""


@pytest.mark.parametrize(
    "what",
    ["scratch().__enter__()", "picture.show()", "kernelcache.prepare()", "folder.start(1, Path('t', 'e'))"],
)
def test_a_signal_while_a_folder_is_made_leaves_nothing(tmp_path: Path, what: str) -> None:
    """It waits until the folder is noted, and nothing ends after that without it."""
    with started(tmp_path, MAKING.replace("WHAT", what)) as process:
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=30)[1].splitlines()
        assert (process.returncode, said[-1]) == (130, "clrt: interrupted; nothing was saved")
    assert [*(tmp_path / "t").iterdir()] == []


def test_a_signal_waits_while_a_place_is_tried() -> None:
    """`tempfile` tries it with a file of its own."""
    assert placed(lambda: [*interrupts.held]) == [True]
    with pytest.raises(clrt.ClrtError, match="no place for temporary files"):
        placed(lambda: os.mkdir("/dev/null/x"))
    assert not interrupts.held


def test_a_folder_that_is_being_removed_goes_with_the_process(monkeypatch: pytest.MonkeyPatch) -> None:
    def signal_within(made: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(scratches, "_remove", signal_within)
    with pytest.raises(KeyboardInterrupt), scratch() as folder:
        (folder / "file").write_text("")
    assert interrupts.folders == {str(folder)}
    interrupts.sweep()
    assert not folder.exists()
    interrupts.folders.clear()


def test_a_folder_in_which_a_driver_goes_on_writing_is_removed(monkeypatch: pytest.MonkeyPatch) -> None:
    """What it makes between the look into a folder and its removal keeps that."""
    right, left = shutil.rmtree, [2]

    def late(folder: str, ignore_errors: bool) -> None:
        right(folder, ignore_errors)
        if left[0]:
            left[0] -= 1
            os.mkdir(folder)

    with scratch() as folder:
        monkeypatch.setattr(shutil, "rmtree", late)
        interrupts.sweep()
        monkeypatch.undo()
        assert not folder.exists()


def test_folders_of_any_depth_are_removed() -> None:
    """Whoever goes down level by level needs a frame and a descriptor for each."""
    here = os.open(".", os.O_RDONLY)
    with scratch() as folder:
        try:
            os.chdir(folder)
            for _ in range(1500):
                os.mkdir("d" * 100)
                os.chdir("d" * 100)
        finally:
            os.fchdir(here)
            os.close(here)
    assert not folder.exists()


def test_no_place_for_temporary_files_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "missing"))
    (tmp_path / "s.toml").write_text("")
    assert main(["render", str(tmp_path / "s.toml"), "-o", "-"]) == 2
    says = "there is no place for temporary files: No such file or directory; let the variable TMPDIR"
    assert says in capsys.readouterr().err
    with pytest.raises(clrt.ClrtError, match="no place for temporary files"):
        clrt.Image(np.zeros((1, 1, 3), np.float32))._repr_png_()


def test_all_that_make_temporary_files_say_where_there_is_no_place() -> None:
    """By `placed` and `scratch`; or in a folder that they name. Harnesses that nobody else runs may fail."""
    root = Path(clrt.__file__).parents[1]
    files = [*root.glob("clrt/**/*.py"), *root.glob("validation/**/*.py")]
    makers = {"mkdtemp", "mkstemp", "mktemp", "gettempdir", "TemporaryDirectory", "TemporaryFile",
              "NamedTemporaryFile", "SpooledTemporaryFile"}  # fmt: skip
    found, safe = [], 0
    for file in files:
        if "hostile" in file.parts or "reliability" in file.parts:
            continue
        nodes = [*ast.walk(ast.parse(file.read_text()))]
        calls = [node for node in nodes if isinstance(node, ast.Call)]
        cared: list[ast.AST] = [call for call in calls if ast.unparse(call.func) == "placed"]
        # who shares no code with clrt catches it alone
        tries = [node for node in nodes if isinstance(node, ast.Try) and len(node.body) == 1]
        cared += [one.body[0] for one in tries if any(_of_the_system(how) for how in one.handlers)]
        within = {id(inner) for node in cared for inner in ast.walk(node)}
        for call in calls:
            module, _, name = ast.unparse(call.func).rpartition(".")
            if name in makers and module in ("", "tempfile"):
                safe += id(call) in within
                if id(call) not in within and all(keyword.arg != "dir" for keyword in call.keywords):
                    found.append(f"{file.relative_to(root)}:{call.lineno}")
    assert not found and safe > 3


def _of_the_system(handler: ast.ExceptHandler) -> bool:
    return handler.type is not None and ast.unparse(handler.type) == "OSError"
