"""Does validation notice? Each deliberate fault is planted in a copy, rendered, and must fail a gate.

An oracle judges that does not reach the module with the fault: the float64 one, which shares no code with the
kernels and what is made for them, or Mitsuba's side for faults in what reads scenes. (The float32 twin would
catch anything, having been written after the kernels.)

    python -m validation.mutants [NAME ...]      plants these, or all
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Final

import numpy as np

from clrt.device.device import Device

from ..cases import case_named, tables
from ..compare.oracle import compare
from ..independence import reached
from ..limits import limits_of
from ..oracles import ORACLE64, SPECTRAL, edges64, oracles, our_picture, picture64, source_of
from ..types import Case, Comparison, MutantResult, OracleImage
from .audit import AUDIT_FAULTS
from .checks import CHECK, failed, passes
from .engine import ENGINE_FAULTS
from .extent import EXTENT_FAULTS
from .host import HOST_FAULTS
from .kept import once
from .kernels import KERNEL_FAULTS, Mutant
from .plant import REFITTED, in_haste, patched, picture_of, pictures_by_child, small
from .spectral import SPECTRAL_FAULTS
from .surfaces import SURFACE_FAULTS

_FAULTS: Final = (*KERNEL_FAULTS, *SURFACE_FAULTS, *HOST_FAULTS, *SPECTRAL_FAULTS, *AUDIT_FAULTS,
                  *ENGINE_FAULTS, *EXTENT_FAULTS)
MUTANTS: Final = {mutant.name: mutant for mutant in _FAULTS}
_EDGES = "edges of the mask"  # kept among the layers
_SECONDS = 120  # that a patched package may take for its pictures


def run_mutant(name: str, device: int | str | None = None) -> MutantResult:
    """Plant a fault and see whether its judge notices it on one of its cases, and what it blames."""
    mutant = MUTANTS[name]
    if mutant.cases[0].startswith(CHECK):
        return _checked(mutant)
    for case, ours in pictures_of(mutant, device):
        if case.startswith(REFITTED):
            if ours.pixels.tobytes() != sound(case, device).pixels.tobytes():
                return MutantResult(name, mutant.file, f"{case}: other bits", ("a new tracer",), False)
            continue
        oracle = judge_of(mutant.file, case)
        reason = oracles().unable(oracle, source_of(rendered(case)))
        if reason is not None:
            return MutantResult(name, mutant.file, f"not judged: {reason}", (), True)
        comparison = judged(case, ours, oracle)
        if not comparison.passed and is_sound(case, device, oracle):
            gates = ", ".join(gate.name for gate in comparison.gates if not gate.passed)
            return MutantResult(name, mutant.file, f"{case}: {gates}", (oracle,), False, comparison.worst)
    return MutantResult(name, mutant.file, f"no gate failed on {', '.join(mutant.cases)}", (), True)


def _checked(mutant: Mutant) -> MutantResult:
    """What the check says that a mutant names in place of cases."""
    check = mutant.cases[0].removeprefix(CHECK)
    passes(check)
    with patched(mutant.file, mutant.edit) as root:
        said = failed(root, check)
    if said:
        return MutantResult(mutant.name, mutant.file, said, (mutant.cases[0],), False)
    return MutantResult(mutant.name, mutant.file, f"no word from {mutant.cases[0]}", (), True)


def judge_of(planted: str, case: str) -> str:
    """The oracle that does not reach the module in which the fault is (of a table: the one that reads it)."""
    file = Path(planted)
    place = file.with_suffix("") if file.suffix == ".py" else file.parent
    module = ".".join(place.parent.parts if place.name == "__init__" else place.parts)
    read_for_both = module.startswith("clrt.formats")  # a case's file, before the oracle begins
    if module not in reached(ORACLE64) and not read_for_both:
        return ORACLE64
    assert module not in reached("mitsuba"), f"{module}: every oracle reaches it"
    return SPECTRAL if "spectrum" in tables(rendered(case).scene) else "mitsuba-table"


def rendered(case: str) -> Case:
    """The case whose picture it is, refitted or not."""
    return case_named(case.removeprefix(REFITTED))


def judged_by_mitsuba() -> list[str]:
    """The cases on which only Mitsuba's side can notice a fault: a quick run asks it for these, too."""
    return list(dict.fromkeys(case for mutant in MUTANTS.values()
                              for case in mutant.cases if not case.startswith((CHECK, REFITTED))
                              and judge_of(mutant.file, case) != ORACLE64))  # fmt: skip


def judged(case: str, ours: OracleImage, oracle: str) -> Comparison:
    """A picture of a case against an oracle's, by the case's gates on what differs."""
    picture, edges = reference(case)
    found = rendered(case)
    limits = dataclasses.replace(limits_of(found, oracle), mask=None, clipped=None,
                                 lit=None)  # of the reference alone
    theirs = picture if oracle == ORACLE64 else _theirs(case, oracle)
    return compare(ours, theirs, edges, found.spp, limits)


@cache
def is_sound(case: str, device: int | str | None, oracle: str) -> bool:
    """Whether the kernels as they are pass here; AssertionError, for else failing says nothing of a fault."""
    comparison = judged(case, sound(case, device), oracle)
    assert comparison.passed, f"{case}: fails without any fault, too: {comparison.worst}"
    return True


@cache
def sound(case: str, device: int | str | None) -> OracleImage:
    """Our picture without any fault. Never of a refitted tree, which has to have the same bits."""
    return our_picture(small(case.removeprefix(REFITTED)), Device(device))


@cache
def reference(case: str) -> tuple[OracleImage, np.ndarray]:
    """The float64 oracle's picture of a case, and the mask (h, w) of what lies at edges in it."""
    scene = small(case.removeprefix(REFITTED))

    def made() -> OracleImage:
        picture = picture64(scene)
        return dataclasses.replace(picture, layers={**picture.layers, _EDGES: edges64(scene, picture)})

    kept = once(ORACLE64, scene.to_dict(), scene.folder, made)
    layers = dict(kept.layers)
    edges = layers.pop(_EDGES)
    return dataclasses.replace(kept, layers=layers), edges


@cache
def _theirs(case: str, oracle: str) -> OracleImage:
    source = source_of(rendered(case))
    assert source.width is not None and source.height is not None
    half = dataclasses.replace(source, width=source.width // 2, height=source.height // 2)
    return once(oracle, dataclasses.asdict(half), half.folder, lambda: oracles().render(oracle, half))


def pictures_of(mutant: Mutant, device: int | str | None) -> Iterator[tuple[str, OracleImage]]:
    """The mutant's pictures of its cases, one after the other."""
    with patched(mutant.file, mutant.edit) as root:
        if mutant.file.startswith("kernels/"):
            opened = Device(device, kernels=root / "kernels")
            for case in mutant.cases:
                with in_haste():
                    picture = picture_of(case, opened)
                yield case, picture
        else:
            yield from pictures_by_child(root, mutant.cases, device, _SECONDS)
