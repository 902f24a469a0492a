"""What client and worker tell each other: an order, and one of three answers. Plain data that pickles."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from clrt.base.errors import ClrtError
from clrt.device.settings import Settings
from clrt.engine.wavefront import KINDS, RayCounts


@dataclass(frozen=True)
class Order:
    """Pixels to be traced: a pure task, that gives the same bits wherever and however often it is done.

    scene, kernels: hashes that the worker must find, too. needs: large arrays of the scene, by `parcels`;
    recipe (b"": none), arrays: what the worker said that it lacks. pixels: y * width + x, (n,) uint32.
    mattes: what shapes count as, by layer, as `coverage.mattes` gives it.
    """

    version: str
    scene: str
    kernels: str
    recipe: bytes
    needs: tuple[str, ...]
    device: int | str | None
    settings: Settings
    max_depth: int
    camera: np.ndarray
    layers: tuple[str, ...]
    pixels: np.ndarray
    adaptive: tuple[int, float] | None = None
    arrays: dict[str, np.ndarray] = field(default_factory=dict)
    mattes: Mapping[str, np.ndarray] = field(default_factory=dict)

    def seal(self) -> bytes:
        """SHA-256 of what is asked for."""
        asked = repr((self.scene, self.kernels, self.max_depth, self.layers, self.adaptive)).encode()
        named = b"".join(name.encode() + ids.tobytes() for name, ids in self.mattes.items())
        return hashlib.sha256(asked + self.camera.tobytes() + self.pixels.tobytes() + named).digest()


@dataclass(frozen=True)
class Worker:
    """Who answers: host and process, and the address by which dask knows it ("" elsewhere)."""

    host: str
    pid: int
    address: str = ""

    def __str__(self) -> str:
        return f"{self.host}, process {self.pid}"


@dataclass(frozen=True)
class Answer:
    """The pixels of an order, in its order: float32 (n, ...) by layer, and what they cost.

    kernels, device: what made them. seconds: by kernel, and of it all (`wall`). setup: seconds until the
    worker had scene and kernels. orders: how many it has done so far. seal: as `sealed` gives it.
    """

    worker: Worker
    layers: dict[str, np.ndarray]
    rays: RayCounts
    local_size: int
    kernels: str
    device: str
    seconds: dict[str, float]
    wall: float
    setup: float
    orders: int
    seal: bytes


@dataclass(frozen=True)
class Lacking:
    """The worker has neither the scene, its recipe, nor these arrays; nothing was done."""

    worker: Worker
    arrays: tuple[str, ...]


@dataclass(frozen=True)
class Refusal:
    """The worker cannot do it, or must not: why."""

    worker: Worker
    error: ClrtError


def sealed(order: Order, layers: dict[str, np.ndarray], rays: RayCounts, local_size: int) -> bytes:
    """SHA-256 of an order and its outcome: what arrives is what was made, for what was asked."""
    found = hashlib.sha256(order.seal())
    for name in sorted(layers):
        array = np.ascontiguousarray(layers[name])
        found.update(f"{name} {array.dtype.str} {array.shape}\n".encode())
        found.update(array.view(np.uint8).data)
    counts = [[row[kind] for kind in KINDS] for row in rays.generations]
    found.update(f"{counts} {local_size}".encode())
    return found.digest()
