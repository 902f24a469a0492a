"""The thesis program's pictures: its own, with its faults, and clrt's, which has none of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import clrt
from clrt.base.resources import validation_module
from clrt.images.file import encode

oracle = validation_module("thesis2011.pictures")
check = validation_module("thesis2011.check")

pytestmark = pytest.mark.filterwarnings("ignore::clrt.base.errors.ClrtWarning")

VIEW = "Width 64 Height 48 Ambient .3 Focal 0 0 -6\n"
LAMP = "Light Point -4 6 -9 Spectrum 380 750 Intensity .7\nLight Point 5 3 -5 Spectrum 380 600 Intensity .4\n"
MIRROR = "Surface Spectrum Magenta Constants .5 .4 0 0 20\n"
GLASS = "Surface Spectrum 380 750 Constants .1 .2 .7 1.4 60\n"
ROOM = f"""{VIEW}{LAMP}Sphere Point -1 0 2 Radius 1 {MIRROR}Sphere Point 1 .2 1 Radius .8 {GLASS}
Ellipsoid Center .2 -.6 0 Radii .9 .2 .3 Surface Spectrum 500 600 Constants .7 .1 0 0 9
Polygon Point -3 -1 6 Point 3 -1 6 Point 0 3 6 Surface Spectrum Red Constants .8 .1 0 0 5
Quadric Constants 1 0 1 0 0 0 0 -1 0 3 Surface Spectrum 380 500 Constants .6 0 0 0 1
Plane Point 0 -1.5 0 Vector 0 1 0 Surface Spectrum 380 750 Constants .5 .2 0 0 10
"""


def load(tmp_path: Path, text: str, faults: bool = False) -> clrt.Scene:
    (tmp_path / "a.txt").write_text(text)
    return clrt.load(tmp_path / "a.txt", faults=faults)


def test_clrt_agrees_with_the_program_without_its_faults(tmp_path: Path) -> None:
    """Colours and all: a byte may differ by 1, since the program cuts fractions off where clrt rounds."""
    scene = load(tmp_path, ROOM)
    ours, theirs = encode(clrt.render(scene).pixels), oracle.Program(scene).picture()
    assert len(np.unique(theirs.reshape(-1, 3), axis=0)) > 300
    assert check.within(ours, theirs, 1) > 0.995  # edges: measured 0.9984
    assert check.within(np.roll(ours, 1, axis=1), theirs, 1) < 0.9


FAULTS_SEEN = {
    "shadow epsilon": f"{VIEW}Light Point 3000 1500 0 Spectrum 380 750 Intensity 1\n"
    f"Plane Point 0 -1 0 Vector 0 1 0 {MIRROR}"
    f"Polygon Point -1 -.9 -4 Point 1 -.9 -4 Point 0 -.9 -2 {MIRROR}",
    "lost reflection": f"{VIEW}{LAMP}Sphere Point 0 0 2 Radius 3 "
    "Surface Spectrum 380 750 Constants 0 0 1 .6 1\n"
    f"Plane Point 0 -4 0 Vector 0 1 0 {MIRROR}",
    "highlight behind": f"{VIEW}Light Point 0 9 40000 Spectrum 380 750 Intensity 1\n"
    "Sphere Point 0 0 2 Radius 1 Surface Spectrum 380 750 Constants .1 .9 0 0 1\n",
    "no linear quadric": f"{VIEW}{LAMP}Quadric Constants 0 0 0 0 0 0 0 0 1 -4 {MIRROR}",
    "lost distance": f"{VIEW}{LAMP}Plane Point 0 0 2e6 Vector 0 0 -1 {MIRROR}",
    "plane at once": f"{VIEW}{LAMP}Plane Point 0 0 -5 Vector 0 1 0 {MIRROR}",
    "power of nothing": f"{VIEW}Light Point 0 0 -3000 Spectrum 380 750 Intensity 1\n"
    "Polygon Point -9 -9 3 Point 9 -9 3 Point 0 9 20 Surface Spectrum 380 750 Constants .1 .9 0 0 0\n",
}  # fmt: skip


def test_every_fault_is_tried() -> None:
    assert FAULTS_SEEN.keys() == oracle.FAULTS.keys()


@pytest.mark.parametrize("fault", FAULTS_SEEN)
def test_every_fault_changes_a_picture(tmp_path: Path, fault: str) -> None:
    scene = load(tmp_path, FAULTS_SEEN[fault])
    # a fault of feelers lets the light through where that of highlights is to be seen
    others = {"shadow epsilon"} - {fault} if fault == "highlight behind" else set()
    with_it, without = (oracle.Program(scene, faults).picture() for faults in ({fault} | others, others))
    assert (check.differences(with_it, without) > 2).any()


def test_clrt_renders_no_faults(tmp_path: Path) -> None:
    scene = load(tmp_path, ROOM, faults=True)
    assert oracle.Program(scene).faults == oracle.FAULTS.keys()
    with pytest.raises(clrt.SceneError, match=r"a\.txt: spectrum\.faults: faults are for validation"):
        clrt.render(scene)


@pytest.mark.shared
@pytest.mark.parametrize(
    ("name", "step"), [("example", 2), ("brushed", 4), ("progress_final", 10), ("mbs", 9)]
)
def test_published_pictures_are_the_programs_with_its_faults(
    shared_folder: Path, name: str, step: int
) -> None:
    (pair,) = [p for p in check.pairs(shared_folder / "data" / "thesis") if p.name == name]
    part = pair.picture[::step, ::step]
    assert check.within(oracle.Program(pair.scene, oracle.FAULTS).picture(step), part, 1) >= check.WITH_FAULTS
