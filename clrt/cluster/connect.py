"""`--cluster`: dask.distributed's workers, on this machine (`local:N`) or behind a scheduler (`tcp://...`)."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import re
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, Final

from clrt.base import hush, interrupts
from clrt.base.errors import ClrtError, MissingPackage, exhausted, show
from clrt.base.install import install_extra
from clrt.base.scratch import scratch
from clrt.device.settings import Settings

_FORMS: Final = "local:N (N workers here), or a scheduler: tcp://HOST:PORT, tls://HOST:PORT"
_MOST: Final = 1024  # workers on one machine
_PATIENCE: Final = 10.0  # seconds for a scheduler to answer at first: one across the world takes one
# The environment of local workers. glibc keeps what an order gave back for the next; dask's own setting has
# it touched anew each time.
FOR_WORKERS: Final = {
    "MALLOC_TRIM_THRESHOLD_": 1 << 27, "MALLOC_MMAP_THRESHOLD_": 1 << 25, "MALLOC_TOP_PAD_": 1 << 25,
    "OMP_NUM_THREADS": 1, "MKL_NUM_THREADS": 1, "OPENBLAS_NUM_THREADS": 1,
}  # fmt: skip
_CONFIG: Final[dict[str, Any]] = {
    "distributed.nanny.pre-spawn-environ": FOR_WORKERS,
    # workers send a sign of life each half second, from a thread of their own; one that is paused or hangs
    # is given up after this time, and what it had is done by another
    "distributed.scheduler.worker-ttl": "10 s",
    # whose death takes an order with it is a matter of chance; the client counts itself (`pool.LOSSES`)
    "distributed.scheduler.allowed-failures": 3,
    # so long after each end of a worker dask looks whether it is there again, and if it has just ended once
    # more never starts it again
    "distributed.deploy.lost-worker-timeout": "1000 days",
    "distributed.worker.multiprocessing-method": "spawn",  # OpenCL's threads do not survive a fork
    # each process watches itself: all that together took 9 % of a core from two idle workers
    "distributed.worker.profile.enabled": False,  # looks at each worker a hundred times a second
    "distributed.admin.tick.interval": "500 ms",  # not fifty times: only a log asks for it
    "distributed.admin.system-monitor.interval": "5 s",
    "distributed.admin.system-monitor.disk": False,
    "distributed.admin.system-monitor.gil.enabled": False,
    "distributed.scheduler.http.routes": [],  # nor do they show anything
    "distributed.worker.http.routes": [],
}  # fmt: skip


@contextmanager
def connected(address: str, settings: Settings) -> Iterator[tuple[Any, Settings]]:
    """An executor, and the settings for its workers; local ones are ended at the end, whatever the reason.

    address: as --cluster takes it. Workers of this machine share its cores, unless `settings.threads` says
    how many each has. ClrtError where there is no such scheduler, or dask.distributed is not installed.
    """
    local = re.fullmatch(r"local:([0-9]{1,18})", address)
    if not local and not re.fullmatch(r"(tcp|tls)://[^\s/]+:[0-9]{1,5}", address):
        raise ClrtError(f"--cluster: {show(address)} is not allowed; give {_FORMS}")
    workers = int(local[1]) if local else 1
    if not 1 <= workers <= _MOST:
        raise ClrtError(f"--cluster: {workers} workers are not allowed; from 1 to {_MOST} are")
    distributed = _distributed()
    with _quiet():
        if not local:
            with _client(distributed, address, address) as client:
                yield client.get_executor(), settings
            return
        shared = replace(settings, threads=settings.threads or max(1, len(_cores()) // workers))
        with _local(distributed, workers) as cluster, _client(distributed, cluster, address) as client:
            yield client.get_executor(), shared


def _distributed() -> Any:
    try:
        import distributed
    except ImportError as error:
        spent = exhausted(error)
        missing = f"--cluster needs dask.distributed: {install_extra('cluster')}"
        raise (ClrtError(spent) if spent else MissingPackage(missing)) from None
    return distributed


@contextmanager
def _client(distributed: Any, place: Any, name: str) -> Iterator[Any]:
    try:
        if isinstance(place, str):
            asyncio.run(asyncio.wait_for(_asked(distributed, place), _PATIENCE + 1))
        # answers come by the scheduler's connection, since workers may stand behind a wall; not here
        direct = not isinstance(place, str)
        client = distributed.Client(place, timeout=_PATIENCE, set_as_default=False, direct_to_workers=direct)
    except Exception as error:  # of distributed, tornado, asyncio, ssl, socket
        said = f"{type(error).__name__}: {error}" if str(error) else f"nothing in {_PATIENCE:.0f} s"
        raise ClrtError(
            f"{name}: no scheduler answers there ({said}); `dask scheduler` starts one, see docs/cluster.md"
        ) from None
    try:
        yield client
    finally:
        with contextlib.suppress(Exception):  # it is being left
            client.close(timeout=2)


async def _asked(distributed: Any, address: str) -> None:
    """Ask a scheduler who it is: a Client waits for ever where a port takes what comes and never answers."""
    security = distributed.Security().get_connection_args("client")
    if address.startswith("tls") and security.get("ssl_context") is None:
        raise ValueError("no certificates: see distributed.comm.tls in dask's configuration")
    async with distributed.rpc(address, timeout=_PATIENCE, connection_args=security) as scheduler:
        await scheduler.identity()


@contextmanager
def _local(distributed: Any, workers: int) -> Iterator[Any]:
    import dask

    # A scheduler runs what it is sent: so it listens to this machine alone. clrt's own limits bound memory;
    # dask's would pause workers at a share of it.
    # Scheduler and workers have folders below one that dask would leave behind.
    with (
        scratch() as folder,
        dask.config.set({**_CONFIG, "temporary-directory": str(folder)}),
        environment_kept(FOR_WORKERS),
    ):
        try:
            cluster = distributed.LocalCluster(
                n_workers=workers, threads_per_worker=1, processes=True, host="127.0.0.1", memory_limit=0,
                dashboard_address=None, worker_dashboard_address=None, silence_logs=logging.CRITICAL,
                preload_nanny=["clrt.cluster.deaf"], preload=["clrt.cluster.preload"],
                scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},
            )  # fmt: skip
        except KeyboardInterrupt:
            _forget_workers()
            raise
        except Exception as error:
            spent = exhausted(error) or f"{type(error).__name__}: {error}"
            raise ClrtError(f"local:{workers}: the workers cannot be started: {spent}") from None
        try:
            yield cluster
        finally:
            with contextlib.suppress(Exception):
                cluster.close(timeout=5)


def _forget_workers() -> None:
    """End those that are being started: one that is not told what for prints where it read that."""
    import psutil  # distributed has brought it

    hush.for_good()  # for whatever dask's threads start now
    for child in psutil.Process().children():
        with contextlib.suppress(psutil.Error):
            if any(word.endswith("multiprocessing-fork") for word in child.cmdline()):
                child.kill()  # not what removes its semaphores


@contextmanager
def environment_kept(names: Iterable[str]) -> Iterator[None]:
    """dask sets these in this process and leaves them: programs that it starts later are not to have them."""
    before = {name: os.environ[name] for name in names if name in os.environ}
    try:
        yield
    finally:
        for name in names:
            os.environ.pop(name, None)
        os.environ.update(before)


@contextmanager
def _quiet() -> Iterator[None]:
    """What dask and its loop say of workers that end is no fault: the client says what is."""
    levels = {log: log.level for log in map(logging.getLogger, ("distributed", "asyncio"))}
    for log in levels:
        log.setLevel(logging.CRITICAL)
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", module=r"distributed|tornado|dask")
            yield
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt) or interrupts.running():
            levels.clear()  # their threads go on to say it until the process, clrt's own, ends
        raise
    finally:
        for log, level in levels.items():
            log.setLevel(level)


def _cores() -> set[int]:
    """The cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return os.sched_getaffinity(0)
    return set(range(os.cpu_count() or 1))
