"""Fixtures of the tests of farms."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

import clrt
from clrt.cluster import connect, pictures, worker


@pytest.fixture(scope="module", autouse=True)
def environment() -> Iterator[None]:
    """As it was: with the allocator that dask sets for workers other tests' programs hold other memory."""
    with connect.environment_kept(connect.FOR_WORKERS):
        yield


@pytest.fixture
def fresh(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A worker that knows nothing, whose device needs no proof; small pieces."""
    worker._bench.cache_clear()
    monkeypatch.setattr(worker, "check", lambda device: None)
    monkeypatch.setattr(pictures, "_LEAST", 100)
    yield
    worker._bench.cache_clear()


@pytest.fixture(scope="module")
def mesh() -> clrt.Scene:
    """A scene with an array that travels alone."""
    side = np.linspace(-1, 1, 24)
    x, z = (array.reshape(-1) for array in np.meshgrid(side, side))
    corner = (np.arange(23)[:, None] * 24 + np.arange(23)).reshape(-1)
    faces = np.concatenate([corner[:, None] + [0, 24, 1], corner[:, None] + [1, 24, 25]])
    vertices = np.stack([x, 0.2 * np.sin(7 * x) * np.cos(5 * z), z], 1)
    shape = {"type": "mesh", "vertices": vertices.tolist(), "faces": faces.tolist(), "material": "m"}
    camera = {"origin": [0, 2, 3], "target": [0, 0, 0], "width": 40, "height": 30}
    light = {"type": "point", "position": [1, 3, 1]}
    materials = {"m": {"diffuse": 0.5, "specular": 0.4, "reflection": 0.3}}
    return clrt.load_dict({"camera": camera, "lights": [light], "materials": materials, "shapes": [shape]})
