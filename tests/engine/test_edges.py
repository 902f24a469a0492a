"""Rays that meet exactly an edge of a solid, where two of its faces are in one place: kernels/edges.clh."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.resources import validation_module

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
FACES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]  # 5: towards +z
EDGES = [(i, j) for i in range(8) for j in range(i) if (i ^ j).bit_count() == 1]
GLASS = {"diffuse": 0, "transmission": 1, "fresnel": True, "absorption": 0.3}
CLAY = {"diffuse": 1}


def cube(kind: str, faces: list[list[int]], material: dict[str, Any], corners: np.ndarray = CORNERS) -> Any:
    """The same solid as a box, one mesh or six polygons."""
    if kind == "box":
        return [{"type": "box", "min": [-1, -1, -1], "max": [1, 1, 1], "material": material}]
    if kind == "mesh":
        return [{"type": "mesh", "vertices": corners.tolist(), "faces": faces, "material": material}]
    return [{"type": "polygon", "points": corners[face].tolist(), "material": material} for face in faces]


@pytest.mark.parametrize("order", [[0, 1, 2, 3, 4, 5], [5, 4, 3, 2, 1, 0], [1, 5, 2, 3, 4, 0]])
@pytest.mark.parametrize(
    ("kind", "material"),
    [("box", GLASS), ("mesh", GLASS), ("box", CLAY), ("mesh", CLAY), ("polygons", CLAY)],
)
def test_an_outline_looks_like_what_is_on_one_of_its_sides(
    kind: str, material: dict[str, Any], order: list[int]
) -> None:
    """A cube seen straight on, its outline through the middles of pixels. Whichever face came first in the
    order of faces was met: the outline of an opaque one was shaded as a side is from within, and glass that a
    ray only touches was crossed, so that what is behind was absorbed."""
    shapes = cube(kind, [FACES[number] for number in order], material)
    lit = {"ambient": 1, "diffuse": 0}
    wall = {"type": "plane", "point": [0, 0, -3], "normal": [0, 0, 1], "material": lit}
    camera = {"origin": [0, 0, 5], "target": [0, 0, 0], "fov": 90, "width": 100, "height": 100}
    lights = [{"type": "point", "position": [0, 0, 5], "intensity": 1}]
    table = {"camera": camera, "ambient": 1.0, "lights": lights, "shapes": [*shapes, wall]}
    pixels = clrt.render(table).pixels
    nearest = np.full(pixels.shape[:2], np.inf)
    for x, y in itertools.product((-1e-3, 1e-3), repeat=2):
        beside = clrt.render({**table, "camera": {**camera, "shift": [x, 0.9 * y]}}).pixels
        nearest = np.minimum(nearest, np.abs(pixels - beside).max(axis=-1))
    assert np.count_nonzero(nearest > 0.01) == 0


@pytest.mark.parametrize("kind", ["box", "mesh", "polygons"])
@pytest.mark.parametrize("beside", ["ground", "room"])
def test_a_room_hides_what_it_stands_on_and_beside(kind: str, beside: str) -> None:
    """Pixels that lie exactly on the seam of floor and wall showed the ground under the floor, or the next
    room: outer sides that are met at the edge, in the place of its inner ones."""
    green, red = {"color": [0, 1, 0]}, {"color": [1, 0, 0]}
    other = [{"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0], "material": green}]
    camera = {"origin": [0, 0, 0], "target": [1, 0, 0], "fov": 120, "width": 65, "height": 65}
    if beside == "room":
        other = cube("mesh", FACES, green, CORNERS + np.array([0, 0, 2]))
        camera = {**camera, "target": [1, 0, 1], "fov": 70}
    pixels = clrt.render({
        "ambient": 0.3, "camera": camera,
        "lights": [{"type": "point", "position": [0, 0.5, 0], "intensity": 1}],
        "shapes": [*cube(kind, FACES, red), *other],
    }).pixels  # fmt: skip
    assert pixels[..., 1].max() == 0 and pixels[..., 0].min() > 0


def test_what_is_behind_an_edge_is_not_at_it() -> None:
    """Another solid's edge behind the seam of a room, a hundred times as far off as places are wide."""
    turn, gap = np.radians(20), 4e-5
    edge = (CORNERS[:, [0, 2]] + 1) @ [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]] + 1 + gap
    corners = np.stack([edge[:, 0], CORNERS[:, 1], edge[:, 1]], axis=1)
    shapes = cube("mesh", FACES, {"color": [1, 0, 0]}) + cube("mesh", FACES, {"color": [0, 1, 0]}, corners)
    camera = {"origin": [0, 0, 0], "target": [1, 0, 1], "fov": 70, "width": 65, "height": 65}
    lights = [{"type": "point", "position": [0, 0.5, 0], "intensity": 1}]
    pixels = clrt.render({"ambient": 0.3, "camera": camera, "lights": lights, "shapes": shapes}).pixels
    assert pixels[..., 1].max() == 0 and pixels[..., 0].min() > 0


def turned(draw: np.random.Generator) -> np.ndarray:
    q, _ = np.linalg.qr(draw.normal(size=(3, 3)))
    return np.asarray(q * np.sign(np.linalg.det(q)))


@pytest.mark.parametrize(("kind", "material"), [("mesh", CLAY), ("polygons", CLAY), ("mesh", GLASS)])
def test_rays_at_edges_of_turned_solids_see_one_of_their_sides(kind: str, material: dict[str, Any]) -> None:
    """4,000 rays at points of edges, rounded, of solids in any pose: beside such a ray is a like one. Of the
    opaque 6 % were shaded as inner sides are, of those at glass 15 % were lost."""
    draw, wrong = np.random.default_rng(7), 0
    for _ in range(10):
        corners = CORNERS @ turned(draw).T * draw.uniform(0.3, 3)
        corners += draw.normal(size=3) * draw.choice([0, 3, 30])
        middle, size = corners.mean(axis=0), float(np.linalg.norm(corners[0] - corners[7]))
        eye = middle + turned(draw)[:, 2] * size * draw.choice([1.0, 3.0, 20.0])
        tracer = clrt.Tracer(clrt.load_dict({
            "background": [0.2, 0.4, 0.7], "ambient": 0.1 if material is not GLASS else 1.0, "max_depth": 4,
            "lights": [{"type": "directional", "direction": turned(draw)[0].tolist(), "intensity": 1}],
            "shapes": cube(kind, [FACES[number] for number in draw.permutation(6)], material, corners),
        }))  # fmt: skip
        ends = np.array(EDGES)[draw.integers(12, size=400)]
        a, b = corners[ends[:, 0]], corners[ends[:, 1]]
        p = a + draw.uniform(size=(400, 1)) * (b - a)
        along = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
        across = np.cross(p - eye, along)
        across /= np.linalg.norm(across, axis=1, keepdims=True)

        def seen(points: np.ndarray, tracer: clrt.Tracer = tracer, eye: np.ndarray = eye) -> np.ndarray:
            return tracer.radiance(np.tile(eye, (400, 1)), points - eye)[0]

        ways = [x * across + y * along for x in (-1, -0.3, 0.3, 1) for y in (-1, 0, 1)]
        beside = [np.abs(seen(p) - seen(p + 1e-4 * size * way)).max(axis=-1) for way in ways]
        wrong += int(np.count_nonzero(np.min(beside, axis=0) > 0.02))
    assert wrong <= 8


def rod(radius: float, length: float, sides: int) -> tuple[np.ndarray, list[list[int]]]:
    """Vertices and triangles of a prism along x, its ends last."""
    turn = np.arange(sides) * 2 * np.pi / sides + 0.1
    ring = np.stack([np.zeros(sides), radius * np.sin(turn), radius * np.cos(turn)], axis=1)
    half = np.array([length / 2, 0, 0])
    pairs = [(i, (i + 1) % sides) for i in range(sides)]
    faces = [face for i, j in pairs for face in ([j, i, sides + j], [sides + j, i, sides + i])]
    faces += [end for i in range(1, sides - 1) for end in ([i, i + 1, 0], [sides + i + 1, sides + i, sides])]
    return np.concatenate([ring - half, ring + half]), faces


def view(origin: list[float], target: list[float], fov: float, shapes: Any, **more: Any) -> clrt.Scene:
    floor = {"type": "plane", "point": [0, -45, 0], "normal": [0, 1, 0], "material": {"color": [1, 0.8, 0.6]}}
    return clrt.load_dict({
        "max_depth": 6, "background": [0.2, 0.4, 0.8], "ambient": 0.3, "shapes": [*shapes, floor],
        "camera": {"origin": origin, "target": target, "fov": fov, "width": 120, "height": 90},
        "lights": [{"type": "directional", "direction": [-0.3, -1, -0.5], "intensity": 1}], **more,
    })  # fmt: skip


def off(scene: clrt.Scene) -> np.ndarray:
    """By how much pixels differ from the float64 oracle's."""
    right = validation_module("oracle64").render64(scene).pixels
    return np.asarray(np.abs(clrt.render(scene).pixels - right).max(axis=-1))


def test_long_thin_faces_are_not_all_edge() -> None:
    """A rod of 1,000 by 6 of 64 triangles: what their distances are rounded by is as thick as the rod, which
    was only touched, and not there."""
    vertices, faces = rod(3, 1000, 32)
    glass = {"type": "mesh", "vertices": vertices.tolist(), "faces": faces, "material": GLASS}
    wrong = off(view([100, 30, 60], [100, 0, 0], 20, [glass]))
    assert np.sqrt(np.mean(wrong**2)) < 0.02


def test_a_pipe_seen_from_within_hides_its_neighbours() -> None:
    """Its faces were all edge: the outer sides of neighbours that touch it were seen, and feelers started far
    back."""
    vertices, faces = rod(40, 4000, 48)

    def pipe(x: float, y: float, color: list[float]) -> dict[str, Any]:
        moved = (vertices + np.array([0, x, y])).tolist()
        return {"type": "mesh", "vertices": moved, "faces": faces[:96], "material": {"color": color}}

    pipes = [pipe(0, 0, [1, 1, 1]), pipe(80, 0, [1, 0, 0]), pipe(-80, 0, [1, 0, 0]), pipe(0, 80, [0, 1, 0])]
    lamp = {"type": "point", "position": [-1500, 20, 0], "intensity": 1}
    assert off(view([-1900, 5, 3], [0, 0, 0], 60, pipes, lights=[lamp])).max() < 0.02


def test_edges_are_no_wider_than_rays_are_rounded() -> None:
    """A cube of glass 1,000 of its sizes from the origin: with wider edges 38 pixels were wrong."""
    middle = np.array([1000.0, 0, 700])
    glass = cube("mesh", FACES, {**GLASS, "absorption": [0.2, 0.8, 1.5]}, CORNERS / 2 + middle)
    wrong = off(view((middle + np.array([1.3, 1.2, 2])).tolist(), middle.tolist(), 35, glass))
    assert np.count_nonzero(wrong > 0.02) <= 20


def test_rays_within_glass_do_not_get_out_at_an_edge() -> None:
    """Down the diagonal of a cube's front rays meet the edge of two sides from within: reflected by the one
    they started in the plane of the other, and were lost behind it: half of the edge was black."""
    shapes = cube("mesh", FACES, GLASS)
    tracer = clrt.Tracer(clrt.load_dict({"background": 1.0, "ambient": 1, "max_depth": 4, "shapes": shapes}))
    eye, height = np.array([0, 0, 20.0]), np.linspace(0.9, -0.9, 200)[:, None]
    points = np.concatenate([np.ones_like(height), -np.ones_like(height), height], axis=1)

    def seen(x: float) -> np.ndarray:
        return tracer.radiance(np.tile(eye, (200, 1)), points - (eye - np.array([x, 0, 0])))[0]

    beside = np.minimum(np.abs(seen(0.0) - seen(1e-3)), np.abs(seen(0.0) - seen(-1e-3)))
    assert beside.max() < 0.01


@pytest.mark.parametrize("at", [0.0, 10.0, 100.0])
@pytest.mark.parametrize("normal", [[0, -1, 0], [0, 1, 0], [-1, 0, 0], [0, 0, -1]])
def test_an_endless_body_of_water_is_entered_from_another(normal: list[float], at: float) -> None:
    """A ball half in a sea of the same water, upside down too: a ray from a point in the sea may never leave
    it, so that rays from the ball were not taken to enter it, and the seam was white."""
    up = np.array(normal, float)
    water = {"diffuse": 0.0, "transmission": 1.0, "ior": 1.0, "absorption": [0.5, 0.2, 0.1]}
    aside = np.roll(up, 1)
    place = np.full(3, at)
    pixels = clrt.render({
        "max_depth": 8, "background": 1.0,
        "camera": {"origin": (place + 5 * up + 6 * aside).tolist(), "target": place.tolist(), "up": normal,
                   "fov": 30, "width": 160, "height": 120},
        "shapes": [
            {"type": "plane", "point": place.tolist(), "normal": normal, "material": water},
            {"type": "sphere", "center": (place + 0.3 * up).tolist(), "radius": 1, "material": water},
        ],
    }).pixels  # fmt: skip
    assert pixels.max() == 0


def test_an_endless_quadric_of_water_is_entered_from_another() -> None:
    """The same with an endless cup, seen upwards: what has gone into it never leaves it."""
    water = {"diffuse": 0.0, "transmission": 1.0, "ior": 1.0, "absorption": 2.0}
    cup, c = [1, 1, -1, 0, 0, 0, 0, 0, 0, 0.1], 501.5  # x^2 + y^2 - z^2 + 0.1 = 0
    pixels = clrt.render({
        "max_depth": 6, "background": 1.0,
        "camera": {"origin": [c + 3, 0.5, c - 6], "target": [c, 0, c], "fov": 30, "width": 160, "height": 90},
        "shapes": [
            {"type": "quadric", "coefficients": cup, "material": water},
            {"type": "sphere", "center": [c, 0, c], "radius": 1, "material": water},
        ],
    }).pixels  # fmt: skip
    assert pixels.max() == 0
