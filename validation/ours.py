"""Our own pictures as the comparison wants them: apart by generation and kind of ray, and by term."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import numpy as np

from clrt import passes
from clrt.device import Device
from clrt.film import Film
from clrt.flatten import flatten_camera
from clrt.immersion import immerse
from clrt.queues import Lit, Queue
from clrt.schedule import TooLarge, complete
from clrt.tiles import tiles
from clrt.tracer import Tracer
from clrt.version import __version__
from clrt.wavefront import trace

from .types import OracleImage

TERMS = ("emission", "ambient", "diffuse", "highlight")  # of the local light of generation 0
_TILE = 1 << 15  # rays
_BUDGET = 256 << 20  # bytes of queues


class RayFilm(Film):
    """A film that also keeps what each generation and kind of rays brings, on a film of its own."""

    def __init__(
        self, device: Device, pixels: int, layers: tuple[str, ...], response: np.ndarray | None = None
    ) -> None:
        super().__init__(device, pixels, layers)
        self.response = response
        self.by_ray: dict[str, Film] = {}

    def add(self, queue: Queue, lit: Lit, generation: int) -> None:
        """As Film.add; a queue is one kind of ray of one generation."""
        super().add(queue, lit, generation)
        key = ray_key(generation, queue.kind)
        apart = self.by_ray.setdefault(key, Film(self.device, self.pixels, ()))
        apart.add(queue, lit, generation)

    def developed(self, samples: int) -> Iterator[tuple[str, np.ndarray]]:
        """Each picture by its key, "image" or one of `by_ray`: float32 (pixels, 3)."""
        for name, values in zip(self.planes, self.develop(samples, self.response), strict=True):
            yield name if name == "image" else ray_key(0, f"camera {name}"), values
        for key, film in self.by_ray.items():
            yield key, film.develop(samples, self.response)[0]


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
    found: dict[str, np.ndarray] = {
        "t": np.full(columns * rows, np.inf, np.float32),
        "shape": np.full(columns * rows, -1, np.int32),
    }
    buffer = tracer.device.upload(camera)
    waiting = list(tiles(columns, rows, (0, 0, columns, rows), max(1, _TILE // samples)))
    while waiting:
        pixels = waiting.pop()
        try:
            _render_tile(tracer, buffer, pixels, samples, depth, shadows, found)
        except TooLarge:
            if len(pixels) < 2:
                raise
            waiting += np.array_split(pixels, 2)
        tracer.device.finish()
    pictures = {key: values.reshape(rows, columns, *values.shape[1:]) for key, values in found.items()}
    t, shape, pixels = pictures.pop("t"), pictures.pop("shape"), pictures.pop("image")
    name = f"clrt {__version__} on {tracer.device.info.label}"
    return OracleImage(pixels, dict(sorted(pictures.items())), t, shape, name, time.perf_counter() - start)


def _render_tile(
    tracer: Tracer,
    camera: Any,
    pixels: np.ndarray,
    samples: int,
    depth: int,
    shadows: bool,
    found: dict[str, np.ndarray],
) -> None:
    """Render these pixels and put them into `found`, arrays over all pixels."""
    device, world = tracer.device, tracer.world
    queue, _ = passes.generate(device, camera, pixels, samples)
    immerse(device, world, queue)
    hits = passes.closest(device, world, queue)
    film = RayFilm(device, len(pixels), TERMS if shadows else (), tracer.flat.response)
    complete(trace(device, world, queue, hits, film, depth, _BUDGET, shadows=shadows))
    for key, values in film.developed(samples):
        if key not in found:
            found[key] = np.zeros((len(found["t"]), 3), np.float32)
        found[key][pixels] = values
    geometry = passes.geometry(device, world, queue, hits, samples)
    found["t"][pixels], found["shape"][pixels] = geometry["depth"], geometry["shape"]
