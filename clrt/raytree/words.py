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
    rays, feelers = len(tree.rays), counts["feelers"]
    plural = "" if rays == 1 else "s"
    return f"{samples}, {rays} ray{plural}, {feelers} shadow feeler{'' if feelers == 1 else 's'}"


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
    name = tree.names.light(light.light)
    if not light.feelers:
        return []
    arriving = [feeler for feeler in light.feelers if feeler.seen]
    hiding = {tree.names.shape(f.met[-1].shape): f.met[-1].t for f in light.feelers if not f.seen and f.met}
    if not arriving:
        where = f" after {next(iter(hiding.values())):.4g}" if len(light.feelers) == 1 and hiding else ""
        return [Line(f"{name}: blocked by {', '.join(hiding) or 'what is there'}{where}", 0.0, "", True)]
    about = ""
    if len(light.feelers) > 1:
        about = f", {len(arriving)} of {len(light.feelers)} feelers arrive"
        about += f" (others: {', '.join(hiding)})" if hiding else ""
    elif arriving[0].met:
        about = f" through {', '.join(tree.names.shape(met.shape) for met in arriving[0].met)}"
        about += f" (x {numbers(arriving[0].filter)})"
    found = [
        _line(tree, ray, f"{name}, {term}{about}", value)
        for term, value in (("diffuse", light.diffuse), ("highlight", light.highlight))
        if any(value)
    ]
    return found or [Line(f"{name}{about}: arrives, adds nothing", 0.0, "")]


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
