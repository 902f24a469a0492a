"""Any renderer as the one under test: its pictures of our cases, judged by the float64 oracle's.

What is wrong is told twice: case by case, with the gates that fail and the cause, where one is found; and
for all cases together, by the causes that explain most of them and the features that only failing ones have.
"""

from __future__ import annotations

import dataclasses
import datetime
import warnings
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Final

import numpy as np

from clrt.base.errors import ClrtError, ClrtWarning
from clrt.judging.verdict import LOSSY

from ..cases import case_named, matrix_cases, own_file
from ..compare.causes import BYTE, FLOAT, Cause
from ..compare.lossy import said
from ..compare.pictures import causes_between
from ..compare.reference import SceneReference
from ..noise import Excuses
from ..oracles import ORACLE64, Picture64, picture64, scene_of
from ..scenes import terms, views
from ..types import Case, CaseResult, OracleImage, SuiteResult
from .alike import alike, compared, is_of_bytes
from .program import Program
from .run import Plan, Progress, completed, versions
from .scenefiles import as_nff
from .worker import lean, lean_maps

SECONDS: Final = 20.0  # of processor time for the causes of one picture
REFERENCE: Final = ORACLE64
_MOST: Final = 5  # features that are told


@dataclass(frozen=True)
class Judged:
    """What one program made of one case."""

    result: CaseResult
    left_out: str = ""  # why the program was not asked
    told: str = ""  # of its picture's file

    @property
    def passed(self) -> bool:
        return self.result.passed


@dataclass(frozen=True)
class Task:
    """A case for a program. pictures: return them, too."""

    case: str
    program: Program
    device: int | str | None = None
    pictures: bool = False
    seconds: float = SECONDS


def judge_case(task: Task) -> Judged:
    """Let the program render a case, and compare."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ClrtWarning)  # cases are to have odd materials
        return _judge(task)


def _judge(task: Task) -> Judged:
    case = case_named(task.case)
    scene, nff = scene_of(case), task.program.scene_suffix == ".nff"
    if nff:
        scene = as_nff(scene, own_file(task.case))
    nothing = OracleImage(np.zeros((0, 0, 3)), {}, None, None, task.program.name, 0.0)
    try:
        rendered = task.program.render(scene, own_file(task.case))
    except ClrtError as error:
        why = f"it cannot be written as {task.program.scene_suffix}: {error}"
        return Judged(CaseResult(case, nothing, {}), left_out=why)
    if rendered.pixels is None:
        failed = dataclasses.replace(nothing, seconds=rendered.seconds)
        return Judged(CaseResult(case, failed, {}, {REFERENCE: rendered.failure}, rendered.seconds))
    reference = picture64(scene) if nff else _reference(task.case)
    eight = task.program.integer and is_of_bytes(rendered.pixels)
    theirs, wanted = alike(rendered, reference, task.program, eight)
    excuses = Excuses(case, scene, reference)
    judging = partial(compared, theirs, wanted, case, eight)
    comparison = excuses.judged(judging, "mitsuba-table")
    causes: tuple[Cause, ...] = ()
    if not comparison.passed:
        again = SceneReference(scene, case.width, case.height, task.device)
        edges = excuses.edges if theirs.pixels.shape == wanted.pixels.shape else None
        between = theirs.pixels, wanted.pixels, edges, BYTE if eight else FLOAT
        causes = causes_between(*between, again, task.seconds, rendered.bits)
    found = lean(wanted, task.pictures), lean_maps(comparison, task.pictures)
    ours, causes = lean(theirs, task.pictures), tuple(dataclasses.replace(c, undone=None) for c in causes)
    result = CaseResult(case, ours, {REFERENCE: found}, seconds=rendered.seconds, causes=causes)
    return Judged(result, told=said(rendered.bits) if rendered.bits in LOSSY else "")


@cache
def _reference(name: str) -> Picture64:
    return picture64(scene_of(case_named(name)))


def run(
    names: Sequence[str],
    program: Program,
    device: int | str | None = None,
    pictures: bool = False,
    progress: Progress | None = None,
    processes: int | None = None,
) -> list[Judged]:
    """Judge the program on cases, some at a time."""
    jobs = {name: (judge_case, Task(name, program, device, pictures)) for name in names}
    found = dict(completed(jobs, processes or Plan().processes, progress))
    return [found[name] for name in names]


def usual_cases(full: bool) -> list[str]:
    """What a program is asked where nobody says: one term of the model a case; full: all of the matrix."""
    if full:
        return [name for name, case in matrix_cases().items() if REFERENCE in case.oracles]
    return [name for name, _, _ in (*terms.scenes(), *views.scenes())]


def suite_result(judged: Sequence[Judged], program: Program, command: str, seconds: float) -> SuiteResult:
    """The run as the report, the JUnit file and the JSON take it."""
    notes = [f"{j.result.case.name} was left out: {j.left_out}" for j in judged if j.left_out]
    notes += told(judged)
    common = common_causes(judged)
    notes += [f"{count} of the cases that fail: {name}: {text}" for name, text, count in common]
    cases = [j.result for j in judged if not j.left_out]
    started = datetime.datetime.now().astimezone().isoformat(timespec="seconds")
    return SuiteResult(cases, [], [], {}, versions(), program.name, seconds, None, command, started,
                       tuple(notes), subject=program.text)  # fmt: skip


def told(judged: Sequence[Judged]) -> list[str]:
    """What is to be said of the files that the program writes."""
    return [f"its pictures are {text}" for text in dict.fromkeys(j.told for j in judged if j.told)]


def common_causes(judged: Sequence[Judged]) -> list[tuple[str, str, int]]:
    """Name, text and number of cases of each cause that was found first, the commonest first."""
    causes = [j.result.causes for j in judged if not j.passed]
    first = [found[0] for found in causes if found and found[0].likely and found[0].certain]
    counts = Counter(cause.name for cause in first)
    texts = {cause.name: cause.text for cause in first}
    return [(name, texts[name], count) for name, count in counts.most_common()]


def _shown(case: Case) -> frozenset[str]:
    """The features that a case shows as was measured; of somebody's own scene those that it has."""
    return case.shows or case.features


def suspects(judged: Sequence[Judged]) -> list[tuple[str, int]]:
    """Features that wrong pictures have and right ones have not, with how many have them.

    The commonest first, then those of the pictures that it does not account for. [] where none is right.
    """
    seen = [j for j in judged if j.result.results]
    right = {feature for j in seen if j.passed for feature in _shown(j.result.case)}
    left = [_shown(j.result.case) - right for j in seen if not j.passed]
    found: list[tuple[str, int]] = []
    while right and len(found) < _MOST:
        counts = Counter(feature for features in left for feature in features)
        if not counts:
            break
        feature, count = max(counts.items(), key=lambda item: (item[1], item[0]))
        found.append((feature, count))
        left = [features for features in left if feature not in features]
    return found
