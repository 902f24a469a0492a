"""What local workers do first: leave Ctrl-C, which the terminal sends to all, and words to the client."""

from __future__ import annotations

import signal
import warnings
from typing import Any

from clrt.base.errors import ClrtWarning


def dask_setup(worker: Any) -> None:
    """Called by dask in the worker's main thread. The client ends its workers, however it ends itself."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    warnings.simplefilter("ignore", ClrtWarning)
