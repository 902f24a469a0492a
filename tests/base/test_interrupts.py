"""Ctrl-C, SIGTERM and SIGHUP at any moment: one line, the exit code of shells, and no file left."""

from __future__ import annotations

import random
import signal
import subprocess
import sys
import textwrap
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.cli.test_terminal import SCENE
from validation.reliability import beginnings

# the command `clrt scenes`, which does something else
PROGRAM = """
import sys
sys.path.insert(0, sys.argv[1])
sys.argv = ["clrt", "scenes"]
from clrt.cli import program, scenes, say
import task
scenes.run = task.run
program()
"""


@contextmanager
def started(folder: Path, task: str) -> Iterator[subprocess.Popen[str]]:
    """A process that runs `task` as a command, once it has said that it is ready."""
    (folder / "task.py").write_text(task)
    command = [sys.executable, "-B", "-c", PROGRAM, str(folder)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, cwd=folder, text=True, **pipes) as process:  # type: ignore[call-overload]
        try:
            assert process.stdout.readline() == "ready\n"
            yield process
        finally:
            process.kill()


@pytest.mark.slow
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_a_command_that_begins_can_be_interrupted(sent: signal.Signals) -> None:
    """A short form of the row `beginnings` of docs/reliability.md."""

    def one(number: int) -> tuple[str, str]:
        command = beginnings.COMMANDS[number % len(beginnings.COMMANDS)]
        return beginnings.interrupt(command, random.Random(number).uniform(0, 0.8), sent)

    with ThreadPoolExecutor(4) as threads:
        found = list(threads.map(one, range(40 if sent == signal.SIGINT else 12)))
    assert [wrong for _, wrong in found if wrong] == []
    assert Counter(how for how, _ in found)["interrupted"] >= len(found) / 2


WRITING = """
import time
from pathlib import Path
from clrt.base.atomic import replacing

def run(options):
    with replacing("a.ck") as temporary:
        temporary.write_text("half")
        print("ready", flush=True)
        time.sleep(60)
"""


@pytest.mark.parametrize(
    ("sent", "line"),
    [
        (signal.SIGINT, "clrt: interrupted; nothing was saved\n"),
        (signal.SIGTERM, "clrt: interrupted by SIGTERM; nothing was saved\n"),
        (signal.SIGHUP, "clrt: interrupted by SIGHUP; nothing was saved\n"),
    ],
)
def test_a_file_that_is_being_written_is_removed(tmp_path: Path, sent: signal.Signals, line: str) -> None:
    with started(tmp_path, WRITING) as process:
        process.send_signal(sent)
        assert process.communicate(timeout=30) == ("", line)
        assert process.returncode == 128 + sent
    assert [file.name for file in tmp_path.iterdir()] == ["task.py"]


def test_what_was_saved_is_told(tmp_path: Path) -> None:
    text = WRITING.replace('    with', '    with replacing("b.ck"):\n        pass\n    with')
    with started(tmp_path, text) as process:
        process.send_signal(signal.SIGINT)
        assert process.communicate(timeout=30) == ("", f"clrt: interrupted; saved: {tmp_path / 'b.ck'}\n")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["b.ck", "task.py"]


IMPORTING = """
def run(options):
    import heavy
    import time
    time.sleep(60)
"""
HEAVY = """
import time
print("ready", flush=True)
begin = time.monotonic()
try:
    while time.monotonic() - begin < 0.3:
        pass
except BaseException:
    print("broken off", flush=True)
    raise
print("whole", flush=True)
"""


def test_an_import_is_not_broken_off(tmp_path: Path) -> None:
    """A library's start in C++ would abort the process."""
    (tmp_path / "heavy.py").write_text(HEAVY)
    with started(tmp_path, IMPORTING) as process:
        process.send_signal(signal.SIGINT)
        assert process.communicate(timeout=30) == ("whole\n", "clrt: interrupted; nothing was saved\n")
        assert process.returncode == 130


ENDLESS = {
    "busy": "while True:\n    pass\n",
    "a pipe": "import os\nos.mkfifo('pipe')\nopen('pipe')\n",
    "asleep": "import time\ntime.sleep(60)\n",
    "deaf": "# no exception ends it\n"
    "while True:\n    try:\n        while True:\n            pass\n    except BaseException:\n        pass\n",
}


@pytest.mark.parametrize("what", ENDLESS)
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_an_import_that_does_not_end_is_ended(tmp_path: Path, what: str, sent: signal.Signals) -> None:
    """With what is being written removed, and one line."""
    (tmp_path / "heavy.py").write_text('print("ready", flush=True)\n' + ENDLESS[what])
    task = (
        "from clrt.base.atomic import replacing\n"
        "def run(options):\n    with replacing('a.ck') as temporary:\n        import heavy\n"
    )
    with started(tmp_path, task) as process:
        begin = time.monotonic()
        process.send_signal(sent)
        said = "interrupted" if sent == signal.SIGINT else "interrupted by SIGTERM"
        assert process.communicate(timeout=30) == ("", f"clrt: {said}; nothing was saved\n")
        assert process.returncode == 128 + sent and 1.5 < time.monotonic() - begin < 10
    assert {file.name for file in tmp_path.iterdir()} <= {"task.py", "heavy.py", "pipe"}


def test_who_ends_at_once_tells_what_was_saved_too(tmp_path: Path) -> None:
    """On one line, whatever the file's name holds."""
    task = (
        "from clrt.base.atomic import replacing\n"
        "def run(options):\n    with replacing('a\\x1b\\n.ck') as temporary:\n"
        "        temporary.write_bytes(b'')\n"
        "    print('ready', flush=True)\n" + textwrap.indent(ENDLESS["deaf"], "    ")
    )
    with started(tmp_path, task) as process:
        for _ in range(2):
            time.sleep(0.5)
            process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=30)[1]
    assert (process.returncode, said) == (130, f"clrt: interrupted; saved: {tmp_path / 'a??.ck'}\n")


TAKEN = """
import ctypes
import threading
import time

def stuck():  # in C, where no signal's end is seen
    libc = ctypes.CDLL(None)
    mutex = ctypes.create_string_buffer(256)
    libc.pthread_mutex_lock(mutex)
    libc.pthread_mutex_lock(mutex)

def mask(how, number):  # neither lets others run, nor looks for signals
    numbers = ctypes.create_string_buffer(128)
    libc = ctypes.PyDLL(None)
    libc.sigaddset(numbers, number)
    assert libc.pthread_sigmask(how, numbers, None) == 0

def run(options):
    threading.Thread(target=stuck, daemon=True).start()
    print("ready", flush=True)
    try:
        while True:
            pass
    except KeyboardInterrupt:
        pass
    mask(0, 14)
    end = time.monotonic() + 0.3
    while time.monotonic() < end:
        pass
    mask(1, 14)
    while True:
        pass
"""


@pytest.mark.skipif(sys.platform != "linux", reason="numbers of signals and of masks are Linux's")
def test_a_signal_that_another_thread_takes_is_followed_by_one(tmp_path: Path) -> None:
    """Python 3.11 forgets there to look for signals: two that come at once hung one command of a hundred."""
    with started(tmp_path, TAKEN) as process:
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        assert process.communicate(timeout=30) == ("", "clrt: interrupted; nothing was saved\n")
        assert process.returncode == 130


STUBBORN = """
import time
from clrt.base.atomic import replacing

def run(options):
    with replacing("a.ck") as temporary:
        try:
            print("ready", flush=True)
            time.sleep(60)
        finally:
            print("tidying", flush=True)
            time.sleep(60)
"""


def test_a_second_signal_ends_what_takes_long_to_end(tmp_path: Path) -> None:
    with started(tmp_path, STUBBORN) as process:
        process.send_signal(signal.SIGINT)
        assert process.stdout is not None and process.stdout.readline() == "tidying\n"
        process.send_signal(signal.SIGTERM)
        assert process.communicate(timeout=30) == ("", "clrt: interrupted; nothing was saved\n")
        assert process.returncode == 130
    assert [file.name for file in tmp_path.iterdir()] == ["task.py"]


DROPS = {
    "numpy": """
import numpy as np

class Size(int):
    def __repr__(self):  # numpy asks for it, and takes whatever it raises for a no
        wait()
        return "12"

def drop():
    np.dtype((np.void, Size(12)))
""",
    "a callback": """
import weakref

class Thing:
    pass

def drop():  # Python ignores what leaves a callback, and says so
    thing = Thing()
    kept = weakref.ref(thing, lambda gone: wait())
    del thing
""",
}
DROPPING = """
import time

def wait():
    print("ready", flush=True)
    time.sleep(60)

def run(options):
    drop()
    try:
        try:
            time.sleep(60)
        finally:
            time.sleep(1)  # what tidies up is left in peace
            print("tidied", flush=True)
    finally:
        try:
            raise OSError
        except OSError:
            time.sleep(0.5)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="there is no timer that could look again")
@pytest.mark.parametrize("where", DROPS)
def test_an_interrupt_that_is_dropped_is_raised_again(tmp_path: Path, where: str) -> None:
    with started(tmp_path, DROPS[where] + DROPPING) as process:
        start = time.monotonic()
        process.send_signal(signal.SIGINT)
        assert process.communicate(timeout=50) == ("tidied\n", "clrt: interrupted; nothing was saved\n")
        assert process.returncode == 130 and time.monotonic() - start < 20


def test_what_else_python_drops_is_told(tmp_path: Path) -> None:
    task = "class Thing:\n def __del__(self): raise OSError('lost')\n\ndef run(options): Thing(); return 0\n"
    with started(tmp_path, "print('ready', flush=True)\n" + task) as process:
        said = process.communicate(timeout=50)[1]
    assert process.returncode == 0 and "OSError: lost" in said


@pytest.mark.parametrize("begin", ["import clrt.cli; clrt.cli.main(['scenes'])", "import clrt"])
def test_a_program_that_imports_clrt_keeps_its_handlers(begin: str) -> None:
    code = (
        "import signal, sys; names = ('SIGINT', 'SIGTERM', 'SIGHUP', 'SIGALRM')\n"
        "before = [signal.getsignal(getattr(signal, name)) for name in names]\n"
        f"{begin}\nassert [signal.getsignal(getattr(signal, name)) for name in names] == before\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


def test_a_signal_that_is_ignored_stays_so(tmp_path: Path) -> None:
    """`nohup clrt render ...`, and jobs in the background."""
    scene = tmp_path / "ball.toml"
    scene.write_text(SCENE)
    code = (
        "import signal, sys, os; ignored = (signal.SIGINT, signal.SIGHUP)\n"
        "for number in ignored: signal.signal(number, signal.SIG_IGN)\n"
        "sys.argv[0] = 'clrt'; from clrt.cli import program\n"
        "for number in ignored: os.kill(os.getpid(), number)\n"
        "program()"
    )
    out = tmp_path / "a.toml"
    done = subprocess.run([sys.executable, "-c", code, "convert", scene, out], capture_output=True, text=True)
    assert done.returncode == 0 and out.exists() and done.stderr.count("\n") == 1  # the scene's own warning
