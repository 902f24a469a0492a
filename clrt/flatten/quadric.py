"""Quadrics for the device: from the form a shape states to a centred, scaled float32 record with a tight box.

In world space a unit quadric 1000 units from the origin has a median error of 0.09 in `t`; about a centre of
its own 2e-6. So the centre is chosen here in float64, rounded to float32, and the form is then written about
exactly that point, and along its own axes, where what is thin is as thin as it is, wherever it points:
nothing is lost but the rounding of axes and coefficients.

Many quadrics are treated at once: `n` in the shapes below is their number.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from clrt import layout
from clrt.base.hints import Numbers, Rows

Corners = Rows

Parts = dict[str, np.ndarray]
"""Fields of `Forms`, `origin` and `curved`, by their names; what is left out is as `_stated` has it."""

_BLOCK = 1 << 11  # forms treated at once: each takes some 3 KB meanwhile
# Rounding moves a hit to where |F| is up to this times `_magnitude`: for a thin cylinder off the surface.
_NOISE = 2 * layout.QUADRIC_PAD
_VANISHES = 1e-14  # of the largest: what rounding in float64 leaves of 0
_COUNTS = 1e-4  # of a form's other terms on its surface: what is less moves it by half as much of its width
_NEARLY_FLAT = 0.05  # of a form's curvatures: the centre is at most 20 radii off its apex
_SWEEPS = 6  # of Jacobi's rotations, which converge quadratically


@dataclass(frozen=True)
class Forms:
    """F(d) = d.Qd + 2 g.d + J of d = p - origin, all float64, of many surfaces; outside is where F grows.

    p is in object space, or in the world once they are moved there. Coordinate i of `clip @ d` must lie in
    [low[i], high[i]]. `profile` is set (not NaN) for a surface of revolution: unit axis, s0, s1, alpha, beta,
    gamma of r^2 = alpha s^2 + beta s + gamma, s0 <= s <= s1.
    """

    q: np.ndarray  # (n, 3, 3)
    g: np.ndarray  # (n, 3)
    j: np.ndarray  # (n,)
    clip: np.ndarray  # (n, 3, 3)
    low: np.ndarray  # (n, 3)
    high: np.ndarray  # (n, 3)
    profile: np.ndarray  # (n, 8)

    def moved(self, by: np.ndarray, inverse: np.ndarray) -> Forms:
        """The same in terms of e, where d = inverse (by + e); shapes (n, 3) and (n, 3, 3)."""
        offset = _times(inverse, by)
        back = np.swapaxes(inverse, 1, 2)
        slope = _times(self.q, offset) + self.g
        clip_shift = _times(self.clip, offset)
        return Forms(
            q=back @ self.q @ inverse,
            g=_times(back, slope),
            j=_dot(offset, slope + self.g) + self.j,
            clip=self.clip @ inverse,
            low=self.low - clip_shift,
            high=self.high - clip_shift,
            profile=self.profile,
        )


@dataclass(frozen=True)
class Own:
    """F(x) = sum values_i x_i^2 + 2 g.x + j of forms along axes of their own, about their centres.

    axes: (n, 3, 3), unit, as rows, in world space; values, g: (n, 3); j: (n,).
    """

    axes: np.ndarray
    values: np.ndarray
    g: np.ndarray
    j: np.ndarray


class Form(NamedTuple):
    """A surface as a shape states it: few numbers, made a form by `records`, thousands at a time."""

    make: Callable[[np.ndarray], Parts]  # of the numbers of many, (n, k)
    matrix: np.ndarray  # world from object, (4, 4)
    numbers: tuple[float, ...]


def ellipsoid(matrix: np.ndarray, center: Numbers, radii: Numbers) -> Form:
    """The ellipsoid with semi-axes `radii` along the object's axes."""
    return Form(_ellipsoids, matrix, (*center, *radii))


def general(matrix: np.ndarray, coefficients: Numbers, clip: Corners | None = None) -> Form:
    """Ax^2 + By^2 + Cz^2 + 2Dxy + 2Eyz + 2Fxz + 2Gx + 2Hy + 2Iz + J = 0; `clip`: two corners of a box."""
    if clip is None:
        return Form(_generals, matrix, tuple(coefficients))
    return Form(_clipped, matrix, (*coefficients, *clip[0], *clip[1]))


def cone(matrix: np.ndarray, p0: Numbers, r0: float, p1: Numbers, r1: float) -> Form:
    """The side of a truncated cone (or cylinder) between the end circles (p0, r0) and (p1, r1)."""
    return Form(_cones, matrix, (*p0, *p1, r0, r1))


def paraboloid(
    matrix: np.ndarray, apex: Numbers, axis: Numbers, focal: float, height: float
) -> Form:
    """r^2 = 4 focal h for 0 <= h <= height, h along `axis` (any length) from the apex."""
    return Form(_paraboloids, matrix, (*apex, *axis, focal, height))


def _ellipsoids(numbers: np.ndarray) -> Parts:
    q = np.where(np.eye(3) == 1, 1.0 / np.square(numbers[:, 3:, None]), 0.0)
    return {"origin": numbers[:, :3], "q": q, "j": -np.ones(len(q)), "curved": np.full(len(q), 3)}


def _generals(numbers: np.ndarray) -> Parts:
    q = numbers[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]
    mixed = numbers[:, 3:6].any(axis=1)
    bends = np.abs(numbers[:, :3])
    bends[mixed] = np.abs(np.linalg.eigvalsh(q[mixed]))
    least = np.where(mixed, _VANISHES * bends.max(axis=1), 0.0)
    curved = (bends > least[:, None]).sum(axis=1)
    return {"q": q, "g": numbers[:, 6:9], "j": numbers[:, 9], "curved": curved}


def _clipped(numbers: np.ndarray) -> Parts:
    form, low, high = np.split(numbers, [10, 13], axis=1)
    return {**_generals(form), "clip": np.eye(3), "low": low, "high": high}


def _cones(numbers: np.ndarray) -> Parts:
    start, end, (r0, r1) = numbers[:, :3], numbers[:, 3:6], numbers[:, 6:].T
    length = _lengths(end - start)
    slope, middle = (r1 - r0) / length, 0.5 * (r0 + r1)
    axis = (end - start) / length[:, None]
    # written about its apex: rays near it have almost equal roots, which cancel about any other point
    pointed = np.minimum(r0, r1) < 0.1 * np.maximum(r0, r1)
    s0 = np.where(pointed, r0 / slope, -0.5 * length)
    s1 = np.where(pointed, s0 + length, 0.5 * length)
    origin = np.where(pointed[:, None], start - axis * s0[:, None], 0.5 * (start + end))
    beta = np.where(pointed, 0.0, 2 * middle * slope)
    gamma = np.where(pointed, 0.0, middle * middle)
    return _revolutions(origin, axis, s0, s1, slope * slope, beta, gamma)


def _paraboloids(numbers: np.ndarray) -> Parts:
    apex, axis, (focal, height) = numbers[:, :3], numbers[:, 3:6], numbers[:, 6:].T
    nothing = np.zeros(len(numbers))
    along = axis / _lengths(axis)[:, None]
    return _revolutions(apex, along, nothing, height, nothing, 4.0 * focal, nothing)


def _revolutions(origin: np.ndarray, axis: np.ndarray, *profile: np.ndarray) -> Parts:
    s0, s1, alpha, beta, gamma = profile
    first = np.arange(3) == 0  # the one coordinate that is clipped
    return {
        "origin": origin,
        "q": np.eye(3) - (1.0 + alpha)[:, None, None] * (axis[:, :, None] * axis[:, None, :]),
        "g": (-0.5 * beta)[:, None] * axis,
        "j": -gamma,
        "curved": np.where(alpha != 0, 3, 2),
        "clip": np.where(first[:, None], axis[:, None, :], 0.0),
        "low": np.where(first, s0[:, None], -np.inf),
        "high": np.where(first, s1[:, None], np.inf),
        "profile": np.column_stack([axis, *profile]),
    }


def records(forms: Sequence[Form]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """The quadrics as the device reads them, with their boxes, and which of them are too thin for that.

    Returns records (dtype Quadric, (n,)) and float64 boxes low, high (n, 3) without the usual padding but
    with room for the rounding of the form; infinite where the surface is unbounded or float32 cannot tell.
    Of those that are too thin, (n,), a curvature is lost in rounding: the record is of a plate or rod that
    never ends.
    """
    n = len(forms)
    out, thin = np.zeros(n, layout.dtype("Quadric")), np.zeros(n, bool)
    low, high = np.zeros((n, 3)), np.zeros((n, 3))
    for start in range(0, n, _BLOCK):
        part = slice(start, start + _BLOCK)
        low[part], high[part], thin[part] = _block(forms[part], out[part])
    return out, low, high, thin


def _stated(forms: Sequence[Form]) -> tuple[Forms, np.ndarray, np.ndarray]:
    """The forms; their origins (n, 3); along how many axes of their own they bend, (n,), if only a little:
    there Q is not 0 but for rounding."""
    n = len(forms)
    parts = {
        "q": np.zeros((n, 3, 3)),
        "g": np.zeros((n, 3)),
        "j": np.zeros(n),
        "clip": np.zeros((n, 3, 3)),
        "low": np.full((n, 3), -np.inf),
        "high": np.full((n, 3), np.inf),
        "profile": np.full((n, 8), np.nan),
        "origin": np.zeros((n, 3)),
        "curved": np.zeros(n, np.int64),
    }
    alike: dict[Callable[[np.ndarray], Parts], list[int]] = {}
    for number, form in enumerate(forms):
        alike.setdefault(form.make, []).append(number)
    for make, which in alike.items():
        for name, values in make(np.array([forms[number].numbers for number in which], np.float64)).items():
            parts[name][which] = values
    origin, curved = parts.pop("origin"), parts.pop("curved")
    return Forms(**parts), origin, curved


def _block(forms: Sequence[Form], out: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fill the records of some; their boxes, and which are too thin."""
    stacked, origin, curved = _stated(forms)
    matrix = np.stack([form.matrix for form in forms])
    linear = matrix[:, :3, :3]
    inverse = np.linalg.inv(linear)
    origin = _times(linear, origin) + matrix[:, :3, 3]

    low, high = _boxes(stacked, linear, np.zeros(len(forms)))
    bounded = np.isfinite(low).all(1) & np.isfinite(high).all(1)
    center = np.where(bounded[:, None], 0.5 * (low + high), 0.0)
    if not bounded.all():
        rest = ~bounded
        at_origin = Forms(*(part[rest] for part in vars(stacked).values())).moved(
            np.zeros((rest.sum(), 3)), inverse[rest]
        )
        center[rest] = _own_center(at_origin)
    apex = (stacked.profile[:, 5] > 0) & (stacked.profile[:, 6] == 0) & (stacked.profile[:, 7] == 0)
    center[apex] = 0.0
    center = (origin + center).astype(np.float32).astype(np.float64)

    world = stacked.moved(center - origin, inverse)
    values, axes = _own_axes(world.q)
    back = np.einsum("nij,nkj->nki", inverse, axes)  # the axes in object space, where forms are exact
    values = np.einsum("nki,nij,nkj->nk", back, stacked.q, back)
    all_values = values
    values = np.where(np.abs(values) > _VANISHES * np.abs(values).max(1, keepdims=True), values, 0.0)
    about = Own(axes, values, _settled(_times(axes, world.g), values, world.j), world.j)
    farthest = np.maximum(np.abs(low + origin - center), np.abs(high + origin - center))
    along_low, along_high = _boxes(stacked, axes @ linear, np.zeros(len(forms)))
    shift = _times(axes, center - origin)
    along = np.maximum(np.abs(along_low - shift), np.abs(along_high - shift))
    fewer = (values != 0).sum(1) < curved
    thin = fewer & _bends_unseen(all_values, values == 0, along, world.j)
    noise = np.where(bounded, _NOISE * _magnitude(about, farthest, along), 0.0)
    low, high = _boxes(stacked, linear, noise)
    low, high = low + origin, high + origin
    _write(out, center, about, world, low, high)
    return low, high, thin


def _bends_unseen(values: np.ndarray, lost: np.ndarray, along: np.ndarray, j: np.ndarray) -> np.ndarray:
    """Whether curvatures that are `lost` count on a surface that reaches so far along its own axes, (n,)."""
    endless = np.isinf(along)
    terms = np.abs(values) * np.square(np.where(endless, 0.0, along))
    others = terms.max(1)  # where they are more than J they cancel
    others = np.where(j == 0, others, np.minimum(others, np.abs(j)))
    return np.any(lost & (endless | (terms > _COUNTS * others[:, None])), axis=1)


def _boxes(forms: Forms, linear: np.ndarray, noise: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """World boxes, about the forms' origins, of the clipped F <= `noise`; infinite where it is unbounded."""
    low, high = _definite_boxes(forms, linear, noise)
    clip_low, clip_high = _clip_boxes(forms, linear)
    apart = np.any(np.maximum(low, clip_low) > np.minimum(high, clip_high), axis=1)
    low = np.where(apart[:, None], clip_low, np.maximum(low, clip_low))  # an empty surface: any box will do
    high = np.where(apart[:, None], clip_high, np.minimum(high, clip_high))
    turned = ~np.isnan(forms.profile[:, 0])
    low[turned], high[turned] = _revolution_boxes(forms.profile[turned], linear[turned], noise[turned])
    return low, high


def _revolution_boxes(
    profile: np.ndarray, linear: np.ndarray, noise: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Exact boxes of surfaces of revolution.

    In a world direction whose row of `linear` has the parts `along` and `across` the axis the surface reaches
    max(along s + across r(s)). r is convex for cones and cylinders, so that s0 or s1 gives the maximum; a
    paraboloid (alpha = 0) may have it where the derivative vanishes.
    """
    axis, (s0, s1, alpha, beta, gamma) = profile[:, :3], profile[:, 3:].T[..., None]
    along = _times(linear, axis)
    across = np.linalg.norm(linear - along[..., None] * axis[:, None, :], axis=2)
    gamma = gamma + noise[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        stationary = (np.square(0.5 * across * beta / along) - gamma) / beta
    stationary = np.where((alpha == 0) & np.isfinite(stationary), np.clip(stationary, s0, s1), s1)
    reach = []
    for sign in (1.0, -1.0):
        at = np.stack([np.broadcast_to(s, along.shape) for s in (s0, s1, stationary)])
        radius = np.sqrt(np.maximum(alpha * at * at + beta * at + gamma, 0.0))
        reach.append((sign * along * at + across * radius).max(axis=0))
    return -reach[1], reach[0]


def _definite_boxes(forms: Forms, linear: np.ndarray, noise: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Exact boxes of ellipsoids. One so thin that rounding could double its size counts as unbounded."""
    low, high = np.full(forms.g.shape, -np.inf), np.full(forms.g.shape, np.inf)
    values = np.linalg.eigvalsh(forms.q)
    least = 1e-12 * np.abs(values).max(1)
    sign = np.where(values[:, 0] > least, 1.0, np.where(values[:, 2] < -least, -1.0, 0.0))
    (which,) = np.nonzero(sign)
    q, g = sign[which, None, None] * forms.q[which], sign[which, None] * forms.g[which]
    inverse = np.linalg.inv(q) if len(which) else q
    middle = -_times(inverse, g)
    level = np.maximum(-(sign[which] * forms.j[which] + _dot(g, middle)), 0.0)
    spread = linear[which] @ inverse @ np.swapaxes(linear[which], 1, 2)
    half = np.sqrt((level + noise[which])[:, None] * np.diagonal(spread, axis1=1, axis2=2))
    center = _times(linear[which], middle)
    known = noise[which] <= 3.0 * level
    low[which[known]], high[which[known]] = (center - half)[known], (center + half)[known]
    return low, high


def _clip_boxes(forms: Forms, linear: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """World boxes of the clip boxes of object space."""
    closed = np.isfinite(forms.low).all(1) & np.isfinite(forms.high).all(1)
    low, high = np.full(forms.g.shape, -np.inf), np.full(forms.g.shape, np.inf)
    center = _times(linear[closed], 0.5 * (forms.low[closed] + forms.high[closed]))
    half = _times(np.abs(linear[closed]), 0.5 * (forms.high[closed] - forms.low[closed]))
    low[closed], high[closed] = center - half, center + half
    return low, high


def _own_center(forms: Forms) -> np.ndarray:
    """Where an unbounded quadric is best centred: near the origin, and where its gradient vanishes.

    Where it never does (a paraboloid, a plane), or only far off, as of a mirror that is nearly a paraboloid,
    as much of it as can vanishes near by, and the point is moved along the rest to the surface: to the apex.
    But a cone is written about its own apex, wherever it is, for rays near it have almost equal roots.
    """
    center, value, rest = _vanishing(forms, _NEARLY_FLAT)
    steep = np.linalg.norm(rest, axis=1) > 1e-9 * np.linalg.norm(forms.g, axis=1)
    square = np.where(steep, _dot(rest, rest), 1.0)
    step = np.where(steep, -0.5 * value / square, 0.0)[:, None] * rest
    near = np.abs(step).max(1) < 1e6 * (1.0 + np.abs(center).max(1))
    center = center + np.where(near[:, None], step, 0.0)
    apex, value, _ = _vanishing(forms, 1e-6)
    terms = np.abs(_dot(apex, _times(forms.q, apex))) + np.abs(2 * _dot(apex, forms.g)) + np.abs(forms.j)
    cone = np.abs(value) <= 1e-9 * terms
    return np.where(cone[:, None], apex, center)


def _vanishing(forms: Forms, least: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The point nearest the origin at which the gradient vanishes but for the directions in which the form is
    flatter than `least` of the steepest; the form there, and half its gradient."""
    center = -_times(np.linalg.pinv(forms.q, rcond=least, hermitian=True), forms.g)
    rest = forms.g + _times(forms.q, center)
    return center, _dot(center, rest + forms.g) + forms.j, rest


def _own_axes(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues (n, 3) and unit eigenvectors (n, 3, 3), as rows, of symmetric matrices (Jacobi's method).

    Not LAPACK's: where eigenvalues are equal its vectors are what rounding makes them, which differs from
    one processor to the next. Here they turn no further than they have to.
    """
    values, axes = q.copy(), np.broadcast_to(np.eye(3), q.shape).copy()
    for _ in range(_SWEEPS):
        before = values.tobytes(), axes.tobytes()
        for i, j in ((0, 1), (0, 2), (1, 2)):
            off, half = values[:, i, j], 0.5 * (values[:, j, j] - values[:, i, i])
            turns = np.abs(off) > _VANISHES * np.abs(values).max(axis=(1, 2))
            steep = half + np.copysign(np.sqrt(half * half + off * off), half)
            tangent = np.where(turns, off, 0.0) / np.where(turns, steep, 1.0)
            cosine = 1.0 / np.sqrt(1.0 + tangent * tangent)
            sine = tangent * cosine
            turn = np.broadcast_to(np.eye(3), q.shape).copy()
            turn[:, i, i], turn[:, i, j], turn[:, j, i], turn[:, j, j] = cosine, -sine, sine, cosine
            values, axes = turn @ values @ np.swapaxes(turn, 1, 2), turn @ axes
        if (values.tobytes(), axes.tobytes()) == before:  # nor would the next sweeps change anything
            break
    return np.diagonal(values, axis1=1, axis2=2).copy(), axes


def _settled(g: np.ndarray, values: np.ndarray, j: np.ndarray) -> np.ndarray:
    """The linear terms without those that are nothing but rounding."""
    natural = np.sqrt(np.abs(j) * np.abs(values).max(1)) + np.abs(g).max(1)
    return np.where(np.abs(g) > _VANISHES * natural[:, None], g, 0.0)


def _magnitude(about: Own, half: np.ndarray, along: np.ndarray) -> np.ndarray:
    """What rounding errors of F scale with on a surface that reaches so far in the world's directions and its
    own: the kernels' `quadric_magnitude`."""
    with np.errstate(invalid="ignore"):
        s, g = np.abs(about.values), np.abs(about.g)
        sums = _times(np.abs(about.axes), half)
        return 2 * _dot(s * along + g, sums) + _dot(along, s * along + 2 * g) + np.abs(about.j)


def _write(
    out: np.ndarray, center: np.ndarray, about: Own, forms: Forms, low: np.ndarray, high: np.ndarray
) -> None:
    """Fill the records. Each form is scaled by a power of two (which rounds nothing) to a slope near 1."""
    largest = np.abs(about.values).max(axis=1)
    slope = np.maximum(np.linalg.norm(about.g, axis=1), np.sqrt(np.abs(about.j) * largest))
    slope = np.where(slope > 0, slope, np.where(largest > 0, largest, 1.0))
    scale = np.exp2(-np.round(np.log2(slope)))
    out["center"][:, :3] = center
    for i, name in enumerate(("axis_x", "axis_y", "axis_z")):
        out[name][:, :3] = about.axes[:, i]
        out[name][:, 3] = about.g[:, i] * scale
    out["form"][:, :3] = about.values * scale[:, None]
    out["form"][:, 3] = about.j * scale
    # a clip box is closed: where it touches the surface, as at an apex, rounding must not open a hole
    farthest = np.maximum(np.abs(low - center), np.abs(high - center))
    for i, name in enumerate(("center", "clip_high", "reach")):
        out[name][:, 3] = 1.001 * farthest[:, i]
    farthest = np.where(np.isfinite(farthest), farthest, 0.0)
    slack = 16 * 2.0**-24 * _times(np.abs(forms.clip), farthest)
    for i, name in enumerate(("clip_x", "clip_y", "clip_z")):
        out[name][:, :3] = forms.clip[:, i]
        out[name][:, 3] = (forms.low - slack)[:, i]
    out["clip_high"][:, :3] = forms.high + slack
    reach = np.maximum(np.abs(low), np.abs(high))
    out["reach"][:, :3] = np.where(np.isfinite(reach), reach, 0.0)


def _times(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    return np.einsum("nij,nj->ni", matrices, vectors)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("ni,ni->n", a, b)


def _lengths(vectors: np.ndarray) -> np.ndarray:
    """`np.linalg.norm` of each of the rows, to the bit: the sums are BLAS's, as its own is."""
    return np.sqrt(np.matmul(vectors[:, None, :], vectors[:, :, None])[:, 0, 0])
