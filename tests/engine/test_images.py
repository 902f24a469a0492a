"""Pictures on surfaces: where they lie, what they show, and that what is plain costs no bit."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
import pytest

import clrt
from clrt.flatten.flatten import flatten
from clrt.formats import load_dict
from tests.pictured import image, looked_at, put, sheet, smooth_pictures
from validation.oracle64 import radiance64, render64
from validation.twin import scenes as twin_scenes
from validation.twin.geometry import Rays, nearest_hit
from validation.twin.surface import surface_at

TWO = np.array([[[1.0], [2.0]], [[3.0], [4.0]]]) * np.ones(3)
WRAPS = {"repeat": oiio.Wrap.Periodic, "clamp": oiio.Wrap.Clamp, "mirror": oiio.Wrap.Mirror}
CAMERA = {"origin": [0, -5, 2], "target": [0, 0, 0], "up": [0, 0, 1], "width": 24, "height": 18}
LIGHT = {"type": "point", "position": [3, -4, 5]}


def place(shape: dict[str, Any], point: Any, folder: Path) -> np.ndarray:
    """u and v of a shape at a point, from the twin, whose bits are the kernels'."""
    put(folder / "a.exr", TWO)
    table = {"shapes": [{**shape, "material": {"color": image("a.exr")}}]}
    flat = flatten(clrt.load_dict(table, folder=folder))
    away = np.asarray(shape.get("normal", [0, 0, 1]), np.float32) if "radii" not in shape else None
    center = np.asarray(shape.get("center", [1, 2, point[2]]), float)
    way = np.asarray(point, float) - center
    way = way / np.linalg.norm(way) if shape["type"] != "disk" else np.asarray(away, float)
    rays = Rays(
        np.asarray(point + way, np.float32)[:, None],
        np.asarray(-way, np.float32)[:, None],
        np.full(1, np.inf, np.float32),
    )
    with np.errstate(all="ignore"):
        return np.asarray(surface_at(flat, rays, nearest_hit(flat, rays)).place[:, 0])


def test_places_are_the_published_ones(tmp_path: Path) -> None:
    """docs/model.md, "Numbers to test against", 27."""
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
    assert place(ball, [0.48, 0.64, 0.6], tmp_path) == pytest.approx((0.1475836, 0.2951672), abs=2e-7)
    egg = {"type": "ellipsoid", "center": [0, 0, 0], "radii": [1, 1, 1]}
    assert place(egg, [0.48, 0.64, 0.6], tmp_path) == pytest.approx((0.1475836, 0.2951672), abs=2e-7)
    disk = {"type": "disk", "center": [0, 0, 0], "normal": [0, 0, 1], "radius": 1}
    assert place(disk, [0.3, -0.4, 0], tmp_path) == pytest.approx((0.5, 0.8524164), abs=2e-7)
    rod = {"type": "cylinder", "p0": [1, 2, 3], "p1": [1, 2, 5], "radius": 0.5}
    assert place(rod, [0.7, 1.6, 3.5], tmp_path) == pytest.approx((0.6475836, 0.25), abs=5e-7)


def test_lookups_are_the_published_ones(tmp_path: Path) -> None:
    """Numbers 28 and 29. Rays are float32, so u and v are off by 1e-7."""
    put(tmp_path / "a.exr", TWO)
    plain = {wrap: sheet(tmp_path, image("a.exr", wrap=wrap)) for wrap in WRAPS}
    assert looked_at(plain["repeat"], 0.4, 0.3)[0] == pytest.approx(1.5 * np.ones(3), abs=1e-6)
    for (u, v), expected in {(1.1, 0.3): (1.5, 2.2, 2.2), (-0.2, 1.3): (2.1, 3.0, 2.8)}.items():
        found = [looked_at(plain[wrap], u, v)[0, 0] for wrap in WRAPS]
        assert found == pytest.approx(expected, abs=2e-6)
    put(tmp_path / "b.png", np.array([[[0], [128]], [[255], [64]]]) * np.ones(3, int), "uint8")
    coded = sheet(tmp_path, image("b.png"))
    assert looked_at(coded, 0.4, 0.3)[0] == pytest.approx(0.129820419 * np.ones(3), abs=1e-7)
    # encodings, against their own formulas
    linear = looked_at(sheet(tmp_path, image("b.png", encoding="linear")), 0.75, 0.25)[0, 0]
    assert linear == np.float32(128 / 255)
    curved = looked_at(sheet(tmp_path, image("a.exr", encoding="srgb")), 0.25, 0.25)[0, 0]
    assert curved == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("wrap", WRAPS)
@pytest.mark.parametrize("filtered", ["linear", "nearest"])
def test_lookups_are_those_of_openimageio(tmp_path: Path, wrap: str, filtered: str) -> None:
    """Its TextureSystem, without mip levels, at places in and around the picture.

    Its weights are floats of texel coordinates up to 40, so off by 40 * 2^-24; texels differ by 1 at most.
    """
    random = np.random.default_rng(7)
    put(tmp_path / "a.exr", random.random((7, 13, 3)))
    u, v = random.uniform(-1.9, 2.9, (2, 400)).astype(np.float32)
    system = oiio.TextureSystem(False)
    how = oiio.TextureOpt()
    how.swrap = how.twrap = WRAPS[wrap]
    how.mipmode = oiio.MipMode.NoMIP
    how.interpmode = oiio.InterpMode.Bilinear if filtered == "linear" else oiio.InterpMode.Closest
    # v as the plane makes it of y, which rounds
    seen = (np.float32(1) - (np.float32(1) - v)).astype(np.float32)
    file = str(tmp_path / "a.exr")
    expected = np.array([
        system.texture(file, how, float(s), float(t), 0, 0, 0, 0, 3) for s, t in zip(u, seen, strict=True)
    ])  # fmt: skip
    found = looked_at(sheet(tmp_path, image("a.exr", wrap=wrap, filter=filtered)), u, v)
    off = np.abs(found - expected).max(axis=1)
    # at the border of two texels rounding decides
    near = np.minimum(abs(u * 13 - np.round(u * 13)), abs(seen * 7 - np.round(seen * 7))) < 1e-4
    assert off[~near].max() < 1e-5 if filtered == "nearest" else off.max() < 1e-5


def plain_scene(folder: Path, shown: bool) -> clrt.Scene:
    """Every colour as a number, or as a picture of it that is bent by a flat map."""
    colors = {
        "color": (0.25, 0.5, 0.75), "highlight_color": (0.5, 1, 0.25), "reflection_color": (1, 0.5, 0.75),
        "transmission_color": (0.125, 0.75, 1), "emission": (0.25, 2, 0.5),
    }  # fmt: skip
    keys: dict[str, Any] = dict(colors)
    if shown:
        for name, color in colors.items():
            put(folder / f"{name}.exr", np.full((3, 5, 3), color))
            keys[name] = image(f"{name}.exr", scale=[3, -2], wrap="mirror")
        put(folder / "flat.png", np.full((4, 4, 3), (128, 128, 255)), "uint8")
        keys["normal_map"] = {"file": "flat.png", "scale": 3.0}
    keys |= {"diffuse": 0.4, "specular": 0.3, "reflection": 0.3, "fresnel": "schlick"}
    glass = keys | {"thin": True, "transmission": 0.3}
    uv = [[0, 0], [1, 0], [1, 1], [0, 1]]
    corners = [[-2, 1, -1], [0, 1, -1], [0, 1.2, 1], [-2, 1.2, 1]]
    mesh = {"type": "mesh", "vertices": corners, "faces": [[0, 1, 2], [0, 2, 3]], "uv": uv}
    return clrt.load_dict({
        "camera": CAMERA, "lights": [LIGHT], "ambient": 0.1, "shadow": "tinted", "shapes": [
            {"type": "plane", "point": [0, 0, -1], "normal": [0, 0, 1], "material": keys},
            {"type": "sphere", "center": [0, 0, 0], "radius": 0.9, "material": glass},
            {"type": "cylinder", "p0": [1.5, 0, -1], "p1": [1.5, 0, 1], "radius": 0.4, "caps": True,
             "material": keys},
            {**mesh, "material": keys},
        ],
    }, folder=folder)  # fmt: skip


def test_one_colour_and_a_flat_map_give_the_bits_of_what_they_replace(tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", clrt.ClrtWarning)
        shown, plain = (clrt.render(plain_scene(tmp_path, shown)) for shown in (True, False))
    assert np.array_equal(shown.pixels, plain.pixels) and shown.pixels.std() > 0.1


def test_a_map_that_leans_changes_the_light(tmp_path: Path) -> None:
    """On a floor, green towards the top row of the picture, which is at y = 1: N' = (0, y, z)."""
    put(tmp_path / "lean.exr", np.full((2, 2, 3), (0.5, 0.9, 0.8)))
    floor = {"type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1]}
    lamp = {"type": "directional", "direction": [0, -1, -1]}
    material = {"color": 1, "normal_map": {"file": "lean.exr"}}
    table = {"lights": [lamp], "shapes": [{**floor, "material": material}]}
    with clrt.Tracer(clrt.load_dict(table, folder=tmp_path)) as tracer:
        seen = tracer.radiance([[0.3, 0.2, 1]], [[0.0, 0.0, -1.0]])[0][0, 0]
    normal = np.array([0, 0.8, 0.6])
    assert seen == pytest.approx(normal @ np.array([0, 1, 1]) / np.sqrt(2), rel=1e-6)


@pytest.mark.parametrize(("texel", "scale", "lit"), [
    ((0.5, 0.5, 0.5), 1.0, 0.6),  # of length 0: the surface's own normal
    ((0.5, 0.9, 0.5), 1e-25, 0.8),  # its square is below, and above, the range of float
    ((0.5, 0.9, 0.5), 1e25, 0.8),
])  # fmt: skip
def test_a_normal_of_any_length(texel: Any, scale: float, lit: float, tmp_path: Path) -> None:
    """It lies in the floor, or does not lean: the light falls on it at 3 : 4."""
    put(tmp_path / "lean.exr", np.full((2, 2, 3), texel))
    bumps = {"file": "lean.exr", "scale": scale}
    floor = {"type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1]}
    shape = {**floor, "material": {"color": 1, "normal_map": bumps}}
    table = {"lights": [{"type": "directional", "direction": [0, -4, -3]}], "shapes": [shape]}
    scene = clrt.load_dict(table, folder=tmp_path)
    rays = [[0.3, 0.2, 1]], [[0.0, -0.1, -1.0]]
    with clrt.Tracer(scene) as tracer:
        assert tracer.radiance(*rays)[0][0] == pytest.approx(lit, rel=1e-6)
    assert radiance64(scene, *rays)[0][0] == pytest.approx(lit, rel=1e-6)


@pytest.mark.parametrize("filtered", ["linear", "mipmap"])
def test_a_map_with_a_placement_has_the_bits_of_one_that_lies_as_a_picture_does(
    tmp_path: Path, filtered: str
) -> None:
    smooth_pictures(tmp_path)
    put(tmp_path / "grey.exr", np.full((32, 48, 3), 0.5))
    floor = {"type": "plane", "point": [0, 0, -1], "normal": [0, 0, 1]}
    own = {"scale": [0.7, -1.3], "offset": [0.2, 0.6], "wrap": "mirror", "filter": filtered}
    pictures = []
    for color, placement in (
        (image("grey.exr", **own), None), (0.5, own), (image("grey.exr", scale=[4, 4]), own), (0.5, None),
    ):  # fmt: skip
        bumps = {"file": "normals.exr"} | ({} if placement is None else {"placement": placement})
        shape = {**floor, "material": {"color": color, "normal_map": bumps}}
        table = {"camera": CAMERA, "lights": [LIGHT], "shapes": [shape]}
        pictures.append(clrt.render(clrt.load_dict(table, folder=tmp_path)).pixels)
    assert np.array_equal(pictures[0], pictures[1]) and np.array_equal(pictures[0], pictures[2])
    assert np.abs(pictures[0] - pictures[3]).max() > 0.1


def test_the_oracle_sees_the_same(tmp_path: Path) -> None:
    """All shapes and colours, bent normals among them; what differs lies at edges of shapes and texels.

    Measured: a median of 2.5e-7 of the light, 99 % of the pixels below 1.05e-3.
    """
    smooth_pictures(tmp_path)
    light = {"ambient": [0.2, 0.25, 0.3], "background": [0.1, 0.2, 0.4], "lights": twin_scenes._LIGHTS}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", clrt.ClrtWarning)
        table = {**light, "camera": twin_scenes._CAMERA, **twin_scenes._pictures()}
        scene = load_dict(table, folder=tmp_path)
        size = {"width": 36, "height": 27}
        ours, theirs = clrt.render(scene, **size).pixels, render64(scene, **size).pixels
    off = np.abs(ours - theirs).max(axis=2) / (theirs.max(axis=2) + 0.05)
    assert np.median(off) < 1e-5 and np.mean(off < 2e-3) > 0.97


def test_faces_of_a_mesh_with_a_picture_are_fans(tmp_path: Path) -> None:
    put(tmp_path / "a.exr", TWO / 4)
    points, uv = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 2, 0]], [[0, 0], [1, 0], [1, 1], [0, 1]]
    mesh = {"type": "mesh", "vertices": points, "uv": uv, "material": {"color": image("a.exr")}}
    hashes = {
        flatten(clrt.load_dict({"shapes": [{**mesh, "faces": faces}]}, folder=tmp_path)).hash
        for faces in ([[0, 1, 2, 3]], [[0, 1, 2], [0, 2, 3]])
    }
    assert len(hashes) == 1


@pytest.mark.parametrize("count", [4, 5])
def test_a_concave_face_of_a_mesh_shows_its_picture_where_it_is_and_nowhere_else(
    tmp_path: Path, count: int
) -> None:
    """An arrow's head, without and with a corner more, whose dent the fan about its first corner fills."""
    put(tmp_path / "a.exr", np.linspace(0, 1, 64)[None, :, None] * np.ones((64, 1, 3)))
    points = np.array([[1, 0, 0], [0, 2, 0], [-1, 0, 0], [0, 1, 0], [0.4, 0.6, 0]])[:count]
    inside, outside = ([0.7, 0.4], [-0.5, 0.7], [0, 1.5]), ([0, 0.5], [-0.3, 0.4], [0.2, 0.3])
    shape = {"type": "mesh", "vertices": points.tolist(), "faces": [list(range(count))],
             "uv": ((points[:, :2] + 1) / 2).tolist()}  # fmt: skip
    material = {"diffuse": 0, "emission": image("a.exr", wrap="clamp")}
    table = {"background": [7, 7, 7], "shapes": [{**shape, "material": material}]}
    places = np.array([*inside, *outside])
    origins = np.c_[places, np.full(6, 3.0)]
    with clrt.Tracer(clrt.load_dict(table, folder=tmp_path)) as tracer:
        seen = tracer.radiance(origins, np.tile([0.0, 0.0, -1.0], (6, 1)))[0][:, 0]
    # texels are linear in u from the middle of the first to that of the last
    expected = ((places[:3, 0] + 1) / 2 * 64 - 0.5) / 63
    assert seen[:3] == pytest.approx(expected, abs=1e-5)
    assert seen[3:].tolist() == [7, 7, 7]


def test_a_tracer_follows_other_pictures(tmp_path: Path) -> None:
    put(tmp_path / "a.exr", TWO / 4)
    put(tmp_path / "b.exr", TWO / 5)
    scene = sheet(tmp_path, image("a.exr")).replace({"camera": CAMERA})
    place_of = "shapes[0].material.emission"
    with clrt.Tracer(scene) as tracer:
        first = tracer.render().hash
        assert tracer.update(scene.replace({f"{place_of}.file": "b.exr"})) == "tables"
        other = tracer.render().hash
        assert tracer.update(scene.replace({f"{place_of}.wrap": "clamp"})) == "tables"
        assert tracer.update(scene.replace({place_of: 0.25})) == "tables"
        assert tracer.update(scene) == "tables"
        assert tracer.render().hash == first != other


@pytest.mark.parametrize("divisions", [1, 2, 3, 7, 8])
def test_a_globe_of_squares_has_no_further_one_at_its_seam(divisions: int) -> None:
    """Where u is exactly 1: seen along it by a camera whose middle column that is, the neighbour's colour."""
    squares = {"type": "checker", "colors": [0.0, 1.0], "divisions": divisions}
    globe = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {"color": squares, "diffuse": 1}}
    rows = np.linspace(-0.9, 0.9, 37)
    colors = []
    for x in (-0.0, 0.0, 1e-4, -1e-4):
        origins = np.stack([np.full(len(rows), x), rows, np.full(len(rows), 4.0)], axis=1)
        table = {"ambient": 1, "shapes": [globe]}
        rays = origins, np.broadcast_to([0.0, 0.0, -1.0], origins.shape)
        with clrt.Tracer(clrt.load_dict(table)) as tracer:
            colors.append(tracer.radiance(*rays)[0][:, 0])
        assert np.allclose(colors[-1], radiance64(clrt.load_dict(table), *rays)[0][:, 0])
    right, left = colors[2:]
    assert all(np.array_equal(line, right) or np.array_equal(line, left) for line in colors[:2])
