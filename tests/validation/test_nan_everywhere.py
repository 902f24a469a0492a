"""A NaN in a kernel fails each proof, though the film shows it as a bright pixel."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.resources import kernel_folder, validation_module
from clrt.device import driver, kernelcache, source
from clrt.device.device import Device
from clrt.device.settings import Settings
from clrt.engine.tripwire import NotFinite
from tests.engine.test_hard_rays import SHAPES, hard_rays, tracer

worker = validation_module("suite.worker")
hostile = validation_module("hostile.worker")
files = validation_module("suite.files")
SCENE: dict[str, Any] = {
    "camera": {"origin": [0, 0, 5], "target": [0, 0, 0], "width": 16, "height": 12}, "ambient": 0.3,
    "lights": [{"type": "point", "position": [3, 4, 5]}],
    "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}],
}  # fmt: skip
# file, what stands there once, a NaN in its place, the pass that is blamed
PLANTED = {
    "own light": ("light.cl", "weight[b] * (emission + ambient), mine",
                  "weight[b] * (emission + ambient) + (0.0f / 0.0f), mine", "shade"),
    "a light's": ("light.clh", "radiance[b] = in_band(light->intensity, s, b) * to.factor",
                  "radiance[b] = sqrt(-1.0f - to.factor) * in_band(light->intensity, s, b) * to.factor",
                  "illuminate"),
}  # fmt: skip


@pytest.fixture(params=PLANTED)
def planted(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, hasty: None
) -> tuple[Path, str]:
    """The folder of kernels with the fault, which is now everybody's; and the pass."""
    folder = tmp_path / "kernels"
    shutil.copytree(kernel_folder(), folder)
    name, old, new, blamed = PLANTED[request.param]
    text = (folder / name).read_text("utf-8")
    assert text.count(old) == 1
    (folder / name).write_text(text.replace(old, new), "utf-8")
    for module in (driver, kernelcache, source):
        monkeypatch.setattr(module, "kernel_folder", lambda: folder)
    return folder, blamed


def test_the_film_alone_hides_it(planted: tuple[Path, str]) -> None:
    assert np.isfinite(clrt.render(clrt.load_dict(SCENE)).pixels).all()


def test_validation_fails(planted: tuple[Path, str], monkeypatch: pytest.MonkeyPatch) -> None:
    folder, blamed = planted

    def opened(wanted: Any, check: bool = True) -> Device:
        return Device(wanted, Settings(check=check), kernels=folder)

    monkeypatch.setattr(worker, "device_of", opened)
    result = worker.run_case(worker.Task("diffuse", ("oracle64",)))
    ((_, comparison),) = result.results.values()
    (gate,) = [gate for gate in comparison.gates if gate.name == "tripwire"]
    assert not result.passed and not gate.passed and f"nan after the pass {blamed}" in gate.detail
    assert gate.detail in files._said(gate)


def test_hostile_inputs_fail(planted: tuple[Path, str], tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(json.dumps(SCENE))
    found = hostile.attempt(tmp_path / "a.json", None)
    assert found["status"] == "not finite" and f"after the pass {planted[1]}" in found["text"]


def test_hard_rays_fail(planted: tuple[Path, str]) -> None:
    with pytest.raises(NotFinite, match=f"after the pass {planted[1]}"):
        tracer(SHAPES["sphere"]).radiance(*hard_rays(1.0))


def test_sound_kernels_pass_all_three(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(json.dumps(SCENE))
    assert hostile.attempt(tmp_path / "a.json", None)["status"] == "rendered"
    assert np.isfinite(tracer(SHAPES["sphere"]).radiance(*hard_rays(1.0))[0]).all()
    result = worker.run_case(worker.Task("diffuse", ("oracle64",)))
    assert result.passed and "tripwire" not in {gate.name for gate in result.results["oracle64"][1].gates}


def test_light_that_overflows_is_not_a_nan(tmp_path: Path) -> None:
    """It counts as the brightest there is; where nothing is above 1 nothing trips."""
    bright = [3e38, [3e38, 1, 1], {"name": "D65", "scale": 3e38}, {"samples": [[400, 3e38], [700, 3e38]]}]
    for number, intensity in enumerate(bright):
        lights = [{**SCENE["lights"][0], "intensity": intensity}]
        shapes = [{**SCENE["shapes"][0], "material": {"specular": 3e38, "highlight_color": [2, 2, 2]}}]
        file = tmp_path / f"{number}.json"
        file.write_text(json.dumps({**SCENE, "lights": lights, "shapes": shapes}))
        with pytest.raises(NotFinite):
            clrt.render(clrt.load(file), settings=Settings(check=True))
        assert hostile.attempt(file, None)["status"] == "rendered"
