"""What passes run on: kernels for one format of rays, on one track of a driver."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np

from clrt import layout
from clrt.base.errors import DeviceError, MemoryLimitError
from clrt.device import cachelock
from clrt.device.driver import TRACKS, Driver
from clrt.device.opencl import cl
from clrt.device.platforms import check_process, pocl_version
from clrt.device.settings import Settings
from clrt.device.timeline import now
from clrt.device.tracks import Answer, kept
from clrt.layout import ceilings, parameters

__all__ = ["TRACKS", "Device"]

_SMALL_GRID: Final = 1 << 16  # PoCL compiles a kernel once more for more work-items than 16 bits can count


class Device:
    """A driver with the kernels for one format of rays, and the track that launches and buffers are on.

    wanted: as for `clrt.Tracer`; or a Driver, whose settings and kernels then hold. None of this changes: for
    other rays, or on another track, there is another Device of the same driver.
    """

    def __init__(
        self,
        wanted: int | str | Driver | None = None,
        settings: Settings | None = None,
        ray_format: layout.RayFormat | None = None,
        kernels: Path | None = None,
        track: int = 0,
    ) -> None:
        driver = wanted if isinstance(wanted, Driver) else Driver(wanted, settings or Settings(), kernels)
        self.driver, self.settings, self.info = driver, driver.settings, driver.info
        self.ray_format, self.packet = ray_format or layout.RayFormat(), driver.packet
        self.kernels = driver.kernels(self.ray_format)
        self._number, self.track = track, driver.tracks[track]
        self.queue, self.pool = self.track.queue, self.track.pool

    def variant(self, ray_format: layout.RayFormat) -> Device:
        """The same with kernels for rays that carry this."""
        same = ray_format == self.ray_format
        return self if same else Device(self.driver, ray_format=ray_format, track=self._number)

    def for_queue(self, narrow: bool) -> Device:
        """The same with the kernels for a queue of such rays."""
        own = self.ray_format
        return self if narrow == own.narrow else self.variant(replace(own, narrow=narrow))

    def on(self, track: int) -> Device:
        """The same on the track of that number, 0 to TRACKS - 1."""
        return self if track == self._number else Device(self.driver, ray_format=self.ray_format, track=track)

    @property
    def bands(self) -> int:
        """Bands of the scene."""
        return self.ray_format.bands

    @property
    def media(self) -> int:
        """Places in a ray's list of media; 0: none."""
        return self.ray_format.media

    @property
    def held_bytes(self) -> int:
        """Bytes of device memory on all tracks, in use or kept for use."""
        return self.driver.held_bytes

    def launch(self, name: str, items: int, *arguments: Any, local_size: int | None = None) -> None:
        """Run a kernel over `items` work-items, in work-groups of one size: that of the settings, at most
        `local_size` and what the device takes for this kernel.

        The last group is filled up with idle items, so kernels check their number. numpy scalars go by value.
        TypeError where the kernel's signature is another.
        """
        self.kernels.check(name, arguments)
        if items == 0:
            return
        check_process()
        kernel = self.kernels.kernel(name, arguments)
        most = local_size or max(1, ceilings.PRIVATE // (4 * self.bands))  # some add up a ray's bands
        local = min(most, self.kernels.groups[name])
        total = -(-items // local) * local

        def enqueue() -> cl.Event:
            kernel.set_args(arguments)
            return cl.enqueue_nd_range_kernel(self.queue, kernel.made, (total,), (local,))

        recorder = self.driver.recorder
        before = now() if recorder else 0
        sizes = (name, local, total < _SMALL_GRID)
        if sizes in self.kernels.launched:
            event = self.driver.guard(enqueue, f"kernel {name}")
        else:
            event = self._first_launch(enqueue, sizes)
        self.track.launched(name, event, self.driver.timing)
        if recorder:
            recorder.enqueued("pass", name, self._number, event, before, items)

    def launch_packets(self, name: str, rays: int, *arguments: Any) -> None:
        """Run a kernel whose work-items take a packet of `rays` each."""
        self.launch(name, -(-rays // self.packet), *arguments, local_size=self._of_packets)

    def launch_chunks(self, name: str, rays: int, *arguments: Any) -> None:
        """Run a kernel whose work-items take a chunk of `rays` each, one packet after the other."""
        self.launch(name, -(-rays // layout.CHUNK), *arguments, local_size=self._of_packets)

    @property
    def _of_packets(self) -> int:
        """The size of a work-group whose work-items take packets.

        Unless the settings say how large, a work-group on a CPU is one work-item: PoCL gives each of a group
        private arrays of its own, and those of many packets (a value a band and ray) leave the caches. Nor
        may a group have more than `ceilings` allow: its arrays lie on a thread's stack.
        """
        if self.info.kind == "CPU" and self.settings.local_size is None:
            return 1
        return max(1, min(ceilings.PACKETS, ceilings.PRIVATE // (4 * self.ray_format.values * self.packet)))

    def _first_launch(self, enqueue: Callable[[], cl.Event], sizes: tuple[str, int, bool]) -> cl.Event:
        """A launch before which PoCL may compile the kernel for these sizes: one process at a time."""
        if not pocl_version(self.info):  # others compile all there is to compile when they build the program
            self.kernels.launched.add(sizes)
            return self.driver.guard(enqueue, f"kernel {sizes[0]}")
        with cachelock.compiling(self.kernels.key, *sizes) as known:
            event = self.driver.guard(enqueue, f"kernel {sizes[0]}")
            if not known:
                self.driver.wait(event.wait, f"kernel {sizes[0]}")
        self.kernels.launched.add(sizes)
        return event

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
                for track in self.driver.tracks:
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
        """Copy an array to the start of a buffer; `wait` as for `upload`.

        What is waited for is there for all tracks. (A blocking copy need only have read the array when it
        returns, OpenCL 1.2, 5.2.2: Intel's runtime writes later, and other tracks read what was there.)
        """
        if array.nbytes:
            event = self._command("upload", lambda: self.track.send(target, array))
            if wait:
                self.driver.wait(event.wait, "upload")

    def _command(self, name: str, action: Callable[[], cl.Event]) -> cl.Event:
        """The event of a copy that is given to the driver; who records is told of it."""
        recorder = self.driver.recorder
        before = now() if recorder else 0
        event: cl.Event = self.driver.guard(action, name)
        if recorder:
            recorder.enqueued("copy", name, self._number, event, before)
        return event

    def ask(self, source: Any, array: np.ndarray) -> Answer:
        """Fill `array` from the start of a buffer, once all passes before it are done; does not wait."""
        if not array.nbytes:
            return Answer(array, None, self.driver.wait)
        copied = self._command(
            "read", lambda: cl.enqueue_copy(self.queue, array, source, is_blocking=False)
        )
        return Answer(array, kept(copied), self.driver.wait)

    def read(self, source: Any, array: np.ndarray) -> np.ndarray:
        """Fill `array` from the start of a buffer; waits for all passes before it."""
        return self.ask(source, array).wait()

    def fill(self, target: Any, nbytes: int, word: int = 0) -> None:
        """Fill the start of a buffer with one 32-bit integer."""
        if nbytes:
            pattern = np.array([word], np.int32)
            self._command("fill", lambda: cl.enqueue_fill_buffer(self.queue, target, pattern, 0, nbytes))

    def copy(self, target: Any, source: Any, nbytes: int) -> None:
        """Copy the start of a buffer to that of another."""
        move = partial(cl.enqueue_copy, self.queue, target, source, byte_count=nbytes)
        self._command("copy", move)

    def flush(self) -> None:
        """See to it that everything launched begins."""
        self.driver.guard(self.queue.flush, "flush")

    def finish(self) -> None:
        """Wait for everything launched on the track, and note the times of what is timed."""
        self.driver.finish(self.track)
