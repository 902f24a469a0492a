"""What callers hand to the public functions, checked: wrong kinds are a ClrtError that names the argument.

Every public entry point passes each of its arguments through one of these before it uses them, and is marked
`public`, so that running out of memory is one line, too.
"""

from __future__ import annotations

import operator
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from decimal import Decimal
from functools import partial, wraps
from numbers import Real
from pathlib import Path
from typing import Any, Final, ParamSpec, TypeGuard, TypeVar

import numpy as np

from clrt.base import ending
from clrt.base.errors import ClrtError, LimitError, exhausted, fault

P = ParamSpec("P")
T = TypeVar("T")


_NO_LISTS: Final = (str, bytes, bytearray, memoryview)  # sequences, some of which cannot be gone through


def public(function: Callable[P, T]) -> Callable[P, T]:
    """An entry point of the package: where memory, files or threads run out in it, a LimitError says so.

    Numbers that overflow there do so in silence, as on the device: numpy has no words for the user. What a
    function of the caller's raises stays what it is.
    """

    @wraps(function)
    def entered(*arguments: P.args, **named: P.kwargs) -> T:
        ending.enter()
        try:
            with np.errstate(all="ignore"):
                return function(*arguments, **named)
        except (MemoryError, OSError, RuntimeError) as error:
            spent = exhausted(error)
            if not spent or ending.is_callers(error):
                raise
            cause = error.with_traceback(None)  # which would hold what the failed call held
        finally:
            ending.leave()
        raise LimitError(spent) from cause

    return entered


def whole(name: str, value: object, least: int | None = 0, most: int | None = None) -> int:
    """`value` as an int: a whole number, numpy's too, from `least` to `most`; True and False are none."""
    right = "it must be a whole number" + ("" if least is None else f", at least {least}")
    right += "" if most is None else f", at most {most}"
    if not _is_whole(value):
        raise ClrtError(fault("", name, value, right))
    if (least is not None and value < least) or (most is not None and value > most):
        raise ClrtError(fault("", name, value, right))
    return operator.index(value)


def _is_whole(value: object) -> TypeGuard[int]:
    """Not a truth value, nor a time, which numpy counts among its integers."""
    return isinstance(value, (int, np.integer)) and not isinstance(value, (bool, np.timedelta64))


def optional(name: str, value: object, least: int = 0, most: int | None = None) -> int | None:
    """As `whole`, but None stays None."""
    return None if value is None else whole(name, value, least, most)


def number(name: str, value: object) -> float:
    """`value` as a float: a number, numpy's too; True and False are none."""
    real = _is_whole(value) or isinstance(value, (float, np.floating))
    try:
        return float(value) if real else float("no number")  # type: ignore[arg-type]
    except (ValueError, OverflowError):  # OverflowError: an int beyond all floats
        raise ClrtError(fault("", name, value, "it must be a number")) from None


def flag(name: str, value: object) -> bool:
    """`value` as a bool: True or False, numpy's too."""
    if not isinstance(value, (bool, np.bool_)):
        raise ClrtError(fault("", name, value, "it must be True or False"))
    return bool(value)


def path(name: str, value: object) -> Path:
    """`value` as a Path: a text or a path, without the character NUL, which no file's name can hold."""
    try:
        text = os.fspath(value) if isinstance(value, (str, os.PathLike)) else None
    except TypeError:  # its __fspath__ gives neither text nor bytes
        text = None
    if not isinstance(text, str):
        raise ClrtError(fault("", name, value, "it must be a file's name: a text or a pathlib.Path"))
    if "\0" in text:
        raise ClrtError(fault("", name, value, r"a file's name cannot hold the character \x00"))
    try:
        os.fsencode(text)
    except UnicodeError:
        raise ClrtError(fault("", name, value, "a file's name cannot hold half a character")) from None
    return Path(str.__str__(text))  # an Enum's text, not its name


def optional_path(name: str, value: object) -> Path | None:
    """As `path`; None and an empty text stand for none."""
    return None if value is None or (isinstance(value, str) and not value) else path(name, value)


def text(name: str, value: object) -> str:
    """`value`, which must be a text."""
    if not isinstance(value, str):
        raise ClrtError(fault("", name, value, "it must be a text"))
    return value


def names(name: str, value: object) -> tuple[str, ...]:
    """`value` as a tuple of texts: a sequence or a set of them, or "all", but no other text by itself."""
    if isinstance(value, str) and value == "all":
        return ("all",)
    many = isinstance(value, (Sequence, set, frozenset)) and not isinstance(value, _NO_LISTS)
    if not many or not all(isinstance(one, str) for one in value):  # type: ignore[attr-defined]
        example = f"[{value!r}]" if isinstance(value, str) and len(value) < 30 else "['depth']"
        raise ClrtError(fault("", name, value, f"it must be a list of names, such as {example}"))
    if isinstance(value, (set, frozenset)):  # in another order in each process
        return tuple(sorted(value))
    return tuple(value)  # type: ignore[arg-type]


def mapping(name: str, value: object) -> Mapping[str, Any]:
    """`value`, which must be a mapping with texts for keys."""
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise ClrtError(fault("", name, value, "it must be a dict whose keys are texts"))
    return value


def instance(name: str, value: object, kind: type[T]) -> T:
    """`value`, which must be of the class `kind`."""
    if not isinstance(value, kind):
        raise ClrtError(fault("", name, value, f"it must be a clrt.{kind.__name__}"))
    return value


def optional_instance(name: str, value: object, kind: type[T]) -> T:
    """As `instance`; None stands for one with its usual values."""
    return kind() if value is None else instance(name, value, kind)


def function(name: str, value: object) -> Any:
    """`value`, a function of the caller's, to be called within a public call; None stays None."""
    if value is None:
        return None
    if not callable(value):
        raise ClrtError(fault("", name, value, "it must be a function, or None"))
    return partial(ending.call_back, value)


def device(name: str, value: object) -> int | str | None:
    """`value` as a choice of device: a number, a text that is not empty, or None."""
    if value is None or (isinstance(value, str) and value.strip()):
        return value
    if _is_whole(value) and 0 <= value < 1 << 31:
        return operator.index(value)
    right = "it must be a number of `clrt devices`, or a part of a device's name"
    raise ClrtError(fault("", name, value, right))


def real_numbers(name: str, value: object, form: str) -> np.ndarray:
    """`value`, real numbers in nested lists or an array, as an array of its own type; `form`: its shape."""
    right = f"it must be numbers in an array of shape {form}"
    try:
        found = np.asarray(value)
    except (TypeError, ValueError, OverflowError):  # rows of different lengths
        raise ClrtError(fault("", name, value, right)) from None
    if found.dtype == object and all(map(_is_real, found.flat)):  # fractions, large ones
        with suppress(OverflowError):  # a whole number beyond all floats
            found = found.astype(np.float64)
    if found.dtype.kind not in "iuf":
        raise ClrtError(fault("", name, value, right))
    unmasked(name, value)
    return found


def _is_real(value: object) -> bool:
    return isinstance(value, (Real, Decimal, np.floating)) and not isinstance(value, (bool, np.timedelta64))


def unmasked(name: str, value: object) -> None:
    """ClrtError for an array some of whose numbers are masked."""
    if "numpy.ma" in sys.modules and np.ma.is_masked(value):  # else nobody has made one; it takes a while
        raise ClrtError(f"{name}: {np.ma.count_masked(value)} of its numbers are masked; fill them in")


def array(name: str, value: object, kind: type[np.floating], form: str) -> np.ndarray:
    """`value`, real numbers in nested lists or an array, as an array of `kind`; `form` names its shape.

    What is beyond the range of `kind` becomes infinite.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        return real_numbers(name, value, form).astype(kind, copy=False)


def vectors(name: str, value: object, kind: type[np.floating]) -> np.ndarray:
    """`value` as an array (n, 3) of `kind`."""
    found = array(name, value, kind, "(n, 3)")
    if found.ndim != 2 or found.shape[1] != 3:
        raise ClrtError(f"{name}: shape {found.shape} is not (n, 3)")
    return found


def rays(
    origins: object, directions: object, kind: type[np.floating], prefix: str = ""
) -> tuple[np.ndarray, np.ndarray]:
    """Origins and directions as two arrays (n, 3) of `kind`, as many of one as of the other."""
    o = vectors(f"{prefix}origins", origins, kind)
    d = vectors(f"{prefix}directions", directions, kind)
    if len(o) != len(d):
        raise ClrtError(
            f"{prefix}origins and {prefix}directions: {len(o)} and {len(d)} rays; they must be as many"
        )
    return o, d
