"""Kernels against the float32 twin: all values of all passes are the same bits, and a fault is named."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import clrt
from clrt import layout
from clrt.base.layers import LAYERS, Geometry, comes_from
from clrt.base.resources import kernel_folder, shipped_scenes
from clrt.device.device import Device
from clrt.flatten.flatten import FlatScene, flatten
from tests.random_scenes import grid_rays, on_the_grid, random_scene
from validation import expected, selftest
from validation.twin.compare import Comparison, compare_picture, compare_rays
from validation.twin.geometry import primitives_of
from validation.twin.picture import radiance32, render32, trace32
from validation.twin.rays import difficult_rays
from validation.twin.scenes import scenes
from validation.twin.variants import in_bands, with_sky

SCENES = scenes()
RAYS_PER_SCENE = 9_000
assert RAYS_PER_SCENE * len(SCENES) >= 100_000


@pytest.fixture(scope="module")
def device() -> Device:
    return Device()


def same(comparison: Comparison) -> int:
    """The number of rays compared, all of them equal."""
    assert comparison.difference is None, str(comparison.difference)
    return comparison.rays


@pytest.mark.parametrize("name", SCENES)
def test_all_passes_of_a_picture_and_of_difficult_rays(name: str, device: Device) -> None:
    scene, flat = SCENES[name]
    rays = same(compare_picture(device, scene, flat, width=72))
    rays += same(compare_rays(device, flat, *difficult_rays(6000, seed=len(name)), max_depth=2))
    assert rays >= RAYS_PER_SCENE


@pytest.mark.parametrize("seed", range(14))
def test_random_scenes(seed: int, device: Device) -> None:
    flat = flatten(random_scene(seed, spectral=seed >= 12))
    flat = with_sky(flat) if seed % 4 == 0 else flat
    origins, directions, t_max = difficult_rays(1500, seed)
    scale = np.float32(10.0 ** (seed % 3 - 1))
    with np.errstate(over="ignore"):
        origins, t_max = origins * scale, t_max * scale
    assert same(compare_rays(device, flat, origins, directions, t_max, max_depth=3)) > 1500


@pytest.mark.parametrize("name", ["spheres", "tinted shadows", "ambient samples", "sky image"])
@pytest.mark.parametrize("bands", [8, 64])
def test_any_number_of_bands(bands: int, name: str, device: Device) -> None:
    scene, flat = SCENES[name]
    flat = in_bands(flat, bands)
    rays = same(compare_picture(device, scene, flat))
    assert rays + same(compare_rays(device, flat, *difficult_rays(500, seed=bands), max_depth=2)) > 1500


def test_rays_through_corners_along_edges_and_at_a_tangent(device: Device) -> None:
    flat = flatten(on_the_grid())
    origins, directions = grid_rays()
    same(compare_rays(device, flat, origins, directions, max_depth=1))
    hits = trace32(flat, origins, directions)
    # each was met, and some rays met none
    assert len(np.unique(hits.primitive)) == len(primitives_of(flat)) + 1


def test_public_answers_about_rays() -> None:
    """Whatever the tile, also where a packet is not full."""
    scene, _ = SCENES["ambient samples"]
    origins, directions, t_max = difficult_rays(1111, 3)
    expected, seen = trace32(scene, origins, directions, t_max), radiance32(scene, origins, directions, 2)
    for tile in (1 << 16, 77):
        tracer = clrt.Tracer(scene, settings=clrt.Settings(tile=tile))
        hits = tracer.intersect(origins, directions, t_max)
        for name in ("t", "primitive", "shape", "normal", "u", "v"):
            ours, theirs = getattr(hits, name), getattr(expected, name)
            assert ours.dtype == theirs.dtype and ours.tobytes() == theirs.tobytes(), name
        assert np.array_equal(tracer.occluded(origins, directions, t_max), expected.primitive >= 0)
        light, stats = tracer.radiance(origins, directions, max_depth=2)
        assert np.array_equal(light.view(np.uint32), seen[0].view(np.uint32))
        assert stats == seen[1]


@pytest.mark.parametrize("name", ["spheres", "ambient samples", "tinted shadows"])
def test_public_pictures_layers_and_counts(name: str) -> None:
    scene, _ = SCENES[name]
    layers = ("direct", "reflection", "transmission", "generation_0", "generation_2", "emission", "ambient")
    geometry = (name for name in LAYERS if comes_from(name, Geometry) and name != "uv")
    layers += ("diffuse", "highlight", *geometry)
    image = clrt.render(scene, spp=4, layers=layers, settings=clrt.Settings(tile=500))
    expected = render32(scene, spp=4, layers=layers)
    assert image.pixels.tobytes() == expected.pixels.tobytes()
    for layer in layers:
        assert image.layers[layer].tobytes() == expected.layers[layer].tobytes(), layer
    assert {key: image.stats[key] for key in ("rays", "generations")} == expected.stats
    assert len(np.unique(expected.pixels)) > 500  # the picture shows something


def test_the_scenes_hold_every_primitive_and_every_term() -> None:
    hit: set[int] = set()
    for scene, flat in SCENES.values():
        shapes = render32(scene, layers=("shape",), flat=flat).layers["shape"]
        primitives = primitives_of(flat)
        hit |= set(primitives["kind"][np.isin(primitives["shape"], shapes)].tolist())
    assert hit == set(layout.KINDS.values())

    def somewhere(section: str, field: str) -> set[float]:
        records = [getattr(flat, section)[field] for _, flat in SCENES.values()]
        return {value for values in records for value in values.ravel().tolist()}

    assert somewhere("materials", "fresnel") == set(layout.FRESNEL.values())
    assert somewhere("materials", "checker") == set(layout.CHECKER.values())
    for field in ("thin", "one_sided"):
        assert somewhere("materials", field) == {0, 1}
    assert somewhere("lights", "kind") == set((layout.LIGHT_KINDS | layout.EXTENDED_KINDS).values())
    assert somewhere("materials", "light") == somewhere("lights", "two_sided") | {2} == {0, 1, 2}
    assert somewhere("lights", "falloff") == set(layout.FALLOFF.values())
    for field in ("tinted", "spd", "one_sided", "background_width", "min_weight", "ambient_samples"):
        assert len(somewhere("scene", field)) > 1, field
    assert min(somewhere("triangles", "normals")) < 0 < max(somewhere("triangles", "normals"))
    totals = [render32(scene, flat=flat).stats["rays"] for scene, flat in SCENES.values()]
    for kind in ("reflection", "transmission", "ambient", "total_internal_reflection", "feelers"):
        assert sum(row[kind] for row in totals) > 100, kind


ULP = "1.0000001f"
# A row: a file, a text in it, the same with a fault that moves one number by about an ulp (or rays to each
# other's places), a scene that shows it, and the pass that must be named.
PLANTED = [
    ("generate.cl", "direction = unit3(add(forward, in_view))",
     f"direction = unit3(add(forward, times(in_view, {ULP})))", "spheres", "generate"),
    ("quadric.clh", "b = dot3(d, slope),", f"b = dot3(d, slope) * {ULP},", "quadrics", "closest"),
    ("triangle.clh", "s.u = e.y / ", f"s.u = {ULP} * e.y / ", "meshes", "surface"),
    ("film.cl", "hit ? away : INFINITY", f"hit ? away * {ULP} : INFINITY", "meshes", "geometry"),
    ("light.cl", "(emission + ambient), mine", f"(emission + ambient) * {ULP}, mine", "spheres", "shade"),
    ("light.clh", "material->ks * power(", f"{ULP} * material->ks * power(", "spheres", "illuminate"),
    ("bounce.clh", "times(n, 2.0f * dot3(n, u))", "times(n, 2.0000002f * dot3(n, u))", "spheres", "reflect"),
    ("bounce.clh", "(s * s + p * p) * 0.5f", "(s * s + p * p) * 0.50000006f", "spheres", "reflect"),
    ("bounce.clh", "add(times(u, eta),", f"add(times(u, eta * {ULP}),", "spheres", "transmit"),
    ("ambient.cl", "slot[i] + k;", "slot[i] + samples - 1 - k;", "ambient samples", "gather_ambient"),
    ("light_point.clh", "1.0f / distance)", f"1.0f / distance * {ULP})", "spheres", "feelers"),
    ("film.cl", "sum[band + b] += ", f"sum[band + b] += {ULP} * ", "spheres", "gather"),
    ("light.cl", "transmitted |= goes", "transmitted = goes", "dispersion beside none", "shade"),
    ("light.cl", "select(transmitted, goes, dispersing)", "goes", "dispersion beside none", "shade"),
]


@pytest.fixture
def patched(tmp_path: Path) -> Path:
    return Path(shutil.copytree(kernel_folder(), tmp_path / "kernels"))


@pytest.mark.parametrize("fault", PLANTED, ids=[f"{row[-1]} {row[-2]}" for row in PLANTED])
def test_a_planted_fault_is_named(fault: tuple[str, ...], patched: Path, hasty: None) -> None:
    file, text, faulty, scene, name = fault
    source = (patched / file).read_text()
    assert source.count(text) == 1, "the place of the planted fault has changed"
    (patched / file).write_text(source.replace(text, faulty))
    difference = compare_picture(Device(kernels=patched), *SCENES[scene]).difference
    assert difference is not None and difference.name == name, str(difference)


def test_the_first_value_that_differs_is_told_with_its_ray_and_both_numbers(
    patched: Path, hasty: None
) -> None:
    """The fault strikes a single pixel, so all of the message is known."""
    source = (patched / "generate.cl").read_text()
    text = "origin = add(origin, times(direction, camera.near / dot3(direction, forward)));"
    one = "as_intP(counting_from(first)) == 77"
    fault = f"{text} origin.y = select(origin.y, as_floatP(as_intP(origin.y) + 1), {one});"
    assert source.count(text) == 1, "the place of the planted fault has changed"
    (patched / "generate.cl").write_text(source.replace(text, fault))
    scene, flat = SCENES["spheres"]
    difference = compare_picture(Device(kernels=patched), scene, flat).difference
    assert difference is not None and scene.camera is not None
    y = np.float32(scene.camera.origin[1])
    there, here = float(np.nextafter(y, np.float32(9))).hex(), float(y).hex()
    assert str(difference) == (
        f"pass generate, generation 0, camera ray 77 (pixel 77): origin[1] is {there} on the device, "
        f"{here} in numpy; 1 values of this pass differ"
    )


def test_selftest_passes_and_fails(patched: Path, request: pytest.FixtureRequest) -> None:
    """A few of its checks; the others are those above, and hashes in tests/engine/test_bits.py."""
    names = selftest.names()
    assert len(set(names)) == len(names) == 3 + len(SCENES) and set(SCENES) < set(names)
    few = [*names[:2], "spheres", "dispersion"]
    results = list(selftest.run_selftest(only=few))
    assert all(result.passed for result in results), [r for r in results if not r.passed]
    assert [result.name for result in results] == few
    source = (patched / "math.clh").read_text()
    dot = "return a.x * b.x + a.y * b.y + a.z * b.z;"
    assert source.count(dot) == 1, "the place of the planted fault has changed"
    fused = "return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z));"  # what a driver that ignores the pragma may do
    (patched / "math.clh").write_text(source.replace(dot, fused))
    request.getfixturevalue("hasty")
    wrong = selftest.run_selftest(Device(kernels=patched), only=few[:3])
    broken = {result.name: result for result in wrong}
    assert broken["layout of records"].passed and broken["arithmetic"].passed
    assert not broken["spheres"].passed and "generation 0, camera ray" in broken["spheres"].detail


def test_selftest_sees_another_layout_and_other_arithmetic(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setitem(selftest._OPERATIONS, "fma(a, b, c)", lambda a, b, c: a * b + c)
        passed, detail = selftest.check_arithmetic(device)
        assert not passed and detail.startswith("fma(a, b, c) with a = ")
    dtype = layout.dtype("Disk")
    moved = np.dtype({"names": dtype.names, "formats": ["4f4", "4f4"], "offsets": [16, 0]})
    kinds = {name: layout.dtype(name) for name in layout.RECORDS} | {"Disk": moved}
    monkeypatch.setattr(selftest.layout, "dtype", lambda name, bands: kinds[name])
    passed, detail = selftest.check_layout(device)
    assert not passed and detail == "offset of Disk.center_radius: 0 bytes on the device, 16 in numpy"


def test_a_flat_scene_may_be_given_in_place_of_a_scene() -> None:
    scene, flat = SCENES["spheres"]
    assert isinstance(flat, FlatScene)
    rays = difficult_rays(50, 1)
    assert trace32(scene, *rays).t.tobytes() == trace32(flat, *rays).t.tobytes()


def test_the_hashes_that_ship_are_of_all_scenes_and_a_changed_picture_is_noticed(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    kept = json.loads(expected.FILE.read_text())
    assert set(kept) == set(shipped_scenes()), "run: python -m validation.expected"
    wrong = tmp_path / "wrong.json"
    wrong.write_text(json.dumps({"room": kept["room"], "prism": "0" * 64}))
    monkeypatch.setattr(expected, "FILE", wrong)
    monkeypatch.setattr(expected, "shipped_scenes", lambda: {"room": None, "prism": None})
    passed, detail = expected.check()
    assert not passed and "1 of 2 pictures differ from ours: prism" in detail
