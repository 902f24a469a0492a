"""Who compiles, who waits for whom, and what is told of it."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from clrt.device import cachelock, kernelcache


def test_commands_that_read_do_not_wait_and_others_say_for_whom(tmp_path: Path) -> None:
    hold = (
        "import os, time; from clrt.device import kernelcache, cachelock; kernelcache.prepare()\n"
        "with cachelock.lock(): print(os.getpid(), flush=True); time.sleep(60)"
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
        waits = "import clrt; from clrt.device import cachelock; clrt.devices()\nwith cachelock.lock(): pass"
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
    monkeypatch.setattr(cachelock, "watchers", [told.append])
    with cachelock.compiling("one"), cachelock.compiling("another", "kernel", 16) as known:
        assert not known
    assert not [text for text in told if text.startswith("waiting")]
    with cachelock.compiling("one") as known:
        assert known


def test_a_kernel_is_compiled_by_one_process_at_a_time_and_others_beside(tmp_path: Path) -> None:
    hold = (
        "import os, sys; from clrt.device import kernelcache, cachelock; kernelcache.prepare()\n"
        "with cachelock.compiling('one', 'kernel', 16): print(os.getpid(), flush=True); sys.stdin.read()"
    )
    meet = (
        "from clrt.device import kernelcache, cachelock; kernelcache.prepare()\n"
        "with cachelock.compiling('one', {}) as known: print(known)"
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
    monkeypatch.setattr(cachelock, "watchers", [told.append])
    with cachelock.compiling("a kernel"):
        assert told == ["compiling kernels"]
    assert told == ["compiling kernels", ""]
    with cachelock.compiling("a kernel") as known:
        assert known and len(told) == 2
