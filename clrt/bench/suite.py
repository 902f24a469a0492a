"""The whole run: which cases, in which order, with how many threads; gives back a report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from clrt.bench import bands, embree, host, kernels, live, machine, queries, roof, scenes
from clrt.bench.frames import frame_times
from clrt.bench.report import Report
from clrt.bench.timing import Measurement, Tell, measure
from clrt.device.device import Device
from clrt.device.settings import Settings
from clrt.flatten.flatten import flatten
from clrt.scene.scene import Scene

GROUPS: Final = ("kernels", "queries", "builder", "launch", "compile", "frames", "bands", "program", "live")


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What to measure. `extra` are the caller's own scenes (name -> scene), rendered as frames only.

    isa: what Embree may use of the processor at most, "" for all there is.
    """

    groups: Sequence[str] = GROUPS
    names: Sequence[str] = tuple(scenes.SCENES)
    device: int | str | None = None
    rounds: int = 9
    quick: bool = False
    embree: bool = False
    isa: str = ""
    extra: dict[str, Scene] = field(default_factory=dict)
    settings: Settings = field(default_factory=Settings)

    def width(self, name: str) -> int:
        """Of the square picture whose queues are recorded: of slow scenes a smaller one."""
        return 128 if self.quick or name not in scenes.WHOLE else 512

    def turns(self, name: str) -> int:
        """Rounds: of slow scenes fewer."""
        return self.rounds if name in scenes.WHOLE else min(self.rounds, 3)


def run(plan: Plan, tell: Tell | None = None) -> Report:
    """Measure all that the plan names. ClrtError, before that, where the yardstick cannot be built."""
    device = Device(plan.device, plan.settings)  # first: Intel's loads beside no older TBB
    yardsticks = embree.builds(plan.isa) if plan.embree else ()
    before = machine.load()
    # the load that this run makes itself is no disturbance, so it is asked first
    found: list[Measurement] = []
    if "kernels" in plan.groups:
        with machine.one_core():
            found += _on_one_core(plan, yardsticks, tell)
    if "queries" in plan.groups:
        with machine.one_core():
            found += queries.times(plan.rounds, plan.device, plan.settings, plan.quick, tell, yardsticks)
    if "live" in plan.groups:
        with machine.one_core():
            found += live.times(plan.rounds, plan.device, plan.settings, plan.quick, tell)
    if "builder" in plan.groups:
        found += _builders(plan, yardsticks, tell)
    if "launch" in plan.groups:
        found += measure(host.launch_cases(device), plan.rounds, tell)
    if "frames" in plan.groups:
        frames = {} if plan.extra else _frames(plan)
        sizes = {name: (scene, _width(scene)) for name, scene in plan.extra.items()}
        found += frame_times(
            {**frames, **sizes}, _threads(device), plan.rounds, plan.device, plan.settings, tell
        )
    if "bands" in plan.groups:
        found += bands.times(plan.rounds, plan.device, plan.settings, plan.quick, tell)
    if "compile" in plan.groups:
        found += host.compile_times(plan.device, 1 if plan.quick else 3, tell)
    if "program" in plan.groups:
        found += host.program_times(plan.device, plan.rounds, tell)
    facts: dict[str, Any] = {**machine.facts(device), "load_before": before, "quick": plan.quick}
    if yardsticks:
        facts["embree"] = [f"{build.version} {build.isa}".strip() for build in yardsticks]
    return Report(facts, tuple(found))


def _on_one_core(plan: Plan, builds: tuple[embree.Build, ...], tell: Tell | None) -> list[Measurement]:
    """The roof, and the passes of every scene with Embree's calls between them."""
    single = Device(plan.device, replace(plan.settings, threads=1))
    found = measure(roof.cases(single, threads=1), plan.rounds, tell)
    for name in plan.names:
        scene, rounds = scenes.make(name, plan.quick), plan.turns(name)
        recording = kernels.recorded(scene, plan.width(name), plan.device, plan.settings)
        cases = kernels.cases(recording, name, passes_too=name in scenes.WHOLE)
        if not builds:
            found += measure(cases, rounds, tell)
            continue
        rays = {
            kind: kernels.rays_of(recording, kind) for kind in recording.rays if kind in kernels.RAY_KINDS
        }
        shape = embree.geometry(recording.world.flat)
        yardsticks = [embree.commit(build, shape, mode) for build in builds for mode in embree.MODES]
        robust = [yardstick for yardstick in yardsticks if yardstick.mode == "robust"]
        differ = {
            kind: max(_disagreement(recording, yardstick, rays[kind], kind) for yardstick in robust)
            for kind in rays
        }
        both = measure([*cases, *embree.tracing_cases(yardsticks, rays, name)], rounds, tell)
        found += [replace(m, extra={"disagree": differ[m.queue]}) if m.group == "embree" else m for m in both]
        for yardstick in yardsticks:
            yardstick.close()
    return found


def _disagreement(recording: Any, yardstick: embree.Yardstick, rays: np.ndarray, kind: str) -> float:
    return embree.disagreement(yardstick, rays, kernels.hits_of(recording, kind), kind == "shadow")


def _builders(plan: Plan, builds: tuple[embree.Build, ...], tell: Tell | None) -> list[Measurement]:
    found = []
    for name in plan.names:
        flat = flatten(scenes.make(name, plan.quick))
        shape = embree.geometry(flat) if builds else None
        cases = []
        for threads in _threads(Device(plan.device, plan.settings)):
            device = Device(plan.device, replace(plan.settings, threads=threads))
            cases += host.builder_cases(device, flat, name, threads)
            if shape is not None:
                for build in builds:
                    cases += embree.commit_cases(build, shape, name, threads)
        found += measure(cases, plan.turns(name), tell)
    return found


def _frames(plan: Plan) -> dict[str, tuple[Scene, int]]:
    """The sphereflake at 1024 x 1024, the terrain as the kernels see it, and two scenes that ship."""
    from clrt.formats.shipped import load_scene

    if plan.quick:
        return {"flake": (scenes.flake_frame(levels=2), 128)}
    return {
        "flake": (scenes.flake_frame(), 1024),
        "terrain": (scenes.terrain_frame(), 1024),
        "showcase": (load_scene("showcase"), 640),
        "room": (load_scene("room"), 320),
    }


def _width(scene: Scene) -> int:
    return scene.camera.width if scene.camera else 512


def _threads(device: Device) -> tuple[int, ...]:
    """One, and as many as the device has."""
    units = device.info.units
    return (1, units) if units > 1 and device.info.kind == "CPU" else (1,)
