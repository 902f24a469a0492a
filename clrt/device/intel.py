"""Intel's OpenCL runtime for processors of any maker, where pip has installed it beside clrt (extra `intel`).

Its wheels announce it with a file that names a folder of their maker's machine, so no loader finds it. Here
its library is loaded and asked for its platform as a loader would ask (cl_khr_icd): every call on that
platform then goes to the right driver by itself. No variable is set, and `pyopencl.get_platforms()` gives
everybody else in the process what it gave before.
"""

from __future__ import annotations

import ctypes
import importlib.metadata
import os
import sys
from functools import cache
from pathlib import Path
from typing import Final

from clrt.base.elsewhere import within
from clrt.base.resources import PACKAGE
from clrt.device.opencl import cl

PACKAGES: Final = ("intel-opencl-rt", "intel-cmplr-lib-rt")
PLATFORM: Final = "Intel(R) OpenCL"
_LIBRARY: Final = "intelocl64.dll" if sys.platform == "win32" else "libintelocl.so"
_MOST: Final = 8  # platforms of one library


@cache
def library() -> Path | None:
    """The runtime's library, None where its packages are not installed."""
    try:
        files = importlib.metadata.files(PACKAGES[0]) or []
    except importlib.metadata.PackageNotFoundError:
        return None
    found = (Path(str(file.locate())).resolve() for file in files if file.name == _LIBRARY)
    return next((file for file in found if file.is_file()), None)


@cache
def platforms() -> tuple[cl.Platform, ...]:
    """The runtime's platforms: none where it is not installed or does not load."""
    with within(PACKAGE):
        return _loaded()


def _loaded() -> tuple[cl.Platform, ...]:
    file = library()
    if file is None:
        return ()
    if sys.platform == "win32":
        os.add_dll_directory(str(file.parent))
    try:
        loaded = ctypes.CDLL(str(file))
        loaded.clGetExtensionFunctionAddress.restype = ctypes.c_void_p
        loaded.clGetExtensionFunctionAddress.argtypes = [ctypes.c_char_p]
        address = loaded.clGetExtensionFunctionAddress(b"clIcdGetPlatformIDsKHR")
    except (OSError, AttributeError):
        return ()  # `clrt doctor` says why it does not load
    if not address:
        return ()
    count = ctypes.c_uint()
    handles = (ctypes.c_void_p * _MOST)()
    get = ctypes.CFUNCTYPE(
        ctypes.c_int, ctypes.c_uint, ctypes.POINTER(ctypes.c_void_p), ctypes.POINTER(ctypes.c_uint)
    )(address)
    if get(_MOST, handles, ctypes.byref(count)) != 0:
        return ()
    return tuple(cl.Platform.from_int_ptr(handle) for handle in handles[: count.value] if handle)
