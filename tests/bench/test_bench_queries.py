"""The benchmark of queries: beside their kernels, and beside embreex where that is installed."""

from __future__ import annotations

import sys
import time
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.bench import embree, queries, report, suite


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


class FromC:
    """What the benchmark needs of a yardstick; its call for 16 coherent rays is the quickest."""

    def __init__(self, build: SimpleNamespace, mode: str) -> None:
        self.build, self.mode, self.open = build, mode, True
        self.asked: list[tuple[int, bool, bool]] = []

    def trace(self, rays: np.ndarray, width: int, coherent: bool, occlusion: bool) -> None:
        assert self.open and rays.shape == (7, 128 * 128) and rays.dtype == np.float32
        assert np.isinf(rays[6]).all() and np.linalg.norm(rays[3:6], axis=0) == pytest.approx(1, abs=1e-6)
        self.asked.append((width, coherent, occlusion))
        end = time.process_time() + (0.001 if (width, coherent) == (16, True) else 0.004)
        while time.process_time() < end:
            pass

    def close(self) -> None:
        self.open = False


def test_embree_s_own_calls_stand_beside_the_many_rays(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[FromC] = []

    def committed(build: SimpleNamespace, shape: embree.Geometry, mode: str) -> FromC:
        assert shape.primitives == 20_000
        made.append(FromC(build, mode))
        return made[-1]

    monkeypatch.setitem(sys.modules, "embreex", None)
    monkeypatch.setattr(embree, "builds", lambda isa: (SimpleNamespace(version="4.4", tag=", 4.4", isa=""),))
    monkeypatch.setattr(embree, "commit", committed)
    plan = suite.Plan(groups=["queries"], rounds=1, quick=True, embree=True)
    found = list(suite.run(plan).measurements)
    assert [yardstick.mode for yardstick in made] == list(embree.MODES)
    assert not any(yardstick.open for yardstick in made)
    for yardstick in made:
        assert set(yardstick.asked) == {(*call, kind) for call in embree.CALLS for kind in (False, True)}
    calls = {m.name: m for m in found if not m.queue}
    for name in (queries.NEAREST, queries.BLOCKED):
        times = {m.queue: m.median for m in found if m.name == name and "robust" in m.queue}
        assert len(times) == len(embree.CALLS) and "Embree robust 16 coherent, 4.4" in times
        best = min(times.values())  # not surely that of 16: whoever else runs may delay any of them
        assert queries.ratio(found, calls[name], "Embree robust") == best / calls[name].median
    for name in (queries.ALL, f"{queries.NEAREST}, 1000 rays"):  # Embree gives less, or is not asked
        assert queries.ratio(found, calls[name], "Embree robust") is None
    (table,) = report.tables(report.Report({}, tuple(found)))
    cells = {name: list(table.columns[at].cells) for name, at in (("query", 1), ("beside", -1))}
    both = " / ".join(queries.said(found, calls[queries.BLOCKED], call) for call in queries.CALLS)
    assert dict(zip(cells["query"], cells["beside"], strict=True))[queries.BLOCKED] == both != ""
    assert str(table.columns[-1].header) == report.BESIDE_C and "Embree" not in "".join(cells["query"])
