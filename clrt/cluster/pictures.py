"""`clrt.render` and `clrt.sweep`, here or on an executor's workers, with the same bits."""

from __future__ import annotations

import os
from collections import Counter, deque
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack, closing
from copy import deepcopy
from dataclasses import fields
from itertools import count
from typing import Any, Final

import numpy as np

from clrt.base import arguments
from clrt.base.arguments import public
from clrt.base.errors import ClrtError
from clrt.base.places import At, known_keys
from clrt.cluster.farm import Farm, Task
from clrt.cluster.orders import Answer
from clrt.cluster.parcels import Parcel, packed
from clrt.cluster.pool import pool_of
from clrt.device import foreign
from clrt.device.settings import Settings
from clrt.engine.checkpoint import Checkpoint
from clrt.engine.coverage import manifests
from clrt.engine.foresight import Values, check_series
from clrt.engine.job import Job
from clrt.engine.picture import Picture
from clrt.engine.provenance import metadata, stats, wavelengths
from clrt.engine.queues import tile_rays
from clrt.engine.request import Request
from clrt.engine.sweep import check_once, checked, combinations
from clrt.engine.tiles import tiles
from clrt.engine.tracer import ON_DEVICE, Progress, Tracer
from clrt.engine.wavefront import RayCounts
from clrt.flatten.flatten import FlatScene, check_ceilings, flatten
from clrt.formats.shipped import as_scene
from clrt.images.image import Image
from clrt.scene.camera import Camera
from clrt.scene.scene import Scene, edited

_PIECES: Final = 4  # of a picture or of the pictures left, a worker: the last ones to end leave few idle
_LEAST: Final = 1 << 13  # rays of a piece: with fewer what is done for each shows
_SECONDS: Final = 1.0  # of an order: what is lost with a worker, and how often progress is told
_TILES: Final = 8  # of an order: with more little is left to gain


@public
def render(
    scene: Scene | Mapping[str, Any] | str | os.PathLike[str],
    width: int | None = None,
    height: int | None = None,
    spp: int | None = None,
    max_depth: int | None = None,
    device: int | str | None = None,
    layers: Sequence[str] = (),
    progress: Progress | None = None,
    settings: Settings | None = None,
    crop: tuple[int, int, int, int] | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    camera: Camera | Mapping[str, Any] | None = None,
    executor: Executor | None = None,
) -> Image:
    """The picture of a scene, a dict, a scene file or a shipped scene's name.

    `Tracer(scene, device, settings).render(...)`, which see for what each argument may be and what is raised.
    executor: a `concurrent.futures.Executor` whose workers do it (docs/cluster.md), tile by tile, with the
    same bits; `device` is then one of theirs. ClrtError names a worker that cannot or must not take part.
    """
    if executor is None:
        tracer = Tracer(scene, device, settings)
        return tracer.render(width, height, spp, max_depth, layers, progress, crop, checkpoint, camera)
    remote = Remote(executor, device, settings)
    asked = Request(width, height, spp, max_depth, layers, crop, camera)
    progress = arguments.function("progress", progress)
    kept = None if checkpoint is None else arguments.path("checkpoint", checkpoint)
    sheet = Sheet(*remote.plan(as_scene(scene, remote.settings.limits), asked), progress)
    with ExitStack() as stack:
        if kept is not None:
            sheet.saved = stack.enter_context(Checkpoint(kept, *sheet.saving()))
        (done,) = remote.sheets(iter([sheet]), 1)
    return done.image()


@public
def sweep(
    scene: Scene | Mapping[str, Any] | str | os.PathLike[str],
    changes: Mapping[str, Sequence[Any] | np.ndarray],
    device: int | str | None = None,
    settings: Settings | None = None,
    executor: Executor | None = None,
    **picture: Any,
) -> Iterator[tuple[Values, Image]]:
    """A picture for every combination of values: {"camera.fov": [20, 30], "materials.glass.ior": [1.3, 1.5]}.

    Gives (values, Image) one after the other, the last place changing fastest. Places are those of
    `Scene.replace`, and `"camera"` takes whole cameras. picture: as for `Tracer.render` (`width`, `spp`,
    `layers`, ...). All is looked at before the first picture (of up to 500 pictures each combination):
    SceneError names the place of a value that is wrong; ClrtError the values for which a picture would be
    refused ("changes['camera.spp'][1]: ..."), an argument that is wrong, and one that would go before values
    of the same thing. One Tracer does all, so that what does not change is done once; or the workers of
    `executor`, as for `render`, several pictures at a time.
    """
    base = as_scene(scene, arguments.optional_instance("settings", settings, Settings).limits)
    found = checked(base, changes)
    if picture.pop("checkpoint", None) is not None:
        raise ClrtError("checkpoint: it keeps one picture; a sweep has many")
    progress = arguments.function("progress", picture.pop("progress", None))
    known_keys(picture, [*(field.name for field in fields(Request)), "progress"], At("sweep"))
    check_once(base, found, picture, lambda name, place: (name, f"changes[{place!r}]"))
    asked, first = Request(**picture), edited(base, next(combinations(found)))
    if executor is not None:
        remote = Remote(executor, device, settings)
        _check_series(base, found, asked, remote.settings, (first, remote.flat_of(first)))
        return _there(remote, base, found, asked, progress)
    tracer = Tracer(first, device, settings)
    _check_series(base, found, asked, tracer.settings, (first, tracer.flat))
    return _here(tracer, base, found, picture | {"progress": progress})


def _check_series(
    base: Scene,
    changes: Mapping[str, Sequence[Any]],
    asked: Request,
    settings: Settings,
    known: tuple[Scene, FlatScene],
) -> None:
    """ClrtError where one of the pictures cannot be rendered; it names values by their place in `changes`."""
    series = [*combinations(changes)]

    def said(places: list[str], index: int) -> str:
        values = series[index]
        which = {p: next(k for k, value in enumerate(changes[p]) if value is values[p]) for p in places}
        return " and ".join(f"changes[{place!r}][{number}]" for place, number in which.items())

    check_series(base, series, asked, settings, said, known)


def _here(
    tracer: Tracer, base: Scene, changes: Mapping[str, Sequence[Any]], picture: Mapping[str, Any]
) -> Iterator[tuple[Values, Image]]:
    with tracer:
        for values in combinations(changes):
            tracer.update(edited(base, values))
            yield deepcopy(values), tracer.render(**picture)


def _there(
    remote: Remote,
    base: Scene,
    changes: Mapping[str, Sequence[Any]],
    asked: Request,
    progress: Progress | None,
) -> Iterator[tuple[Values, Image]]:
    many = [*combinations(changes)]
    sheets = (Sheet(*remote.plan(edited(base, values), asked), progress) for values in many)
    with closing(remote.sheets(sheets, len(many))) as done:
        for values, sheet in zip(many, done, strict=True):
            yield deepcopy(values), sheet.image()


Plan = tuple[Scene, Parcel, Job, tuple[int, int], tuple[int, int, int, int]]


class Sheet:
    """A picture that answers are put into: its job, which pixels it wants, and what it has."""

    def __init__(
        self,
        scene: Scene,
        parcel: Parcel,
        job: Job,
        full: tuple[int, int],
        window: tuple[int, int, int, int],
        progress: Progress | None = None,
    ) -> None:
        self.scene, self.parcel, self.job, self.full, self.window = scene, parcel, job, full, window
        self.progress = progress
        self.picture = Picture(window, full[0], job.layers, job.flat.bands)
        self.counts, self.saved = RayCounts(), None  # type: tuple[RayCounts, Checkpoint | None]
        self.left = self.total = window[2] * window[3]
        self._local_size = 0
        self._seconds: Counter[str] = Counter()
        self._kernels: set[str] = set()
        self._devices: set[str] = set()

    def saving(self) -> tuple[Any, ...]:
        """What `Checkpoint` asks for besides the file."""
        return self.job.identity(self.window), self.picture, self.counts, self.job.ranges()

    def pieces(self, size: int) -> Iterable[np.ndarray]:
        """Numbers of pixels, at most `size` of them together: all that are wanted."""
        found: Iterable[np.ndarray] = tiles(*self.full, self.window, size)
        if self.saved is not None:
            found = self.saved.unfinished(found)
            self.left = sum(map(len, found))
        return found

    def put(self, pixels: np.ndarray, answer: Answer) -> None:
        """Take what a worker has found for some of them."""
        self.picture.put(pixels, answer.layers)
        if self.saved is not None:
            self.saved.add(pixels, answer.rays)
        else:
            self.counts.merge(answer.rays)
        self._local_size = answer.local_size
        self._seconds.update(answer.seconds)
        self._kernels.add(answer.kernels)
        self._devices.add(answer.device)
        self.left -= len(pixels)
        if self.progress:
            self.progress(self.total - self.left, self.total, self.counts.traced)

    def image(self) -> Image:
        """The picture, of which all has come."""
        device, kernels = (", ".join(sorted(names)) for names in (self._devices, self._kernels))
        if not kernels:  # a checkpoint held all of it, made by the same ones
            device, kernels = "none: it was kept", foreign.source_hash(self.job.flat.ray_format)
        told = metadata(kernels, device, self.job.settings, self.job.flat)
        told |= manifests(self.scene, self.job.layers)
        made = stats(self.counts, self._local_size, dict(self._seconds), device)
        return Image(*self.picture.whole(), made, told, wavelengths(self.scene))


class Remote:
    """Plans pictures here, without a device, and has them made by an executor's workers."""

    def __init__(self, executor: object, device: int | str | None, settings: Settings | None) -> None:
        self.settings = arguments.optional_instance("settings", settings, Settings)
        self.farm = Farm(pool_of(executor), arguments.device("device", device))
        self._last: tuple[Scene, FlatScene, Parcel] | None = None
        self._pixels, self._seconds = 0.0, 0.0  # done by the last orders, and what they took workers

    def plan(self, scene: Scene, asked: Request) -> Plan:
        """A picture, checked as `Tracer.render` does."""
        flat, parcel = self._parcel_of(scene)
        return scene, parcel, *asked.job(scene, flat, self.settings)

    def flat_of(self, scene: Scene) -> FlatScene:
        """The scene, flattened; a plan of it does not do that again."""
        return self._parcel_of(scene)[0]

    def _parcel_of(self, scene: Scene) -> tuple[FlatScene, Parcel]:
        """Of the scene before is kept what this one has, too."""
        if self._last and all(getattr(scene, name) is getattr(self._last[0], name) for name in ON_DEVICE):
            flat, parcel = self._last[1:]
        else:
            flat = flatten(scene, self._last[:2] if self._last else None)
            check_ceilings(flat, scene.source)
            parcel = packed(flat)
        self._last = scene, flat, parcel
        return flat, parcel

    def sheets(self, sheets: Iterator[Sheet], most: int) -> Generator[Sheet]:
        """The sheets in their order, full, several filled at a time. most: how many there may be."""
        waiting: deque[Sheet] = deque()
        begun = count(1)

        def tasks() -> Iterator[Task]:
            for sheet in sheets:
                waiting.append(sheet)
                left = (most - next(begun)) * sheet.total  # of the pictures after it
                for pixels in self._joined(sheet.pieces(self._size(sheet, most)), sheet.left, left):
                    yield Task(sheet, sheet.job, sheet.parcel, pixels)

        with closing(self.farm.work(tasks())) as answers:
            for task, answer in answers:
                # soon forgotten: the first ones may have compiled kernels
                self._pixels = 0.75 * self._pixels + len(task.pixels)
                self._seconds = 0.75 * self._seconds + answer.wall - answer.setup
                task.owner.put(task.pixels, answer)
                while waiting and not waiting[0].left:
                    yield waiting.popleft()
        yield from waiting  # of which a checkpoint held all

    def _joined(self, pieces: Iterable[np.ndarray], left: int, after: int) -> Iterator[np.ndarray]:
        """Several pieces in one, which costs scheduler and client less, as long as that leaves `_PIECES` a
        worker of the pixels `left` in this picture and `after` it: so the last ones are small. None takes
        long, as far as those before tell. Workers cut them into tiles again."""
        together: list[np.ndarray] = []
        for piece in pieces:
            together.append(piece)
            have = sum(map(len, together))
            share = (left + after) // (_PIECES * self.farm.pool.workers)
            quick = int(_SECONDS * self._pixels / self._seconds) if self._seconds else 0
            if have + len(piece) > min(share, quick) or len(together) >= _TILES:
                left -= have
                yield np.concatenate(together) if len(together) > 1 else piece
                together = []
        if together:
            yield np.concatenate(together)

    def _size(self, sheet: Sheet, most: int) -> int:
        """Pixels of a piece: few pieces cost least, many leave no worker idle at the end."""
        samples = sheet.job.piece_samples
        tile = tile_rays(sheet.job.flat.ray_format, self.settings)
        pieces = -(-_PIECES * self.farm.pool.workers // most)
        even = -(-sheet.total * samples // pieces)
        # of two tiles one keeps many cores busy while the host looks at the other; to one core it is the same
        largest = tile if self.settings.threads == 1 else 2 * tile
        return max(1, min(max(even, _LEAST), largest) // samples)
