"""An OpenCL device that is open, and the kernels that are built for it.

Nothing of a scene ever reaches the source or the build options, so the kernels compile once a machine: the
driver's own cache finds them again. Every call of the driver goes through `Driver.guard`: a refusal is a
DeviceError.
"""

from __future__ import annotations

import hashlib
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache, cached_property, partial
from pathlib import Path
from types import CodeType
from typing import Any, Final

from clrt import layout
from clrt.base.errors import DeviceError
from clrt.base.log import log
from clrt.base.resources import kernel_folder, kernel_text
from clrt.device import beside, binaries, cachelock, foreign, intel, kernelpool, waiter
from clrt.device.opencl import cl
from clrt.device.platforms import check_process, choose, command, pocl_version, starting
from clrt.device.settings import Settings
from clrt.device.source import kernel_source
from clrt.device.timeline import current, now
from clrt.device.tracks import Track, seconds_by_name
from clrt.device.trial import broken, plain
from clrt.layout import parameters

TRACKS: Final = 2  # pieces of work that go on at the same time
_GROUP: Final = 64  # work-items of a work-group, unless the settings say otherwise
# PoCL keeps what it compiled by itself; a checker like Oclgrind has to see every kernel being compiled
_KEEPS_PROGRAMS: Final = ("Portable Computing Language", "Oclgrind")
# Kernels take packets of rays in vectors of their own. Intel's compiler would vectorise each once more, over
# work-items: it then takes three to four times as long, and pictures a sixth to a half more (docs/design.md)
_AS_WRITTEN: Final = "#define __kernel __kernel __attribute__((intel_vec_len_hint(1)))\n#line 1\n"


# Contexts and programs are kept for the process: they hold no state of a scene, and looking a program up in
# the driver's cache takes longer than a small picture.
@cache
def _context(device: cl.Device) -> cl.Context:
    with starting():  # Intel's runtime starts its compiler here, and reads its `cl.cfg` anew
        return cl.Context([device])


@cache
def _program(context: cl.Context, source: str) -> cl.Program:
    device = context.devices[0]
    options = ["-cl-std=CL1.2", "-w"]  # else clang prints how many warnings there were
    if device.single_fp_config & cl.device_fp_config.CORRECTLY_ROUNDED_DIVIDE_SQRT:
        options.append("-cl-fp32-correctly-rounded-divide-sqrt")
    if device.platform.name.strip() in _KEEPS_PROGRAMS:
        return binaries.quietly(context, cl.Program(context, source), options)
    return binaries.built(context, source, options)


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


class Driver:
    """The chosen device with its context, its tracks, and its kernels by what rays carry."""

    def __init__(self, wanted: int | str | None, settings: Settings, folder: Path | None) -> None:
        self.settings = settings
        self.foreign = folder or foreign.folder()  # None: the kernels that ship
        self.info, device = choose(wanted)
        if device.max_work_group_size < 1:
            raise DeviceError(broken(f"{self.info.label}: its largest work-group is of 0 work-items"))
        if self.settings.local_size and self.settings.local_size > device.max_work_group_size:
            raise DeviceError(
                f"{self.info.label}: local_size {self.settings.local_size} is above its "
                f"{device.max_work_group_size}"
            )
        try:
            self.device = _thread_limited(device, self.settings.threads)
            self.context = _context(self.device)
            self.tracks = [Track(self.context, self.device) for _ in range(TRACKS)]
        except cl.Error as error:
            raise DeviceError(f"{self.info.label}: {error}") from None
        # PoCL 3.0's compiler hangs or aborts on float16; Oclgrind takes its upper half for uninitialised
        eight = "Oclgrind" in self.info.platform or (0,) < pocl_version(self.info) < (3, 1)
        self.packet = 8 if eight else self.settings.lanes
        log.info("device: %s, %d bits wide packets", self.info.label, 32 * self.packet)
        self._kernels: dict[layout.RayFormat, Kernels] = {}
        self._timers = 0  # how many ask for times
        self._spans: list[tuple[int, int, str]] = []
        timeline = current()
        self.recorder = timeline.opened(self.info.label) if timeline else None  # None: nobody records

    def kernels(self, ray_format: layout.RayFormat) -> Kernels:
        """The kernels for rays that carry this."""
        if ray_format not in self._kernels:
            read = foreign.text if self.foreign else kernel_text
            folder = self.foreign or kernel_folder()
            source = kernel_source(ray_format, self.settings.lanes, self.packet, folder, read)
            self._kernels[ray_format] = Kernels(self, ray_format, source)
        return self._kernels[ray_format]

    def build(self, source: str, anew: Callable[[], None] | None = None) -> cl.Program:
        """Compile a program as the kernels are compiled. DeviceError with the driver's log.

        anew: called where nobody has compiled it before.
        """
        begin = time.perf_counter()
        built = self._build(source, anew)
        log.info("program of %d characters ready in %.2f s", len(source), time.perf_counter() - begin)
        return built

    def _build(self, source: str, anew: Callable[[], None] | None) -> cl.Program:
        check_process()
        with cachelock.compiling(self._program_name(source)) as known:
            if anew and not known:
                anew()
            given = self.given(source)
            try:
                return _program(self.context, given)
            except cl.Error:
                pass  # builds fail without a reason where a process outside clrt's lock compiles, too
            try:
                return _program(self.context, given)
            except cl.Error as error:
                where = f" of {self.foreign}" if self.foreign else ""
                advice = "" if self.foreign else f"; what mends it says: {command('doctor')}"
                reason = f"the kernels{where} do not build: {plain(str(error))}{advice}"
                raise DeviceError(f"{self.info.label}: {reason}") from None

    def compiled_as(self, source: str) -> str:
        """Another text for every source, device and driver, and for each place where pip put a driver.

        PoCL compiles anew what a PoCL elsewhere has compiled, though the version is the same.
        """
        whose = f"{self.info.label} {self.info.driver} {Path(cl.__file__).parent}"
        return hashlib.sha256(f"{whose} {source}".encode()).hexdigest()[:16]

    def _program_name(self, source: str) -> str:
        return f"program-{self.compiled_as(source)}"

    def is_compiled(self, source: str) -> bool:
        """Whether a program has been built here before."""
        return cachelock.was_compiled(self._program_name(source))

    def given(self, source: str) -> str:
        """What the driver's compiler is given of a source."""
        return _AS_WRITTEN + source if self.device.platform.name.strip() == intel.PLATFORM else source

    @property
    def held_bytes(self) -> int:
        """Bytes of device memory in all pools, in use or kept for use."""
        held: int = 0
        for track in self.tracks:
            held += track.pool.managed_bytes
        return held

    def finish(self, track: Track) -> None:
        """Wait for everything launched on a track, and note the times of what is timed."""
        self.wait(track.queue.finish, "finish")
        self._spans += track.take_spans()
        if self.recorder:
            self.recorder.settle()

    def barrier(self) -> None:
        """Let all that any track has been given be done before what any track is given from now on.

        For work that is given up half-way, so that nobody will wait for it: it goes on reading a scene's
        buffers, whose memory the next scene gets. Does not wait.
        """
        check_process()

        def enqueue() -> None:
            marks = [cl.enqueue_marker(track.queue) for track in self.tracks]
            for track in self.tracks:
                cl.enqueue_barrier(track.queue, wait_for=marks)
                track.queue.flush()  # another queue waits for what is in it

        self.guard(enqueue, "barrier")

    @property
    def timing(self) -> bool:
        """Whether times of launches are asked for now."""
        return self._timers > 0

    @contextmanager
    def timed(self) -> Iterator[dict[str, float]]:
        """Seconds by kernel of what is launched within, on all tracks; they are there once it is left.

        What is launched elsewhere leaves nothing behind, however often, and within another such block (a
        picture's `progress` renders one) none of its times.
        """
        seconds: dict[str, float] = {}
        self._timers += 1
        before, self._spans = self._spans, []
        launched = [track.take_launches() for track in self.tracks]
        try:
            yield seconds
            for track in self.tracks:
                self.finish(track)
            seconds |= seconds_by_name(self._spans)
        finally:
            self._timers -= 1
            self._spans = before
            for track, launches in zip(self.tracks, launched, strict=True):
                track.forget(launches)

    def wait(self, action: Callable[[], Any], what: str) -> None:
        """Do something that returns when the device is done; Ctrl-C ends the wait at once.

        Python answers signals in its main thread, between two steps of it: so that one must not be in the
        driver. What is waited for goes on, and keeps its buffers and arrays until it is done.
        """
        check_process()
        begin = now() if self.recorder else 0
        if threading.current_thread() is threading.main_thread():
            self.guard(lambda: waiter.done(action), what)
        else:
            self.guard(action, what)
        if self.recorder:
            self.recorder.waited(what, begin)

    def guard(self, action: Callable[[], Any], what: str) -> Any:
        """What a call of the driver gives; DeviceError where it is refused."""
        try:
            return action()
        except cl.Error as error:
            raise DeviceError(f"{self.info.label}: {what}: {error}") from None


class Kernels:
    """The kernels of a driver for rays of one format, compiled when the first is asked for."""

    def __init__(self, driver: Driver, ray_format: layout.RayFormat, source: str) -> None:
        self._driver, self.ray_format, self.source = driver, ray_format, source
        self.launched: set[tuple[str, int, bool]] = set()  # name, size of work-groups, is the grid small
        self.groups: dict[str, int] = {}  # work-items of a kernel's work-group
        self.needed: Mapping[str, bool] = {}  # those that are known to be needed (`clrt.device.beside`)
        self._kernels: dict[str, kernelpool.Kernel] = {}
        self._kept = kernelpool.Kept()
        self._checked: set[tuple[str, CodeType, int]] = set()  # kernels, and lines of code that launch them

    def check(self, name: str, arguments: tuple[Any, ...]) -> None:
        """TypeError where the kernel takes other arguments than these.

        A line of code hands on the same kinds each time: it is checked once (a small picture has hundreds of
        launches, and looking at each argument would cost a twentieth of its time).
        """
        frame = sys._getframe(2)
        if frame.f_code.co_name in ("launch_packets", "launch_chunks") and frame.f_back is not None:
            frame = frame.f_back
        place = (name, frame.f_code, frame.f_lineno)
        if place not in self._checked:
            self._check_signature(name, arguments)
            self._checked.add(place)

    def _check_signature(self, name: str, arguments: tuple[Any, ...]) -> None:
        try:
            parameters.check(self.source, name, parameters.kinds(arguments))
        except (TypeError, KeyError, StopIteration, ValueError) as error:
            if self._driver.foreign is None:
                raise
            missing = f"there is no kernel {name}, or none that takes what is given to it"
            reason = str(error) if isinstance(error, TypeError) else missing
            raise DeviceError(f"{self._driver.foreign}: {reason}") from None

    @cached_property
    def hash(self) -> str:
        """SHA-256 of the program's source."""
        return hashlib.sha256(self.source.encode()).hexdigest()

    @cached_property
    def key(self) -> str:
        """Another one for every source and driver."""
        return self._driver.compiled_as(self.source)

    @cached_property
    def program(self) -> cl.Program:
        driver = self._driver
        anew = partial(beside.start, driver.info.label, driver.settings, self.ray_format, self.needed)
        # foreign ones may never end; other drivers compile all kernels with the program
        helped = driver.foreign is None and pocl_version(driver.info)
        return driver.build(self.source, anew if helped else None)

    def kernel(self, name: str, arguments: tuple[Any, ...]) -> kernelpool.Kernel:
        """A kernel object for arguments of these types, looked up once: a lookup costs more than a launch."""
        if name not in self._kernels:
            kernel = self._driver.guard(
                lambda: self._kept.take(self.program, name, arguments), f"kernel {name}"
            )
            self._kernels[name] = kernel
            most = cl.kernel_work_group_info.WORK_GROUP_SIZE
            wanted = self._driver.settings.local_size or _GROUP
            self.groups[name] = min(wanted, kernel.made.get_work_group_info(most, self._driver.device))
        return self._kernels[name]
