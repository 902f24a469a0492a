"""Normal maps against Mitsuba's own `normalmap`: on its rectangle, its sphere and a mesh of a file."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from tests.pictured import put, smooth_pictures
from validation.oracle64 import render64
from validation.oracles import handed_on

RAYS = """
import json, sys
import numpy as np
import mitsuba as mi
mi.set_variant("scalar_rgb")
given = json.load(open(sys.argv[1]))
for shape in given.values():
    if "to_world" in shape:
        shape["to_world"] = mi.ScalarTransform4f(shape["to_world"])
    if isinstance(shape.get("bsdf"), dict) and "to_uv" in shape["bsdf"]["normalmap"]:
        shape["bsdf"]["normalmap"]["to_uv"] = mi.ScalarTransform4f(shape["bsdf"]["normalmap"]["to_uv"])
lamps = [name for name in given if given[name]["type"] == "point"]
direct = mi.load_dict({"type": "direct", "emitter_samples": 1, "bsdf_samples": 0})
sampler = mi.load_dict({"type": "independent"})
rays = [mi.RayDifferential3f(mi.Ray3f(list(o), list(d))) for o, d in np.load(sys.argv[2])]
found = 0  # lamp by lamp, for the integrator draws one of them
for lamp in lamps:
    scene = mi.load_dict({"type": "scene", **{name: given[name] for name in given if name not in lamps},
                          "lamp": given[lamp]})
    found = found + np.array([direct.sample(scene, sampler, ray)[0] for ray in rays])
np.save(sys.argv[3], found)
"""
LAMPS = [([-1.0, 2.0, 6.0], [20.0, 5.0, 9.0]), ([2.5, 1.0, 5.0], [4.0, 16.0, 9.0])]
COLOR, DIFFUSE = [0.8, 0.7, 0.6], 0.9
UPSIDE_DOWN = [[1, 0, 0, 0], [0, -1, 0, 1], [0, 0, 1, 0], [0, 0, 0, 1]]
# of its rectangle v goes up with y; there the picture is turned over, so that it is not seen in a mirror
RECTANGLE = [[0.9, 0, 0.2, -2.3], [0, 1.1, 0, 0], [-0.3, 0, 0.6, 0], [0, 0, 0, 1]]
BALL = [[0, 0.8, 0, 0], [0, 0, 0.8, 0], [0.8, 0, 0, 0], [0, 0, 0, 1]]

OTHERS = {"left": [-1, 1, 1], "down": [1, -1, 1], "flat": [0, 0, 1]}  # faults: what the map's bands are times


def sail(path: Path) -> None:
    """A bent surface of 2 x 9 x 9 triangles with normals of its own, u to the right and v up."""
    y, x = np.mgrid[0:10, 0:10] / 9
    points = np.stack([1.4 + 1.8 * x, 2 * y - 1, 0.4 * np.sin(3 * x) + 0.2 * y * y], axis=-1).reshape(-1, 3)
    normals = np.stack([-1.2 * np.cos(3 * x) / 1.8, -0.2 * y, np.ones(x.shape)], axis=-1).reshape(-1, 3)
    lines = [f"v {a} {b} {c}" for a, b, c in points.tolist()]
    lines += [f"vt {a} {b}" for a, b in np.stack([x, y], axis=-1).reshape(-1, 2).tolist()]
    lines += [f"vn {a} {b} {c}" for a, b, c in normals.tolist()]
    for k in (10 * row + column + 1 for row in range(9) for column in range(9)):
        for face in ((k, k + 1, k + 11), (k, k + 11, k + 10)):
            lines.append("f " + " ".join(f"{at}/{at}/{at}" for at in face))
    path.write_text("\n".join(lines) + "\n", "utf-8")


def ours(folder: Path, file: str) -> clrt.Scene:
    u, v, _, middle = np.array(RECTANGLE)[:3].T
    corners = [(middle + a * u + b * v).tolist() for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    shapes: list[dict[str, Any]] = [
        {"type": "mesh", "vertices": corners, "faces": [[0, 1, 2], [0, 2, 3]],
         "uv": [[0, 1], [1, 1], [1, 0], [0, 0]]},
        {"type": "sphere", "center": [0, 0, 0], "radius": 1,
         "transform": np.array(BALL, float).tolist()},
        {"type": "mesh", "file": "sail.obj", "smooth": True},
    ]  # fmt: skip
    look = {"color": COLOR, "diffuse": DIFFUSE, "normal_map": {"file": file}}
    lights = [{"type": "point", "position": at, "intensity": light, "falloff": "inverse-square"}
              for at, light in LAMPS]  # fmt: skip
    return clrt.load_dict(
        {"camera": {"origin": [0, 0.5, 8], "target": [0, 0, 0], "fov": 42, "width": 96, "height": 40},
         "lights": lights, "ambient": 0.0, "shapes": [{**shape, "material": look} for shape in shapes]},
        folder=folder,
    )  # fmt: skip


def theirs(folder: Path, rays: np.ndarray) -> np.ndarray:
    bitmap = {"type": "bitmap", "filename": str(folder / "normals.exr"), "raw": True}
    matte = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [DIFFUSE * c for c in COLOR]}}
    plain = {"type": "normalmap", "flip_invalid_normals": False, "use_shadowing_function": False,
             "bsdf": matte}  # fmt: skip
    bent = {**plain, "normalmap": bitmap}
    given: dict[str, Any] = {
        "a": {"type": "rectangle", "to_world": RECTANGLE,
              "bsdf": {**plain, "normalmap": {**bitmap, "to_uv": UPSIDE_DOWN}}},
        "b": {"type": "sphere", "to_world": BALL, "bsdf": bent},
        "c": {"type": "obj", "filename": str(folder / "sail.obj"), "bsdf": bent},
    }  # fmt: skip
    for number, (at, light) in enumerate(LAMPS):
        intensity = {"type": "rgb", "value": [np.pi * band for band in light]}
        given[f"lamp{number}"] = {"type": "point", "position": at, "intensity": intensity}
    (folder / "scene.json").write_text(json.dumps(given))
    np.save(folder / "rays.npy", rays)
    files = [str(folder / name) for name in ("scene.json", "rays.npy", "found.npy")]
    subprocess.run([sys.executable, "-c", RAYS, *files], check=True, timeout=120)
    return np.asarray(np.load(files[2]))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("mitsuba", reason="needs the optional dependency clrt[validation]")
    path = tmp_path_factory.mktemp("normalmap")
    y, x = np.mgrid[0:32, 0:48] * np.array([2 * np.pi / 32, 2 * np.pi / 48])[:, None, None]
    leaning = np.stack([0.5 + 0.12 * np.sin(x), 0.5 + 0.12 * np.cos(2 * y), np.full(x.shape, 0.9)], axis=-1)
    put(path / "normals.exr", leaning)
    for name, bands in OTHERS.items():
        put(path / f"{name}.exr", 0.5 + (leaning - 0.5) * bands)
    sail(path / "sail.obj")
    return path


def test_normal_maps_are_those_of_mitsubas_own_plugin(folder: Path) -> None:
    """Where surfaces are seen and lit at moderate angles; and not with green or red the other way round."""
    found = {}
    for file in ("normals", *OTHERS):
        with clrt.Tracer(ours(folder, f"{file}.exr")) as tracer:
            image = tracer.render(layers=("shape", "position", "normal"))
            origins, directions = (rays.reshape(-1, 3) for rays in tracer.camera_rays())
        found[file] = image.pixels.reshape(-1, 3)
    layers = {name: values.reshape(len(origins), -1) for name, values in image.layers.items()}
    ways = [np.array(at) - layers["position"] for at, _ in LAMPS] + [-directions]
    cosines = [(way * layers["normal"]).sum(axis=1) / np.linalg.norm(way, axis=1) for way in ways]
    seen = np.min(cosines, axis=0) > 0.5
    picture = theirs(folder, np.stack([origins, directions], axis=1))
    for shape in range(3):
        here = seen & (layers["shape"][:, 0] == shape)
        off = {file: np.abs(pixels - picture)[here].max(axis=1) for file, pixels in found.items()}
        assert here.sum() > 200 and picture[here].mean() > 0.2
        # light is up to 1 and sums of a dozen float32 roundings, 6e-8 each; measured: 7.2e-7
        assert off["normals"].max() <= 2e-6, shape
        for file in OTHERS:
            assert np.median(off[file]) > 0.01, (shape, file)


@pytest.mark.parametrize("filtered", ["linear", "mipmap"])
def test_both_oracles_place_a_map_as_its_placement_says(
    tmp_path: Path, mitsuba: Any, filtered: str
) -> None:
    smooth_pictures(tmp_path)
    placement = {"scale": [0.7, -1.3], "offset": [0.2, 0.6], "wrap": "mirror", "filter": filtered}
    bumps = {"file": "normals.exr", "scale": 0.5, "placement": placement}
    color = {"type": "image", "file": "colors.exr", "scale": [4.0, 4.0]}
    floor = {"type": "plane", "point": [0, 0, -1], "normal": [0, 0, 1]}
    camera = {"origin": [0, -5, 2], "target": [0, 0, -1], "up": [0, 0, 1], "width": 32, "height": 24}
    table = {"camera": camera, "lights": [{"type": "point", "position": [3, -4, 5]}],
             "shapes": [{**floor, "material": {"color": color, "normal_map": bumps}}]}  # fmt: skip
    (tmp_path / "s.json").write_text(json.dumps(table))
    scene = clrt.load(tmp_path / "s.json")
    found = clrt.render(scene).pixels
    other = clrt.render(scene.replace({"shapes[0].material.normal_map.placement": None})).pixels
    assert np.abs(found - other).max() > 0.1
    for theirs in (render64(scene), mitsuba.render(handed_on(scene))):
        assert np.quantile(np.abs(found - theirs.pixels).max(axis=2), 0.99) < 2e-3
