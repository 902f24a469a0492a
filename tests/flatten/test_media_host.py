"""Where rays start, whether they need lists of media at all, what is warned of and what is refused."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import clrt
import clrt.flatten
from clrt import layout
from clrt.device.device import Device
from clrt.flatten.camera import near_corners
from clrt.flatten.flatten import flatten, flatten_camera
from clrt.flatten.inside import count_inside
from clrt.formats import load_dict
from clrt.scene.camera import Camera
from tests.engines import ENGINES, unit
from validation.selftest import _run
from validation.twin.math import exponential
from validation.twin.queues import generate

GLASS: dict[str, Any] = {"diffuse": 0.0, "fresnel": True}
WATER: dict[str, Any] = {**GLASS, "ior": "water"}


def sphere(x: float, radius: float, **material: Any) -> dict[str, Any]:
    return {"type": "sphere", "center": [x, 0, 0], "radius": radius, "material": {**GLASS, **material}}


def cube(low: float, high: float, **material: Any) -> dict[str, Any]:
    return {"type": "box", "min": [low] * 3, "max": [high] * 3, "material": {**GLASS, **material}}


CUBE = {
    "vertices": [[i & 1, i >> 1 & 1, i >> 2] for i in range(8)],
    "faces": [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]],
}
SOLIDS: dict[str, dict[str, Any]] = {
    "sphere": {"type": "sphere", "center": [0.2, 0, -0.1], "radius": 0.9},
    "ellipsoid": {"type": "ellipsoid", "center": [0, 0.1, 0], "radii": [0.5, 1, 0.8]},
    "box": {"type": "box", "min": [-0.5, -0.7, -0.4], "max": [0.8, 0.3, 0.9]},
    "cylinder": {"type": "cylinder", "p0": [-0.5, 0, 0], "p1": [0.6, 0.4, 0.2], "radius": 0.6, "caps": True},
    "cone": {"type": "cone", "p0": [0, -0.9, 0], "r0": 1.0, "p1": [0.2, 1, 0.1], "r1": 0.1, "caps": True},
    "mesh": {"type": "mesh", **CUBE},
    "plane": {"type": "plane", "point": [0.1, 0.2, 0], "normal": [1, 2, -1]},
    "quadric": {"type": "quadric", "coefficients": [1, 2, 3, 0.1, 0.2, 0.3, 0.1, 0.2, 0.1, -0.8]},
    "endless quadric": {"type": "quadric", "coefficients": [1, 0, 2, 0, 0.1, 0, 0.1, 0, 0, -0.5]},
}
TRANSFORMS: dict[str, list[dict[str, Any]]] = {
    "in place": [],
    "moved": [{"scale": 1.3}, {"rotate": [[1, 2, 3], 50]}, {"translate": [0.2, -0.1, 0.3]}],
    "mirrored": [{"rotate": [[1, -1, 0], 70]}, {"scale": [-1.1, 1.1, 1.1]}],
    "squeezed": [{"scale": [1, 0.5, 1.2]}, {"rotate": ["y", 20]}, {"translate": [0, 0.3, 0]}],
}
# a plane takes no transform, and caps must stay round
POSSIBLE = [(name, transform) for name in SOLIDS for transform in TRANSFORMS
            if (name, transform) not in (("cylinder", "squeezed"), ("cone", "squeezed"))
            and (name != "plane" or transform == "in place")]  # fmt: skip


@pytest.mark.parametrize(("name", "transform"), POSSIBLE)
def test_a_point_is_inside_where_rays_leave(name: str, transform: str) -> None:
    """The first surface that a ray from inside a convex solid meets is left, and from outside entered."""
    keys = SOLIDS[name]
    if TRANSFORMS[transform]:
        keys = {**keys, "transform": TRANSFORMS[transform]}
    scene = load_dict({"shapes": [keys]})
    rng = np.random.default_rng(3)
    points = rng.uniform(-1.5, 1.5, (2000, 3))
    directions = unit(rng.uniform(-1, 1, (2000, 3)) - points)
    hits = ENGINES["oracle64"].intersect(scene, points, directions)
    hits_back = ENGINES["oracle64"].intersect(scene, points, -directions)
    leaves = np.where(hits.primitive >= 0, np.einsum("ij,ij->i", hits.normal, directions) > 0,
                      np.einsum("ij,ij->i", hits_back.normal, -directions) > 0)  # fmt: skip
    found = count_inside(scene.shapes[0], points)
    met = (hits.primitive >= 0) | (hits_back.primitive >= 0)
    assert met.sum() > 400 and leaves.any() and not leaves.all()
    assert np.array_equal(found[met], leaves[met].astype(int))


def test_open_shapes_hold_what_lies_between_their_ends() -> None:
    tube = {"type": "cylinder", "p0": [0, 0, 0], "p1": [0, 2, 0], "radius": 1}
    bowl = {"type": "paraboloid", "apex": [0, 0, 0], "axis": [0, 3, 0], "focal": 0.25, "height": 1}
    ball = [1, 1, 1, 0, 0, 0, 0, 0, 0, -1]
    cut = {"type": "quadric", "coefficients": ball, "clip": [[-2, -2, -2], [2, 0, 2]]}
    sheet = {"type": "polygon", "points": [[-1, 0, -1], [1, 0, -1], [0, 0, 1]]}
    disk = {"type": "disk", "center": [0, 0, 0], "normal": [0, 1, 0], "radius": 1}
    shapes = load_dict({"shapes": [tube, bowl, cut, sheet, disk]}).shapes
    points = np.array([[0, 0.5, 0], [0, 2.5, 0], [0, -0.5, 0], [0.9, 0.5, 0]])
    found = [count_inside(shape, points).tolist() for shape in shapes]
    assert found == [[1, 0, 0, 1], [1, 0, 0, 0], [0, 0, 1, 0], [0] * 4, [0] * 4]


def test_a_mesh_counts_how_often_it_winds_around_a_point() -> None:
    """Hollow where an inner wall is turned round, twice where a second body lies in the first."""
    outer, small = np.array(CUBE["vertices"]) * 4.0 - 2, np.array(CUBE["vertices"]) - 0.5
    faces = [np.array(face) for face in CUBE["faces"]]
    points = [[0, 0, 0], [1.5, 0.1, 0.2], [3, 0, 0], [np.nan, 0, 0], [np.inf, 0, 0]]
    for inner, expected in (([face[::-1] + 8 for face in faces], 0), ([face + 8 for face in faces], 2)):
        mesh = {"type": "mesh", "vertices": np.concatenate([outer, small]).tolist(),
                "faces": [face.tolist() for face in [*faces, *inner]]}  # fmt: skip
        shape = load_dict({"shapes": [mesh]}).shapes[0]
        assert count_inside(shape, np.array(points)).tolist() == [expected, 1, 0, 0, 0]


def test_the_lists_rays_start_with() -> None:
    """Larger boxes first, whatever the order of shapes; equal materials are one medium, checkered or not."""
    shapes = [sphere(0, 1, ior="ice"), cube(-3, 3, ior="water"), sphere(0, 2), sphere(1.6, 0.3)]
    flat = flatten(load_dict({"shapes": shapes}))
    assert flat.media is not None
    ice, water, glass = 0, 1, 2
    assert flat.materials["medium"].tolist() == [ice, water, glass]
    points = np.array([[0, 0, 0], [1.7, 0, 0], [2.5, 0, 0], [9, 0, 0], [np.nan, 0, 0]], np.float32)
    expected = [[water, glass, ice], [water, glass, glass], [water], [], []]
    lists = flat.media.lists(points)
    assert [[m for m in row if m >= 0] for row in lists.tolist()] == expected
    for point, row in zip(points, lists, strict=True):
        assert np.array_equal(flat.media.lists(point[None])[0], row)


@pytest.mark.parametrize(
    "camera",
    [
        {"near": 2.5},
        {"near": 0.5, "mirror": True, "shift": (3.0, -7.0)},
        {"type": "orthographic", "size": 3.0, "near": 1.0, "shift": (-2.0, 1.0)},
        {"aperture": 2.0, "focus": 9.0},
        {"near": 2.5, "filter": "mitchell"},
        {"aperture": 2.0, "focus": 3.0, "near": 5.0},
        {"type": "orthographic", "size": 3.0, "near": 1.0, "aperture": 0.5},
    ],
)
def test_camera_rays_start_between_the_corners(camera: dict[str, Any]) -> None:
    view = Camera(origin=(40.0, -3.0, 7.0), target=(1.0, 2.0, -5.0), width=60, height=40, **camera)
    record = flatten_camera(view, spp=4, jitter=3)
    origins = generate(record, np.arange(60 * 40, dtype=np.uint32)).rays.origin.T
    corners = near_corners(record)
    low, high, size = corners.min(axis=0), corners.max(axis=0), np.ptp(corners)
    assert (np.abs(origins.min(axis=0) - low) < 0.02 * size).all()  # half a pixel of 60
    assert (np.abs(origins.max(axis=0) - high) < 0.02 * size).all()
    assert (origins >= low - 1e-5 * 45).all() and (origins <= high + 1e-5 * 45).all()


def test_media_that_come_near_are_told_from_the_others() -> None:
    media = flatten(load_dict({"shapes": nested(3)})).media
    assert media is not None
    edge = float(media.high[:, 0].max())
    plane, x = np.array([[0.0, -1, -1], [0, 1, -1], [0, -1, 1], [0, 1, 1]]), np.array([edge, 0, 0])
    assert media.near(plane + x)
    assert media.near(plane + (1 + 1e-6) * x)
    assert not media.near(plane + 1.001 * x)


def test_a_checker_makes_no_other_medium() -> None:
    material = {**GLASS, "color": {"type": "checker"}}
    pane = {"type": "disk", "center": [0, 0, 0], "normal": [0, 1, 0], "radius": 0.5, "material": material}
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": material}
    with pytest.warns(clrt.ClrtWarning, match="encloses nothing"):
        flat = flatten(load_dict({"shapes": [pane, ball]}))
    assert len(flat.materials) == 2 and flat.materials["medium"].tolist() == [0, 0]


@pytest.mark.parametrize("other", [{"divisions": 8}, {"size": 2.0}, {"colors": [0.1, 0.9]}])
def test_checkers_that_differ_are_media_that_differ(other: dict[str, Any]) -> None:
    """Also by what their shapes do not look at: equal materials are one medium, and only these."""
    checkers = [{"type": "checker"}, {"type": "checker", **other}]
    shapes = [{"type": "sphere", "center": [0, 0, 0], "radius": r, "material": {**GLASS, "color": checker}}
              for r, checker in zip((1, 0.5), checkers, strict=True)]  # fmt: skip
    flat = flatten(load_dict({"shapes": shapes}))
    assert flat.materials["medium"].tolist() == [0, 1]


def test_media_are_as_many_as_different_materials_let_light_in() -> None:
    rng = np.random.default_rng(31)
    choices: dict[str, list[Any]] = {
        "color": [0.5, [0.5, 0.5, 0.5], {"type": "checker"}, {"type": "checker", "divisions": 4}],
        "shininess": [10, 20], "ior": [1.3, "water"], "priority": [0, 1], "transmission": [0.0, 0.5],
    }  # fmt: skip
    for _ in range(50):
        drawn = [{key: some[rng.integers(len(some))] for key, some in choices.items()} for _ in range(12)]
        shapes = [sphere(3 * i, 1, **material) for i, material in enumerate(drawn)]
        scene = load_dict({"shapes": shapes})
        used = [scene.material_of(shape) for shape in scene.shapes]
        media = flatten(scene).materials["medium"][flatten(scene).primitives["material"]]
        pairs = {pair for pair in zip(media.tolist(), used, strict=True) if pair[0] >= 0}
        clear = {material for material in used if material.kt > 0}
        assert len(pairs) == len(clear) == len({number for number, _ in pairs})


APART = [sphere(-3, 1, ior="water"), sphere(0, 1), cube(2, 3)]
FLOOR = {"type": "plane", "point": [0, -1.1, 0], "normal": [0, 1, 0]}
COAT = {"fresnel": True, "transmission": 0}


@pytest.mark.parametrize(
    ("shapes", "needed"),
    [
        (APART, False),
        ([*APART, {**FLOOR, "material": COAT}], False),  # a half-space of which all glass is clear
        ([*APART, {**FLOOR, "point": [0, -0.5, 0]}], False),  # what reflects no Fresnel asks for no index
        ([*APART, {**FLOOR, "point": [0, -0.5, 0], "material": COAT}], True),
        ([*APART, sphere(0.5, 0.2)], True),
        ([*APART, sphere(0.5, 0.2, transmission=0)], True),
        ([*APART, sphere(0.5, 0.2, fresnel=False, diffuse=1.0)], False),
        ([sphere(0, 1, absorption=[0, 0, 1e-9])], True),
        ([sphere(0, 1, thin=True, absorption=1)], False),
        ([{"type": "mesh", **CUBE, "material": GLASS}], True),  # who knows what lies within it
        ([FLOOR], False),
        ([{**FLOOR, "material": GLASS}], True),
    ],
)
@pytest.mark.filterwarnings("ignore:.*a surface makes light")
def test_lists_are_carried_where_they_matter(shapes: list[dict[str, Any]], needed: bool) -> None:
    scene = load_dict({"shapes": shapes})
    assert flatten(scene).media_places == (layout.MEDIA if needed else 0)
    counted = load_dict({"shapes": shapes, "conformance": "spd"})
    assert flatten(counted).media_places == 0


@pytest.mark.filterwarnings("ignore:.*a surface makes light")
def test_where_they_do_not_matter_they_change_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    tint = {"fresnel": False, "transmission": 0.8, "reflection": 0.1, "transmission_color": [1, 0.8, 0.6]}
    shapes = [sphere(-3, 1, ior="water"), sphere(0, 1), cube(2, 3, **tint), {**FLOOR, "material": COAT}]
    camera = {"origin": [0.1, 0.2, 0.3], "target": [1, -0.1, 0.2], "fov": 100, "width": 64, "height": 48}
    scene = load_dict({"shapes": shapes, "camera": camera, "ambient": 0.3,
                       "lights": [{"type": "point", "position": [1, 5, 3]}], "background": 0.5})  # fmt: skip
    without = clrt.render(scene)
    monkeypatch.setattr(clrt.flatten.flatten, "needs_lists", lambda *_: True)
    assert flatten(scene).media_places == layout.MEDIA
    with_lists = clrt.render(scene)
    assert with_lists.hash == without.hash and with_lists.stats["rays"] == without.stats["rays"]


@pytest.mark.filterwarnings("ignore:.*a surface makes light")
def test_counted_rays_meet_every_surface() -> None:
    """As the published counts have it, also those that lists of media would hide."""
    ray = [[0.1, 0.2, -5]], [[0, 0, 1]]
    shapes = [sphere(0, 2, fresnel=False, transmission=1.0), sphere(0, 1, fresnel=False, transmission=1.0)]
    hits = []
    for conformance in ("none", "spd"):
        scene = load_dict({"shapes": shapes, "conformance": conformance, "max_depth": 4})
        ours, theirs = (engine.radiance(scene, *ray)[1] for engine in ENGINES.values())
        assert ours == theirs
        hits.append(ours["hits"])
    # seen are the outer ball's two surfaces; counted are four, and what their reflections meet
    assert hits[0] == 2 and hits[1] > 4


def nested(n: int) -> list[dict[str, Any]]:
    return [sphere(0, 1 + 0.1 * k, ior=1 + 0.01 * k, reflection=0.0) for k in range(n)]


def test_lists_that_are_too_short_are_refused() -> None:
    inward = np.array([[0, 0, -5]]), np.array([[0, 0, 1]])
    outward = np.zeros((1, 3)), inward[1]
    fits = clrt.Tracer(load_dict({"shapes": nested(8), "background": 1.0, "max_depth": 20}))
    share = np.prod([1 - (0.01 / (2 + 0.01 * (2 * k + 1))) ** 2 for k in range(7)])
    assert fits.radiance(*outward)[0][0] == pytest.approx(share * (1 - (0.07 / 2.07) ** 2), abs=2e-6)
    for rays in (inward, outward):
        scene = load_dict({"shapes": nested(9), "max_depth": 20}, source="onion.toml")
        with pytest.raises(clrt.LimitError, match=r"^onion\.toml: shapes: .* more than 8 media"):
            clrt.Tracer(scene).radiance(*rays)
    # rays that do not come so deep are fine, and a refused picture leaves no mark
    tracer = clrt.Tracer(load_dict({"shapes": nested(9), "max_depth": 20}))
    with pytest.raises(clrt.LimitError):
        tracer.radiance(*inward)
    tracer.radiance(inward[0], inward[0])


OVERLAPPING = {
    "spheres": ([sphere(0, 1), sphere(1, 1, ior="water")], True),
    "one in the other": ([sphere(0, 1), sphere(0.2, 0.5, ior="water")], False),
    "of one medium": ([sphere(0, 1), sphere(1, 1)], False),
    "of two priorities": ([sphere(0, 1), sphere(1, 1, ior="water", priority=1)], False),
    "side by side": ([cube(0, 1), cube(1, 2, ior="water")], False),
    "with a face in common": ([cube(-1, 1), {**cube(-0.5, 0.5, ior="water"), "max": [0.5, 0.5, 1]}], False),
    "sticking out": ([cube(-1, 1), {**cube(-0.5, 0.5, ior="water"), "max": [0.5, 0.5, 1.2]}], True),
    "afloat": ([sphere(0, 1), {**FLOOR, "point": [0, 0.5, 0], "material": WATER}], True),
    "mesh": ([{"type": "mesh", **CUBE, "material": GLASS}, sphere(0, 0.4, ior="water")], True),
}


@pytest.mark.parametrize("name", OVERLAPPING)
@pytest.mark.parametrize("order", [1, -1])
def test_overlaps_of_one_priority_are_warned_of(name: str, order: int) -> None:
    shapes, warned = OVERLAPPING[name]
    scene = load_dict({"shapes": shapes[::order]})
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", clrt.ClrtWarning)
        flatten(scene)
    said = [str(warning.message) for warning in told]  # of a common face another one tells: test_flush.py
    assert [text for text in said if "with a piece of its surface" not in text] == (
        ["shapes[0]: overlaps shapes[1], a medium of the same priority 0: where both are, the one that a ray "
         "entered last counts; give one a higher priority"] if warned else [])  # fmt: skip


def test_the_exponential_function() -> None:
    """Kernels and twin alike: within 1.3e-7 of e^x, 1 at 0, and 0 where precision ends."""
    ends = [0, 87, 88, np.inf, np.nan]
    x = -np.concatenate([np.linspace(0, 90, 1 << 16), np.logspace(-12, 2, 1 << 14), ends]).astype(np.float32)
    device = Device()
    head = "__kernel void exponentials(__global const float *x, __global float *out)"
    body = "{ const uint i = get_global_id(0); out[i] = exponential(x[i]); }"
    source = f"{device.kernels.source}\n{head}\n{body}\n"
    found, _ = _run(device, source, "exponentials", len(x), np.empty_like(x), device.upload(x))
    assert np.array_equal(found, exponential(x))
    kept = x >= -87
    exact = np.exp(x[kept].astype(np.float64))
    assert np.abs(found[kept] / exact - 1).max() < 1.3e-7
    assert (found[~kept] == 0).all() and found[0] == 1 and (np.diff(found[: 1 << 16]) <= 0).all()
