"""What local workers do first of all: leave Ctrl-C, which the terminal sends to all, to the client."""

from __future__ import annotations

import signal
from typing import Any


def dask_setup(worker: Any) -> None:
    """Called by dask in the worker's main thread. The client ends its workers, however it ends itself."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
