"""A scene as the reference of a comparison: rendered, changed and rendered again, in one size."""

from __future__ import annotations

from dataclasses import dataclass, replace

from msgspec import structs

from clrt.device.settings import Settings
from clrt.engine.tracer import Tracer
from clrt.scene.scene import Scene

from ..ours import render_ours
from .metrics import DIAGONAL, EDGE_STEP, Array, edge_mask

_PARTS = 16  # times the pixels of a picture that it is looked for in, at most


@dataclass(frozen=True)
class SceneReference:
    """A scene as the reference: rendered, changed and rendered again, in one size."""

    scene: Scene
    width: int
    height: int
    device: int | str | None = None
    settings: Settings | None = None
    exposure: float = 1.0  # by which pictures are multiplied
    own: tuple[int, int] | None = None  # width and height that the scene states, if it was given others

    def whole(self) -> SceneReference | None:
        """The scene in its own size, where that is a larger one: a picture may be a part of that."""
        if self.own is None or self.own[0] <= self.width or self.own[1] <= self.height:
            return None
        width, height = self.own
        if width * height > _PARTS * self.width * self.height:
            return None
        scene = self.scene.override(width=width, height=height)
        return replace(self, scene=scene, width=width, height=height)

    def render(self, scene: Scene | None = None, shadows: bool = True) -> Array:
        """The linear picture of the scene, or of a changed one."""
        tracer = Tracer(scene or self.scene, self.device, self.settings)
        if shadows:
            pixels = tracer.render(self.width, self.height).pixels
        else:
            pixels = render_ours(tracer, self.width, self.height, shadows=False).pixels
        return pixels if self.exposure == 1.0 else self.exposure * pixels

    def layer(self, scene: Scene, name: str) -> Array:
        """A layer of a scene's picture."""
        tracer = Tracer(scene, self.device, self.settings)
        return tracer.render(self.width, self.height, layers=[name]).layers[name]

    def edges(self, reference: Array) -> Array:
        """Pixels (h, w) where the picture jumps: see `edge_mask`."""
        camera = self.scene.camera
        assert camera is not None
        shifted = []
        for x, y in DIAGONAL:
            shift = camera.shift[0] + EDGE_STEP * x, camera.shift[1] + EDGE_STEP * y
            changed = structs.replace(self.scene, camera=structs.replace(camera, shift=shift))
            shifted.append(self.render(changed))
        return edge_mask(reference, shifted)


def reference_of(
    scene: Scene,
    shape: tuple[int, ...] | None = None,
    device: int | str | None = None,
    settings: Settings | None = None,
) -> SceneReference:
    """The scene to render: in a picture's size (h, w), if that has the camera's aspect to within a pixel."""
    assert scene.camera is not None
    width, height = own = scene.camera.width, scene.camera.height
    if shape and abs(shape[1] * height / width - shape[0]) <= 1:
        height, width = shape[:2]
        scene = scene.override(width=width, height=height)
    return SceneReference(scene, width, height, device, settings, own=own)
