"""The records that oracles, comparisons, the suite and its report hand to one another."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

Better = Literal["low", "high"]
COUNT_TOLERANCE = 0.005  # of published ray counts
FEWEST_ORACLES = 2  # that share no code, for every feature


@dataclass(frozen=True, eq=False)
class OracleImage:
    """One program's picture of a case: an oracle's, or ours."""

    pixels: np.ndarray  # float (h, w, 3): linear radiance
    # "generation 2 transmission" -> float (h, w, 3): what these rays added by their own local light, or {}
    by_ray: dict[str, np.ndarray]
    t: np.ndarray | None  # float (h, w): distance along the first sample's ray, inf on a miss
    shape: np.ndarray | None  # int (h, w): the scene's number of the shape it hits, -1 on a miss
    name: str  # the program and its version
    seconds: float
    # other layers of clrt's own by name, (h, w) or (h, w, 3), as far as there are
    layers: Mapping[str, np.ndarray] = field(default_factory=dict, kw_only=True)


@dataclass(frozen=True)
class Gate:
    """One figure that a comparison must reach."""

    name: str
    value: float
    limit: float
    passed: bool
    better: Better  # "low": value <= limit passes; "high": value >= limit does
    detail: str = ""


@dataclass(frozen=True, eq=False)
class Comparison:
    """What differs between our picture and an oracle's, and whether it may."""

    metrics: dict[str, float]
    gates: tuple[Gate, ...]
    # "difference" (h, w, 3) ours - reference; "ssim", "mask" and, where FLIP was run, "flip" (h, w)
    maps: dict[str, np.ndarray]
    worst: str = ""  # where it differs most, such as "generation 2, transmission"; "" where no gate failed

    @property
    def passed(self) -> bool:
        return all(gate.passed for gate in self.gates)


@dataclass(frozen=True, eq=False)
class Case:
    """A picture to render and the oracles that must agree with it."""

    name: str
    # a scene's tables, or the file of a scene that ships (a script describes its tables)
    scene: dict[str, Any] | Path
    features: frozenset[str]  # that its scene has
    oracles: tuple[str, ...]  # "oracle64", "mitsuba-table", "mitsuba-bsdf", "stock-S1", ...
    width: int
    height: int
    spp: int = 1
    max_depth: int | None = None
    note: str = ""
    shows: frozenset[str] = frozenset()  # features without which it is another picture, measured (`ticks`)
    # a scene of the same picture and the same shapes' numbers, for oracles that cannot express this one
    stand_in: dict[str, Any] | None = None
    is_test: bool = False  # made to test something, so that few of its pixels are edges


@dataclass(frozen=True, eq=False)
class CaseResult:
    """A case as it came out."""

    case: Case
    ours: OracleImage
    results: dict[str, tuple[OracleImage, Comparison]]  # by oracle
    unproven: dict[str, str] = field(default_factory=dict)  # oracle that did not run -> why
    seconds: float = 0.0
    # `compare.causes.Cause`s: why the picture of another program is wrong, the likeliest first
    causes: tuple[Any, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether every oracle that ran agrees; a case without one has proved nothing and does not pass."""
        return bool(self.results) and all(comparison.passed for _, comparison in self.results.values())


@dataclass(frozen=True)
class MutantResult:
    """A deliberate fault, and who noticed it."""

    name: str
    file: str
    description: str
    caught_by: tuple[str, ...]  # oracles that do not reach the module with the fault
    survived: bool
    where: str = ""  # what the comparison blamed, such as "generation 1, reflection"


@dataclass(frozen=True)
class CountResult:
    """Rays of one kind in a scene whose count was published."""

    scene: str
    kind: str
    ours: int
    published: int
    relative: float  # (ours - published) / published; ours where none were published

    @property
    def passed(self) -> bool:
        return abs(self.relative) <= COUNT_TOLERANCE


@dataclass(frozen=True)
class CheckResult:
    """Something that is right or not, such as the float32 twin's bits; `detail` says what was compared."""

    name: str
    passed: bool
    detail: str
    seconds: float


@dataclass(frozen=True, eq=False)
class SuiteResult:
    """A whole run of the suite: what the report, the JSON and the JUnit file are made from."""

    cases: list[CaseResult]
    mutants: list[MutantResult]
    counts: list[CountResult]
    coverage: dict[str, set[str]]  # feature -> oracles under which it passed
    versions: dict[str, str]
    device: str
    seconds: float
    seed: int | None  # of the random scenes
    command: str = ""  # that repeats the run
    started: str = ""  # date and time, for people
    notes: tuple[str, ...] = ()  # what else a reader should know: what was left out and why
    checks: tuple[CheckResult, ...] = ()
    known: int = 0  # cases that a full run of this kind has; 0: not known
    subject: str = ""  # another program's command, where that is the one under test
    stamp: dict[str, Any] = field(default_factory=dict)  # of the code, where this is a checkout
    kept: tuple[str, ...] = ()  # jobs whose results are of earlier runs, of the same code and inputs

    @property
    def thin(self) -> list[str]:
        """Features under fewer than FEWEST_ORACLES oracles that share no code."""
        from .independence import family

        families = {name: {family(oracle) for oracle in oracles} for name, oracles in self.coverage.items()}
        return sorted(name for name, of in families.items() if len(of) < FEWEST_ORACLES)

    @property
    def passed(self) -> bool:
        """All cases agree with all their oracles, no mutant survived, all counts are near, all is covered."""
        if self.subject and not self.cases:  # another program of which nothing could be asked
            return False
        if self.thin or any(mutant.survived for mutant in self.mutants):
            return False
        if any(case.unproven for case in self.cases) or not all(check.passed for check in self.checks):
            return False
        return all(case.passed for case in self.cases) and all(count.passed for count in self.counts)
