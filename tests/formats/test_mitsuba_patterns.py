"""What of Mitsuba's plugins has no counterpart is named; checkers and pictures, which have one in part."""

from __future__ import annotations

import shutil
import warnings
from pathlib import Path

import pytest

import clrt
from tests.mitsuba_samples import BALL, SCENES, lost, material, read, table

CHECKER = '<texture type="checkerboard" name="{}">{}</texture>'


@pytest.mark.parametrize(
    ("body", "name"),
    [
        ('<shape type="serialized"/>', "the shape serialized"),
        (BALL.format('<bsdf type="mask"><bsdf type="diffuse"/></bsdf>'), "the bsdf mask"),
        (BALL.format('<bsdf type="null"/>'), "the bsdf null"),
        (BALL.format('<medium type="homogeneous" name="interior"/>'), "media"),
        ('<medium type="homogeneous"/>', "media"),
        ('<sensor type="perspective"/><sensor type="perspective"/>', "cameras but the first"),
        (BALL.format('<bsdf type="conductor"><string name="material" value="Cr"/></bsdf>'), "the metal 'Cr'"),
        (BALL.format('<bsdf type="conductor"><rgb name="eta" value="1"/></bsdf>'), "eta of conductor"),
        (BALL.format('<bsdf type="roughdielectric"/>'), "the roughness of glass"),
        (
            BALL.format('<bsdf type="principled"><float name="spec_trans" value="1"/></bsdf>'),
            "the roughness of glass",
        ),
        (
            BALL.format('<bsdf type="principled"><texture name="roughness" type="bitmap"/></bsdf>'),
            "textures of metal",
        ),
        (
            BALL.format(f'<bsdf type="roughplastic">{CHECKER.format("alpha", "")}</bsdf>'),
            "textures of roughness",
        ),
        (
            BALL.format(f'<bsdf type="conductor">{CHECKER.format("specular_reflectance", "")}</bsdf>'),
            "a checkerboard",
        ),
        (
            BALL.format('<bsdf type="diffuse"><texture type="volume" name="reflectance"/></bsdf>'),
            "the texture volume",
        ),
        (
            f'<shape type="cube"><bsdf type="diffuse">{CHECKER.format("reflectance", "")}</bsdf></shape>',
            "a checkerboard",
        ),
        (
            f"""<shape type="rectangle"><transform name="to_world"><scale x="2"/></transform>
             <bsdf type="diffuse">{CHECKER.format("reflectance", "")}</bsdf></shape>""",
            "the stretch of a checkerboard",
        ),
        (
            BALL.format('<boolean name="flip_normals" value="true"/><bsdf type="dielectric"/>'),
            "which side of glass is its inside",
        ),
        (
            BALL.format(
                '<emitter type="area"><texture type="bitmap" name="radiance">'
                '<string name="filename" value="wood.png"/></texture></emitter>'
            ),
            "textures of lights",
        ),
        (
            """<shape type="sphere"><bsdf type="blendbsdf"><texture name="weight" type="bitmap"/>
             <bsdf type="diffuse"/>
             <bsdf type="diffuse"/></bsdf></shape>""",
            "textures of a blend",
        ),
        (
            BALL.format('<transform name="to_world"><scale x="2"/></transform><emitter type="area"/>'),
            "a mesh sheds",
        ),
        ('<emitter type="envmap"><string name="filename" value="sky.exr"/></emitter>', "turns of an envmap"),
        (2 * '<emitter type="constant"/>', "surroundings but the last"),
        ('<emitter type="sunsky"/>', "the emitter sunsky"),
        ('<sensor type="orthographic"><transform name="to_world"><scale x="3" y="2"/></transform></sensor>',
         "the stretch of an orthographic view"),
        ('<sensor type="radiancemeter"/>', "the sensor radiancemeter"),
        (BALL.format('<emitter type="directionalarea"/>'), "the light of a directionalarea"),
        (BALL.format('<emitter type="area"/><bsdf type="diffuse"/>'), "the surfaces of lights"),
        (BALL.format('<bsdf type="twosided"><bsdf type="diffuse"/><bsdf type="plastic"/></bsdf>'),
         "a further bsdf of twosided"),
        (
            BALL.format("""<bsdf type="diffuse"><texture name="reflectance" type="bitmap">
          <string name="filename" value="wood.png"/>
          <transform name="to_uv"><rotate z="1" angle="9"/></transform>
          </texture></bsdf>"""),
            "rotations of textures",
        ),
    ],
)
def test_what_has_no_counterpart_is_named(body: str, name: str, tmp_path: Path) -> None:
    for picture in ("wood.png", "sky.exr"):
        shutil.copy(SCENES / picture, tmp_path)
    assert name in lost(tmp_path, body)


_PICTURE = '<texture {} type="checkerboard"/>'
_HOLDERS = {
    "sensor": ["perspective", "orthographic"],
    "film": ["hdrfilm"],
    "sampler": ["independent"],
    "rfilter": ["gaussian"],
    "integrator": ["path", "direct", "aov"],
    "emitter": ["point", "spot", "directional", "constant"],
    "area": ["area"],
    "bsdf": ["diffuse", "conductor", "roughconductor", "dielectric", "thindielectric", "roughdielectric",
             "plastic", "roughplastic", "principled", "twosided", "normalmap", "blendbsdf"],
    "texture": ["checkerboard"],
    "shape": ["sphere", "cylinder", "rectangle", "disk", "cube"],
}  # fmt: skip
_WITHIN = {"twosided": '<bsdf type="plastic"/>', "blendbsdf": 2 * '<bsdf type="plastic"/>'}
_AROUND = {
    "film": '<sensor type="perspective">{}</sensor>',
    "rfilter": '<sensor type="perspective"><film type="hdrfilm">{}</film></sensor>',
    "sampler": '<sensor type="perspective">{}</sensor>',
    "area": BALL, "bsdf": BALL,
    "texture": BALL.format('<bsdf type="diffuse">{}</bsdf>'),
}  # fmt: skip
_INNER = [
    _PICTURE.format(""), *(_PICTURE.format(f'name="{name}"') for name in (
        "reflectance", "specular_reflectance", "alpha", "k", "base_color", "metallic", "sheen", "weight",
        "opacity", "radiance", "intensity", "texture", "color0", "to_world", "nonsense")),
    '<bsdf type="plastic"/>', '<bsdf type="conductor" name="nested_bsdf"/>', '<emitter type="area"/>',
    '<film type="hdrfilm"><integer name="width" value="9"/></film>', '<sampler type="independent"/>',
    '<rfilter type="tent"/>', '<medium type="homogeneous" name="interior"/>', '<phase type="hg"/>',
    '<volume type="constvolume" name="albedo"/>', '<shape type="cube"/>', '<integrator type="direct"/>',
    '<sensor type="orthographic"/>', '<ref id="wood"/>', '<ref id="wood" name="diffuse_reflectance"/>',
]  # fmt: skip


@pytest.mark.parametrize(("tag", "kind"), [(tag, kind) for tag, kinds in _HOLDERS.items() for kind in kinds])
def test_nothing_that_stands_in_an_object_is_lost_without_a_word(tag: str, kind: str, tmp_path: Path) -> None:
    """Whatever is put into whatever: the scene is another one, the warning says more, or it is refused."""
    shutil.copy(SCENES / "wood.png", tmp_path)
    name = 'name="reflectance"' if tag == "texture" else ""
    picture = '<texture type="bitmap" name="normalmap"><string name="filename" value="wood.png"/></texture>'
    own = picture + '<bsdf type="diffuse"/>' if kind == "normalmap" else _WITHIN.get(kind, "")
    around, element = _AROUND.get(tag, "{}"), "emitter" if tag == "area" else tag

    def said(inner: str) -> tuple[str, str]:
        body = around.format(f'<{element} type="{kind}" {name}>{own}{inner}</{element}>')
        top = '<texture id="wood" type="checkerboard"/>'
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            try:
                scene = str(table(tmp_path, top + body))
            except clrt.ClrtError as error:
                scene = str(error)
        return scene, " ".join(str(one.message) for one in found)

    before, known = said(""), []
    for inner in _INNER:
        assert said(inner) != before, (kind, inner)
        known.append(said(inner)[0] != before[0])
    assert not all(known)


def test_what_is_named_by_reference_is_asked_for_where_it_is_named(tmp_path: Path) -> None:
    """A texture that one plugin shows is still lost in another; one that nobody names is nobody's."""
    top = '<texture id="wood" type="checkerboard"/><texture id="none" type="checkerboard"/>'
    shown = BALL.format('<bsdf type="diffuse"><ref id="wood" name="reflectance"/></bsdf>')
    read(tmp_path, top + shown)
    both = shown + BALL.format('<bsdf type="plastic"><ref id="wood" name="specular_reflectance"/></bsdf>')
    assert lost(tmp_path, top + both).endswith(", the texture 'specular_reflectance' of plastic")


def test_a_checker_around_a_sphere(tmp_path: Path) -> None:
    to_uv = '<transform name="to_uv"><scale x="8" y="4"/></transform>'
    color = material(tmp_path, f'<bsdf type="diffuse">{CHECKER.format("reflectance", to_uv)}</bsdf>')["color"]
    assert color == {"type": "checker", "colors": [0.4, 0.2]}  # 16 of them, which is the default


def test_a_picture_of_a_principled(tmp_path: Path) -> None:
    shutil.copy(SCENES / "wood.png", tmp_path)
    found = material(tmp_path, """<bsdf type="principled"><texture name="base_color" type="bitmap">
      <string name="filename" value="wood.png"/></texture></bsdf>""")  # fmt: skip
    assert found["color"] == {"type": "image", "file": "wood.png"}
    blend = """<bsdf type="blendbsdf"><bsdf type="diffuse"/><bsdf type="diffuse"><texture type="bitmap"
      name="reflectance"><string name="filename" value="wood.png"/></texture></bsdf></bsdf>"""  # fmt: skip
    assert "the weaker diffuse" in lost(tmp_path, BALL.format(blend))
