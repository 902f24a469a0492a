"""Standard output and standard error while a command runs: no write to them can fail, nor steer a terminal.

A picture is saved whether somebody reads the warnings or not. What is written passes through `Stream`, the
progress bars and help of other packages included; what failed is noted, for the exit code.
"""

from __future__ import annotations

import errno
import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from typing import TYPE_CHECKING, Any, Final

from clrt.base.errors import ClrtError, one_line, printable

if TYPE_CHECKING:
    from rich.console import Console


FAULT: Final = 2
"""The exit code where one line on stderr says what is wrong."""


_NARROWEST: Final = 20  # letters of a line: a table of fewer has a letter in each


def say(text: str, code: int = 0) -> int:
    """Put one line on stderr; return `code`."""
    if sys.stderr is not None:  # print takes None for stdout
        print(one_line(f"clrt: {text}"), file=sys.stderr, flush=True)
    return code


class Stream(io.TextIOBase):
    """Text to a stream that may be full, closed, gone or of few characters. `failure`: what first went wrong.

    escaping: write what is not printable as `errors.printable` does; line breaks and tabs pass.
    """

    def __init__(self, inner: Any, escaping: bool = True) -> None:
        self.inner, self.escaping = inner, escaping
        self.failure: OSError | None = None
        if inner is None:  # the process was started without
            self.failure = OSError(errno.EBADF, os.strerror(errno.EBADF))

    @property
    def encoding(self) -> str:  # type: ignore[override]
        return getattr(self.inner, "encoding", None) or "utf-8"

    def write(self, text: str) -> int:
        shown = _escaped(text) if self.escaping else text
        self._try(lambda: self.inner.write(_in(shown, self.encoding)))
        return len(text)

    def flush(self) -> None:
        self._try(lambda: self.inner.flush())

    def isatty(self) -> bool:
        return self.failure is None and bool(self.inner.isatty())

    def fileno(self) -> int:
        if self.inner is None:
            raise io.UnsupportedOperation("fileno")
        return int(self.inner.fileno())

    def writable(self) -> bool:
        return True

    def raw(self) -> Stream:
        """A stream to the same place that lets a terminal's escape sequences pass."""
        return _Raw(self)

    def _try(self, call: Any) -> None:
        if self.failure is not None:
            return
        try:
            call()
        except (OSError, ValueError) as error:  # a stream that is closed raises ValueError
            self.failure = error if isinstance(error, OSError) else OSError(errno.EBADF, str(error))
            self._drop()

    def _drop(self) -> None:
        """Let what is left in buffers, which the interpreter writes at its end, go nowhere."""
        with suppress(OSError, ValueError, AttributeError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self.inner.fileno())
            os.close(nowhere)


class _Raw(Stream):
    """See `Stream.raw`; a failure is the outer stream's."""

    def __init__(self, outer: Stream) -> None:
        super().__init__(outer.inner, escaping=False)
        self._outer = outer

    def _try(self, call: Any) -> None:
        self._outer._try(call)
        self.failure = self._outer.failure


@contextmanager
def surviving() -> Iterator[tuple[Stream, Stream]]:
    """Within the block `sys.stdout` and `sys.stderr` are such streams."""
    before = sys.stdout, sys.stderr
    out, err = Stream(sys.stdout), Stream(sys.stderr)
    sys.stdout, sys.stderr = out, err
    try:
        yield out, err
    finally:
        sys.stdout, sys.stderr = before


def hold_closed() -> None:
    """Fill the places of closed standard streams, lest a file opened later be taken for one of them."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)


def console(stderr: bool = False, **options: Any) -> Console:
    """A console of rich, whose texts are made printable before their markup becomes escape sequences."""
    from rich.console import Console

    class Printable(Console):
        def render_str(self, text: str, **how: Any) -> Any:
            return super().render_str(_escaped(text), **how)

    stream: Any = sys.stderr if stderr else sys.stdout
    file: Any = stream.raw() if isinstance(stream, Stream) else stream
    made = Printable(file=file, stderr=stderr, emoji=False, **options)
    made.width = max(made.width, _NARROWEST)
    return made


def marked(text: str) -> str:
    """Any text for a place where rich reads markup."""
    from rich.markup import escape

    return escape(printable(text))


def tell_more(verbose: int) -> None:
    """Put what clrt logs on stderr, a line each: with 1 what it does, with 2 details, with 0 nothing."""
    if not verbose and "clrt.base.log" not in sys.modules:
        return  # nobody has logged: spare the import
    import logging

    from clrt.base.log import log

    log.handlers[:] = [handler for handler in log.handlers if not isinstance(handler, _lines())]
    log.setLevel(logging.NOTSET)
    if verbose:
        log.addHandler(_lines()())
        log.setLevel(logging.INFO if verbose == 1 else logging.DEBUG)


@cache
def _lines() -> Any:
    """The class of handlers whose records are lines like all others on stderr."""
    import logging

    class Lines(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            say(record.getMessage())

    return Lines


def write_bytes(data: bytes) -> bool:
    """Put what is no text on standard output; whether a reader was there. ClrtError where that fails."""
    sys.stdout.flush()
    out = sys.stdout
    inner = out.inner if isinstance(out, Stream) else out
    binary = getattr(inner, "buffer", None)
    if binary is None or (isinstance(out, Stream) and out.failure):
        raise ClrtError("-: standard output is closed; give the name of a file")
    if out.isatty():
        raise ClrtError("-: a terminal cannot show a picture; lead standard output to a file or a program")
    try:
        binary.write(data)
        binary.flush()
    except BrokenPipeError as error:
        if isinstance(out, Stream):
            out.failure = error
            out._drop()
        return False
    except (OSError, ValueError) as error:
        if isinstance(out, Stream):
            out.failure = OSError(errno.EBADF, str(error))
            out._drop()
        raise ClrtError(f"-: standard output cannot be written: {error}") from None
    return True


def _escaped(text: str) -> str:
    return text if text.isprintable() else "".join(c if c in "\n\t" else printable(c) for c in text)


def _in(text: str, encoding: str) -> str:
    """`text` with what the encoding lacks escaped."""
    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        return text.encode(encoding, "backslashreplace").decode(encoding)
    return text
