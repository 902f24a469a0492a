"""A third driver: Oclgrind, an interpreter, gives the bits of the float32 twin and finds nothing amiss."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import clrt
import watched
from clrt.device.device import Device
from validation.twin.compare import compare_picture, compare_rays
from validation.twin.rays import difficult_rays
from validation.twin.scenes import scenes

pytestmark = pytest.mark.oclgrind
SCENES = scenes()


@pytest.fixture
def device(monkeypatch: pytest.MonkeyPatch) -> Iterator[Device]:
    for name, replacement in watched.PATCHES:
        monkeypatch.setattr(name, replacement)
    yield Device(settings=clrt.Settings(lanes=8, local_size=8))
    assert watched.findings()[:2000] == ""


@pytest.mark.parametrize("name", SCENES)
def test_tiny_frames_have_the_bits_of_the_twin(name: str, device: Device) -> None:
    scene, flat = SCENES[name]
    picture = compare_picture(device, scene, flat, width=9, height=7, spp=1, max_depth=2)
    assert picture.difference is None, str(picture.difference)
    rays = compare_rays(device, flat, *difficult_rays(60, seed=3), max_depth=1)
    assert rays.difference is None, str(rays.difference)
