"""The scenes that ship: each loads and renders, is documented, and shows what its header says."""

from __future__ import annotations

import runpy
import warnings
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

import clrt
from clrt import layout
from clrt.base.errors import SceneError
from clrt.base.resources import scene_folder, shipped_scenes
from clrt.cli.scenes import headline
from clrt.formats.shipped import load_scene
from clrt.scene.scene import DirectionalLight, Mesh, Scene, Sphere

NAMES = sorted(shipped_scenes())
SCRIPTS = [name for name, file in shipped_scenes().items() if file.suffix == ".py"]
DOCS = Path(__file__).resolve().parent.parent / "docs"


@pytest.fixture(scope="module")
def scenes() -> dict[str, Scene]:
    """Every scene that ships, loaded with warnings as errors."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return {name: load_scene(name) for name in NAMES}


@pytest.mark.parametrize("name", NAMES)
def test_each_renders_a_picture(name: str, scenes: dict[str, Scene]):
    spectral = scenes[name].spectrum is not None
    image = clrt.render(scenes[name], width=48, spp=1, layers=["bands"] if spectral else [])
    pixels = image.pixels
    assert np.isfinite(pixels).all()
    # pure colours lie outside what red, green and blue can show; there is no negative light
    assert (image.layers["bands"] if spectral else pixels).min() >= 0
    assert pixels.std(axis=(0, 1)).min() > 0.02
    assert pixels.max(axis=2).mean() > 0.1


def test_each_is_described(scenes: dict[str, Scene]):
    documented = (DOCS / "scenes.md").read_text()
    for name, file in shipped_scenes().items():
        text = file.read_text()
        assert headline(file), name
        assert "Source: " in text and "What to look at" in text, name
        assert f"`{name}`" in documented, name
        assert file.stat().st_size < 300_000, name
        camera = scenes[name].camera
        assert camera is not None and camera.width * camera.height * camera.spp <= 1280 * 720 * 9, name


def test_each_figure_of_the_thesis_that_shows_an_effect_has_a_scene():
    figures = {name[7:11] for name in NAMES if name.startswith("thesis_")}
    assert figures == {"3_06", "3_07", "3_09", "3_12", "4_1_", "4_2_", "4_3_", "4_4_"}


@pytest.mark.parametrize("name", SCRIPTS)
def test_scripts_give_the_same_scene_every_time(name: str):
    first, second = (runpy.run_path(str(shipped_scenes()[name]))["scene"]() for _ in range(2))
    assert first == second and first["shapes"]


def test_only_scripts_that_ship_are_run(tmp_path: Path):
    script = tmp_path / "sphereflake.py"
    script.write_text("raise AssertionError('was run')")
    with pytest.raises(SceneError, match=r"\.py"):
        load_scene(script)


def test_sizes_of_the_generated_scenes(scenes: dict[str, Scene]):
    def spheres(name: str) -> int:
        return sum(isinstance(shape, Sphere) for shape in scenes[name].shapes)

    def triangles(name: str) -> int:
        return sum(len(shape.data().faces) for shape in scenes[name].shapes if isinstance(shape, Mesh))

    assert spheres("sphereflake") == 7381
    assert spheres("thesis_4_4_spheres") > 700
    assert spheres("mountain") == 4 and triangles("mountain") > 50_000
    assert triangles("tetrahedron") == 4 * 4**5


def test_no_marble_of_the_flake_is_inside_another(scenes: dict[str, Scene]):
    """Children touch their parent from outside: the centres' distance is the sum of the radii."""
    balls = [shape for shape in scenes["sphereflake"].shapes if isinstance(shape, Sphere)]
    centers, radii = np.array([b.center for b in balls[:200]]), np.array([b.radius for b in balls[:200]])
    gaps = np.linalg.norm(centers[:, None] - centers[None], axis=2) - radii[:, None] - radii[None]
    np.fill_diagonal(gaps, np.inf)
    assert np.abs(gaps.min(axis=1)[1:]).max() < 1e-5


def test_backgrounds_are_what_their_script_writes():
    folder = scene_folder()
    script = runpy.run_path(str(folder / "generate_backgrounds.py"))
    assert sorted(f"{name}.exr" for name in script["BACKGROUNDS"]) == sorted(
        f.name for f in folder.glob("*.exr")
    )
    for name, make in script["BACKGROUNDS"].items():
        held = np.asarray(oiio.ImageBuf(str(folder / f"{name}.exr")).get_pixels(oiio.FLOAT))
        np.testing.assert_allclose(held, make(), rtol=1e-3, atol=1e-6)  # half floats: 11 bits


def test_pictures_on_surfaces_are_what_their_script_writes():
    """But for the last bit of a byte, which another library's sine may round otherwise."""
    folder = scene_folder()
    script = runpy.run_path(str(folder / "generate_textures.py"))
    files = sorted(f.name for f in folder.glob("*.png"))
    assert sorted(f"{name}.png" for name in script["PICTURES"]) == files
    for name, make in script["PICTURES"].items():
        held = np.asarray(oiio.ImageBuf(str(folder / f"{name}.png")).get_pixels(oiio.UINT8)).astype(int)
        assert np.abs(held - np.clip(make(), 0, 1) * 255).max() <= 1


def test_meshes_are_what_their_script_makes(scenes: dict[str, Scene]):
    script = runpy.run_path(str(scene_folder() / "generate_meshes.py"))
    made = {
        "mesh": [script["torus_knot"](), script["gem"]()],
        "showcase": [script["gem"](), script["torus_knot"](along=240, around=18)],
    }
    for name, expected in made.items():
        held = [shape.data() for shape in scenes[name].shapes if isinstance(shape, Mesh)]
        assert len(held) == len(expected)
        for data, (vertices, _) in zip(held, expected, strict=True):
            np.testing.assert_allclose(data.vertices, vertices, atol=6e-5)


def test_coloured_stones_are_what_their_script_writes(tmp_path):
    script = runpy.run_path(str(scene_folder() / "generate_meshes.py"))
    for kind in ("vertices", "faces"):
        script["write_colored"](tmp_path / "stone.ply", kind == "faces")
        assert (tmp_path / "stone.ply").read_text() == (scene_folder() / f"stone-{kind}.ply").read_text()


def test_meshes_are_closed_and_wound_outwards():
    """The divergence theorem: each has the volume that its shape has, with the right sign."""
    script = runpy.run_path(str(scene_folder() / "generate_meshes.py"))

    def volume(vertices: np.ndarray, faces: list[tuple[int, ...]]) -> float:
        fans = [(f[0], f[i], f[i + 1]) for f in faces for i in range(1, len(f) - 1)]
        a, b, c = (vertices[[fan[k] for fan in fans]] for k in range(3))
        edges = [(f[i], f[(i + 1) % len(f)]) for f in faces for i in range(len(f))]
        assert len(set(edges)) == len(edges) and {(j, i) for i, j in edges} == set(edges)
        return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)

    t = np.linspace(0, 2 * np.pi, 20001)
    radius = 1 + 0.42 * np.cos(3 * t)
    curve = np.stack([radius * np.cos(2 * t), radius * np.sin(2 * t), 0.42 * np.sin(3 * t)], axis=1)
    length = np.linalg.norm(np.diff(curve, axis=0), axis=1).sum()
    assert volume(*script["torus_knot"]()) == pytest.approx(np.pi * 0.24**2 * length, rel=0.02)
    assert 1.5 < volume(*script["gem"]()) < 1.75


def test_without_the_offset_surfaces_shade_themselves(
    scenes: dict[str, Scene], monkeypatch: pytest.MonkeyPatch
):
    """Thesis, figure 3.7, on the sphere: with the offset all of its lit side is lit."""
    scene = scenes["thesis_3_07_acne"]
    assert isinstance(scene.shapes[1], Sphere)
    light = scene.lights[0]
    assert isinstance(light, DirectionalLight)
    towards = -np.array(light.direction) / np.linalg.norm(light.direction)
    layers = ("shape", "normal", "diffuse")

    def lit_and_dark() -> tuple[int, int]:
        image = clrt.render(scene, width=160, spp=1, layers=layers)
        facing = (image.layers["shape"] == 1) & (image.layers["normal"] @ towards > 0.05)
        bright = image.layers["diffuse"].max(axis=2) > 0
        return int((facing & bright).sum()), int((facing & ~bright).sum())

    lit, dark = lit_and_dark()
    assert lit > 1000 and dark == 0
    monkeypatch.setattr(layout, "OFFSET", 0.0)
    lit, dark = lit_and_dark()
    assert 0.3 < dark / (lit + dark) < 0.7


def test_no_ray_leaves_the_room(scenes: dict[str, Scene]):
    rays = clrt.render(scenes["room"], width=64, spp=1).stats["rays"]
    assert rays["hits"] == rays["camera"] + rays["reflection"] + rays["transmission"]


@pytest.mark.parametrize("name", ["bubble", "prism", "mesh", "showcase"])
def test_total_internal_reflection_happens(name: str, scenes: dict[str, Scene]):
    assert clrt.render(scenes[name], width=64, spp=1).stats["rays"]["total_internal_reflection"] > 100


def test_the_depth_limit_shows_in_the_mirrors(scenes: dict[str, Scene]):
    """depth_color has no green: nothing else in the picture is as magenta."""

    def magenta(max_depth: int) -> int:
        pixels = clrt.render(scenes["mirrors"], width=160, spp=1, max_depth=max_depth).pixels
        return int(((pixels[..., 0] > 0.1) & (pixels[..., 1] < 0.02)).sum())

    assert 0 < magenta(14) < magenta(6)


def test_the_layers_of_the_shading_model_are_all_there(scenes: dict[str, Scene]):
    """On surfaces: what misses everything is background, which is in none of the four terms."""
    terms = ("emission", "ambient", "diffuse", "highlight")
    layers = (*terms, "reflection", "transmission", "depth")
    image = clrt.render(scenes["thesis_4_2_shading"], width=96, spp=1, layers=layers)
    for name in (*terms, "reflection"):
        assert image.layers[name].max() > 0.05, name
    hit = np.isfinite(image.layers["depth"])
    assert 0.5 < hit.mean() < 0.95
    total = sum(image.layers[name] for name in terms) + image.layers["reflection"]
    np.testing.assert_allclose(total[hit], image.pixels[hit], atol=1e-5)
    assert not image.layers["transmission"].any()
