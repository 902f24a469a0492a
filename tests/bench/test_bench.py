"""The benchmarks measure what they say: the right rays, the right work; and report it."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import clrt
from clrt import layout
from clrt.bench import embree, kernels, report, roof, scaling, scenes, suite, timing, walk
from clrt.bench.machine import one_core
from clrt.bench.recorder import Recording, case
from clrt.bench.timing import Case
from clrt.cli import main
from clrt.device.device import Device
from tests.bench_samples import measurement

WIDTH = 40


@pytest.fixture(scope="module")
def scene() -> clrt.Scene:
    return scenes.flake(levels=1)


@pytest.fixture(scope="module")
def recording(scene: clrt.Scene) -> Recording:
    """Of two tiles."""
    return kernels.recorded(scene, WIDTH, None, clrt.Settings(tile=WIDTH * WIDTH // 2))


# --- what is recorded
# -------------------------------------------------------------------------------------------


def test_the_recorded_rays_are_those_of_a_render(scene: clrt.Scene, recording: Recording):
    rays = clrt.render(scene, WIDTH, WIDTH, max_depth=1).stats["generations"]
    cases = {(c.name, c.queue): c for c in kernels.cases(recording, "flake")}
    assert cases["generate", "primary"].items == cases["closest", "primary"].items == WIDTH * WIDTH
    assert cases["occluded", "shadow"].items == rays[0]["feelers"] > 0
    for kind, name in (
        ("reflection", "reflection"),
        ("transmission", "refraction"),
        ("ambient", "incoherent"),
    ):
        assert cases["closest", name].items == rays[1][kind] > 0
    assert {c.name for c in cases.values()} >= {
        "cross_boundaries",  # the glass of these scenes is nested, so their rays carry lists of media
        "shade",
        "feelers",
        "gather",
        "count",
        "scan",
        "rank",
    }
    assert len(recording.launches["closest", "primary"]) == 2  # a launch a tile


def test_traffic_is_that_of_the_queues(recording: Recording):
    """A generated ray is written once: 7 floats, 3 bands of weight, pixel and path; a number is read."""
    made = case(recording, "generate", "primary", "flake")
    assert made.nbytes == pytest.approx(made.items * 4 * (7 + 3 + 2 + 1), rel=0.01)


def test_launches_can_be_repeated_without_changing_the_queues(recording: Recording):
    before = {kind: kernels.hits_of(recording, kind) for kind in recording.rays}
    slots = recording.launches["rank", "generation 2"][0].arguments[-1]
    contents = recording.device.read(slots, np.empty(100, np.uint32))
    chunks, places, _ = recording.launches["offsets", "primary"][0].arguments
    firsts = recording.device.read(places, np.empty(int(chunks), np.uint32))
    assert firsts[-1] > firsts[1] > 0  # of the feelers, by which their pass writes
    cases = kernels.cases(recording, "flake")
    assert {c.name for c in cases if c.reset} == {"rank", "illuminate", "gather", "resolve"}
    for made in cases:
        for _ in range(2):
            if made.reset:
                made.reset()
            made.run()
            found = recording.device.read(places, np.empty(int(chunks), np.uint32))
            assert np.array_equal(found, firsts), made.name
    for made in cases:
        if made.reset:
            made.reset()
    assert np.array_equal(recording.device.read(slots, np.empty(100, np.uint32)), contents)
    for kind, hits in before.items():
        assert np.array_equal(kernels.hits_of(recording, kind), hits)


def test_rays_come_back_as_they_were_made(scene: clrt.Scene, recording: Recording):
    rays = kernels.rays_of(recording, "primary")
    assert rays.shape == (7, WIDTH * WIDTH) and np.isinf(rays[6]).all()
    assert scene.camera is not None
    assert np.allclose(rays[:3].T, np.float32(scene.camera.origin))
    assert np.linalg.norm(rays[3:6], axis=0) == pytest.approx(1, abs=1e-6)
    hits = clrt.Tracer(scene).intersect(rays[:3].T, rays[3:6].T)
    assert np.array_equal(hits.primitive, kernels.hits_of(recording, "primary"))


@pytest.mark.parametrize("name", ["needles", "grains"])
def test_loose_triangles_are_thin_and_of_all_sizes(name: str) -> None:
    mesh = scenes.make(name, quick=True).shapes[0].data()  # type: ignore[union-attr]
    corners = np.asarray(mesh.vertices, np.float64)[np.asarray(mesh.faces)]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    area = np.linalg.norm(np.cross(*(corners[:, k] - corners[:, 0] for k in (1, 2))), axis=1)
    assert len(corners) == 20_000
    if name == "needles":
        assert sides.min() > 1.9 and (area / sides**2).max() < 0.021  # width over length
    else:
        assert sides.max() / sides.min() > 800 and 0.05 < np.median(sides) < 0.1
    plan = suite.Plan(groups=["kernels", "builder"], names=[name], rounds=9, quick=True)
    made = suite.run(dataclasses.replace(plan, rounds=1)).measurements
    assert {m.queue for m in made if m.group == "tracing"} == set(kernels.RAY_KINDS)
    assert not [m for m in made if m.group == "shading"] and [m for m in made if m.group == "builder"]
    assert plan.turns(name) == 3 and plan.turns("flake") == 9


# --- what a walk cannot avoid
# -----------------------------------------------------------------------------------


def visits_one_by_one(
    nodes: np.ndarray, origin: np.ndarray, direction: np.ndarray, t: float
) -> tuple[int, int]:
    """Nodes and blocks, by recursion over one ray."""

    def visit(number: int) -> tuple[int, int]:
        visited, blocks = 1, 0
        low, high = nodes[number]["planes"].reshape(3, 2, layout.WIDE).transpose(1, 2, 0)
        for k, child in enumerate(nodes[number]["child"]):
            a, b = (low[k] - origin) / direction, (high[k] - origin) / direction
            if (low[k] > high[k]).any() or max(np.minimum(a, b).max(), 0) > min(np.maximum(a, b).min(), t):
                continue
            if child < 0:
                blocks += 1
            else:
                more = visit(child)
                visited, blocks = visited + more[0], blocks + more[1]
        return visited, blocks

    return visit(0)


def test_visits_are_counted_as_by_recursion(recording: Recording):
    nodes = walk.read_nodes(recording.device, recording.world)
    rng = np.random.default_rng(1)
    origins = rng.normal(size=(60, 3)) * 3
    directions = -origins + rng.normal(size=(60, 3)) * 0.5
    t = np.where(rng.random(60) < 0.5, np.inf, 0.7)
    found = walk.count_visits(nodes, origins, directions, t)
    wanted = [visits_one_by_one(nodes, *ray) for ray in zip(origins, directions, t, strict=True)]
    assert found.nodes == pytest.approx(np.mean([nodes for nodes, _ in wanted]))
    assert found.blocks == pytest.approx(np.mean([blocks for _, blocks in wanted])) and found.blocks > 0.3
    assert found.nbytes(1) < found.nbytes(2) and found.nbytes(10**9) == found.tree_bytes


# --- how times are taken
# ----------------------------------------------------------------------------------------


def test_cases_are_interleaved_warmed_up_and_repeated(monkeypatch: pytest.MonkeyPatch):
    order: list[str] = []
    clock = {"seconds": 0.0}

    def runner(name: str, cost: float) -> Case:
        def run() -> None:
            order.append(name)
            clock["seconds"] += cost

        return Case(group="g", name=name, run=run, clock="cpu")

    monkeypatch.setitem(timing.CLOCKS, "cpu", lambda: clock["seconds"])
    slow, fast = timing.measure([runner("slow", 1.0), runner("fast", timing.SHORTEST / 3.5)], rounds=3)
    assert order == ["slow"] * 2 + ["fast"] * 2 + (["slow"] + ["fast"] * 4) * 3
    assert slow.seconds == pytest.approx((1.0,) * 3)
    assert fast.seconds == pytest.approx((timing.SHORTEST / 3.5,) * 3) and fast.spread == pytest.approx(
        0, abs=1e-9
    )


def test_a_case_is_readied_outside_the_time_and_may_time_itself(monkeypatch: pytest.MonkeyPatch):
    clock = {"seconds": 0.0}

    def spend(seconds: float) -> None:
        clock["seconds"] += seconds

    monkeypatch.setitem(timing.CLOCKS, "cpu", lambda: clock["seconds"])
    readied = Case(group="g", name="a", run=lambda: spend(1e-6), reset=lambda: spend(5.0))
    own = Case(group="g", name="b", run=lambda: 0.25)
    a, b = timing.measure([readied, own], rounds=2)
    assert a.seconds == pytest.approx((1e-6,) * 2) and b.seconds == (0.25, 0.25)


def test_median_and_spread():
    m = measurement((1.0, 2.0, 3.0, 4.0, 100.0), items=2)
    assert m.median == 3.0 and m.ns == 1.5e9
    assert m.spread == pytest.approx((4 - 2) / 2 / 3)


def test_the_roof_is_that_of_a_processor():
    with one_core():
        found = timing.measure(roof.cases(Device(settings=clrt.Settings(threads=1)), threads=1), rounds=3)
    best = roof.roof_of(found)
    assert 5e8 < best.memory < 1e12 and best.memory < best.cache < 1e13 and 1e9 < best.arithmetic < 1e12
    m = measurement((1.0,))
    assert best.least_seconds(m) == max(200 / best.memory, 3000 / best.arithmetic)


# --- reports
# ----------------------------------------------------------------------------------------------------


def test_scaling_measures_each_point_in_a_process_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    points = [(n, scaling.Point(primitives=n, width=32, lights=1, depth=1, tile=256)) for n in (200, 20_000)]
    monkeypatch.setattr(scaling, "series", lambda quick: {"primitives": points})
    assert scaling.main([str(tmp_path / "a.json"), str(tmp_path / "a.svg"), "--quick"]) == 0
    assert "<svg" in (tmp_path / "a.svg").read_text()
    few, many = json.loads((tmp_path / "a.json").read_text())["series"]["primitives"]
    assert (few["x"], many["x"]) == (200, 20_000) and len(few["seconds"]) == 5 and few["rays"] > 32 * 32
    assert few["device_bytes"] < many["device_bytes"] < many["peak_bytes"]


@pytest.mark.embree
def test_embree_sees_what_we_see(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    out = tmp_path / "a.json"
    command = ["bench", "--quick", "--only", "kernels,builder", "--against", "embree", "--rounds", "1"]
    assert main([*command, "--json", str(out)]) == 0
    assert "our speed over Embree's" in capsys.readouterr().out
    rows = report.ratios(report.load(out))
    rays = [row for row in rows if row["queue"] != "tree"]
    assert len(rays) == 5 * len(scenes.SCENES) == 25 and len(rows) > len(rays)
    # edges and silhouettes are a matter of rounding
    assert all(row["disagree"] < 1e-3 for row in rays)
    made = report.load(out)
    for version in made.machine["embree"]:  # each of those that are here was timed, by a name of its own
        tag = "" if version.startswith("3.") else f", {version}"
        assert {m.name for m in made.of("embree")} >= {f"default 1{tag}", f"robust tree{tag}"}


def test_the_newer_embree_is_the_one_of_the_wheel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "embreex.libs" / "libembree4-1.so.4"
    file.parent.mkdir()
    file.write_bytes(b"")
    entry = SimpleNamespace(name=file.name, locate=lambda: file)
    monkeypatch.setattr(embree.importlib.metadata, "files", lambda name: [entry])
    made: list[tuple[str, ...]] = []

    def compiled(name: str, flags: tuple[str, ...]) -> SimpleNamespace:
        made.append((name, *flags))
        return SimpleNamespace(yardstick_version=lambda: 40400 if "4" in name else 31305)

    monkeypatch.setattr(embree, "_compiled", compiled)
    monkeypatch.setattr(embree, "_HEADERS", tmp_path)
    found = embree.builds("avx2")
    assert [(build.version, build.tag, build.isa) for build in found] == [
        ("3.13", "", "avx2"), ("4.4", ", 4.4", "avx2"),
    ]  # fmt: skip
    assert made[1][:3] == ("yardstick4.so", "-DEMBREE4", str(file))
    monkeypatch.setattr(embree, "_HEADERS", tmp_path / "none")  # without Debian's the wheel's does
    assert [build.version for build in embree.builds()] == ["4.4"]
    monkeypatch.setattr(embree.importlib.metadata, "files", lambda name: None)
    assert embree._wheel() is None
