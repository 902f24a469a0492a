"""How time and memory grow with one quantity at a time: primitives, pixels, lights, depth, threads, tile.

    python -m clrt.bench.scaling scaling.json [chart.svg] [--quick]

Each point is rendered in a process of its own, so that its peak of memory is its own.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from typing import Any, Final

from clrt.base.atomic import write_json
from clrt.base.errors import ClrtError
from clrt.bench import machine, scenes
from clrt.device.device import Device
from clrt.device.settings import Settings
from clrt.engine.tracer import Tracer
from clrt.images.plotting import drawing, save, subplots
from clrt.scene.scene import Scene


@dataclass(frozen=True, kw_only=True)
class Point:
    """One render: the sphereflake with `primitives` = 0, else a terrain of so many triangles; square."""

    primitives: int = 0
    width: int = 512
    lights: int = 3
    depth: int = 4
    threads: int | None = None
    tile: int = 1 << 17


Series = dict[str, list[tuple[float, Point]]]
LABELS: Final = {
    "primitives": "triangles",
    "pixels": "pixels",
    "pixels of 1M triangles": "pixels",
    "lights": "lights",
    "depth": "generations after the camera's",
    "threads": "threads",
    "threads, 1M triangles": "threads",
    "tile": "rays in a tile",
}
_TERRAIN: Final = {"lights": 1, "depth": 1}


def series(quick: bool = False) -> Series:
    """Name -> (what grows, render); `quick` stays far below what the curves are meant to show."""
    small = {"width": 64} if quick else {}
    most, widths = (3, (32, 64)) if quick else (6, (128, 256, 512, 1024, 2048, 4096))
    large: dict[str, Any] = {"primitives": 10**most, **_TERRAIN}
    wide: dict[str, Any] = small or {"width": 1024}
    return {
        "primitives": [
            (n, Point(primitives=n, **_TERRAIN, **small))
            for n in (10**k for k in range(2 if quick else 3, most + 1))
        ],
        "pixels": [(w * w, Point(width=w)) for w in widths],
        "pixels of 1M triangles": [(w * w, Point(width=w, **large)) for w in widths],
        "lights": [(n, Point(lights=n, **small)) for n in (1, 2, 4, 8, 16, 32, 64)[: 2 if quick else 7]],
        "depth": [(n, Point(depth=n, **small)) for n in range(2 if quick else 9)],
        "threads": [(n, Point(threads=n, **wide)) for n in (1, 2)],
        "threads, 1M triangles": [(n, Point(threads=n, **{**large, **wide})) for n in (1, 2)],
        "tile": [(1 << k, Point(tile=1 << k, **wide)) for k in ((10, 12) if quick else range(10, 21))],
    }


def render_point(point: Point, rounds: int, device: int | str | None = None) -> dict[str, Any]:
    """Seconds until ready (upload, tree) and of `rounds` renders after a warm-up; rays; bytes at the peak."""
    scene = _scene(point)
    start = time.perf_counter()
    tracer = Tracer(scene, device, Settings(threads=point.threads, tile=point.tile))
    tracer.device.finish()
    ready = time.perf_counter() - start
    times: list[float] = []
    rays = 0
    for _ in range(rounds + 1):
        start = time.perf_counter()
        rays = tracer.render(width=point.width).stats["traced"]
        times.append(time.perf_counter() - start)
    return {
        "point": asdict(point),
        "ready_seconds": ready,
        "seconds": times[1:],
        "rays": rays,
        "peak_bytes": machine.peak_bytes(),
        "device_bytes": tracer.device.held_bytes,
    }


def run(quick: bool = False, rounds: int = 5, device: int | str | None = None) -> dict[str, Any]:
    """Every series, a process a point."""
    before = machine.load()
    found: dict[str, list[dict[str, Any]]] = {}
    for name, points in series(quick).items():
        found[name] = []
        for x, point in points:
            order = json.dumps({"point": asdict(point), "rounds": rounds, "device": device})
            command = [sys.executable, "-m", "clrt.bench.scaling", "--point", order]
            done = subprocess.run(command, cwd=_ROOT, stdout=subprocess.PIPE, text=True)
            if done.returncode:
                raise ClrtError(f"scaling: {name} {x:g}: the render failed; its own message is above")
            found[name].append({"x": x, **json.loads(done.stdout)})
    return {"machine": {**machine.facts(Device(device)), "load_before": before}, "series": found}


@drawing()
def chart(content: dict[str, Any], path: str | Path) -> Path:
    """Seconds (dots, left) and peak of memory (dashes, right) over what grows; a panel a series."""
    panels = content["series"]
    columns = -(-len(panels) // 2)
    figure, grid = subplots(2, columns, figsize=(3.6 * columns, 6.4))
    for axes, (name, rows) in zip(grid.flat, panels.items(), strict=False):
        x = [row["x"] for row in rows]
        axes.plot(x, [median(row["seconds"]) for row in rows], "o-", color="C0", label="picture")
        if name == "primitives":
            axes.plot(x, [row["ready_seconds"] for row in rows], "s-", color="C2", label="upload and tree")
        axes.set(title=name, xlabel=LABELS[name])
        if name not in ("depth", "threads", "threads, 1M triangles"):
            axes.set(xscale="log", yscale="log" if name != "tile" else "linear")
        if axes.get_yscale() == "linear":
            axes.set_ylim(bottom=0)
        axes.set_ylabel("seconds", color="C0")
        memory = axes.twinx()
        memory.plot(x, [row["peak_bytes"] / 2**20 for row in rows], "--", color="C1")
        memory.set_ylim(bottom=0)
        memory.set_ylabel("MiB at the peak", color="C1")
        memory.spines["right"].set_visible(True)
    grid.flat[0].legend(frameon=False, fontsize=8)
    for axes in list(grid.flat)[len(panels) :]:
        axes.remove()
    figure.tight_layout()
    return save(figure, path)


_ROOT: Final = Path(__file__).resolve().parents[2]


def _scene(point: Point) -> Scene:
    if point.primitives:
        return scenes.terrain_frame(point.primitives, point.lights, point.depth)
    return scenes.flake_frame(point.lights, point.depth)


def main(arguments: Sequence[str] | None = None) -> int:
    """The script: measure, write the JSON, draw."""
    parser = argparse.ArgumentParser(description="Measure how time and memory grow.")
    parser.add_argument("json", nargs="?", help="file to write")
    parser.add_argument("chart", nargs="?", help="file to draw: .svg or .png")
    parser.add_argument("--quick", action="store_true", help="few and small points")
    parser.add_argument("--point", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.point:
        order = json.loads(options.point)
        print(json.dumps(render_point(Point(**order["point"]), order["rounds"], order["device"])))
        return 0
    if not options.json:
        parser.error("say which file to write")
    content = run(options.quick)
    write_json(options.json, content)
    if options.chart:
        chart(content, options.chart)
    return 0


if __name__ == "__main__":
    sys.exit(main())
