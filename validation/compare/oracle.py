"""Our picture against an oracle's: figures, gates on them, and which rays are to blame.

No single figure is honest. SSIM forgives a wrong exponent, pixel tolerances forgive a lost shadow, and a
black background makes everything look right; so a comparison passes only where all of its gates do. Edges are
the one place where correct programs differ (a ray that just misses in one just hits in the other): a mask
made from the reference alone leaves them out of the pixel tolerances, and is itself bounded.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from clrt.base.layers import find

from ..types import Better, Comparison, Gate, OracleImage
from .metrics import brightening, encoded, flip, largest, psnr, relative, share, ssim, to_white
from .rays import FINE, RayRow, ray_rows

COARSE, FAR = 1e-3, 1e-2  # differences of linear radiance, relative above 1, as FINE
SIZE = "size"  # the gate of pictures that are not of one size, which have no other
_NEAR = 0.1  # of the median distance; what is nearer is rounded as its coordinates, not as its distance
_DISTANT = 100.0  # median distances; what is farther is rounded as its inverse distance
_MANY = 0.2  # share of lit pixels; so many are off by a fault, not by rounding or at an edge


@dataclass(frozen=True)
class Limits:
    """What a comparison must reach; None lets a gate go. Shares are of pixels, from 0 to 1."""

    ssim: float | None
    window: float | None  # the worst window of SSIM
    flip: float | None
    psnr: float | None  # dB
    mask: float | None  # largest share of edges
    fine: float | None = 0.999  # share within FINE, outside the mask
    coarse: float | None = 0.9999  # share within COARSE, likewise; the others are rounded up to whole pixels
    masked: float | None = 0.01  # share of the mask's pixels off by more than FAR; one pixel always may be
    mean: float | None = 1e-4  # relative difference of mean radiance, outside the mask
    rays: float | None = 0.999  # as `fine`, for each generation and kind of ray
    distance: float | None = 1e-5  # relative, outside the mask
    shape: float | None = 0.0  # share of pixels outside the mask with another shape
    layers: float | None = 0.999  # share of pixels outside the mask within FINE, of each layer of both
    clipped: float | None = None  # share of the reference's pixels above 1: FLIP and SSIM are blind to them
    lit: float | None = None  # share that is not black: a black picture agrees with too much
    not_finite: float | None = 0.0  # pixels


def limits(spp: int = 1, many_edges: bool = False) -> Limits:
    """The standard limits for pictures of `spp` samples.

    `many_edges`: for scenes made to look good, or by chance, rather than as a test; they have more edges, and
    may be dark or bright in places. At 16 samples pictures are 2/3 as wide or less, so that edges take 1.5
    times as large a share of them.
    """
    picture = {"mask": 0.08, "clipped": 0.01, "lit": 0.5}
    if many_edges:
        picture = {"mask": 0.30 if spp < 16 else 0.45}
    if spp < 16:
        return Limits(ssim=0.998, window=None, flip=0.002, psnr=45, **picture)
    if spp < 64:
        return Limits(ssim=0.9995, window=0.9, flip=0.002, psnr=60, **picture)
    return Limits(ssim=0.9999, window=0.9, flip=0.002, psnr=65, **picture)


def exact(base: Limits) -> Limits:
    """Stricter limits for an oracle in float64 that follows the very rays: what ours misses is rounding."""
    return dataclasses.replace(
        base,
        ssim=max(base.ssim or 0, 0.9995),
        window=0.9,
        flip=0.001,
        psnr=max(base.psnr or 0, 55),
        masked=0.005,
        mean=1e-5,
    )


def statistical(base: Limits, mean: float = 1e-2) -> Limits:
    """Limits for an oracle that draws its light at random: its noise hides single pixels, not the whole."""
    return dataclasses.replace(
        base,
        ssim=None,
        window=None,
        flip=None,
        fine=None,
        coarse=None,
        masked=None,
        rays=None,
        distance=None,
        layers=None,
        mean=mean,
    )


def _brighter(image: OracleImage, times: float) -> OracleImage:
    by_ray = {name: times * values for name, values in image.by_ray.items()}
    return dataclasses.replace(image, pixels=times * image.pixels, by_ray=by_ray)


def compare(
    ours: OracleImage,
    reference: OracleImage,
    mask: np.ndarray | None = None,
    spp: int = 1,
    limit: Limits | None = None,
) -> Comparison:
    """Our picture against an oracle's of the same case.

    mask: (h, w) bool, the edges, from the reference's side alone (`edge_mask`); None where there are none to
    leave out. `limit`: the gates' limits, by default `limits(spp)`. Dim pictures are compared brighter
    (`brightening`). Never raises for a bad picture: one of another size, or with NaN, fails its gate.
    """
    limit = limit or limits(spp)
    if ours.pixels.shape != reference.pixels.shape:
        detail = f"{size(ours.pixels)} in place of {size(reference.pixels)}"
        return Comparison({}, (Gate(SIZE, 1.0, 0.0, False, "low", detail),), {}, "picture, size")
    mask = np.zeros(reference.pixels.shape[:2], bool) if mask is None else np.asarray(mask, bool)
    bad = ~np.isfinite(ours.pixels).all(axis=-1)
    blank = ~np.isfinite(reference.pixels).all(axis=-1)
    times = brightening(reference.pixels)
    if times != 1.0:
        ours, reference = (_brighter(image, times) for image in (ours, reference))
    a = np.where(np.isfinite(ours.pixels), ours.pixels, 0.0).astype(np.float64)
    b = np.where(np.isfinite(reference.pixels), reference.pixels, 0.0).astype(np.float64)
    metrics, maps = _figures(a, b, mask)
    metrics |= {"not finite": float(np.count_nonzero(bad | blank))}
    metrics |= _geometry(ours, reference, mask)
    layers = _layers(ours, reference, mask)
    metrics |= {f"layer {name}": within for name, within in layers.items()}
    rows = ray_rows(ours, reference, mask)
    for row in rows:
        metrics |= {
            f"{row.key}: mean": row.mean,
            f"{row.key}: mean difference": row.mean_difference,
            f"{row.key}: largest": row.largest,
            f"{row.key}: within 1e-4": row.within,
        }
    if limit.masked is not None and mask.any():  # one pixel of a short edge is more than a share allows
        limit = dataclasses.replace(limit, masked=max(limit.masked, 1 / np.count_nonzero(mask)))
    if limit.coarse is not None and not mask.all():  # a share of a small picture, in whole pixels
        outside = np.count_nonzero(~mask)
        limit = dataclasses.replace(limit, coarse=1 - math.ceil((1 - limit.coarse) * outside) / outside)
    gates = (*_gates(metrics, limit), *_layer_gates(layers, limit), *_ray_gates(rows, limit))
    failed = [gate for gate in gates if not gate.passed]
    return Comparison(metrics, gates, maps, _blame(failed, rows, limit) if failed else "")


def _figures(
    a: np.ndarray, b: np.ndarray, mask: np.ndarray
) -> tuple[dict[str, float], dict[str, np.ndarray]]:
    """The figures of two finite linear pictures and their maps."""
    difference = a - b
    off, out = largest(relative(difference, b)), ~mask
    shown_a, shown_b = encoded(a), encoded(b)
    similarity, windows = ssim(shown_a, shown_b)
    perceived = flip(shown_a, shown_b)
    scale = max(float(np.mean(b[out])) if out.any() else 0.0, 1e-30)
    means = np.abs(difference[out].mean(axis=0)).max() if out.any() else 0.0
    metrics = {
        "SSIM": similarity,
        "worst window": float(windows.min()),
        **({"FLIP": perceived[0]} if perceived else {}),
        "PSNR": psnr(to_white(a), to_white(b)),
        "edges": share(mask),
        "within 1e-4": 1 - share(off[out] > FINE),
        "within 1e-3": 1 - share(off[out] > COARSE),
        "largest difference": float(off[out].max(initial=0.0)),
        "largest at edges": float(off[mask].max(initial=0.0)),
        "edges far off": share(off[mask] > FAR),
        "mean radiance": float(means) / scale,
        "clipped": share((b > 1).any(axis=-1)),
        "lit": share((b > 0).any(axis=-1)),
    }
    maps = {"difference": difference, "ssim": windows.mean(axis=-1), "mask": mask * 1.0}
    return metrics, maps | ({"flip": perceived[1]} if perceived else {})


def _geometry(ours: OracleImage, reference: OracleImage, mask: np.ndarray) -> dict[str, float]:
    """Shape numbers and hit distances, as far as both pictures have them.

    A plane at height h is met at t = h / sin(elevation), and float32 rounds the sine by some 1e-7 whatever it
    is: far out, 1 / t is as exact as near by, and t is not.
    """
    found: dict[str, float] = {}
    agree = ~mask
    if ours.shape is not None and reference.shape is not None:
        found["another shape"] = share((ours.shape != reference.shape)[agree])
        agree = agree & (ours.shape == reference.shape)
    if ours.t is not None and reference.t is not None:
        hit = agree & (np.isfinite(ours.t) | np.isfinite(reference.t))
        distances = reference.t[np.isfinite(reference.t)]
        median = float(np.median(distances)) if distances.size else 1.0
        with np.errstate(invalid="ignore", divide="ignore"):
            scale = np.maximum(reference.t[hit], _NEAR * median)
            scale *= np.maximum(scale / (_DISTANT * median), 1)
            error = np.abs(ours.t[hit].astype(np.float64) - reference.t[hit]) / scale
        found["distance"] = float(np.nan_to_num(error, nan=math.inf).max(initial=0.0))
    return found


def _layers(ours: OracleImage, reference: OracleImage, mask: np.ndarray) -> dict[str, float]:
    """Of each further layer that both have the share of pixels that are within FINE, outside edges.

    Distances relative to the way there, as `_geometry` takes it.
    """
    agree = ~mask
    if ours.shape is not None and reference.shape is not None:
        agree = agree & (ours.shape == reference.shape)
    found: dict[str, float] = {}
    for name in ours.layers.keys() & reference.layers.keys():
        mine, exact = (image.layers[name].astype(np.float64) for image in (ours, reference))
        scale = np.ones(mine.shape[:2])
        if find(name).picture == "nearness" and reference.t is not None:
            seen = reference.t[np.isfinite(reference.t)]
            median = float(np.median(seen)) if seen.size else 1.0
            scale = np.maximum(reference.t, _NEAR * median)
            scale *= np.maximum(scale / (_DISTANT * median), 1)
        with np.errstate(invalid="ignore"):
            off = np.where(mine == exact, 0.0, np.abs(mine - exact))  # both infinite where nothing is hit
            off = off.reshape(*off.shape[:2], -1).max(axis=2) / np.where(np.isfinite(scale), scale, 1.0)
        found[name] = share(off[agree] <= FINE) if agree.any() else 1.0
    return dict(sorted(found.items()))


def _layer_gates(layers: dict[str, float], limit: Limits) -> list[Gate]:
    if limit.layers is None:
        return []
    detail = "share of pixels within 1e-4, outside edges"
    return [gate(f"layer {name}", within, limit.layers, "high", detail) for name, within in layers.items()]


# figure, field of Limits that bounds it, which side is better, what it is
_GATES: tuple[tuple[str, str, Better, str], ...] = (
    ("not finite", "not_finite", "low", "pixels with NaN or infinity"),
    ("SSIM", "ssim", "high", "structural similarity of the whole picture"),
    ("worst window", "window", "high", "structural similarity of its worst 11 x 11 pixels"),
    ("FLIP", "flip", "low", "difference that an eye sees, mean"),
    ("PSNR", "psnr", "high", "dB"),
    ("within 1e-4", "fine", "high", "share of pixels whose radiance differs by no more, outside edges"),
    ("within 1e-3", "coarse", "high", "share of pixels whose radiance differs by no more, outside edges"),
    ("mean radiance", "mean", "low", "relative difference, outside edges"),
    ("edges far off", "masked", "low", "share of edge pixels that differ by more than 1e-2"),
    ("edges", "mask", "low", "pixels left out as the reference jumps there; a larger picture has fewer"),
    ("another shape", "shape", "low", "share of pixels that see another shape, outside edges"),
    ("distance", "distance", "low", "largest relative difference of a hit's distance, outside edges"),
    ("clipped", "clipped", "low", "share of the reference above 1, where SSIM and FLIP are blind"),
    ("lit", "lit", "high", "share of the reference that is not black"),
)


def _gates(metrics: dict[str, float], limit: Limits) -> list[Gate]:
    """The gates on a picture's figures; one whose limit or figure is missing is left out."""
    bounds = dataclasses.asdict(limit)
    return [
        gate(name, metrics[name], bounds[field], better, detail)
        for name, field, better, detail in _GATES
        if bounds[field] is not None and name in metrics
    ]


def _ray_gates(rows: list[RayRow], limit: Limits) -> list[Gate]:
    if limit.rays is None:
        return []
    detail = "share of pixels within 1e-4, outside edges; largest difference {:.2g}"
    return [gate(row.label, row.within, limit.rays, "high", detail.format(row.largest)) for row in rows]


def gate(name: str, value: float, limit: float, better: Better, detail: str = "") -> Gate:
    """A gate that passes where the value is on the right side of the limit or on it; NaN never passes."""
    passed = value <= limit if better == "low" else value >= limit
    return Gate(name, value, limit, bool(passed), better, detail)


def _blame(failed: list[Gate], rows: list[RayRow], limit: Limits) -> str:
    """Where it went wrong first: geometry, the worst rays of the earliest wrong generation, else a layer.

    Rays of later generations start from what earlier ones found, so that their failures follow from it. Rays
    that bring little light pass their gate even if all of it is wrong, which then shows in `off`.
    """
    names = {gate.name for gate in failed}
    if names & {"another shape", "distance"}:
        return "generation 0, camera, geometry"
    broken = [row for row in rows if not row.within >= (limit.rays or 0.999) or row.off > _MANY]
    layers = [gate for gate in failed if gate.name.startswith("layer ")]
    if layers and not broken:
        return min(layers, key=lambda gate: gate.value).name
    broken = broken or [row for row in rows if row.within < 1 and names - {"edges", "clipped", "lit"}]
    if not broken:
        return f"picture, {failed[0].name}"
    first = [row for row in broken if row.generation == broken[0].generation]
    terms = [row for row in first if row.is_term]
    return min(terms or first, key=lambda row: (row.within, -row.off)).label


def size(pixels: np.ndarray) -> str:
    """The size as "160 x 120"."""
    return f"{pixels.shape[1]} x {pixels.shape[0]}" if pixels.ndim >= 2 else f"an array {pixels.shape}"
