"""How near the published pictures of the thesis program are, and what comes of each of its faults.

    python -m validation.thesis2011.check FOLDER [-o OUT] [--step N]

FOLDER has the program's scenes, `NAME.txt`, and its pictures, `NAME*.png`. For every pair: pixels of the
float64 tracer with the program's faults within 1/255, of clrt's picture within 2/255, and how many pixels
each fault changes. OUT gets a picture a scene: the published one, clrt's, and where they differ by more.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

import clrt
from clrt.images.file import encode

from .pictures import FAULTS, Program

WITH_FAULTS, OURS = 0.999, 0.99
"""Shares of pixels that must agree: the tracer's with faults within 1/255, clrt's within 2/255."""


@dataclass(frozen=True, eq=False)
class Pair:
    """A scene of the program and its picture, (h, w, 3) uint8."""

    name: str
    scene: clrt.Scene
    picture: np.ndarray


def pairs(folder: Path) -> list[Pair]:
    """The scenes of a folder that have a picture. A picture may be smaller than its scene says."""
    found = []
    for file in sorted(folder.glob("*.txt")):
        pictures = sorted(folder.glob(f"{file.stem}*.png"))
        if pictures:
            pixels = np.asarray(oiio.ImageBuf(str(pictures[0])).get_pixels(oiio.UINT8))[..., :3]
            height, width = pixels.shape[:2]
            found.append(Pair(file.stem, _sized(clrt.load(file), width, height), pixels))
    return found


def _sized(scene: clrt.Scene, width: int, height: int) -> clrt.Scene:
    """The scene with another size. The field of view stays; the middle of even sides is a pixel's corner."""
    table = scene.to_dict()
    shift = [0.0 if side % 2 else -0.5 for side in (width, height)]
    table["camera"] |= {"width": width, "height": height, "shift": shift}
    return clrt.load_dict(table, source=scene.source)


def differences(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(h, w) the largest difference of a pixel's bytes."""
    return np.asarray(np.abs(a.astype(int) - b).max(axis=-1))


def within(a: np.ndarray, b: np.ndarray, most: int) -> float:
    """Share of pixels whose bytes differ by `most` at most."""
    return float((differences(a, b) <= most).mean())


def main() -> int:
    """Compare, print, and return 1 where a share is missed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("-o", "--output", type=Path, metavar="OUT", help="folder for pictures")
    parser.add_argument("--step", type=int, default=1, help="trace every N-th row and column in float64")
    options = parser.parse_args()
    table = Table("scene", f"faults, of {WITH_FAULTS:.1%}", f"clrt, of {OURS:.0%}", *FAULTS)
    missed = False
    found = pairs(options.folder)
    with Progress(console=Console(stderr=True)) as progress:
        task = progress.add_task("tracing", total=len(found) * (2 + len(FAULTS)))
        for pair in found:
            part = pair.picture[:: options.step, :: options.step]
            faulty = Program(pair.scene, FAULTS).picture(options.step)
            ours = encode(clrt.render(pair.scene).pixels)
            progress.advance(task, 2)
            changed = []
            for fault in FAULTS:
                without = Program(pair.scene, FAULTS.keys() - {fault}).picture(options.step)
                changed.append(f"{(differences(without, faulty) > 2).mean():.4%}")
                progress.advance(task)
            shares = within(faulty, part, 1), within(ours, pair.picture, 2)
            missed |= shares[0] < WITH_FAULTS or shares[1] < OURS
            table.add_row(pair.name, *(f"{share:.4%}" for share in shares), *changed)
            if options.output:
                _save(options.output / f"{pair.name}.png", pair.picture, ours)
    Console(width=max(160, Console().width)).print(table)
    return int(missed)


def _save(path: Path, published: np.ndarray, ours: np.ndarray) -> None:
    """The two pictures and, in white on the darkened second, where they differ by more than 2/255."""
    marked = ours // 4
    marked[differences(published, ours) > 2] = 255
    row = np.concatenate([published, ours, marked], axis=1)
    buffer = oiio.ImageBuf(oiio.ImageSpec(row.shape[1], row.shape[0], 3, "uint8"))
    buffer.set_pixels(oiio.ROI(), np.ascontiguousarray(row))
    path.parent.mkdir(parents=True, exist_ok=True)
    buffer.write(str(path))


if __name__ == "__main__":
    sys.exit(main())
