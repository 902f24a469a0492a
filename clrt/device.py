"""The OpenCL side: build the kernels, keep buffers, launch, read.

Nothing of a scene ever reaches the source or the build options, so the kernels compile once a machine: the
driver's own cache finds them again. Every call of the driver goes through `Device._guard`: a refusal is a
DeviceError.
"""

from __future__ import annotations

import copy
import hashlib
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache, cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np
import pyopencl as cl

from clrt import kernelcache, layout, parameters
from clrt.errors import DeviceError, MemoryLimitError
from clrt.platforms import check_process, choose, pocl_version
from clrt.resources import kernel_folder
from clrt.settings import Settings
from clrt.source import kernel_source
from clrt.tracks import Answer, Track, kept, seconds_by_name

TRACKS: Final = 2  # pieces of work that go on at the same time
_GROUP: Final = 64  # work-items of a work-group, unless the settings say otherwise
_SMALL_GRID: Final = 1 << 16  # PoCL compiles a kernel once more for more work-items than 16 bits can count
_waiting = ThreadPoolExecutor(1, "clrt-wait")


# Contexts and programs are kept for the process: they hold no state of a scene, and looking a program up in
# the driver's cache takes longer than a small picture.
@cache
def _context(device: cl.Device) -> cl.Context:
    return cl.Context([device])


@cache
def _program(context: cl.Context, source: str) -> cl.Program:
    options = ["-cl-std=CL1.2"]
    if context.devices[0].single_fp_config & cl.device_fp_config.CORRECTLY_ROUNDED_DIVIDE_SQRT:
        options.append("-cl-fp32-correctly-rounded-divide-sqrt")
    # PoCL keeps a cache of its own on disk, for other drivers pyopencl does
    return cl.Program(context, source).build(options)


@cache
def _thread_limited(device: cl.Device, threads: int | None) -> cl.Device:
    if threads is None or threads >= device.max_compute_units:
        return device
    by_counts = cl.device_partition_property.BY_COUNTS
    try:
        return device.create_sub_devices([by_counts, threads])[0]  # type: ignore[list-item]
    except cl.Error as error:
        raise DeviceError(
            f"{device.name}: cannot be limited to {threads} of its {device.max_compute_units} "
            f"compute units ({error}); leave out threads"
        ) from None


class Device:
    """An OpenCL device and the kernels built for it: owns context, tracks and program.

    `rays` is what the kernels' rays carry.
    """

    def __init__(
        self,
        wanted: int | str | None = None,
        settings: Settings | None = None,
        rays: layout.Rays | None = None,
        kernels: Path | None = None,
    ) -> None:
        self.settings = settings or Settings()
        self.rays = rays or layout.Rays()
        self._kernel_folder = kernels
        self.info, device = choose(wanted)
        if (self.settings.local_size or 1) > device.max_work_group_size:
            raise DeviceError(
                f"{self.info.label}: local_size {self.settings.local_size} is above its "
                f"{device.max_work_group_size}"
            )
        try:
            self.device = _thread_limited(device, self.settings.threads)
            self.context = _context(self.device)
            self._tracks = [Track(self.context, self.device) for _ in range(TRACKS)]
        except cl.Error as error:
            raise DeviceError(f"{self.info.label}: {error}") from None
        # PoCL 3.0's compiler hangs or aborts on float16; Oclgrind takes its upper half for uninitialised
        narrow = "Oclgrind" in self.info.platform or (0,) < pocl_version(self.info) < (3, 1)
        self.packet = 8 if narrow else self.settings.lanes
        self._variants: dict[layout.Rays, Device] = {self.rays: self}
        self._start()

    def _start(self) -> None:
        self.source = kernel_source(
            self.rays, self.settings.lanes, self.packet, self._kernel_folder or kernel_folder()
        )
        self._kernels: dict[str, cl.Kernel] = {}
        self._launched: set[tuple[str, int, bool]] = set()
        self._known: set[tuple[str, tuple[Any, ...]]] = set()  # kernels and kinds of arguments that fit
        self._spans: list[tuple[int, int, str]] = []
        self.use(0)

    def variant(self, rays: layout.Rays) -> Device:
        """This device with kernels for rays that carry this; tracks and memory are shared."""
        if rays not in self._variants:
            other = copy.copy(self)
            for name in ("program", "_cache_key"):
                other.__dict__.pop(name, None)
            other.rays = rays
            other._start()
            self._variants[rays] = other
        return self._variants[rays]

    def for_queue(self, narrow: bool) -> Device:
        """The kernels for a queue of such rays, on this device's track."""
        if narrow == self.rays.narrow:
            return self
        other = self.variant(replace(self.rays, narrow=narrow))
        other._track, other.queue, other.pool = self._track, self.queue, self.pool
        return other

    @property
    def bands(self) -> int:
        """Bands of the scene."""
        return self.rays.bands

    @property
    def media(self) -> int:
        """Places in a ray's list of media; 0: none."""
        return self.rays.media

    @property
    def kernel_hash(self) -> str:
        """SHA-256 of the program's source."""
        return hashlib.sha256(self.source.encode()).hexdigest()

    @cached_property
    def program(self) -> cl.Program:
        return self.build(self.source)

    def build(self, source: str) -> cl.Program:
        """Compile a program as the kernels are compiled. DeviceError with the driver's log."""
        check_process()
        with kernelcache.lock():
            try:
                return _program(self.context, source)
            except cl.Error:
                pass  # builds fail without a reason where a process outside clrt's lock compiles, too
            try:
                return _program(self.context, source)
            except cl.Error as error:
                raise DeviceError(
                    f"{self.info.label}: the kernels do not build: {error}; `clrt doctor` looks for the cause"
                ) from None

    def kernel(self, name: str, arguments: tuple[Any, ...]) -> cl.Kernel:
        """A kernel object for arguments of these types, looked up once: a lookup costs more than a launch.

        Told the types of its numbers beforehand, it takes them in a tenth of the time.
        """
        if name not in self._kernels:
            kernel = self._guard(lambda: cl.Kernel(self.program, name), f"kernel {name}")
            kernel.set_scalar_arg_dtypes([a.dtype if isinstance(a, np.generic) else None for a in arguments])
            self._kernels[name] = kernel
        return self._kernels[name]

    def use(self, track: int) -> None:
        """Put what comes on the track of that number, 0 to TRACKS - 1."""
        self._track = self._tracks[track]
        self.queue, self.pool = self._track.queue, self._track.pool

    @property
    def held_bytes(self) -> int:
        """Bytes of device memory in all pools, in use or kept for use."""
        held: int = 0
        for track in self._tracks:
            held += track.pool.managed_bytes
        return held

    def launch(self, name: str, items: int, *arguments: Any, local_size: int | None = None) -> None:
        """Run a kernel over `items` work-items, in work-groups of one size: by default the settings'.

        The last group is filled up with idle items, so kernels check their number. numpy scalars go by value.
        TypeError where the kernel's signature is another.
        """
        given = (name, parameters.kinds(arguments))
        if given not in self._known:
            parameters.check(self.source, *given)
            self._known.add(given)
        if items == 0:
            return
        check_process()
        local = local_size or self.settings.local_size or _GROUP
        kernel = self.kernel(name, arguments)
        total = -(-items // local) * local

        def enqueue() -> cl.Event:
            kernel.set_args(*arguments)
            return cl.enqueue_nd_range_kernel(self.queue, kernel, (total,), (local,))

        sizes = (name, local, total < _SMALL_GRID)
        if sizes in self._launched:
            event = self._guard(enqueue, f"kernel {name}")
        else:
            event = self._first_launch(enqueue, sizes)
        self._track.launched(name, event)

    def launch_packets(self, name: str, rays: int, *arguments: Any) -> None:
        """Run a kernel whose work-items take a packet of `rays` each.

        Unless the settings say how large, a work-group on a CPU is one work-item: PoCL gives each of a group
        private arrays of its own, and those of many packets (a value a band and ray) leave the caches.
        """
        alone = self.info.kind == "CPU" and self.settings.local_size is None
        self.launch(name, -(-rays // self.packet), *arguments, local_size=1 if alone else None)

    def _first_launch(self, enqueue: Callable[[], cl.Event], sizes: tuple[str, int, bool]) -> cl.Event:
        """A launch before which the driver may compile the kernel for these sizes: one process at a time."""
        with kernelcache.compiling("-".join(map(str, (self._cache_key, *sizes)))) as known:
            event = self._guard(enqueue, f"kernel {sizes[0]}")
            if not known:
                self._wait(event.wait, f"kernel {sizes[0]}")
        self._launched.add(sizes)
        return event

    @cached_property
    def _cache_key(self) -> str:
        return hashlib.sha256(f"{self.info.label} {self.source}".encode()).hexdigest()[:16]

    def buffer(self, nbytes: int, kind: str | None = None) -> Any:
        """Uninitialised device memory from the pool; freed when no longer referenced.

        `kind` is the C type of what it holds; kernels take no buffer of none.

        MemoryLimitError where all buffers together would pass the limit `device_bytes` (drivers promise more
        memory than there is, and fail when it is touched), and where the driver has no memory left.
        """
        check_process()
        pool, limits = self.pool, self.settings.limits
        size = max(nbytes, 4)
        # an allocation at most doubles what was asked for: only near the limit does its exact size matter
        if self.held_bytes + 2 * size > limits.device_bytes:
            block = pool.alloc_size(pool.bin_number(size))
            if self.held_bytes + block > limits.device_bytes:
                for track in self._tracks:
                    track.pool.free_held()
                limits.check("device_bytes", self.held_bytes + block)
        try:
            memory: Any = pool.allocate(size)
        except cl.MemoryError as error:
            raise MemoryLimitError(
                f"{self.info.label}: no memory for {nbytes} bytes more ({error}); use a smaller scene"
            ) from None
        except cl.Error as error:
            raise DeviceError(f"{self.info.label}: {nbytes} bytes: {error}") from None
        memory.kind = kind
        return memory

    def upload(self, array: np.ndarray, wait: bool = True, kind: str | None = None) -> Any:
        """A copy of an array on the device, as elements of that kind (None: those of the array).

        Without `wait` the array must stay as it is until it is there.
        """
        array = np.ascontiguousarray(array)
        target = self.buffer(array.nbytes, kind or parameters.element(array.dtype))
        self.write(target, array, wait)
        return target

    def write(self, target: Any, array: np.ndarray, wait: bool = True) -> None:
        """Copy an array to the start of a buffer; `wait` as for `upload`."""
        if array.nbytes and wait:
            self._wait(lambda: cl.enqueue_copy(self.queue, target, array, is_blocking=True), "upload")
        elif array.nbytes:
            self._guard(lambda: self._track.send(target, array), "upload")

    def ask(self, source: Any, array: np.ndarray) -> Answer:
        """Fill `array` from the start of a buffer, once all passes before it are done; does not wait."""
        if not array.nbytes:
            return Answer(array, None, self._wait)
        copied = self._guard(lambda: cl.enqueue_copy(self.queue, array, source, is_blocking=False), "read")
        return Answer(array, kept(copied), self._wait)

    def read(self, source: Any, array: np.ndarray) -> np.ndarray:
        """Fill `array` from the start of a buffer; waits for all passes before it."""
        return self.ask(source, array).wait()

    def fill(self, target: Any, nbytes: int, word: int = 0) -> None:
        """Fill the start of a buffer with one 32-bit integer."""
        if nbytes:
            pattern = np.array([word], np.int32)
            self._guard(lambda: cl.enqueue_fill_buffer(self.queue, target, pattern, 0, nbytes), "fill")

    def flush(self) -> None:
        """See to it that everything launched begins."""
        self._guard(self.queue.flush, "flush")

    def finish(self) -> None:
        """Wait for everything launched on the track in use, and note the time of each pass."""
        self._finish(self._track)

    def take_seconds(self) -> dict[str, float]:
        """Seconds by kernel since the last call, on all tracks."""
        for track in self._tracks:
            self._finish(track)
        spans, self._spans = self._spans, []
        return seconds_by_name(spans)

    def _finish(self, track: Track) -> None:
        self._wait(track.queue.finish, "finish")
        self._spans += track.take_spans()

    def _wait(self, action: Callable[[], Any], what: str) -> None:
        """Do something that returns when the device is done; Ctrl-C ends the wait at once.

        Python answers signals in its main thread, between two steps of it: so that one must not be in the
        driver. What is waited for goes on, and keeps its buffers and arrays until it is done.
        """
        check_process()
        if threading.current_thread() is threading.main_thread():
            self._guard(_waiting.submit(action).result, what)
        else:
            self._guard(action, what)

    def _guard(self, action: Callable[[], Any], what: str) -> Any:
        try:
            return action()
        except cl.Error as error:
            raise DeviceError(f"{self.info.label}: {what}: {error}") from None
