"""Compiled programs of drivers that keep none themselves: one file a program, in the folder of `kernelcache`.

A file is its program's name in one line, the SHA-256 of what follows, and the driver's binary. The name is a
digest of all that the binary depends on: driver and its version, device, processor, build options (those that
pyopencl and the driver take from the environment among them) and source.
What does not fit, is cut short or is refused by the driver is compiled again and written anew.
"""

from __future__ import annotations

import hashlib
import warnings
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Final

from clrt.base import handlers
from clrt.base.atomic import replacing
from clrt.base.elsewhere import apart, relative
from clrt.base.errors import ClrtError
from clrt.base.resources import PACKAGE
from clrt.device import cachefolder, cachelock, vendors
from clrt.device.added import added
from clrt.device.opencl import cl
from clrt.device.processor import signature

_MOST: Final = 256 << 20  # bytes that are read of a file: programs take about 2 MB


def built(context: cl.Context, source: str, options: list[str]) -> cl.Program:
    """The program, from its binary where there is a good one, else compiled and kept. Raises cl.Error."""
    device = context.devices[0]
    file, name = _place(device, source, options)
    binary = _read(file, name)
    if binary:
        with suppress(cl.Error):
            return quietly(context, cl.Program(context, [device], [binary]), options)
    with cachelock.waiting("compiling kernels"):
        program = quietly(context, cl.Program(context, source), options)
    _write(file, name, program)
    return program


def _place(device: cl.Device, source: str, options: list[str]) -> tuple[Path, bytes]:
    platform = device.platform
    parts = (
        platform.name, platform.version, device.name, device.driver_version, signature(), *options,
        *map("=".join, added().items()), source,
    )  # fmt: skip
    name = hashlib.sha256("\0".join(parts).encode()).hexdigest()
    return cachefolder.ours("binaries", name[:32]), name.encode()


def _read(file: Path, name: bytes) -> bytes:
    """The binary that a file holds; b"" where there is none, or not this one, whole."""
    try:
        data = cachefolder.contents(file, _MOST)
    except OSError:
        return b""
    head, binary = data[:130], data[130:]
    return binary if head == _head(name, binary) else b""


def _head(name: bytes, binary: bytes) -> bytes:
    return name + b"\n" + hashlib.sha256(binary).hexdigest().encode() + b"\n"


def _write(file: Path, name: bytes, program: cl.Program) -> None:
    with suppress(OSError, ClrtError, cl.Error):  # only time is lost
        binary: bytes = program.get_info(cl.program_info.BINARIES)[0]  # type: ignore[index]
        if binary:
            cachefolder.make(file.parent)
            with replacing(file, told=False) as temporary:
                temporary.write_bytes(_head(name, binary) + binary)


def quietly(context: cl.Context, program: cl.Program, options: list[str]) -> cl.Program:
    """Build; what a compiler has to say about a program that it took is nobody's business.

    Not in the current folder, where Intel's looks for `cl.cfg` at each build, and Clang for `modules.idx`.
    (Oclgrind builds in the thread that made the context, or ends the process.)
    """
    with handlers.kept(), warnings.catch_warnings():
        warnings.simplefilter("ignore", cl.CompilerWarning)
        build = partial(program.build, options)
        # of the context: pyopencl warns who asks a program before it is built
        here = relative(*vendors.PLACES) or "Oclgrind" in context.devices[0].platform.name
        return build() if here else apart(PACKAGE, build)
