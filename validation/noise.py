"""How far float32 moves a scene's picture: what limits of its own a case may have.

The float64 oracle renders the scene, and once more with every number of shapes, lights, materials and camera
moved by one unit in the last place of a float32, up or down. What the two pictures differ by is the least
that any program in float32 may differ by, for it rounds as much when it reads the scene.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import cycle, repeat
from typing import Any, Final

import numpy as np

from clrt.base.errors import ClrtWarning
from clrt.formats import load_dict
from clrt.scene.scene import Scene

from .compare.oracle import SIZE, Limits, compare
from .limits import FIGURES, Noise, limits_of, times_of, widened
from .oracles import Picture64, edges64, picture64
from .types import Case, Comparison, OracleImage

# how each number in turn is moved in the pictures: neighbours are moved apart in one at least, say the height
# of a camera and that of its target, which tilts it
_SIGNS: Final = ((1, 1, 1), (-1, 1, -1), (1, -1, -1), (-1, -1, 1))
PICTURES: Final = len(_SIGNS[0])
# where these explain too little: a surface seen at a grazing angle is moved by one picture in ten twice as
# far as by the worst of the first three. In all others each number's way is drawn by itself
MANY: Final = 16
_COUNTED: Final = ("fine", "coarse", "masked", "rays", "layers")  # shares of pixels
# fields that are the worst of several figures -> how the names of these begin and end
_WORST_OF: Final = {"rays": ("", ": within 1e-4"), "layers": ("layer ", "")}
_KEPT: Final = frozenset({"spp", "max_depth", "width", "height", "samples", "seed", "jitter", "priority"})


@dataclass(eq=False)
class Excuses:
    """What may excuse a picture that differs, looked for only where one does: passing without proves more.

    scene: the case's. reference: the float64 oracle's picture of it.
    """

    case: Case
    scene: Scene
    reference: Picture64

    @cached_property
    def edges(self) -> np.ndarray:
        """Pixels (h, w) where the reference jumps: there correct programs differ."""
        return edges64(self.scene, self.reference)

    @cached_property
    def noise(self) -> Noise:
        """What float32 moves the picture by, at the least."""
        return measured(self.scene, self.reference, self.edges, self.case.spp, PICTURES)

    @cached_property
    def rare(self) -> Noise:
        """The same of so many pictures that what few of them show is among it."""
        return measured(self.scene, self.reference, self.edges, self.case.spp, MANY)

    def judged(
        self, judge: Callable[[np.ndarray | None, Limits], Comparison], oracle: str
    ) -> Comparison:
        """What `judge` says of an oracle's picture (edges to leave out, limits); tests need no noise."""
        limit = limits_of(self.case, oracle)
        found = judge(None, limit)
        if found.passed or found.gates[0].name == SIZE:
            return found
        found = judge(self.edges, limit)
        if found.passed or self.case.is_test:
            return found
        times = times_of(self.case, oracle)
        found = judge(self.edges, widened(limit, self.noise, times))
        return found if found.passed else judge(self.edges, widened(limit, self.rare, times))


def moved(scene: Scene, picture: int) -> Scene:
    """The scene with each of those numbers one step of float32 away, for a picture from 0 to MANY - 1."""
    few = picture < PICTURES
    draw = np.random.default_rng(0 if few else picture)  # who is moved alike in all pictures is so by chance
    rows = (row[picture] for row in cycle(_SIGNS)) if few else repeat(1)
    signs = (draw.choice((-1.0, 1.0)) * row for row in rows)
    table = scene.to_dict()
    for key in ("shapes", "lights", "materials", "camera"):
        if key in table:
            table[key] = _moved(table[key], signs)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ClrtWarning)
        return load_dict(table, folder=scene.folder)


def _moved(value: Any, signs: Iterator[float]) -> Any:
    if isinstance(value, dict):
        return {key: inner if key in _KEPT else _moved(inner, signs) for key, inner in value.items()}
    if isinstance(value, list):
        return [_moved(inner, signs) for inner in value]
    if isinstance(value, float) and value not in (0.0, 1.0):
        return float(value + float(np.spacing(np.float32(abs(value)))) * next(signs))
    return value


def measured(scene: Scene, reference: OracleImage, edges: np.ndarray, spp: int, pictures: int) -> Noise:
    """The noise of a scene whose float64 picture and edges (h, w) are those, by so many moved ones."""
    every = Limits(None, None, None, None, None)
    away = (picture64(moved(scene, picture)) for picture in range(pictures))
    found = [compare(picture, reference, edges, spp, every) for picture in away]
    inside = int(np.count_nonzero(edges))
    pixels = {field: max(inside if field == "masked" else edges.size - inside, 1) for field in _COUNTED}
    figures: dict[str, float] = {}
    for field, (_, low) in FIGURES.items():
        values = [value for one in found if (value := _figure(field, one)) is not None]
        if values and field in pixels:
            # what was seen k times in so many pictures is expected k + 1 times at the most (Laplace)
            unseen = 1 / (len(values) * pixels[field])
            figures[field] = float(np.mean(values)) + (-unseen if low else unseen)
        elif values:
            figures[field] = (min if low else max)(values)
    return Noise(figures, pixels)


def _figure(field: str, comparison: Comparison) -> float | None:
    if field in _WORST_OF:
        start, end = _WORST_OF[field]
        return min((value for key, value in comparison.metrics.items()
                    if key.startswith(start) and key.endswith(end)), default=None)  # fmt: skip
    return comparison.metrics.get(FIGURES[field][0])
