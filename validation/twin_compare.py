"""A device and the float32 twin, stage by stage: the first value that differs, by pass and ray."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, zip_longest

import numpy as np

from clrt import passes
from clrt.device import Device
from clrt.flatten import FlatScene, flatten, flatten_camera
from clrt.passes import Queue
from clrt.scene import Scene
from clrt.world import World

from . import twin_queues
from .twin import adopted, geometry
from .twin_device import LAYERS, device_stages
from .twin_film import Film, developed
from .twin_media import first_seen
from .twin_queues import generate
from .twin_wavefront import Stage, generations


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


def compare_picture(
    device: Device,
    scene: Scene,
    flat: FlatScene | None = None,
    width: int | None = None,
    height: int | None = None,
    spp: int | None = None,
    max_depth: int | None = None,
) -> Comparison:
    """Every stage of the picture that the scene's camera sees, in one tile."""
    assert scene.camera is not None
    flat = flat or flatten(scene)
    camera = flatten_camera(scene.camera, width, height, spp)
    pixels = np.arange(int(camera["width"][0]) * int(camera["height"][0]), dtype=np.uint32)
    samples = int(camera["grid"][0]) ** 2
    device = device.variant(flat.rays)
    queue, _ = passes.generate(device, device.upload(camera), pixels, samples)
    with np.errstate(all="ignore"):
        return _compare(
            device,
            flat,
            queue,
            generate(camera, pixels, flat.bands),
            len(pixels),
            samples,
            scene.max_depth if max_depth is None else max_depth,
        )


def compare_rays(
    device: Device,
    flat: FlatScene,
    origins: np.ndarray,
    directions: np.ndarray,
    t_max: float | np.ndarray = np.inf,
    max_depth: int = 0,
) -> Comparison:
    """Every stage of the caller's n rays: origins and directions (n, 3), t_max a number or (n,)."""
    o, d = (np.ascontiguousarray(array, np.float32) for array in (origins, directions))
    limit = np.array(np.broadcast_to(np.asarray(t_max, np.float32), (len(o),)))
    device = device.variant(flat.rays)
    queue = passes.adopt(device, o, d, limit, np.arange(len(o), dtype=np.uint32))
    with np.errstate(all="ignore"):
        return _compare(device, flat, queue, adopted(o, d, limit, bands=flat.bands), len(o), 1, max_depth)


def _compare(
    device: Device,
    flat: FlatScene,
    queue: Queue,
    twin: twin_queues.Queue,
    pixels: int,
    samples: int,
    max_depth: int,
) -> Comparison:
    film = Film(pixels, LAYERS, flat.bands)
    counts: list[Counter[str]] = []
    computed = device_stages(device, World(device, flat), queue, pixels, samples, max_depth)
    expected = chain(
        generations(flat, twin, max_depth, film, counts), _last_stages(flat, twin, film, samples, max_depth)
    )
    rays = values = 0
    for ours, theirs in zip_longest(computed, expected):
        assert ours is not None and theirs is not None and ours.name == theirs.name, (ours, theirs)
        difference = first_difference(ours, theirs)
        values += sum(array.size for array in theirs.values.values())
        rays += len(theirs.pixel_of) if theirs.name in ("closest", "feelers") else 0
        if difference:
            return Comparison(difference, rays, values)
    return Comparison(None, rays, values)


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
    here, there = (_text(stage.values[name][*row, ray]) for stage in (ours, theirs))
    label = name + "".join(f"[{i}]" for i in row)
    return Difference(*where, ray, int(theirs.pixel_of[ray]), label, here, there, count)


def _text(value: np.generic) -> str:
    if isinstance(value, np.floating):
        return float(value).hex()
    return hex(value) if isinstance(value, np.unsignedinteger) else str(value)


def _last_stages(
    flat: FlatScene, queue: twin_queues.Queue, film: Film, samples: int, max_depth: int
) -> Iterator[Stage]:
    place = np.arange(film.sums.shape[-1], dtype=np.uint32)
    means = film.sums / np.float32(samples)
    yield Stage("resolve", max_depth, "film", {"means": means}, place)
    if flat.response is not None:
        values = {"rows": developed(means, flat.response)}
        yield Stage("develop", max_depth, "film", values, place)
    seen = geometry(flat, queue, first_seen(flat, queue))
    values = {
        "depth": seen.t,
        "position": seen.position.T,
        "normal": seen.normal.T,
        "uv": np.stack([seen.u, seen.v]),
        "primitive": seen.primitive,
        "shape": seen.shape,
    }
    yield Stage(
        "geometry", 0, "camera", {name: array[..., ::samples] for name, array in values.items()}, place
    )
