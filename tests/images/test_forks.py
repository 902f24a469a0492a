"""Processes that are forked after pictures were read or written, and what OpenImageIO is told to do."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

HELPERS = """
import os, sys, threading, time
import numpy as np
import clrt

image = clrt.Image(np.random.default_rng(1).random((150, 150, 3), np.float32))

def ended(work):
    \"\"\"How a forked child ends, after it has done the work; 'stuck' where it does not.\"\"\"
    child = os.fork()
    if not child:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        work()
        sys.exit(0)
    until = time.monotonic() + 20
    while time.monotonic() < until:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.002)
    os.kill(child, 9)
    os.waitpid(child, 0)
    return "stuck"

def save(suffix, name):
    return lambda: image.save(name + suffix)

def read(suffix):
    return lambda: clrt.read_image("whole" + suffix)
"""
AFTER = """
for suffix in (".exr", ".png", ".tif"):
    ended(save(suffix, "whole"))  # in a child: this process has done nothing yet
parent, *children = [eval(text) for text in sys.argv[1:]]
parent()
for work in children:
    print(ended(work), end=" ")
"""
MEANWHILE = """
image.save("whole.exr")
left = threading.Event()
def loop():
    while not left.is_set():
        image.save("again.exr")
        clrt.read_image("again.exr")
thread = threading.Thread(target=loop)
thread.start()
print({ended(save(".exr", "child")) for _ in range(30)}, end="")
left.set()
thread.join()
"""

forks = pytest.mark.skipif(not hasattr(os, "fork"), reason="no processes are forked")


def said(folder: Path, code: str, *words: str, **variables: str) -> str:
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", HELPERS + code, *words],
        cwd=folder, env={**os.environ, **variables}, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


@forks
@pytest.mark.parametrize("parent", ["save('.exr', 'parent')", "read('.exr')", "save('.tif', 'parent')"])
def test_a_forked_child_saves_reads_and_ends(tmp_path: Path, parent: str) -> None:
    saved = ["save('.exr', 'child')", "save('.png', 'child')"]
    children = ["lambda: None", *saved, "read('.exr')", "read('.png')"]
    assert said(tmp_path, AFTER, parent, *children) == "0 0 0 0 0 "


@forks
@pytest.mark.slow
def test_children_are_forked_while_another_thread_saves(tmp_path: Path) -> None:
    assert said(tmp_path, MEANWHILE) == "{0}"


def test_variables_of_the_library_s_own_change_nothing(tmp_path: Path) -> None:
    code = "image.save('a.exr'); print((clrt.read_image('a.exr') == image.pixels).all(), end='')"
    options = "try_all_readers=0,threads=4,exr_threads=4"
    assert said(tmp_path, code, OPENIMAGEIO_OPTIONS=options, OPENIMAGEIO_THREADS="4") == "True"
