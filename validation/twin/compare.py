"""A device and the float32 twin, stage by stage: the first value that differs, by pass and ray."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np

from clrt import layout
from clrt.device.device import Device
from clrt.engine import stage
from clrt.engine.job import Job
from clrt.engine.schedule import complete
from clrt.engine.world import World
from clrt.flatten.flatten import FlatScene, flatten, flatten_camera
from clrt.scene.scene import Scene

from . import queues as twin_queues
from .film import Film, developed
from .media import first_seen
from .picture import adopted, geometry_layers
from .queues import generate
from .wavefront import SPAWNING, Stage, generations

LAYERS = (
    "direct",
    "reflection",
    "transmission",
    "generation_0",
    "emission",
    "ambient",
    "diffuse",
    "highlight",
)


@dataclass(frozen=True)
class Difference:
    """The first value of the first pass that is not the same.

    `ray` counts in the pass's queue; -1: already the number of rays differs. `pixel` is the number of its
    pixel, or of the caller's ray; `count` how many values of the pass differ.
    """

    name: str
    generation: int
    kind: str
    ray: int
    pixel: int
    value: str
    device: str
    twin: str
    count: int
    expected_bits: int = 0  # the twin's value as a uint32

    def __str__(self) -> str:
        where = f"pass {self.name}, generation {self.generation}, {self.kind}"
        if self.ray < 0:
            return f"{where}: {self.device} rays on the device, {self.twin} in numpy"
        return (
            f"{where} ray {self.ray} (pixel {self.pixel}): {self.value} is {self.device} on the device, "
            f"{self.twin} in numpy; {self.count} values of this pass differ"
        )


@dataclass(frozen=True)
class Comparison:
    """How many rays (shadow feelers included) and values were compared, up to the first pass that differs."""

    difference: Difference | None
    rays: int
    values: int
    stage: stage.Stage | None = None  # that differs


def compare_picture(
    device: Device,
    scene: Scene,
    flat: FlatScene | None = None,
    width: int | None = None,
    height: int | None = None,
    spp: int | None = None,
    max_depth: int | None = None,
    observe: stage.Observer | None = None,
) -> Comparison:
    """Every stage of the picture that the scene's camera sees, in one tile.

    observe: is told of every stage that is the same.
    """
    assert scene.camera is not None
    flat = flat or flatten(scene)
    camera = flatten_camera(scene.camera, width, height, spp)
    pixels = np.arange(int(camera["width"][0]) * int(camera["height"][0]), dtype=np.uint32)
    depth = scene.max_depth if max_depth is None else max_depth
    device = device.variant(flat.ray_format)
    job = Job(flat, depth, camera, (*LAYERS, "position"), device.settings)
    with np.errstate(all="ignore"):
        return _compare(device, job, pixels, generate(camera, pixels, flat.bands), observe)


def compare_rays(
    device: Device,
    flat: FlatScene,
    origins: np.ndarray,
    directions: np.ndarray,
    t_max: float | np.ndarray = np.inf,
    max_depth: int = 0,
    observe: stage.Observer | None = None,
) -> Comparison:
    """Every stage of the caller's n rays: origins and directions (n, 3), t_max a number or (n,).

    observe: as for `compare_picture`.
    """
    o, d = (np.ascontiguousarray(array, np.float32) for array in (origins, directions))
    limit = np.array(np.broadcast_to(np.asarray(t_max, np.float32), (len(o),)))
    device = device.variant(flat.ray_format)
    job = Job(flat, max_depth, None, (*LAYERS, "position"), device.settings)
    rays = o, d, limit, np.arange(len(o), dtype=np.uint32)
    with np.errstate(all="ignore"):
        return _compare(device, job, rays, adopted(o, d, limit, bands=flat.bands), observe)


class Lockstep:
    """An observer that compares each stage of the device with the twin's; raises _Differs at the first."""

    def __init__(self, expected: Iterator[Stage]) -> None:
        self._expected = expected
        self.rays = self.values = 0
        self.last: stage.Stage | None = None

    def __call__(self, seen: stage.Stage) -> None:
        self.last = seen
        for ours in twin_stages(seen):
            theirs = next(self._expected, None)
            if theirs is None or _key(theirs) != _key(ours):
                twins = theirs is not None and theirs.name in SPAWNING.values()
                raise _Differs(_without_rays(theirs if theirs and twins else ours, twins))
            self.values += sum(array.size for array in theirs.values.values())
            self.rays += len(theirs.pixel_of) if theirs.name in ("closest", "feelers") else 0
            if difference := first_difference(ours, theirs):
                raise _Differs(difference)

    def end(self) -> None:
        """To be called when the device is done: the twin must be, too."""
        if theirs := next(self._expected, None):
            raise _Differs(_without_rays(theirs, True))


def _compare(
    device: Device,
    job: Job,
    piece: np.ndarray | tuple[np.ndarray, ...],
    queue: twin_queues.Queue,
    observe: stage.Observer | None,
) -> Comparison:
    pixels = len(queue) // job.samples
    weighed = None if job.camera is None else twin_queues.weights(job.camera, np.asarray(piece))
    film = Film(pixels, LAYERS, job.flat.bands, weighed)
    counts: list[Counter[str]] = []
    stages = generations(job.flat, queue, job.max_depth, film, counts)
    eye = np.zeros(1, layout.dtype("Camera")) if job.camera is None else job.camera
    watch = Lockstep(chain(stages, _last_stages(job.flat, queue, film, job.samples, eye)))
    try:
        observers = (watch,) if observe is None else (watch, observe)
        complete(job.trace(device, World(device, job.flat), piece, observers))
        watch.end()
    except _Differs as found:
        return Comparison(found.difference, watch.rays, watch.values, watch.last)
    return Comparison(None, watch.rays, watch.values)


def twin_stages(seen: stage.Stage) -> Iterator[Stage]:
    """What a pass of the device wrote as the twin has it: under names of kernels, feelers by their ray."""
    values, queue = seen.values(), seen.queue
    names = {"spawn": SPAWNING.get(seen.kind, ""), "adopt": "generate"}
    at, name = (seen.generation, seen.kind), names.get(seen.name, seen.name)
    place = values["pixel_of"] if "pixel_of" in values else queue.words(queue.pixel_of)
    if name == "closest":
        met = {key: values.pop(key) for key in ("t", "primitive")}
        yield Stage(name, *at, met, place)
        name = "surface"
    elif name == "feelers":
        owner = values.pop("owner")
        by_ray = np.argsort(owner, kind="stable")
        values = {key: array[..., by_ray] for key, array in values.items()}
        place = place[owner[by_ray]]
    elif name == "illuminate":
        values.pop("spawn")
    elif name == "geometry":
        values = {key: array.T for key, array in values.items()}
    elif name == "develop":
        values = {key: np.ascontiguousarray(array.transpose(0, 2, 1)) for key, array in values.items()}
    if name in ("gather", "resolve", "develop", "geometry"):
        place = np.arange(next(iter(values.values())).shape[-1], dtype=np.uint32)
    yield Stage(name, *at, values, place, seen.term)


class _Differs(Exception):
    def __init__(self, difference: Difference) -> None:
        self.difference = difference


def _key(stage: Stage) -> tuple[str, int, str, str]:
    return stage.name, stage.generation, stage.kind, stage.term


def _without_rays(stage: Stage, twins: bool) -> Difference:
    """A stage that only the twin has, or only the device."""
    n = ("0", str(len(stage.pixel_of)))
    return Difference(stage.name, stage.generation, stage.kind, -1, -1, "rays", *(n if twins else n[::-1]), 1)


def first_difference(ours: Stage, theirs: Stage) -> Difference | None:
    """Of the device's stage and the twin's. Any NaN equals any other."""
    where = ours.name, ours.generation, ours.kind
    if len(ours.pixel_of) != len(theirs.pixel_of):
        return Difference(*where, -1, -1, "rays", str(len(ours.pixel_of)), str(len(theirs.pixel_of)), 1)
    found: list[tuple[int, str, tuple[int, ...]]] = []  # ray, value, component
    count = 0
    for name, a in ours.values.items():
        b = theirs.values[name]
        assert a.dtype == b.dtype, f"{where} {name}: {a.dtype} on the device, {b.dtype} in numpy"
        unequal = np.ascontiguousarray(a).view(np.uint32) != np.ascontiguousarray(b).view(np.uint32)
        unequal &= ~(np.isnan(a) & np.isnan(b))
        at = np.argwhere(unequal)
        count += len(at)
        if len(at):
            *row, ray = at[at[:, -1].argmin()].tolist()
            found.append((ray, name, tuple(row)))
    if not found:
        return None
    ray, name, row = min(found, key=lambda entry: entry[0])
    here, there = (stage.values[name][*row, ray] for stage in (ours, theirs))
    label = name + "".join(f"[{i}]" for i in row)
    bits = int(np.asarray(there).view(np.uint32))
    return Difference(*where, ray, int(theirs.pixel_of[ray]), label, _text(here), _text(there), count, bits)


def _text(value: np.generic) -> str:
    if isinstance(value, np.floating):
        return float(value).hex()
    return hex(value) if isinstance(value, np.unsignedinteger) else str(value)


def _last_stages(
    flat: FlatScene, queue: twin_queues.Queue, film: Film, samples: int, camera: np.ndarray
) -> Iterator[Stage]:
    place = np.arange(len(queue) // samples, dtype=np.uint32)
    found = geometry_layers(flat, queue, first_seen(flat, queue), camera)
    values = {name: array[..., ::samples] for name, array in found.items()}
    yield Stage("geometry", 0, "camera", values, place)
    means = film.resolved(samples)
    place = np.arange(means.shape[-1], dtype=np.uint32)
    yield Stage("resolve", 0, "camera", {"sums": means}, place)
    rows = means if flat.response is None else developed(means, flat.response)
    yield Stage("develop", 0, "camera", {"rows": rows}, place)
