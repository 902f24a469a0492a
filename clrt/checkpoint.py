"""Long renders: the finished part of a picture in a file, from which a later render goes on.

The file is a numpy archive (.npz, whatever its name): the picture and its layers, which pixels are finished,
the ray counts, and what was rendered. It is replaced as a whole, so that a render that is killed while it
saves leaves the state before. Pixels do not depend on each other: what comes out has the bits of one render.
"""

from __future__ import annotations

import json
import os
import time
import zipfile
import zlib
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from typing import Final

import numpy as np

from clrt.atomic import check_replaceable, replacing
from clrt.errors import ClrtError
from clrt.picture import Picture
from clrt.wavefront import RayCounts

_SHARE: Final = 0.05  # of the time that saving may take
_MARK: Final = "clrt checkpoint 1"
_ADVICE: Final = "give another file, or remove this one"
_DAMAGE: Final = (
    OSError, ValueError, KeyError, TypeError, AttributeError, EOFError, zipfile.BadZipFile, zlib.error,
)  # fmt: skip


class Checkpoint:
    """Saves `picture` and `counts` while they grow; as a context, also when it is left, whatever the reason.

    `task` is what `Job.identity` gives. Where the file exists, picture and counts are filled from it;
    ClrtError when it belongs to another task, is damaged, or cannot be written.
    """

    def __init__(
        self, path: str | os.PathLike[str], task: dict[str, str], picture: Picture, counts: RayCounts
    ) -> None:
        self.path, self.task, self.picture, self.counts = Path(path), task, picture, counts
        self.done = np.zeros(picture.pixels.shape[:2], bool)
        self._unsaved = False
        self._took, self._last = 0.0, time.monotonic()
        check_replaceable(path)
        if self.path.exists():
            self._load()

    def unfinished(self, pieces: Iterable[np.ndarray]) -> list[np.ndarray]:
        """The pieces (numbers of pixels) without what is finished already."""
        done = self.done.reshape(-1)
        left = (pixels[~done[self.picture.places(pixels)]] for pixels in pieces)
        return [pixels for pixels in left if len(pixels)]

    def add(self, pixels: np.ndarray) -> None:
        """Note that these pixels are in the picture, and their rays in the counts; save now and then."""
        self.done.reshape(-1)[self.picture.places(pixels)] = True
        self._unsaved = True
        if (time.monotonic() - self._last) * _SHARE >= self._took:
            self.save()

    def save(self) -> None:
        """Replace the file."""
        start = time.monotonic()
        arrays = {"pixels": self.picture.pixels, "done": self.done}
        arrays |= {f"layer {name}": layer for name, layer in self.picture.layers.items()}
        told = {"mark": _MARK, "job": self.task, "rays": self.counts.generations}
        arrays["told"] = np.frombuffer(json.dumps(told).encode(), np.uint8)
        with replacing(self.path) as temporary, temporary.open("wb") as file:
            np.savez(file, **arrays)  # type: ignore[arg-type]
        self._unsaved = False
        self._last = time.monotonic()
        self._took = self._last - start

    def __enter__(self) -> Checkpoint:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._unsaved:
            self.save()

    def _load(self) -> None:
        try:
            with np.load(self.path, allow_pickle=False) as stored:
                told = json.loads(stored["told"].tobytes())
                if told["mark"] != _MARK:
                    raise ValueError("of another version")
                self._check_job(told["job"])
                self.done[...] = stored["done"]
                self.picture.pixels[...] = stored["pixels"]
                for name, layer in self.picture.layers.items():
                    layer[...] = stored[f"layer {name}"]
            self.counts.generations[:] = [Counter(rays) for rays in told["rays"]]
        except _DAMAGE:  # whose texts speak of numpy's files, not of ours
            raise ClrtError(f"{self.path}: is not a whole checkpoint of clrt; {_ADVICE}") from None

    def _check_job(self, stored: dict[str, str]) -> None:
        for name, now in self.task.items():
            then = stored.get(name)
            if then != now:
                change = f"{name} was {_short(then)}, is {_short(now)}"
                raise ClrtError(f"{self.path}: is the checkpoint of another render: {change}; {_ADVICE}")


def _short(text: str | None) -> str:
    return "unknown" if text is None else text if len(text) <= 40 else f"{text[:12]}..."
