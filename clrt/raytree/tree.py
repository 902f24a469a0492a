"""A pixel's rays as a tree, with what each brings, where that comes from, and what became of it."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from clrt.base import arguments
from clrt.base.arguments import public
from clrt.base.errors import ClrtError, legible
from clrt.raytree.sums import cancel, luminance_of, pixel_of
from clrt.scene.scene import Scene

if TYPE_CHECKING:
    from clrt.raytree.names import Names

Numbers = tuple[float, ...]

KINDS: Final = ("camera", "reflection", "transmission", "ambient")


@dataclass(frozen=True)
class Crossing:
    """A surface on the way of a shadow feeler. t: distance from its start. blocks: nothing comes through."""

    shape: int
    t: float
    blocks: bool


@dataclass(frozen=True)
class Feeler:
    """A shadow feeler: from a hit to a light.

    origin, direction (3 numbers, unit), distance (infinite to a directional light): the way. seen: does
    light arrive. met: the surfaces on the way, nearest first, up to the one that blocks it (one that does
    where shadows are opaque). filter: what comes through of each band the ray carries, 1 where all does.
    """

    origin: Numbers
    direction: Numbers
    distance: float
    seen: bool
    met: tuple[Crossing, ...]
    filter: Numbers


@dataclass(frozen=True)
class LightShare:
    """What one light brings to the pixel at a hit, weighted: by band, as all below.

    light: its number in the scene. feelers: one to each of its points that stands above the surface; none
    where the material reflects nothing directly. diffuse, highlight: the terms, each rounded by itself;
    brings: both together, as the kernels add it.
    """

    light: int
    feelers: tuple[Feeler, ...]
    diffuse: Numbers
    highlight: Numbers
    brings: Numbers


@dataclass(frozen=True)
class Hit:
    """Where a ray ends. t: distance. point (on the surface), normal (geometric), shading (normal): 3 numbers,
    both normals on the ray's side. inside: does the ray come from the inside. material: its number."""

    t: float
    shape: int
    primitive: int
    point: Numbers
    normal: Numbers
    shading: Numbers
    inside: bool
    material: int


@dataclass(frozen=True, eq=False)
class Ray:
    """One ray, and its children. Colours are by band, as the ray carries them: `first_band` and on.

    number: in the order in which the film adds them. queue: its queue's number in the generation. kind: of
    KINDS. sample: of the pixel. origin, direction: 3 numbers, unit. weight: what its light counts for in
    the pixel where it starts; arriving: after what the media have absorbed on its way. media: numbers of
    the materials that it starts in, oldest first; medium: the one it goes through to its hit, -1 for none.
    hit: None where it meets nothing. emission, ambient: terms of the model; background: what is seen where
    nothing is met; beyond: what stands for the generations after the last. lights: one for each of the
    scene's. brings: the sum, as the film adds it; None where it brings nothing. total_internal: a
    transmission was asked for and could not leave.
    """

    number: int
    generation: int
    queue: int
    kind: str
    sample: int
    first_band: int
    narrow: bool
    origin: Numbers
    direction: Numbers
    weight: Numbers
    arriving: Numbers
    media: tuple[int, ...]
    medium: int
    hit: Hit | None
    emission: Numbers
    ambient: Numbers
    background: Numbers
    beyond: Numbers
    lights: tuple[LightShare, ...]
    brings: Numbers | None
    total_internal: bool
    path: int
    parent: int | None
    children: tuple[Ray, ...] = field(default=(), repr=False)

    def __reduce__(self) -> tuple[Any, ...]:
        """Copied and sent as one of its sample's, which stand side by side: Python cannot go as deep as they
        may be, and what is sent of many of them is sent once."""
        return _member, self.__dict__.get(_KIN) or (_Kin([self]), 0)


@dataclass(frozen=True, eq=False)
class RayTree:
    """All rays of a pixel: `tracer.explain(x, y)`.

    x, y: the pixel, from the top left; width, height: the picture's size. samples: rays of generation 0.
    value: the pixel, 3 float32 linear, as `render` gives it. rays: all of them, in the order in which the
    film adds up what they bring. bands: how many a ray of generation 0 carries; response (rows, bands):
    turns their means into `value`, None where they are red, green and blue. scene: what they went through.
    weights: what each sample counts for, by the camera's filter; none without one, where all count alike.
    """

    scene: Scene = field(repr=False)
    x: int
    y: int
    width: int
    height: int
    samples: int
    max_depth: int
    bands: int
    response: np.ndarray | None = field(repr=False)
    value: np.ndarray
    rays: tuple[Ray, ...] = field(repr=False)
    weights: Numbers = field(default=(), repr=False)

    def __post_init__(self) -> None:
        kin: dict[int, _Kin] = {}
        for ray in self.rays:
            if _KIN not in ray.__dict__:
                kin.setdefault(ray.sample, _Kin([])).take(ray)

    @property
    def roots(self) -> tuple[Ray, ...]:
        """The rays of generation 0, one a sample."""
        return self.rays[: self.samples]

    @property
    def total(self) -> np.ndarray:
        """What the rays bring, added up in the film's order: (3,) float32, equal to `value` bit for bit."""
        return pixel_of(self.rays, self.samples, self.bands, self.response, self.weights)

    @cached_property
    def luminance(self) -> float:
        """Of all that the rays bring, weighed, before it is divided by the samples or their weights."""
        return sum(self._bright(ray) for ray in self.rays)

    @cached_property
    def shares(self) -> tuple[float, ...]:
        """Of each ray, by its number, the part of the pixel's luminance that it brings; 0 of a black one."""
        total = self.luminance
        return tuple(self._bright(ray) / total if total else 0.0 for ray in self.rays)

    def _bright(self, ray: Ray) -> float:
        weight = self.weights[ray.sample] if self.weights and not cancel(self.weights) else 1.0
        return weight * luminance_of(ray.brings or (), ray.first_band, self.bands, self.response)

    @cached_property
    def branch_shares(self) -> tuple[float, ...]:
        """Of each ray, by its number, the part that it brings with all its descendants."""
        found = list(self.shares)
        for ray in reversed(self.rays):  # children stand behind their parents
            if ray.parent is not None:
                found[ray.parent] += found[ray.number]
        return tuple(found)

    def stats(self) -> dict[str, Any]:
        """Counts of the rays by kind and generation, as `Image.stats` has them: "rays" and "generations"."""
        rows: list[Counter[str]] = []
        for ray in self.rays:
            while len(rows) <= ray.generation:
                rows.append(Counter())
            row = rows[ray.generation]
            row[ray.kind] += 1
            row["hits"] += ray.hit is not None
            row["camera_hits"] += ray.kind == "camera" and ray.hit is not None
            row["total_internal_reflection"] += ray.total_internal
            row["feelers"] += sum(len(light.feelers) for light in ray.lights)
        names = ("camera", "camera_hits", "reflection", "transmission", "ambient",
                 "total_internal_reflection", "feelers", "hits")  # fmt: skip
        table = [{name: row[name] for name in names} for row in rows]
        return {"rays": {name: sum(row[name] for row in table) for name in names}, "generations": table}

    @cached_property
    def names(self) -> Names:
        """What shapes, materials and lights are called."""
        from clrt.raytree.names import Names

        return Names(self.scene, {ray.hit.material: ray.hit.shape for ray in self.rays if ray.hit})

    def walk(self) -> Iterator[Ray]:
        """The rays as the tree is read: each before its children."""
        todo = list(reversed(self.roots))
        while todo:
            ray = todo.pop()
            yield ray
            todo += reversed(ray.children)

    def as_dict(self) -> dict[str, Any]:
        """The tree as tables, lists, texts and numbers: what `save` writes as JSON (docs/explain.md)."""
        from clrt.raytree.document import document

        return document(self)

    def to_json(self) -> str:
        """`as_dict` as a text of JSON."""
        return json.dumps(legible(self.as_dict()), allow_nan=False)

    @public
    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write it: .json; .html, a page for any browser; .glb, the rays as coloured tubes in the scene.

        Raises ClrtError for another ending, where the file cannot be written, and for .glb without trimesh.
        """
        from clrt.raytree.files import write

        arguments.path("path", path)
        return write(self, path)

    def to_glb(self, path: str | os.PathLike[str]) -> Path:
        """`save`, for a path that ends in .glb, or ClrtError."""
        if arguments.path("path", path).suffix.lower() != ".glb":
            raise ClrtError(f"{os.fspath(path)}: the name must end in .glb; save writes .json and .html, too")
        return self.save(path)

    def _repr_html_(self) -> str:
        """What notebooks show."""
        from clrt.raytree.page import fragment

        return fragment(self)


def _values(record: Ray | RayTree) -> dict[str, Any]:
    return {part.name: getattr(record, part.name) for part in fields(record)}


def _rows(rays: Sequence[Ray]) -> list[dict[str, Any]]:
    """The fields of rays, then of all below them; for children their places among these rows."""
    found = list(rays)
    places = {id(ray): place for place, ray in enumerate(found)}
    for ray in found:
        for child in ray.children:
            if places.setdefault(id(child), len(found)) == len(found):
                found.append(child)
    return [_values(ray) | {"children": [places[id(child)] for child in ray.children]} for ray in found]


class _Kin:
    """Rays that are copied and sent together."""

    def __init__(self, rays: list[Ray]) -> None:
        self.rays = rays

    def take(self, ray: Ray) -> None:
        object.__setattr__(ray, _KIN, (self, len(self.rays)))
        self.rays.append(ray)

    def __reduce__(self) -> tuple[Any, ...]:
        return _kin, (_rows(self.rays),)


_KIN: Final = "_kin"  # of a ray: its _Kin, and its place there


def _kin(rows: list[dict[str, Any]]) -> _Kin:
    kin = _Kin([])
    for row in rows:
        kin.take(Ray(**row | {"children": ()}))
    for ray, row in zip(kin.rays, rows, strict=True):  # nobody has seen them yet
        object.__setattr__(ray, "children", tuple(kin.rays[place] for place in row["children"]))
    return kin


def _member(kin: _Kin, place: int) -> Ray:
    return kin.rays[place]
