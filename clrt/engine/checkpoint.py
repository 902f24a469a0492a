"""Long renders: the finished part of a picture in a file, from which a later render goes on.

The file is a numpy archive (.npz, whatever its name): the picture and its layers, which pixels are finished,
the ray counts, and what was rendered. It is replaced as a whole, so that a render that is killed while it
saves leaves the state before. Pixels do not depend on each other: what comes out has the bits of one render.

The render decides how large every part of the file must be; nothing is read by what the file says of itself.
"""

from __future__ import annotations

import io
import json
import os
import time
import zipfile
from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Final

import numpy as np

from clrt.base.atomic import check_replaceable, replacing
from clrt.base.errors import ClrtError
from clrt.engine.picture import Picture
from clrt.engine.queues import AMBIENT, REFLECTION, TRANSMISSION
from clrt.engine.wavefront import KINDS, RayCounts
from clrt.layout import ceilings

_SHARE: Final = 0.05  # of the time that saving may take
_MARK: Final = "clrt checkpoint 1"
_ADVICE: Final = "give another file, or remove this one"
_HEADER: Final = 128  # bytes that numpy writes before an array of bytes
_TOLD: Final = 1 << 18  # bytes: what texts and the counts of usual depths stay below
_GENERATION: Final = 512  # bytes of a generation's counts, whatever the numbers
_BLOCK: Final = 1 << 20  # bytes read at a time
_CHILDREN: Final = (1 << 16) + 2 * 64  # of a ray at most: ambient samples, and what dispersion makes of two


class Checkpoint:
    """Saves `picture` and `counts` while they grow; as a context, also when it is left, whatever the reason.

    `task` is what `Job.identity` gives, `ranges` what `Job.ranges` does. Where the file exists, picture and
    counts are filled from it; ClrtError when it belongs to another task, holds what that task cannot have
    made, is damaged, or cannot be written.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        task: dict[str, str],
        picture: Picture,
        counts: RayCounts,
        ranges: Mapping[str, tuple[float, float]],
    ) -> None:
        self.path, self.task, self.picture, self.counts = Path(path), task, picture, counts
        self.ranges = ranges
        self._adding: tuple[np.ndarray, list[Counter[str]]] | None = None  # pixels, and counts before
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

    def add(self, pixels: np.ndarray, rays: RayCounts) -> None:
        """Note that these pixels are in the picture, and count their rays; save now and then."""
        places = self.picture.places(pixels)
        self._adding = places, [Counter(row) for row in self.counts.generations]
        self.done.reshape(-1)[places] = True
        self.counts.merge(rays)
        self._adding = None
        self._unsaved = True
        if (time.monotonic() - self._last) * _SHARE >= self._took:
            self.save()

    def save(self) -> None:
        """Replace the file."""
        start = time.monotonic()
        if self._adding:  # and interrupted there: these pixels are not finished
            places, self.counts.generations[:] = self._adding
            self.done.reshape(-1)[places] = False
            self._adding = None
        arrays = self._arrays()
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
        arrays, depth = self._arrays(), int(self.task["max_depth"])
        most = _TOLD + _GENERATION * depth
        try:
            with zipfile.ZipFile(self.path) as archive:
                told = json.loads(_texts(archive, most).tobytes())
                if told["mark"] != _MARK:
                    raise ValueError("of another version")
                self._check_job(told["job"])
                rays = _counts(told["rays"], depth + 1)
                for name, array in arrays.items():
                    _fill(archive, name, array)
            self._check(rays)
        except ClrtError:
            raise
        except Exception:  # what is damaged can fail anywhere in zipfile or json, in words about their files
            raise ClrtError(f"{self.path}: is not a whole checkpoint of clrt; {_ADVICE}") from None
        self.counts.generations[:] = rays

    def _check(self, rays: list[Counter[str]]) -> None:
        """ValueError for numbers that the task cannot have made."""
        if (self.done.view(np.uint8) > 1).any():
            raise ValueError("neither finished nor not")
        for name, array in {"image": self.picture.pixels, **self.picture.layers}.items():
            least, most = self.ranges[name]
            if not (least <= array.min() and array.max() <= most):  # of a NaN neither is true
                raise ValueError("no light and no place")
        if not self._least <= sum(row["camera"] for row in rays) <= self._most:
            raise ValueError("not the rays of what is finished")

    @property
    def _least(self) -> int:
        """Camera rays of what is finished."""
        return int(self.task["spp"]) * int(np.count_nonzero(self.done))

    @property
    def _most(self) -> int:
        """The same where every pixel got all grids."""
        return self._least * sum(4**k for k in range(int(self.task["refinements"]) + 1))

    def _arrays(self) -> dict[str, np.ndarray]:
        """What the file holds besides texts and counts."""
        layers = {f"layer {name}": layer for name, layer in self.picture.layers.items()}
        return {"pixels": self.picture.pixels, "done": self.done, **layers}

    def _check_job(self, stored: dict[str, str]) -> None:
        for name in dict.fromkeys((*self.task, *stored)):  # some are there only where they are set
            now, then = self.task.get(name), stored.get(name)
            if then != now:
                if not (name.isprintable() and (then is None or then.isprintable())):
                    raise ValueError("not our words")
                change = f"{_short(name)} was {_short(then)}, is {_short(now)}"
                raise ClrtError(f"{self.path}: is the checkpoint of another render: {change}; {_ADVICE}")


def _short(text: str | None) -> str:
    return "not set" if text is None else (text or "none") if len(text) <= 40 else f"{text[:12]}..."


def _texts(archive: zipfile.ZipFile, most: int) -> np.ndarray:
    """The member whose length only the file knows: up to `most` bytes."""
    length = archive.getinfo("told.npy").file_size - _HEADER
    if not 0 <= length <= most:
        raise ValueError("of another size")
    array = np.empty(length, np.uint8)
    _fill(archive, "told", array)
    return array


def _fill(archive: zipfile.ZipFile, name: str, array: np.ndarray) -> None:
    """Read a member into an array; ValueError unless it is stored as `save` stores this very array."""
    info = archive.getinfo(f"{name}.npy")
    expected = _header(array)
    size = len(expected) + array.nbytes
    if info.compress_type != zipfile.ZIP_STORED or (info.file_size, info.compress_size) != (size, size):
        raise ValueError("of another size")
    with archive.open(info) as member:
        if member.read(len(expected)) != expected:
            raise ValueError("of another kind")
        place = memoryview(array.reshape(-1).view(np.uint8))  # type: ignore[arg-type]
        for start in range(0, len(place), _BLOCK):
            block = member.read(_BLOCK)
            place[start : start + len(block)] = block
        if member.read(1):  # at its end zipfile compares the sum of all
            raise ValueError("of another size")


def _header(array: np.ndarray) -> bytes:
    """What numpy writes before an array."""
    out = io.BytesIO()
    np.lib.format.write_array_header_1_0(out, np.lib.format.header_data_from_array_1_0(array))
    return out.getvalue()


def _counts(rows: Any, most: int) -> list[Counter[str]]:
    """The ray counts by generation; ValueError where they are none."""
    if not isinstance(rows, list) or len(rows) > most:
        raise ValueError("not a list of generations")
    for row in rows:
        if not isinstance(row, dict) or not all(type(n) is int and 0 <= n < 1 << 63 for n in row.values()):
            raise ValueError("not counts")
        if not row.keys() <= set(KINDS):
            raise ValueError("of other kinds")
    counts: list[Counter[str]] = [Counter(row) for row in rows]
    hits = 0
    for generation, row in enumerate(counts):
        children = row[REFLECTION] + row[TRANSMISSION] + row[AMBIENT]
        if (row["camera"] and generation) or children > hits * _CHILDREN:
            raise ValueError("rays from nowhere")
        if row["camera_hits"] != (0 if generation else row["hits"]) or row["hits"] > row["camera"] + children:
            raise ValueError("hits of no rays")
        hits = row["hits"]
        inside = row["total_internal_reflection"]
        if inside > hits * _CHILDREN or row["feelers"] > hits * ceilings.LIGHTS:
            raise ValueError("what follows no hit")
    return counts
