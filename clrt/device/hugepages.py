"""Ask for large pages of memory: rays jump about in a tree, and with 4 KiB pages each jump looks up a page.

A hint, for the tree alone: tracing a million triangles is 4 to 7 % faster. For all of a scene it would take
longer than it saves in one picture, as the system clears and seeks large pages slowly. Linux has it, and only
a processor's buffers lie where it counts.
"""

from __future__ import annotations

import ctypes
import mmap
from typing import Any, Final

import numpy as np

from clrt.device.opencl import cl

PAGE: Final = 1 << 21  # bytes of a large page on x86-64 and, mostly, on ARM


def ask(queue: cl.CommandQueue, buffer: Any, nbytes: int) -> bool:
    """Advise the system to back what is untouched of a buffer with large pages. Did it take the advice?"""
    advice = getattr(mmap, "MADV_HUGEPAGE", None)
    if advice is None or nbytes < 2 * PAGE or not queue.device.type & cl.device_type.CPU:
        return False
    flags = cl.map_flags.READ
    mapped: Any = cl.enqueue_map_buffer(queue, buffer, flags, 0, (nbytes,), np.dtype(np.uint8))[0]
    first = -(-mapped.ctypes.data // PAGE) * PAGE
    length = (mapped.ctypes.data + nbytes) // PAGE * PAGE - first
    mapped.base.release(queue)
    if length <= 0:
        return False
    madvise = ctypes.CDLL(None).madvise
    madvise.argtypes = (ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int)
    return int(madvise(first, length, advice)) == 0
