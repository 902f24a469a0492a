"""Functions of the validation package, called by an executor's workers, again only where that is lost.

A call is a pure task: a function by name with plain arguments, and the files that it reads.
"""

from __future__ import annotations

import hashlib
import io
import pickle
from collections import Counter, deque
from collections.abc import Generator, Mapping
from concurrent.futures import Future
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, Final

from clrt import layout
from clrt.base import ending
from clrt.base.errors import ClrtError
from clrt.base.resources import validation_module
from clrt.base.scratch import scratch
from clrt.cluster.orders import Refusal, Worker
from clrt.cluster.pool import LOSSES, Pool
from clrt.cluster.worker import check_kernels, count, doing, proven
from clrt.device import foreign
from clrt.version import __version__

_AHEAD: Final = 2  # calls a worker, so that it has the next one when it has done one


@dataclass(frozen=True)
class Call:
    """What a worker is to call: `module.function(*arguments)`. device: that it takes.

    files: by absolute path what the function reads there. A worker that sees the same has them already;
    for others they are laid into a folder, and those of the arguments that are a `Path` lead there.
    """

    module: str
    function: str
    arguments: tuple[Any, ...]
    device: int | str | None = None
    files: Mapping[str, bytes] = field(default_factory=dict)


@dataclass(frozen=True)
class Sent:
    """A call on its way. kernels: the hash that the worker must find. packed: pickled, since only who knows
    the validation package can unpack it."""

    version: str
    kernels: str
    device: int | str | None
    packed: bytes


@dataclass(frozen=True)
class Reply:
    """What a call gave, pickled, and the device whose worker it was. seal: SHA-256 of call and outcome."""

    worker: Worker
    device: str
    found: bytes
    seal: bytes


def sent(call: Call) -> Sent:
    """A call for its way."""
    return Sent(__version__, foreign.source_hash(layout.RayFormat()), call.device, pickle.dumps(call))


def answer(order: Sent) -> Reply | Refusal:
    """Do a call. Whatever is wrong is in the answer, with the worker's name, and never raised."""
    with doing() as task:
        if order.version != __version__:
            raise ClrtError(f"it has clrt {__version__}, the client {order.version}; install the same")
        check_kernels(layout.RayFormat(), order.kernels)
        label = proven(order.device)
        validation_module("suite.worker")
        call: Call = pickle.loads(order.packed)
        with ExitStack() as stack:
            arguments = tuple(_there(one, call, stack) for one in call.arguments)
            result = getattr(validation_module(call.module), call.function)(*arguments)
        packed = pickle.dumps(result)
        count()
        task.answer = Reply(task.me, label, packed, _seal(order, packed))
    return task.answer


def _there(argument: Any, call: Call, stack: ExitStack) -> Any:
    """A path of the client's as a path of this worker's; any other argument as it is."""
    if not isinstance(argument, Path) or not call.files or all(_same(*file) for file in call.files.items()):
        return argument
    folder = stack.enter_context(scratch())
    for name, data in call.files.items():
        file = folder / _below(name)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(data)
    return folder / _below(str(argument))


def _below(name: str) -> Path:
    """An absolute path as one below a folder."""
    return Path(*[part.replace(":", "") for part in Path(name).parts[1:] if part != ".."])


def _same(name: str, data: bytes) -> bool:
    try:
        return Path(name).read_bytes() == data
    except OSError:
        return False


def _seal(order: Sent, found: bytes) -> bytes:
    return hashlib.sha256(hashlib.sha256(order.packed).digest() + found).digest()


@dataclass
class Told:
    """What was done: calls with an answer, those that were lost and done again, on what and by whom."""

    answers: int = 0
    lost: int = 0
    devices: set[str] = field(default_factory=set)
    workers: Counter[Worker] = field(default_factory=Counter)


def answers(pool: Pool, calls: Mapping[str, Call], told: Told) -> Generator[tuple[str, Any]]:
    """Names and what their calls gave, as they come. ClrtError where a worker refuses, with its name, and
    where none can answer any more. Whatever ends it, nothing that it handed in is begun after that."""
    waiting, losses = deque(calls), Counter[str]()
    done: SimpleQueue[Future[Any]] = SimpleQueue()
    under_way: dict[Future[Any], tuple[str, Sent]] = {}
    try:
        while waiting or under_way:
            while waiting and len(under_way) < _AHEAD * pool.workers:
                name = waiting.popleft()
                order = sent(calls[name])
                future = pool.submit(order, do=answer)
                under_way[future] = name, order
                future.add_done_callback(done.put)
            try:
                with ending.outside():  # nobody knows how long
                    future = done.get(timeout=1.0)
            except Empty:
                pool.check()
                continue
            pool.heard()
            name, order = under_way.pop(future)
            said = pool.outcome(future)
            if isinstance(said, Refusal):
                raise said.error.reworded(f"worker {said.worker}: {name}: {said.error}")
            if not isinstance(said, Reply) or said.seal != _seal(order, said.found):
                told.lost += 1
                losses[name] += 1
                if losses[name] >= LOSSES:
                    raise ClrtError(f"{name}: was lost {LOSSES} times: it is likely what ends the workers")
                waiting.appendleft(name)
                continue
            told.answers += 1
            told.devices.add(said.device)
            told.workers[said.worker] += 1
            yield name, pickle.load(io.BytesIO(said.found))
    finally:
        for future in under_way:
            future.cancel()
