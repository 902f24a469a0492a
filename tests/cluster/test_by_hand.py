"""Scheduler and worker started as docs/cluster.md says: programs of their own, over TCP and TLS."""

from __future__ import annotations

import contextlib
import logging
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.cluster import connect
from clrt.cluster.connect import connected

psutil = pytest.importorskip("psutil", reason="needs the optional dependency clrt[cluster]")
DOCS = Path(__file__).resolve().parents[2] / "docs"


def commands(heading: str) -> list[str]:
    """The lines of a shell below a heading of docs/cluster.md."""
    part = (DOCS / "cluster.md").read_text("utf-8").split(f"## {heading}\n")[1].split("\n## ")[0]
    return [line[4:] for line in part.splitlines() if line.startswith("    ")]


BY_HAND = {
    "tcp": "Two machines by hand",
    "tls": "Whoever reaches a port of a scheduler or worker runs code there",
}


def answers(host: str, port: int) -> None:
    """Wait until somebody listens there."""
    deadline = time.monotonic() + 60
    while True:
        try:
            return socket.create_connection((host, port), timeout=5).close()
        except OSError:
            assert time.monotonic() < deadline
            time.sleep(0.1)


@contextlib.contextmanager
def by_hand(protocol: str, folder: Path) -> Iterator[tuple[str, dict[str, str], Any]]:
    """Scheduler and worker as the page starts them, on this machine: the address, what else a client needs in
    its environment, and the scheduler's process."""
    lines = commands(BY_HAND[protocol])
    first = next(k for k, line in enumerate(lines) if line.startswith("dask "))
    variables = {**os.environ, "PYTHONPATH": str(DOCS.parent), "PYTHONDONTWRITEBYTECODE": "1"}
    if first:  # certificates, and who shows them
        if not shutil.which("openssl"):
            # the page's own command makes the certificates; CI installs it, so there it is never left out
            pytest.skip("needs the command openssl: apt-get install openssl")
        script = "\n".join(["set -e", *lines[:first], "env -0"])
        done = subprocess.run(["sh", "-c", script], cwd=folder, env=variables, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        variables |= dict(one.split("=", 1) for one in done.stdout.split("\0") if one)
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = str(free.getsockname()[1])
    here = [line.replace("10.0.0.1", "127.0.0.1").replace("8786", port) for line in lines[first : first + 2]]
    address = f"{protocol}://127.0.0.1:{port}"
    assert here[0].startswith("dask scheduler ") and here[1].startswith(f"dask worker {address} ")
    started = []
    try:
        for line in here:
            words, null = [sys.executable, "-m", *line.split()], subprocess.DEVNULL
            started.append(subprocess.Popen(words, cwd=folder, env=variables, stdout=null, stderr=null))
            answers("127.0.0.1", int(port))
        yield address, variables, started[0]
    finally:
        for process in reversed(started):
            family = [psutil.Process(process.pid), *psutil.Process(process.pid).children(recursive=True)]
            for member in family:
                member.send_signal(signal.SIGCONT)
                member.terminate()
            for member in psutil.wait_procs(family, timeout=10)[1]:
                member.kill()
            process.wait()


@pytest.mark.parametrize("protocol", BY_HAND)
def test_a_scheduler_and_a_worker_started_by_hand(protocol: str, tmp_path: Path) -> None:
    """As the page says, each a program of its own; over TLS nobody without the certificate is let in."""
    words = [sys.executable, "-m", "clrt", "render", "bubble", "--width", "96", "--quiet", "-o"]
    with by_hand(protocol, tmp_path) as (address, variables, _):
        command = [*words, "there.png", "--cluster", address]
        done = subprocess.run(
            command, cwd=tmp_path, env=variables, capture_output=True, text=True, timeout=200
        )
        assert done.returncode == 0, done.stderr
        if protocol == "tls":
            for name in [name for name in variables if name.startswith("DASK_")]:
                del variables[name]
            done = subprocess.run(command, cwd=tmp_path, env=variables, capture_output=True, text=True)
            assert done.returncode == 2 and "no certificates" in done.stderr
            assert done.stderr.count("\n") == 1
    image = clrt.render(clrt.load("bubble"), width=96)
    image.save(tmp_path / "here.png")
    there, here = (clrt.read_image(tmp_path / f"{name}.png") for name in ("there", "here"))
    assert np.array_equal(there, here)


@pytest.mark.slow
def test_a_scheduler_that_hangs_is_given_up(tmp_path: Path) -> None:
    """Within the 45 s that the page says; from when it hangs until all is over."""
    said = "| the scheduler is lost or hangs on the way | an error within 45 s |"
    assert said in (DOCS / "cluster.md").read_text("utf-8")
    stopped: list[float] = []
    with by_hand("tcp", tmp_path) as (address, _, scheduler):

        def stop(done: int, total: int, rays: int) -> None:
            if not stopped:
                os.kill(scheduler.pid, signal.SIGSTOP)
                stopped.append(time.monotonic())

        with (
            pytest.raises(clrt.ClrtError, match=rf"^{address}: the scheduler does not answer"),
            connected(address, clrt.Settings()) as (executor, settings),
        ):
            clrt.render(clrt.load("bubble"), executor=executor, settings=settings, progress=stop, width=1600)
        assert time.monotonic() - stopped[0] < 45


@pytest.mark.parametrize(("error", "command", "quiet"), [
    (KeyboardInterrupt(), False, True), (clrt.ClrtError("lost"), True, True),
    (clrt.ClrtError("lost"), False, False),
])  # fmt: skip
def test_dask_says_nothing_after_the_one_line(
    error: BaseException, command: bool, quiet: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its threads say that they are lost as a command of clrt ends; a program has its levels again."""
    log = logging.getLogger("distributed")
    monkeypatch.setattr(log, "level", logging.WARNING)
    monkeypatch.setattr(connect.interrupts, "running", lambda: command)
    with pytest.raises(type(error)), connect._quiet():
        raise error
    assert (log.level == logging.CRITICAL) == quiet
