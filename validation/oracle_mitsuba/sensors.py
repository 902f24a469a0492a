"""Camera rays and pictures by Mitsuba's own plugins, at exact positions in the image (worker process)."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import engine
from .engine import dr, mi
from .skies import environment

Array = np.ndarray
PATHS = 1 << 21  # traced together


def camera_rays(
    sensor: dict[str, Any], eye: Array | None, position: Array, lens: Array | None = None
) -> tuple[Array, Array]:
    """Origins and unit directions (n, 3) through positions (n, 2) of the image, 0 to 1.

    eye: where rays start, (3,) or (n, 3), or None: where Mitsuba starts them (its near plane). lens: (n, 2),
    0 to 1, what a thin lens makes points of the disk of; None where there is none.
    """
    ray = _sampled(engine.load(sensor), position, lens)
    direction = engine.rows(ray.d, len(position))
    direction = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    origin = engine.rows(ray.o, len(position)) if eye is None else np.broadcast_to(eye, direction.shape)
    return origin, direction


def _sampled(sensor: Any, position: Array, lens: Array | None = None) -> Any:
    x, y = (mi.Float(np.ascontiguousarray(position[:, k], np.float32)) for k in range(2))
    at = mi.Point2f(0.5)
    if lens is not None:  # Mitsuba's +x is to the left
        u1, u2 = (mi.Float(np.ascontiguousarray(u, np.float32)) for u in (1 - lens[:, 0], lens[:, 1]))
        at = mi.Point2f(u1, u2)
    return sensor.sample_ray(0.0, 0.5, mi.Point2f(x, y), at)[0]


def stock_render(job: dict[str, Any]) -> dict[str, Any]:
    """A stock integrator's mean over `paths` paths per position (n, 2), its standard error, and what is hit.

    No film and no jitter: the integrator is asked for the very rays of these positions.
    """
    plan = job["scene"]
    sky = {"sky": environment(plan["sky"]["background"])} if "sky" in plan else {}
    scene = engine.load(plan | sky)
    integrator = engine.load(job["integrator"])
    n, paths = len(job["positions"]), job["paths"]
    mean, error = np.zeros((n, 3)), np.zeros((n, 3))
    block = max(1, PATHS // paths)
    for begin in range(0, n, block):
        rows = slice(begin, min(begin + block, n))
        count = rows.stop - rows.start
        ray = mi.RayDifferential3f(_rays(scene, job, np.repeat(np.arange(n)[rows], paths)))
        sampler = mi.load_dict({"type": "independent", "sample_count": paths})
        sampler.seed(job["seed"] * n + begin, count * paths)
        light, _, _ = integrator.sample(scene, sampler, ray)
        values = engine.rows(light, count * paths).reshape(count, paths, 3)
        mean[rows] = values.mean(axis=1)
        error[rows] = values.std(axis=1) / max(paths - 1, 1) ** 0.5
    spp = job["spp"]
    return {"mean": mean, "error": error if paths > 1 else None, **_first_hits(scene, job),
            "shares": shares(job["sensor"], job["off"], spp, n // spp)}  # fmt: skip


def _rays(scene: Any, job: dict[str, Any], rows: Array) -> Any:
    lens, eye = job["lens"], job["eye"]
    ray = _sampled(scene.sensors()[0], job["positions"][rows], None if lens is None else lens[rows])
    if eye is not None:
        ray.o = engine.point(np.broadcast_to(eye if eye.ndim == 1 else eye[rows], (len(rows), 3)))
    return ray


def shares(plugin: dict[str, Any], off: Array | None, spp: int, pixels: int) -> Array:
    """What each sample counts for in its pixel, (spp, pixels): by Mitsuba's own filter, so far off (spp,
    pixels, 2) the middle. They sum to 1; all are alike where most of them cancel."""
    if off is None:
        return np.full((spp, pixels), 1 / spp)
    kernel = engine.load(plugin["film"]["rfilter"])
    along = [engine.column(kernel.eval(mi.Float(off[..., k].astype(np.float32).ravel())), spp * pixels)
             for k in range(2)]  # fmt: skip
    weights = np.multiply(*along).reshape(spp, pixels).astype(float)
    whole = weights.sum(axis=0)
    cancelled = ~(whole > np.abs(weights).sum(axis=0) / 4)
    return np.where(cancelled, 1 / spp, weights / np.where(cancelled, 1, whole))


def _first_hits(scene: Any, job: dict[str, Any]) -> dict[str, Array]:
    n = len(job["positions"])
    ray = mi.Ray3f(_rays(scene, job, np.arange(n)))
    si = scene.ray_intersect(ray)
    dr.eval(si.t, si.n, si.shape)
    number = engine.words(si.shape, n)
    shape = np.full(n, -1)
    for plugin in scene.shapes():
        if plugin.id() in job["owners"]:
            shape[number == engine.number(plugin)] = job["owners"][plugin.id()]
    t = engine.column(si.t, n).copy()
    shape[~np.isfinite(t)] = -1
    point = engine.rows(ray.o, n) + np.where(np.isfinite(t), t, 0.0)[:, None] * engine.rows(ray.d, n)
    return {"t": t, "shape": shape, "point": point, "normal": engine.rows(si.n, n).copy()}
