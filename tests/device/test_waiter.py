"""Ctrl-C may come between any two steps of a wait: the next one works all the same."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from clrt.device import waiter

EVERYWHERE = """
import sys
from clrt.device import waiter

def interrupted(line):
    def step(frame, event, argument):
        nonlocal line
        line -= event == "line"
        if line == 0:
            raise KeyboardInterrupt
        return step
    return lambda frame, *_: step if frame.f_code is waiter.done.__code__ else None

count = 0
for line in range(1, 30):
    sys.settrace(interrupted(line))
    try:
        waiter.done(lambda: None)
    except KeyboardInterrupt:
        count += 1
    finally:
        sys.settrace(None)
    assert waiter.done(lambda: line) == line
print(count)
"""


def test_an_interrupt_anywhere_leaves_the_next_wait_whole() -> None:
    """Within ThreadPoolExecutor.submit it left a lock taken: every later call hung, and the exit, too."""
    done = subprocess.run([sys.executable, "-c", EVERYWHERE], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) >= 8


def test_answers_and_exceptions_come_back() -> None:
    assert waiter.done(lambda: 3) == 3

    def fails() -> None:
        raise KeyError("a")

    with pytest.raises(KeyError, match="a"):
        waiter.done(fails)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="Windows has no forks")
def test_a_fork_ends() -> None:
    code = "import os\nfrom clrt.device import waiter\nwaiter.done(int)\n"
    code += "if os.fork() == 0: raise SystemExit(3)\nprint(os.waitstatus_to_exitcode(os.wait()[1]))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.stdout == "3\n", done.stderr
