"""`python -m clrt.device.attempt NUMBER`: what goes wrong when a device builds one small kernel, if anything.

In a process of its own (`clrt.device.trial`), since a driver may end or hang it.
"""

from __future__ import annotations

import sys
from contextlib import suppress
from typing import Final
from zlib import crc32

import numpy as np

from clrt.base.errors import ClrtError
from clrt.device.binaries import quietly
from clrt.device.opencl import cl
from clrt.device.platforms import listed
from clrt.device.trial import DONE, LISTING, circumstances, plain

# Under other circumstances it is another program, that no cache of the driver's has: by the number of a
# work-item that there is not.
_OTHER: Final = 1000 + crc32(ascii(circumstances()).encode()) % (1 << 30)
_SOURCE: Final = (
    "__kernel void trial(__global float *x) { int i = get_global_id(0); "
    f"x[i] = i == {_OTHER} ? 0 : 2 * i + 1; }}"
)


def _try(number: int) -> str:
    """What goes wrong with a device in this process."""
    try:
        device = listed()[number][1]
        if device.max_work_group_size < 1:
            return "error: its largest work-group is of 0 work-items"
        context = cl.Context([device])
        queue = cl.CommandQueue(context)
        kernel = cl.Kernel(quietly(context, cl.Program(context, _SOURCE), ["-cl-std=CL1.2"]), "trial")
        found = np.zeros(64, np.float32)
        buffer = cl.Buffer(context, cl.mem_flags.READ_WRITE, found.nbytes)
        kernel(queue, found.shape, (1,), buffer)  # a driver may be told to take no more
        cl.enqueue_copy(queue, found, buffer)
    except cl.Error as error:
        return str(error)
    right = np.array_equal(found, 2 * np.arange(64, dtype=np.float32) + 1)
    return "" if right else "error: 2 x + 1 comes out wrong"


def _list() -> str:
    """What goes wrong where all drivers are asked for their devices, in this process."""
    with suppress(ClrtError):  # there is none: whoever asks then is told so
        listed()
    return ""


if __name__ == "__main__":
    fault = _list() if sys.argv[1] == LISTING else _try(int(sys.argv[1]))
    print(plain(fault) if fault else "")
    print(DONE, file=sys.stderr)
    sys.exit(1 if fault else 0)
