"""The errors and warnings a user can meet; each one line: where, what, and what would be right."""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Mapping
from typing import Any

WORD, LINE = 200, 2000  # characters of a message's longest word (a name, mostly) and of all of it

has_limit = True
"""Whether a message may advise --limit: false within a command that does not take it."""


class Portable(Exception):
    """An exception that can be copied and pickled, whatever its class asks for when it is made.

    Python makes it again from `args` alone; another process' pool waits for ever where that fails.
    """

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (type(self), self.args), self.__dict__ or None


def _again(kind: type[Portable], arguments: tuple[Any, ...]) -> Portable:
    return kind.__new__(kind, *arguments)


class ClrtError(Portable):
    """A fault of the user's making; the command line prints it in one line and exits with 2."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))

    def reworded(self, message: str) -> ClrtError:
        """An error of this class that says `message`, whatever the class asks for when it is made."""
        other = _again(type(self), (one_line(message),))
        other.__dict__.update(self.__dict__)
        assert isinstance(other, ClrtError)
        return other


class SceneError(ClrtError):
    """A scene, or a file that belongs to it, says something that cannot be rendered."""


class MissingPackage(SceneError):
    """A file cannot be read without an optional package; the message says which, and how it is installed."""


class DeviceError(ClrtError):
    """No OpenCL device fits, or its driver refused."""


class LimitError(ClrtError):
    """A scene or a render would cost more than `clrt.base.limits.Limits` allows."""


class MemoryLimitError(LimitError):
    """There is no room on the device for one buffer more; with smaller tiles there may be."""


class ClrtWarning(Portable, UserWarning):
    """Something that is allowed but probably not meant."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


NO_MEMORY = "this machine has no memory left for it; use a smaller scene or picture, or fewer layers"

_UNSEEN = re.compile(
    "[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff\ufffe\uffff]"
)

_SPENT = {
    errno.EMFILE: "this process may not open more files (ulimit -n)",
    errno.ENFILE: "this machine has no more open files",
    errno.ENOMEM: NO_MEMORY,
    errno.EAGAIN: "no more processes or threads can be started here (ulimit -u, ulimit -v)",
}
_WORDS = {
    "can't start new thread": errno.EAGAIN,  # a RuntimeError of Python's own
    "failed to map segment": errno.ENOMEM,  # an ImportError, in the loader's words
    "cannot allocate memory": errno.ENOMEM,
    "too many open files": errno.EMFILE,
}


def exhausted(error: BaseException) -> str:
    """What of the machine ran out, where an exception says that, in whatever words; '' of another one."""
    if isinstance(error, MemoryError):
        return NO_MEMORY
    if isinstance(error, FileNotFoundError) and error.filename is None and _is_nowhere():
        return "the current folder was removed; change to another one"
    if isinstance(error, OSError):
        return _SPENT.get(error.errno or 0, "")
    if isinstance(error, (RuntimeError, ImportError)):
        said = str(error).lower()
        return next((_SPENT[number] for words, number in _WORDS.items() if words in said), "")
    return ""


def _is_nowhere() -> bool:
    """Whether the current folder is not there any more."""
    try:
        os.getcwd()
    except OSError:
        return True
    return False


def one_line(text: str) -> str:
    """`text` as a terminal or a log may show it: printable, one line, neither it nor a word too long.

    Every run of white space, line breaks included, becomes one space. What is too long loses its middle.
    """
    words = _cut(text, 10 * LINE).split()  # first: a broken file may hold a name of megabytes
    return _cut(" ".join(_cut(printable(word), WORD) for word in words), LINE)


def printable(text: str) -> str:
    r"""`text` with all that could steer a terminal or hide what stands there written as `\x1b`, `\u202e`, ...

    That is what is neither a printable character nor a space: control and format characters, marks that
    reverse the direction of writing, halves of characters (bytes of names that are not UTF-8).
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def legible(value: Any) -> Any:
    r"""A text, or all texts in lists and dicts, as files for people and other programs hold them.

    What XML and UTF-8 cannot hold, what steers a terminal, and what turns the direction of writing is
    written as `\x1b`, `\udcff`, ...; line breaks and tabs stay.
    """
    if isinstance(value, str):
        return _UNSEEN.sub(lambda found: found.group().encode("unicode_escape").decode(), value)
    if isinstance(value, Mapping):
        return {legible(key): legible(item) for key, item in value.items()}
    return [legible(item) for item in value] if isinstance(value, (list, tuple)) else value


def in_line(text: str) -> str:
    """`legible`, in one line: a name of a file may hold line breaks."""
    return legible(text).replace("\n", "\\n").replace("\r", "\\r")


def decimal(word: str) -> float:
    """A number in a text, as all programs read it. ValueError for others, and for what Python alone takes:
    `1_0`, and digits of other scripts."""
    if "_" in word or not word.isascii():
        raise ValueError(f"{show(word)} is not a number")
    return float(word)


def show(value: object, width: int = 60) -> str:
    """`value` as a message shows it: its repr in one line of at most `width` characters."""
    try:
        text = " ".join(repr(value).split())
    except Exception:  # an int of too many digits, an endless structure, a __repr__ that fails
        text = f"a {type(value).__name__}"
    return text if len(text) <= width else text[: width - 3] + "..."


def located(source: str, place: str, text: str) -> str:
    """'file: place: text', without the parts that are empty."""
    return ": ".join(part for part in (source, place, text) if part)


def fault(source: str, place: str, value: object, right: str) -> str:
    """The usual message: `room.toml: shapes[3].radius: -1.0 is not allowed; a radius must be > 0`."""
    return located(source, place, f"{show(value)} is not allowed; {right}")


def _cut(text: str, most: int) -> str:
    """`text` without its middle where it is too long: both of its ends say the most."""
    if len(text) <= most:
        return text
    head, tail = (most - 3) * 2 // 3, (most - 3) - (most - 3) * 2 // 3
    return f"{text[:head]}...{text[-tail:]}"
