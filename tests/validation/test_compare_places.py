"""Small things that are missing: means over a large picture pass them, the widest place does not."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

import numpy as np
import pytest

import clrt
from clrt.images.file import uncurved
from validation.compare.metrics import HALO, PLACE, PLAIN, THIN, widest

ROOM = """
ambient = 0.1
background = [0.1, 0.2, 0.3]
camera = {origin = [0, 1.2, 5], target = [0, 0.6, 0], width = 640, height = 360}
lights = [{type = "point", position = [3, 5, 4], intensity = 0.8}]
[[shapes]]
type = "plane"
point = [0, 0, 0]
normal = [0, 1, 0]
[[shapes]]
type = "sphere"
center = [-0.8, 0.7, 0]
radius = 0.7
material = {diffuse = 0.2, reflection = 0.6}
"""
PEA = """
[[shapes]]
type = "sphere"
center = [0.6, 0.022, 0.5]
radius = 0.022
material = {color = [0.4, 0.8, 0.4]}
"""


def shown(values: np.ndarray) -> np.ndarray:
    """The linear picture that a screen shows like this."""
    return uncurved(np.clip(values, 0.0, 1.0))


def grey(side: int = 256) -> np.ndarray:
    across = np.linspace(0.3, 0.6, side)
    return np.repeat((across[:, None] + across) [..., None] / 2, 3, axis=2)


@pytest.mark.parametrize(
    ("side", "steps", "same"), [(3, 60, True), (4, 9, False), (4, 7, True), (4, -9, False)]
)
def test_a_place_is_as_wide_as_its_square(side: int, steps: int, same: bool) -> None:
    """PLACE pixels of PLAIN steps: one more of either is no single pixel."""
    assert (PLACE, PLAIN) == (3, 8 / 255)
    values = grey()
    values[100 : 100 + side, 40 : 40 + side, 1] += steps / 255
    verdict = clrt.compare(shown(values).astype(np.float32), shown(grey()).astype(np.float32), seconds=0)
    assert verdict.verdict == ("same picture" if same else "similar"), verdict
    assert verdict.figures["widest place"] == (side if abs(steps) > 8 else 0)


def test_edges_and_noise_are_no_places() -> None:
    """Of right programs: an edge that two draw a pixel apart, and light from random samples.

    Of noise as strong as PSNR lets be in all of a picture, or five times as strong in a part of it.
    """
    step, noise = np.zeros((64, 64, 3)), np.random.default_rng(7).normal(0, 10 ** (-45 / 20), (512, 512, 3))
    step[:, 32:34] = 0.8
    assert widest(step) == 2 and widest(noise) <= 1 and 1 <= widest(5 * noise[:100]) <= PLACE
    assert widest(np.full((64, 64, 3), 0.5)) == HALO, "no more is looked at"
    assert widest(np.zeros((4, 4, 3))) == 0 and widest(np.full((1, 9, 3), 1.0)) == 1


def test_places_are_found_across_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures are looked at in blocks, whose borders cut none."""
    from validation.compare import metrics

    monkeypatch.setattr(metrics, "_BLOCK", 64 * 256)
    values = grey()
    values[62:66, 40:44] += 0.1  # blocks are of 64 rows
    verdict = clrt.compare(shown(values).astype(np.float32), shown(grey()).astype(np.float32), seconds=0)
    assert verdict.figures["widest place"] == 4 and not verdict


def test_a_thing_that_is_missing_is_no_same_picture(tmp_path: Path) -> None:
    (tmp_path / "with.toml").write_text(ROOM + PEA)
    (tmp_path / "without.toml").write_text(ROOM)
    picture = clrt.render(clrt.load(tmp_path / "without.toml"))
    verdict = clrt.compare(picture, tmp_path / "with.toml")
    failed = [gate.name for gate in verdict.gates if not gate.passed]
    assert verdict.verdict == "similar" and not verdict and failed == ["widest place", "thin place"]
    assert verdict.causes[0].name == "shape 2 (sphere) missing"
    assert clrt.compare(picture, tmp_path / "without.toml").verdict == "identical"


@pytest.mark.parametrize("out", ["exr", "png"])
def test_a_program_that_leaves_a_thing_out_is_wrong(tmp_path: Path, out: str) -> None:
    from clrt.cli import main

    (tmp_path / "with.toml").write_text(ROOM + PEA)
    script = tmp_path / "renders.py"
    script.write_text(
        "import sys, clrt\nfrom msgspec.structs import replace\n"
        "scene = clrt.load(sys.argv[1])\n"
        "scene = replace(scene, shapes=scene.shapes[:int(sys.argv[3])])\n"
        "clrt.render(scene, spp=1).save(sys.argv[2])\n"
    )
    command = f"{shlex.quote(sys.executable)} {shlex.quote(str(script))} {{scene.toml}} {{out.{out}}}"
    for shapes, code in ((3, 0), (2, 1)):
        assert main(["validate", str(tmp_path / "with.toml"), "--against", f"{command} {shapes}"]) == code


ROD = """
[[shapes]]
type = "cylinder"
p0 = [1, 0.5, 1]
p1 = [1.03, 0.7, 1]
radius = 0.004
caps = true
material = {color = 0.9}
"""


def test_a_thin_thing_that_is_missing_is_no_same_picture(tmp_path: Path) -> None:
    """A cable or a rail: no square shows it, and means over a large picture do not."""
    large = ROOM.replace("width = 640, height = 360", "width = 1280, height = 720, spp = 4")
    (tmp_path / "with.toml").write_text(large + ROD)
    (tmp_path / "without.toml").write_text(large)
    without, right = (clrt.render(tmp_path / f"{name}.toml").pixels for name in ("without", "with"))
    verdict = clrt.compare(without, right, seconds=0)
    failed = {gate.name for gate in verdict.gates if not gate.passed}
    assert not verdict and "thin place" in failed <= {"thin place", "widest place"}
    assert clrt.compare(clrt.render(tmp_path / "with.toml", spp=9).pixels, right, seconds=0)


@pytest.mark.parametrize(
    ("width", "length", "found"),
    [(1, 200, 0), (2, 8, 16), (2, 24, 48), (2, 25, 50), (2, 200, 66), (3, 200, 99)],
)
def test_a_thin_place_is_as_long_as_its_square(width: int, length: int, found: int) -> None:
    """Lines of one pixel are edges that two right programs draw; a square of 33 has no more than 33 rows."""
    assert (HALO, THIN) == (16, 48)
    values = grey()
    values[20 : 20 + length, 70 : 70 + width, 1] -= 9 / 255
    verdict = clrt.compare(shown(values).astype(np.float32), shown(grey()).astype(np.float32), seconds=0)
    assert verdict.figures["thin place"] == found
    failed = {gate.name for gate in verdict.gates if not gate.passed}
    assert ("thin place" in failed) == (found > THIN) and failed <= {"thin place", "SSIM", "FLIP"}


def test_thin_places_are_found_across_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    from validation.compare import metrics

    monkeypatch.setattr(metrics, "_BLOCK", 64 * 256)
    values = grey()
    values[50:80, 40:42] += 0.1
    verdict = clrt.compare(shown(values).astype(np.float32), shown(grey()).astype(np.float32), seconds=0)
    assert verdict.figures["thin place"] == 60
