"""Kernel objects: made once, and handed on when nobody uses them any more.

For every kernel object that is made pyopencl compiles Python code that sets its arguments (1 ms, twice), and
keeps that code for as long as the process lives, under a name that it looks for among all the names before:
after 800 small pictures each took three times as long as the first, and the process had grown by 100 MB.
"""

from __future__ import annotations

import weakref
from collections import defaultdict
from typing import Any, Final

import numpy as np

from clrt.device.opencl import cl

Key = tuple[cl.Program, str, tuple[np.dtype[Any] | None, ...]]
_idle: Final[defaultdict[Key, list[cl.Kernel]]] = defaultdict(list)


class Kept:
    """Kernel objects of one user, for whom nobody else sets arguments; its end frees them for others."""

    def __init__(self) -> None:
        self._taken: list[tuple[Key, cl.Kernel]] = []
        weakref.finalize(self, _give_back, self._taken).atexit = False

    def take(self, program: cl.Program, name: str, arguments: tuple[Any, ...]) -> cl.Kernel:
        """A kernel object for arguments of these types: told them beforehand, it takes numbers in a tenth of
        the time. Raises cl.Error.
        """
        types = tuple(a.dtype if isinstance(a, np.generic) else None for a in arguments)
        key = (program, name, types)
        try:
            kernel = _idle[key].pop()  # in one step, whichever threads ask
        except IndexError:
            kernel = cl.Kernel(program, name)
            kernel.set_scalar_arg_dtypes(types)
        self._taken.append((key, kernel))
        return kernel


def _give_back(taken: list[tuple[Key, cl.Kernel]]) -> None:
    for key, kernel in taken:
        _idle[key].append(kernel)
