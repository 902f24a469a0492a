"""What is done before local workers are started: none hears the terminal, and none speaks at the end.

A terminal sends Ctrl-C to all processes, and workers import for seconds before `preload` is asked.
"""

from __future__ import annotations

import signal
import sys
from multiprocessing import resource_tracker
from typing import Any


def dask_setup(nanny: Any) -> None:
    """Called by dask in clrt's own process, in the thread whose threads start workers, also again.

    Those and the workers inherit what is blocked here; the main thread goes on hearing it.
    """
    if not hasattr(signal, "pthread_sigmask"):
        return
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGHUP})
    _start_tracker()
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # not before: the tracker's start unblocks it


def _start_tracker() -> None:
    """The process that removes what queues leave where clrt ends at once: it says so on standard error."""
    before = sys.warnoptions[:]
    sys.warnoptions.append("ignore")  # its command line's
    try:
        resource_tracker.ensure_running()
    finally:
        sys.warnoptions[:] = before
