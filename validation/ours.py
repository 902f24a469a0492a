"""Our own pictures as the comparison wants them: apart by generation and kind of ray, and by term."""

from __future__ import annotations

import time
from typing import Final

import numpy as np

from clrt import layout
from clrt.base.layers import TERMS
from clrt.device.device import Device
from clrt.engine.film import Film
from clrt.engine.job import Job, halves
from clrt.engine.queues import Feelers, Shaded, Weights
from clrt.engine.schedule import Work, interleaved
from clrt.engine.stage import Stage
from clrt.engine.tiles import tiles
from clrt.engine.tracer import Tracer
from clrt.flatten.flatten import flatten_camera
from clrt.spectra.colorimetry import finished
from clrt.version import __version__

from .types import OracleImage

_TILE = 1 << 15  # rays
_BUDGET = 256 << 20  # bytes of queues
LAYERS: Final[tuple[str, ...]] = (
    "depth", "shape", "z", "distance", "normal", "shading_normal", "albedo", "uv", "material", "alpha",
)  # fmt: skip


class Shares:
    """An observer that keeps what each generation and kind of rays brings, on a film of its own."""

    def __init__(self, device: Device, pixels: int) -> None:
        self._device, self._pixels = device, pixels
        self._films: dict[str, Film] = {}
        self._weights: Weights | None = None

    def __call__(self, stage: Stage) -> None:
        if isinstance(stage.wrote, Weights):
            self._weights = stage.wrote
        if stage.name == "illuminate" and isinstance(stage.wrote, Shaded) and not stage.term:
            key = ray_key(stage.generation, stage.kind)
            film = self._films.setdefault(key, Film(self._device, self._pixels, (), self._weights))
            film.add(stage.queue, stage.wrote, stage.generation)

    def developed(self, samples: int, response: np.ndarray | None) -> dict[str, np.ndarray]:
        """Each share by its key of `OracleImage.by_ray`: float32 (pixels, 3)."""
        means = {key: film.developing(samples, response) for key, film in self._films.items()}
        return {key: finished(answer.wait())[0] for key, answer in means.items()}


def unshadowed(stage: Stage) -> None:
    """An observer that lets every opaque feeler arrive."""
    if isinstance(stage.wrote, Feelers) and stage.wrote.n:
        stage.queue.device.write(stage.wrote.seen, np.full(stage.wrote.n, layout.SEEN["CLEAR"], np.uint32))


def ray_key(generation: int, kind: str) -> str:
    """A key of OracleImage.by_ray: "generation 2 reflection", with a term "generation 0 camera diffuse"."""
    return f"generation {generation} {kind}"


def render_ours(
    tracer: Tracer,
    width: int | None = None,
    height: int | None = None,
    spp: int | None = None,
    max_depth: int | None = None,
    shadows: bool = True,
) -> OracleImage:
    """What `tracer.render` gives, bit for bit, with every generation's and kind's share in `by_ray`.

    Camera rays also have their terms: "generation 0 camera highlight" and so on. `shadows=False` lets every
    opaque feeler arrive, to tell how a picture without shadows would look (and gives no terms).
    """
    start = time.perf_counter()
    scene = tracer.scene
    if scene.camera is None:
        raise ValueError("the scene has no camera")
    camera = flatten_camera(scene.camera, width, height, spp)
    columns, rows = int(camera["width"][0]), int(camera["height"][0])
    samples = int(camera["grid"][0]) ** 2
    depth = scene.max_depth if max_depth is None else max_depth
    job = Job(tracer.flat, depth, camera, (*(TERMS if shadows else ()), *LAYERS), tracer.settings)
    changes = () if shadows else (unshadowed,)

    def traced(device: Device, pixels: np.ndarray) -> Work[dict[str, np.ndarray]]:
        shares = Shares(device, len(pixels))
        tile = yield from job.trace(device, tracer.world, pixels, (*changes, shares), _BUDGET)
        terms = {ray_key(0, f"camera {name}"): tile.layers[name] for name in TERMS if shadows}
        kept = {name: tile.layers[name] for name in ("image", *LAYERS)}
        return kept | terms | shares.developed(samples, tracer.flat.response)

    pieces = list(tiles(columns, rows, (0, 0, columns, rows), max(1, _TILE // samples)))
    found: dict[str, np.ndarray] = {}
    for pixels, values in interleaved(tracer.device, pieces, traced, halves):
        for key, part in values.items():
            whole = found.setdefault(key, np.zeros((columns * rows, *part.shape[1:]), part.dtype))
            whole[pixels] = part
    pictures = {key: values.reshape(rows, columns, *values.shape[1:]) for key, values in found.items()}
    layers = {name: pictures.pop(name) for name in LAYERS}
    t, shape, image = layers.pop("depth"), layers.pop("shape"), pictures.pop("image")
    name, seconds = _name(tracer), time.perf_counter() - start
    return OracleImage(image, dict(sorted(pictures.items())), t, shape, name, seconds, layers=layers)


def render_adaptive(tracer: Tracer) -> OracleImage:
    """An adaptive picture: its rays are not told apart, and it has the layer `samples`."""
    start = time.perf_counter()
    names = (name for name in LAYERS if name != "uv" or tracer.flat.pictures is not None)
    image = tracer.render(layers=(*names, "samples"))
    layers = dict(image.layers)
    t, shape, seconds = layers.pop("depth"), layers.pop("shape"), time.perf_counter() - start
    return OracleImage(image.pixels, {}, t, shape, _name(tracer), seconds, layers=layers)


def _name(tracer: Tracer) -> str:
    return f"clrt {__version__} on {tracer.device.info.label}"
