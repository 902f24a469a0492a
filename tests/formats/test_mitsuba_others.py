"""What Mitsuba's own scenes and exporters write beside shapes and materials: as Mitsuba has it, or named."""

from __future__ import annotations

import math
import shutil
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.scene.textures import ImageTexture
from tests.mitsuba_samples import BALL, SCENES, lost, material, read, table

UNUSED = ("anisotropic", "spec_tint", "sheen", "sheen_tint", "flatness", "clearcoat", "clearcoat_gloss")
FILE = '<string name="filename" value="{}"/>'


def _turned(steps: str) -> str:
    return f'<transform name="to_world">{steps}</transform>'


@pytest.mark.parametrize("looks", ["1,2,3 4,-1,2", "0,0,5 0,0,0", "0,0,0 0,3,0", "3,0,0 -1,-2,4"])
def test_looks_without_up_have_mitsubas(tmp_path: Path, looks: str) -> None:
    """As of <sensor type="perspective"> in Mitsuba 3.9: `world_transform()`, the second axis."""
    origin, target = (np.array([*map(float, part.split(","))]) for part in looks.split())
    x, y, z = (target - origin) / np.linalg.norm(target - origin)
    sign = 1.0 if z >= 0 else -1.0
    right = np.array([1 - x * x / (1 + abs(z)), -x * y / (sign + z) * sign, -sign * x])
    step = f'<lookat origin="{looks.split()[0]}" target="{looks.split()[1]}" {{}}/>'
    for up in ("", 'up="0 0 0"'):
        found = read(tmp_path, f'<sensor type="perspective">{_turned(step.format(up))}</sensor>').camera
        assert found is not None and found.up == pytest.approx(right, abs=1e-12)


def test_axes_of_lights_that_are_scaled(tmp_path: Path) -> None:
    """Mitsuba compares a spot's directions in its own space, and takes a sun's axis as long as it is."""
    sun = '<emitter type="directional">{}<rgb name="irradiance" value="1 1 1"/></emitter>'
    turned = _turned('<scale value="3"/><rotate y="1" angle="90"/>')
    scaled, plain = (table(tmp_path, sun.format(way))["lights"][0]["intensity"] for way in (turned, ""))
    assert scaled == pytest.approx([3 * part for part in plain], rel=1e-12)
    given = table(tmp_path, sun.format('<vector name="direction" value="0 0 3"/>'))["lights"][0]
    assert given["intensity"] == plain
    look = '<lookat origin="0 0 5" target="0 0 0" up="0 1 0"/>'
    spot = '<emitter type="spot">{}</emitter>'
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read(tmp_path, spot.format(_turned(f'<scale value="-2"/>{look}')))
    for axis in "xyz":
        with pytest.warns(clrt.ClrtWarning, match="no counterpart: the stretch of a spot$"):
            read(tmp_path, spot.format(_turned(f'<scale {axis}="2"/>{look}')))


def test_what_is_nearer_than_the_near_clip_is_not_seen(tmp_path: Path) -> None:
    """Across the view from there on, as in Mitsuba 3."""
    for kind in ("perspective", "thinlens", "orthographic"):
        for clip, near in ("", 0.0), ('<float name="near_clip" value="1.5"/>', 1.5):
            camera = read(tmp_path, f'<sensor type="{kind}">{clip}</sensor>').camera
            assert camera is not None and camera.near == near
    clip, scaled = '<float name="near_clip" value="1.5"/>', _turned('<scale x="2" y="2" z="3"/>')
    camera = read(tmp_path, f'<sensor type="orthographic">{clip}{scaled}</sensor>').camera
    assert camera is not None and (camera.near, camera.size) == (4.5, 4)


@pytest.mark.parametrize(("steps", "scale", "offset", "named"), [
    ('<rotate z="1" angle="180"/>', (-1, -1), (0, 0), False),
    ('<rotate z="1" angle="90"/><translate x="0.25"/>', (1, 1), (-0.75, 0), True),
    ('<scale x="2" y="3"/><rotate z="1" angle="30"/>', (2, 3), None, True),
])  # fmt: skip
def test_turned_pictures_are_as_large(
    tmp_path: Path, steps: str, scale: tuple[float, float], offset: tuple[float, float] | None, named: bool
) -> None:
    """A turn by half is a scale; of others the turn alone is left out, and the middle stays where it is."""
    shutil.copy(SCENES / "tiles.png", tmp_path / "a.png")
    moved = f'<transform name="to_uv">{steps}</transform>'
    bitmap = f'<texture type="bitmap" name="reflectance">{FILE.format("a.png")}{moved}</texture>'
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        scene = read(tmp_path, BALL.format(f'<bsdf type="diffuse">{bitmap}</bsdf>'))
    assert [str(one.message).split(": ")[-1] for one in said] == ["rotations of textures"] * named
    found = scene.material_of(scene.shapes[0]).color
    assert isinstance(found, ImageTexture) and found.scale == pytest.approx(scale)
    if offset is not None:
        assert found.offset == pytest.approx(offset, abs=1e-12)


def test_pictures_on_meshes_without_uv_are_left_out(tmp_path: Path) -> None:
    shutil.copy(SCENES / "tiles.png", tmp_path / "a.png")
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "b.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n")
    unused = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1//1 2//1 3//1\n"
    vertex = "element vertex 3\n" + "".join(f"property float {name}\n" for name in "xyz")
    head = f"ply\nformat ascii 1.0\n{vertex}{{}}element face 1\nproperty list uchar int vertex_indices\n"
    (tmp_path / "a.ply").write_text(head.format("") + "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    uv = head.format("property float s\nproperty float t\n") + "end_header\n"
    (tmp_path / "b.ply").write_text(f"{uv}0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n")
    picture = '<texture type="bitmap" name="{}">' + FILE.format("a.png") + "</texture>"
    bsdf = f'<bsdf type="diffuse">{picture.format("reflectance")}</bsdf>'
    mapped = f'<bsdf type="normalmap">{picture.format("normalmap")}{bsdf}</bsdf>'
    for kind in ("obj", "ply", "obj"):
        for inner in (bsdf, mapped):
            files = [FILE.format(f"{name}.{kind}") for name in "aabb"]
            meshes = [f'<shape type="{kind}">{file}{inner}</shape>' for file in files]
            with pytest.warns(clrt.ClrtWarning, match="textures of 'm' where it has no uv$"):
                shared = "".join(meshes).replace(inner, '<ref id="m"/>')
                scene = read(tmp_path, f'<bsdf id="m"{inner[5:]}{shared}')
            *bare, shown, other = (scene.material_of(shape) for shape in scene.shapes)
            assert [(one.color, one.normal_map) for one in bare] == [(0.5, None)] * 2
            assert isinstance(shown.color, ImageTexture) and (shown.normal_map is None) == (inner == bsdf)
            assert other == shown
            with pytest.warns(clrt.ClrtWarning, match=f"textures of '{kind}' where it has no uv$"):
                alone = read(tmp_path, meshes[0])
            assert alone.material_of(alone.shapes[0]) == bare[0]
        (tmp_path / "a.obj").write_text(unused)  # the last time


def test_a_picture_on_a_mesh_of_another_kind(tmp_path: Path) -> None:
    shutil.copy(SCENES / "tiles.png", tmp_path / "a.png")
    (tmp_path / "a.dat").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    picture = '<texture type="bitmap" name="reflectance">' + FILE.format("a.png") + "</texture>"
    shape = f'<shape type="obj">{FILE.format("a.dat")}<bsdf type="diffuse">{picture}</bsdf></shape>'
    with pytest.raises(clrt.SceneError, match=r"a\.dat"):
        read(tmp_path, shape)


@pytest.mark.parametrize(("integrator", "sky", "bsdf", "named"), [
    ("direct", True, "conductor", 2), ("direct", True, "dielectric", 2), ("direct", True, "diffuse", 0),
    ("direct", False, "conductor", 0), ("path", True, "conductor", 0),
])  # fmt: skip
def test_mirrors_show_lights_a_bounce_later(
    tmp_path: Path, integrator: str, sky: bool, bsdf: str, named: int
) -> None:
    """A light in a mirror is a path of length 2 in Mitsuba, as is one on a wall; here a generation more."""
    parts = f'<integrator type="{integrator}"/>' + BALL.format(f'<bsdf type="{bsdf}"/>')
    parts += '<emitter type="constant"/>' if sky else '<emitter type="point"/>'
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        read(tmp_path, parts)
    words = f"what mirrors and glass show of light at a max_depth of {named}"
    assert [str(one.message).split(": ")[-1] for one in said] == ([words] if named else [])


def test_what_builds_trees_changes_no_picture(tmp_path: Path) -> None:
    kinds = "".join(f'<shape type="{kind}"><boolean name="face_normals" value="true"/></shape>'
                    for kind in ("rectangle", "cube"))  # fmt: skip
    robust = '<boolean name="embree_use_robust_intersections" value="true"/>'
    assert len(read(tmp_path, f'{robust}<integer name="kd_max_depth" value="4"/>{kinds}').shapes) == 2
    with pytest.raises(clrt.ClrtError, match="there is no element 'integer'"):
        read(tmp_path, '<integer name="max_depth" value="4"/>')


def test_folders_in_which_files_lie(tmp_path: Path) -> None:
    """Those that <path> names come before the scene's own, the last of them first."""
    corners = "v 0 0 0\nv {0} 0 0\nv 0 {0} 0\nf 1 2 3\n"
    for number, folder in enumerate(("", "b", "c/d"), 1):
        (tmp_path / folder).mkdir(parents=True, exist_ok=True)
        (tmp_path / folder / "a.obj").write_text(corners.format(number))
    (tmp_path / "e.obj").write_text(corners.format(9))
    (tmp_path / "b" / "in.xml").write_text('<bsdf version="3.0.0" type="diffuse"/>')

    def sizes(head: str) -> list[float]:
        file = '<shape type="obj"><string name="filename" value="{}.obj"/></shape>'
        shapes = file.format("a") + file.format("e")
        return [float(shape.data().vertices.max()) for shape in read(tmp_path, head + shapes).shapes]

    assert sizes("") == [1, 9]
    assert sizes('<path value="b"/><include filename="in.xml"/>') == [2, 9]
    assert sizes('<path value="b"/><path value="./c\\d"/><path value="b"/>') == [3, 9]
    for elsewhere in ("..", "/", "gone", "e.obj", "", "."):
        if elsewhere in ("", "."):
            assert sizes(f'<path value="{elsewhere}"/>') == [1, 9]
        else:
            with pytest.warns(clrt.ClrtWarning, match="the <path> '.*', which is no folder in the scene's"):
                assert sizes(f'<path value="{elsewhere}"/>') == [1, 9]
    many = "".join(f'<path value="f{k}"/>' for k in range(65))
    for k in range(65):
        (tmp_path / f"f{k}").mkdir()
    with pytest.raises(clrt.ClrtError, match="more than 64 folders of <path>"):
        sizes(many)


def test_files_included_within_objects(tmp_path: Path) -> None:
    (tmp_path / "red.xml").write_text(
        '<bsdf version="3.0.0" type="diffuse"><rgb name="reflectance" value="$red 0 0"/></bsdf>'
    )
    body = '<default name="red" value="0.5"/><default name="which" value="red"/>{}'
    shape = '<shape type="sphere"><float name="radius" value="2"/><include filename="$which.xml"/></shape>'
    found = read(tmp_path, body.format(shape))
    assert found.material_of(found.shapes[0]).color == (0.5, 0, 0)
    with pytest.raises(clrt.ClrtError, match=r"red\.xml is included twice|'red.xml' is included twice"):
        read(tmp_path, body.format(shape * 2))
    (tmp_path / "red.xml").write_text(f'<scene version="3.0.0">{shape}</scene>')
    with pytest.raises(clrt.ClrtError, match="an included file includes no other"):
        read(tmp_path, body.format(shape))


def test_plastic_in_another_medium(tmp_path: Path) -> None:
    """Its index is one against what is around it; one of principled, or both alike, reflects nothing."""
    def mirror(bsdf: str) -> Any:
        found = read(tmp_path, f'<shape type="sphere">{bsdf}</shape>')
        material = found.material_of(found.shapes[0])
        return material.highlight_color, material.kr

    plain = '<bsdf type="plastic"><float name="int_ior" value="1.5"/>{}</bsdf>'
    (color, kr), (wet, _) = (
        mirror(plain.format(ext)) for ext in ("", '<float name="ext_ior" value="1.33"/>')
    )
    assert kr == 1 and color[0] == pytest.approx(0.04, rel=1e-6)
    assert wet[0] == pytest.approx((0.17 / 2.83) ** 2, rel=1e-9)
    assert mirror(plain.format('<float name="ext_ior" value="1.5"/>'))[1] == 0
    for value in ('"specular" value="0"', '"eta" value="1"'):
        bsdf = f'<bsdf type="principled"><float name={value}/><float name="roughness" value="0.2"/></bsdf>'
        assert mirror(bsdf)[1] == 0


def test_glass_of_principled_lets_the_root_of_its_colour_pass(tmp_path: Path) -> None:
    """At each of the two surfaces of a body that light crosses; of a picture there is no root."""
    shutil.copy(SCENES / "tiles.png", tmp_path / "a.png")
    smooth = '<float name="roughness" value="0"/>'
    body = f'<bsdf type="principled">{smooth}{{}}<float name="spec_trans" value="{{}}"/></bsdf>'
    color = '<rgb name="base_color" value="0.25 0.64 1"/>'
    glass = material(tmp_path, body.format(color, 1))
    assert glass["transmission_color"] == pytest.approx([0.5, 0.8, 1]) and glass["transmission"] == 1
    assert glass["color"] == [0.25, 0.64, 1]
    picture = f'<texture type="bitmap" name="base_color">{FILE.format("a.png")}</texture>'
    root = "the root of a picture by which glass lets light pass"
    assert lost(tmp_path, BALL.format(body.format(picture, 1))) == root
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read(tmp_path, BALL.format(body.format(picture, 0)))


PICTURE = '<texture type="bitmap" name="{}">{}' + FILE.format("a.{}") + "</texture>"
MAP = '<bsdf type="normalmap">' + PICTURE.format("normalmap", "{}", "{}") + "{}</bsdf>"
RAW, RED, GREEN = '<boolean name="raw" value="true"/>', *(
    f'<bsdf type="diffuse"><rgb name="reflectance" value="{value}"/></bsdf>' for value in ("1 0 0", "0 1 0")
)
PLAIN = MAP.format(RAW, "png", RED)
ALLOY = '<float name="spec_trans" value="1"/><float name="metallic" value="{}"/>'


@pytest.mark.parametrize(("bsdf", "named"), [
    (PLAIN, ""), (MAP.format("", "exr", RED), ""),
    (MAP.format("", "png", RED), "that a normal map without raw is decoded from sRGB"),
    (MAP.format(RAW, "png", PLAIN), "a normal map within another"),
    (f'<bsdf type="blendbsdf">{RED}{PLAIN}</bsdf>', "that only a part of a blendbsdf has the normal map"),
    (f'<bsdf type="blendbsdf">{PLAIN}{PLAIN}</bsdf>', ""),
    (f'<bsdf type="principled"><float name="roughness" value="0"/>{ALLOY.format(0.5)}</bsdf>',
     "the metal of what is glass, too"),
    (f'<bsdf type="principled"><float name="roughness" value="0"/>{ALLOY.format(0)}</bsdf>', ""),
])  # fmt: skip
def test_what_of_maps_and_blends_is_lost(tmp_path: Path, bsdf: str, named: str) -> None:
    shutil.copy(SCENES / "tile-normals.png", tmp_path / "a.png")
    shutil.copy(SCENES / "sky.exr", tmp_path / "a.exr")
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        read(tmp_path, BALL.format(bsdf))
    assert [str(one.message).split("counterpart: ")[-1] for one in said] == ([named] if named else [])


def test_a_checker_beneath_a_normal_map_is_its_mean(tmp_path: Path) -> None:
    """A rectangle becomes a mesh there, which has no checker."""
    shutil.copy(SCENES / "tile-normals.png", tmp_path / "a.png")
    checker = '<bsdf type="diffuse"><texture type="checkerboard" name="reflectance"/></bsdf>'
    with pytest.warns(clrt.ClrtWarning, match="a checkerboard, but for its mean, where there can be none$"):
        scene = read(tmp_path, f'<shape type="rectangle">{MAP.format(RAW, "png", checker)}</shape>')
    assert scene.material_of(scene.shapes[0]).color == pytest.approx((0.3, 0.3, 0.3))


def test_a_beam_ends_at_the_cutoff(tmp_path: Path) -> None:
    angles = '<float name="cutoff_angle" value="30"/><float name="beam_width" value="{}"/>'
    for beam, penumbra in (15, 0.5), (30, 0), (45, 0):
        (light,) = table(tmp_path, f'<emitter type="spot">{angles.format(beam)}</emitter>')["lights"]
        assert (light.get("angle", 30), light.get("penumbra", 0)) == (30, penumbra)


def test_alpha_along_u_and_v(tmp_path: Path) -> None:
    values = '<float name="alpha_u" value="{}"/><float name="alpha_v" value="{}"/>'
    both = f'<bsdf type="roughconductor">{values}</bsdf>'
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert material(tmp_path, both.format(0.36, 0.36))["roughness"] == 0.6
        assert material(tmp_path, '<bsdf type="roughconductor"/>')["roughness"] == math.sqrt(0.1)
    apart = both.format(0.09, 0.16)
    said = "alpha u and alpha v of roughconductor, but for their mean"
    assert lost(tmp_path, BALL.format(apart)) == said
    assert material(tmp_path, apart)["roughness"] == pytest.approx(math.sqrt(0.12))
    with pytest.raises(clrt.ClrtError, match=r"alpha_v: 2\.0 is not allowed"):
        read(tmp_path, BALL.format(both.format(0.1, 2)))


@pytest.mark.parametrize(("metal", "mitsubas"), [
    ("Au", (0.967, 0.802, 0.324)), ("Cu", (0.952, 0.620, 0.511)), ("Ag", (0.975, 0.958, 0.906)),
    ("Al", (0.928, 0.918, 0.919)),
])  # fmt: skip
def test_highlights_of_rough_metals_have_their_colour(
    tmp_path: Path, metal: str, mitsubas: tuple[float, ...]
) -> None:
    """What Mitsuba 3.9.1's conductors reflect straight on; its tables are others, up to 0.08 apart."""
    shutil.copy(SCENES / "tiles.png", tmp_path / "a.png")
    said = f'<string name="material" value="{metal}"/><float name="alpha" value="0.3"/>'
    rough = f'<bsdf type="roughconductor">{said}{{}}</bsdf>'

    def highlight(tint: str) -> Any:
        scene = read(tmp_path, BALL.format(rough.format(tint)))
        return scene.material_of(scene.shapes[0]).highlight_color

    plain = np.array(highlight(""))
    np.testing.assert_allclose(plain, mitsubas, atol=0.08)
    half = highlight('<rgb name="specular_reflectance" value="0.5 0.5 0.25"/>')
    np.testing.assert_allclose(half, plain * (0.5, 0.5, 0.25), rtol=1e-12)
    bitmap = f'<texture type="bitmap" name="specular_reflectance">{FILE.format("a.png")}</texture>'
    picture = highlight(bitmap)
    assert isinstance(picture, ImageTexture) and picture.tint == pytest.approx(plain)


def test_words_of_any_case(tmp_path: Path) -> None:
    """Mitsuba does not tell them apart."""
    for word in ("BK7", "Bk7", "bk7"):
        found = material(tmp_path, f'<bsdf type="dielectric"><string name="int_ior" value="{word}"/></bsdf>')
        assert found["ior"] == 1.5046
    for word in ("Y", "y"):
        axis = f'<float name="fov" value="40"/><string name="fov_axis" value="{word}"/>'
        sensor = f'<sensor type="perspective">{axis}</sensor>'
        assert table(tmp_path, sensor)["camera"]["fov_axis"] == "vertical"
    film = '<film type="hdrfilm"><string name="pixel_format" value="Luminance"/></film>'
    assert "pixel format" in lost(tmp_path, f'<sensor type="perspective">{film}</sensor>')
    with pytest.raises(clrt.SceneError, match="fov axis"):
        read(tmp_path, '<sensor type="perspective"><string name="fov_axis" value="w"/></sensor>')


def test_diffuse_reflectance_of_the_first_version(tmp_path: Path) -> None:
    color = '<rgb name="{}" value="0.5 0.3 0.2"/>'
    ball = BALL.format(f'<bsdf type="diffuse">{color.format("diffuseReflectance")}</bsdf>')
    found = read(tmp_path, ball, "0.5.0")
    assert found.material_of(found.shapes[0]).color == (0.5, 0.3, 0.2)
    plain = BALL.format(f'<bsdf type="diffuse">{color.format("reflectance")}</bsdf>')
    found = read(tmp_path, plain, "0.5.0")
    assert found.material_of(found.shapes[0]).color == (0.5, 0.3, 0.2)


@pytest.mark.parametrize(("name", "word"), [("wrap_mode", "Clamp"), ("filter_type", "cubic")])
def test_words_of_textures_that_mitsuba_has_not(tmp_path: Path, name: str, word: str) -> None:
    """Of these it does tell large letters from small ones."""
    shutil.copy(SCENES / "tiles.png", tmp_path / "a.png")
    values = FILE.format("a.png") + f'<string name="{name}" value="{word}"/>'
    texture = f'<texture type="bitmap" name="reflectance">{values}</texture>'
    with pytest.raises(clrt.SceneError, match=name.replace("_", " ")):
        read(tmp_path, BALL.format(f'<bsdf type="diffuse">{texture}</bsdf>'))


def test_values_of_principled_that_change_nothing_are_not_named(tmp_path: Path) -> None:
    """Blender's add-on writes all of them, as 0 where they are not used."""
    ball = BALL.format('<bsdf type="principled">{}</bsdf>')
    for zero in ("0", "0.0", "-0.000000"):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            read(tmp_path, ball.format("".join(f'<float name="{n}" value="{zero}"/>' for n in UNUSED)))
    for name in UNUSED:
        assert name.replace("_", " ") in lost(tmp_path, ball.format(f'<float name="{name}" value="0.05"/>'))
