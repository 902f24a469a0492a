"""A suite's result as the report takes it: right and wrong pictures of one scene, all by our kernels."""

from __future__ import annotations

import dataclasses
from functools import cache
from typing import Any

import numpy as np

import compare_samples as samples
from clrt.base.resources import validation_module

types = validation_module("types")
compare = validation_module("compare.oracle")
SIZE = {"width": 160, "height": 120}
LIMIT = dataclasses.replace(compare.limits(many_edges=True), mask=None)


def edges(reference: Any) -> Any:
    metrics = validation_module("compare.metrics")
    moved = (samples.with_camera(shift=(0.05 * x, 0.05 * y)) for x, y in metrics.DIAGONAL)
    return metrics.edge_mask(reference.pixels, [samples.ours(scene, **SIZE).pixels for scene in moved])


def without_flip(found: Any) -> Any:
    """The same run where FLIP's package is not installed."""

    def bare(comparison: Any) -> Any:
        return dataclasses.replace(
            comparison,
            metrics={name: value for name, value in comparison.metrics.items() if name != "FLIP"},
            gates=tuple(gate for gate in comparison.gates if gate.name != "FLIP"),
            maps={name: values for name, values in comparison.maps.items() if name != "flip"},
        )

    cases = [
        dataclasses.replace(case, results={o: (image, bare(of)) for o, (image, of) in case.results.items()})
        for case in found.cases
    ]
    return dataclasses.replace(found, cases=cases, notes=("FLIP was not run",))


@cache
def result(wrong: bool = True) -> Any:
    """A run of three cases; where `wrong`, one fails, one oracle could not run and one mutant survived."""
    right = samples.ours(**SIZE)
    noise = np.random.default_rng(1).normal(0, 2e-6, right.pixels.shape)
    oracle = dataclasses.replace(right, pixels=right.pixels + noise, name="float64 oracle", seconds=1.5)
    other = dataclasses.replace(right, by_ray={}, name="Mitsuba 3.9.1", seconds=0.8)
    mask = edges(right)

    def case(name: str, mine: Any, unproven: dict[str, str]) -> Any:
        results = {
            label: (image, compare.compare(mine, image, mask, limit=LIMIT))
            for label, image in (("oracle64", oracle), ("mitsuba-table", other))
            if label not in unproven
        }
        about = types.Case(
            name,
            samples.SCENE,
            frozenset({"sphere", "fresnel"}),
            ("oracle64", "mitsuba-table"),
            160,
            120,
            note="A note & <b>no markup</b>.",
        )
        return types.CaseResult(about, mine, results, unproven, 2.25)

    cases = [case("all is well", right, {}), case("sphere in a room", right, {})]
    mutants = [
        types.MutantResult(
            "exponent",
            "kernels/light.clh",
            "m + 1 for m",
            ("oracle64",),
            False,
            "generation 0, camera, highlight",
        )
    ]
    if wrong:
        index = samples.ours(samples.with_material(2, ior=1.6), **SIZE)
        cases.append(case("glass of another index", index, {}))
        cases.append(case("half proven", right, {"mitsuba-table": "LLVM is missing"}))
        mutants.append(types.MutantResult("tie", "kernels/trace.cl", "last for first", (), True))
    counts = [types.CountResult("balls", "camera_hits", 263100, 263169, -69 / 263169)]
    coverage = {
        "sphere": {"oracle64", "mitsuba-table", *(f"stock-S{number}" for number in range(1, 9))},
        "fresnel": {"oracle64"} if wrong else {"oracle64", "mitsuba-table"},
    }
    return types.SuiteResult(
        cases,
        mutants,
        counts,
        coverage,
        {"clrt": "0.1", "mitsuba": "3.9.1"},
        "PoCL 3.0 / a CPU",
        254.0,
        7,
        "clrt validate --full --random 3 --seed 7",
        "2026-01-02 03:04",
        ("A note.",),
    )
