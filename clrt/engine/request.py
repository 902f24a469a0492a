"""What is asked of a `Tracer`: a picture or a depth, checked against what may be asked, and as a job."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from clrt import layout
from clrt.base import arguments, notices
from clrt.base.errors import SceneError
from clrt.base.layers import check_layers
from clrt.base.places import At
from clrt.device.settings import Settings
from clrt.engine.coverage import mattes
from clrt.engine.job import Job
from clrt.engine.picture import check_crop, picture_bytes
from clrt.flatten.flatten import FlatScene, flatten_camera
from clrt.flatten.work import check_limits, depth_of
from clrt.scene.camera import Camera
from clrt.scene.scene import Scene, read_camera


@dataclass(frozen=True)
class Request:
    """A picture as `Tracer.render` is asked for it; None is what the scene says."""

    width: int | None = None
    height: int | None = None
    spp: int | None = None
    max_depth: int | None = None
    layers: Sequence[str] = ()
    crop: tuple[int, int, int, int] | None = None
    camera: Camera | Mapping[str, Any] | None = None

    def job(
        self, scene: Scene, flat: FlatScene, settings: Settings
    ) -> tuple[Job, tuple[int, int], tuple[int, int, int, int]]:
        """What is to be rendered, the size of the whole picture, and the window of it; checked."""
        width, height = (
            arguments.optional(name, getattr(self, name), 1) for name in ("width", "height")
        )
        spp, layers = arguments.optional("spp", self.spp, 1), arguments.names("layers", self.layers)
        camera = camera_of(scene, self.camera)
        view = flatten_camera(camera, width, height, spp)
        full = int(view["width"][0]), int(view["height"][0])
        depth = depth_of(scene, self.max_depth, settings.limits)
        names = check_layers(layers, depth, flat.response is not None, flat.pictures is not None)
        window = check_crop(self.crop, *full)
        grid = finest = int(view["grid"][0])
        adaptive = None
        if scene.adaptive is not None:
            scene.adaptive.check_reached(grid**2, At(scene.source, "adaptive"))
            finest = math.isqrt(scene.adaptive.spp)
            adaptive = (finest, scene.adaptive.threshold) if finest > grid else None
        enough = layout.filter_grid(camera.filter)
        if grid < enough and adaptive is None:
            few = "1 sample" if grid == 1 else f"{grid**2} samples"
            text = f"{camera.filter!r} weighs {few} a pixel, too few to be weighed; spp = {enough**2} or more"
            notices.warn(scene.source, "camera.filter", text)
        check_limits(flat, settings.limits, full[0] * full[1], finest**2, depth)
        settings.limits.check("host_bytes", picture_bytes(window, names, flat.bands))
        return Job(flat, depth, view, names, settings, adaptive, mattes(scene, names)), full, window


def camera_of(scene: Scene, given: Camera | Mapping[str, Any] | None) -> Camera:
    """The camera that is given, else the scene's."""
    camera = scene.camera if given is None else read_camera(given, At())
    if camera is None:
        raise SceneError(f"{scene.source or 'scene'}: camera: missing; a picture needs a [camera]")
    return camera
