"""Layers of where a pixel's first ray hits: against rays and positions, and against Mitsuba's own."""

from __future__ import annotations

import json
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from tests.mitsuba_rooms import CHECKER, GREY, MATTE, NEAR, as_read, stock_room

BALLS: dict[str, Any] = {
    "lights": [{"type": "point", "position": [3, 5, 4]}],
    "shapes": [
        {"type": "sphere", "center": [-0.7, 0, 0], "radius": 1, "name": "left"},
        {"type": "sphere", "center": [0.9, 0.4, -1], "radius": 1},
        {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]},
    ],
}
CAMERA = {"origin": [1.5, 1.0, 5.0], "target": [0, 0.2, 0], "width": 48, "height": 36, "near": 0.75}
CAMERAS = {
    "perspective": {}, "orthographic": {"type": "orthographic", "size": 4.0},
    "wide and mirrored": {"fov": 110, "mirror": True, "shift": [3.5, -2.25], "near": 0.0},
    "lens": {"aperture": 0.2, "focus": 4.0},
}  # fmt: skip
GEOMETRY = ["depth", "z", "distance", "position"]
ROUNDED = 3e-6  # of the largest coordinate: ten roundings of float32


@pytest.fixture(scope="module")
def tracer() -> clrt.Tracer:
    return clrt.Tracer(clrt.load_dict({**BALLS, "camera": CAMERA}))


@pytest.mark.parametrize("name", CAMERAS)
def test_unprojected_z_is_the_position(name: str, tracer: clrt.Tracer) -> None:
    """p = o + z q, where q is the pixel's direction with q.d = 1; in float64."""
    given = {**CAMERA, **CAMERAS[name]}
    layers = tracer.render(camera=given, layers=GEOMETRY).layers
    origins, directions = (a.astype(np.float64) for a in tracer.camera_rays(given))
    eye, target = (np.array(given[key], float) for key in ("origin", "target"))
    forward = (target - eye) / np.linalg.norm(target - eye)
    hit = np.isfinite(layers["z"])
    assert 0.2 < hit.mean() < 1 or name == "orthographic"
    z, position = layers["z"].astype(float)[..., None], layers["position"].astype(float)
    way = directions / (directions @ forward)[..., None]
    start = origins - ((origins - eye) @ forward)[..., None] * way  # where z = 0: near is left out
    size = np.maximum(np.abs(position), np.abs(eye)).max(axis=2)[hit]
    if name in ("perspective", "wide and mirrored"):
        assert np.abs(start - eye).max() <= ROUNDED * np.abs(eye).max()
        start = np.broadcast_to(eye, start.shape)
    away = np.abs(start + np.where(hit[..., None], z, 0) * way - position).max(axis=2)[hit]
    assert (away <= ROUNDED * size * np.abs(way).max(axis=2)[hit] * 3).all()
    flat = given.get("type") == "orthographic"
    distance = z[..., 0] if flat else np.linalg.norm(position - eye, axis=2)
    assert (np.abs(layers["distance"] - distance)[hit] <= ROUNDED * size).all()
    for layer in ("depth", "z", "distance"):
        assert (np.isinf(layers[layer]) == ~hit).all()
    if name == "perspective":  # near is along the view
        near = given["near"] * np.linalg.norm(way, axis=2)
        assert np.abs((layers["depth"] + near)[hit] - layers["distance"][hit]).max() <= 1e-5 * size.max()


AOV = """
import json, sys
import numpy as np
import mitsuba as mi
mi.set_variant("scalar_rgb")
scene = mi.load_file(sys.argv[1])
wanted = "dd:depth,nn:sh_normal,gg:geo_normal,pos:position,alb:albedo"
aov = mi.load_dict({"type": "aov", "aovs": wanted})
sampler = mi.load_dict({"type": "independent"})
rays = np.load(sys.argv[2])
found = [aov.sample(scene, sampler, mi.RayDifferential3f(mi.Ray3f(list(o), list(d))))[2] for o, d in rays]
np.save(sys.argv[3], np.array(found))
"""


def test_mitsubas_aov_are_these_layers(tmp_path: Path) -> None:
    """Along our own rays: depth, normals, position, albedo; some shapes are meshes there."""
    pytest.importorskip("mitsuba", reason="needs the optional dependency clrt[validation]")
    from validation.oracle_mitsuba.xml import write_xml

    materials = {"floor": CHECKER, "a": CHECKER, "b": MATTE, "c": GREY, "d": MATTE}
    scene = as_read(stock_room(materials, {"lights": [NEAR], "background": 0.0}))
    write_xml(scene, tmp_path / "room.xml")
    tracer = clrt.Tracer(scene)
    wanted = ["depth", "shading_normal", "normal", "position", "albedo"]
    layers = tracer.render(spp=1, layers=wanted).layers
    origins, directions = tracer.camera_rays()
    np.save(tmp_path / "rays.npy", np.stack([origins, directions], axis=2)[::4, ::4].reshape(-1, 2, 3))
    files = [str(tmp_path / name) for name in ("room.xml", "rays.npy", "found.npy")]
    subprocess.run([sys.executable, "-c", AOV, *files], check=True, timeout=120)
    found = np.load(files[2])
    mine = np.concatenate([np.atleast_3d(layers[name])[::4, ::4] for name in wanted], axis=2)
    mine = mine.reshape(len(found), -1).astype(float)
    hit = np.isfinite(mine[:, 0])
    assert hit.mean() > 0.3 and np.array_equal(hit, found[:, 0] > 0)
    # seen from either side: Mitsuba's normals point out, ours of shading to the eye; edges and meshes' facets
    facing = np.sign((found[:, 1:4] * mine[:, 1:4]).sum(axis=1, keepdims=True))
    found[:, 1:4] *= facing
    # twice what was seen (2.1e-4, 8e-4, 1.2e-2); the normals of meshes are those of their facets
    for name, columns, most in (("depth", [0], 5e-4), ("shading normal", [1, 2, 3], 2e-3),
                                ("normal", [4, 5, 6], 2.4e-2), ("position", [7, 8, 9], 5e-4),
                                ("albedo", [10, 11, 12], 1.2e-7)):  # fmt: skip
        assert np.abs(found - mine)[hit][:, columns].max() <= most, name


def test_layers_that_are_not_asked_for_cost_nothing(
    tracer: clrt.Tracer, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: Any) -> None:
        raise AssertionError("computed, and not asked for")

    monkeypatch.setattr("clrt.engine.job.covered", refuse)
    monkeypatch.setattr("clrt.images.cryptomatte.id_of", refuse)
    assert "geometry" not in tracer.render(layers=["direct"]).stats["seconds"]
    assert "geometry" in tracer.render(layers=["z"]).stats["seconds"]


def test_mattes_go_on_from_a_checkpoint_of_the_same_names_alone(tmp_path: Path) -> None:
    scene = clrt.load_dict({**BALLS, "camera": CAMERA})
    wanted = {"layers": ["crypto_shape", "alpha", "z", "albedo", "material", "shading_normal", "distance"],
              "checkpoint": tmp_path / "c"}  # fmt: skip
    settings = clrt.Settings(tile=200)

    def stop(done: int, *_: int) -> None:
        if done > 900:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        clrt.Tracer(scene, settings=settings).render(progress=stop, **wanted)
    other = scene.replace({"shapes[1].name": "right"})
    with pytest.raises(clrt.ClrtError, match="the checkpoint of another render: crypto_shape was"):
        clrt.Tracer(other).render(**wanted)
    gone_on = clrt.Tracer(scene).render(**wanted)
    whole = clrt.Tracer(scene).render(layers=wanted["layers"])
    for name, layer in whole.layers.items():
        assert gone_on.layers[name].tobytes() == layer.tobytes(), name
    assert gone_on.metadata == whole.metadata
    (manifest,) = (text for key, text in whole.metadata.items() if key.endswith("/manifest"))
    assert json.loads(manifest).keys() == {"left", "shapes[1]", "shapes[2]"}


def test_the_colour_is_the_same_in_bands() -> None:
    """What RGB stands for in bands has that RGB under D65; what a spectrum has is colour-science's to say."""
    colors = [[0.8, 0.1, 0.1], [0.1, 0.6, 0.2], 0.5]
    shapes = [{**shape, "material": {"color": color, "diffuse": 0.9}}
              for shape, color in zip(BALLS["shapes"], colors, strict=True)]  # fmt: skip
    table = {**BALLS, "shapes": shapes, "camera": CAMERA}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", clrt.ClrtWarning)
        plain, bands = (clrt.render({**table, **more}, layers=["albedo"]).layers["albedo"]
                        for more in ({}, {"spectrum": {"bands": 24}}))  # fmt: skip
    assert plain.shape == bands.shape and np.abs(plain - bands).max() <= 2e-3
    for color in colors:
        assert (np.abs(plain - 0.9 * np.broadcast_to(color, 3)).max(axis=2) <= 1e-7).any()
