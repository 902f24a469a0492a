"""Large proofs with rays made on the device: no leak through shared edges, no surface that meets itself.

    python -m clrt_validation.proofs --leaks 1e8 --self-hits 1e7

prints what was found, and exits with 1 when a single ray fails.
"""

from __future__ import annotations

import argparse
import itertools
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import clrt
from clrt import layout
from clrt.device.device import Device
from clrt.device.opencl import cl
from clrt.engine import passes
from clrt.engine.queues import CAMERA, Queue, new_queue
from clrt.engine.world import World
from clrt.flatten.flatten import FlatScene, flatten

SCALES = (1e-4, 1e-2, 1.0, 1e3, 1e6)
DISTANCES = (0.0, 10.0, 1000.0)  # from the origin of the world, in sizes of the shape
Progress = Callable[[str, int], None]


@dataclass(frozen=True)
class Proof:
    """How many rays of a kind were traced, and how many failed."""

    name: str
    rays: int
    failed: int
    seconds: float


class Prover:
    """A device with the kernels of the product and those that make the rays."""

    def __init__(
        self, wanted: int | str | None = None, batch: int = 1 << 20, kernels: Path | None = None
    ) -> None:
        self.device = Device(wanted, kernels=kernels)
        self.batch = batch  # rays at a time, a multiple of 64
        source = (Path(__file__).parent / "kernels" / "aim.cl").read_text(encoding="utf-8")
        self._program = self.device.driver.build(self.device.kernels.source + '#line 1 "aim.cl"\n' + source)
        self.queue = new_queue(self.device, CAMERA, batch)

    def make(self, kernel: str, *arguments: Any) -> Queue:
        """Fill the queue with a batch of rays by a kernel of aim.cl, whose last parameter is the queue."""
        made = cl.Kernel(self._program, kernel)
        made.set_args(*arguments, self.queue.rays)
        cl.enqueue_nd_range_kernel(self.device.queue, made, (self.batch,), (64,))
        return self.queue

    def primitives(self, hits: passes.QueueHits) -> np.ndarray:
        return self.device.read(hits.primitive, np.empty(self.batch, np.int32))

    def fields(self, blocks: Any, fields: int, first: int, count: int) -> np.ndarray:
        """(batch, count) float64 of fields first .. first + count of a queue's blocks."""
        return self.queue.blocks(blocks, fields)[first : first + count].T.astype(np.float64)


def lumpy_ball(scale: float, center: np.ndarray, rings: int = 40, around: int = 60) -> dict[str, Any]:
    """A closed mesh about `center` that is seen whole from there; two corners have 60 triangles."""
    v = (np.arange(1, rings) / rings * np.pi)[:, None]
    u = np.arange(around) / around * 2 * np.pi
    radius = scale * (1 + 0.2 * np.sin(3 * u) * np.sin(v) ** 3)
    ball = np.stack(
        [radius * np.sin(v) * np.cos(u), radius * np.cos(v) + 0 * u, radius * np.sin(v) * np.sin(u)], -1
    )
    vertices = np.concatenate([[[0, scale, 0]], ball.reshape(-1, 3), [[0, -scale, 0]]]) + center
    ring = 1 + np.arange(rings - 1)[:, None] * around
    here, beside = ring + np.arange(around), ring + (np.arange(around) + 1) % around
    quads = np.stack([here[:-1], beside[:-1], beside[1:], here[1:]], -1).reshape(-1, 4)
    last = len(vertices) - 1
    top = np.stack([np.zeros(around, int), beside[0], here[0]], -1)
    bottom = np.stack([np.full(around, last), here[-1], beside[-1]], -1)
    faces = np.concatenate([top, quads[:, :3], quads[:, [0, 2, 3]], bottom])
    return {"type": "mesh", "vertices": vertices, "faces": faces}


def quad_box(scale: float, center: np.ndarray, divisions: int = 8) -> dict[str, Any]:
    """A closed cube of squares about `center`, `scale` from there to its sides."""
    lattice = np.arange(divisions + 1) * 2 / divisions - 1
    places: dict[tuple[float, ...], int] = {}
    faces = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            for u, v in np.ndindex(divisions, divisions):
                square = [(u, v), (u + 1, v), (u + 1, v + 1), (u, v + 1)][:: int(side)]
                corners = [np.roll([side, lattice[i], lattice[j]], axis) for i, j in square]
                faces.append([places.setdefault(tuple(corner.tolist()), len(places)) for corner in corners])
    return {"type": "mesh", "vertices": np.array([*places]) * scale + center, "faces": faces}


def _places() -> Iterator[tuple[float, np.ndarray]]:
    direction = np.array([0.48, 0.6, 0.64])
    for scale in SCALES:
        for distance in DISTANCES:
            yield scale, direction * distance * scale


def leaks(prover: Prover, rays: int, progress: Progress | None = None) -> Proof:
    """Rays from inside closed meshes, aimed at shared edges and corners: one that meets nothing leaked."""
    start, done, failed = time.perf_counter(), 0, 0
    places, n = list(itertools.product(_places(), ("aim_at_edges", "aim_at_sides"))), prover.batch
    share = -(-rays // (len(places) * n))
    for number, ((scale, center), kernel) in enumerate(places):
        edges = kernel == "aim_at_edges"
        flat = flatten(clrt.load_dict({"shapes": [(lumpy_ball if edges else quad_box)(scale, center)]}))
        many, size = (len(flat.triangles), 0.3 * scale) if edges else (len(flat.polygons), scale)
        world = World(prover.device, flat)
        middle = np.array([*center, 0], np.float32)
        for batch in range(share):
            seed = np.uint32(number * 65536 + batch)
            arguments = (np.uint32(n), np.uint32(many), seed, middle, np.float32(size))
            hits = passes.closest(prover.device, world, prover.make(kernel, *world.arguments, *arguments))
            failed += int((prover.primitives(hits) < 0).sum())
            prover.device.finish()
            done += n
            if progress:
                progress("leaks", done)
    return Proof(
        "leaks through shared edges and corners of closed meshes", done, failed, time.perf_counter() - start
    )


_LEANING = np.array([0.2, 0.9, 0.4]) / np.sqrt(1.01)


def _endless(slope: float, level: float) -> dict[str, Any]:
    """The quadric r^2 + 2 slope s + level = 0 without an end: s along _LEANING, r the distance from it."""
    (a, d, f), (_, b, e), (_, _, c) = np.eye(3) - np.outer(_LEANING, _LEANING)
    return {"type": "quadric", "coefficients": [a, b, c, d, e, f, *(slope * _LEANING), level]}


# each about 1 across, at the origin; every one is convex, so that only the way through it may meet it again
SOLIDS: dict[str, dict[str, Any]] = {
    "sphere": {"type": "sphere", "center": [0, 0, 0], "radius": 1},
    "ellipsoid": {"type": "ellipsoid", "center": [0, 0, 0], "radii": [1, 0.4, 0.7]},
    "cylinder": {"type": "cylinder", "p0": [-0.5, -0.6, 0], "p1": [0.5, 0.6, 0.2], "radius": 0.5},
    "cone": {"type": "cone", "p0": [0, -0.7, 0], "r0": 0.8, "p1": [0.1, 0.8, 0.3], "r1": 0.1},
    "spire": {"type": "cone", "p0": [0.1, -0.9, 0], "r0": 0.05, "p1": [0.3, 0.9, 0.2], "r1": 0},
    "flat cone": {"type": "cone", "p0": [0.01, -0.05, 0], "r0": 1, "p1": [0, 0.05, 0], "r1": 0.01},
    "rod": {"type": "cylinder", "p0": [-0.5, -0.6, 0.1], "p1": [0.5, 0.6, -0.3], "radius": 5e-4},
    "endless cylinder": _endless(0, -0.25),
    "endless paraboloid": _endless(-0.2, 0),
    "paraboloid": {
        "type": "paraboloid",
        "apex": [0, -0.8, 0],
        "axis": [0.2, 1, 0.1],
        "focal": 0.2,
        "height": 1.5,
    },
    "triangle": {
        "type": "mesh",
        "vertices": [[-1, -0.5, 0.2], [1, -0.4, 0], [0, 1, -0.3]],
        "faces": [[0, 1, 2]],
    },
    "needle": {
        "type": "mesh",
        "vertices": [[-1, -0.5, 0.2], [1, 0.5, -0.2], [0.3, 0.17, -0.06]],
        "faces": [[0, 1, 2]],
    },
    "hair": {
        "type": "mesh",
        "vertices": [[-1, 0.1, 0.7], [1, -0.1, -0.7], [-0.399, 0.042, 0.28]],
        "faces": [[0, 1, 2]],
    },
    "polygon": {"type": "polygon", "points": [[-1, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]]},
    "disk": {"type": "disk", "center": [0, 0, 0], "normal": [0.3, 1, 0.2], "radius": 1},
    "plane": {"type": "plane", "point": [0, 0, 0], "normal": [0.3, 1, 0.2]},
}


def _way_through(flat: FlatScene, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Distance to where rays from the surface of the scene's one curved primitive leave it, in float64."""
    if flat.primitives["kind"][0] == layout.KINDS["SPHERE"]:
        o = origins - flat.spheres["center_radius"][0, :3].astype(np.float64)
        return np.asarray(-2 * np.sum(o * directions, -1))
    record = flat.quadrics[0]
    rows = np.array([record[name] for name in ("axis_x", "axis_y", "axis_z")], np.float64)
    axes, g, form = rows[:, :3], rows[:, 3], record["form"][:3].astype(np.float64)
    o, d = (origins - record["center"][:3].astype(np.float64)) @ axes.T, directions @ axes.T
    slope = np.sum(d * (form * o + g), -1)
    with np.errstate(divide="ignore"):
        return np.asarray(-2 * slope / np.sum(form * d * d, -1))


def self_hits(prover: Prover, rays: int, progress: Progress | None = None) -> Proof:
    """Rays that leave a surface outwards must miss it; inwards not meet it before half of their way."""
    start, done, failed = time.perf_counter(), 0, 0
    places, n = list(_places()), prover.batch
    share = -(-rays // (2 * len(places) * len(SOLIDS) * n))
    rng = np.random.default_rng(20240613)
    for name, keys in SOLIDS.items():
        for scale, center in places:
            moved = {**keys, "transform": [{"scale": scale}, {"translate": center.tolist()}]}
            if name == "plane":
                moved = {**keys, "point": center.tolist()}
            flat = flatten(clrt.load_dict({"shapes": [moved]}))
            world = World(prover.device, flat)
            for _ in range(share):
                origins = center + 3 * scale * _directions(rng, n)
                aims = center + scale * _aims(keys, rng, n)
                far, numbers = np.full(n, np.inf, np.float32), np.arange(n, dtype=np.uint32)
                o, d = origins.astype(np.float32), (aims - origins).astype(np.float32)
                queue = passes.adopt(prover.device, o, d, far, numbers)
                first = passes.closest(prover.device, world, queue)
                for inner in (0, 1):
                    seed = np.uint32(rng.integers(1 << 32))
                    leaving = prover.make(
                        "leave_surfaces", first.surfaces, first.code, np.uint32(n), seed, np.uint32(inner)
                    )
                    failed += _met_again(prover, world, flat, leaving, bool(inner))
                    done += n
                prover.device.finish()
                if progress:
                    progress(name, done)
    return Proof("self-hits of rays that leave a surface", done, failed, time.perf_counter() - start)


def _aims(keys: dict[str, Any], rng: np.random.Generator, n: int) -> np.ndarray:
    """Places on a triangle or on an axis, however thin or long it is; about the middle of any other solid.

    Not near a cone's apex: where it is thinner than the distance of two coordinates, no point is outside.
    """
    if "vertices" in keys:
        return np.asarray(rng.dirichlet([1, 1, 1], n) @ np.array(keys["vertices"]))
    if "p0" in keys:
        return np.asarray(keys["p0"] + 0.8 * rng.random((n, 1)) * np.subtract(keys["p1"], keys["p0"]))
    if "coefficients" in keys:
        return 30 * rng.random((n, 1)) * _LEANING
    return 0.6 * _directions(rng, n)


def _directions(rng: np.random.Generator, n: int) -> np.ndarray:
    d = rng.normal(size=(n, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def _met_again(prover: Prover, world: World, flat: FlatScene, leaving: Queue, inner: bool) -> int:
    hits = passes.closest(prover.device, world, leaving)
    again = prover.primitives(hits) >= 0
    if not inner or flat.primitives["kind"][0] not in (layout.KINDS["SPHERE"], layout.KINDS["QUADRIC"]):
        return int(again.sum())
    t = prover.device.read(hits.t, np.empty(prover.batch, np.float32))
    numbers = np.flatnonzero(again)
    rays = prover.fields(leaving.rays, len(layout.RAY_FIELDS), 0, 6)[numbers]
    return int((t[numbers] < 0.5 * _way_through(flat, rays[:, :3], rays[:, 3:])).sum())


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="clrt_validation.proofs", description=(__doc__ or "").splitlines()[0]
    )
    parser.add_argument("--leaks", type=float, default=1e8, help="rays aimed at edges and corners")
    parser.add_argument("--self-hits", type=float, default=1e7, help="rays that leave surfaces")
    parser.add_argument("--device", default=None)
    arguments = parser.parse_args()
    prover = Prover(arguments.device)

    def progress(what: str, done: int) -> None:
        if sys.stderr.isatty():
            print(f"\r{what}: {done:,} rays ", end="", file=sys.stderr)

    proofs = [
        leaks(prover, int(arguments.leaks), progress),
        self_hits(prover, int(arguments.self_hits), progress),
    ]
    print(f"\non {prover.device.info.label}:")
    for proof in proofs:
        print(f"{proof.name}: {proof.failed} of {proof.rays:,} ({proof.seconds:.0f} s)")
    return int(any(proof.failed for proof in proofs))


if __name__ == "__main__":
    sys.exit(main())
