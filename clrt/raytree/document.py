"""A tree of rays as tables, lists, texts and numbers, for JSON."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from clrt.version import __version__

if TYPE_CHECKING:
    from clrt.raytree.tree import Feeler, LightShare, Ray, RayTree


def document(tree: RayTree) -> dict[str, Any]:
    """What docs/explain.md describes. Numbers are the float32 that the device has; infinite ones are None."""
    return {
        "clrt": __version__, "scene": tree.scene.source, "pixel": [tree.x, tree.y],
        "size": [tree.width, tree.height], "samples": tree.samples, "max_depth": tree.max_depth,
        "weights": _list(tree.weights) or None,
        "value": _list(tree.value.tolist()), "bands": tree.bands,
        "response": None if tree.response is None else tree.response.tolist(),
        **tree.stats(),
        "tree": [_ray(tree, ray) for ray in tree.rays],
    }  # fmt: skip


def _ray(tree: RayTree, ray: Ray) -> dict[str, Any]:
    names, hit = tree.names, None
    if ray.hit is not None:
        hit = {
            "t": _number(ray.hit.t), "shape": ray.hit.shape, "name": names.shape(ray.hit.shape),
            "material": names.material_of(ray.hit.shape), "primitive": ray.hit.primitive,
            "point": _list(ray.hit.point), "normal": _list(ray.hit.normal),
            "shading_normal": _list(ray.hit.shading), "inside": ray.hit.inside,
        }  # fmt: skip
    return {
        "number": ray.number, "parent": ray.parent, "children": [child.number for child in ray.children],
        "generation": ray.generation, "queue": ray.queue, "kind": ray.kind, "sample": ray.sample,
        "first_band": ray.first_band, "origin": _list(ray.origin), "direction": _list(ray.direction),
        "media": [names.material(number) for number in ray.media], "medium": names.material(ray.medium),
        "weight": _list(ray.weight), "arriving": _list(ray.arriving), "hit": hit,
        "total_internal_reflection": ray.total_internal,
        "terms": {
            "emission": _list(ray.emission), "ambient": _list(ray.ambient),
            "background": _list(ray.background), "beyond": _list(ray.beyond),
            "lights": [_light(tree, light) for light in ray.lights],
        },
        "brings": None if ray.brings is None else _list(ray.brings),
        "share": tree.shares[ray.number], "branch_share": tree.branch_shares[ray.number],
    }  # fmt: skip


def _light(tree: RayTree, light: LightShare) -> dict[str, Any]:
    return {
        "light": light.light, "name": tree.names.light(light.light), "diffuse": _list(light.diffuse),
        "highlight": _list(light.highlight), "brings": _list(light.brings),
        "feelers": [_feeler(tree, feeler) for feeler in light.feelers],
    }  # fmt: skip


def _feeler(tree: RayTree, feeler: Feeler) -> dict[str, Any]:
    return {
        "origin": _list(feeler.origin), "direction": _list(feeler.direction),
        "distance": _number(feeler.distance), "seen": feeler.seen, "filter": _list(feeler.filter),
        "met": [
            {"shape": met.shape, "name": tree.names.shape(met.shape), "t": met.t, "blocks": met.blocks}
            for met in feeler.met
        ],
    }  # fmt: skip


def _list(values: Any) -> list[float | None]:
    return [_number(value) for value in values]


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
