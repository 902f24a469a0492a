"""The process keeps its handlers of signals, whatever drivers and their compilers do."""

from __future__ import annotations

import ctypes
import faulthandler
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from clrt.base import handlers

pytestmark = pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="Windows has no sigaction")

LOOK = """
import ctypes, signal
NUMBERS = sorted(signal.valid_signals() - {signal.SIGKILL, signal.SIGSTOP, signal.SIGFPE})
def handler(number):
    action = ctypes.create_string_buffer(1024)
    assert ctypes.CDLL(None).sigaction(number, None, action) == 0
    return action.raw[:8]
def handled():
    return [handler(number) for number in NUMBERS]
"""


def said(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", LOOK + code], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.fixture
def handler() -> Iterator[int]:
    """SIGINT's handler as the system has it; what a test leaves there is put right."""
    before = handlers._action(signal.SIGINT)
    yield address()
    handlers._sigaction()(signal.SIGINT, before, None)


def address() -> int:
    return int.from_bytes(handlers._action(signal.SIGINT).raw[:8], sys.byteorder)


def test_what_a_library_puts_there_is_gone_after_the_block(handler: int) -> None:
    with handlers.kept():
        ctypes.CDLL(None).signal(int(signal.SIGINT), ctypes.c_void_p(1))
        assert address() == 1 != handler
    assert address() == handler


def test_a_handler_that_no_python_installed_is_kept_too(handler: int) -> None:
    ctypes.CDLL(None).signal(int(signal.SIGINT), ctypes.c_void_p(1))
    with pytest.raises(KeyError), handlers.kept():
        ctypes.CDLL(None).signal(int(signal.SIGINT), ctypes.c_void_p(0))
        raise KeyError
    assert address() == 1


def test_of_blocks_in_two_threads_the_first_one_knows(handler: int) -> None:
    """The second began when a library had taken the signal, and ends last."""
    inside, taken = threading.Event(), threading.Event()

    def first() -> None:
        with handlers.kept():
            ctypes.CDLL(None).signal(int(signal.SIGINT), ctypes.c_void_p(1))
            inside.set()
            taken.wait(60)

    thread = threading.Thread(target=first)
    thread.start()
    assert inside.wait(60)
    with handlers.kept():
        taken.set()
        thread.join()
        assert address() == handler
    assert address() == handler


@pytest.mark.parametrize("late", [False, True])
@pytest.mark.parametrize("wanted", [signal.SIG_DFL, signal.SIG_IGN, lambda number, frame: None])
def test_what_the_program_installs_meanwhile_stays(wanted: object, late: bool) -> None:
    """Also where the library takes the signal only then."""
    taken = ctypes.cast(ctypes.CDLL(None).getpid, ctypes.c_void_p)  # any function that is not Python's
    before = signal.signal(signal.SIGUSR1, signal.SIG_IGN if wanted == signal.SIG_DFL else signal.SIG_DFL)
    try:
        with handlers.kept():
            for step in (late, not late):
                if step:
                    signal.signal(signal.SIGUSR1, wanted)  # type: ignore[arg-type]
                else:
                    ctypes.CDLL(None).signal(int(signal.SIGUSR1), taken)
        action = handlers._function(handlers._action(signal.SIGUSR1))
        assert action == wanted if wanted in handlers._SET_HERE else handlers._is_pythons(action)
    finally:
        signal.signal(signal.SIGUSR1, before)


def test_a_fault_handler_that_the_program_registers_meanwhile_stays() -> None:
    """It is Python's, and none that `signal` knows of."""
    try:
        with handlers.kept():
            faulthandler.register(signal.SIGUSR1)
            action = handlers._action(signal.SIGUSR1)[:8]
        assert handlers._action(signal.SIGUSR1)[:8] == action
    finally:
        faulthandler.unregister(signal.SIGUSR1)


def test_every_handler_of_the_program_is_called_after_a_picture() -> None:
    code = """
import os, clrt
called = []
HARMLESS = [number for number in NUMBERS if number != signal.SIGCHLD]
for number in HARMLESS:
    signal.signal(number, lambda number, frame: called.append(number))
clrt.render("gallery", width=8)
for number in HARMLESS:
    os.kill(os.getpid(), number)
print(sorted(called) == HARMLESS)
"""
    assert said(code) == "True"


def test_a_picture_leaves_the_handlers_as_they_were() -> None:
    """PoCL's LLVM takes them when it starts: a compilation that Ctrl-C meets failed in a line of its own."""
    code = """
before = handled()
import clrt
assert handled() == before
image = clrt.render("gallery", width=8)
assert handled() == before
signal.signal(signal.SIGINT, lambda number, frame: None)
assert clrt.devices() and handled() == before  # all of Python's are one to the system
signal.signal(signal.SIGTERM, signal.SIG_IGN)
ignored = handled()
assert ignored != before
clrt.render("gallery", width=8, spp=4)
print(handled() == ignored)
"""
    assert said(code) == "True"


def test_a_file_that_is_too_large_is_an_error_and_no_words_of_the_driver(tmp_path: Path) -> None:
    """LLVM asks for a bug report where `ulimit -f` meets what it has not written."""
    code = f"""
import clrt, resource
clrt.render("gallery", width=8)
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
try:
    with open({str(tmp_path / "large")!r}, "wb", buffering=0) as file:
        while file.write(bytes(600)):
            pass
except OSError as error:
    print(error.strerror)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stdout, done.stderr) == (0, "File too large\n", "")


def test_without_that_the_driver_would_take_them() -> None:
    """What the test above watches for does happen, where the driver has LLVM's handlers."""
    code = """
import contextlib
from clrt.base import handlers
handlers.kept = contextlib.nullcontext
before = handled()
import clrt
clrt.render("gallery", width=8)
print(handled() != before or not any("PoCL" in device.label for device in clrt.devices()))
"""
    assert said(code) == "True"


def test_a_forked_child_waits_for_no_thread_that_it_has_not() -> None:
    code = """
import os, signal, threading
from clrt.base import handlers
inside, done = threading.Event(), threading.Event()
def other():
    with handlers.kept(), handlers._lock:
        inside.set()
        done.wait(60)
threading.Thread(target=other).start()
inside.wait(60)
child = os.fork()
if not child:
    signal.alarm(20)  # where it waits for the lock
    with handlers.kept():
        assert handlers._blocks == 1
    os._exit(handlers._blocks)
assert os.waitpid(child, 0)[1] == 0
done.set()
"""
    subprocess.run([sys.executable, "-W", "ignore", "-c", code], check=True)


def test_where_there_is_no_sigaction_nothing_is_done(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(handlers, "_sigaction", lambda: None)
    assert handlers._numbers.__wrapped__() == ()
    monkeypatch.setattr(handlers, "_numbers", handlers._numbers.__wrapped__)
    with handlers.kept():
        pass
