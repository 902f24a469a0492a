"""A ray in words: what a terminal and a page say of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from clrt.raytree.sums import luminance_of

if TYPE_CHECKING:
    from clrt.raytree.tree import LightShare, Ray, RayTree


class Line(NamedTuple):
    """What a term is, what of the pixel it brings (0 to 1), and its colour as text; "" for nothing.

    why: it says why there is no light.
    """

    text: str
    share: float
    colour: str
    why: bool = False


def title(tree: RayTree) -> str:
    """The pixel and its value."""
    scene = tree.scene.source or "scene"
    size = f"{tree.width} x {tree.height}"
    return f"pixel ({tree.x}, {tree.y}) of {scene}, {size}: {numbers(tree.value.tolist())}"


def summary(tree: RayTree) -> str:
    """How many rays it took."""
    counts = tree.stats()["rays"]
    samples = f"{tree.samples} sample{'s' if tree.samples > 1 else ''}"
    return f"{samples}, {len(tree.rays)} rays, {counts['feelers']} shadow feelers"


def heading(tree: RayTree, ray: Ray) -> str:
    """What kind of ray it is, and where it ends."""
    kind = f"{ray.kind} ray {ray.number}"
    if ray.narrow:
        kind += f" of bands {ray.first_band} to {ray.first_band + len(ray.weight) - 1}"
    if ray.hit is None:
        where = "meets nothing"
    else:
        side = " from inside" if ray.hit.inside else ""
        where = f"meets {tree.names.shape(ray.hit.shape)}{side} after {ray.hit.t:.4g}"
    through = f" through {tree.names.material(ray.medium)}" if ray.medium >= 0 else ""
    return f"{kind}{through} {where}, weight {numbers(ray.weight)}"


def lines(tree: RayTree, ray: Ray) -> list[Line]:
    """What the ray itself brings, term by term; those that bring nothing only where a reason can be told."""
    found = []
    around = "ambient light from outside" if ray.kind == "ambient" else "background"
    for name, value in (("emission", ray.emission), ("ambient light", ray.ambient), (around, ray.background),
                        ("beyond the last generation", ray.beyond)):  # fmt: skip
        if any(value):
            found.append(_line(tree, ray, name, value))
    for light in ray.lights:
        found += _light(tree, ray, light)
    if ray.total_internal:
        found.append(Line("total internal reflection: nothing is transmitted", 0.0, "", True))
    return found


def _light(tree: RayTree, ray: Ray, light: LightShare) -> list[Line]:
    name, count = tree.names.light(light.light), len(light.feelers)
    if not light.feelers:
        return []
    arrived = [feeler for feeler in light.feelers if feeler.seen]
    if not arrived:
        ends = [met for feeler in light.feelers for met in feeler.met[-1:]]
        behind = " and ".join(dict.fromkeys(tree.names.shape(met.shape) for met in ends)) or "what is there"
        after = f" after {ends[0].t:.4g}" if count == 1 and ends else ""
        return [Line(f"{name}: blocked by {behind}{after}", 0.0, "", True)]
    through = f", {len(arrived)} of {count} points seen" if count > 1 else ""
    passed = dict.fromkeys(tree.names.shape(met.shape) for feeler in arrived for met in feeler.met)
    if passed:
        through += f" through {', '.join(passed)}"
        through += f" (x {numbers(np.mean([feeler.filter for feeler in arrived], axis=0).tolist())})"
    found = [
        _line(tree, ray, f"{name}, {term}{through}", value)
        for term, value in (("diffuse", light.diffuse), ("highlight", light.highlight))
        if any(value)
    ]
    return found or [Line(f"{name}{through}: arrives, adds nothing", 0.0, "")]


def _line(tree: RayTree, ray: Ray, text: str, value: Sequence[float]) -> Line:
    part = luminance_of(value, ray.first_band, tree.bands, tree.response)
    return Line(text, part / tree.luminance if tree.luminance else 0.0, numbers(value))


def numbers(values: Sequence[float]) -> str:
    """Three numbers as they are, more by their mean."""
    if len(values) > 4:
        return f"{np.mean(values):.4g} on average"
    return " ".join(f"{value:.4g}" for value in values)


def percent(share: float) -> str:
    """A share for people: what is there is never shown as nothing."""
    if 0 < share < 0.0005:
        return "<0.1 %"
    return f"{100 * share:.1f} %"
