"""Pictures by an executor's workers are those of one process, and what goes wrong there is one ClrtError."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.places import At, PlacedError
from clrt.cluster import pictures, worker
from clrt.cluster.orders import Answer, Lacking, Order
from clrt.device import foreign
from clrt.scene.scene import edited
from tests.farm_samples import SIZE, Here, done, same

SCENES = Path(__file__).parents[2] / "scenes"
pytestmark = pytest.mark.usefixtures("fresh")


@pytest.mark.parametrize("name", ["bubble", "rainbow"])
def test_the_picture_is_that_of_one_process(name: str) -> None:
    """Media, bands that disperse, layers of all kinds, samples, a part of the picture, settings, a camera."""
    scene = clrt.load(name)
    layers = ["diffuse", "depth", "shape", "albedo", "alpha", "crypto_shape", "crypto_material"]
    more: dict[str, Any] = {"layers": layers, "spp": 4, "crop": (3, 2, 30, 20)}
    assert scene.camera is not None
    more |= {"settings": clrt.Settings(lanes=8, tile=1000), "camera": replace_origin(scene), **SIZE}
    executor = Here()
    same(clrt.render(scene, executor=executor, **more), clrt.render(scene, **more))
    assert len(executor.answers) > 2


def replace_origin(scene: clrt.Scene) -> clrt.Camera:
    assert scene.camera is not None
    moved = scene.replace({"camera.fov": 25}).camera
    assert moved is not None
    return moved


def test_threads_do(mesh: clrt.Scene) -> None:
    with ThreadPoolExecutor(2) as executor:
        same(clrt.render(mesh, executor=executor, **SIZE), clrt.render(mesh, **SIZE))


def test_many_tiles_go_in_few_orders_the_last_ones_small(
    mesh: clrt.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As long as a worker's share of what is left has several, and none takes long."""
    more: dict[str, Any] = {"settings": clrt.Settings(tile=10, threads=1), **SIZE}
    right, tiles = clrt.render(mesh, **more), SIZE["width"] * SIZE["height"] // 10

    def sizes(seconds: float) -> list[int]:
        monkeypatch.setattr(pictures, "_SECONDS", seconds)
        executor = Here()
        same(clrt.render(mesh, executor=executor, **more), right)
        answers = [one for one in executor.answers if isinstance(one, Answer)]
        return [len(next(iter(answer.layers.values()))) for answer in answers]

    found = sizes(1e9)
    assert found[0] == 10, "no cost is known yet"
    assert max(found) == 8 * 10 and max(found[-3:]) == 10, "the last ones keep nobody waiting"
    assert 3 * len(found) < tiles and sum(found) == 10 * tiles
    assert sizes(1e-9) == [10] * tiles, "one that takes long is not made longer"


def test_a_series_is_that_of_one_process_and_a_mesh_travels_once(mesh: clrt.Scene) -> None:
    changes = {"materials.m.reflection": [0.1, 0.6], "camera.fov": [30, 50]}
    parcels_sent: list[int] = []

    def weigh(order: Order) -> Order:
        if order.arrays:
            parcels_sent.append(len(order.arrays))
        return order

    executor = Here(weigh)
    there = [*clrt.sweep(mesh, changes, executor=executor, width=24)]
    for (values, image), (other, right) in zip(there, clrt.sweep(mesh, changes, width=24), strict=True):
        assert values == other
        same(image, right)
    assert len(parcels_sent) == 1, "the mesh was sent again"
    assert all(isinstance(answer, (Answer, Lacking)) for answer in executor.answers)
    scenes = worker._bench().scenes.values()
    assert len({id(scene.flat.triangles) for scene in scenes}) == 1 < len(scenes), "it is kept twice"
    assert len({id(scene.world._buffers["nodes"]) for scene in scenes}) == 1, "the tree was built again"


def test_an_abandoned_series_hands_in_no_more(mesh: clrt.Scene) -> None:
    executor = Here()
    pictures_of = clrt.sweep(mesh, {"camera.fov": range(20, 60)}, executor=executor, width=24)
    next(pictures_of)
    pictures_of.close()  # type: ignore[attr-defined]
    assert len(executor.answers) < 20


def test_what_a_worker_has_not_is_sent_again(mesh: clrt.Scene) -> None:
    """Each order goes to a worker that has just been started."""

    def forget(order: Order) -> Order:
        worker._bench.cache_clear()
        return order

    image, report = done(Here(forget), mesh, **SIZE)
    same(image, clrt.render(mesh, **SIZE))
    assert report.asked >= report.answers > 2 and report.lost == 0


def test_a_worker_forgets_what_was_unused_for_longest() -> None:
    scene, executor = clrt.load("bubble"), Here()
    for fov in range(20, 20 + worker._SCENES + 2):
        clrt.render(scene.replace({"ambient": fov / 100}), 8, 6, executor=executor)
    assert len(worker._bench().scenes) == worker._SCENES


def test_no_memory_for_two_scenes_is_no_fault(mesh: clrt.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    executor, kept = Here(), []
    settings = clrt.Settings(limits=clrt.Limits(device_bytes=16 << 20))
    trace = worker._traced

    def traced(*arguments: Any) -> Any:
        kept.append(len(worker._bench().scenes))
        if kept[-1] > 1:
            raise worker.MemoryLimitError("full")
        return trace(*arguments)

    monkeypatch.setattr(worker, "_traced", traced)
    for ambient in (0.1, 0.2):
        changed = mesh.replace({"ambient": ambient})
        same(clrt.render(changed, executor=executor, settings=settings, **SIZE),
             clrt.render(changed, settings=settings, **SIZE))  # fmt: skip
    assert 2 in kept


@pytest.mark.parametrize("times", [2, 100])
def test_answers_that_change_on_the_way(mesh: clrt.Scene, times: int) -> None:
    """They are asked for again, a few times."""
    left = [times]

    def damage(answer: Any) -> Any:
        if not isinstance(answer, Answer) or not left[0]:
            return answer
        left[0] -= 1
        image = answer.layers["image"].copy()
        image.view(np.uint32).reshape(-1)[5] ^= 1
        return replace(answer, layers={**answer.layers, "image": image})

    if times > 10:
        with pytest.raises(clrt.ClrtError, match=r"pixels from 0 on were lost 5 times, .* changed on"):
            done(Here(after=damage), mesh, **SIZE)
        return
    image, report = done(Here(after=damage), mesh, **SIZE)
    same(image, clrt.render(mesh, **SIZE))
    assert report.lost == times


class KilledWorker(Exception):
    """As dask calls it."""


def test_orders_whose_worker_ends_are_done_again(mesh: clrt.Scene) -> None:
    left = [3]

    def end(order: Order) -> Order:
        if left[0] and order.recipe:
            left[0] -= 1
            raise KilledWorker
        return order

    image, report = done(Here(end), mesh, **SIZE)
    same(image, clrt.render(mesh, **SIZE))
    assert report.lost == 3


def poisoned(order: Order) -> Order:
    if 600 in order.pixels:
        raise KilledWorker
    return order


def test_what_always_ends_its_worker_is_given_up(mesh: clrt.Scene) -> None:
    with pytest.raises(clrt.ClrtError, match=r"lost 5 times, the last time by the end of its worker"):
        done(Here(poisoned), mesh, **SIZE)


def _note(told: list[tuple[int, ...]], *row: int) -> None:
    told.append(row)


def test_a_checkpoint_goes_on_there_and_here(mesh: clrt.Scene, tmp_path: Path) -> None:
    """What one process finished is not done again by workers, nor the reverse."""
    right, file = clrt.render(mesh, **SIZE), tmp_path / "c"

    def leave(done: int, total: int, rays: int) -> None:
        if done >= 600:
            raise KeyboardInterrupt

    for first in (None, Here()):
        for second in (None, Here()):
            file.unlink(missing_ok=True)
            both: dict[str, Any] = {"settings": clrt.Settings(tile=300), "checkpoint": file, **SIZE}
            with pytest.raises(KeyboardInterrupt):
                clrt.render(mesh, executor=first, progress=leave, **both)
            told: list[tuple[int, ...]] = []
            note = partial(_note, told)
            image = clrt.render(mesh, executor=second, progress=note, **both)
            assert image.hash == right.hash and image.stats["generations"] == right.stats["generations"]
            assert 600 < told[0][0] <= 900 and told[-1][0] == 1200, "what was finished was done again"
            again = clrt.render(mesh, executor=second, **both)
            assert again.hash == right.hash and again.stats["rays"] == right.stats["rays"]


def test_a_picture_that_a_checkpoint_holds_all_of_says_what_made_it(mesh: clrt.Scene, tmp_path: Path) -> None:
    file = tmp_path / "whole"
    first = clrt.render(mesh, checkpoint=file, executor=Here(), **SIZE)
    again = clrt.render(mesh, checkpoint=file, executor=Here(), **SIZE)
    assert again.hash == first.hash and again.metadata["device"] == again.stats["device"] != ""
    for name in ("scene_hash", "settings", "version"):
        assert again.metadata[name] == first.metadata[name] != ""
    flat = clrt.Tracer(mesh).flat  # a driver may take narrower packets
    assert again.metadata["kernel_hash"] == foreign.source_hash(flat.ray_format)



def test_samples_of_the_picture_s_own_go_with_what_is_adaptive() -> None:
    """The scene alone says 9 samples, with which it would refuse 16: `--spp 4 --adaptive 16`."""
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
    glass = {"fresnel": True, "diffuse": 0.0, "absorption": 0.1}
    camera = {"origin": [0, 0, 5], "target": [0, 0, 0], "spp": 9}
    light = {"type": "point", "position": [3, 5, 4]}
    table = {"camera": camera, "lights": [light], "shapes": [{**ball, "material": glass}]}
    scene = edited(clrt.load_dict(table), {"adaptive": {"spp": 16}})
    same(clrt.render(scene, spp=4, executor=Here(), **SIZE), clrt.render(scene, spp=4, **SIZE))


def test_whatever_class_a_worker_s_error_is_of_it_names_the_worker(
    mesh: clrt.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Some classes are not made from a message alone."""

    def refuses(*_: Any) -> None:
        raise At("a.toml", "shapes[0]").error(3, "it must be 4")

    monkeypatch.setattr(worker, "unpacked", refuses)
    says = r"^worker .*: a\.toml: shapes\[0\]: 3 is not allowed; it must be 4$"
    with pytest.raises(PlacedError, match=says):
        clrt.render(mesh, executor=Here(), **SIZE)
