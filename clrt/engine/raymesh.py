"""Ray queries on a trimesh mesh, with trimesh's own interface.

    mesh.ray = RayMeshIntersector(mesh)

and everything in trimesh that asks `mesh.ray` (`mesh.contains`, `trimesh.proximity` ...) is answered by clrt.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from clrt.base import arguments
from clrt.base.arguments import public
from clrt.base.errors import ClrtError, show
from clrt.device.settings import Settings
from clrt.engine.tracer import Tracer
from clrt.formats import load_dict

# Hits of a ray closer together than this share of the mesh's size are in one place: the device's vertices are
# rounded to float32, and so is the decision which side of an edge a ray passes.
_SAME_PLACE: Final = 1e-6
_STEEP: Final = 1e-3  # |cosine| from which on a face's plane gives a better distance than float32 does
_STEP: Final = 1 << 17  # rays at a time: what is made for them stays in the caches
# along which inside is told from outside: a line both ways, and one more where a surface is not closed
_WAYS: Final = ((0.4395064455, 0.617598629942, 0.652231566745), (-0.2182178902, 0.8728715609, -0.4364357805))


class RayMeshIntersector:
    """Answers for one mesh; made ready at the first question, and again when the mesh has changed.

    geometry: a `trimesh.Trimesh`. device, settings: as for `clrt.Tracer`. Rays are (n, 3) origins and
    directions of any length; directions that are zero or not finite miss. ClrtError for arrays of another
    shape or of anything but real numbers, and for a geometry that is no mesh.
    """

    def __init__(
        self, geometry: Any, device: int | str | None = None, settings: Settings | None = None
    ) -> None:
        if not {"vertices", "faces", "bounds", "triangles"} <= {*dir(geometry)}:
            raise ClrtError(f"geometry: {show(geometry)} is not allowed; it must be a trimesh.Trimesh")
        self.mesh = geometry
        self._device = arguments.device("device", device)
        self._settings = arguments.optional_instance("settings", settings, Settings)
        self._state: _Faces | None = None

    @public
    def intersects_first(self, ray_origins: Any, ray_directions: Any) -> np.ndarray:
        """(n,) int64: the number of the first face that each ray hits, -1 for none."""
        return self._faces.first(*_rays(ray_origins, ray_directions))

    @public
    def intersects_any(self, ray_origins: Any, ray_directions: Any) -> np.ndarray:
        """(n,) bool: whether each ray hits anything."""
        return self._faces.any(*_rays(ray_origins, ray_directions))

    @public
    def intersects_id(
        self,
        ray_origins: Any,
        ray_directions: Any,
        multiple_hits: bool = True,
        max_hits: int | None = None,
        return_locations: bool = False,
    ) -> tuple[np.ndarray, ...]:
        """Faces and rays of all hits, (m,) int64 each, ray by ray and along each ray.

        multiple_hits = False: each ray's first only; max_hits: at most so many of a ray (0: none). A ray
        through a common edge or corner hits as many of its faces as keep inside and outside apart: one, or
        none or two where it only touches the mesh. return_locations: also the points, (m, 3) float64; faces
        that a ray meets in one place then count as one, of the sense that prevails, inwards or outwards, or
        as one of each where it only touches: on a closed mesh a ray's hits alternate.
        """
        origins, directions = _rays(ray_origins, ray_directions)
        most = arguments.optional("max_hits", max_hits)
        if not arguments.flag("multiple_hits", multiple_hits):
            most = 1 if most is None else min(most, 1)
        arguments.flag("return_locations", return_locations)
        rays, faces, t = self._faces.every(origins, directions, most)
        if not return_locations:
            return faces, rays
        normals, corners = self.mesh.face_normals[faces], self.mesh.triangles[faces, 0]
        cosine = np.einsum("ij,ij->i", normals, directions[rays])
        above = np.einsum("ij,ij->i", normals, corners - origins[rays])
        t = np.where(np.abs(cosine) > _STEEP, above / np.where(cosine == 0, 1, cosine), t)
        kept = _places(rays, t, cosine < 0, _SAME_PLACE * float(self.mesh.scale))
        locations = origins[rays[kept]] + directions[rays[kept]] * t[kept, None]
        return faces[kept], rays[kept], locations

    @public
    def intersects_location(
        self, ray_origins: Any, ray_directions: Any, multiple_hits: bool = True, max_hits: int | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Points (m, 3) float64 of the hits, their rays and their faces (m,) int64: see `intersects_id`."""
        faces, rays, locations = self.intersects_id(
            ray_origins, ray_directions, multiple_hits, max_hits, return_locations=True
        )
        return locations, rays, faces

    @public
    def contains_points(self, points: Any) -> np.ndarray:
        """(n,) bool: which points are inside a closed mesh; those on its surface may be either.

        By the parity of what a ray crosses, which is right for every ray. Where a mesh has holes, and so a
        ray each way says another thing, a third decides.
        """
        given = arguments.vectors("points", points, np.float64)
        low, high = self._faces.bounds
        found = ((given >= low) & (given <= high)).all(axis=1)
        (left,) = np.nonzero(found)
        odd = [self._faces.odd(given[left], way) for way in (np.array(_WAYS[0]), -np.array(_WAYS[0]))]
        found[left] = odd[0]
        doubtful = left[odd[0] != odd[1]]
        found[doubtful] = self._faces.odd(given[doubtful], np.array(_WAYS[1]))
        return found

    @property
    def _faces(self) -> _Faces:
        version = hash(self.mesh)
        if self._state is None or self._state.version != version:
            self._state = _Faces(self.mesh, version, self._device, self._settings)
        return self._state

    def __getstate__(self) -> dict[str, Any]:
        """Copies and pickles make the device's side anew."""
        return {**self.__dict__, "_state": None}


class _Faces:
    """One version of a mesh on the device, moved to the origin of coordinates, where float32 is finest."""

    def __init__(self, mesh: Any, version: int, device: int | str | None, settings: Settings) -> None:
        self.version = version
        vertices, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces)
        there = len(faces) and 0 <= faces.min() <= faces.max() < len(vertices)  # if not, `load_dict` says so
        self.bounds = np.asarray(mesh.bounds if there else np.full((2, 3), np.nan), np.float64)
        low, high = self.bounds if there else np.zeros((2, 3))
        self.center = (low + high) / 2
        self.radius = float(np.linalg.norm(high - low)) / 2
        shapes = [{"type": "mesh", "vertices": vertices - self.center, "faces": faces}] if len(faces) else []
        self.tracer = Tracer(load_dict({"shapes": shapes}, limits=settings.limits), device, settings)

    def first(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        out = np.full(len(origins), -1, np.int64)
        for part, rays, _ in self._moved(origins, directions):
            out[part] = self.tracer.intersect(*rays, fields=["primitive"]).primitive
        return out

    def any(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        out = np.zeros(len(origins), bool)
        for part, rays, _ in self._moved(origins, directions):
            out[part] = self.tracer.occluded(*rays)
        return out

    def odd(self, points: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """(n,) bool: whether the mesh is crossed an odd number of times on the way from each point."""
        out = np.zeros(len(points), bool)
        for part, rays, _ in self._moved(points, np.broadcast_to(direction, points.shape)):
            out[part] = self.tracer.count_hits(*rays) % 2 == 1
        return out

    def every(
        self, origins: np.ndarray, directions: np.ndarray, most: int | None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rays, faces (m,) int64 and distances (m,) float64 of all hits, or the first `most` of each ray."""
        found = [(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0))]
        for part, rays, ahead in self._moved(origins, directions):
            if most == 1:  # as `first`
                nearest = self.tracer.intersect(*rays, fields=["t", "primitive"])
                (ray,) = np.nonzero(nearest.primitive >= 0)
                face, t = nearest.primitive[ray], nearest.t[ray]
            else:
                hits = self.tracer.all_hits(*rays, fields=["t", "primitive"])
                ray, face, t = hits.rays, hits.primitive, hits.t
                if most is not None:
                    kept = np.arange(len(hits)) - hits.splits[ray] < most
                    ray, face, t = ray[kept], face[kept], t[kept]
            found.append((ray + part.start, face.astype(np.int64), t + ahead[ray]))
        rays_hit, faces, distances = (np.concatenate(arrays) for arrays in zip(*found, strict=True))
        return rays_hit, faces, distances

    def _moved(
        self, origins: np.ndarray, directions: np.ndarray
    ) -> Iterator[tuple[slice, tuple[np.ndarray, np.ndarray], np.ndarray]]:
        """The rays piece by piece: which, as float32, and how far each was moved on to the mesh (float64)."""
        for start in range(0, len(origins), _STEP):
            part = slice(start, min(start + _STEP, len(origins)))
            local, d = origins[part] - self.center, directions[part]
            # rounding a far origin to float32 would bend the ray's way through the mesh
            ahead = -np.einsum("ij,ij->i", local, d) - 1.01 * self.radius
            ahead = np.where((ahead > 0) & (ahead < np.inf), ahead, 0.0)
            with np.errstate(over="ignore", invalid="ignore"):  # what is not finite misses
                near = (local + d * ahead[:, None]).astype(np.float32)
            yield part, (near, d.astype(np.float32)), ahead


def _rays(origins: Any, directions: Any) -> tuple[np.ndarray, np.ndarray]:
    """Origins and unit directions, (n, 3) float64; a zero direction stays 0."""
    o, d = arguments.rays(origins, directions, np.float64, prefix="ray_")
    with np.errstate(over="ignore", invalid="ignore"):
        largest = np.abs(d).max(axis=1, keepdims=True, initial=0.0)
        d = d / np.where(largest > 0, largest, 1.0)  # or the squares would leave the range of numbers
        length = np.linalg.norm(d, axis=1, keepdims=True)
        return o, d / np.where(length > 0, length, 1.0)


def _places(rays: np.ndarray, t: np.ndarray, inwards: np.ndarray, tolerance: float) -> np.ndarray:
    """Which hits to keep, in order: of those of a ray that lie in one place, one of the sense that prevails.

    Where none does, the surface is touched: one of each, in the order that fits the crossings beside it.
    """
    if not len(rays):
        return np.zeros(0, np.int64)
    apart = (np.diff(rays) != 0) | (np.abs(np.diff(t)) > tolerance)
    place = np.concatenate([[0], np.cumsum(apart)])
    ray = rays[np.flatnonzero(np.diff(place, prepend=-1))]
    net = np.sign(np.bincount(place, 2.0 * inwards - 1))
    # whether a ray is inside before each place: its last crossing says so, or else the next one
    last, after = _nearest(ray, net), -_nearest(ray[::-1], net[::-1])[::-1]
    inside = np.where(last != 0, last, after) > 0
    sense, at = np.unique(2 * place + inwards, return_index=True)
    kept = (net[sense // 2] == 0) | ((net[sense // 2] > 0) == (sense % 2 == 1))
    sense, at = sense[kept], at[kept]
    second = np.where(net[sense // 2] == 0, (sense % 2 == 1) == inside[sense // 2], False)
    return at[np.lexsort((second, sense // 2))]


def _nearest(ray: np.ndarray, net: np.ndarray) -> np.ndarray:
    """Of the same ray's places before each, the last `net` that is not 0; 0 where there is none."""
    at = np.maximum.accumulate(np.where(net != 0, np.arange(len(net)), -1))
    before = np.concatenate([[-1], at[:-1]])
    return np.where((before >= 0) & (ray[before] == ray), net[before], 0.0)
