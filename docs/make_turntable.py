"""Render the showcase from all around on a local cluster, one of whose workers is killed on the way.

    python docs/make_turntable.py [--frames 120] [--workers 4]

writes docs/turntable.png, all frames small. It fails where a frame is not that of one process, bit for bit:
every tenth is rendered here, too. Prints how long it took and what was lost.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
import time
from pathlib import Path
from typing import Final

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))

import numpy as np  # noqa: E402
from PIL import Image as Pictures  # noqa: E402

import clrt  # noqa: E402
from clrt.cluster.connect import connected  # noqa: E402
from clrt.images.file import encode  # noqa: E402

SIZE: Final = {"width": 640, "height": 360, "spp": 1}
COLUMNS, CELL, GAP, PAPER = 12, (106, 60), 2, 24  # pixels; grey of 255
TENTH: Final = 10


def sheet(cells: list[np.ndarray]) -> Pictures.Image:
    """Small pictures in rows."""
    rows, width, height = -(-len(cells) // COLUMNS), CELL[0] + GAP, CELL[1] + GAP
    paper = Pictures.new("RGB", (COLUMNS * width + GAP, rows * height + GAP), (PAPER,) * 3)
    for number, cell in enumerate(cells):
        small = Pictures.fromarray(cell).resize(CELL, Pictures.Resampling.BOX)
        paper.paste(small, (GAP + number % COLUMNS * width, GAP + number // COLUMNS * height))
    return paper


def main() -> None:
    """Render, kill, compare, write."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--workers", type=int, default=4)
    options = parser.parse_args()
    scene = clrt.load("showcase")
    assert scene.camera is not None
    cameras = clrt.turntable(scene.camera, options.frames)
    cells, hashes, start = [], [], time.monotonic()
    with connected(f"local:{options.workers}", clrt.Settings(threads=1)) as (executor, settings):
        series = clrt.sweep(scene, {"camera": cameras}, executor=executor, settings=settings, **SIZE)
        for number, (_, image) in enumerate(series):
            if number == options.frames // 3:
                victim = next(iter(executor._client.run(os.getpid).values()))
                os.kill(victim, signal.SIGKILL)
                print(f"process {victim} was killed after {number + 1} frames", flush=True)
            cells.append(encode(image.pixels))
            hashes.append(image.hash)
    print(f"{len(cells)} frames in {time.monotonic() - start:.0f} s", flush=True)
    with clrt.Tracer(scene) as tracer:
        for number in range(0, options.frames, TENTH):
            assert tracer.render(**SIZE, camera=cameras[number]).hash == hashes[number], number
    sheet(cells).save(FOLDER / "turntable.png", optimize=True)


if __name__ == "__main__":
    main()
