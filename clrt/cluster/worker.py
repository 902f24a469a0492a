"""What a worker does: `work`, for one order. Between orders it keeps its device and the scenes it has.

It holds no more than that: a worker that is new, or has been started again, says what it lacks.
"""

from __future__ import annotations

import copy
import hashlib
import os
import socket
import sys
import threading
import time
from collections import OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import cache
from typing import Any, Final
from weakref import WeakValueDictionary

import numpy as np

from clrt import layout
from clrt.base.errors import ClrtError, DeviceError, MemoryLimitError, exhausted
from clrt.base.resources import validation_module
from clrt.cluster.orders import Answer, Lacking, Order, Refusal, Worker, sealed
from clrt.cluster.parcels import LARGE, digest, unpacked
from clrt.device import cachelock, foreign, trial
from clrt.device.device import Device
from clrt.device.settings import Settings
from clrt.engine.job import Job
from clrt.engine.wavefront import RayCounts
from clrt.engine.world import World
from clrt.flatten.flatten import FlatScene
from clrt.version import __version__

_SCENES: Final = 4  # that a worker keeps: frames of a series come nearly in order
_BYTES: Final = 1 << 30  # of their arrays together; one scene may have more
_TREE: Final = ("boxes", "finite", "triangles", "spheres")  # arrays of which the tree is made

_lock = threading.Lock()  # orders are done one after the other: one has all cores that its settings allow


def work(order: Order) -> Answer | Lacking | Refusal:
    """Do an order. Whatever is wrong is in the answer, with the worker's name, and never raised."""
    with doing() as task:
        try:
            task.answer = _bench().done(order, task.me)
        except _Lacks as lacks:
            task.answer = Lacking(task.me, lacks.arrays)
    return task.answer


@dataclass
class Doing:
    """Something that a worker does: who it is, and what it will have answered."""

    me: Worker
    answer: Any = None


@contextmanager
def doing() -> Iterator[Doing]:
    """One task after the other. What is wrong with one becomes its answer: a Refusal."""
    task = Doing(_myself())
    try:
        with _lock, np.errstate(all="ignore"):
            yield task
    except ClrtError as error:
        task.answer = Refusal(task.me, error)
    except (MemoryError, OSError, RuntimeError, ImportError) as error:
        spent = exhausted(error)
        task.answer = Refusal(task.me, ClrtError(spent or f"{type(error).__name__}: {error}"))


class _Lacks(Exception):
    def __init__(self, arrays: tuple[str, ...]) -> None:
        self.arrays = arrays


@dataclass(frozen=True, eq=False)
class _Scene:
    flat: FlatScene
    device: Device
    world: World


class _Bench:
    """What a worker keeps: devices that are open, and scenes on them, the longest unused first."""

    def __init__(self) -> None:
        self.devices: dict[tuple[int | str | None, Settings], Device] = {}
        self.scenes: OrderedDict[tuple[str, int | str | None, Settings], _Scene] = OrderedDict()
        self.arrays: WeakValueDictionary[str, np.ndarray] = WeakValueDictionary()  # held by the scenes
        self.orders = 0

    def done(self, order: Order, me: Worker) -> Answer:
        """The answer to an order; _Lacks, or a ClrtError that says why there is none."""
        start = time.perf_counter()
        if order.version != __version__:
            raise ClrtError(f"it has clrt {__version__}, the client {order.version}; install the same")
        scene = self._scene(order)
        ready = time.perf_counter()
        what = order.camera, order.layers, order.settings, order.adaptive, order.mattes
        job = Job(scene.flat, order.max_depth, *what)
        with scene.device.driver.timed() as seconds:
            try:
                layers, rays, local_size = _traced(job, scene, order.pixels)
            except MemoryLimitError:  # alone there may be room
                self._keep(0)
                scene = self._scene(order)
                layers, rays, local_size = _traced(job, scene, order.pixels)
        device, now = scene.device, time.perf_counter()
        self.orders += 1
        return Answer(
            me, layers, rays, local_size, device.kernels.hash, device.info.label,
            seconds, now - start, ready - start, self.orders,
            sealed(order, layers, rays, local_size),
        )  # fmt: skip

    def _scene(self, order: Order) -> _Scene:
        """The scene of an order on its device; made where it is not known yet."""
        key = order.scene, order.device, order.settings
        if key in self.scenes:
            self.scenes.move_to_end(key)
            return self.scenes[key]
        arrays = self._arrays(order)
        flat = unpacked(order.scene, order.recipe, arrays)
        check_kernels(flat.ray_format, order.kernels)
        device = self._device(order, flat)
        try:
            made = _Scene(flat, device, self._world(device, flat))
        except MemoryLimitError:
            self._keep(0)
            made = _Scene(flat, device, World(device, flat))
        self.scenes[key] = made
        self.arrays.update(arrays)
        self._keep(_SCENES)
        return made

    def _arrays(self, order: Order) -> dict[str, np.ndarray]:
        for name, array in order.arrays.items():
            if digest(array) != name:
                raise ClrtError("an array has changed on its way; is the network's memory sound?")
        known = {name: order.arrays.get(name, self.arrays.get(name)) for name in order.needs}
        missing = tuple(name for name, array in known.items() if array is None)
        if missing or not order.recipe:
            raise _Lacks(missing)
        return {name: array for name, array in known.items() if array is not None}

    def _device(self, order: Order, flat: FlatScene) -> Device:
        """A device whose arithmetic has been found right, with the kernels for the scene's rays."""
        key = order.device, order.settings
        if key not in self.devices:
            device = Device(order.device, order.settings, flat.ray_format)
            check(device)
            self.devices = {key: device}  # of one client at a time
        return self.devices[key].variant(flat.ray_format)

    def _world(self, device: Device, flat: FlatScene) -> World:
        """The scene on the device. What another one has there of the same arrays is shared, the tree too."""
        for other in reversed(self.scenes.values()):
            alike = all(_same(getattr(other.flat, name), getattr(flat, name)) for name in _TREE)
            if alike and other.device.driver is device.driver and other.flat.ray_format == flat.ray_format:
                world = copy.copy(other.world)
                world.update(device, flat)
                return world
        return World(device, flat)

    def _keep(self, most: int) -> None:
        """Forget the scenes that were not used for longest, until so many are left, of so many bytes."""
        while len(self.scenes) > most or (len(self.scenes) > 1 and self._bytes() > _BYTES):
            self.scenes.popitem(last=False)

    def _bytes(self) -> int:
        arrays = (
            value
            for scene in self.scenes.values()
            for value in (getattr(scene.flat, entry.name) for entry in fields(scene.flat))
            if isinstance(value, np.ndarray)
        )
        return sum({id(array): array.nbytes for array in arrays}.values())


def _same(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two arrays are one; small ones, which come with each scene, whether they hold the same."""
    if one is other:
        return True
    return one.nbytes < LARGE and one.shape == other.shape and one.tobytes() == other.tobytes()


@cache
def _bench() -> _Bench:
    return _Bench()


def count() -> None:
    """One more thing is done: a call, too, is an order."""
    _bench().orders += 1


@cache
def proven(wanted: int | str | None) -> str:
    """The label of a device whose arithmetic has been found right. DeviceError where it was not."""
    device = Device(wanted)
    check(device)
    return device.info.label


def check_kernels(ray_format: layout.RayFormat, wanted: str) -> None:
    """ClrtError where the kernels of this process are not those, by `foreign.source_hash`."""
    found = foreign.source_hash(ray_format)
    if found != wanted:
        both = f"{found[:12]}, not {wanted[:12]}"
        same = f"install the same clrt, and set {foreign.VARIABLE} alike"
        raise ClrtError(f"its kernels are others: {both}; {same}")


def _traced(job: Job, scene: _Scene, pixels: np.ndarray) -> tuple[dict[str, np.ndarray], RayCounts, int]:
    """Layers, counts and the size of work-groups of some pixels, in their order."""
    layers: dict[str, np.ndarray] = {}
    rays, local_size = RayCounts(), 0
    pieces = list(_cut(pixels, max(1, job.tile_rays // job.piece_samples)))
    places = {id(piece): slice(start, start + len(piece)) for start, piece in pieces}
    for part, found in job.tiles(scene.device, scene.world, [piece for _, piece in pieces]):
        place: Any = places.get(id(part))
        if place is None:  # half of a piece that was too large
            order = np.argsort(pixels)
            place = order[np.searchsorted(pixels, part, sorter=order)]
        for name, values in found.layers.items():
            if name not in layers:
                layers[name] = np.empty((len(pixels), *values.shape[1:]), values.dtype)
            layers[name][place] = values
        rays.merge(found.rays)
        local_size = found.local_size
    return layers, rays, local_size


def _cut(pixels: np.ndarray, size: int) -> Iterator[tuple[int, np.ndarray]]:
    for start in range(0, len(pixels), size):
        yield start, pixels[start : start + size]


def check(device: Device) -> None:
    """DeviceError where a device fails the quick self-test, made once for a driver and these kernels.

    The verdict is kept as that of a driver's trial is, so that the workers of a machine make it once.
    """
    what = f"selftest {__version__} {foreign.source_hash(layout.RayFormat())}"
    key = hashlib.sha256(f"{what} {device.info.label} {device.info.driver}".encode()).hexdigest()
    with cachelock.lock(name=f"selftest-{key[:16]}"):
        fault = trial.kept_verdict(f"selftest-{key}", device.info.label, lambda: _fault(device))
    if fault:
        raise DeviceError(f"{device.info.label}: fails the self-test: {fault}; see `clrt selftest`")


def _fault(device: Device) -> str:
    """The first check of the quick self-test that fails; '' where none does."""
    for result in validation_module("selftest").run_selftest(device.info.index, quick=True):
        if not result.passed:
            return f"{result.name}: {result.detail}"
    return ""


def _myself() -> Worker:
    """This process; asked anew each time, for it may have been forked."""
    address = ""
    distributed = sys.modules.get("distributed")
    if distributed is not None:
        try:
            address = str(distributed.get_worker().address)
        except (ValueError, AttributeError):  # this process is none of its workers
            address = ""
    return Worker(socket.gethostname(), os.getpid(), address)
