"""The benchmark of queries: beside their kernels, and beside embreex where that is installed."""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.bench import queries, report


class StandIn:
    """What the benchmark needs of embreex's scene."""

    triangles = 0
    asked: list[dict[str, Any]]

    def __init__(self) -> None:
        self.asked = []
        StandIn.last = self

    def run(self, origins: np.ndarray, directions: np.ndarray, **how: Any) -> np.ndarray:
        assert origins.shape == directions.shape and origins.dtype == np.float32
        self.asked.append(how)
        return np.zeros(len(origins), np.int32)

    last: StandIn


def mesh(scene: StandIn, vertices: np.ndarray, faces: np.ndarray) -> None:
    assert len(vertices) == 3 * len(faces) and vertices.dtype == np.float32
    scene.triangles = len(faces)


@pytest.mark.parametrize("there", [False, True], ids=["alone", "beside embreex"])
def test_queries_stand_beside_their_kernels(there: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    names = ("rtcore_scene", "mesh_construction")
    modules = {f"embreex.{name}": ModuleType(name) for name in names} if there else {}
    for name in ("embreex", *(f"embreex.{name}" for name in names)):
        monkeypatch.setitem(sys.modules, name, modules.get(name, ModuleType(name) if there else None))
    if there:
        modules["embreex.rtcore_scene"].EmbreeScene = StandIn  # type: ignore[attr-defined]
        modules["embreex.mesh_construction"].TriangleMesh = mesh  # type: ignore[attr-defined]
    made = queries.times(1, None, clrt.Settings(), quick=True)
    assert len({m.key for m in made}) == len(made) == 17 + 9 * there
    assert queries.compared(made) is there
    calls = {m.name: m for m in made if not m.queue}
    own = calls[queries.NEAREST]
    kernel = next(m for m in made if m.queue == queries.KERNEL and m.name == own.name)
    assert queries.ratio(made, own, queries.KERNEL) == kernel.median / own.median
    assert queries.ratio(made, kernel, queries.KERNEL) is None
    assert (queries.ratio(made, own, queries.EMBREEX) is not None) is there
    assert {m.items for m in made} == {128 * 128, *queries.FEW}
    if there:
        assert StandIn.last.triangles == 20_000 and {"query": "OCCLUDED"} in StandIn.last.asked
    (table,) = report.tables(report.Report({}, tuple(made)))
    assert ("embreex is not here" in str(table.title)) is not there
