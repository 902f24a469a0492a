"""Kernel objects: made once, and handed on when nobody uses them any more.

For every kernel object that is made pyopencl compiles Python code that sets its arguments (1 ms; once more
where it is told of types), and keeps that code for as long as the process lives, under a name that it looks
for among all the names before: after 800 small pictures each took three times as long as the first, and the
process had grown by 100 MB.
"""

from __future__ import annotations

import weakref
from collections import defaultdict
from collections.abc import Callable
from operator import itemgetter
from typing import Any, Final

import numpy as np

from clrt.device.opencl import cl


class Kernel:
    """A kernel object, and which of its arguments are numbers: sets them without code written for it."""

    def __init__(self, made: cl.Kernel, numbers: tuple[bool, ...]) -> None:
        self.made = made
        places = range(len(numbers))
        self._numbers = _Places([place for place in places if numbers[place]])
        self._others = _Places([place for place in places if not numbers[place]])

    def set_args(self, arguments: tuple[Any, ...]) -> None:
        """Numbers by their bytes: asked for any argument, pyopencl tries what else each may be, for 10 us."""
        made: Any = self.made  # of its stubs these are no part
        made._set_arg_multi(self._others.numbered(arguments))
        made._set_arg_buf_multi(self._numbers.numbered(arguments))


class _Places:
    """Some places among arguments."""

    def __init__(self, places: list[int]) -> None:
        self._pairs: list[Any] = [x for place in places for x in (place, None)]
        several = len(places) > 1  # of one, itemgetter gives what is there, and no tuple
        self._pick: Callable[[Any], Any] = (
            itemgetter(*places) if several else lambda arguments: [arguments[place] for place in places]
        )

    def numbered(self, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
        """The arguments there, each after its place; in a quarter of the time of a loop."""
        pairs = self._pairs.copy()
        pairs[1::2] = self._pick(arguments)
        return tuple(pairs)


Key = tuple[cl.Program, str, tuple[bool, ...]]
_idle: Final[defaultdict[Key, list[Kernel]]] = defaultdict(list)


class Kept:
    """Kernel objects of one user, for whom nobody else sets arguments; its end frees them for others."""

    def __init__(self) -> None:
        self._taken: list[tuple[Key, Kernel]] = []
        weakref.finalize(self, _give_back, self._taken).atexit = False

    def take(self, program: cl.Program, name: str, arguments: tuple[Any, ...]) -> Kernel:
        """A kernel object for such arguments: numbers and buffers at the same places. Raises cl.Error."""
        numbers = tuple(isinstance(argument, np.generic) for argument in arguments)
        key = (program, name, numbers)
        try:
            kernel = _idle[key].pop()  # in one step, whichever threads ask
        except IndexError:
            kernel = Kernel(cl.Kernel(program, name), numbers)
        self._taken.append((key, kernel))
        return kernel


def _give_back(taken: list[tuple[Key, Kernel]]) -> None:
    for key, kernel in taken:
        _idle[key].append(kernel)
