"""The oracle's light against what is known without it: identities, symmetries, closed forms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from tests.pictured import image, put
from tests.solids import CAMERA, SHAPES, colourful, rays_towards_the_middle, scene, shape
from validation.oracle64 import radiance64, render64, trace64


@pytest.mark.parametrize(
    "settings", [{}, {"ambient_samples": 3, "max_depth": 3}, {"depth_color": 0.4, "max_depth": 2}]
)
def test_layers_sum_to_the_picture(settings: dict[str, Any]) -> None:
    found = colourful(**settings)
    routes = ("direct", "reflection", "transmission")
    generations = [f"generation_{k}" for k in range(found.max_depth + 1)]
    image = render64(found, layers=[*routes, *generations])
    for names in (routes, generations):
        assert np.abs(sum(image.layers[name] for name in names) - image.pixels).max() < 1e-13
        assert all(image.layers[name].max() > 0.01 for name in names)


def test_layers_of_a_response_that_is_not_linear_are_clrts() -> None:
    """Each is developed by itself, from the bands that it sums; outside edges, which are a fiftieth."""
    found = colourful(spectrum={"bands": 6, "response": "thesis-2011"}, max_depth=2)
    names = ["direct", "reflection", "transmission", "generation_0", "generation_1", "ambient", "diffuse"]
    theirs, ours = render64(found, layers=names), clrt.render(found, layers=names)
    for name in names:
        off = np.abs(theirs.layers[name] - ours.layers[name]).max(axis=-1) / theirs.layers[name].max()
        assert np.quantile(off, 0.98) < 1e-4, name
    routes = sum(theirs.layers[name] for name in names[:3])
    assert np.abs(routes - theirs.pixels).max() > 0.1 * theirs.pixels.max(), "it would be linear"


def test_what_a_filters_lobes_leave_below_zero_is_black_where_the_response_is_a_ratio() -> None:
    """Beside a ball that shines before black; clrt divided such sums by 1, the oracle had 0."""
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {"emission": 0.002, "color": 1}}
    found = clrt.load_dict({
        "spectrum": {"bands": 6, "response": "thesis-2011"}, "shapes": [ball],
        "camera": {"origin": [0, 0, 5], "target": [0, 0, 0], "fov": 40, "width": 40, "height": 30, "spp": 9,
                   "filter": "mitchell"},
    })  # fmt: skip
    theirs, ours = render64(found), clrt.render(found, layers=["bands"])
    below = ours.layers["bands"].max(axis=-1) < 0
    assert below.sum() > 20 and (ours.pixels[below] == 0).all()
    assert ours.pixels.max() > 0.3 and np.abs(theirs.pixels - ours.pixels).max() < 1e-5


def test_terms_sum_to_generation_0_where_something_is_hit() -> None:
    terms = ("emission", "ambient", "diffuse", "highlight")
    image = render64(colourful(), layers=[*terms, "generation_0", "shape"])
    hit = image.layers["shape"] >= 0
    assert 0.5 < hit.mean() < 1
    total = sum(image.layers[name] for name in terms)
    assert np.abs(total - image.layers["generation_0"])[hit].max() < 1e-14
    assert (total[~hit] == 0).all()


@pytest.mark.parametrize("material", [
    {"fresnel": True, "diffuse": 0.0},
    {"fresnel": True, "diffuse": 0.0, "thin": True},
    {"reflection": 0.3, "transmission": 0.7, "diffuse": 0.0, "ior": 0.7},
    {"fresnel": "schlick", "reflection": 1.0, "diffuse": 0.0},
])  # fmt: skip
def test_white_furnace(material: dict[str, Any]) -> None:
    """Surfaces that only pass light on cannot be seen in white surroundings; nor can a white depth limit."""
    shapes = [shape(kind, turned=kind == "box", material=material) for kind in ("sphere", "box", "cone")]
    found = scene(*shapes, camera=CAMERA, background=1.0, depth_color=1.0, max_depth=6)
    image = render64(found)
    assert image.stats["rays"]["camera_hits"] > 100
    assert np.abs(image.pixels - 1).max() < 1e-12
    assert (
        image.stats["rays"]["total_internal_reflection"] > 0 or material.get("thin") or "ior" not in material
    )


def moved(found: clrt.Scene, matrix: np.ndarray, scale: float = 1.0) -> clrt.Scene:
    """A scene and its camera moved by a similarity (spheres and meshes only, lights without falloff)."""

    def to(p: Any) -> list[float]:
        return list(scale * matrix @ np.asarray(p, float))

    assert found.camera is not None
    camera = {
        **CAMERA,
        "origin": to(found.camera.origin),
        "target": to(found.camera.target),
        "up": list(matrix[:, 1]),
    }
    shapes: list[dict[str, Any]] = []
    for each in found.shapes:
        rows = np.eye(4)
        rows[:3, :3] = scale * matrix
        shapes.append(
            {
                "type": each.type,
                **SHAPES[each.type],
                "material": each.material,
                "transform": rows @ each.matrix,
            }
        )
    lights = [{"type": "point", "position": to(light.position)} for light in found.lights]
    return scene(*shapes, camera=camera, lights=lights, background=0.2, ambient=0.1)


def test_similar_scenes_give_the_same_picture() -> None:
    """Turned any way and scaled from a millimetre to 100 kilometres; mirrored, the picture is mirrored."""
    glass = {"reflection": 0.2, "transmission": 0.6, "diffuse": 0.1, "specular": 0.3}
    found = scene(
        shape("sphere", material=glass), shape("mesh", True, material={"diffuse": 0.7, "reflection": 0.3}),
        shape("cone", True, material=glass),
        camera=CAMERA, lights=[{"type": "point", "position": [2, 3, 4]}], background=0.2, ambient=0.1,
    )  # fmt: skip
    image = render64(found)
    turn = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    for scale in (1e-3, 1.0, 1e5):
        again = render64(moved(found, turn, scale))
        assert again.stats["rays"] == image.stats["rays"]
        assert np.abs(again.pixels - image.pixels).max() < 1e-6  # the offset, 1e-10, through three lenses
    mirrored = render64(moved(found, np.diag([-1.0, 1.0, 1.0])))
    assert np.abs(mirrored.pixels[:, ::-1] - image.pixels).max() < 1e-6


def test_a_ray_that_leaves_never_meets_its_own_surface() -> None:
    """In an empty sky convex bodies see only the sky, also at grazing angles and far from the origin."""
    for far in (0.0, 1e3):
        for kind in ("sphere", "ellipsoid", "cylinder", "cone", "box", "mesh"):
            mirror = {"reflection": 1.0, "diffuse": 0.0}
            body = shape(kind, transform=[{"translate": [far, -far, far]}], material=mirror)
            origin, direction = rays_towards_the_middle(3000)
            found = scene(body, background=1.0, max_depth=1)
            light, stats = radiance64(found, origin + np.array([far, -far, far]), direction)
            assert stats["rays"]["reflection"] > 500
            assert stats["generations"][1]["hits"] == 0
            assert (light == 1).all()


def test_ambient_samples_gather_what_surrounds() -> None:
    """Under a lamp of radius R at height h: its form factor is R^2 / (R^2 + h^2), the sky's the rest."""
    lamp = {
        "type": "disk",
        "center": [0, 2, 0],
        "normal": [0, -1, 0],
        "radius": 1.5,
        "material": {"diffuse": 0, "emission": 3.0},
    }
    floor = {
        "type": "plane",
        "point": [0, 0, 0],
        "normal": [0, 1, 0],
        "material": {"color": 0.5, "ambient": 0.8},
    }
    found = scene(floor, lamp, ambient=0.25, ambient_samples=1024, max_depth=1)
    light, stats = radiance64(found, [0, 1, -1], [0, -1, 1])
    share = 1.5**2 / (1.5**2 + 2**2)
    # 1024 points of a low-discrepancy sequence: an error of a few thousandths in the share
    assert light[0] == pytest.approx([0.4 * (share * 3.0 + (1 - share) * 0.25)] * 3, rel=5e-3)
    assert stats["rays"]["ambient"] == 1024
    empty, _ = radiance64(scene(floor, ambient=0.25, ambient_samples=16), [0, 1, -1], [0, -1, 1])
    assert empty[0] == pytest.approx([0.4 * 0.25] * 3, rel=1e-12)


def test_shadows_opaque_and_tinted() -> None:
    floor = {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], "material": {"color": 1.0}}
    glass = {"diffuse": 0, "transmission": 0.5, "transmission_color": [1, 0.8, 0.4], "thin": True}
    ball = {"type": "sphere", "center": [0, 2, 0], "radius": 0.5, "material": glass}
    pane = {"type": "polygon", "points": [[-1, 3, -1], [-1, 3, 1], [1, 3, 1], [1, 3, -1]], "material": glass}
    wall = {"type": "disk", "center": [0, 4, 0], "normal": [0, 1, 0], "radius": 0.1}
    beyond = {"type": "disk", "center": [0, 6, 0], "normal": [0, 1, 0], "radius": 0.1}
    light = [{"type": "point", "position": [0, 5, 0]}]
    ray = ([0, 1, -1], [0, -1, 1])
    tint = 0.5 * np.array([1, 0.8, 0.4])

    def floor_light(*between: dict[str, Any], shadow: str) -> np.ndarray:
        return np.asarray(radiance64(scene(floor, *between, lights=light, shadow=shadow), *ray)[0][0])

    assert floor_light(beyond, shadow="opaque") == pytest.approx([1] * 3)
    assert floor_light(ball, shadow="opaque").tolist() == [0] * 3
    assert floor_light(ball, beyond, shadow="tinted") == pytest.approx(tint**2)  # in and out
    assert floor_light(ball, pane, shadow="tinted") == pytest.approx(tint**3)
    assert floor_light(ball, wall, pane, shadow="tinted").tolist() == [0] * 3


@pytest.mark.parametrize("pictured", ["color", "transmission_color"])
def test_a_tint_of_0_beside_a_picture_tints_shadows(pictured: str, tmp_path: Path) -> None:
    """Of a material with a picture the tint divided by itself: 0 by 0."""
    put(tmp_path / "tint.exr", np.broadcast_to([1.0, 0.0, 0.25], (2, 2, 3)))
    pane = {"diffuse": 0, "transmission": 0.5, "transmission_color": [1, 0, 0.25], "thin": True}
    pane[pictured] = image("tint.exr")
    shapes = [
        {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], "material": {"color": 1.0}},
        {"type": "disk", "center": [0, 2, 0], "normal": [0, 1, 0], "radius": 0.5, "material": pane},
    ]
    light = [{"type": "point", "position": [0, 5, 0]}]
    found = clrt.load_dict({"shapes": shapes, "lights": light, "shadow": "tinted"}, folder=tmp_path)
    seen = radiance64(found, [0, 1, -1], [0, -1, 1])[0][0]
    assert seen == pytest.approx([0.5, 0, 0.125], abs=1e-14)


def test_opaque_surfaces_that_are_one_sided() -> None:
    """Invisible from behind, to shadow feelers too; transmitting ones stay."""
    inside = ([0.1, 0.2, -0.1], [0, 0, 1])
    white = {"background": 1.0, "one_sided": "opaque"}
    assert radiance64(scene(shape("sphere"), **white), *inside)[0].tolist() == [[1] * 3]
    clear = shape("sphere", material={"diffuse": 0, "transmission": 0.5, "ior": 1.0})
    assert radiance64(scene(clear, **white), *inside)[0].tolist() == [[0.5] * 3]
    # through the open end of a tube the wall shows its inner side: not seen; from outside the near wall is
    tube = {"type": "cylinder", "p0": [0, -1, 0], "p1": [0, 1, 0], "radius": 0.5}
    assert trace64(
        scene(tube, **white), [[0, 2, 0], [0, 0, -3]], [[0.2, -1, 0], [0, 0, 1]]
    ).shape.tolist() == [-1, 0]


def test_rays_of_no_or_little_weight() -> None:
    glass = {"diffuse": 0, "transmission": 0.6, "reflection": 0.0}
    ball = shape("sphere", material=glass)
    ray = ([0.3, 0.2, -5], [0, 0, 1])

    def counts(**settings: Any) -> list[int]:
        rays = radiance64(scene(ball, max_depth=3, background=1.0, **settings), *ray)[1]["rays"]
        return [rays["reflection"], rays["transmission"]]

    assert counts() == [0, 2]
    assert counts(min_weight=0.5) == [0, 1]
    # every hit of glass reflects, though with weight 0: 1 + 1 inside + (1 + 1) in the next generation
    assert counts(conformance="spd", min_weight=0.5) == [3, 3]
    assert radiance64(scene(ball, background=1.0, min_weight=0.5), *ray)[0].tolist() == [[0] * 3]


@pytest.mark.parametrize("spectral", [{}, {"spectrum": {"bands": 8}}])
@pytest.mark.parametrize("lamp", [{"name": "D65", "scale": 0}, {"blackbody": 3000, "scale": 0}])
def test_a_lamp_scaled_by_0_is_dark(lamp: dict[str, Any], spectral: dict[str, Any]) -> None:
    def seen(dark: Any) -> np.ndarray:
        lights = [{"type": "point", "position": [0, 5, -5], "intensity": each} for each in (dark, 0.7)]
        ball = shape("sphere", material={"color": 0.8, "emission": dark})
        return radiance64(scene(ball, lights=lights, **spectral), [0.1, 0.3, -5], [0, 0, 1])[0]

    assert np.array_equal(seen(lamp), seen(0.0)) and seen(lamp).max() > 0.1
