"""What a page is answered: the scene, its pictures, a pixel's rays, files. Knows no network and no notebook.

A page states all that it wants with every question (camera, changes, size), so nothing is kept between two
of them, and several pages may look at one scene. Of a page's questions for pictures the last one wins:
a picture that nobody waits for any more is given up after the tile that is under way.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from clrt.base import arguments, notices
from clrt.base.errors import ClrtError, SceneError, exhausted, legible, show
from clrt.base.layers import LAYERS, Spectral, comes_from, find
from clrt.base.places import At
from clrt.scene.camera import Camera
from clrt.scene.edit import kept
from clrt.scene.scene import Scene, previewed, read_camera
from clrt.view.knobs import checked, knobs
from clrt.view.pixel import told

if TYPE_CHECKING:
    from clrt.engine.tracer import Tracer
    from clrt.images.image import Image

Answer = tuple[dict[str, Any], bytes]
Gone = Callable[[], bool]

_MOST_SIDE: Final = 4096  # in a row or column
_PAGES: Final = 64  # whose last question is remembered
_CAMERA: Final = ("origin", "target", "up", "fov", "size", "aperture", "focus")
_HALF: Final = 65504.0  # the largest float16
_GROUPS: Final = {
    "by its first bounce": ("direct", "reflection", "transmission"),
    "terms of the first hit": ("ambient", "diffuse", "highlight", "emission"),
    "the first hit": ("depth", "normal", "position", "shape"),
}


class Superseded(Exception):
    """Nobody waits for this picture any more."""


def answered(ask: Callable[[], Answer]) -> Answer:
    """An answer; or what is wrong with the question, or what of the machine ran out for it."""
    try:
        return ask()
    except ClrtError as error:
        said = str(error)
    except (MemoryError, OSError, RuntimeError, ImportError) as error:
        said = exhausted(error)
        if not said:
            raise
    return {"error": legible(said)}, b""


def without_camera(scene: Scene) -> SceneError:
    """What is wrong with a scene that has none."""
    return SceneError(f"{scene.source or 'scene'}: camera: missing; to look at the scene it needs a [camera]")


class Session:
    """A scene on a device, and its answers. Threads may share it. Raises SceneError without a camera."""

    def __init__(self, tracer: Tracer) -> None:
        self.tracer = tracer
        self.scene = tracer.scene  # as it was at first: changes count from here
        if self.scene.camera is None:
            raise without_camera(self.scene)
        self.camera: Camera = self.scene.camera
        self.knobs = {knob["place"]: knob for knob in knobs(self.scene)}
        self._lock = threading.Lock()  # one question at a time
        self._made = ("{}", self.scene)  # the last changes, and the scene with them
        self._latest: dict[str, int] = {}

    def answer(self, kind: str, body: object, gone: Gone = lambda: False) -> Answer:
        """The answer to a question: a table, and bytes. ClrtError says what is wrong with the question.

        gone: whether the page that asks has gone away.
        """
        asked = {"open": self._open, "frame": self._frame, "pixel": self._pixel, "save": self._save}
        if kind not in asked:
            raise ClrtError(f"{show(kind)} is no question; it must be one of {', '.join(asked)}")
        given = arguments.mapping("body", body)
        return asked[kind](dict(given), gone)

    # --- the scene

    def _open(self, body: dict[str, Any], gone: Gone) -> Answer:
        camera, scene = self.camera, self.scene
        names = {group: list(held) for group, held in _GROUPS.items()}
        names["by generation"] = [f"generation_{g}" for g in range(min(scene.max_depth, 32) + 1)]
        if scene.spectrum is not None:
            names["colour"] = [name for name in LAYERS if comes_from(name, Spectral) and find(name).is_shown]
        state = {name: getattr(camera, name) for name in ("type", "fov_axis", *_CAMERA)}
        return {
            "title": legible(scene.source or "scene"), "size": [camera.width, camera.height],
            "spp": int(camera.spp) if isinstance(camera.spp, int) else 1,
            "adaptive": scene.adaptive is not None,
            "camera": state | {"focus": camera.in_focus}, "mirror": camera.mirror,
            "layers": [{"group": group, "names": held} for group, held in names.items()],
            "knobs": [
                knob | {"group": legible(knob["group"]), "label": legible(knob["label"])}
                for knob in self.knobs.values()
            ],
        }, b""  # fmt: skip

    def shown(self, body: dict[str, Any]) -> tuple[Scene, Camera]:
        """The scene with a page's changes, and its camera. ClrtError for what may not be changed."""
        changes = checked(body.get("changes", {}), self.knobs)
        key = json.dumps(changes, sort_keys=True)
        made, scene = self._made
        if key != made:
            scene = self.scene.replace(changes)
            self._made = key, scene
        given = arguments.mapping("camera", body.get("camera", {}))
        for name in given:
            if name not in _CAMERA:
                raise ClrtError(
                    f"camera: {show(name)} cannot be changed here; it can be {', '.join(_CAMERA)}"
                )
        camera = read_camera({**kept(self.camera, Camera, given), **given}, At(self.scene.source))
        assert camera is not None
        return scene, camera

    # --- pictures

    def _frame(self, body: dict[str, Any], gone: Gone) -> Answer:
        page, number = (
            arguments.text("page", body.get("page", "")),
            arguments.whole("number", body.get("number", 0)),
        )
        self._latest[page] = max(number, self._latest.get(page, 0))
        while len(self._latest) > _PAGES:
            self._latest.pop(next(iter(self._latest)), None)
        try:
            image, layer = self._render(body, lambda: self._latest.get(page, number) > number or gone())
        except Superseded:
            return {"superseded": True}, b""
        pixels = np.clip(np.nan_to_num(image.pixels), -_HALF, _HALF).astype("<f2")
        light = layer == "image" or find(layer).is_light
        return {
            "width": image.width,
            "height": image.height,
            "layer": layer,
            "light": light,
        }, pixels.tobytes()

    def _render(self, body: dict[str, Any], stale: Gone) -> tuple[Image, str]:
        """The picture or layer that is asked for, and which. Superseded where nobody waits for it."""
        size = self._size(body)
        layer = arguments.text("layer", body.get("layer", "image"))

        def look(done: int, total: int, rays: int) -> None:
            if done < total and stale():
                raise Superseded

        with self._lock:
            look(0, 1, 0)
            scene, camera = self.shown(body)
            self.tracer.update(previewed(scene, size[2]))
            layers = () if layer == "image" else (layer,)
            with notices.without("too few to be weighed"):  # of coarse pictures
                image = self.tracer.render(*size, layers=layers, progress=look, camera=camera)
        return (image.layer(layer) if layers else image), layer

    def _size(self, body: dict[str, Any]) -> tuple[int, int, int]:
        """Width, height, samples a pixel."""
        width, height = (arguments.whole(name, body.get(name), 1, _MOST_SIDE) for name in ("width", "height"))
        return width, height, arguments.whole("spp", body.get("spp", 1), 1)

    def _pixel(self, body: dict[str, Any], gone: Gone) -> Answer:
        x, y = (arguments.whole(name, body.get(name)) for name in ("x", "y"))
        size = self._size(body)
        with self._lock:
            scene, camera = self.shown(body)
            self.tracer.update(previewed(scene, size[2]))
            tree = self.tracer.explain(x, y, *size, camera=camera)
        table = told(tree)
        try:
            json.dumps(table, allow_nan=False)  # which is all that a browser can read
        except ValueError:
            raise ClrtError(f"pixel ({x}, {y}): its rays bring light that is not finite") from None
        return table, b""

    # --- files

    def _save(self, body: dict[str, Any], gone: Gone) -> Answer:
        from clrt.view.files import picture_file, scene_file

        what = body.get("what")
        if what == "scene":
            with self._lock:
                scene, camera = self.shown(body)
            return scene_file(scene.replace({"camera": camera}))
        if what not in ("png", "exr"):
            raise ClrtError(f"what: {show(what)} is not allowed; it must be 'scene', 'png' or 'exr'")
        exposure = arguments.number("exposure", body.get("exposure", 0.0))
        if not -100 <= exposure <= 100:
            raise ClrtError(f"exposure: {exposure} is not allowed; use a number from -100 to 100 stops")
        try:
            image, layer = self._render(body, gone)
        except Superseded:
            return {"superseded": True}, b""
        light = layer == "image" or find(layer).is_light
        return picture_file(image, self.scene.source, what, exposure if light else 0.0)
