"""`--check`: a number that is not finite is named by its first pass, its ray and its shape."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt import layout
from clrt.cli import main
from clrt.engine.job import Job, Tile
from clrt.engine.rayinput import ray_chunks
from clrt.engine.schedule import complete
from clrt.engine.stage import Observer, Stage
from clrt.engine.tiles import tiles
from clrt.flatten.flatten import flatten_camera
from clrt.formats.shipped import load_scene

SCENE: dict[str, Any] = {
    "ambient": 0.1,
    "camera": {"origin": [0, 1, 4], "target": [0, 0, 0], "width": 40, "height": 30},
    "lights": [{"type": "point", "position": [3, 5, 4]}],
    "materials": {"glass": {"diffuse": 0.2, "reflection": 0.3, "transmission": 0.5}},
    "shapes": [
        {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]},
        {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "glass"},
    ],
}
CHECKED = clrt.Settings(check=True)


@pytest.fixture(scope="module")
def tracer() -> clrt.Tracer:
    return clrt.Tracer(clrt.load_dict(SCENE), settings=CHECKED)


@pytest.mark.parametrize("name", ["ambient", "tinted_shadows", "rainbow", "spectrum", "diamond"])
def test_a_sound_scene_gives_the_same_picture(name: str) -> None:
    """Also where dispersion makes rays that carry fewer bands than the scene has."""
    scene = load_scene(name)
    layers = ("reflection", "diffuse")
    image = clrt.render(scene, width=60, layers=layers, settings=CHECKED)
    assert image.hash == clrt.render(scene, width=60, layers=layers).hash


def spoil(device: Any, buffer: Any, row: int, field: int, fields: int, value: float) -> None:
    """Write a number into a buffer of blocks."""
    lanes = device.settings.lanes
    place = row // lanes * lanes * fields + field * lanes + row % lanes
    values = device.read(buffer, np.empty(place + 1, np.float32))
    values[place] = value
    device.write(buffer, values)


def spoiling(name: str, what: Callable[[Any, Any], None], call: int = 0) -> Observer:
    """An observer that lets `what` change what the pass `name` wrote, the `call`-th time that it runs."""
    calls = []

    def spoiled(stage: Stage) -> None:
        if stage.name == name:
            calls.append(stage)
            if len(calls) == call + 1:
                what(stage.queue.device, stage.wrote)

    return spoiled


def render(tracer: clrt.Tracer, *observers: Observer, layers: tuple[str, ...] = ()) -> Tile:
    """The picture of the scene in one tile, with observers before the tripwire."""
    assert tracer.scene.camera is not None
    camera = flatten_camera(tracer.scene.camera)
    job = Job(tracer.flat, tracer.scene.max_depth, camera, ("shape", *layers), tracer.settings)
    return complete(job.trace(tracer.device, tracer.world, one_tile(tracer), observers))


def one_tile(tracer: clrt.Tracer) -> np.ndarray:
    assert tracer.scene.camera is not None
    size = tracer.scene.camera.width, tracer.scene.camera.height
    (pixels,) = tiles(*size, (0, 0, *size), 1 << 16)
    return pixels


def first_row(tracer: clrt.Tracer, shape: int) -> tuple[int, tuple[int, int]]:
    """A ray of generation 0 that meets a shape: its place in the only tile, and its pixel (x, y)."""
    pixels = one_tile(tracer)
    row = int(np.flatnonzero(render(tracer).layers["shape"] == shape)[7])
    return row, (int(pixels[row]) % 40, int(pixels[row]) // 40)


RAY, SURFACE = len(layout.RAY_FIELDS), len(layout.SURFACE_FIELDS)


@pytest.mark.parametrize(
    ("name", "buffer", "fields", "says"),
    [
        ("closest", "surfaces", SURFACE, "hit is nan after the pass surface"),
        ("shade", "local", 3, "local light is nan after the pass shade"),
        ("illuminate", "local", 3, "direct light is nan after the pass illuminate"),
    ],
)
def test_the_first_pass_the_ray_and_the_shape_are_named(
    tracer: clrt.Tracer, name: str, buffer: str, fields: int, says: str
) -> None:
    row, (x, y) = first_row(tracer, shape=1)
    wrong = spoiling(name, lambda device, made: spoil(device, getattr(made, buffer), row, 2, fields, np.nan))
    where = rf"{says}, at pixel \({x}, {y}\), generation 0, camera ray, which meets shapes\[1\] \(prim"
    with pytest.raises(clrt.ClrtError, match=where) as caught:
        render(tracer, wrong)
    assert "\n" not in str(caught.value)


def test_a_camera_ray(tracer: clrt.Tracer) -> None:
    row, (x, y) = first_row(tracer, shape=0)
    wrong = spoiling("generate", lambda device, made: spoil(device, made.rays, row, 1, RAY, np.inf))
    where = rf"at pixel \({x}, {y}\), generation 0, camera ray, which left the camera"
    says = f"ray is inf after the pass generate, {where}"
    with pytest.raises(clrt.ClrtError, match=says):
        render(tracer, wrong)


@pytest.mark.parametrize(
    ("field", "fields", "buffer", "what"), [(3, RAY, "rays", "ray"), (0, 3, "weight", "weight")]
)
def test_a_spawned_ray_and_its_weight(
    tracer: clrt.Tracer, field: int, fields: int, buffer: str, what: str
) -> None:
    wrong = spoiling(
        "spawn", lambda device, made: spoil(device, getattr(made, buffer), 5, field, fields, -np.inf), call=1
    )
    where = r"at pixel .*, generation 1, transmission ray, which left shapes\[1\]"
    with pytest.raises(clrt.ClrtError, match=f"{what} is -inf after the pass spawn transmission, {where}"):
        render(tracer, wrong)


def test_a_ray_of_a_few_bands() -> None:
    """The last of its words is the number of its first band, which is no value."""
    scene = load_scene("rainbow").override(width=40, height=30)
    tracer = clrt.Tracer(scene, settings=CHECKED)
    spoiled: list[tuple[int, int]] = []

    def wrong(stage: Stage) -> None:
        if stage.name == "spawn" and stage.queue.narrow and not spoiled:
            group = tracer.flat.group
            assert tracer.flat.bands > stage.queue.device.ray_format.values == group + 1
            row = stage.queue.n - 1
            pixel = int(one_tile(tracer)[stage.values()["pixel_of"][row]])
            spoiled.append((pixel % 40, pixel // 40))
            spoil(stage.queue.device, stage.queue.weight, row, group - 1, group + 1, np.nan)

    with pytest.raises(clrt.ClrtError, match="weight is nan after the pass spawn transmission") as caught:
        render(tracer, wrong)
    assert f"at pixel {spoiled[0]}, generation" in str(caught.value)


def test_feelers_are_traced_to_their_ray(tracer: clrt.Tracer) -> None:
    row, (x, y) = first_row(tracer, shape=0)

    def first_of_row(device: Any, found: Any) -> None:
        owner = device.read(found.owner, np.empty(found.n, np.uint32))
        spoil(device, found.rays, int(np.argmax(owner == row)), 0, RAY, np.nan)

    where = rf"at pixel \({x}, {y}\), .*, which meets shapes\[0\]"
    with pytest.raises(clrt.ClrtError, match=f"check: feeler is nan after the pass feelers, {where}"):
        render(tracer, spoiling("feelers", first_of_row))


@pytest.mark.parametrize(
    ("name", "call", "says"),
    [
        ("shade", 0, "local light of the layer ambient is nan after the pass shade"),
        ("illuminate", 1, "direct light of the layer diffuse is nan after the pass illuminate"),
        ("illuminate", 2, "direct light is nan after the pass illuminate"),
    ],
)
def test_a_term_of_which_there_is_a_layer(tracer: clrt.Tracer, name: str, call: int, says: str) -> None:
    """Nothing of it is in the picture."""
    row, (x, y) = first_row(tracer, shape=1)
    wrong = spoiling(name, lambda device, made: spoil(device, made.local, row, 2, 3, np.nan), call)
    where = rf"{says}, at pixel \({x}, {y}\), generation 0, camera ray, which meets shapes\[1\] \(prim"
    with pytest.raises(clrt.ClrtError, match=where):
        render(tracer, wrong, layers=("ambient", "diffuse"))


def test_the_film_and_callers_rays(tracer: clrt.Tracer) -> None:
    def too_bright(device: Any, film: Any) -> None:
        sums = device.read(film.sums, np.empty(6, np.float32))
        sums[4] = np.inf
        device.write(film.sums, sums)

    rays = [[0, 1, 4], [0, 1, 4]], [[0, -0.25, -1], [0, 1, 0]]
    assert np.isfinite(tracer.radiance([*rays[0], [np.nan, 0, 0]], [*rays[1], [1, np.inf, 0]])[0]).all()
    job, (chunk,) = Job(tracer.flat, 5, settings=CHECKED), ray_chunks(*rays, np.inf, 2, clrt.Limits(), 0)
    where = "at ray 1, generation 0, camera ray, which meets nothing"
    with pytest.raises(clrt.ClrtError, match=f"sum of the film is inf after the pass gather, {where}"):
        complete(job.trace(tracer.device, tracer.world, chunk, (spoiling("gather", too_bright),)))


def test_the_command_line_asks_for_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, out = tmp_path / "a.json", tmp_path / "a.png"
    scene.write_text(json.dumps(SCENE))
    assert main(["render", str(scene), "-o", str(out), "--check", "--quiet"]) == 0
    seen: list[clrt.Settings] = []

    class Enough(Exception):
        pass

    def render(scene: clrt.Scene, settings: clrt.Settings, **_: Any) -> None:
        seen.append(settings)
        raise Enough

    monkeypatch.setattr(clrt, "render", render)
    with pytest.raises(Enough):
        main(["render", str(scene), "-o", str(out), "--check"])
    assert seen[0].check
    with pytest.raises(clrt.ClrtError, match="check"):
        clrt.Settings(check=1)  # type: ignore[arg-type]
