"""A job is what defines a picture and nothing else; the loop that it runs stands once and can be observed."""

from __future__ import annotations

import ast
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
MODULES = ("clrt.engine.passes", "clrt.engine.immersion", "clrt.engine.wavefront")
HELPERS = {"arranged", "spawned_kinds"}  # of the passes themselves and of the bench
# Who may launch a pass of the loop. `film.py` makes layers of single terms of generation 0, `apart.py` takes
# a pixel's light apart, `figures.py` shows its text; the others ask about rays that nothing follows.
CALLERS = {
    "generate": {"clrt/engine/job.py": 1, "clrt/engine/tracer.py": 1},
    "adopt": {"clrt/engine/job.py": 1, "validation/proofs.py": 1},
    "shade": {"clrt/engine/wavefront.py": 1, "clrt/engine/film.py": 1, "clrt/engine/apart.py": 2},
    "feelers": {"clrt/engine/wavefront.py": 1, "clrt/engine/film.py": 1, "clrt/engine/apart.py": 1},
    "illuminate": {"clrt/engine/wavefront.py": 1, "clrt/engine/film.py": 1, "clrt/engine/apart.py": 1},
    "gather": {"clrt/engine/film.py": 2},
    "weigh_samples": {"clrt/engine/job.py": 1},
    "develop": {"clrt/engine/film.py": 1},
    "spawn": {"clrt/engine/wavefront.py": 1},
    "closest": {
        "clrt/engine/job.py": 1, "clrt/engine/wavefront.py": 1,
        "clrt/bench/kernels.py": 2, "validation/proofs.py": 3,
    },
    "geometry": {"clrt/engine/job.py": 1},
    "immerse": {"clrt/engine/job.py": 2},
    "trace": {"clrt/engine/job.py": 1, "docs/site/figures.py": 1},
}  # fmt: skip


def public(module: str) -> set[str]:
    """Functions that a module offers."""
    tree = ast.parse((ROOT / f"{module.replace('.', '/')}.py").read_text())
    named = (node.name for node in tree.body if isinstance(node, ast.FunctionDef))
    return {name for name in named if not name.startswith("_")}


def calls(source: str) -> list[str]:
    """The names of the passes, of `immerse` and of the loop that a program names, one for each place, by
    whatever name and way they were imported."""
    nodes, meant = list(ast.walk(ast.parse(source))), {}  # what a name of the program stands for
    for node in nodes:
        if isinstance(node, ast.ImportFrom):
            meant |= {alias.asname or alias.name: f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Import):
            meant |= {alias.asname: alias.name for alias in node.names if alias.asname}

    def full(node: ast.AST) -> str:
        if isinstance(node, ast.Attribute):
            return f"{full(node.value)}.{node.attr}"
        return meant.get(node.id, node.id) if isinstance(node, ast.Name) else ""

    found = (full(node).rpartition(".") for node in nodes if isinstance(node, ast.Attribute | ast.Name))
    return [name for module, _, name in found if module in MODULES]


def test_the_loop_stands_once() -> None:
    """Each pass is named in these places and in no others; a pass that is not among them would be found."""
    offered = set().union(*map(public, MODULES))
    assert offered - HELPERS == CALLERS.keys()
    found: dict[str, dict[str, int]] = {}
    for folder in ("clrt", "validation", "docs"):
        for file in sorted((ROOT / folder).rglob("*.py")):
            place = file.relative_to(ROOT).as_posix()
            for name in offered.intersection(named := calls(file.read_text())) - HELPERS:
                found.setdefault(name, {})[place] = named.count(name)
    assert found == CALLERS


@pytest.mark.parametrize(
    "source",
    [
        "from clrt.engine import passes\npasses.shade(1)",
        "from clrt.engine import passes as p\np.shade(1)",
        "import clrt.engine.passes\nclrt.engine.passes.shade(1)",
        "import clrt.engine.passes as p\ndo = p.shade",
        "from clrt.engine.passes import shade\nshade(1)",
        "from clrt.engine.passes import shade as s\nwith s(1): pass",
        "import clrt.engine\nclrt.engine.passes.shade(1)",
    ],
)
def test_no_way_of_import_hides_a_second_loop(source: str) -> None:
    assert calls(source) == ["shade"]
    assert calls(source.replace("passes", "others")) == []


def observers(source: str) -> dict[str, int]:
    """What takes a stage record and returns nothing: lines of the class that is called with it, or of the
    function, by name."""
    found = {}
    for node in ast.walk(ast.parse(source)):
        for inner in getattr(node, "body", []) if isinstance(node, ast.Module | ast.ClassDef) else ():
            if isinstance(inner, ast.FunctionDef) and ast.unparse(inner.returns or ast.Pass()) == "None":
                stated = [argument.annotation for argument in inner.args.args if argument.arg != "self"]
                of_class = isinstance(node, ast.ClassDef) and inner.name == "__call__"
                whole = node if of_class else inner
                if [ast.unparse(one).rpartition(".")[2] for one in stated if one] == ["Stage"]:
                    found[whole.name] = whole.end_lineno - whole.lineno + 1  # type: ignore[operator, union-attr]
    return found


def test_observers_are_short() -> None:
    found: dict[str, int] = {}
    for folder in ("clrt", "validation"):
        for file in (ROOT / folder).rglob("*.py"):
            found |= observers(file.read_text())
    assert {one.__name__ for one in (Tripwire, Lockstep, Recorder, Shares, Watcher)} < found.keys()
    assert {"unshadowed", "forget"} < found.keys()
    assert {name: lines for name, lines in found.items() if lines >= 100} == {}


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
