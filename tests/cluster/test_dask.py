"""dask's workers: killed, paused, unreachable; none of it changes a picture or holds up the client."""

from __future__ import annotations

import contextlib
import os
import random
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import clrt
from clrt.cli import main
from clrt.cluster import connect, pictures, pool
from clrt.cluster.connect import connected
from tests.cluster.endurance import (
    CASES,
    Fault,
    disturbed,
    kill,
    orders,
    pause,
    pids,
    settle,
    twice,
    validated,
    wrong,
)

psutil = pytest.importorskip("psutil", reason="needs the optional dependency clrt[cluster]")
DOCS = Path(__file__).resolve().parents[2] / "docs"
SIZE = {"width": 160, "height": 90}


@pytest.fixture(scope="module")
def scene() -> clrt.Scene:
    return clrt.load("bubble")


@pytest.fixture(scope="module")
def right(scene: clrt.Scene) -> clrt.Image:
    return clrt.render(scene, **SIZE)


@pytest.fixture(scope="module")
def workers() -> Iterator[Any]:
    with connected("local:2", clrt.Settings()) as (executor, settings):
        yield executor, settings


@pytest.fixture(autouse=True)
def small_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pictures, "_LEAST", 900)
    monkeypatch.setattr(pictures, "_PIECES", 8)


def calm(executor: Any, settings: clrt.Settings, scene: clrt.Scene) -> tuple[clrt.Image, Any]:
    return disturbed(executor, settings, scene, 10**6, kill, **SIZE)


def test_a_worker_that_ends_again_and_again_is_started_again(workers: Any) -> None:
    """So long after each end dask looks whether the worker is there, and drops it if it has just ended once
    more. (`python -m tests.cluster.endurance --workers 1` ends workers in earnest.)
    """
    dask = pytest.importorskip("dask")
    after = dask.utils.parse_timedelta(dask.config.get("distributed.deploy.lost-worker-timeout"))
    assert after > 3600 * 24, "longer than any run"


def test_nothing_is_done_twice(workers: Any, scene: clrt.Scene, right: clrt.Image) -> None:
    """Each worker says how many orders it has done: as many as its answers that have come."""
    image, before = calm(*workers, scene)
    assert image.hash == right.hash and image.stats["generations"] == right.stats["generations"]
    _, after = calm(*workers, scene)
    assert after.answers == sum(after.workers.values()) == 16
    assert len(after.orders) == 2 and after.sent == after.lost == 0
    for worker, done in after.orders.items():
        assert done - before.orders.get(worker, 0) == after.workers[worker]


def test_workers_listen_to_this_machine_alone(workers: Any) -> None:
    processes = [psutil.Process(pid) for pid in (os.getpid(), *pids(workers[0]))]
    sockets = [one for found in processes for one in found.net_connections() if one.status == "LISTEN"]
    assert {one.laddr.ip for one in sockets} == {"127.0.0.1"}
    assert workers[1].threads >= 1


@pytest.mark.parametrize("what", [kill, kill, pause])
def test_a_worker_may_end_or_hang(what: Any, workers: Any, scene: clrt.Scene, right: clrt.Image) -> None:
    """Whoever is left does no more orders than its answers that have come."""
    executor, settings = workers
    settle(executor, 2)
    _, before = calm(executor, settings, scene)
    image, after = disturbed(executor, settings, scene, random.randrange(1, 9), what, **SIZE)
    assert image.hash == right.hash and image.stats["generations"] == right.stats["generations"]
    assert after.answers == 16
    left = {worker for worker in after.workers if worker.pid in pids(executor)}
    assert left & after.orders.keys(), "one of the two was left alone"
    for worker in left & after.orders.keys():
        assert after.orders[worker] - before.orders.get(worker, 0) == after.workers[worker]


def test_a_worker_may_end_while_it_validates(workers: Any) -> None:
    """What is found is what is found in peace; that is compared with one process in `test_calls`."""
    executor, _ = workers
    settle(executor, 2)
    before, victim = orders(executor), pids(executor)[0]
    found, told = validated(executor, 1, kill, victim, CASES[:2])
    settle(executor, 2)
    assert twice(executor, before, victim, told.workers) == 0
    others = {worker: count for worker, count in told.workers.items() if worker.pid != victim}
    known = [worker for worker in others if worker.address in before]
    assert twice(executor, before, victim, {}) == sum(others[worker] for worker in known)
    (alone,) = [address for address, (process, _) in before.items() if process == victim]
    assert twice(executor, {alone: before[alone]}, victim, {}) is None
    assert {row[0] for row in found} == set(CASES[:2])
    assert found == validated(executor, 9, kill, 0, CASES[:2])[0]


def test_the_long_run_disturbs_a_worker_that_has_work(workers: Any, scene: clrt.Scene) -> None:
    """Or nobody, if there is none any more."""
    executor, settings = workers
    settle(executor, 2)
    before = orders(executor)
    late = Fault(executor, before, "kill", 60.0)
    with late.coming():
        calm(executor, settings, scene)
    assert late.victim == late.pieces == 0
    assert {*pids(executor)} == {pid for pid, _ in before.values()}
    before = orders(executor)
    begin = Fault(executor, before, "kill", 0.0)
    with begin.coming():
        _, told = calm(executor, settings, scene)
    assert begin.pieces > 0 and begin.victim in {pid for pid, _ in before.values()}
    settle(executor, 2)
    assert begin.victim not in pids(executor)
    row = {"same": True, "twice": twice(executor, before, begin.victim, told.workers)}
    bad = [{"same": False, "twice": 0}, {"same": True, "twice": 1}]
    assert wrong([row, {"same": True, "twice": None}, *bad]) == bad


def test_the_only_worker_may_end_while_it_is_sent_arrays(
    mesh: clrt.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """There is none for a moment, and then one of another address."""
    submit, check, killed = pool.DaskPool.submit, pool.DaskPool.check, list[float]()

    def submitted(self: Any, order: Any, to: Any = None, **more: Any) -> Any:
        if to is not None and not killed:
            kill(to.pid)
            while self.client.run_on_scheduler(lambda dask_scheduler: to.address in dask_scheduler.workers):
                time.sleep(0.01)
            killed.append(time.monotonic())
        return submit(self, order, to, **more)

    def checked(self: Any) -> None:
        check(self)
        if killed and time.monotonic() - killed[0] > 60:
            raise TimeoutError("nothing comes any more")

    monkeypatch.setattr(pool.DaskPool, "submit", submitted)
    monkeypatch.setattr(pool.DaskPool, "check", checked)
    with connected("local:1", clrt.Settings()) as (executor, settings):
        image = clrt.render(mesh, executor=executor, settings=settings, **SIZE)
    assert killed and image.hash == clrt.render(mesh, **SIZE).hash


def test_workers_are_spawned(workers: Any) -> None:
    """OpenCL's threads do not survive a fork."""
    for pid in pids(workers[0]):
        assert "from multiprocessing.spawn import spawn_main" in " ".join(psutil.Process(pid).cmdline())


def test_the_page_s_code_runs(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    (block,) = re.findall(r"```python\n(.*?)```", (DOCS / "cluster.md").read_text("utf-8"), re.DOTALL)
    exec(block, {"__name__": "__main__"})
    assert capsys.readouterr().out.count("True") == 1


def test_what_is_there_for_workers_is_gone_with_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A program that the user starts later would have the workers' allocator: 25 MB more, in one case."""
    for name in connect.FOR_WORKERS:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with connected("local:1", clrt.Settings()):
        assert "MALLOC_TOP_PAD_" in os.environ
        assert [*tmp_path.rglob("dask-scratch-space")], "below a folder that goes with them"
    assert [*tmp_path.iterdir()] == []
    left = {name: os.environ[name] for name in connect.FOR_WORKERS if name in os.environ}
    assert left == {"OMP_NUM_THREADS": "7"}


def test_a_series_on_workers_is_that_of_one_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """And goes on where it was broken off."""
    monkeypatch.chdir(tmp_path)
    rows = {}
    for name, more in {"one": [], "many": ["--cluster", "local:1"]}.items():
        run = ["sweep", "bubble", "--set", "camera.fov=30,40", "--set", "ambient=0,0.2", "--width", "24",
               "-o", f"{name}{{index}}.png", "--manifest", f"{name}.csv", "--quiet"]  # fmt: skip
        assert main(run + more) == 0
        lines = Path(f"{name}.csv").read_text().replace(name, "").splitlines()
        rows[name] = [[cell for i, cell in enumerate(line.split(",")) if i != 5] for line in lines]
        Path(f"{name}2.png").unlink()
    assert rows["one"] == rows["many"] and len(rows["one"]) == 5
    stamp = Path("many1.png").stat().st_mtime_ns
    assert main(run + more) == 0
    assert Path("many2.png").exists() and Path("many1.png").stat().st_mtime_ns == stamp


def test_ctrl_c_ends_all_workers(tmp_path: Path) -> None:
    """As a terminal sends it: to every process. What is finished is kept, and gone on from."""
    command = [sys.executable, "-m", "clrt", "render", "bubble", "-o", "b.png", "--spp", "16"]
    command += ["--checkpoint", "c", "--cluster", "local:2", "--width", "1600"]
    root = str(Path(__file__).resolve().parents[2])
    child = subprocess.Popen(
        command, cwd=tmp_path, stderr=subprocess.PIPE, text=True, start_new_session=True,
        env={**os.environ, "PYTHONPATH": root},
    )  # fmt: skip
    deadline = time.monotonic() + 600  # where workers have proven nothing so far, that takes two minutes
    while not (tmp_path / "c").exists() and time.monotonic() < deadline and child.poll() is None:
        time.sleep(0.2)
    family = psutil.Process(child.pid).children(recursive=True)
    assert len(family) >= 2
    os.killpg(child.pid, signal.SIGINT)
    said = child.communicate(timeout=30)[1]
    assert child.returncode == 130
    assert said == "clrt: interrupted; c holds what is finished: the same command goes on from there\n"
    assert psutil.wait_procs(family, timeout=10)[1] == []


@pytest.mark.parametrize(
    ("sent", "wait"),
    [(signal.SIGINT, 0.0), (signal.SIGINT, 0.5), (signal.SIGHUP, 0.0), (signal.SIGTERM, 0.2)],
)
def test_signals_while_workers_start_are_one_line(tmp_path: Path, sent: signal.Signals, wait: float) -> None:
    """As a terminal sends it. Workers begin with seconds of imports, and queues leave semaphores behind."""
    command = [sys.executable, "-m", "clrt", "render", "bubble", "-o", "b.png", "--cluster", "local:2"]
    variables = {**os.environ, "PYTHONPATH": str(DOCS.parent), "TMPDIR": str(tmp_path)}
    pipes: dict[str, Any] = {"stderr": subprocess.PIPE, "text": True}
    child = subprocess.Popen(command, cwd=tmp_path, start_new_session=True, env=variables, **pipes)
    while not (family := _spawned(child.pid)):
        assert child.poll() is None
        time.sleep(0.005)
    time.sleep(wait)
    family = psutil.Process(child.pid).children(recursive=True)
    if sent == signal.SIGTERM:  # as `kill` sends it
        child.send_signal(sent)
    else:
        os.killpg(child.pid, sent)
    said = child.communicate(timeout=30)[1]
    how = "" if sent == signal.SIGINT else f" by {sent.name}"
    assert (child.returncode, said) == (128 + sent, f"clrt: interrupted{how}; nothing was saved\n")
    assert psutil.wait_procs(family, timeout=10)[1] == []
    assert [*tmp_path.iterdir()] == []


def _spawned(pid: int) -> list[Any]:
    found = []
    for one in psutil.Process(pid).children():
        with contextlib.suppress(psutil.Error):
            found += [one] if "--multiprocessing-fork" in one.cmdline() else []
    return found


WRONG = {
    "local:0": "--cluster: 0 workers are not allowed; from 1 to 1024 are",
    "local:100000": "--cluster: 100000 workers are not allowed; from 1 to 1024 are",
    "local:two": "--cluster: 'local:two' is not allowed; give local:N .* or a scheduler: tcp://HOST:PORT",
    "example.org:8786": "is not allowed; give local:N",
    "tcp://127.0.0.1:1": "tcp://127.0.0.1:1: no scheduler answers there",
    "tls://127.0.0.1:1": "no scheduler answers there .*no certificates",
}


@pytest.mark.parametrize("address", WRONG)
def test_addresses_where_nobody_is(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connect, "_PATIENCE", 0.5)
    with pytest.raises(clrt.ClrtError, match=WRONG[address]), connected(address, clrt.Settings()):
        pass


def test_a_port_that_takes_all_and_never_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connect, "_PATIENCE", 0.5)
    start = time.monotonic()
    with socket.create_server(("127.0.0.1", 0)) as hole:
        address = f"tcp://127.0.0.1:{hole.getsockname()[1]}"
        text = f"{address}: no scheduler answers there"
        with pytest.raises(clrt.ClrtError, match=text), connected(address, clrt.Settings()):
            pass
    assert time.monotonic() - start < 20


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere a full queue refuses")
def test_an_address_whose_packets_are_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing answers a connection, not even that it is refused: the system drops what a full queue gets."""
    monkeypatch.setattr(connect, "_PATIENCE", 0.5)
    start = time.monotonic()
    with contextlib.ExitStack() as stack:
        hole = stack.enter_context(socket.create_server(("127.0.0.1", 0), backlog=0))
        for _ in range(4):
            filling = stack.enter_context(socket.socket())
            filling.setblocking(False)
            filling.connect_ex(hole.getsockname())
        probe = stack.enter_context(socket.socket())
        probe.settimeout(0.3)
        with pytest.raises(TimeoutError):
            probe.connect(hole.getsockname())
        address = f"tcp://127.0.0.1:{hole.getsockname()[1]}"
        text = f"{address}: no scheduler answers there"
        with pytest.raises(clrt.ClrtError, match=text), connected(address, clrt.Settings()):
            pass
    assert time.monotonic() - start < 20


def test_dask_is_not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    text = "--cluster needs dask.distributed: .*install"
    with pytest.raises(clrt.ClrtError, match=text), connected("local:1", clrt.Settings()):
        pass


def test_a_scheduler_without_workers(scene: clrt.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    import distributed

    monkeypatch.setattr(pool, "_WORKERS", 1.0)
    with (
        distributed.LocalCluster(n_workers=0, host="127.0.0.1", dashboard_address=None) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
        pytest.raises(clrt.ClrtError, match=r"^tcp://.*: no worker has come in 1 s; start some: dask worker"),
    ):
        clrt.render(scene, executor=client, **SIZE)  # a Client does, too


def test_a_scheduler_that_is_lost(workers: Any, scene: clrt.Scene) -> None:
    """The last test: the cluster is gone after it."""
    executor, settings = workers

    def leave(done: int, total: int, rays: int) -> None:
        if not gone:
            gone.append(threading.Thread(target=executor._client.cluster.close))
            gone[0].start()

    gone: list[threading.Thread] = []
    with pytest.raises(clrt.ClrtError, match=r"the scheduler does not answer|it has given up"):
        clrt.render(scene, executor=executor, settings=settings, progress=leave, width=1000)
    gone[0].join()
