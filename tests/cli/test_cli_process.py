"""The command line as a process: what it imports, and how it ends when pipes close and Ctrl-C is pressed."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from clrt.cli import main
from clrt.device.vendors import install_command
from clrt.images.image import read_image
from tests.cli_samples import run, scene_in


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return scene_in(tmp_path)


def test_help_is_fast_and_imports_nothing_heavy():
    code = (
        "import sys, contextlib, clrt.cli\n"
        "with contextlib.suppress(SystemExit): clrt.cli.main(['--help'])\n"
        "print(sorted({'numpy', 'pyopencl', 'OpenImageIO', 'rich', 'msgspec'} & set(sys.modules)))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.endswith("[]\n") and "render" in done.stdout
    seconds = []
    for _ in range(3):
        before = os.times()
        assert run("--help").returncode == 0
        after = os.times()  # what others do on the machine counts for nothing
        seconds.append(after[2] + after[3] - before[2] - before[3])
    assert min(seconds) < 0.2


def test_rendering_imports_only_what_it_uses(scene: Path):
    code = (
        "import sys, clrt.cli\n"
        "clrt.cli.main(['render', sys.argv[1], '-o', sys.argv[1] + '.png', '--quiet'])\n"
        "print(sorted({'rich', 'trimesh', 'scipy', 'skimage', 'clrt_validation'} & set(sys.modules)))\n"
    )
    done = subprocess.run([sys.executable, "-c", code, scene], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_no_opencl_platform_is_one_line(scene: Path):
    nowhere = {"OCL_ICD_VENDORS": str(scene.with_name("nothing")), "CLRT_DRIVER": ""}
    done = run("render", scene, "-o", scene.with_name("a.png"), **nowhere)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("clrt: error: no OpenCL platform") and done.stderr.count("\n") == 1
    assert install_command() in done.stderr
    assert not scene.with_name("a.png").exists()


def test_a_closed_pipe_is_no_error():
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "wb") as broken:
        done = subprocess.run([sys.executable, "-m", "clrt", "scenes"], stdout=broken, stderr=subprocess.PIPE)
    assert (done.returncode, done.stderr) == (0, b"")


def test_ctrl_c_while_saving_says_what_was_saved(
    scene: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("clrt.cli.render.write_json", interrupted)
    out = scene.with_name("a.png")
    code = main(["render", str(scene), "-o", str(out), "--stats", str(scene.with_name("a.json"))])
    assert (code, capsys.readouterr()) == (130, ("", f"clrt: interrupted; saved: {out}\n"))
    assert read_image(out).shape == (16, 24, 3)


def test_ctrl_c_ends_a_long_render_and_leaves_nothing(scene: Path):
    """On a terminal, where the progress bar shows rays per second; Ctrl-C ends the render soon."""
    options = ["--width", "3000", "--height", "3000", "--spp", "64"]
    controller, terminal = pty.openpty()
    command = [sys.executable, "-m", "clrt", "render", scene, "-o", scene.with_name("a.png"), *options]
    wide = {**os.environ, "COLUMNS": "120", "TERM": "xterm"}
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=terminal, env=wide)
    try:
        os.close(terminal)
        shown = _read_until(controller, b"%", 60)  # appears after the first tile
        process.send_signal(signal.SIGINT)
        start = time.perf_counter()
        shown += _read_until(controller, b"saved", 30)
        output, _ = process.communicate(timeout=30)
        assert (process.returncode, output) == (130, b"")
        assert time.perf_counter() - start < 10
    finally:
        process.kill()
        process.communicate()
        os.close(controller)
    assert b" Mrays/s" in shown and b"clrt: interrupted; nothing was saved" in shown
    assert [file.name for file in scene.parent.iterdir()] == ["ball.toml"]


def _read_until(descriptor: int, wanted: bytes, seconds: float) -> bytes:
    shown, end = b"", time.perf_counter() + seconds
    while wanted not in shown and time.perf_counter() < end:
        try:
            shown += os.read(descriptor, 4096)
        except OSError:  # how a pseudo-terminal says that the other side has closed
            break
    return shown
