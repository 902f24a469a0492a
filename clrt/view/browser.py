"""The user's browser, where there is one."""

from __future__ import annotations

import os
import sys
import threading
import webbrowser


def opens(address: str) -> bool:
    """Let a browser show it; False where none is found. One within the terminal is not taken."""
    if sys.platform not in ("darwin", "win32") and not os.environ.get("BROWSER"):
        if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            return False
    try:
        browser = webbrowser.get()
    except webbrowser.Error:
        return False
    # some wait until their window is closed
    threading.Thread(target=browser.open, args=(address,), daemon=True).start()
    return True
