"""What rays meet: Mitsuba finds the hits; here they get the scene's numbers, and approximations their
surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import engine
from .engine import dr, mi
from .plugins import FLAT, SMOOTH

Array = np.ndarray
OFFSET = 1e-6  # of the coordinates: how far off a surface rays start; 16 units in the last place of a float32
FLATTEST = 0.02  # cosine; a ray that is flatter crosses so little that steps would pass the other side
PASSES = 200  # surfaces that a ray may pass before something must be wrong
SHORT = 0.05  # of the scene's size: chords of a form that its mesh may not have


@dataclass(frozen=True, eq=False)
class Hits:
    """Nearest hits of n rays; a miss has t = inf and shape = -1."""

    t: Array  # (n,) float64
    shape: Array  # (n,) int: the scene's
    point: Array  # (n, 3)
    outward: Array  # (n, 3): geometric unit normal
    shading: Array  # (n, 3): shading unit normal, on either side
    form: Array  # (n,) int: row of World.forms, -1 where Mitsuba's shape is the surface itself
    face: Array  # (n,) int: row of World.corners
    chart: Array  # (n, 8): of meshes u, v, dp/du, dp/dv; (n, 11): and colours; (n, 0): no mesh has any

    def take(self, rows: Array) -> Hits:
        return Hits(*(getattr(self, name)[rows] for name in FIELDS))

    def put(self, rows: Array, hits: Hits) -> None:
        """Overwrite rows."""
        for name in FIELDS:
            getattr(self, name)[rows] = getattr(hits, name)


FIELDS = tuple(Hits.__dataclass_fields__)


class World:
    """A scene's geometry in Mitsuba.

    geometry: from plugins.packed. opaque (shapes + 1,): which of the scene's shapes let no light through.
    hides_backs: whether those are invisible from behind. more: further plugins of the scene, such as
    emitters.
    """

    def __init__(
        self, geometry: dict[str, Any], opaque: Array, hides_backs: bool, more: dict[str, Any]
    ) -> None:
        self.center = geometry["center"]
        self.short = SHORT * float(geometry["size"])
        self.least_step = OFFSET * 0.05 * float(geometry["fine"])
        plugins = {f"shape_{i:06d}": shape for i, shape in enumerate(geometry["shapes"])}
        self.scene = engine.load({"type": "scene", **plugins, **more})
        self.owner, self.kind, self.form = geometry["owner"], geometry["kind"], geometry["form"]
        self.forms = geometry["forms"]
        self.owner_of_form = np.zeros(len(self.forms), int)
        self.owner_of_form[self.form[self.form >= 0]] = self.owner[self.form >= 0]
        self.opaque, self.hides_backs = opaque, hides_backs
        self.simple = not len(self.forms) and not hides_backs
        shapes = {shape.id(): engine.number(shape) for shape in self.scene.shapes()}
        places = np.array([shapes[name] for name in plugins], int)
        self.first = np.zeros(places.max(initial=0) + 1, int)
        self.first[places] = geometry["first"]
        self.colored = [mi.ShapePtr(shape) for shape in self.scene.shapes()
                        if shape.is_mesh() and shape.has_attribute("vertex_color")]  # fmt: skip
        pictured = any("texcoords" in shape for shape in geometry["shapes"])
        self.chart = 11 if self.colored else 8 * pictured
        self.many = np.zeros(places.max(initial=0) + 1, bool)  # a rectangle's two triangles are one primitive
        self.many[places] = [shape["type"] == "mesh" for shape in geometry["shapes"]]
        # of faces, on which a hit may be at an edge; the last row is of what has none
        self.corners = np.concatenate([*map(corners_of, geometry["shapes"]), np.full((1, 4, 3), np.inf)])

    def nearest(self, origin: Array, direction: Array, form: Array, start: Array | None = None) -> Hits:
        """Nearest hits of rays (n, 3), unit directions, at distances above `start` (n,; 0).

        form: on which form rays start (n,), or -1.
        """
        found = self._beyond(origin, direction, start)
        self._add_chords(found, origin, direction, form, start)
        return found

    def _beyond(self, origin: Array, direction: Array, start: Array | None) -> Hits:
        n = len(origin)
        after = np.zeros(n) if start is None else start
        begin = after.copy()
        point, outward, shading = np.zeros((3, n, 3))
        nothing = np.full(n, -1)
        found = Hits(np.full(n, np.inf), nothing, point, outward, shading, nothing.copy(), nothing.copy(),
                     np.zeros((n, self.chart)))  # fmt: skip
        todo = np.arange(n)
        for count in range(PASSES):
            if not todo.size:
                return found
            hits, exists, met = self._traced(origin[todo], direction[todo], begin[todo], after[todo])
            good = (
                exists
                & (hits.t > after[todo])
                & (hits.t < found.t[todo])
                & self._shows(hits, direction[todo])
            )
            found.put(todo[good], hits.take(good))
            step = self.step(origin[todo] + met[:, None] * direction[todo])
            # something else may lie between a facet and the surface far behind it
            passed = exists & (met + np.where(good, 20.0, 0.0) * step < found.t[todo])
            # further each time: a ray along a facet meets it again and again
            todo, ahead = todo[passed], (met + (1 + count) ** 2 * step)[passed]
            begin[todo] = ahead
        if len(todo) > max(10, n // 1000):
            raise RuntimeError(
                f"{len(todo)} of {n} rays meet more than {PASSES} surfaces that they should pass"
            )
        return found  # a few lie in a surface: misses, which a comparison shows

    def _traced(
        self, origin: Array, direction: Array, begin: Array, after: Array
    ) -> tuple[Hits, Array, Array]:
        """What Mitsuba finds beyond `begin` (n,), moved onto forms, where it counts beyond `after` (n,);
        whether it found anything; and where on the ray it did."""
        n = len(origin)
        moved = origin + begin[:, None] * direction
        si = self.scene.ray_intersect(engine.rays(moved - self.center, direction))
        prim = si.prim_index
        dr.eval(si.t, si.p, si.n, si.sh_frame.n, si.shape, prim)
        t = engine.column(si.t, n)
        exists = np.isfinite(t)
        number = np.where(exists, engine.words(si.shape, n), 0)
        row = np.where(exists, self.first[number] + np.where(self.many[number], engine.words(prim, n), 0), 0)
        normal, shading = engine.rows(si.n, n), engine.rows(si.sh_frame.n, n)
        chart = np.zeros((n, self.chart))
        if self.chart:
            chart[:, :8] = np.hstack([engine.rows(each, n) for each in (si.uv, si.dp_du, si.dp_dv)])
        for mesh in self.colored:
            for name in ("vertex_color", "face_color"):
                chart[:, 8:] += engine.rows(mesh.eval_attribute_3(name, si, si.shape == mesh), n)
        if not len(self.owner):
            nowhere = np.full(n, np.inf)
            none = np.full(n, -1)
            return Hits(nowhere, none, moved, normal, shading, none, none, chart), exists, nowhere
        kind = self.kind[row]
        outward = np.where((kind == FLAT)[:, None], shading, normal)
        shading = np.where((kind == SMOOTH)[:, None], shading, outward)
        t = begin + t
        point = engine.rows(si.p, n) + self.center
        owner, form = (np.where(exists, table[row], -1) for table in (self.owner, self.form))
        hits = Hits(t.copy(), owner, point, outward, shading, form, row, chart)
        on_form = np.flatnonzero(form >= 0)
        if on_form.size:
            rays = origin[on_form], direction[on_form], after[on_form]
            hits.put(on_form, self._polished(hits.take(on_form), *rays))
        return hits, exists, t

    def _polished(self, hits: Hits, origin: Array, direction: Array, after: Array) -> Hits:
        """Hits moved along their rays onto the forms that Mitsuba's shapes approximate.

        A hit whose form the ray does not meet, or meets outside the shape's ends, gets t = -1: it does not
        count. A ray that leaves a form beyond `after` (n,) where it did not enter slipped between two
        triangles, as one in some million does in Mitsuba, or was just then on its way past something else:
        it gets the hit that it lacks.
        """
        roots = self._roots(hits.form, origin, direction)
        best, rows = np.argmin(np.abs(roots - hits.t[:, None]), axis=1), np.arange(len(after))
        found = self._at(roots[rows, best], hits.shape, hits.form, origin, direction)
        before = roots[rows, 1 - best]
        lost = np.flatnonzero((before > after) & (before < found.t))
        if lost.size:
            entered = self._at(before[lost], hits.shape[lost], hits.form[lost], origin[lost], direction[lost])
            real = (entered.t > 0) & self._shows(entered, direction[lost])
            found.put(lost[real], entered.take(real))
        return found

    def _roots(self, form: Array, origin: Array, direction: Array) -> Array:
        """Distances (n, 2) at which rays meet forms; inf where they do not."""
        q = self.forms[form, :16].reshape(-1, 4, 4)
        o, d = np.c_[origin, np.ones(len(origin))], np.c_[direction, np.zeros(len(origin))]
        a, b, c = (np.einsum("ni,nij,nj->n", u, q, v) for u, v in ((d, d), (o, d), (o, o)))
        with np.errstate(all="ignore"):
            stable = -(b + np.where(b < 0, -1.0, 1.0) * np.sqrt(b * b - a * c))
            roots = np.stack([stable / a, c / stable], -1)
        return np.where(np.isfinite(roots), roots, np.inf)

    def _at(self, t: Array, shape: Array, form: Array, origin: Array, direction: Array) -> Hits:
        """Hits of forms at distances t (n,); t = -1 where that is no point of the shape."""
        exists = np.isfinite(t)
        point = origin + np.where(exists, t, 0.0)[:, None] * direction
        q, to_object = self.forms[form, :16].reshape(-1, 4, 4), self.forms[form, 16:32].reshape(-1, 4, 4)
        homogeneous = np.c_[point, np.ones(len(point))]
        placed = np.einsum("nij,nj->ni", to_object, homogeneous)[:, :3]
        inside = np.all((placed >= self.forms[form, 32:35]) & (placed <= self.forms[form, 35:38]), axis=1)
        gradient = np.einsum("nij,nj->ni", q, homogeneous)[:, :3]
        length = np.linalg.norm(gradient, axis=1, keepdims=True)
        normal = np.where(length > 0, gradient / np.where(length > 0, length, 1.0), -direction)
        return Hits(np.where(exists & inside, t, -1.0), shape, point, normal, normal.copy(), form,
                    np.full(len(point), -1), np.zeros((len(point), self.chart)))

    def _add_chords(
        self, found: Hits, origin: Array, direction: Array, form: Array, start: Array | None
    ) -> None:
        """Hits of the forms that rays start on, too near for a mesh: between the corners of its own
        facets."""
        rows = np.flatnonzero(form >= 0)
        if not rows.size:
            return
        o, u, form = origin[rows], direction[rows], form[rows]
        after = np.zeros(len(rows)) if start is None else start[rows]
        for t in self._roots(form, o, u).T:
            near = np.where((t > after) & (t < self.short), t, np.inf)
            hits = self._at(near, self.owner_of_form[form], form, o, u)
            good = (hits.t > 0) & (hits.t < found.t[rows]) & self._shows(hits, u)
            found.put(rows[good], hits.take(good))

    def _shows(self, hits: Hits, direction: Array) -> Array:
        """Which hits are visible from the ray's side."""
        if not self.hides_backs:
            return np.ones(len(hits.t), bool)
        behind = np.einsum("ni,ni->n", hits.outward, direction) > 0
        return np.asarray(~(behind & self.opaque[hits.shape]))

    def visible(
        self, origin: Array, direction: Array, form: Array, length: Array, clear: Array | None
    ) -> Array:
        """What of a light at distance `length` (n,) arrives, (n, 3): 0 behind a blocker, else 1; form as for
        nearest.

        With `clear` (shapes + 1, 3), the transparency of the scene's shapes, every surface crossed multiplies
        it.
        """
        n = len(origin)
        seen = np.ones((n, 3))
        if self.simple and clear is None:
            ray = engine.rays(origin - self.center, direction)
            ray.maxt = mi.Float(np.minimum(length, 1e30).astype(np.float32))
            seen[np.broadcast_to(np.array(self.scene.ray_test(ray)), (n,))] = 0.0
            return seen
        todo, start = np.arange(n), np.zeros(n)
        for _ in range(PASSES):
            hits = self.nearest(origin[todo], direction[todo], form[todo], start[todo])
            blocked = hits.t < length[todo]
            todo, t, shape = todo[blocked], hits.t[blocked], hits.shape[blocked]
            seen[todo] *= 0.0 if clear is None else clear[shape]
            lit = seen[todo].any(axis=1)
            todo, t = todo[lit], t[lit]
            if not todo.size:
                return seen
            # no surface may be crossed twice: Mitsuba rounds its distance to a share of it
            away = self.step(origin[todo] + t[:, None] * direction[todo])
            slope = np.abs(np.einsum("ni,ni->n", hits.outward[blocked][lit], direction[todo]))
            start[todo] = t + np.maximum(OFFSET * (t - start[todo]), away) / np.maximum(slope, FLATTEST)
        raise RuntimeError(f"{len(todo)} shadow rays cross more than {PASSES} surfaces")

    def at_edge(self, hits: Hits) -> Array:
        """Which hits (n,) are nearer to an edge of a face than rays start off it."""
        corners = self.corners[hits.face]
        way, along = hits.point[:, None] - self.center - corners, np.roll(corners, -1, axis=1) - corners
        with np.errstate(invalid="ignore"):
            beside = np.sum(np.cross(way, along) ** 2, axis=-1) - (
                self.step(hits.point)[:, None] ** 2 * np.sum(along**2, axis=-1)
            )
        return np.asarray(((beside <= 0) & along.any(axis=-1) & (hits.form < 0)[:, None]).any(axis=1))

    def middle(self, hits: Hits) -> Array:
        """Directions (n, 3) from hits of faces towards the middles of these."""
        way = self.corners[hits.face].mean(axis=1) + self.center - hits.point
        return np.asarray(way / np.linalg.norm(way, axis=-1, keepdims=True))

    def step(self, point: Array) -> Array:
        """How far (n,) rays that start at points (n, 3) on a surface are moved off it."""
        return np.maximum(OFFSET * np.abs(point - self.center).max(axis=-1, initial=0.0), self.least_step)


def corners_of(shape: dict[str, Any]) -> Array:
    """The corners (primitives, 4, 3) of a plugin's faces, of triangles the last one twice; else infinite."""
    if shape["type"] == "mesh":
        corners = np.asarray(shape["vertices"], float)[shape["faces"]]
        return np.concatenate([corners, corners[:, 2:]], axis=1)
    if shape["type"] != "rectangle":
        return np.full((1, 4, 3), np.inf)
    square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    to_world = np.asarray(shape["to_world"])
    return np.asarray(square @ to_world[:3, :3].T + to_world[:3, 3])[None]
