"""Tiny frames of everything, for Oclgrind to watch every memory access of every kernel.

What it finds stands in its log, which must be empty after each test.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import clrt
import watched
from clrt.base.resources import kernel_folder
from clrt.device.device import Device
from clrt.engine.raymesh import RayMeshIntersector
from clrt.images.image import Image

pytestmark = pytest.mark.oclgrind

GLASS = {"diffuse": 0.1, "specular": 0.3, "reflection": 0.3, "transmission": 0.7, "fresnel": True}
WATER = {**GLASS, "ior": "water", "absorption": [0.1, 0.2, 0.3], "priority": 1}
MIRROR = {"color": [0.9, 0.6, 0.3], "specular": 0.5, "reflection": 0.5, "fresnel": "schlick"}
CHECKER = {"color": {"type": "checker"}}
MATT = {"emission": 0.1}
TETRAHEDRON = {
    "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "faces": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
}
SHAPES: dict[str, list[dict[str, Any]]] = {
    "spheres": [
        {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": GLASS},
        {"type": "sphere", "center": [1.4, 0.5, -1], "radius": 0.7, "transform": [{"scale": [1, 2, 1]}]},
        {"type": "ellipsoid", "center": [-1.3, 0, -0.5], "radii": [0.4, 0.9, 0.5], "material": MIRROR},
    ],
    "flat": [
        {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0], "material": CHECKER},
        {"type": "polygon", "points": [[-1, -1, 0], [1, -1, 0], [0, -0.4, 0], [0, 1, 0]], "material": MIRROR},
        {"type": "disk", "center": [1, 0.5, -1], "normal": [0, 0.2, 1], "radius": 0.6, "material": MATT},
        {"type": "box", "min": [-1.5, -1, -1.5], "max": [-0.7, 0.2, -0.7], "material": GLASS},
    ],
    "round": [
        {"type": "cylinder", "p0": [-1, -1, 0], "p1": [-1, 1, 0], "radius": 0.4, "caps": True},
        {"type": "cone", "p0": [0.5, -1, 0], "r0": 0.6, "p1": [0.5, 0.5, 0], "r1": 0, "material": MIRROR},
        {"type": "paraboloid", "apex": [1, 0, -1], "axis": [0, 1, 0], "focal": 0.2, "height": 1},
        {
            "type": "quadric", "coefficients": [1, -1, 1, 0, 0, 0, 0, 0, 0, -0.1],
            "clip": [[-1, -1, -1], [1, 1, 1]], "material": MATT,
        },
    ],
    "meshes": [
        {"type": "mesh", **TETRAHEDRON, "material": GLASS},
        {"type": "mesh", **TETRAHEDRON, "smooth": True, "transform": [{"translate": [-1.2, 0, 0]}]},
    ],
    "media": [
        {"type": "sphere", "center": [0, 0, 0], "radius": 6, "material": {**WATER, "priority": -1}},
        {"type": "box", "min": [-1.5, -1, -1], "max": [0.7, 0.5, 0.5], "material": GLASS},
        {"type": "sphere", "center": [0.5, 0, 0.3], "radius": 0.7, "material": WATER},
        {"type": "mesh", **TETRAHEDRON, "material": GLASS},
    ],
    "nothing": [],
    "spectra": [
        {"type": "sphere", "center": [0, 0, 0], "radius": 0.8, "material": {"fresnel": True, "ior": "BK7"}},
        {"type": "sphere", "center": [1, 0, 0], "radius": 0.6, "material": {"conductor": "gold"}},
    ],
}  # fmt: skip
LAYERS = ["direct", "reflection", "transmission", "generation_1", "emission", "ambient", "diffuse"]
LAYERS += ["highlight", "depth", "position", "normal", "shape"]
launched: set[str] = set()


@pytest.fixture(autouse=True)
def watch(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Nothing is hidden from Oclgrind, the kernels launched are recorded, and the log must stay empty."""
    for name, replacement in watched.PATCHES:
        monkeypatch.setattr(name, replacement)
    launch = Device.launch

    def recording(self: Device, name: str, *rest: Any, **options: Any) -> None:
        launched.add(name)
        launch(self, name, *rest, **options)

    monkeypatch.setattr(Device, "launch", recording)
    yield
    assert watched.findings()[:2000] == ""


def scene(shapes: str, **more: Any) -> clrt.Scene:
    table = {
        "max_depth": 2, "ambient": 0.2, "background": [0.1, 0.2, 0.3],
        "camera": {"origin": [0.3, 0.5, 4], "target": [0, 0, 0], "width": 9, "height": 7},
        "lights": [
            {"type": "point", "position": [3, 4, 5], "falloff": "inverse-square", "intensity": 20},
            {"type": "directional", "direction": [1, -2, -1]},
        ],
        "shapes": SHAPES[shapes],
    }  # fmt: skip
    return clrt.load_dict({**table, **more})


@pytest.mark.parametrize("shapes", SHAPES)
def test_frames(shapes: str):
    """Work-groups of 8 do not divide the queues, so that the idle items of the last one are watched too."""
    settings = clrt.Settings(local_size=8, lanes=8, tile=40)
    spectrum = {"bands": 4, "group": 3} if shapes == "spectra" else None
    layers = [*LAYERS, "bands", "xyz"] if spectrum else LAYERS
    image = clrt.render(scene(shapes, spectrum=spectrum), layers=layers, settings=settings)
    assert np.isfinite(image.pixels).all() and image.stats["rays"]["camera"] == 63


@pytest.mark.parametrize("shadow", ["opaque", "tinted"])
def test_a_frame_with_everything_that_costs_more(shadow: str, tmp_path: Path):
    Image(np.random.default_rng(1).random((4, 8, 3), np.float32)).save(tmp_path / "sky.exr")
    table = {"background": "sky.exr", "shadow": shadow, "ambient_samples": 3, "one_sided": "opaque"}
    camera = {"origin": [0.3, 0.5, 4], "target": [0, 0, 0], "width": 5, "height": 4, "spp": 4, "jitter": 7}
    made = clrt.load_dict(
        {**table, "max_depth": 1, "camera": camera, "lights": [{"type": "point", "position": [3, 4, 5]}],
         "shapes": SHAPES["spheres"] + SHAPES["flat"]}, folder=tmp_path,
    )  # fmt: skip
    assert np.isfinite(clrt.render(made).pixels).all()


def test_ambient_rays_and_callers_rays_in_media():
    """Lists of media that are handed on and read from the caller's origins, which lie in several."""
    made = scene("media", ambient_samples=2, max_depth=1)
    tracer = clrt.Tracer(made, settings=clrt.Settings(local_size=8, lanes=8, tile=40))
    assert np.isfinite(tracer.render(layers=["depth"]).pixels).all()
    origins = np.random.default_rng(3).normal(size=(21, 3))
    assert np.isfinite(tracer.radiance(origins, -origins)[0]).all()


def test_questions_about_rays():
    generator = np.random.default_rng(2)
    origins = generator.normal(size=(37, 3)) * 3
    directions = -origins + generator.normal(size=(37, 3)) * 0.3
    directions[5] = 0
    directions[6] = np.nan
    for shapes in ("spheres", "meshes"):
        tracer = clrt.Tracer(scene(shapes), settings=clrt.Settings(local_size=16))
        hits = tracer.intersect(origins, directions)
        assert (hits.primitive >= 0).any() and (hits.primitive[[5, 6]] == -1).all()
        assert np.array_equal(tracer.occluded(origins, directions), hits.primitive >= 0)
        assert tracer.radiance(origins, directions)[0].shape == (37, 3)
        patches = tracer.intersect(origins[:36].reshape(9, 4, 3), directions[:36].reshape(9, 4, 3), t_min=0.5)
        assert patches.normal.shape == (9, 4, 3)
        assert np.isfinite(tracer.occluded(origins[:1], directions, np.full(37, 9.0), np.arange(37.0))).all()


def test_what_rays_cross():
    generator = np.random.default_rng(2)
    origins = np.zeros((19, 3), np.float32) + generator.integers(-2, 3, (19, 3))
    directions = generator.integers(-1, 2, (19, 3)) - origins
    for shapes in ("spheres", "flat", "round", "meshes"):
        tracer = clrt.Tracer(scene(shapes, one_sided="opaque"), settings=clrt.Settings(tile=11))
        found = tracer.all_hits(origins, directions)
        assert np.array_equal(found.counts, tracer.count_hits(origins, directions)) and found.counts.any()


def test_all_hits_of_a_ray():
    mesh = trimesh.Trimesh(TETRAHEDRON["vertices"], TETRAHEDRON["faces"], process=False)
    ray = RayMeshIntersector(mesh, settings=clrt.Settings(local_size=16))
    origins = np.random.default_rng(4).normal(size=(21, 3)) * 2
    faces, _ = ray.intersects_id(origins, mesh.centroid - origins)
    inside = (origins > 0).all(axis=1) & (origins.sum(axis=1) < 1)
    assert len(faces) == 21 + np.count_nonzero(~inside)


@pytest.mark.parametrize("name", ["tent", "mitchell"])
def test_weighed_samples(name: str):
    camera = {"origin": [0.3, 0.5, 4], "target": [0, 0, 0], "width": 5, "height": 3, "spp": 4, "jitter": 7}
    made = scene("flat", max_depth=1, camera={**camera, "filter": name})
    image = clrt.render(made, layers=["diffuse"], settings=clrt.Settings(lanes=8, local_size=8, tile=24))
    assert np.isfinite(image.pixels).all() and image.stats["rays"]["camera"] == 60


def test_things_that_move():
    """Boxes of the tree are made anew, level by level, for spheres and for triangles."""
    side = np.linspace(-1, 1, 9)
    x, y = (array.reshape(-1) for array in np.meshgrid(side, side))
    corner = (np.arange(8)[:, None] * 9 + np.arange(8)).reshape(-1)
    faces = np.concatenate([corner[:, None] + [0, 1, 9], corner[:, None] + [1, 10, 9]]).tolist()
    sheet, bent = (np.stack([x, y, z * x], 1).tolist() for z in (0, 0.1))
    balls = [{"type": "sphere", "center": [k % 4 - 1.5, k // 4 - 1.5, 0], "radius": 0.3} for k in range(16)]
    made = scene("flat", max_depth=0)
    made = made.replace({"shapes": [{"type": "mesh", "vertices": sheet, "faces": faces}, *balls]})
    with clrt.Tracer(made, settings=clrt.Settings(lanes=8, local_size=8)) as tracer:
        moved = made.replace({"shapes[0].vertices": bent, "shapes[3].center": [0.6, -1.4, 0.1]})
        assert tracer.update(moved) == "refit"
        assert np.isfinite(tracer.render().pixels).all()


def test_every_kernel_was_watched():
    """Last in this file: it looks at what the tests above launched."""
    source = "".join(file.read_text() for file in kernel_folder().glob("*.cl"))
    assert launched == set(re.findall(r"__kernel\s+void\s+(\w+)", source))
