"""The user's browser, where there is one."""

from __future__ import annotations

import os
import sys
import threading
import webbrowser
from typing import Final

_FAULTS: Final = (webbrowser.Error, ValueError, OSError)
_SOON: Final = 0.5  # seconds within which a browser that cannot be started says so


def opens(address: str) -> bool:
    """Let a browser show it; False where none is found, or it soon fails. One within the terminal is not
    taken.

    BROWSER may say anything: a quote that nothing ends is a ValueError of `webbrowser`.
    """
    if sys.platform not in ("darwin", "win32") and not os.environ.get("BROWSER"):
        if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            return False
    try:
        browser = webbrowser.get()
    except _FAULTS:
        return False
    shown: list[bool] = []

    def show() -> None:
        try:
            shown.append(browser.open(address))
        except _FAULTS:
            shown.append(False)

    thread = threading.Thread(target=show, daemon=True)
    thread.start()
    thread.join(_SOON)  # no longer: some wait until their window is closed
    return all(shown)
