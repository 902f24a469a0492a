"""A thread that waits for devices in the main thread's place, which answers Ctrl-C meanwhile.

No `ThreadPoolExecutor`: its locks are Python's, and an interrupt between taking one and giving it back
leaves it taken for ever. Here each step that others depend on is one of C, which no handler comes between.
"""

from __future__ import annotations

import _thread
import os
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any, Final

from clrt.base import ending
from clrt.base.elsewhere import own_stack

_Job = tuple[Callable[[], Any], list[Any], list[BaseException], Any]
_jobs: Final[SimpleQueue[_Job]] = SimpleQueue()
_started: Final[list[int]] = []  # processes that have the thread: a fork has not


def done(action: Callable[[], Any]) -> Any:
    """What `action` gives or raises, in the other thread. It goes on there whatever is raised here."""
    answer: list[Any] = []
    failure: list[BaseException] = []
    ended = _thread.allocate_lock()
    ended.acquire()
    if not _started:
        try:
            with own_stack():
                _thread.start_new_thread(_work, ())
        except RuntimeError:  # there is no room for one, or the interpreter ends: Ctrl-C has to wait
            return action()
        _started.append(os.getpid())  # after it: two threads do no harm
    _jobs.put((action, answer, failure, ended))
    ended.acquire()
    if failure:
        raise failure.pop()
    return answer[0]


def _work() -> None:
    while True:
        action, answer, failure, ended = _jobs.get()
        try:
            answer.append(action())
        except BaseException as error:
            failure.append(error)
        ended.release()
        del action, answer, failure, ended  # what was waited for may be given up


@ending.at_last
def _finish() -> None:
    """The interpreter must not end while a thread is in a driver."""
    if os.getpid() in _started:
        done(lambda: None)
