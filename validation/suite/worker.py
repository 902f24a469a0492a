"""What one process of the suite does: render cases and compare them. It keeps its device and its Mitsuba."""

from __future__ import annotations

import dataclasses
import multiprocessing
import os
import threading
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np

from clrt.device.device import Device
from clrt.device.settings import Settings
from clrt.engine.tripwire import NotFinite
from clrt.scene.scene import Scene

from .. import spd
from ..cases import case_named, own_file
from ..compare.causes import Cause
from ..compare.metrics import brightening
from ..compare.oracle import Limits, compare, gate, statistical
from ..coverage import PROGRAM
from ..noise import Excuses
from ..oracle_mitsuba import MitsubaError
from ..oracle_povray import client as povray
from ..oracle_povray.client import PovrayError
from ..oracles import (
    ORACLE64,
    POVRAY,
    lifted64,
    oracles,
    our_picture,
    picture64,
    scene_of,
    source_of,
    stand_in_of,
    why_not,
)
from ..twin.check import twin_check
from ..types import Case, CaseResult, CheckResult, Comparison, CountResult, OracleImage
from .alike import alike, compared, is_of_bytes
from .program import Program


def _end_with_parent() -> None:
    """Where this is a process of a pool: end it once nobody is left who takes what it finds."""
    parent = multiprocessing.parent_process()
    if parent is not None:

        def watch() -> None:
            parent.join()
            os._exit(1)

        threading.Thread(target=watch, name="parent", daemon=True).start()


_end_with_parent()  # the suite's processes have this module for an initializer

_FAR_SIGMA, _FAR_SHARE = 4.5, 1e-2  # of values that may be so many standard errors from a random oracle's
_AT_EDGES = {"SSIM", "worst window", "FLIP", "PSNR", "edges far off", "edges"}  # gates that count edges
_NOISY_PSNR = 40.0  # dB: what a random oracle's own noise leaves


@dataclass(frozen=True)
class Task:
    """A case to run. pictures: return them. rays: how many it takes, about. program: a further oracle."""

    name: str
    oracles: tuple[str, ...]
    device: int | str | None = None
    pictures: bool = False
    rays: int = 0
    program: Program | None = None


@cache
def device_of(wanted: int | str | None, check: bool = True) -> Device:
    """This process' device, its kernels built once. check: the tripwire is on, for the film hides a NaN."""
    return Device(wanted, Settings(check=check))


def run_case(task: Task) -> CaseResult:
    """Render a case by the kernels and by its oracles, and compare."""
    start = time.perf_counter()
    case = case_named(task.name)
    scene = scene_of(case)
    ours, tripped = seen(scene, task.device)
    reference, source = picture64(scene), source_of(case)
    additive = scene.spectrum is None or scene.spectrum.response == "cie"
    excuses = Excuses(case, scene, reference)
    results: dict[str, tuple[OracleImage, Comparison]] = {}
    unproven: dict[str, str] = {}
    for oracle in task.oracles:
        if oracle == POVRAY and povray.too_dark(reference.pixels):
            continue  # no words for it, as where `able` says so before
        try:
            picture: OracleImage | None = reference
            reason: str | None = None
            if oracle == POVRAY:
                reason = povray.missing() or why_not(oracle, case)
                picture = None if reason else povray.render(stand_in_of(case))
            elif oracle != ORACLE64:
                reason = oracles().unable(oracle, source)
                picture = None if reason else oracles().render(oracle, source)
        except (MitsubaError, PovrayError) as error:
            picture, reason = None, " ".join(str(error).split())
        if picture is None:
            unproven[oracle] = reason or ""
            continue
        judging = partial(judge, ours, picture, case, oracle, additive)
        comparison = excuses.judged(judging, oracle)
        if not comparison.passed and oracle.startswith("stock"):
            picture = dataclasses.replace(picture, pixels=picture.pixels - lifted64(case))
            comparison = excuses.judged(partial(judge, ours, picture, case, oracle, additive), oracle)
        if tripped:
            wrong = gate("tripwire", 1.0, 0.0, "low", tripped)
            comparison = dataclasses.replace(comparison, gates=(*comparison.gates, wrong))
        results[oracle] = picture, comparison
    if task.program is not None:
        beside(task.program, excuses, ours, results, unproven)
    passed = all(comparison.passed for _, comparison in results.values())
    kept = task.pictures and (not passed or not task.name.startswith("random"))
    results = {o: (lean(image, kept), lean_maps(found, kept)) for o, (image, found) in results.items()}
    ours = lean(ours, kept)
    causes = tuple(aliasing(found for _, found in results.values()))
    return CaseResult(case, ours, results, unproven, time.perf_counter() - start, causes)


def aliasing(comparisons: Iterable[Comparison]) -> Iterator[Cause]:
    """Why the pictures differ, where that is at too many edges and nowhere else.

    The edges are those of the float64 oracle's picture alone, which jumps there by itself.
    """
    failed = [{gate.name: gate.value for gate in found.gates if not gate.passed} for found in comparisons]
    failed = [gates for gates in failed if gates]
    if failed and all("edges" in gates and gates.keys() <= _AT_EDGES for gates in failed):
        share = f"{failed[0]['edges']:.0%} of the pixels"
        text = (
            f"details finer than pixels, as of a texture, checker or crowd far away: at {share} the oracle's "
            "own picture jumps when its samples move by a small part of a pixel, and all others agree; "
            "larger checks, or a picture's filter = 'mipmap', make them fewer"
        )
        yield Cause("aliasing", text, 0.0, certain=False)


def beside(program: Program, excuses: Excuses, ours: OracleImage,
           results: dict[str, tuple[OracleImage, Comparison]], unproven: dict[str, str]) -> None:  # fmt: skip
    """Let somebody else's program judge our picture, by what its file can hold and Mitsuba's limits.

    Nothing where its format has no words for the scene.
    """
    case, scene = excuses.case, excuses.scene
    name, origin = PROGRAM + program.name, own_file(case.name)
    if program.unable(scene, origin):
        return
    rendered = program.render(scene, origin)
    if rendered.pixels is None:
        unproven[name] = rendered.failure
        return
    eight = program.integer and is_of_bytes(rendered.pixels)
    theirs, mine = alike(rendered, ours, program, eight)
    judging = partial(compared, mine, theirs, case, eight)
    results[name] = theirs, excuses.judged(judging, "mitsuba-table")


def seen(scene: Scene, wanted: int | str | None) -> tuple[OracleImage, str]:
    """The kernels' picture, and what the tripwire said of it, if anything."""
    try:
        return our_picture(scene, device_of(wanted)), ""
    except NotFinite as error:
        return our_picture(scene, device_of(wanted, check=False)), str(error)


def count_published(name: str, folder: Path, device: int | str | None) -> list[CountResult]:
    """Ray counts of a published scene."""
    return spd.published_counts(name, folder, device_of(device))


def count_known(name: str, device: int | str | None) -> list[CountResult]:
    """Ray counts of a scene whose counts an oracle, or arithmetic, knows."""
    return spd.known_counts(name, device_of(device))


def run_twin(device: int | str | None) -> CheckResult:
    """The float32 twin's million rays."""
    return twin_check(device_of(device, check=False))


def judge(ours: OracleImage, picture: OracleImage, case: Case, oracle: str, additive: bool,
          edges: np.ndarray | None, limit: Limits) -> Comparison:  # fmt: skip
    """Compare; a picture from random paths is also asked whether what differs is within its own noise.

    Where colours are no sums over rays, what rays of each kind bring is no part of the picture.
    """
    if oracle == POVRAY:
        ours = OracleImage(np.clip(ours.pixels, 0, 1), {}, None, None, ours.name, ours.seconds)
    if not additive:
        ours, picture = (dataclasses.replace(image, by_ray={}) for image in (ours, picture))
    error = getattr(picture, "error", None)
    if error is None:
        return compare(ours, picture, edges, case.spp, limit)
    found = compare(ours, picture, edges, case.spp, dataclasses.replace(statistical(limit), psnr=_NOISY_PSNR))
    outside = np.ones(error.shape[:2], bool) if edges is None else ~edges
    least = 1e-4 / brightening(picture.pixels)
    sigma = np.abs(ours.pixels - picture.pixels)[outside] / np.maximum(error[outside], least)
    far = gate("beyond noise", float(np.mean(sigma > _FAR_SIGMA)), _FAR_SHARE, "low",
               f"share of values more than {_FAR_SIGMA} standard errors off")  # fmt: skip
    return dataclasses.replace(found, gates=(*found.gates, far))


def lean(image: OracleImage, kept: bool) -> OracleImage:
    """What a report needs of a picture: the picture, or only its name and time."""
    pixels = image.pixels.astype(np.float32) if kept else np.zeros((0, 0, 3), np.float32)
    return OracleImage(pixels, {}, None, None, image.name, image.seconds)


def lean_maps(comparison: Comparison, kept: bool) -> Comparison:
    maps = {name: values.astype(np.float32) for name, values in comparison.maps.items()} if kept else {}
    return dataclasses.replace(comparison, maps=maps)
