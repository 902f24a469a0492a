"""Mitsuba's plugins as a scene, by docs/mitsuba.md."""

from __future__ import annotations

import math
import shutil
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.errors import ClrtWarning
from clrt.meshfiles.facets import Facets, fresnel_of
from tests.mitsuba_samples import BALL, SCENES, WOOD, lost, material, read, table
from validation.hostile import xmlfiles


def test_a_whole_file(tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_text(xmlfiles.SCENE)
    found = clrt.load(tmp_path / "a.xml").to_dict()
    assert found["max_depth"] == 4 and found["background"] == found["ambient"] == 0.1
    assert found["camera"] == {
        "origin": [0, 1, 5], "target": [0, 0.5, 0], "up": [0, 1, 0], "fov": 40.0, "fov_axis": "vertical",
        "aperture": 0.05, "focus": 5.0, "width": 12, "height": 9, "filter": "tent", "spp": 4,
    }  # fmt: skip
    assert [shape["type"] for shape in found["shapes"]] == ["sphere", "box", "polygon"]
    disk, spot = found["lights"]
    assert disk["type"] == "disk" and disk["radius"] == 1 and disk["radiance"] == [5, 5, 4]
    np.testing.assert_allclose(disk["normal"], [0, -1, 0], atol=1e-15)
    assert spot["type"] == "spot" and "angle" not in spot and spot["penumbra"] == 0.25
    color = found["materials"][found["shapes"][2]["material"]]["color"]
    assert color == {"type": "checker", "colors": [0.9, 0.2]}  # of size 1


@pytest.mark.parametrize("away", [0.0, 1e6, 2e7, 1e12, 1e16])
@pytest.mark.parametrize("size", [1e-30, 1e-8, 1.0, 1e8])
def test_views_and_lights_of_any_size_and_place_look_as_their_matrix(
    away: float, size: float, tmp_path: Path
) -> None:
    """A step of 1 is lost in float32 far from the origin; one of an axis's length, where that is short."""
    turn = f'<rotate y="1" angle="20"/><translate x="{away}" z="{-away}"/>'
    placed = f'<transform name="to_world"><scale value="{size}"/>{turn}</transform>'
    (tmp_path / "a.xml").write_text(
        f'<scene version="3.0.0"><sensor type="perspective">{placed}</sensor>'
        f'<emitter type="spot">{placed}</emitter><emitter type="directional">{placed}</emitter></scene>'
    )
    found = clrt.load(tmp_path / "a.xml")
    spot, sun = found.lights
    right = [math.sin(math.radians(20)), 0, math.cos(math.radians(20))]
    for place, target in ((found.camera.origin, found.camera.target), (spot.position, spot.target)):
        assert place == (away, 0, -away)
        way = np.subtract(target, place)
        np.testing.assert_allclose(way / np.linalg.norm(way), right, atol=1e-9)
    np.testing.assert_allclose(sun.direction, right, atol=1e-15)


def test_lights_are_pi_times_as_bright(tmp_path: Path) -> None:
    body = f"""
    <emitter type="point"><point name="position" value="1 2 3"/>
      <rgb name="intensity" value="{math.pi * 0.3!r}"/></emitter>
    <emitter type="point"><transform name="to_world"><translate value="4, 5, 6"/></transform></emitter>
    <emitter type="directional"><vector name="direction" x="1" y="-1"/>
      <spectrum name="irradiance" value="400:{math.pi!r} 700:{math.pi!r}"/></emitter>
    <emitter type="directional"><rgb name="irradiance" value="{math.pi!r} 0 0"/></emitter>
    <shape type="sphere"><float name="radius" value="2"/><point name="center" x="1"/>
      <transform name="to_world"><scale value="3"/></transform><emitter type="area"/></shape>
    <shape type="rectangle"><boolean name="flip_normals" value="true"/><emitter type="area">
      <rgb name="radiance" value="7"/></emitter></shape>"""
    lights = table(tmp_path, body)["lights"]
    assert lights[0] == {
        "type": "point",
        "position": [1, 2, 3],
        "intensity": 0.3,
        "falloff": "inverse-square",
    }
    assert lights[1]["position"] == [4, 5, 6]
    assert lights[2]["direction"] == [1, -1, 0]
    assert lights[3]["direction"] == [0, 0, 1] and lights[3]["intensity"] == [1, 0, 0]
    assert lights[4]["center"] == [3, 0, 0] and lights[4]["radius"] == 6
    assert lights[5]["radiance"] == 7 and np.cross(lights[5]["u"], lights[5]["v"]).tolist() == [0, 0, -1]


def test_cameras(tmp_path: Path) -> None:
    def camera(inner: str, kind: str = "perspective") -> Any:
        return read(tmp_path, f'<sensor type="{kind}">{inner}</sensor>').camera

    size = '<integer name="width" value="300"/><integer name="height" value="400"/>'
    film = f'<film type="hdrfilm">{size}</film>'
    fov = '<float name="fov" value="50"/>'
    plain = camera(film)
    assert (plain.origin, plain.target, plain.spp) == ((0, 0, 0), (0, 0, 1), 1)
    assert plain.filter == camera("").filter == "gaussian"
    across = 2 * math.degrees(math.atan(math.hypot(36, 24) / 100 * 300 / 500))
    assert plain.fov == pytest.approx(across, rel=1e-12)  # 50 mm along the diagonal
    assert camera('<string name="focal_length" value="28mm"/>').fov > 60
    for axis, is_vertical in (("x", False), ("y", True), ("smaller", False), ("larger", True)):
        found = camera(f'{film}<float name="fov" value="50"/><string name="fov_axis" value="{axis}"/>')
        assert found.fov == 50 and (found.fov_axis == "vertical") is is_vertical
    moved = camera(f'{film}{fov}<float name="principal_point_offset_x" value="0.1"/>')
    assert moved.shift == (30, 0)
    assert camera('<transform name="to_world"><scale x="-1"/></transform>').mirror
    flat = camera('<transform name="to_world"><scale value="3"/></transform>', "orthographic")
    assert flat.type == "orthographic" and flat.size == 6
    lens = camera("", "thinlens")
    assert lens.aperture == 0 and lens.focus == 10000
    assert camera('<float name="far_clip" value="7"/>', "thinlens").focus == 7
    assert camera('<float name="focus_distance" value="2"/>', "thinlens").focus == 2
    many = camera('<sampler type="multijitter"><integer name="sample_count" value="1024"/></sampler>')
    assert many.spp == 16
    assert camera('<film type="hdrfilm"><rfilter type="box"/></film>').filter == "box"
    for kind in ("perspective", "orthographic"):
        assert camera('<float name="focus_distance" value="1000"/>', kind).aperture == 0


@pytest.mark.parametrize(
    ("body", "named"),
    [
        ('<integrator type="path"><boolean name="hide_emitters" value="{}"/></integrator>',
         "emitters are hidden"),
        ('<bsdf type="plastic" id="a"><boolean name="nonlinear" value="{}"/></bsdf>'
         '<shape type="sphere"><ref id="a"/></shape>', "nonlinear of plastic"),
    ],
)  # fmt: skip
def test_what_is_asked_for_and_has_no_counterpart_is_named(tmp_path: Path, body: str, named: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read(tmp_path, body.format("false"))
    with pytest.warns(clrt.ClrtWarning, match=named):
        read(tmp_path, body.format("true"))


def test_a_number_is_a_spectrum_of_a_light_and_a_grey_of_a_surface(tmp_path: Path) -> None:
    flat = '<spectrum name="{}" value="0.5"/>'
    named = {"point": "intensity", "spot": "intensity", "directional": "irradiance", "constant": "radiance"}
    body = "".join(f'<emitter type="{kind}">{flat.format(name)}</emitter>' for kind, name in named.items())
    area = f'<emitter type="area">{flat.format("radiance")}</emitter>'
    found = table(tmp_path, f'{body}<shape type="disk">{area}</shape>')
    curves = [light["intensity"] for light in found["lights"][:3]]
    curves += [found["lights"][3]["radiance"], found["background"], found["ambient"]]
    assert [[nm for nm, _ in curve] for curve in curves] == [[360, 830]] * 6
    assert len({*map(str, curves[:3])}) == 1 and curves[3:] == [[[360, 0.5], [830, 0.5]]] * 3
    assert material(tmp_path, f'<bsdf type="diffuse">{flat.format("reflectance")}</bsdf>') == {"color": 0.5}


def test_a_film_of_grey_is_named(tmp_path: Path) -> None:
    film = '<film type="hdrfilm"><string name="pixel_format" value="luminance"/></film>'
    with pytest.warns(clrt.ClrtWarning, match="pixel format 'luminance'"):
        read(tmp_path, f'<sensor type="perspective">{film}</sensor>')


def test_materials(tmp_path: Path) -> None:
    grey = material(tmp_path, '<default name="a" value="b"/>')
    assert grey == {"color": 0.5}
    assert material(tmp_path, '<bsdf type="diffuse"/>') == {"color": 0.5}
    said = '<string name="material" value="Au"/><float name="alpha" value="0.25"/>'
    gold = f'<bsdf type="roughconductor">{said}</bsdf>'
    rough = material(tmp_path, f'<bsdf type="twosided">{gold}</bsdf>')
    assert rough["conductor"] == "gold" and rough["roughness"] == 0.5 and rough["specular"] == 4
    for said in ("", '<string name="material" value="none"/>'):
        assert material(tmp_path, f'<bsdf type="conductor">{said}</bsdf>') == {"diffuse": 0, "reflection": 1}
    mirror = material(tmp_path, '<bsdf type="conductor"><string name="material" value="none"/></bsdf>')
    assert mirror == {"diffuse": 0, "reflection": 1}
    glass = material(tmp_path, '<bsdf type="thindielectric"><float name="int_ior" value="1.4"/></bsdf>')
    assert glass == {
        "diffuse": 0,
        "fresnel": True,
        "ior": 1.4,
        "reflection": 1,
        "transmission": 1,
        "thin": True,
    }
    dark = '<rgb name="diffuse_reflectance" value="0.2"/>'
    plastic = material(tmp_path, f'<bsdf type="roughplastic">{dark}</bsdf>')
    index = 1.49
    made = Facets(roughness=math.sqrt(0.1), ior=index, f0=(fresnel_of(index),) * 3).table()
    assert plastic["color"] == 0.2 and plastic["specular"] == made["specular"]
    assert material(tmp_path, '<bsdf type="plastic"/>')["fresnel"] == "schlick"
    metal = material(
        tmp_path, '<bsdf type="principled"><float name="metallic" value="1"/>'
        '<rgb name="base_color" value="0.3"/></bsdf>',
    )  # fmt: skip
    assert metal["reflection_color"] == pytest.approx([0.3] * 3)
    grey = material(tmp_path, '<bsdf type="principled"><rgb name="base_color" value="0.1 0.2 0.3"/></bsdf>')
    assert grey["color"] == [0.1, 0.2, 0.3]


def test_a_curve_has_its_colour_where_there_can_be_none(tmp_path: Path) -> None:
    """What a diffuse surface of that curve looks like."""
    curve = '<spectrum name="{}" value="400:0.2 570:0.2 600:0.9 700:0.9"/>'
    plain = f'<bsdf type="diffuse">{curve.format("reflectance")}</bsdf>'
    whole = read(tmp_path, f'<emitter type="constant"/>{BALL.format(plain)}')
    view = {"origin": [0, 0, 9], "target": [0, 0, 0], "fov": 20.0, "width": 3, "height": 3}
    red = clrt.render(whole.replace({"camera": view}), layers=("albedo",)).layers["albedo"][1, 1]
    assert red[0] > 3 * red[2] > 0
    base = f'<bsdf type="principled">{curve.format("base_color")}</bsdf>'
    np.testing.assert_allclose(material(tmp_path, base)["color"], red, rtol=1e-6)
    both = f'<bsdf type="blendbsdf">{plain}{plain}</bsdf>'
    np.testing.assert_allclose(material(tmp_path, both)["color"], red, rtol=1e-6)


@pytest.mark.parametrize(
    ("pairs", "curve"),
    [
        ("580:0.2, 620:0.3", [[580, 0], [580, 0.2], [620, 0.3], [620, 0]]),
        ("580:0 620:0.3", [[580, 0], [620, 0.3], [620, 0]]),
        ("580:0.2 620:0", [[580, 0], [580, 0.2], [620, 0]]),
        ("360:0.2 700:0.3", [[360, 0.2], [700, 0.3], [700, 0]]),
        ("300:0.2 830:0.3", [[300, 0.2], [830, 0.3]]),
    ],
)
def test_a_curve_ends_where_its_points_do(tmp_path: Path, pairs: str, curve: list[list[float]]) -> None:
    """Mitsuba's is 0 beyond them."""
    both = [f'<spectrum name="{name}" value="{pairs}"/>' for name in ("radiance", "reflectance")]
    ball = BALL.format(f'<bsdf type="diffuse">{both[1]}</bsdf>')
    found = read(tmp_path, f'<emitter type="constant">{both[0]}</emitter>{ball}')
    assert found.to_dict()["background"] == found.to_dict()["materials"]["diffuse"]["color"] == curve
    found.save(tmp_path / "b.toml")
    assert clrt.load(tmp_path / "b.toml").to_dict() == found.to_dict()


def test_names_of_the_first_version_of_textures(tmp_path: Path) -> None:
    shutil.copy(SCENES / "wood.png", tmp_path)
    moved = "".join(f'<float name="{name}" value="{value}"/>' for name, value in
                    (("uscale", 2), ("vscale", 3), ("uoffset", 0.25), ("voffset", 0.5)))  # fmt: skip
    wood = f'<texture type="bitmap" name="diffuseReflectance">{WOOD}{moved}</texture>'
    color = material(tmp_path, f'<bsdf type="plastic">{wood}</bsdf>')["color"]
    assert color == {"type": "image", "file": "wood.png", "scale": [2, 3], "offset": [0.5, 1.5]}
    scale = '<float name="uscale" value="4"/><float name="vscale" value="2"/>'
    squares = f'<texture type="checkerboard" name="reflectance">{scale}</texture>'
    bsdf = f'<bsdf type="diffuse">{squares}</bsdf>'
    assert material(tmp_path, bsdf)["color"] == {"type": "checker", "colors": [0.4, 0.2], "divisions": 8}


def test_glass_under_water(tmp_path: Path) -> None:
    water = '<bsdf type="dielectric"><string name="ext_ior" value="water"/></bsdf>'
    twice = water.replace(">", ' id="a">', 1) + BALL.format(water) + '<texture type="bitmap"/>'
    assert table(tmp_path, twice)["medium_ior"] == 1.333
    air = BALL.format('<bsdf type="dielectric"/>')
    for both in (air + BALL.format(water), BALL.format(water) + air):
        assert lost(tmp_path, both) == "more than one ext_ior" and "medium_ior" not in table(tmp_path, both)


def test_blends_are_sums(tmp_path: Path) -> None:
    colors = [f'<rgb name="reflectance" value="{color}"/>' for color in ("1 0 0", "0 0 1")]
    red, blue = (f'<bsdf type="diffuse">{color}</bsdf>' for color in colors)
    mirror = '<bsdf type="conductor"><string name="material" value="none"/></bsdf>'
    weight = '<float name="weight" value="0.25"/>'
    found = material(tmp_path, f'<bsdf type="blendbsdf">{weight}{red}{blue}</bsdf>')
    assert found["color"] == [0.75, 0, 0.25] and found.get("diffuse", 1.0) == 1
    found = material(tmp_path, f'<bsdf type="blendbsdf">{weight}{mirror}{blue}</bsdf>')
    assert found["reflection"] == 0.75 and found["diffuse"] == 0.25 and found["color"] == [0, 0, 1]
    two = material(tmp_path, f'<bsdf type="blendbsdf">{mirror}{mirror}</bsdf>')
    assert two == material(tmp_path, mirror), "as the one that both are"
    plastic = '<bsdf type="plastic"/>'
    assert material(tmp_path, f'<bsdf type="blendbsdf">{red}{plastic}</bsdf>')["fresnel"] == "schlick"


def test_shapes(tmp_path: Path) -> None:
    turned = '<transform name="to_world"><rotate z="1" angle="90"/><scale x="2"/></transform>'
    matrix = '<transform name="to_world"><matrix value="2 0 0 1  0 2 0 0  0 0 2 0  0 0 0 1"/></transform>'
    shapes = table(tmp_path, f"""
    <shape type="cylinder" id="tube">
      <point name="p0" value="0 0 0"/><point name="p1" value="0 1 0"/>{turned}</shape>
    <shape type="rectangle">{matrix}</shape>
    <shape type="disk"><transform name="to_world"><matrix value="0 0 1 0 1 0 1 0 0"/></transform></shape>
    <shape type="cube"/>""")["shapes"]  # fmt: skip
    assert shapes[0]["name"] == "tube" and "caps" not in shapes[0]
    np.testing.assert_allclose(
        shapes[0]["transform"], [[0, -2, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], atol=1e-15
    )
    assert shapes[1]["points"] == [[-1, -2, 0], [3, -2, 0], [3, 2, 0], [-1, 2, 0]]
    assert shapes[2]["transform"][0] == [0, 0, 1, 0]
    assert shapes[3]["type"] == "box" and "transform" not in shapes[3]


def test_files_beside(tmp_path: Path) -> None:
    for name in ("knot.ply", "gem.obj", "wood.png", "tile-normals.png", "sky.exr"):
        shutil.copy(SCENES / name, tmp_path)
    wood = f'<texture name="reflectance" type="bitmap">{WOOD}</texture>'
    (tmp_path / "part.xml").write_text(f'<bsdf type="diffuse" id="wood">{wood}</bsdf>')
    (tmp_path / "two.xml").write_text('<scene version="3.0.0"><shape type="cube"/></scene>')
    bumps = """<bsdf type="normalmap">
      <texture name="normalmap" type="bitmap"><boolean name="raw" value="true"/>
      <string name="filename" value="tile-normals.png"/></texture><ref id="wood"/></bsdf>"""
    gem = '<string name="filename" value="gem.obj"/><boolean name="face_normals" value="true"/>'
    obj = f'<shape type="obj">{gem}'
    body = f"""<include filename="part.xml"/><include filename="two.xml"/>
    <alias id="wood" as="oak"/><path value="x"/>
    <shape type="sphere"><ref id="oak"/></shape>
    <shape type="rectangle"><ref id="wood"/></shape><shape type="rectangle">{bumps}</shape>
    <shape type="ply"><string name="filename" value="knot.ply"/></shape>
    {obj}</shape>{obj}<emitter type="area"/></shape>
    <emitter type="envmap"><string name="filename" value="sky.exr"/>
      <transform name="to_world"><rotate y="1" angle="180"/></transform></emitter>"""
    assert "the light that a mesh sheds" in lost(tmp_path, body)
    with pytest.warns(ClrtWarning):
        found = read(tmp_path, body).to_dict()
    assert found["background"] == "sky.exr" and found["ambient_samples"] == 16
    kinds = [shape["type"] for shape in found["shapes"]]
    assert kinds == ["box", "sphere", "mesh", "mesh", "mesh", "mesh", "mesh"]
    assert found["shapes"][1]["material"] == "wood"
    assert found["materials"]["wood"]["color"] == {"type": "image", "file": "wood.png"}
    bent = found["materials"][found["shapes"][3]["material"]]
    assert bent["normal_map"]["file"] == "tile-normals.png"
    assert found["shapes"][4]["smooth"] and not found["shapes"][5].get("smooth")
    assert found["shapes"][6]["material"]["emission"] == 1


def test_v_of_a_ply_runs_upwards(tmp_path: Path) -> None:
    """Mitsuba reads the numbers of a PLY as they stand, the picture's first row at v = 0."""
    shutil.copy(SCENES / "wood.png", tmp_path)
    vertices = "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n"
    (tmp_path / "a.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "property float s\nproperty float t\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n"
        f"{vertices}3 0 1 2\n"
    )
    to_uv = '<transform name="to_uv"><scale x="2" y="3"/><translate x="0.1" y="0.2"/></transform>'
    bsdf = f"""<bsdf type="diffuse"><texture name="reflectance" type="bitmap">{to_uv}
      <string name="filename" value="wood.png"/></texture></bsdf>"""
    shape = '<shape type="ply"><string name="filename" value="a.ply"/>{}</shape>'
    found = read(tmp_path, shape.format(bsdf))
    color = found.material_of(found.shapes[0]).color
    assert color.scale == (2, -3) and color.offset == (0.1, 3.2)
    flipped = '<boolean name="flip_tex_coords" value="true"/>'
    found = read(tmp_path, shape.format(bsdf + flipped))
    assert found.material_of(found.shapes[0]).color.scale == (2, 3)


@pytest.mark.parametrize(
    ("integrator", "depth"),
    [
        ('<integrator type="direct"/>', 0),
        ('<integrator type="path"/>', 5),
        ('<integrator type="path"><integer name="maxDepth" value="-1"/></integrator>', 5),
        ('<integrator type="path"><integer name="max_depth" value="1"/></integrator>', 0),
        ('<integrator type="aov"><integrator type="direct"/></integrator>', 0),
        ('<integrator type="bdpt"><integer name="max_depth" value="4"/></integrator>', 2),
        ('<integrator type="volpath"><integer name="max_depth" value="999"/></integrator>', 64),
    ],
)
def test_depths(integrator: str, depth: int, tmp_path: Path) -> None:
    assert read(tmp_path, integrator, "0.6.0").max_depth == depth
