"""Drivers that end or hold up whoever loads them: found in processes apart, and kept from the loader.

A loader loads every driver that a file announces, before anybody can choose among them: one that aborts as
it is loaded (half installed, or with a library of another's name) ends all programs that ask for OpenCL. So
where there are others than the driver beside pyopencl, a process of its own loads them first, once for what
is announced (`clrt.device.trial`); if that ends, each by itself, and the loader is shown the others.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Final

from clrt.base import notices
from clrt.base.scratch import scratch
from clrt.device import trial, vendors

_OTHERS: Final = ("OPENCL_VENDOR_PATH", "OCL_ICD_FILENAMES")  # what these name is loaded all the same
_NONE: Final = "no-driver"  # a file that is not there: then none is loaded


@cache
def harmful() -> dict[Path, str]:
    """The `.icd` files whose driver ends or holds up who loads it, and how. Warns of what is new."""
    if trial.is_listing() or trial.circumstances() or not _may_be_left_out():
        return {}  # with `circumstances`, who asks for devices is told of them
    files, key = vendors.files(), vendors.announced()
    if not trial.listing(key)[0]:
        return {}
    told = {file: trial.listing(f"{key}\0{file}", {vendors.VARIABLE: str(file)}) for file in files}
    found = {file: fault for file, (fault, _) in told.items() if fault}
    for file, fault in found.items():
        if told[file][1]:
            what = f"the driver of {file} is left out: as it is loaded, {fault}"
            notices.warn("", "", f"{what}; install it again, or remove that file")
    return found


def is_known() -> bool:
    """Whether a loader may load all drivers, as far as that is known without a trial."""
    return not _may_be_left_out() or trial.is_known_to_list(vendors.announced())


def _may_be_left_out() -> bool:
    """Whether there are others than the driver beside pyopencl, and all are named by files."""
    bundled = vendors.bundled_folder()
    others = any(file.parent != bundled for file in vendors.files())
    return others and not any(map(os.environ.get, _OTHERS))


@contextmanager
def left_out() -> Iterator[None]:
    """Let a loader that reads its files within this see none of `harmful`."""
    bad = harmful()
    if not bad:
        yield
        return
    good = [vendor for vendor in vendors.vendors(tried=False) if vendor.file not in bad]
    beside = vendors.bundled_folder()
    with scratch() as folder:
        place = str(folder)
        if len(good) < 2 or any(file.parent == beside for file in bad):
            # of a folder the loader would take what lies beside itself, too
            place = str(good[0].file if good else folder / _NONE)
        else:
            for number, vendor in enumerate(vendor for vendor in good if vendor.file.parent != beside):
                (folder / f"{number}.icd").write_text(f"{vendor.library}\n", "utf-8")
        before = os.environ.get(vendors.VARIABLE)
        os.environ[vendors.VARIABLE] = place
        try:
            yield
        finally:
            os.environ.pop(vendors.VARIABLE)
            if before is not None:
                os.environ[vendors.VARIABLE] = before
