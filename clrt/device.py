"""The OpenCL side: choose a device, build the kernels, keep buffers, launch.

Nothing of a scene ever reaches the source or the build options, so the kernels compile once a machine: the
driver's own cache finds them again.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np
import pyopencl as cl
from pyopencl import tools as cl_tools

from clrt import layout
from clrt.errors import DeviceError
from clrt.resources import kernel_folder
from clrt.settings import Settings

KERNEL_FILES: Final = (
    "generate.cl",
    "trace.cl",
    "surface.cl",
    "light.cl",
    "bounce.cl",
    "ambient.cl",
    "compact.cl",
    "film.cl",
    "tree.cl",
    "crossings.cl",
)
_INCLUDE = re.compile(r'^#include "([\w.]+)"$')


@dataclass(frozen=True)
class DeviceInfo:
    """One OpenCL device, as `clrt devices` lists it. `memory` is in bytes, `units` counts compute units."""

    index: int
    name: str
    platform: str
    version: str
    kind: str
    units: int
    memory: int

    @property
    def label(self) -> str:
        return f"{self.platform} {self.version} / {self.name}"


def _all_devices() -> list[tuple[DeviceInfo, cl.Device]]:
    try:
        platforms = cl.get_platforms()
    except cl.Error as error:
        raise DeviceError(
            f"no OpenCL platform: {error}; install a driver: pip install 'clrt[pocl]' (Linux, x86-64), "
            "or your system's (Debian: apt-get install pocl-opencl-icd)"
        ) from None
    found: list[tuple[DeviceInfo, cl.Device]] = []
    for platform in platforms:
        for device in platform.get_devices():
            kind = (
                "CPU"
                if device.type & cl.device_type.CPU
                else "GPU"
                if device.type & cl.device_type.GPU
                else "other"
            )
            info = DeviceInfo(
                len(found),
                device.name.strip(),
                platform.name.strip(),
                _short_version(platform.version),
                kind,
                device.max_compute_units,
                device.global_mem_size,
            )
            found.append((info, device))
    return found


def _short_version(version: str) -> str:
    """'OpenCL 3.0 PoCL 3.1+debian  Linux, ...' -> 'PoCL 3.1+debian'; other drivers: the whole text."""
    match = re.search(r"PoCL [\w.+-]+", version)
    return match.group(0) if match else version.strip()


def devices() -> list[DeviceInfo]:
    """The OpenCL devices of this machine. DeviceError when there is no OpenCL platform."""
    return [info for info, _ in _all_devices()]


def _pocl_version(info: DeviceInfo) -> tuple[int, ...]:
    match = re.search(r"PoCL (\d+)\.(\d+)", info.version)
    return tuple(int(part) for part in match.groups()) if match else ()


def choose(wanted: int | str | None = None) -> tuple[DeviceInfo, cl.Device]:
    """The device that `wanted` means: a number, a part of "platform version / name", or None.

    None looks at the environment variable CLRT_DEVICE, then takes the newest PoCL, then the first device.
    DeviceError lists what there is.
    """
    found = _all_devices()
    if wanted is None:
        wanted = os.environ.get("CLRT_DEVICE") or None
    if wanted is None:
        if not found:
            raise DeviceError("no OpenCL device; `clrt devices` lists what this machine offers")
        return max(found, key=lambda entry: (_pocl_version(entry[0]), -entry[0].index))
    text = str(wanted).strip()
    matches = [entry for entry in found if text == str(entry[0].index)]
    matches = matches or [entry for entry in found if text.lower() in entry[0].label.lower()]
    if not matches:
        offered = "; ".join(f"{info.index}: {info.label}" for info, _ in found) or "nothing"
        raise DeviceError(f"device {text!r} is not here; this machine offers {offered}")
    return matches[0]


def flatten_includes(files: tuple[str, ...], folder: Path) -> str:
    """One source of all files: each include in place, once, with #line so that messages name file and line.

    (Real -I paths break on folders with a space in their name.)
    """
    seen: set[str] = set()
    out: list[str] = []

    def add(name: str) -> None:
        seen.add(name)
        out.append(f'#line 1 "{name}"')
        for number, line in enumerate((folder / name).read_text(encoding="utf-8").splitlines(), 1):
            match = _INCLUDE.match(line)
            if not match:
                out.append(line)
            elif match.group(1) not in seen:
                add(match.group(1))
                out.append(f'#line {number + 1} "{name}"')
            else:
                out.append("")

    for name in files:
        add(name)
    return "\n".join(out) + "\n"


def kernel_source(
    bands: int = layout.BANDS, lanes: int = 16, packet: int = 16, folder: Path | None = None
) -> str:
    """The program: the layout's declarations and every kernel file."""
    return layout.c_declarations(bands, lanes, packet) + flatten_includes(
        KERNEL_FILES, folder or kernel_folder()
    )


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
    """An OpenCL device and the kernels built for it: owns context, command queue, program and memory pool."""

    def __init__(
        self,
        wanted: int | str | None = None,
        settings: Settings | None = None,
        bands: int = layout.BANDS,
        kernels: Path | None = None,
    ) -> None:
        self.settings = settings or Settings()
        self.bands = bands
        self._kernel_folder = kernels
        self.info, device = choose(wanted)
        if self.settings.local_size > device.max_work_group_size:
            raise DeviceError(
                f"{self.info.label}: local_size {self.settings.local_size} is above its "
                f"{device.max_work_group_size}"
            )
        try:
            self.device = _thread_limited(device, self.settings.threads)
            self.context = _context(self.device)
            # PoCL's context names the whole device where it was made for a part: the queue must say which
            self.queue = cl.CommandQueue(
                self.context, self.device, properties=cl.command_queue_properties.PROFILING_ENABLE
            )
            self.pool = cl_tools.MemoryPool(cl_tools.ImmediateAllocator(self.queue))
        except cl.Error as error:
            raise DeviceError(f"{self.info.label}: {error}") from None
        # PoCL 3.0's compiler hangs or aborts on float16
        self.packet = (
            8 if _pocl_version(self.info) and _pocl_version(self.info) < (3, 1) else self.settings.lanes
        )
        self.source = kernel_source(bands, self.settings.lanes, self.packet, kernels)
        self._kernels: dict[str, cl.Kernel] = {}
        self._events: list[tuple[str, cl.Event]] = []
        self._seconds: dict[str, float] = {}

    def with_bands(self, bands: int) -> Device:
        """The same device with kernels for rays of another number of bands; itself where that is its own."""
        if bands == self.bands:
            return self
        return Device(self.info.index, self.settings, bands, self._kernel_folder)

    @property
    def kernel_hash(self) -> str:
        """SHA-256 of the program's source."""
        return hashlib.sha256(self.source.encode()).hexdigest()

    @cached_property
    def program(self) -> cl.Program:
        return self.build(self.source)

    def build(self, source: str) -> cl.Program:
        """Compile a program as the kernels are compiled. DeviceError with the driver's log."""
        try:
            return _program(self.context, source)
        except cl.Error as error:
            raise DeviceError(f"{self.info.label}: the kernels do not build: {error}") from None

    def kernel(self, name: str, arguments: tuple[Any, ...]) -> cl.Kernel:
        """A kernel object for arguments of these types, looked up once: a lookup costs more than a launch.

        Told the types of its numbers beforehand, it takes them in a tenth of the time.
        """
        if name not in self._kernels:
            kernel = cl.Kernel(self.program, name)
            kernel.set_scalar_arg_dtypes([a.dtype if isinstance(a, np.generic) else None for a in arguments])
            self._kernels[name] = kernel
        return self._kernels[name]

    def launch(self, name: str, items: int, *arguments: Any, local_size: int | None = None) -> None:
        """Run a kernel over `items` work-items; the work-groups are all of the settings' size.

        The last group is filled up with idle items, so kernels check their number. numpy scalars go by value.
        """
        if items == 0:
            return
        local = local_size or self.settings.local_size
        kernel = self.kernel(name, arguments)
        try:
            kernel.set_args(*arguments)
            event = cl.enqueue_nd_range_kernel(self.queue, kernel, (-(-items // local) * local,), (local,))
        except cl.Error as error:
            raise DeviceError(f"{self.info.label}: kernel {name}: {error}") from None
        self._events.append((name, event))

    def buffer(self, nbytes: int) -> Any:
        """Uninitialised device memory from the pool; freed when no longer referenced.

        LimitError where all buffers together would pass the limit `device_bytes`: drivers promise more memory
        than there is, and fail when it is touched.
        """
        self.settings.limits.check("device_bytes", self.pool.active_bytes + nbytes)
        return self._guard(lambda: self.pool.allocate(max(nbytes, 4)), f"{nbytes} bytes")

    def upload(self, array: np.ndarray) -> Any:
        """A copy of an array on the device."""
        array = np.ascontiguousarray(array)
        target = self.buffer(array.nbytes)
        if array.nbytes:
            self._guard(lambda: cl.enqueue_copy(self.queue, target, array, is_blocking=True), "upload")
        return target

    def read(self, source: Any, array: np.ndarray) -> np.ndarray:
        """Fill `array` from the start of a buffer; waits for all passes before it."""
        if array.nbytes:
            self._guard(lambda: cl.enqueue_copy(self.queue, array, source, is_blocking=True), "read")
        return array

    def fill_zero(self, target: Any, nbytes: int) -> None:
        if nbytes:
            self._guard(
                lambda: cl.enqueue_fill_buffer(self.queue, target, np.zeros(1, np.uint32), 0, nbytes), "fill"
            )

    def finish(self) -> None:
        """Wait for everything launched, and add up the time by pass."""
        self._guard(self.queue.finish, "finish")
        for name, event in self._events:
            spent = (event.profile.end - event.profile.start) * 1e-9
            self._seconds[name] = self._seconds.get(name, 0.0) + spent
        self._events.clear()

    def take_seconds(self) -> dict[str, float]:
        """Seconds by kernel since the last call."""
        self.finish()
        seconds, self._seconds = self._seconds, {}
        return seconds

    def _guard(self, action: Callable[[], Any], what: str) -> Any:
        try:
            return action()
        except cl.Error as error:
            raise DeviceError(f"{self.info.label}: {what}: {error}") from None
