"""The program may end while other threads are in calls: it ends well, and soon."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

BEGIN = """
import clrt, threading, time, numpy as np
scene = clrt.load_dict({
    "camera": {"origin": [0, 1, 4], "target": [0, 0, 0], "width": 32, "height": 24},
    "lights": [{"type": "point", "position": [3, 5, 4]}],
    "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {"diffuse": 0.7}}]})
tracer = clrt.Tracer(scene)
image = tracer.render(width=500)
rays = np.zeros((200_000, 3)) + [0, 0, 5], np.zeros((200_000, 3)) + [0, 0, -1]
begun = threading.Event()

def spin():
    while True:
        begun.set()
        CALL

threading.Thread(target=spin, daemon=True).start()
begun.wait()
time.sleep(PAUSE)
END
"""
CALLS = {
    "render": "tracer.render(width=300)",
    "one long render": "tracer.render(width=8000, height=6000, spp=64)",
    "rays": "tracer.intersect(*rays)",
    "save": "image.save('a.png')",
    "whatever it raises": """
        try:
            tracer.render(width=300)
        except BaseException:
            pass""",
}  # fmt: skip


@pytest.mark.parametrize("end", ["", "raise SystemExit(0)"])
@pytest.mark.parametrize("name", CALLS)
def test_daemon_threads_end_first(name: str, end: str, tmp_path: Path) -> None:
    code = BEGIN.replace("CALL", CALLS[name]).replace("PAUSE", "0.2").replace("END", end)
    start = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=120
    )
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    assert time.perf_counter() - start < 60
    assert {file.name for file in tmp_path.iterdir()} <= {"a.png"}, "nothing half written is left"


SCENE = BEGIN[: BEGIN.index("image =")].replace("import clrt,", "import atexit, clrt, os, queue,")


def ended(code: str) -> tuple[int, str, str]:
    """The exit code of a program, and what it says."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    return done.returncode, done.stdout.strip(), done.stderr


WAITS = {
    "for a queue that a thread empties": (
        """
work, done = queue.Queue(), []
atexit.register(lambda: print(len(done)))
atexit.register(work.join)
""",
        """
def write():
    while True:
        done.append(tracer.render(width=work.get()))
        work.task_done()
threading.Thread(target=write, daemon=True).start()
for k in range(5):
    work.put(40 + k)
""",
        "5",
    ),
    "for a thread that renders": (
        """
def late():
    thread = threading.Thread(target=lambda: print(tracer.render(width=20).pixels.shape[1]))
    try:
        thread.start()
        thread.join()
    except RuntimeError:  # Python 3.12 and later start none then
        print(20)
atexit.register(late)
""",
        "tracer.render(width=8)",
        "20",
    ),
}  # fmt: skip


@pytest.mark.parametrize("first", ["the handler", "clrt"])
@pytest.mark.parametrize("name", WAITS)
def test_a_handler_of_atexit_may_wait_for_a_thread_that_renders(name: str, first: str) -> None:
    """Whichever was first: such handlers are called the last one first."""
    handler, use, said = WAITS[name]
    begin = (handler, SCENE) if first == "the handler" else (SCENE, handler)
    assert ended("\n".join(["import atexit, queue, threading", *begin, use])) == (0, said, "")


@pytest.mark.parametrize("second", ["", "threading.Thread(target=tracer.render, daemon=True).start()"])
def test_the_end_waits_for_no_function_of_the_callers(second: str) -> None:
    """Nor for who waits for the Tracer that it keeps."""
    code = f"""
begun = threading.Event()
def progress(*told):
    begun.set()
    threading.Event().wait()
threading.Thread(target=lambda: tracer.render(progress=progress), daemon=True).start()
begun.wait()
{second}
time.sleep(0.1)
"""
    assert ended(SCENE + code) == (0, "", "")


FORKS = """
import signal
begun = threading.Event()
def spin():
    while True:
        begun.set()
        tracer.render(width=300)
def child(end):
    number = os.fork()
    if not number:
        signal.alarm(20)
        end()
    return os.waitstatus_to_exitcode(os.waitpid(number, 0)[1])
def leave(*told):
    raise SystemExit(7)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="Windows has no forks")
def test_a_fork_within_progress_ends_as_it_says() -> None:
    code = """
told = lambda *numbers: print(child(leave), flush=True)
tracer.render(progress=told)
"""
    assert ended(SCENE + FORKS + code)[:2] == (0, "7")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="Windows has no forks")
def test_a_forked_process_may_close_the_tracer_that_another_thread_was_using() -> None:
    code = """
threading.Thread(target=spin, daemon=True).start()
begun.wait()
def end():
    with tracer:
        pass
    tracer.close()
    raise SystemExit(3)
print(child(end))
"""
    assert ended(SCENE + FORKS + code)[:2] == (0, "3")
