"""The program may end while other threads are in calls: it ends well, and soon."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest

BEGIN = """
import clrt, threading, time, numpy as np
scene = clrt.load_dict({
    "camera": {"origin": [0, 1, 4], "target": [0, 0, 0], "width": 32, "height": 24},
    "lights": [{"type": "point", "position": [3, 5, 4]}],
    "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {"diffuse": 0.7}}]})
tracer = clrt.Tracer(scene)
image = tracer.render(width=500)
rays = np.zeros((200_000, 3)) + [0, 0, 5], np.zeros((200_000, 3)) + [0, 0, -1]
begun = threading.Event()

def spin():
    while True:
        begun.set()
        CALL

threading.Thread(target=spin, daemon=True).start()
begun.wait()
time.sleep(PAUSE)
END
"""
CALLS = {
    "render": "tracer.render(width=300)",
    "one long render": "tracer.render(width=8000, height=6000, spp=64)",
    "rays": "tracer.intersect(*rays)",
    "save": "image.save('a.png')",
    "whatever it raises": """
        try:
            tracer.render(width=300)
        except BaseException:
            pass""",
}  # fmt: skip


@pytest.mark.parametrize("end", ["", "raise SystemExit(0)"])
@pytest.mark.parametrize("name", CALLS)
def test_daemon_threads_end_first(name: str, end: str, tmp_path: Path) -> None:
    code = BEGIN.replace("CALL", CALLS[name]).replace("PAUSE", "0.2").replace("END", end)
    start = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=120
    )
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    assert time.perf_counter() - start < 60
    assert {file.name for file in tmp_path.iterdir()} <= {"a.png"}, "nothing half written is left"
