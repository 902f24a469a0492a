"""What is wrong in Mitsuba's XML is said in one line; nothing is read that a file may not name."""

from __future__ import annotations

from pathlib import Path

import pytest

import clrt
from clrt.base.errors import LimitError, SceneError
from clrt.base.limits import Limits
from clrt.formats.xml_tree import LONGEST

BALL = '<shape type="sphere">{}</shape>'
VIEW = '<sensor type="perspective">{}</sensor>'


def wrong(tmp_path: Path, text: str, limits: Limits | None = None) -> str:
    (tmp_path / "a.xml").write_text(text)
    with pytest.raises((SceneError, LimitError)) as found:
        clrt.load(tmp_path / "a.xml", limits=limits or Limits())
    return str(found.value)


@pytest.mark.parametrize("version", ["", "3", "abc", "-1.0.0", "3.0.0 ", "3.0.\u0663"])
def test_versions_are_three_numbers(version: str, tmp_path: Path) -> None:
    found = wrong(tmp_path, f'<scene version="{version}">{BALL.format("")}</scene>')
    assert found.endswith(f"a.xml:1: version: {version!r} is not allowed; it must be like 3.0.0")


@pytest.mark.parametrize("last", ["0 0 0 2", "0 0 0 0", "0 0 1 1"])
@pytest.mark.parametrize(
    "body",
    [
        BALL,
        VIEW,
        '<shape type="rectangle">{}</shape>',
        '<shape type="rectangle">{}<emitter type="area"/></shape>',
        '<emitter type="spot">{}</emitter>',
    ],
)
def test_matrices_of_a_perspective_are_refused(body: str, last: str, tmp_path: Path) -> None:
    matrix = f'<transform name="to_world"><matrix value="1 0 0 0 0 1 0 0 0 0 1 0 {last}"/></transform>'
    found = wrong(tmp_path, f'<scene version="3.0.0">{body.format(matrix)}</scene>')
    assert "the last row of a matrix must be 0 0 0 1" in found and "\n" not in found


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("<bsdf", "a.xml:1: wrong syntax"),
        (2 * '<bsdf type="plastic" id="a"/>', "id 'a' stands twice, first in line 1"),
        ('<bsdf type="diffuse" id="a"/><bsdf type="plastic" id="b"/><alias id="a" as="b"/>', "'b' stands"),
        (
            BALL.format('<float name="radius" value="1"/><integer name="radius" value="2"/>'),
            "radius stands twice, first in line 1",
        ),
        ("words", "the text 'words' belongs to no value"),
        ("<thing/>", "no element 'thing'"),
        (BALL.format("<thing/>"), "no element 'thing'"),
        ('<shape type="sphear"/>', "did you mean 'sphere'"),
        ("<shape/>", '<shape> needs type="..."'),
        (BALL.format('<float name="radios" value="1"/>'), "called 'radios'; did you mean 'radius'"),
        (BALL.format('<float name="radius"/>'), 'needs value="..."'),
        (BALL.format('<float name="radius" value="x"/>'), "radius: 'x' is not allowed"),
        (BALL.format('<float name="radius" value="1_0"/>'), "it must be a number"),
        (BALL.format('<float name="radius" value="$r"/>'), "'$r' stands for nothing"),
        (BALL.format('<point name="center" value="1 2"/>'), "1 or 3 numbers, not 2"),
        (BALL.format('<point name="center" w="2"/>'), "part of a vector called 'w'"),
        (BALL.format('<boolean name="flip_normals" value="yes"/>'), "it must be true or false"),
        (BALL.format('<bsdf type="plastic"><float name="int_ior" value="-1"/></bsdf>'), "a number > 0"),
        (BALL.format('<bsdf type="principled"><float name="eta" value="-1"/></bsdf>'), "a number > 0"),
        (
            BALL.format(
                '<bsdf type="diffuse"><texture name="reflectance" type="checkerboard">'
                '<transform name="to_uv"><scale x="1e200"/><scale x="1e200"/></transform></texture></bsdf>'
            ),
            "must not leave the range of float64",
        ),
        (BALL.format('<ref id="a"/>'), "no object with the id 'a' (there is none)"),
        (BALL.format('<emitter type="point"/>'), "no emitter of a shape 'point'"),
        ('<alias id="a" as="b"/>', "no object with the id 'a'"),
        (
            BALL.format('<transform name="to_world"><skale/></transform>'),
            "called 'skale'; did you mean 'scale'",
        ),
        (BALL.format('<transform name="to_world"><rotate angle="3"/></transform>'), "axis of a rotation"),
        (
            VIEW.format(
                '<transform name="to_world"><rotate x="1" angle="3"/>'
                '<lookat origin="0 0 0" target="0 0 0" up="0 1 0"/></transform>'
            ),
            "must not be at its origin",
        ),
        (VIEW.format('<transform name="to_world"><scale value="0"/></transform>'), "must not flatten space"),
        (
            '<emitter type="spot"><transform name="to_world"><scale z="0"/></transform></emitter>',
            "must not flatten space",
        ),
        (VIEW.format('<float name="fov" value="200"/>'), "from 0 to 180 degrees"),
        (VIEW.format('<string name="focal_length" value="0mm"/>'), "it must be like 50mm"),
        (VIEW.format('<string name="fov_axis" value="z"/>'), "no fov axis 'z'"),
        (VIEW.format('<film type="hdrfilm"><float name="width" value="1.5"/></film>'), "a whole number >= 1"),
        (VIEW.format('<film type="hdrfilm"><rfilter type="sinc"/></film>'), "no rfilter 'sinc'"),
        (VIEW.format('<sampler type="random"/>'), "no sampler 'random'"),
        ('<sensor type="fisheye"/>', "no sensor 'fisheye'"),
        ('<integrator type="pat"/>', "did you mean 'path'"),
        ('<emitter type="moon"/>', "no emitter 'moon'"),
        (VIEW.format('<film type="film"/>'), "no film 'film'"),
        (
            BALL.format('<bsdf type="diffuse"><bsdf name="reflectance" type="diffuse"/></bsdf>'),
            "reflectance: a bsdf is no colour; give it a texture",
        ),
        ('<emitter type="envmap"/>', "needs its filename"),
        ('<emitter type="spot"><float name="cutoff_angle" value="99"/></emitter>', "from 0 to 90 degrees"),
        ('<bsdf type="difuse"/>', "did you mean 'diffuse'"),
        ('<bsdf type="twosided"/>', "a twosided needs a bsdf within it"),
        ('<bsdf type="normalmap"><bsdf type="diffuse"/></bsdf>', "needs a bitmap"),
        ('<bsdf type="roughplastic"><float name="alpha" value="2"/></bsdf>', "a number from 0 to 1"),
        ('<bsdf type="dielectric"><string name="int_ior" value="bk9"/></bsdf>', "did you mean 'bk7'"),
        ('<bsdf type="diffuse"><texture name="reflectance" type="bitmab"/></bsdf>', "did you mean 'bitmap'"),
        ('<bsdf type="diffuse"><texture name="reflectance" type="bitmap"/></bsdf>', "needs its filename"),
        (
            '<emitter type="point"><spectrum name="intensity" type="d66"/></emitter>',
            "there is no spectrum 'd66'; did you mean 'd65'?",
        ),
        (
            BALL.format('<bsdf type="diffuse"><spectrum name="reflectance" filename="a.spd"/></bsdf>'),
            "reflectance: a spectrum from a file is not read; write <spectrum value=",
        ),
        (
            BALL.format('<bsdf type="diffuse"><spectrum name="reflectance" value="600:0.5"/></bsdf>'),
            "a curve has 2 or more [nm, value] pairs",
        ),
        ('<bsdf type="twosided" id="a"><ref id="a"/></bsdf>', "refers to itself"),
        ('<shape type="ply"/>', "needs its filename"),
        (
            '<shape type="ply"><string name="filename" value="/etc/passwd"/></shape>',
            "must lie in the scene's folder",
        ),
        ('<include filename="../x.xml"/>', "must lie in the scene's folder"),
        ('<include filename="a.xml"/>', "an included file includes no other"),
        (
            '<integrator type="path"><integer name="maxdepth" value="5"/></integrator>',
            "did you mean 'max_depth'",
        ),
        (
            '<integrator type="aov"><integrator type="direct"><float name="rr_depth" value="5"/></integrator>'
            "</integrator>",
            "value of integrator 'direct' called 'rr_depth'",
        ),
        (
            '<sensor type="perspective"><film type="hdrfilm"><rfilter type="gaussian">'
            '<float name="sigma" value="1"/></rfilter></film></sensor>',
            "value of rfilter 'gaussian' called 'sigma'",
        ),
    ],
)
def test_faults_are_one_line(body: str, said: str, tmp_path: Path) -> None:
    found = wrong(tmp_path, f'<scene version="3.0.0">{body}</scene>')
    assert said in found and found.startswith("a.xml") and "\n" not in found


def test_what_is_no_scene(tmp_path: Path) -> None:
    assert "no element found" in wrong(tmp_path, "")
    assert "holds a <scene>, not <shape>" in wrong(tmp_path, '<shape type="sphere"/>')


@pytest.mark.parametrize("inner", ['[<!ENTITY a "lol">]', 'SYSTEM "file:///etc/passwd"', ""])
def test_document_types_are_refused(inner: str, tmp_path: Path) -> None:
    """So no entity can grow, nor name another file."""
    assert "DOCTYPE" in wrong(tmp_path, f"<!DOCTYPE scene {inner}><scene/>")


def test_parameters_do_not_grow(tmp_path: Path) -> None:
    doubled = "".join(f'<default name="a{k}" value="$a{k - 1}$a{k - 1}"/>' for k in range(1, 60))
    text = f'<scene version="3.0.0"><default name="a0" value="99"/>{doubled}</scene>'
    assert f"longer than {LONGEST} letters" in wrong(tmp_path, text)


def test_limits(tmp_path: Path) -> None:
    deep = '<bsdf type="twosided">' * 20 + "</bsdf>" * 20
    assert "nesting: " in wrong(tmp_path, f"<scene>{deep}</scene>")
    many = "<shape/>" * 10
    assert "primitives: " in wrong(tmp_path, f"<scene>{many}</scene>", Limits(primitives=9))
    (tmp_path / "b.xml").write_text("<scene>" + " " * 100 + "</scene>")
    both = '<scene version="3.0.0"><include filename="b.xml"/></scene>'
    assert "text_bytes: " in wrong(tmp_path, both, Limits(text_bytes=120))
    endless = Limits(nesting=10**6)
    deeper = '<bsdf type="twosided">' * 5000 + "</bsdf>" * 5000
    assert "deeper than Python follows" in wrong(tmp_path, f"<scene>{deeper}</scene>", endless)


def test_a_file_is_included_once(tmp_path: Path) -> None:
    """Else 2,500 names of a file of 20 spheres ask for 50,000."""
    (tmp_path / "b.xml").write_text('<scene version="3.0.0"><shape type="sphere"/></scene>')
    once, again = '<include filename="b.xml"/>', '<include filename="./b.xml"/>'
    said = wrong(tmp_path, f'<scene version="3.0.0">\n{once}{again}</scene>')
    assert said == "a.xml:2: 'b.xml' is included twice, first in line 2; leave one out"


def test_references_are_followed_once(tmp_path: Path) -> None:
    """Each of 40 blends names the one before it twice: 2 to the 40th as a tree."""
    blends = "".join(
        f'<bsdf type="blendbsdf" id="b{k + 1}"><ref id="b{k}"/><ref id="b{k}"/></bsdf>' for k in range(39)
    )
    first = '<bsdf type="diffuse" id="b0"/>'
    last = BALL.format('<ref id="b39"/>')
    (tmp_path / "a.xml").write_text(f'<scene version="3.0.0">{first}{blends}{last}</scene>')
    assert clrt.load(tmp_path / "a.xml").shapes


def test_integrators_are_followed_once(tmp_path: Path) -> None:
    """Each of 40 integrators names the next one twice."""
    inner = "".join(
        f'<integrator type="aov" id="i{k}"><ref id="i{k + 1}"/><ref id="i{k + 1}"/></integrator>'
        for k in range(39)
    )
    last = '<integrator type="direct" id="i39"/>'
    (tmp_path / "a.xml").write_text(f'<scene version="3.0.0">{inner}{last}{BALL.format("")}</scene>')
    assert clrt.load(tmp_path / "a.xml").shapes


@pytest.mark.parametrize("encoding", ["latin-1", "utf-16", "cp037"])
def test_other_encodings_are_named(tmp_path: Path, encoding: str) -> None:
    """They were taken for UTF-8."""
    text = f'<?xml version="1.0" encoding="{encoding}"?><scene version="3.0.0"/>'
    assert f"a.xml:1: the encoding '{encoding}' is not read; save the file as UTF-8" in wrong(tmp_path, text)
