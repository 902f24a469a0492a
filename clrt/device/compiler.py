"""`python -m clrt.device.compiler`: what compiles kernels for another process (`clrt.device.beside`).

Kernels are launched on nothing: every buffer is zeros, every number 0, and so is that of what there is to do.
"""

from __future__ import annotations

import json
import os
import sys
import threading
from contextlib import suppress
from typing import Any, Final

from clrt import layout
from clrt.device.device import Device
from clrt.device.settings import Settings
from clrt.layout import parameters

_BYTES: Final = 1 << 20  # of each buffer: more than what kernels read before they see that there is nothing


def _compile(asked: dict[str, Any]) -> None:
    """Launch the kernels, from the last on. One that was compiled meanwhile costs nothing."""
    device = Device(asked["device"], Settings(**asked["settings"]), layout.RayFormat(**asked["rays"]))
    signatures = parameters.signatures(device.kernels.source)
    buffers: dict[str, Any] = {}
    for name in reversed(asked["needed"]):
        arguments = []
        for _, kind in signatures[name]:
            if not isinstance(kind, str):
                arguments.append(kind(0))
                continue
            if kind not in buffers:
                buffers[kind] = device.buffer(_BYTES, kind)
                device.fill(buffers[kind], _BYTES)
            arguments.append(buffers[kind])
        launch = device.launch_packets if asked["needed"][name] else device.launch
        launch(name, 1, *arguments)
    device.finish()


def _follow() -> None:
    """End with the process that started this one."""
    sys.stdin.buffer.read()
    os._exit(0)


def _main() -> None:
    asked = json.loads(sys.stdin.buffer.readline())
    threading.Thread(target=_follow, daemon=True).start()
    with suppress(Exception):  # who started this meets it, too
        _compile(asked)
    os._exit(0)


if __name__ == "__main__":
    _main()
