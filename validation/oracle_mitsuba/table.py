"""The table mode: Mitsuba says what rays meet and which lights are seen.

What surfaces do with light is computed here, in float64, from a table of materials: the full model.
`lobes.py` replaces these formulas by Mitsuba's own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from . import skies
from .facets import facet, smith
from .hashing import GATHERED, basis, child_path, combine, cosine_direction, on_disk, pair
from .lights import Way, surface, unhidden, ways
from .media import Media
from .optics import Optics, conductor, dot, normalized
from .pictures import Pictures
from .spot import Spot
from .whitted import AMBIENT, REFLECTION, TRANSMISSION, Rays, Shaded, drawing
from .world import FLATTEST, OFFSET, Hits, World

BEFORE_1 = 1 - 1e-15  # where a globe is whole its last field goes on
REACH = 1 - 2.0**-14  # of the way to a light; what lies nearer to the light does not hide it
WAY = normalized(np.array([[0.5698, 0.3713, 0.7331]]))[0]  # which edges and planes of no scene have
BESIDE = 16  # steps off a surface: nearer to its start a ray may have crossed an edge by its other side
PAST = 4  # steps: what is so far past an edge is not on it
PARALLEL = 0.999  # cosine of the angle between faces that are no edge, but one upon the other

Array = np.ndarray
PLAIN, GLOBE = 0, 2  # patterns, as in surfaces.py


class Table:
    """The table mode. job: `materials`, `lights`, `settings` and `geometry` as surfaces.py and plugins.py
    make them."""

    def __init__(self, job: dict[str, Any]) -> None:
        self.of = job["materials"]
        self.lights, self.settings = job["lights"], job["settings"]
        self.shapes = len(self.of["kd"]) - len(self.lights) - 1
        self.max_depth: int = self.settings["max_depth"]
        background = self.settings["background"]
        image = skies.read(background) if isinstance(background, str) else background
        self.sky = image if image.ndim == 3 else None
        self.center = job["geometry"]["center"]
        opaque = self.of["kt"] == 0
        self.media = Media(job["media"], job["states"])
        self.world = World(job["geometry"], opaque, self.settings["hides_backs"], self.plugins())
        self.pictures: Pictures = job["pictures"]
        self.clear = self.of["kt"][:, None] * self.of["Tt"] if self.settings["tinted"] else None

    def plugins(self) -> dict[str, Any]:
        """What Mitsuba's scene needs besides shapes."""
        return {}

    def meet(self, rays: Rays) -> tuple[Rays, Hits, Array]:
        """Nearest hits, those of boundaries left out behind which the same medium is on top.

        Rays come back with the states of media on this side of their hits, and weaker by what absorbs.
        """
        hits = self._nearest(rays)
        self._faced(rays, hits)
        here, beyond = rays.media.copy(), rays.media.copy()
        todo = np.flatnonzero(hits.shape >= 0)
        while todo.size:
            found = hits.take(todo)
            enters = dot(found.outward, rays.direction[todo]) <= 0
            beside = self._is_crossed(found, here[todo], enters)
            beside |= self._touched(rays.take(todo), found, here[todo], enters)
            here[todo], beyond[todo] = self.media.across(here[todo], found.shape, enters, beside)
            same = self.media.top(here[todo]) == self.media.top(beyond[todo])
            todo = todo[same & (self.media.number[found.shape] >= 0)]
            here[todo] = beyond[todo]
            start = hits.t[todo] + self.world.step(hits.point[todo])
            ahead = rays.take(todo)
            further = self._nearest(ahead, start)
            self._faced(ahead, further)
            hits.put(todo, further)
            todo = todo[hits.shape[todo] >= 0]
        sigma = self.media.sigma[self.media.top(here)]
        with np.errstate(invalid="ignore"):
            clear = np.where(sigma > 0, np.exp(-sigma * hits.t[:, None]), 1.0)
        return replace(rays, media=here, weight=rays.weight * clear), hits, beyond

    def _is_crossed(self, hits: Hits, states: Array, enters: Array) -> Array:
        """Where rays have just crossed an edge by its other side (n,): hits beside their starts whose inner
        sides lie in as many solids of the medium as are listed."""
        medium, step = self.media.number[hits.shape], self.world.step(hits.point)
        times, out = self.media.times(states, medium), np.zeros(len(enters), bool)
        asked = np.flatnonzero((hits.t <= BESIDE * step) & (medium >= 0) & ((times > 0) == enters))
        inner = hits.point[asked] - step[asked, None] * hits.outward[asked]
        out[asked] = self._solids(inner, medium[asked]) == times[asked]
        return out

    def _solids(self, point: Array, medium: Array) -> Array:
        """How many solids of media (n,) hold points: so many more of their surfaces are left than entered, on
        that of two opposite ways on which more are. An endless one is left on one of them only."""
        return np.maximum(self._leaves(point, medium, WAY), self._leaves(point, medium, -WAY))

    def _leaves(self, origin: Array, medium: Array, way: Array) -> Array:
        """How many more surfaces of media (n,) rays leave than they enter."""
        solids, going, start = np.zeros(len(medium), int), np.arange(len(medium)), np.zeros(len(medium))
        while going.size:
            ways = np.broadcast_to(way, (len(going), 3))
            met = self.world.nearest(origin[going], ways, np.full(len(going), -1), start)
            hit = met.shape >= 0
            met, going = met.take(np.flatnonzero(hit)), going[hit]
            same = self.media.number[met.shape] == medium[going]
            solids[going] += np.where(same, np.where(dot(met.outward, ways[hit]) > 0, 1, -1), 0)
            start = met.t + self.world.step(met.point)
        return solids

    def _touched(self, rays: Rays, hits: Hits, states: Array, enters: Array) -> Array:
        """Where rays only touch an edge (n,): they leave what they are not in, and enter it at once; or as
        much of the medium is behind the edge as before it."""
        medium, out = self.media.number[hits.shape], np.zeros(len(enters), bool)
        times, edge = self.media.times(states, medium), self.world.at_edge(hits)
        asked = np.flatnonzero(~enters & (medium >= 0) & (times == 0))
        if asked.size:
            ahead, t = rays.take(asked), hits.t[asked]
            other = self.world.nearest(ahead.origin, ahead.direction, ahead.form, t)
            near = other.t <= t + self.world.step(hits.point[asked]) + OFFSET * t
            same = self.media.number[other.shape] == medium[asked]
            out[asked] = near & same & (dot(other.outward, ahead.direction) <= 0)
        asked = np.flatnonzero(edge & (medium >= 0) & (~enters | (times == 0)))
        past = PAST * self.world.step(hits.point[asked])[:, None] * rays.direction[asked]
        before, behind = (self._solids(hits.point[asked] + way, medium[asked]) for way in (-past, past))
        out[asked] |= before == behind
        return out

    def _faced(self, rays: Rays, hits: Hits) -> None:
        """In the place of opaque inner sides at edges, the faces that rays meet from outside there."""
        opaque = (hits.shape >= 0) & (self.media.number[hits.shape] < 0)
        rows = np.flatnonzero(opaque & (dot(hits.outward, rays.direction) > 0))
        rows = rows[self.world.at_edge(hits.take(rows))]
        if not rows.size:
            return
        way = self.world.middle(hits.take(rows)) - hits.outward[rows]
        inwards = PAST * self.world.step(hits.point[rows])[:, None] * way
        ahead = rays.take(rows)
        near = PAST * self.world.step(hits.point[rows]) / FLATTEST
        start = np.maximum(hits.t[rows] - near, 0.0)
        other = self.world.nearest(ahead.origin + inwards, ahead.direction, ahead.form, start)
        facing, across = dot(other.outward, ahead.direction), np.abs(dot(other.outward, hits.outward[rows]))
        good = (np.abs(other.t - hits.t[rows]) <= near) & (facing <= 0) & (across < PARALLEL)
        hits.put(rows[good], other.take(good))

    def _nearest(self, rays: Rays, start: Any = None) -> Hits:
        """Nearest hits beyond `start`: of shapes, which Mitsuba finds, and of lights that are seen."""
        hits = self.world.nearest(rays.origin, rays.direction, rays.form, start)
        for number, light in enumerate(self.lights):
            if not light.get("visible"):
                continue
            t, outward = surface(light, rays.origin, rays.direction)
            rows = np.flatnonzero((t < hits.t) & (t > (0.0 if start is None else start)))
            point = rays.origin[rows] + t[rows, None] * rays.direction[rows]
            shape, form = np.full(len(rows), self.shapes + number), np.full(len(rows), -1)
            hits.put(rows, Hits(t[rows], shape, point, outward[rows], outward[rows], form, form.copy(),
                                np.zeros((len(rows), hits.chart.shape[1]))))
        return hits

    def shade(self, rays: Rays, hits: Hits, beyond: Array, kind: str, last: bool) -> Shaded:
        """The rays' own light, and the rays they spawn; those of the last generation bring depth_color
        instead."""
        shaded = Shaded(np.zeros_like(rays.direction), np.zeros((4, *rays.direction.shape)), [])
        met = np.flatnonzero(hits.shape >= 0)
        missed = np.flatnonzero(hits.shape < 0)
        ambient = self.settings["ambient"]
        shaded.light[missed] = ambient if kind == AMBIENT else self.background(rays.direction[missed])
        if not met.size:
            return shaded
        here = rays.take(met)
        spot = self._spot(here, hits.take(met), beyond[met])
        share = self.of["ka"][spot.shape, None] * spot.F
        gathers = (here.path & GATHERED == 0) & np.any(here.weight * share != 0, axis=1)
        gathers &= not last and self.settings["ambient_samples"] > 0
        constant = np.where(gathers[:, None], 0.0, share * ambient)
        received = [self._received(index, here, spot) for index in range(len(self.lights))]
        shaded.terms[:, met] = np.stack(
            [self._emission(spot, kind), constant, *sum(received, np.zeros((2, *share.shape)))]
        )
        shaded.light[met] = shaded.terms[:, met].sum(axis=0)
        for name, rows, weight, child in self._bounced(here, spot):
            if last:
                shaded.light[met[rows]] += weight * self.settings["depth_color"]
            else:
                shaded.children.append((name, child))
        if gathers.any():
            shaded.children.append((AMBIENT, self._gatherers(here, spot, share, np.flatnonzero(gathers))))
        return shaded

    def _emission(self, spot: Spot, kind: str) -> Array:
        """e (n, 3); of lights on a side that shines, nothing for ambient rays: feelers count them."""
        number = np.maximum(spot.shape - self.shapes, -1)  # -1 of all that is no light
        both = np.array([*(light.get("two_sided", False) for light in self.lights), False])
        dark = (number >= 0) & ((~both[number] & ~spot.enters) | (kind == AMBIENT))
        return np.where(dark[:, None], 0.0, spot.e)

    def _spot(self, rays: Rays, hits: Hits, beyond: Array) -> Spot:
        u = rays.direction
        enters = dot(hits.outward, u) <= 0
        n = np.where(enters[:, None], hits.outward, -hits.outward)
        ns = np.where((dot(hits.shading, n) < 0)[:, None], -hits.shading, hits.shading)
        ns = np.where((dot(ns, u) < 0)[:, None], ns, n)
        cone = np.stack([rays.cone[:, 0] + rays.cone[:, 1] * hits.t, rays.cone[:, 1]], 1)
        ns = self.pictures.bent(ns, n, u, cone[:, 0], hits)
        tones = {name: self.of[name][hits.shape] for name in ("H", "M", "Tt", "e")}
        tones = self.pictures.tones({"F": self.reflectance(hits), **tones}, u, cone[:, 0], hits)
        step = self.world.step(hits.point)
        back = np.minimum(step + OFFSET / 4 * hits.t, hits.t)[:, None] * u
        sides = self._indices(hits.shape, rays.media, beyond, enters)
        return Spot(hits.shape, hits.point, hits.outward, n, ns, enters, step, back, form=hits.form,
                    eta_i=sides[0], eta_t=sides[1], media=rays.media, beyond=beyond, cone=cone,
                    **tones)  # fmt: skip

    def _indices(self, shape: Array, here: Array, beyond: Array, enters: Array) -> tuple[Array, Array]:
        """Indices of refraction on this side and beyond; sheets and opaque surfaces have theirs inside."""
        eta_i, eta_t = (self.media.eta[self.media.top(states)] for states in (here, beyond))
        own = self.media.number[shape] < 0
        eta_t = np.where(own, self.of["eta"][shape], eta_t)
        behind = own & ~enters & ~self.of["thin"][shape] & ~self.of["conductor"][shape]
        return np.where(behind, eta_t, eta_i), np.where(behind, eta_i, eta_t)

    def reflectance(self, hits: Hits) -> Array:
        """F (n, 3): plain, squares on flat shapes, fields on spheres."""
        shape, of = hits.shape, self.of
        pattern = of["pattern"][shape]
        offset = hits.point - of["origin"][shape]
        squares = [np.floor(dot(offset, of[side][shape]) / of["size"][shape]) for side in ("across", "up")]
        u, v = skies.longitude_latitude(hits.outward)
        divisions = of["divisions"][shape]
        u, v = np.minimum(u, BEFORE_1), np.minimum(v, BEFORE_1)
        fields = [np.floor(u * divisions), np.floor(v * divisions / 2)]
        cell = np.where(pattern == GLOBE, fields[0] + fields[1], squares[0] + squares[1])
        odd = (pattern != PLAIN) & (cell % 2 == 1)
        return np.where(odd[:, None], of["F2"][shape], of["F"][shape])

    def background(self, direction: Array) -> Array:
        """Radiance (n, 3) of directions that meet nothing."""
        if self.sky is None:
            return np.broadcast_to(self.settings["background"], direction.shape)
        return skies.bilinear(self.sky, direction)

    def _received(self, index: int, rays: Rays, spot: Spot) -> Array:
        """What light number `index` adds at hits: diffuse and highlight (2, n, 3)."""
        of, shape = self.of, spot.shape
        origin = spot.start_before
        scatters = (of["kd"][shape] > 0) | (of["ks"][shape] > 0)
        added = np.zeros((2, *origin.shape))
        for way in ways(self.lights[index], index, origin, rays.base, rays.sample):
            L, distance, factor = way
            rows = np.flatnonzero((dot(spot.n, L) > 0) & (dot(spot.ns, L) > 0) & scatters)
            if rows.size:
                reach = REACH * distance[rows]
                seen = self.world.visible(origin[rows], L[rows], spot.form[rows], reach, self.clear)
                seen = seen * unhidden(self.lights, index, origin[rows], L[rows], reach)
                here = L[rows], distance[rows], factor[rows]
                added[:, rows] += seen * self.local(index, rays.direction[rows], spot.take(rows), here)
        return added

    def local(self, index: int, u: Array, spot: Spot, way: Way) -> Array:
        """I f(r) kd F (Ns.L) and I f(r) ks H (R.V)^m, unshadowed (2, n, 3), of a light this way."""
        light, of, shape = self.lights[index], self.of, spot.shape
        L, _, factor = way
        cosine = dot(spot.ns, L)
        aligned = -dot(2 * cosine[:, None] * spot.ns - L, u)
        with np.errstate(all="ignore"):
            lobe = np.where(aligned > 0, aligned ** of["m"][shape], 0.0)
        if light.get("visible"):  # mirrors show it
            lobe = np.where(of["kr"][shape] > 0, 0.0, lobe)
        highlight = self._faded(spot.H, shape, cosine)
        value = np.stack(
            [(of["kd"][shape] * cosine)[:, None] * spot.F, (of["ks"][shape] * lobe)[:, None] * highlight]
        )
        return np.asarray(light["intensity"] * factor[:, None] * value)

    def _faded(self, tint: Array, shape: Array, cosine: Array) -> Array:
        """Schlick's approximation on the shapes that have it: a tint goes to 1 at grazing angles."""
        grazing = tint + (1 - tint) * (1 - cosine[:, None]) ** 5
        return np.where(self.of["schlick"][shape, None], grazing, tint)

    def _bounced(self, rays: Rays, spot: Spot) -> Iterator[tuple[str, Array, Array, Rays]]:
        """Reflected and transmitted rays, with the rows (m,) they come from and their shares (m, 3) of
        those."""
        found = self._rough(self.optics(rays.direction, spot, spot.ns), rays, spot)
        smooth = self.of["alpha"][spot.shape] == 0
        astray = (dot(found.reflected, spot.n) <= 0) | (dot(found.transmitted, spot.n) >= 0)
        again = np.flatnonzero(smooth & astray)
        if again.size:  # a shading normal that bends a ray through the surface: the geometric one does not
            part = spot.take(again)
            by_n = self.optics(rays.direction[again], part, part.n)
            mirrored = dot(found.reflected[again], part.n) <= 0
            crossed = ~found.total[again] & (dot(found.transmitted[again], part.n) >= 0)
            found.reflected[again[mirrored]] = by_n.reflected[mirrored]
            for name in ("transmitted", "total", "reflects", "transmits"):
                getattr(found, name)[again[crossed]] = getattr(by_n, name)[crossed]
        outcomes = (
            (REFLECTION, found.reflects, found.reflected, spot.start_before, 1),
            (TRANSMISSION, found.transmits, found.transmitted, spot.start_behind, 2),
        )
        for name, share, direction, start, number in outcomes:
            weight = rays.weight * share
            most = weight.max(axis=1)
            rows = np.flatnonzero((most > 0) & (most >= self.settings["min_weight"]))
            if rows.size:
                path = child_path(rays.path[rows], number) | rays.path[rows] & np.uint32(15)
                media = spot.beyond if name == TRANSMISSION else spot.media
                child = Rays(start, direction, weight, rays.pixel, rays.path, spot.form, media, rays.base,
                             rays.sample, spot.cone).take(rows)  # fmt: skip
                yield name, rows, share[rows], drawing(replace(child, path=path))

    def optics(self, u: Array, spot: Spot, n: Array) -> Optics:
        """Reflection and refraction of directions u at the normals n, in the model's formulas."""
        of, shape = self.of, spot.shape
        kr = of["kr"][shape, None] * self._faded(spot.M, shape, -dot(spot.ns, u))
        kt = of["kt"][shape, None] * spot.Tt
        thin = of["thin"][shape]
        eta_i, eta_t = spot.eta_i, spot.eta_t
        cos_i = -dot(n, u)
        reflected = normalized(u + 2 * cos_i[:, None] * n)
        eta = eta_i / eta_t
        k = 1 - eta**2 * (1 - cos_i**2)
        cos_t = np.sqrt(np.maximum(k, 0.0))
        bent = normalized(eta[:, None] * u + (eta * cos_i - cos_t)[:, None] * n)
        straight = thin | (eta_i == eta_t)
        transmitted = np.where(straight[:, None], u, bent)
        total = (k < 0) & ~thin & (of["kt"][shape] > 0)
        parallel = (eta_t * cos_i - eta_i * cos_t) / (eta_t * cos_i + eta_i * cos_t)
        across = (eta_i * cos_i - eta_t * cos_t) / (eta_i * cos_i + eta_t * cos_t)
        fresnel = np.where(k < 0, 1.0, np.where(eta_i == eta_t, 0.0, (parallel**2 + across**2) / 2))
        fresnel = np.where(thin, 2 * fresnel / (1 + fresnel), fresnel)[:, None]
        metal = of["conductor"][shape, None]
        fresnel = np.where(metal, conductor(of["n"][shape], of["k"][shape], eta_i, -dot(spot.ns, u)), fresnel)
        by_fresnel, lost = of["fresnel"][shape, None] | metal, total[:, None]
        reflects = np.where(by_fresnel, kr * fresnel, kr + np.where(lost, kt, 0.0))
        transmits = np.where(lost, 0.0, np.where(by_fresnel, kt * (1 - fresnel), kt))
        return Optics(reflected, transmitted, reflects, transmits, total)

    def _rough(self, found: Optics, rays: Rays, spot: Spot) -> Optics:
        """The same with one ray for each rough mirror: about the shading normal, else about the true one."""
        rows = np.flatnonzero(self.of["alpha"][spot.shape] > 0)
        if not rows.size:
            return found
        part, u = spot.take(rows), rays.direction[rows]
        draws = pair(combine(rays.base[rows], np.uint32(0x80000001)), rays.sample[rows])
        back, share = self.gloss(u, part, part.ns, draws)
        below = np.flatnonzero((share.max(axis=1) > 0) & (dot(back, part.n) <= 0))
        if below.size:
            again = part.take(below)
            draws = draws[0][below], draws[1][below]
            back[below], share[below] = self.gloss(u[below], again, again.n, draws)
        found.reflected[rows], found.reflects[rows] = back, share
        return found

    def gloss(self, u: Array, spot: Spot, n: Array, draws: tuple[Array, Array]) -> tuple[Array, Array]:
        """Reflected directions (m, 3) about normals n, and their shares (m, 3)."""
        of, shape = self.of, spot.shape
        alpha, frame = of["alpha"][shape], np.stack([*basis(n), n], 1)
        v = -np.einsum("nij,nj->ni", frame, u)
        half = facet(v, alpha, *on_disk(*draws))
        cosine = dot(v, half)
        back = 2 * cosine[:, None] * half - v
        shadowed = smith(back, alpha)[:, None] * of["kr"][shape, None]
        return np.einsum("nij,ni->nj", frame, back), shadowed * self.on_facet(cosine, spot)

    def on_facet(self, cosine: Array, spot: Spot) -> Array:
        """Fresnel's share and the tint (m, 3) of a mirror met at angles of these cosines."""
        of, shape = self.of, spot.shape
        tint = self._faded(spot.M, shape, cosine)
        eta_i, eta_t = spot.eta_i, spot.eta_t
        cos_t = np.sqrt(np.maximum(1 - (eta_i / eta_t) ** 2 * (1 - cosine**2), 0.0))
        along = (eta_t * cosine - eta_i * cos_t) / (eta_t * cosine + eta_i * cos_t)
        across = (eta_i * cosine - eta_t * cos_t) / (eta_i * cosine + eta_t * cos_t)
        share = np.where(cos_t == 0, 1.0, np.where(eta_i == eta_t, 0.0, (along**2 + across**2) / 2))
        share = np.where(of["thin"][shape], 2 * share / (1 + share), share)[:, None]
        share = np.where(of["fresnel"][shape, None], share, 1.0)
        metal = conductor(of["n"][shape], of["k"][shape], eta_i, cosine)
        return np.asarray(tint * np.where(of["conductor"][shape, None], metal, share))

    def _gatherers(self, rays: Rays, spot: Spot, share: Array, rows: Array) -> Rays:
        """The ambient rays of hits `rows` (m,): cosine-distributed about the shading normal."""
        samples = self.settings["ambient_samples"]
        h = child_path(rays.path[rows], 3, masked=False)
        flags = rays.path[rows] & np.uint32(15) | GATHERED
        n, ns = spot.n[rows], spot.ns[rows]
        queues = []
        for i in range(samples):
            direction = cosine_direction(h, i, ns)
            below = dot(direction, n) <= 0
            direction[below] = cosine_direction(h[below], i, n[below])
            weight = rays.weight[rows] * share[rows] / samples
            origin, form = spot.start_before[rows], spot.form[rows]
            path = combine(h, np.uint32(i)) & ~np.uint32(15) | flags
            own = rays.pixel[rows], path, form, spot.media[rows], h, h, spot.cone[rows]
            child = Rays(origin, direction, weight, *own)
            queues.append(drawing(child))
        return Rays.joined(queues)
