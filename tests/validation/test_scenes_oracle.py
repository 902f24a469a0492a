"""Every scene that ships, on the kernels and in the float64 oracle, which share no code."""

from __future__ import annotations

import numpy as np
import pytest

import clrt
from clrt.base.resources import shipped_scenes, validation_module
from clrt.formats.shipped import load_scene

oracle = validation_module("oracle64")

pytestmark = pytest.mark.filterwarnings("ignore::clrt.base.errors.ClrtWarning")
WIDTH = 40
# a lamp 30 times as bright as white, seen where a drop's direction stands still over the impact parameter
WITHIN = {"rainbow": 2e-3}


@pytest.mark.parametrize("name", shipped_scenes())
def test_the_picture_is_the_oracles(name: str) -> None:
    """Outside edges (pixels whose colour moves by 2e-3 under shifts of 0.05 pixel) 99.9 % are within 1e-4.

    Where WITHIN says nothing else.
    """
    scene = load_scene(name)
    ours = clrt.render(scene, width=WIDTH, spp=1).pixels
    theirs = oracle.render64(scene, width=WIDTH, spp=1)
    smooth = ~oracle.edge_mask(scene, reference=theirs.samples)
    wrong = (np.abs(ours - theirs.pixels) > WITHIN.get(name, 1e-4)).any(axis=2)
    assert smooth.mean() > 0.15  # else there is little to compare
    assert wrong[smooth].mean() <= 1e-3
