"""A job is what defines a picture and nothing else; the loop that it runs stands once and can be observed."""

from __future__ import annotations

import ast
import inspect
import multiprocessing
import pickle
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.bench.recorder import Recorder
from clrt.device.device import Device
from clrt.engine.job import TILE_BYTES, GivenRays, Job, Tile, halves
from clrt.engine.rayinput import ray_chunks
from clrt.engine.schedule import TooLarge, complete
from clrt.engine.stage import Stage
from clrt.engine.tripwire import Tripwire
from clrt.engine.watcher import Watcher
from clrt.engine.world import World
from clrt.flatten.flatten import flatten_camera
from clrt.formats.shipped import load_scene
from validation.ours import Shares
from validation.twin.compare import Lockstep

ROOT = Path(__file__).parents[2]
# Who may launch a pass of the loop. `film.py` makes layers of single terms of generation 0, `apart.py` takes
# a pixel's light apart; the others ask about rays that nothing follows. What is not named here has one
# caller: the loop or the job around it.
CALLERS = {
    "generate": {"clrt/engine/job.py": 1, "clrt/engine/tracer.py": 1},
    "adopt": {
        "clrt/engine/job.py": 1, "validation/proofs.py": 1,
    },
    "shade": {"clrt/engine/wavefront.py": 1, "clrt/engine/film.py": 1, "clrt/engine/apart.py": 2},
    "feelers": {"clrt/engine/wavefront.py": 1, "clrt/engine/film.py": 1, "clrt/engine/apart.py": 1},
    "illuminate": {"clrt/engine/wavefront.py": 1, "clrt/engine/film.py": 1, "clrt/engine/apart.py": 1},
    "gather": {"clrt/engine/film.py": 2},
    "spawn": {"clrt/engine/wavefront.py": 1},
    "closest": {
        "clrt/engine/job.py": 1, "clrt/engine/wavefront.py": 1,
        "clrt/engine/apart.py": 1,
        "clrt/bench/kernels.py": 2, "validation/proofs.py": 3,
    },
    "geometry": {"clrt/engine/job.py": 1},
    "immerse": {"clrt/engine/job.py": 2},
    "trace": {"clrt/engine/job.py": 1},
}  # fmt: skip

MODULES = ("clrt.engine.passes", "clrt.engine.immersion", "clrt.engine.wavefront")


def calls(file: Path) -> list[str]:
    """The names of the passes, of `immerse` and of the loop that a file calls, one for each place."""
    found, nodes = [], list(ast.walk(ast.parse(file.read_text())))
    imported = {
        alias.asname or alias.name: alias.name
        for node in nodes
        if isinstance(node, ast.ImportFrom) and node.module in MODULES
        for alias in node.names
    }
    for node in nodes:
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "passes":
            found.append(node.attr)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node.id in imported:
            found.append(imported[node.id])
    return found


def test_the_loop_stands_once() -> None:
    found: dict[str, dict[str, int]] = {name: {} for name in CALLERS}
    for folder in ("clrt", "validation"):
        for file in sorted((ROOT / folder).rglob("*.py")):
            for name in calls(file):
                if name in found:
                    callers = found[name]
                    place = file.relative_to(ROOT).as_posix()
                    callers[place] = callers.get(place, 0) + 1
    assert found == CALLERS


@pytest.mark.parametrize("observer", [Tripwire, Lockstep, Recorder, Shares, Watcher])
def test_observers_are_short(observer: type) -> None:
    assert len(inspect.getsourcelines(observer)[0]) < 100


def picture_job(name: str, layers: tuple[str, ...] = (), **settings: Any) -> tuple[Job, np.ndarray]:
    """A small picture of a scene that ships, and its pixels."""
    scene = load_scene(name)
    assert scene.camera is not None
    camera = flatten_camera(scene.camera, 48, 27)
    job = Job(clrt.Tracer(scene).flat, scene.max_depth, camera, layers, clrt.Settings(**settings))
    return job, np.arange(48 * 27, dtype=np.uint32)


def done(job: Job, piece: np.ndarray | GivenRays) -> Tile:
    """What a job gives for a piece, with all that it needs made anew."""
    device = Device(None, job.settings, job.flat.ray_format)
    return complete(job.trace(device, World(device, job.flat), piece))


def done_elsewhere(work: bytes) -> Tile:
    """The same in another process."""
    job, piece = pickle.loads(work)
    return done(job, piece)


def test_a_job_can_be_done_by_another_process() -> None:
    """Rays that disperse within nested media, layers of all kinds, settings that are not the usual ones."""
    layers = ("transmission", "diffuse", "depth", "bands")
    job, pixels = picture_job("rainbow", layers, lanes=8, local_size=16)
    glass, _ = picture_job("bubble")
    origins = np.random.default_rng(4).normal(size=(200, 3)) * 3
    (rays,) = ray_chunks(origins, -origins, np.inf, 200, clrt.Limits(), 0)
    pieces = [(job, pixels[100:900]), (Job(glass.flat, 3), rays)]
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        tiles = list(pool.map(done_elsewhere, map(pickle.dumps, pieces)))
    for (task, piece), tile in zip(pieces, tiles, strict=True):
        here = done(task, piece)
        assert tile.layers.keys() == here.layers.keys() >= {"image", *task.layers}
        for name, values in here.layers.items():
            assert tile.layers[name].tobytes() == values.tobytes(), name
        assert tile.rays == here.rays and here.rays.traced > 300
        assert len(np.unique(here.layers["image"])) > 20


def test_a_job_gives_each_pixel_alone_what_it_gives_all() -> None:
    scene = load_scene("bubble")
    image = clrt.render(scene, 48, 27).pixels.reshape(-1, 3)
    job, pixels = picture_job("bubble")
    order = np.random.default_rng(1).permutation(pixels)
    for piece in np.array_split(order, 3):
        assert np.array_equal(done(job, piece).layers["image"], image[piece])


def test_an_observer_sees_every_pass_in_order_and_changes_nothing() -> None:
    tracer = clrt.Tracer(load_scene("bubble"))
    job, pixels = picture_job("bubble", ("depth",))
    seen: list[Stage] = []
    device, world = tracer.device, tracer.world
    tile = complete(job.trace(device, world, pixels, (seen.append, lambda stage: stage.values() and None)))
    assert np.array_equal(tile.layers["image"], done(job, pixels).layers["image"])
    assert [stage.name for stage in seen[:6]] == [
        "generate", "closest", "shade", "feelers", "illuminate", "gather"
    ]  # fmt: skip
    assert [stage.name for stage in seen[-3:]] == ["geometry", "resolve", "develop"]
    for row, kinds in enumerate(tile.rays.generations):
        for kind in ("camera", "reflection", "transmission"):
            queues = [s.queue.n for s in seen if s.name == "shade" and (s.generation, s.kind) == (row, kind)]
            assert sum(queues) == kinds[kind]


def test_a_piece_that_is_too_large_is_done_in_halves() -> None:
    job, pixels = picture_job("bubble")
    tracer = clrt.Tracer(load_scene("bubble"))
    with pytest.raises(TooLarge):
        complete(job.trace(tracer.device, tracer.world, pixels, budget=1000))
    assert [len(half) for half in halves(pixels)] == [648, 648] and TILE_BYTES > 1000
    (rays,) = ray_chunks(np.zeros((5, 3)), np.ones((5, 3)), np.inf, 5, clrt.Limits(), 0)
    second, first = halves(rays)
    assert [len(part) for part in first] == [2] * 4 and second[3].tolist() == [2, 3, 4]
    with pytest.raises(clrt.LimitError, match="single pixel"):
        halves(pixels[:1])


def test_a_tracer_can_share_a_device() -> None:
    """Kernels for one number of bands do not get in the way of those for another."""
    device = Device(settings=clrt.Settings(tile=500))
    for name in ("bubble", "rainbow", "bubble"):
        scene = load_scene(name)
        tracer = clrt.Tracer(scene, device)
        assert tracer.settings is device.settings
        assert tracer.render(48, 27).hash == clrt.render(scene, 48, 27).hash
