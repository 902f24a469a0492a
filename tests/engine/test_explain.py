"""A pixel's rays as a tree: their sum is the pixel, their number the picture's, the tree float64's."""

from __future__ import annotations

import warnings
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest

import clrt
from clrt.raytree.page import page
from clrt.raytree.tree import Ray, RayTree
from validation.oracle64.hashing import FLAGS
from validation.oracle64.raytree import Key, Ray64, tree64
from validation.scenes.chance import scene as by_chance

SIZE = 40, 30
SCENES = Path(__file__).parents[2] / "scenes"
# Scenes by seed: those whose rays carry what few others do are left out, each would be compiled for itself.
DRAWN = {21: (0, 2, 3, 6, 7), 22: (0, 2, 3, 5, 7), 31: (0, 1, 2, 3, 4, 5, 6), 32: (0, 2, 3, 4, 5, 6, 7)}
SHIFTS = [(0.0, 0.0), *((x, y) for x in (0.05, -0.05) for y in (0.05, -0.05))]


def drawn(seed: int, number: int) -> clrt.Scene:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", clrt.ClrtWarning)
        return clrt.load_dict(by_chance(seed, number, wide=False))  # whose lights have one feeler each


def check_sums(tree: RayTree, image: clrt.Image, one: clrt.Image) -> None:
    """The pixel and the counts are those of pictures; and each ray's terms add up to what it brings."""
    assert tree.value.tobytes() == image.pixels[tree.y, tree.x].tobytes()
    assert tree.total.tobytes() == tree.value.tobytes()
    counts = tree.stats()
    assert {name: one.stats[name] for name in counts} == counts
    for ray in tree.rays:
        terms = [ray.emission, ray.ambient, ray.background, ray.beyond]
        terms += [light.brings for light in ray.lights]
        total = np.sum(terms, axis=0)
        brings = np.array(ray.brings or np.zeros(len(total)))
        # each of the sums was rounded to float32 on its way
        assert np.allclose(total, brings, rtol=len(terms) * 2.0**-22, atol=1e-30), ray
        for light in ray.lights:
            both = np.add(light.diffuse, light.highlight)
            assert np.allclose(both, light.brings, rtol=2.0**-20, atol=1e-30)
            if not any(feeler.seen for feeler in light.feelers):
                assert not any(light.brings)
            for feeler in light.feelers:
                assert [met.blocks for met in feeler.met[-1:]] == ([True] if not feeler.seen else
                                                                   [False] * len(feeler.met[-1:]))


@pytest.mark.parametrize("seed", [21, 22])
def test_what_the_rays_bring_is_the_pixel_bit_for_bit(seed: int) -> None:
    """Random scenes: any material and light, bands and dispersion, media in each other, ambient rays."""
    generator, rays, kinds = np.random.default_rng(seed), 0, set()
    for number in DRAWN[seed]:
        tracer = clrt.Tracer(drawn(seed, number))
        image = tracer.render(*SIZE, spp=4)
        for _ in range(3):
            x, y = (int(generator.integers(side)) for side in SIZE)
            tree = tracer.explain(x, y, *SIZE, spp=4)
            check_sums(tree, image, tracer.render(*SIZE, spp=4, crop=(x, y, 1, 1)))
            rays += len(tree.rays)
            kinds |= {ray.kind for ray in tree.rays}
    assert rays > 60 and kinds >= {"camera", "reflection", "transmission"}


@pytest.mark.parametrize("name", ["rainbow", "bubble", "tinted_shadows", "ambient", "thesis_4_2_shading"])
def test_of_scenes_that_ship_too(name: str) -> None:
    """Narrow rays, thin films in media, coloured shadows, ambient samples, the thesis program's colours."""
    tracer = clrt.Tracer(name)
    image = tracer.render(width=64)
    for x, y in ((20, image.height // 2), (33, image.height // 3), (45, image.height - 9)):
        tree = tracer.explain(x, y, width=64)
        check_sums(tree, image, tracer.render(width=64, crop=(x, y, 1, 1)))
        assert sum(tree.shares) == pytest.approx(1.0) or not any(tree.value)


def test_lights_with_extent_have_a_feeler_for_each_point() -> None:
    """Of each light its own: those of the second are drawn by its number."""
    tracer = clrt.Tracer("panel-room")
    image = tracer.render(width=64, spp=4)
    most = 0
    for x, y in ((20, image.height // 2), (33, image.height - 5)):
        tree = tracer.explain(x, y, width=64, spp=4)
        check_sums(tree, image, tracer.render(width=64, spp=4, crop=(x, y, 1, 1)))
        most = max(len(light.feelers) for ray in tree.rays for light in ray.lights)
        assert page(tree) and tree.as_dict()
    assert most > 1


@pytest.mark.parametrize("scene", ["showcase", "rainbow"])
@pytest.mark.parametrize("name", ["tent", "gaussian", "mitchell"])
def test_with_a_filter_each_sample_is_a_place_of_the_film(scene: str, name: str) -> None:
    """Queues are then merged sample by sample, and a ray's parent is not the next in its queue."""
    tracer = clrt.Tracer(clrt.load(scene).replace({"camera.filter": name}))
    generator, rays = np.random.default_rng(9), 0
    image = tracer.render(width=64, spp=16)
    for _ in range(6):
        x, y = int(generator.integers(64)), int(generator.integers(image.height))
        tree = tracer.explain(x, y, width=64, spp=16)
        assert tree.value.tobytes() == image.pixels[y, x].tobytes() == tree.total.tobytes()
        check_descent(tree)
        rays += len(tree.rays)
    assert rays > 150


def test_the_tree_hangs_together() -> None:
    tree = clrt.Tracer("bubble").explain(70, 50, width=160, spp=4)
    assert [root.sample for root in tree.roots] == [0, 1, 2, 3]
    check_descent(tree)
    assert tree.branch_shares[tree.roots[0].number] < 1 and sum(tree.shares) == pytest.approx(1)


def check_descent(tree: RayTree) -> None:
    """Children begin where their parents end, on the side that they go to."""
    assert [ray.number for ray in tree.rays] == list(range(len(tree.rays)))
    assert sorted(ray.number for ray in tree.walk()) == list(range(len(tree.rays)))
    for ray in tree.rays:
        for child in ray.children:
            assert child.parent == ray.number and child.generation == ray.generation + 1
            assert child.sample == ray.sample and ray.hit is not None
            side = np.dot(ray.hit.normal, np.subtract(child.origin, ray.hit.point))
            assert (side > 0) == (child.kind != "transmission")  # it leaves to the side it goes to
            way = np.linalg.norm(np.subtract(child.origin, ray.hit.point))
            assert 0 < way < 1e-4
        single = [child for child in ray.children if child.kind == "transmission" and not child.narrow]
        assert ray.narrow or len(single) <= 1


def keyed(rays: list[Ray64]) -> dict[Key, list[Ray64]]:
    found: dict[Key, list[Ray64]] = defaultdict(list)
    for ray in rays:
        found[ray.key].append(ray)
    return found


def keyed_ours(tree: RayTree) -> dict[Key, list[Ray]]:
    group = tree.scene.spectrum.group if tree.scene.spectrum else 1
    found: dict[Key, list[Ray]] = defaultdict(list)
    for ray in tree.rays:
        at = ray.first_band // group if ray.narrow else -1
        found[ray.generation, ray.kind, ray.path & ~FLAGS, at].append(ray)
    return found


def shapes(rays: dict[Key, list[Ray64]]) -> dict[Key, list[int]]:
    return {key: [ray.shape for ray in found] for key, found in rays.items()}


@pytest.mark.parametrize("seed", [31, 32])
def test_the_tree_is_that_of_the_recursion(seed: int) -> None:
    """Pixels where a twentieth of a pixel to all sides changes no ray of float64's tree, which are most.

    There each ray is in both trees, with the same shape; and weights and light differ by what rounding does:
    by less than a fiftieth of what that shift changes, which is about a thousand times as large.
    """
    generator, counts = np.random.default_rng(seed), []
    for number in DRAWN[seed]:
        tracer = clrt.Tracer(drawn(seed, number))
        for _ in range(3):
            x, y = (int(generator.integers(side)) for side in SIZE)
            counts.append(check_tree(tracer, x, y, *SIZE))
    assert sum(count > 0 for count in counts) >= 14 and sum(counts) >= 25


def check_tree(tracer: clrt.Tracer, x: int, y: int, width: int, height: int, spp: int = 1) -> int:
    """How many rays were compared: 0 where an edge is too near."""
    trees = [keyed(tree64(tracer.scene, x, y, width, height, spp, shift=shift)) for shift in SHIFTS]
    if any(shapes(tree) != shapes(trees[0]) for tree in trees):
        return 0
    ours = keyed_ours(tracer.explain(x, y, width, height, spp=spp))
    assert {k: [r.hit.shape if r.hit else -1 for r in v] for k, v in ours.items()} == shapes(trees[0])
    for key, found in ours.items():
        for i, ray in enumerate(found):
            check_ray(ray, [tree[key][i] for tree in trees])
    return sum(map(len, ours.values()))


def test_narrow_rays_are_those_of_the_recursion() -> None:
    """Of a drop of water: a ray for each of 24 bands, inside it and out of it.

    Pixels none of whose rays ends at a step of the background's picture, which is no edge of a shape.
    """
    tracer = clrt.Tracer("rainbow")
    assert [check_tree(tracer, x, y, 160, 120) for x, y in ((134, 64), (80, 60), (120, 50))] == [98] * 3


WIDE = {
    "max_depth": 3, "ambient": 0.1, "background": [0.2, 0.3, 0.5],
    "camera": {"origin": [0, 2.5, 7], "target": [0, 0.6, 0], "aperture": 0.02, "fov": 40},
    "lights": [
        {"type": "rectangle", "center": [-3, 4, 1], "u": [0.6, 0, 0], "v": [0, 0.2, 0.5],
         "radiance": [9, 8, 7], "samples": 3},
        {"type": "point", "position": [0, 6, 3], "intensity": 0.2},
        {"type": "disk", "center": [3, 4, 2], "normal": [-3, -4, -2], "radius": 0.5, "radiance": 12,
         "samples": 4, "visible": False},
        {"type": "sphere", "center": [0.5, 3, -2], "radius": 0.3, "radiance": [10, 15, 20], "samples": 2},
    ],
    "shapes": [
        {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0],
         "material": {"color": {"type": "image", "file": str(SCENES / "wood.png")}, "diffuse": 0.6,
                      "specular": 0.2, "reflection": 0.2, "roughness": 0.3,
                      "normal_map": {"file": str(SCENES / "tile-normals.png")}}},
        {"type": "sphere", "center": [-1, 1, 0], "radius": 1,
         "material": {"conductor": "gold", "roughness": 0.15, "diffuse": 0.0, "specular": 0.5}},
        {"type": "sphere", "center": [1.2, 0.8, 0.5], "radius": 0.8,
         "material": {"diffuse": 0.1, "reflection": 0.1, "transmission": 0.8, "ior": 1.5, "specular": 0.1}},
    ],
}  # fmt: skip


def test_wide_lights_gloss_lenses_and_textures_are_those_of_the_recursion() -> None:
    """Lights of every kind, each with its own points, for all samples of a pixel."""
    tracer = clrt.Tracer(clrt.load_dict(WIDE))
    at = (9, 13), (13, 11), (33, 24), (36, 20)
    counts = [check_tree(tracer, x, y, *SIZE, spp=4) for x, y in at]
    assert sum(count > 0 for count in counts) >= 4 and sum(counts) >= 45, counts
    rays = [ray for x, y in at for ray in tracer.explain(x, y, *SIZE, spp=4).rays]
    lit = [light for ray in rays for light in ray.lights if any(light.brings)]
    assert {light.light for light in lit} == {0, 1, 2, 3}
    assert [max(len(light.feelers) for light in lit if light.light == n) for n in range(4)] == [3, 1, 4, 2]


def check_ray(ray: Ray, theirs: list[Ray64]) -> None:
    here = slice(ray.first_band, ray.first_band + len(ray.weight))
    lit = [light.light for light in ray.lights if any(light.brings)]
    pairs = [(ray.arriving, [other.weight for other in theirs])]
    pairs += [(ray.brings or np.zeros(len(ray.weight)), [other.brings for other in theirs])]
    for number in lit:
        light = ray.lights[number]
        for name in ("diffuse", "highlight"):
            pairs.append((getattr(light, name), [other.terms[f"{name} {number}"] for other in theirs]))
    for mine, values in pairs:
        true, *moved = (np.asarray(value)[here] for value in values)
        spread = max(float(np.abs(other - true).max()) for other in moved)
        error = np.abs(np.asarray(mine)[: len(true)] - true).max()
        assert error <= 2e-5 * (1 + np.abs(true).max()) + 0.02 * spread, (ray, true)


def test_a_wrong_tree_is_noticed() -> None:
    """Planted: a ray less; a ray that brings a little more."""
    tracer = clrt.Tracer("bubble")
    tree = tracer.explain(80, 50, width=160, spp=1)
    tree.__dict__["rays"] = tree.rays[:-1]
    bright = next(ray for ray in tree.rays if ray.brings and min(ray.brings) > 1e-3)
    assert tree.stats()["rays"] != tracer.render(width=160, spp=1, crop=(80, 50, 1, 1)).stats["rays"]
    bright.__dict__["brings"] = tuple(value * 1.001 for value in bright.brings or ())
    assert tree.total.tobytes() != tree.value.tobytes()


def test_blockers_are_named() -> None:
    """A ball between a floor and one of two lights, and beside the other."""
    scene = clrt.load_dict({
        "camera": {"origin": [0, 3, 6], "target": [0, 0, 0], "width": 9, "height": 9, "fov": 20},
        "lights": [{"type": "point", "position": [0, 5, 0]},
                   {"type": "directional", "direction": [-1, -0.2, 0]},
                   {"type": "point", "position": [0, -5, 0]}],
        "shapes": [{"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], "name": "floor"},
                   {"type": "sphere", "center": [0, 3, 0], "radius": 0.5, "name": "ball"}],
    })  # fmt: skip
    (ray,) = clrt.Tracer(scene).explain(4, 4).rays
    above, aside, below = ((*light.feelers, None)[0] for light in ray.lights)
    assert above and not above.seen and above.distance == pytest.approx(5)
    assert [(met.shape, met.blocks) for met in above.met] == [(1, True)]
    assert above.met[0].t == pytest.approx(2.5, rel=1e-5) and not any(ray.lights[0].brings)
    assert aside and aside.seen and aside.distance == np.inf and not aside.met
    assert below is None  # under the floor
    assert np.allclose(ray.lights[1].brings, ray.lights[1].diffuse) and min(ray.lights[1].brings) > 0


def test_tinted_shadows_say_what_light_came_through() -> None:
    glass = {"transmission": 1.0, "transmission_color": [0.5, 0.6, 0.7], "ior": 1.0, "diffuse": 0.0}
    disks = [{"type": "disk", "center": [0, y, 0], "normal": [0, 1, 0], "radius": 1, "material": glass}
             for y in (1, 2)]  # fmt: skip
    table = {
        "shadow": "tinted", "max_depth": 0, "lights": [{"type": "point", "position": [0, 5, 0]}],
        "camera": {"origin": [0, 0.5, 6], "target": [0, 0, 0], "width": 3, "height": 3},
        "shapes": [{"type": "box", "min": [-3, -1, -3], "max": [3, 0, 3]}, *disks],
    }  # fmt: skip
    feeler = clrt.Tracer(clrt.load_dict(table)).explain(1, 1).rays[0].lights[0].feelers[0]
    assert feeler and feeler.seen and [met.shape for met in feeler.met] == [1, 2]
    assert np.allclose(feeler.filter, [0.25, 0.36, 0.49])
    table["shapes"].append({"type": "disk", "center": [0, 3, 0], "normal": [0, 1, 0], "radius": 1})
    feeler = clrt.Tracer(clrt.load_dict(table)).explain(1, 1).rays[0].lights[0].feelers[0]
    assert feeler and not feeler.seen and feeler.filter == (0.0, 0.0, 0.0)
    assert [(met.shape, met.blocks) for met in feeler.met] == [(1, False), (2, False), (3, True)]


def test_media_are_named() -> None:
    """Water in a glass: lists of media; and a ball alone, where the side of the surface tells."""
    tree = clrt.Tracer("straw").explain(50, 60, width=96, spp=1)
    inside = {tree.names.material(ray.medium) for ray in tree.rays}
    assert "outside" in inside and len(inside) > 1
    ball = clrt.load_dict({
        "camera": {"origin": [0, 0, 5], "target": [0, 0, 0], "width": 3, "height": 3}, "background": 0.5,
        "materials": {"glass": {"transmission": 1.0, "ior": 1.5}},
        "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "glass"}],
    })  # fmt: skip
    tree = clrt.Tracer(ball).explain(1, 1)
    assert [tree.names.material(ray.medium) for ray in tree.rays] == ["outside", "glass", "outside"]
    assert tree.rays[1].hit and tree.rays[1].hit.inside and tree.rays[1].hit.t == pytest.approx(2, rel=1e-5)


def test_what_cannot_be_explained_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    tracer = clrt.Tracer("ambient")
    with pytest.raises(clrt.ClrtError, match=r"x: 64 is not allowed; .* at least 0, at most 63"):
        tracer.explain(64, 0, width=64)
    with pytest.raises(clrt.ClrtError, match=r"y: -1 is not allowed"):
        tracer.explain(0, -1)
    with pytest.raises(clrt.SceneError, match="camera: missing"):
        clrt.Tracer({"shapes": []}).explain(0, 0)
    monkeypatch.setattr("clrt.engine.watcher.MOST_RAYS", 10)
    with pytest.raises(clrt.LimitError, match=r"more than 10 rays; lower max_depth"):
        tracer.explain(32, 20, width=64)
    monkeypatch.undo()
    monkeypatch.setattr("clrt.engine.explain.MOST_LIGHTS", 0)
    with pytest.raises(clrt.LimitError, match=r"lights; at most 0"):
        tracer.explain(32, 20, width=64)
    assert tracer.render(width=16).hash == clrt.render("ambient", width=16).hash


@pytest.mark.parametrize(
    ("lights", "spp", "panes"), [(1, 1, 400), (400, 1, 0), (1, 400, 0)], ids=["panes", "lights", "samples"]
)
def test_what_is_kept_of_a_pixel_is_bounded(
    monkeypatch: pytest.MonkeyPatch, lights: int, spp: int, panes: int
) -> None:
    """By all that it is made of: products of what each is small."""
    scene = {
        "max_depth": 0, "shadow": "tinted", "materials": {"clear": {"transmission": 0.9}, "wall": {}},
        "camera": {"origin": [0, 0, -5], "target": [0, 0, -9], "width": 3, "height": 3},
        "lights": [{"type": "point", "position": [0, 0, 5]}] + [
            {"type": "point", "position": [0, k, -50]} for k in range(1, lights)],
        "shapes": [{"type": "plane", "point": [0, 0, -9], "normal": [0, 0, 1], "material": "wall"}],
    }  # fmt: skip
    scene["shapes"] += [  # type: ignore[operator]
        {"type": "polygon", "points": [[x, y, -k / 200] for x, y in ((-9, -9), (9, -9), (9, 9), (-9, 9))],
         "material": "clear"} for k in range(panes)
    ]  # fmt: skip
    tracer = clrt.Tracer(scene)
    assert tracer.explain(1, 1, spp=spp).rays
    monkeypatch.setattr("clrt.engine.apart.MOST_NUMBERS", 1500)
    with pytest.raises(clrt.LimitError, match=r"of more than 1500 numbers; lower samples of lights"):
        tracer.explain(1, 1, spp=spp)
