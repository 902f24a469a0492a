"""On which cases a fault that nobody chose is looked for, and in which order: first where it is cheap.

Building the kernels for another format of rays takes as long as a hundred small pictures. So faults in
kernels are looked for on cases of as few formats as show every feature that a kernel can tell apart; faults
of the host, which need no build, on all cases.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import cache
from typing import Final

from clrt.base.errors import ClrtWarning
from clrt.flatten.flatten import flatten
from clrt.layout import RayFormat

from ..cases import matrix_cases
from ..coverage import fewest_cases
from .checks import CHECK
from .plant import REFITTED, small
from .run import MUTANTS

# of the host alone: to kernels these are numbers a band, like any others
_OF_TABLES: Final = frozenset((
    "colours in bands", "spectra in RGB", "named spectrum", "black body", "gaussian", "band", "line",
    "samples", "white balance", "metal by name",
))  # fmt: skip
# trees of many nodes, and of few wide ones; the cases of the matrix have but some leaves
_LARGE: Final = ("shipped sphereflake", "shipped mesh")
_BOTH: Final = "dispersive prism"  # what only rays with media and bands of their own run through
_REFITTED: Final = tuple(REFITTED + name for name in _LARGE)
_TREES: Final = ("tree.cl", "collapse.clh", "walk.clh", "leaves.clh", "intersect.clh", "packet.clh",
                 "frustum.clh", "gather.clh", "children.clh", "boxes.clh")  # fmt: skip


def cases_for(file: str) -> list[str]:
    """The cases on which faults in a file are looked for, the most promising first."""
    near = [case for mutant in MUTANTS.values() if mutant.file == file for case in mutant.cases
            if not case.startswith(CHECK)]  # fmt: skip
    if not file.startswith("kernels/"):
        # scenes that are scripts are run from where they ship alone, and a patched package links to them
        every = fewest_cases({name: case.shows for name, case in matrix_cases().items()})
        return list(dict.fromkeys([*near, *every, *_panel(), _LARGE[1], *matrix_cases()]))
    if file.rpartition("/")[2] in _TREES:
        near = [*_LARGE, *near]
    others = [case for case in matrix_cases() if _format(case) in {*map(_format, _panel())}]
    # of other faults a new tracer with them says nothing: it has other bits than the sound one, too
    again = _REFITTED if file.endswith("/refit.cl") else ()
    return list(dict.fromkeys([*near, *again, *_panel(), *_LARGE, *others]))


@cache
def _panel() -> Sequence[str]:
    """Cases of few formats that show every feature that kernels can tell apart."""
    shows = {name: case.shows - _OF_TABLES for name, case in matrix_cases().items()}
    missing, chosen, formats = frozenset().union(*shows.values()), list[str](), set[RayFormat]()
    while missing:
        # a new format has to bring what no case of the others does
        able = [name for name in shows if _format(name) in formats and shows[name] & missing]
        best = max(able or shows, key=lambda name: len(shows[name] & missing))
        chosen.append(best)
        formats.add(_format(best))
        missing -= shows[best]
    pictures = [name for name in shows if _format(name).images][:1]
    return [*chosen, *pictures, _BOTH]


@cache
def _format(case: str) -> RayFormat:
    scene = small(case.removeprefix(REFITTED))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ClrtWarning)  # of media that overlap: cases are to have such
        return flatten(scene).ray_format
