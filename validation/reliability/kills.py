"""Killed at random: every output file is the old one or the complete new one.

A process saves two pictures in turn to the same .exr and .png, a checkpoint, and statistics, as fast as it
can. After a random time it is killed (SIGKILL) or interrupted (SIGINT); then each file must be one of the two
whole ones. What SIGKILL may leave besides is the temporary file that was being written. Python drops a
KeyboardInterrupt that is raised while it takes an object apart: then SIGINT is sent again, as a user would.
"""

from __future__ import annotations

import itertools
import json
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path

import numpy as np

from clrt.base.atomic import replacing
from clrt.base.errors import ClrtError
from clrt.engine.checkpoint import Checkpoint
from clrt.engine.picture import Picture
from clrt.engine.wavefront import RayCounts
from clrt.images.file import read_samples
from clrt.images.image import Image

from .figures import Figure, Tell, listed

_LONGEST = 0.08  # seconds until the signal: some ten rounds of saving
_PATIENCE, _TIMES = 5.0, 4  # seconds until it is sent again, and how often
_SAVER = (sys.executable, "-m", __name__)
_HEIGHT, _WIDTH = 120, 160
_TASK = {"scene": "none", "max_depth": "0", "spp": "1", "refinements": "0"}
_RANGES = {"image": (0.0, 1e30)}


def pictures() -> tuple[Image, Image]:
    """Two pictures that no mixture of their bytes looks like."""
    values = np.random.default_rng(1).random((2, _HEIGHT, _WIDTH, 3), np.float32)
    first, second = (Image(value) for value in values)
    return first, second


def run(count: int, tell: Tell) -> Figure:
    """End a process that saves, `count` times."""
    start = time.perf_counter()
    whole = pictures()
    sent: Counter[str] = Counter()
    found: list[str] = []
    again = 0
    with tempfile.TemporaryDirectory(prefix="clrt-kills-") as name:
        folder = Path(name)
        for number in range(count):
            chance = random.Random(number)
            how = chance.choice((signal.SIGKILL, signal.SIGINT))
            sent[how.name] += 1
            took = _round(folder, how, chance.uniform(0, _LONGEST))
            again += took > 1
            wrong = torn(folder, whole) + ([] if took else ["it does not end"])
            for file in folder.glob(".clrt-*"):
                file.unlink()
                wrong += [f"{file.name} is left"] if how == signal.SIGINT else []
            if wrong:
                found.append(f"round {number}, {how.name}: {', '.join(wrong)}")
            tell((number + 1) / count)
    detail = " and ".join(f"{number} times {how}" for how, number in sorted(sent.items()))
    detail += f" while .exr, .png, .json and checkpoint are written; {again} had to be sent again"
    return Figure(count, len(found), detail + listed(found), time.perf_counter() - start)


def _round(folder: Path, sent: signal.Signals, seconds: float) -> int:
    """Start a process that saves, and end it so many seconds after its first round; signals that this took, 0
    where none ended it."""
    with subprocess.Popen(
        [*_SAVER, str(folder)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    ) as process:
        assert process.stdout
        process.stdout.readline()
        time.sleep(seconds)
        for number in range(1, _TIMES + 1):
            process.send_signal(sent)
            with suppress(subprocess.TimeoutExpired):
                process.wait(_PATIENCE)
                return number
        process.kill()
        return 0


def save_for_ever(folder: Path) -> None:
    """Write the files again and again; say so once they have all been written."""
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job ignores it
    for number, image in enumerate(itertools.cycle(pictures())):
        image.save(folder / "a.exr")
        image.save(folder / "a.png")
        picture = Picture((0, 0, _WIDTH, _HEIGHT), _WIDTH, (), 3)
        (folder / "a.checkpoint").unlink(missing_ok=True) if number == 0 else None
        counts = RayCounts()
        saved = Checkpoint(folder / "a.checkpoint", _TASK, picture, counts, _RANGES)
        counts.generations[:] = [Counter(camera=_WIDTH * _HEIGHT)]
        picture.pixels[...] = image.pixels
        saved.done[...] = True
        saved.save()
        with replacing(folder / "a.json") as temporary:
            temporary.write_text(json.dumps({"hash": image.hash}))
        if number == 0:
            print("saved", flush=True)


def torn(folder: Path, whole: tuple[Image, Image]) -> list[str]:
    """The files that are neither the one nor the other picture's."""
    hashes = {image.hash for image in whole}
    png = {_encoded(image) for image in whole}
    picture = Picture((0, 0, _WIDTH, _HEIGHT), _WIDTH, (), 3)
    faults = []
    for name in ("a.exr", "a.png", "a.checkpoint", "a.json"):
        try:
            if name.endswith("checkpoint"):
                Checkpoint(folder / name, _TASK, picture, RayCounts(), _RANGES)
                good = Image(picture.pixels.copy()).hash in hashes
            elif name.endswith("json"):
                good = json.loads((folder / name).read_text())["hash"] in hashes
            elif name.endswith("png"):
                good = read_samples(folder / name).tobytes() in png
            else:
                good = Image(read_samples(folder / name)).hash in hashes
        except (ClrtError, OSError, ValueError, KeyError) as error:
            faults.append(f"{name}: {error}")
            continue
        if not good:
            faults.append(f"{name}: neither the old nor the new one")
    return faults


def _encoded(image: Image) -> bytes:
    """The samples of the .png of an image."""
    with tempfile.TemporaryDirectory(prefix="clrt-kills-") as name:
        return read_samples(image.save(Path(name) / "a.png")).tobytes()


if __name__ == "__main__":
    save_for_ever(Path(sys.argv[1]))
