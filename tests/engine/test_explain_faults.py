"""Faults in what draws on lights, on lenses or of rough mirrors, or reads pictures, show in a tree."""

from __future__ import annotations

import pytest

import clrt
from clrt.device.device import Device
from tests.engine.test_explain import SIZE, WIDE, check_tree
from validation.mutants.plant import in_haste, patched
from validation.mutants.run import MUTANTS

AT = (9, 13), (13, 11), (33, 24), (36, 20)


@pytest.mark.parametrize(
    "name",
    [
        "a light's points on a line",
        "a disk of wedges with gaps",
        "facets seen as by a smooth surface",
        "texels of a row exchanged",
    ],
)
def test_a_planted_fault_moves_a_tree_away_from_the_recursion(name: str) -> None:
    mutant = MUTANTS[name]
    with patched(mutant.file, mutant.edit) as root, in_haste():
        tracer = clrt.Tracer(clrt.load_dict(WIDE), device=Device(kernels=root / "kernels"))
        with pytest.raises(AssertionError):
            for x, y in AT:
                check_tree(tracer, x, y, *SIZE, spp=4)
