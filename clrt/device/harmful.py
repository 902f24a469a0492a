"""Drivers that end or hold up whoever loads them: found in processes apart, and kept from the loader.

A loader loads every driver that a file announces, before anybody can choose among them: one that aborts as
it is loaded (half installed, or with a library of another's name) ends all programs that ask for OpenCL. So
where there are others than the driver beside pyopencl, a process of its own loads them first, once for what
is announced (`clrt.device.trial`); if that ends, each by itself, and the loader is shown the others.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Final

from clrt.base import notices
from clrt.device import trial, vendors

_OTHERS: Final = ("OPENCL_VENDOR_PATH", "OCL_ICD_FILENAMES")  # what these name is loaded all the same
_NONE: Final = "no-driver"  # a file that is not there: then none is loaded


@cache
def harmful() -> dict[Path, str]:
    """The `.icd` files whose driver ends or holds up who loads it, and how. Warns of what is new."""
    files = vendors.files()
    if trial.is_listing() or trial.circumstances() or any(map(os.environ.get, _OTHERS)):
        return {}  # with `circumstances`, who asks for devices is told of them
    bundled = vendors.bundled_folder()
    if all(file.parent == bundled for file in files) or not trial.listing(vendors.announced())[0]:
        return {}
    key = vendors.announced()
    told = {file: trial.listing(f"{key}\0{file}", {vendors.VARIABLE: str(file)}) for file in files}
    found = {file: fault for file, (fault, _) in told.items() if fault}
    for file, fault in found.items():
        if told[file][1]:
            what = f"the driver of {file} is left out: as it is loaded, {fault}"
            notices.warn("", "", f"{what}; install it again, or remove that file")
    return found


@contextmanager
def left_out() -> Iterator[None]:
    """Let a loader that reads its files within this see none of `harmful`."""
    bad = harmful()
    if not bad:
        yield
        return
    good = [vendor for vendor in vendors.vendors(tried=False) if vendor.file not in bad]
    beside = vendors.bundled_folder()
    with tempfile.TemporaryDirectory(prefix="clrt-drivers-") as folder:
        place = folder
        if len(good) < 2 or any(file.parent == beside for file in bad):
            # of a folder the loader would take what lies beside itself, too
            place = str(good[0].file) if good else os.path.join(folder, _NONE)
        else:
            for number, vendor in enumerate(vendor for vendor in good if vendor.file.parent != beside):
                Path(folder, f"{number}.icd").write_text(f"{vendor.library}\n", "utf-8")
        before = os.environ.get(vendors.VARIABLE)
        os.environ[vendors.VARIABLE] = place
        try:
            yield
        finally:
            os.environ.pop(vendors.VARIABLE)
            if before is not None:
                os.environ[vendors.VARIABLE] = before
