"""The two computations of the image model that tests ask the same questions: oracle and kernels."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np

import clrt
from validation.oracle64 import radiance64, render64, trace64


@dataclass(frozen=True)
class Hits:
    """Nearest hits in float64; inf and -1 for a miss."""

    t: np.ndarray
    primitive: np.ndarray
    shape: np.ndarray
    normal: np.ndarray


class Engine(ABC):
    """Rays are (n, 3) arrays, or single vectors."""

    name: str

    def tolerance(self, float32: float, float64: float = 1e-9) -> float:
        """How far this engine's numbers may be off; both given, as each has its own reason."""
        return float32 if self.name == "kernels" else float64

    @abstractmethod
    def intersect(self, scene: clrt.Scene, origins: Any, directions: Any) -> Hits: ...

    @abstractmethod
    def radiance(self, scene: clrt.Scene, origins: Any, directions: Any) -> tuple[np.ndarray, dict[str, int]]:
        """Radiance (n, 3) and the counts of rays."""

    @abstractmethod
    def layer(self, scene: clrt.Scene, name: str) -> np.ndarray:
        """A layer of the scene's picture."""


class Oracle64(Engine):
    name = "oracle64"

    def intersect(self, scene: clrt.Scene, origins: Any, directions: Any) -> Hits:
        hits = trace64(scene, origins, directions)
        return Hits(hits.t, hits.primitive, hits.shape, hits.normal)

    def radiance(self, scene: clrt.Scene, origins: Any, directions: Any) -> tuple[np.ndarray, dict[str, int]]:
        light, stats = radiance64(scene, origins, directions)
        return light, stats["rays"]

    def layer(self, scene: clrt.Scene, name: str) -> np.ndarray:
        return np.asarray(render64(scene, layers=[name]).layers[name])


class Kernels(Engine):
    name = "kernels"

    def intersect(self, scene: clrt.Scene, origins: Any, directions: Any) -> Hits:
        hits = clrt.Tracer(scene).intersect(np.reshape(origins, (-1, 3)), np.reshape(directions, (-1, 3)))
        return Hits(hits.t.astype(float), hits.primitive, hits.shape, hits.normal.astype(float))

    def radiance(self, scene: clrt.Scene, origins: Any, directions: Any) -> tuple[np.ndarray, dict[str, int]]:
        rays = np.reshape(origins, (-1, 3)), np.reshape(directions, (-1, 3))
        light, stats = clrt.Tracer(scene).radiance(*rays)
        return light.astype(float), stats["rays"]

    def layer(self, scene: clrt.Scene, name: str) -> np.ndarray:
        return np.asarray(clrt.Tracer(scene).render(layers=[name]).layers[name], float)


ENGINES = {"oracle64": Oracle64(), "kernels": Kernels()}


def unit(v: Any) -> np.ndarray:
    """`v` at length 1."""
    v = np.asarray(v, float)
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))
