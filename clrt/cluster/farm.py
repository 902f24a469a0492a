"""Who hands out orders: each is done once, and again only where it was lost on the way."""

from __future__ import annotations

from collections import deque
from collections.abc import Generator, Iterator
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from queue import Empty, SimpleQueue
from typing import Any, Final

import numpy as np

from clrt.base import ending
from clrt.base.errors import ClrtError
from clrt.cluster.orders import Answer, Lacking, Order, Refusal, Worker, sealed
from clrt.cluster.parcels import LARGE, Parcel
from clrt.cluster.pool import LOSSES, Pool
from clrt.device import foreign
from clrt.engine.job import Job
from clrt.version import __version__

_AHEAD: Final = 2  # orders a worker, so that it has the next one when it has done one


@dataclass(frozen=True, eq=False)
class Task:
    """Pixels of a job. owner: whatever the caller knows it by."""

    owner: Any
    job: Job
    parcel: Parcel
    pixels: np.ndarray


@dataclass
class Report:
    """What was done: orders with an answer, those that were lost and done again, questions for arrays.

    sent: bytes of arrays, without small ones, which travel with each order. workers: their answers;
    orders: how many each says it has done, ever. setups, walls: seconds of each order on its worker, until
    there were scene and kernels, and then.
    """

    answers: int = 0
    lost: int = 0
    asked: int = 0
    sent: int = 0
    workers: dict[Worker, int] = field(default_factory=dict)
    orders: dict[Worker, int] = field(default_factory=dict)
    setups: list[float] = field(default_factory=list)
    walls: list[float] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class _Errand:
    """An order under way. to: whose lack of arrays it is to end."""

    task: Task
    order: Order
    losses: int = 0
    to: Worker | None = None


class Farm:
    """Does tasks on a pool. One use: `work`, to its end or until it is closed."""

    def __init__(self, pool: Pool, device: int | str | None = None) -> None:
        self.pool, self.device = pool, device
        self.report = Report()
        self._done: SimpleQueue[Future[Any]] = SimpleQueue()
        self._errands: dict[Future[Any], _Errand] = {}
        self._held: deque[_Errand] = deque()  # wait until arrays have arrived somewhere
        self._sending: set[Worker] = set()  # to whom; of other scenes, too: they may share arrays
        self._kernels: dict[Any, str] = {}

    def work(self, tasks: Iterator[Task]) -> Generator[tuple[Task, Answer]]:
        """All tasks with their answers, as they come; tasks are taken when there is a worker for them.

        ClrtError where a worker refuses, with its name, and where none can answer any more. Whatever ends
        it, nothing that it handed in is begun after that.
        """
        more = True
        try:
            while True:
                while more and len(self._errands) + len(self._held) < _AHEAD * self.pool.workers:
                    task = next(tasks, None)
                    if task is None:
                        more = False
                    else:
                        self._hand_in(_Errand(task, self._order(task)))
                if not self._errands:
                    if not more:
                        return
                    continue
                try:
                    with ending.outside():  # nobody knows how long
                        future = self._done.get(timeout=1.0)
                except Empty:
                    self.pool.check()
                    continue
                self.pool.heard()
                errand = self._errands.pop(future)
                answer = self._answer(errand, future)
                if answer is not None:
                    yield errand.task, answer
        finally:
            for future in self._errands:
                future.cancel()

    def _order(self, task: Task) -> Order:
        job = task.job
        assert job.camera is not None
        ray_format = job.flat.ray_format
        if ray_format not in self._kernels:
            self._kernels[ray_format] = foreign.source_hash(ray_format)
        return Order(
            __version__, task.parcel.scene, self._kernels[ray_format], _small(task.parcel.recipe),
            tuple(task.parcel.arrays), self.device, job.settings, job.max_depth, job.camera, job.layers,
            task.pixels, job.adaptive, mattes=job.mattes,
        )  # fmt: skip

    def _hand_in(self, errand: _Errand) -> None:
        future = self.pool.submit(errand.order, errand.to)
        self._errands[future] = errand
        future.add_done_callback(self._done.put)

    def _answer(self, errand: _Errand, future: Future[Any]) -> Answer | None:
        """What became of an errand; None where it is under way again."""
        if errand.to is not None:  # the arrays have arrived, or were lost
            self._sending.discard(errand.to)
            held, self._held = self._held, deque()
            for other in held:
                self._hand_in(other)
        said = self.pool.outcome(future)
        if isinstance(said, Refusal):
            raise said.error.reworded(f"worker {said.worker}: {said.error}")
        if isinstance(said, Lacking):
            self._send(errand, said)
            return None
        whole = isinstance(said, Answer) and said.seal == sealed(
            errand.order, said.layers, said.rays, said.local_size
        )
        if not isinstance(said, Answer) or not whole:
            self._again(errand, "an answer that was changed on its way" if said else "the end of its worker")
            return None
        told = self.report
        told.answers += 1
        told.workers[said.worker] = told.workers.get(said.worker, 0) + 1
        told.orders[said.worker] = max(said.orders, told.orders.get(said.worker, 0))
        told.setups.append(said.setup)
        told.walls.append(said.wall)
        return said

    def _send(self, errand: _Errand, lacking: Lacking) -> None:
        """Send what a worker lacks, unless that is on its way: then wait until it has arrived."""
        self.report.asked += 1
        if lacking.worker in self._sending:
            self._held.append(self._bare(errand))
            return
        self._sending.add(lacking.worker)
        names = {*errand.order.arrays, *lacking.arrays}
        arrays = {name: errand.task.parcel.arrays[name] for name in names}
        self.report.sent += sum(array.nbytes for array in arrays.values())
        order = replace(errand.order, recipe=errand.task.parcel.recipe, arrays=arrays)
        self._hand_in(replace(errand, to=lacking.worker, order=order))

    def _again(self, errand: _Errand, why: str) -> None:
        self.report.lost += 1
        if errand.losses + 1 >= LOSSES:
            pixels = f"{len(errand.task.pixels)} pixels from {errand.task.pixels[0]} on"
            raise ClrtError(f"{pixels} were lost {LOSSES} times, the last time by {why}")
        self._hand_in(replace(self._bare(errand), losses=errand.losses + 1))

    def _bare(self, errand: _Errand) -> _Errand:
        """The same without what only one worker lacked."""
        return replace(errand, to=None, order=self._order(errand.task))


def _small(recipe: bytes) -> bytes:
    return recipe if len(recipe) < LARGE else b""
