"""`--check`: a number that is not finite is named by its first pass, its ray and its shape."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt import layout, passes
from clrt.cli import main
from clrt.resources import scene_file
from clrt.tiles import tiles

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


@pytest.mark.parametrize("name", ["ambient", "tinted_shadows"])
def test_a_sound_scene_gives_the_same_picture(name: str) -> None:
    scene = clrt.load(scene_file(name))
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


def spoiling(
    tracer: clrt.Tracer, monkeypatch: pytest.MonkeyPatch, name: str, what: Callable[..., None], call: int = 0
) -> None:
    """Let `what` change the result of the pass `name`, the `call`-th time that it runs."""
    plain, calls = getattr(passes, name), []

    def spoiled(*arguments: Any, **named: Any) -> Any:
        result = plain(*arguments, **named)
        calls.append(result)
        if len(calls) == call + 1:
            what(tracer.device, result)
        return result

    monkeypatch.setattr(passes, name, spoiled)


def first_row(tracer: clrt.Tracer, shape: int) -> tuple[int, tuple[int, int]]:
    """A ray of generation 0 that meets a shape: its place in the only tile, and its pixel (x, y)."""
    (pixels,) = tiles(40, 30, (0, 0, 40, 30), 1 << 16)
    shapes = tracer.render(layers=["shape"]).layers["shape"].reshape(-1)[pixels]
    row = int(np.flatnonzero(shapes == shape)[7])
    return row, (int(pixels[row]) % 40, int(pixels[row]) // 40)


RAY, SURFACE = len(layout.RAY_FIELDS), len(layout.SURFACE_FIELDS)


@pytest.mark.parametrize(
    ("name", "buffer", "fields", "says"),
    [
        ("closest", "surfaces", SURFACE, "hit is nan after the pass surface"),
        ("light", "local", 3, "local light is nan after the pass light"),
    ],
)
def test_the_first_pass_the_ray_and_the_shape_are_named(
    tracer: clrt.Tracer, monkeypatch: pytest.MonkeyPatch, name: str, buffer: str, fields: int, says: str
) -> None:
    row, (x, y) = first_row(tracer, shape=1)
    spoiling(
        tracer, monkeypatch, name,
        lambda device, result: spoil(device, getattr(result, buffer), row, 2, fields, np.nan),
    )  # fmt: skip
    where = rf"{says}, at pixel \({x}, {y}\), generation 0, camera ray, which meets shapes\[1\] \(prim"
    with pytest.raises(clrt.ClrtError, match=where) as caught:
        tracer.render()
    assert "\n" not in str(caught.value)


def test_a_camera_ray(tracer: clrt.Tracer, monkeypatch: pytest.MonkeyPatch) -> None:
    row, (x, y) = first_row(tracer, shape=0)
    spoiling(
        tracer, monkeypatch, "generate",
        lambda device, made: spoil(device, made[0].rays, row, 1, RAY, np.inf),
    )  # fmt: skip
    where = rf"at pixel \({x}, {y}\), generation 0, camera ray, which left the camera"
    says = f"ray is inf after the pass generate, {where}"
    with pytest.raises(clrt.ClrtError, match=says):
        tracer.render()


def test_a_spawned_ray_and_its_weight(tracer: clrt.Tracer, monkeypatch: pytest.MonkeyPatch) -> None:
    for field, fields, buffer, what in ((3, RAY, "rays", "ray"), (0, 3, "weight", "weight")):
        with monkeypatch.context() as patch:
            spoiling(
                tracer, patch, "spawn",
                lambda dev, made, b=buffer, f=field, n=fields: spoil(dev, getattr(made, b), 5, f, n, -np.inf),
                call=1,
            )  # fmt: skip
            where = r"at pixel .*, generation 1, transmission ray, which left shapes\[1\]"
            says = f"{what} is -inf after the pass spawn transmission, {where}"
            with pytest.raises(clrt.ClrtError, match=says):
                tracer.render()


def test_feelers_are_traced_to_their_ray(tracer: clrt.Tracer, monkeypatch: pytest.MonkeyPatch) -> None:
    row, (x, y) = first_row(tracer, shape=0)

    def first_of_row(device: Any, found: Any) -> None:
        owner = device.read(found.owner, np.empty(found.n, np.uint32))
        spoil(device, found.rays, int(np.argmax(owner == row)), 0, RAY, np.nan)

    spoiling(tracer, monkeypatch, "feelers", first_of_row)
    where = rf"at pixel \({x}, {y}\), .*, which meets shapes\[0\]"
    with pytest.raises(clrt.ClrtError, match=f"check: feeler is nan after the pass feelers, {where}"):
        tracer.render()


def test_what_lights_bring(tracer: clrt.Tracer, monkeypatch: pytest.MonkeyPatch) -> None:
    row, (x, y) = first_row(tracer, shape=0)
    plain = passes.illuminate

    def spoiled(device: Any, world: Any, queue: Any, hits: Any, lit: Any, *others: Any) -> None:
        plain(device, world, queue, hits, lit, *others)
        spoil(device, lit.local, row, 1, 3, np.nan)

    monkeypatch.setattr(passes, "illuminate", spoiled)
    where = rf"at pixel \({x}, {y}\), .*, which meets shapes\[0\]"
    says = "check: direct light is nan after the pass illuminate"
    with pytest.raises(clrt.ClrtError, match=f"{says}, {where}"):
        tracer.render()


def test_the_film_and_callers_rays(tracer: clrt.Tracer, monkeypatch: pytest.MonkeyPatch) -> None:
    plain = passes.gather

    def spoiled(device: Any, queue: Any, lit: Any, film: Any, *others: Any) -> None:
        plain(device, queue, lit, film, *others)
        sums = device.read(film, np.empty(6, np.float32))
        sums[4] = np.inf
        device.write(film, sums)

    rays = [[0, 1, 4], [0, 1, 4]], [[0, -0.25, -1], [0, 1, 0]]
    assert np.isfinite(tracer.radiance([*rays[0], [np.nan, 0, 0]], [*rays[1], [1, np.inf, 0]])[0]).all()
    monkeypatch.setattr(passes, "gather", spoiled)
    where = "at ray 1, generation 0, camera ray, which meets nothing"
    with pytest.raises(clrt.ClrtError, match=f"sum of the film is inf after the pass gather, {where}"):
        tracer.radiance(*rays)


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
