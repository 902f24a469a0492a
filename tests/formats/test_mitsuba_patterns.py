"""What of Mitsuba's plugins has no counterpart is named; checkers and pictures, which have one in part."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.mitsuba_samples import BALL, SCENES, lost, material

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
            "flip normals of glass",
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
