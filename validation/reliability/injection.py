"""Faults on order: the k-th call of the driver or the disk fails, once, as it would there."""

from __future__ import annotations

import errno
import pkgutil
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from typing import Any, Final
from unittest import mock

import OpenImageIO as oiio
from pyopencl import tools as cl_tools

from clrt.device.opencl import cl

Fault = Callable[[], Any]  # raises, or gives what a call that failed gives


def _driver() -> Any:
    raise cl.RuntimeError("injected: OUT_OF_RESOURCES")


def _memory() -> Any:
    raise cl.MemoryError("injected: MEM_OBJECT_ALLOCATION_FAILURE")


def _disk() -> Any:
    raise OSError(errno.ENOSPC, "injected: No space left on device")


def _reading() -> Any:
    raise OSError(errno.EIO, "injected: Input/output error")


# where faults may happen: owner, name, what is at fault, and how it fails
POINTS: Final[tuple[tuple[Any, str, str, Fault], ...]] = (
    (cl, "get_platforms", "driver", _driver),
    (cl, "Context", "driver", _driver),
    (cl, "CommandQueue", "driver", _driver),
    (cl.Program, "build", "build", _driver),
    (cl, "Kernel", "driver", _driver),
    (cl_tools.MemoryPool, "allocate", "memory", _memory),
    (cl, "enqueue_nd_range_kernel", "launch", _driver),
    (cl, "enqueue_copy", "copy", _driver),
    (cl, "enqueue_fill_buffer", "fill", _driver),
    (cl.Event, "wait", "wait", _driver),
    (cl.CommandQueue, "finish", "wait", _driver),
    ("clrt.base.atomic.os", "open", "write", _disk),
    ("clrt.base.atomic.os", "fsync", "write", _disk),
    ("clrt.base.atomic.os", "replace", "write", _disk),
    (oiio.ImageOutput, "create", "write", lambda: None),
    (oiio.ImageInput, "open", "read", lambda: None),
    ("clrt.base.files", "open", "read", _reading),
)


@dataclass
class Plan:
    """Which call fails (None: none), and the calls so far: where, and whose fault it would be."""

    fails: int | None = None
    calls: list[tuple[str, str]] = field(default_factory=list)


@contextmanager
def injected(fails: int | None = None) -> Iterator[Plan]:
    """Within the block the call of number `fails` (from 0) of all calls at POINTS fails."""
    plan = Plan(fails)
    with ExitStack() as stack:
        for owner, name, kind, fault in POINTS:
            target = _resolve(owner)
            watched = _watched(plan, getattr(target, name, open), name, kind, fault)
            stack.enter_context(mock.patch.object(target, name, watched, create=True))
        yield plan


def _resolve(owner: Any) -> Any:
    return pkgutil.resolve_name(owner) if isinstance(owner, str) else owner


def _watched(plan: Plan, original: Any, name: str, kind: str, fault: Fault) -> Any:
    def call(*arguments: Any, **named: Any) -> Any:
        number = len(plan.calls)
        plan.calls.append((name, kind))
        return fault() if number == plan.fails else original(*arguments, **named)

    return call
