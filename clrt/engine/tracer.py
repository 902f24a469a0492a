"""The public API: a scene compiled to a device, rendered or asked about rays."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from copy import copy
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NoReturn, TypeVar

import numpy as np

from clrt.base import arguments, display, ending
from clrt.base.arguments import public
from clrt.base.errors import ClrtError
from clrt.device.device import Device
from clrt.device.platforms import check_process, is_forked
from clrt.device.settings import Settings
from clrt.engine import passes, queries, tree
from clrt.engine.answers import Crossings, Hits, check_fields
from clrt.engine.batch import Batch
from clrt.engine.checkpoint import Checkpoint
from clrt.engine.corners import turned_meshes
from clrt.engine.coverage import manifests
from clrt.engine.job import Job
from clrt.engine.picture import Picture
from clrt.engine.provenance import metadata, stats, wavelengths
from clrt.engine.queues import picture_tile, tile_rays
from clrt.engine.rayinput import LIGHT_BYTES, ray_chunks
from clrt.engine.request import Request, camera_of
from clrt.engine.tiles import tiles
from clrt.engine.wavefront import RayCounts
from clrt.engine.world import World
from clrt.flatten.flatten import check_ceilings, flatten, flatten_camera
from clrt.flatten.work import check_limits, check_work, depth_of
from clrt.formats.shipped import as_scene
from clrt.images.image import Image
from clrt.scene.camera import Camera
from clrt.scene.scene import Document, Scene, Shape, previewed

if TYPE_CHECKING:
    from clrt.raytree.tree import RayTree
else:
    RayTree = Any  # which few ask for: hints can be, without it

# fields of a scene that say nothing of what is on the device
_ASIDE = ("version", "camera", "max_depth", "adaptive")
ON_DEVICE = [name for name in (*Document.__struct_fields__, "folder") if name not in _ASIDE]
Progress = Callable[[int, int, int], None]
Method = TypeVar("Method", bound=Callable[..., Any])


_IN_USE: Final = (
    "this Tracer is in use by the call that is interrupted; a signal handler cannot use the Tracer that it "
    "interrupts: give it one of its own"
)


def _one_at_a_time(method: Method) -> Method:
    """Let threads wait for each other; a process that was forked learns why it cannot go on.

    Whoever comes again in the same thread comes from a signal's handler, or the like, and finds a launch that
    is half made: that is refused. `Tracer._tell` lets `progress` come again.
    """

    @wraps(method)
    def locked(self: Tracer, *arguments: Any, **named: Any) -> Any:
        check_process()  # first: a lock that was held when the process was forked stays held
        with ending.outside(), self._lock, ending.inside():
            if self._busy:
                raise ClrtError(_IN_USE)
            try:
                self._busy = True
                self._check_open()
                return method(self, *arguments, **named)
            finally:
                self._busy = False

    return locked  # type: ignore[return-value]


class Tracer:
    """A scene compiled to a device: reusable for pictures and ray queries.

    Threads may share it: one at a time is served. A forked process may not: it gets a DeviceError; nor may a
    signal's handler that interrupts it: a ClrtError. `progress` may.

    scene: a Scene, a dict as `clrt.load_dict` takes it, or a file or shipped scene's name as `clrt.load`
    takes it. device: a number from `clrt.devices()`, a part of "platform version / name", or None
    (CLRT_DEVICE, else the newest PoCL); or a `Device` of `clrt.device`, which then serves one thread and
    whose settings hold. settings: how to run, None for the usual. Raises DeviceError, SceneError,
    LimitError, and ClrtError for arguments of another kind. `update` gives it another scene; settings stay.
    As a context (`with Tracer(scene) as tracer`) it frees the device at the end, as `close` does.
    """

    @public
    def __init__(
        self,
        scene: Scene | Mapping[str, Any] | str | os.PathLike[str],
        device: int | str | Device | None = None,
        settings: Settings | None = None,
    ) -> None:
        opened = device.driver if isinstance(device, Device) else arguments.device("device", device)
        settings = arguments.optional_instance("settings", settings, Settings)
        self._settings = device.settings if isinstance(device, Device) else settings
        self._scene = as_scene(scene, self._settings.limits)
        self._lock = threading.RLock()
        self._busy = self._closed = False
        self._known: tuple[Sequence[Shape], np.ndarray | None] | None = None
        self._check_size(self._scene)
        self.flat = flatten(self._scene)
        check_ceilings(self.flat, self._scene.source)
        self.device = Device(opened, self.settings, self.flat.ray_format)
        self._world = World(self.device, self.flat)

    def _check_open(self) -> None:
        if self._closed:
            raise ClrtError("this Tracer is closed; make a new one: clrt.Tracer(scene)")

    def _check_size(self, scene: Scene) -> None:
        """Before anything is flattened, which takes the host as much memory."""
        self._settings.limits.check("device_bytes", tree.least_bytes(scene), scene.source, "shapes")

    @property
    def world(self) -> World:
        """The scene's buffers on the device."""
        self._check_open()
        return self._world

    @property
    def scene(self) -> Scene:
        """The scene that is on the device. `update` puts another in its place."""
        return self._scene

    @scene.setter
    def scene(self, other: object) -> None:
        raise ClrtError("tracer.scene: it is compiled to the device; for another scene call tracer.update")

    @public
    @_one_at_a_time
    def update(self, scene: Scene | Mapping[str, Any] | str | os.PathLike[str]) -> str:
        """Hold another scene, at the least cost, and say what it took.

        "nothing": all is as it was, on the device; "camera": that alone differs; "tables": materials, lights
        or other small arrays were sent; "refit": the same primitives moved, and the tree got new boxes;
        "rebuild": the tree was built anew, as where primitives come or go, or where a refit would leave it
        1.5 times as costly as it was when last built. Objects that both scenes share (`Scene.replace` keeps
        what it does not change) are not looked at. Pictures are those of a new Tracer, bit for bit. Raises
        what `Tracer` raises; the scene before then stays.
        """
        scene = as_scene(scene, self.settings.limits)
        before, cost = self._scene, "nothing"
        if not all(getattr(scene, name) is getattr(before, name) for name in ON_DEVICE):
            if scene.shapes is not before.shapes:
                self._check_size(scene)
            flat = flatten(scene, (before, self.flat))
            check_ceilings(flat, scene.source)
            device = self.device.variant(flat.ray_format)
            # another one: a picture whose `progress` calls this is finished as it was begun, and what is
            # raised in between (Ctrl-C) changes nothing
            world = copy(self.world)
            cost = world.update(device, flat)
            self._world, self.flat, self.device, self._scene = world, flat, device, scene
        if cost == "nothing" and scene.camera != before.camera:
            cost = "camera"
        self._scene = scene
        return cost

    @public
    def close(self) -> None:
        """Free what it holds on the device; it cannot be used after that. To close it twice does no harm.

        In a forked process that frees nothing: all of it is its parent's.
        """
        if not (self._closed or is_forked()):
            self._close()

    @_one_at_a_time
    def _close(self) -> None:
        self._closed = True
        del self._world
        for track in self.device.driver.tracks:
            track.pool.free_held()

    def __enter__(self) -> Tracer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def settings(self) -> Settings:
        """How it runs. They cannot be replaced: make a new Tracer for others."""
        return self._settings

    @settings.setter
    def settings(self, other: object) -> None:
        text = "the device was set up with these; for others make Tracer(scene, settings=...)"
        raise ClrtError(f"tracer.settings: {text}")

    @_one_at_a_time
    def _preview(self, width: int) -> Image:
        """A picture of one sample a pixel, also of a scene whose `adaptive` goes with others."""
        return self._render(previewed(self._scene, 1), Request(width, spp=1))

    def _repr_html_(self) -> str:
        """What notebooks show: a small picture, what is in the scene, and where it is computed."""
        from clrt.engine.shown import shown

        return shown(self)

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """What notebooks show: the same, and the widget where there is one."""
        return display.bundle(self, self._repr_html_())

    def __reduce__(self) -> NoReturn:
        raise ClrtError("a Tracer holds a device and cannot be copied or pickled; its scene and settings can")

    @property
    def tile(self) -> int:
        """Rays that are traced at once: the setting, or what suits the scene's number of bands."""
        return tile_rays(self.flat.ray_format, self.settings)

    @public
    @_one_at_a_time
    def render(
        self,
        width: int | None = None,
        height: int | None = None,
        spp: int | None = None,
        max_depth: int | None = None,
        layers: Sequence[str] = (),
        progress: Progress | None = None,
        crop: tuple[int, int, int, int] | None = None,
        checkpoint: str | os.PathLike[str] | None = None,
        camera: Camera | Mapping[str, Any] | None = None,
    ) -> Image:
        """The picture that the scene's camera sees, or another one.

        width, height (pixels, >= 1), spp (a square >= 1), max_depth (>= 0): in place of the scene's; width or
        height alone keeps the aspect. layers: names as in docs/layers.md (`direct`, `generation_1`, `depth`,
        ...), or "all". progress: called with (pixels done, pixels in all, rays traced) after every tile.
        crop: (x, y, width, height) in pixels, the part of the picture to render, with the same bits as in the
        whole. camera: a `clrt.Camera`, or a dict as in scene files, for this picture only. checkpoint: a file
        that keeps what is finished; a render that finds it goes on from there. It
        is kept at the end, for you to remove. Raises SceneError without a camera, LimitError, DeviceError,
        and ClrtError for arguments of another kind or range.
        """
        progress = arguments.function("progress", progress)
        kept = None if checkpoint is None else arguments.path("checkpoint", checkpoint)
        asked = Request(width, height, spp, max_depth, layers, crop, camera)
        return self._render(self._scene, asked, progress, kept)

    def _render(
        self, scene: Scene, asked: Request, progress: Progress | None = None, checkpoint: Path | None = None
    ) -> Image:
        flat, device, world = self.flat, self.device, self.world
        task, full, window = asked.job(scene, flat, self.settings)
        samples = task.piece_samples
        picture = Picture(window, full[0], task.layers, flat.bands)
        counts, local_size, total = RayCounts(), 0, window[2] * window[3]
        saved = None
        size = self.tile if self.settings.tile else picture_tile(window[2] * window[3] * samples, self.tile)
        pieces = list(tiles(*full, window, max(1, size // samples)))[::-1]
        if checkpoint is not None:
            saved = Checkpoint(checkpoint, task.identity(window), picture, counts, task.ranges())
            pieces = saved.unfinished(pieces)
        done = total - sum(map(len, pieces))
        with device.driver.timed() as seconds, saved or nullcontext():
            for pixels, tile in task.tiles(device, world, pieces):
                picture.put(pixels, tile.layers)
                if saved:
                    saved.add(pixels, tile.rays)
                else:
                    counts.merge(tile.rays)
                local_size = tile.local_size
                done += len(pixels)
                if progress:
                    self._tell(progress, done, total, counts.traced)
        label = device.info.label
        told = metadata(device.kernels.hash, label, device.settings, flat)
        told |= manifests(scene, task.layers)
        made = stats(counts, local_size, seconds, label)
        return Image(*picture.whole(), made, told, wavelengths(scene))

    def _tell(self, progress: Progress, *told: int) -> None:
        """Call the caller's function, which may use this Tracer."""
        try:
            self._busy = False
            progress(*told)
        finally:
            self._busy = True

    @public
    @_one_at_a_time
    def identity(
        self,
        width: int | None = None,
        height: int | None = None,
        spp: int | None = None,
        max_depth: int | None = None,
        layers: Sequence[str] = (),
        crop: tuple[int, int, int, int] | None = None,
        camera: Camera | Mapping[str, Any] | None = None,
    ) -> str:
        """SHA-256 (hexadecimal) of all that decides the picture that `render` would give for these arguments.

        Equal for equal pictures' scenes, cameras, sizes, layers and kernels, known without rendering. Raises
        what `render` does.
        """
        asked = Request(width, height, spp, max_depth, layers, crop, camera)
        task, _, window = asked.job(self.scene, self.flat, self.settings)
        return task.fingerprint(window)

    @public
    @_one_at_a_time
    def camera_rays(
        self, camera: Camera | Mapping[str, Any] | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Origins and unit directions (height, width, 3) float32 of a picture's rays, one a pixel.

        camera: as for `render`. They are what `render(spp=1)` traces, bit for bit.
        """
        view = flatten_camera(camera_of(self.scene, camera), spp=1)
        height, width = int(view["height"][0]), int(view["width"][0])
        check_limits(self.flat, self.settings.limits, width * height, 1, 0)
        self.settings.limits.check("host_bytes", 4 * 6 * width * height)
        found = np.empty((2, height * width, 3), np.float32)
        record = self.device.upload(view)
        for start in range(0, height * width, self.tile):
            pixels = np.arange(start, min(start + self.tile, height * width), dtype=np.uint32)
            queue, _ = passes.generate(self.device, record, pixels, 1)
            lines = queue.lines(queue.rays)
            found[0, pixels], found[1, pixels] = lines["origin"].T, lines["direction"].T
        origins, directions = found.reshape(2, height, width, 3)
        return origins, directions

    @public
    @_one_at_a_time
    def explain(
        self,
        x: int,
        y: int,
        width: int | None = None,
        height: int | None = None,
        spp: int | None = None,
        max_depth: int | None = None,
        camera: Camera | Mapping[str, Any] | None = None,
    ) -> RayTree:
        """All rays of one pixel, x to the right and y down from 0, and what each brings to it: a `RayTree`.

        The other arguments are as for `render`. Raises what it does, ClrtError for a pixel outside of the
        picture, and LimitError for a pixel of more than 50 000 rays or 100 000 shadow feelers, or a scene of
        more than 1000 lights.
        """
        from clrt.engine.explain import explain

        asked = Request(width, height, spp, max_depth, (), None, camera)
        task, full, _ = asked.job(self.scene, self.flat, self.settings)
        place = arguments.whole("x", x, 0, full[0] - 1), arguments.whole("y", y, 0, full[1] - 1)
        return explain(self.device, self.world, self.scene, task, place, full)

    @public
    @_one_at_a_time
    def intersect(
        self, origins: Any, directions: Any, t_max: Any = np.inf, t_min: Any = 0.0,
        fields: Sequence[str] | None = None,
    ) -> Hits:
        """Nearest hits of rays: origins, directions (..., 3); t_min, t_max (...); all broadcast as in numpy.

        So one origin does for many directions. Only hits with t_min < t < t_max and t > 0 count. Directions
        need not have unit length; t is a distance. A zero or non-finite direction misses, and so does a NaN
        anywhere. fields: names of those of `Hits` that are wanted, None for all; what is not asked for is
        not computed. float32 arrays that are C-contiguous are read where they lie, so nobody may change them
        meanwhile; others are copied piece by piece. ClrtError for other shapes, and for anything but real
        numbers; LimitError where the answers need more than `Limits.host_bytes`.
        """
        names = check_fields(fields)
        batch = Batch(origins, directions, t_min, t_max)
        return queries.intersect(self.device, self.world, batch, names, self._turned())

    @public
    @_one_at_a_time
    def occluded(self, origins: Any, directions: Any, t_max: Any = np.inf, t_min: Any = 0.0) -> np.ndarray:
        """(...) bool: does anything stand within t_min < t < t_max. Rays and errors as for `intersect`."""
        return queries.occluded(self.device, self.world, Batch(origins, directions, t_min, t_max))

    @public
    @_one_at_a_time
    def count_hits(self, origins: Any, directions: Any, t_max: Any = np.inf, t_min: Any = 0.0) -> np.ndarray:
        """(...) int32: how many surfaces each ray crosses. Rays and errors as for `intersect`.

        A closed surface of triangles or polygons is crossed an odd number of times from within, an even one
        from outside, also through edges and corners and along faces; what is only touched counts 0 or 2.
        """
        return queries.count_hits(self.device, self.world, Batch(origins, directions, t_min, t_max))

    @public
    @_one_at_a_time
    def all_hits(
        self, origins: Any, directions: Any, t_max: Any = np.inf, t_min: Any = 0.0,
        fields: Sequence[str] | None = None,
    ) -> Crossings:
        """All that rays cross, counted as by `count_hits`, in the order of (t, primitive) along each ray.

        Rays, fields and errors as for `intersect`.
        """
        names = check_fields(fields)
        batch = Batch(origins, directions, t_min, t_max)
        return queries.all_hits(self.device, self.world, batch, names, self._turned())

    def _turned(self) -> np.ndarray | None:
        """As `turned_meshes`, looked for once for all questions about the same shapes."""
        shapes = self._scene.shapes
        if self._known is None or self._known[0] is not shapes:
            self._known = shapes, turned_meshes(shapes)
        return self._known[1]

    @public
    @_one_at_a_time
    def radiance(
        self, origins: Any, directions: Any, max_depth: int | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Radiance along rays, (..., 3) float32 linear Rec.709, and ray counts as in Image.stats.

        origins, directions: (..., 3), as for `intersect`; max_depth (>= 0): in place of the scene's. Each ray
        starts in the media that its origin lies in. Raises LimitError for more depth, work (counted as for
        pictures) or bytes of answers than may be, and ClrtError as `intersect`.
        """
        depth = depth_of(self.scene, max_depth, self.settings.limits)
        task = Job(self.flat, depth, settings=self.settings)
        counts = RayCounts()
        batch = Batch(origins, directions, 0.0, np.inf)
        self.settings.limits.check("host_bytes", batch.n * LIGHT_BYTES, place="rays")  # a view may be small
        check_work(self.flat, self.settings.limits, batch.n, depth, "rays")
        pieces = [*ray_chunks(*batch.flat(), np.inf, self.tile, self.settings.limits, LIGHT_BYTES)][::-1]
        found = np.empty((batch.n, 3), np.float32)
        for (_, _, _, numbers), tile in task.tiles(self.device, self.world, pieces):
            found[numbers] = tile.layers["image"]
            counts.merge(tile.rays)
        return found.reshape(*batch.shape, 3), dict(counts.table())
