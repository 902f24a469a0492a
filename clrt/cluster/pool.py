"""Executors as the farm sees them: how many work there, how an order is handed in, whether they live."""

from __future__ import annotations

import os
import time
import warnings
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from typing import Any, Final

from clrt.base import ending
from clrt.base.errors import ClrtError, LimitError, exhausted, fault, one_line, show
from clrt.cluster.orders import Worker
from clrt.cluster.worker import work
from clrt.version import __version__

_PING: Final = 10.0  # seconds of silence after which a scheduler is asked whether it is there
_ANSWER: Final = 30.0  # seconds that it may take to say so: one that is busy with 1,000 workers takes one
LOSSES: Final = 5  # times that something may be lost: it is likely then that it is what ends the workers
_LOST: Final = ("FutureCancelledError", "CommClosedError")  # what dask says where its scheduler is gone
_WORKERS: Final = 60.0  # seconds without any worker: one that is started anew takes 5


class Pool:
    """Any `concurrent.futures.Executor`."""

    def __init__(self, executor: Executor) -> None:
        self.executor: Any = executor  # dask's has more than the interface

    @property
    def workers(self) -> int:
        """How many orders are done at a time, as far as that is known."""
        return int(getattr(self.executor, "_max_workers", 0) or os.cpu_count() or 1)

    def submit(self, order: Any, to: Worker | None = None, do: Callable[[Any], Any] = work) -> Future[Any]:
        """Hand in an order, if possible to that worker. do: what the worker calls with it."""
        try:
            future: Future[Any] = ending.call_back(self.executor.submit, do, order)
            return future
        except RuntimeError as error:  # it was shut down, or is broken
            if exhausted(error):
                raise LimitError(exhausted(error)) from error
            raise ClrtError(f"executor: {error or type(error).__name__}; give one that is running") from error

    def check(self) -> None:
        """ClrtError where nothing will come any more. Asked each second in which nothing comes."""

    def heard(self) -> None:
        """An answer has come."""

    def outcome(self, future: Future[Any]) -> Any:
        """What a future holds; None where its worker has ended."""
        try:
            return future.result()
        except CancelledError:
            raise self._given_up() from None
        except BrokenExecutor as error:
            raise ClrtError(
                f"executor: its processes have ended ({one_line(str(error))}); those of dask.distributed are "
                "replaced: see docs/cluster.md"
            ) from None
        except Exception as error:
            if type(error).__name__ == "KilledWorker":  # the scheduler's limit is not ours
                return None
            if type(error).__name__ in _LOST:
                raise self._given_up() from None
            raise ClrtError(
                f"a worker cannot do its work: {type(error).__name__}: {error}; it needs clrt {__version__} "
                "and the same Python packages"
            ) from error

    def _given_up(self) -> ClrtError:
        self.check()  # which may know more
        return ClrtError("executor: it has given up what it was to do; was it, or its scheduler, shut down?")


class DaskPool(Pool):
    """The executor of a `distributed.Client`."""

    def __init__(self, executor: Any) -> None:
        super().__init__(executor)
        # dask names neither an executor's client nor its keywords in public
        self.client, self._submitting = executor._client, executor
        self._workers, self._asked = 1, 0.0
        self._bound: dict[Future[Any], str] = {}  # orders for one worker, by its address
        self._stranded: set[Future[Any]] = set()
        self._heard = self._peopled = time.monotonic()

    @property
    def workers(self) -> int:
        if time.monotonic() - self._asked > 2.0:
            self._ask()
        return max(1, self._workers)

    def submit(self, order: Any, to: Worker | None = None, do: Callable[[Any], Any] = work) -> Future[Any]:
        # never `pure`: dask would answer an order that comes again with what it said before
        where: dict[str, Any] = {"pure": False}
        address = to.address if to is not None else ""
        if address:
            where |= {"workers": [address], "allow_other_workers": True}  # it may be gone by then
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # of large orders: a scene is sent once a worker
            try:
                held = self.client.submit(do, order, **self._submitting._kwargs | where)
                future: Future[Any] = self._submitting._wrap_future(held)
            except Exception as error:  # in tornado's or dask's own words
                raise self._gone(error) from None
        # given back as soon as its answer has come: dask would do again what it believes to be wanted still,
        # where the worker ends on which it was
        future.add_done_callback(lambda _: held.release())
        if address:
            self._bound[future] = address
            future.add_done_callback(lambda done: self._bound.pop(done, None))
        return future

    def outcome(self, future: Future[Any]) -> Any:
        if future in self._stranded:
            self._stranded.discard(future)
            return None
        return super().outcome(future)

    def heard(self) -> None:
        self._heard = self._peopled = time.monotonic()

    def check(self) -> None:
        now = time.monotonic()
        if self.client.status != "running":
            raise self._gone("the connection is closed")
        if now - self._heard > min(_PING, _WORKERS) or not self._workers or self._bound:
            self._ask()
            self._heard = now
        if not self._workers and now - self._peopled > _WORKERS:
            raise ClrtError(
                f"{self._name}: no worker has come in {_WORKERS:.0f} s; start some: "
                f"dask worker {self._name} (docs/cluster.md)"
            )

    def _ask(self) -> None:
        """How many workers there are."""
        try:
            found = self.client.sync(self.client.scheduler.ncores, callback_timeout=_ANSWER)
        except Exception as error:  # of distributed, tornado, asyncio
            raise self._gone(error) from None
        self._workers, self._asked = len(found), time.monotonic()
        if found:
            self._peopled = self._asked
        # An order whose worker ends while there is no other waits in dask for ever, whoever comes after that.
        for future, address in list(self._bound.items()):
            if address not in found:
                self._stranded.add(future)
                if not future.cancel():  # its answer has come
                    self._stranded.discard(future)

    @property
    def _name(self) -> str:
        return str(getattr(self.client.scheduler, "address", "the scheduler"))

    def _gone(self, why: object) -> ClrtError:
        said = why if isinstance(why, str) else f"{type(why).__name__}: {why}"
        return ClrtError(f"{self._name}: the scheduler does not answer ({said})")


def pool_of(executor: object) -> Pool:
    """An executor, or a Client of distributed, as a pool. ClrtError for anything else."""
    if getattr(executor, "asynchronous", False) is True:
        right = "it must be one that answers within a call: Client(...) without asynchronous=True"
        raise ClrtError(fault("", "executor", executor, right))
    if hasattr(executor, "get_executor"):
        executor = executor.get_executor()
    if type(executor).__module__.startswith("distributed."):
        return DaskPool(executor)
    if not isinstance(executor, Executor):
        right = "it must be a concurrent.futures.Executor, such as client.get_executor() of distributed"
        raise ClrtError(f"executor: {show(executor)} is not allowed; {right}")
    return Pool(executor)
