"""Normal maps of Mitsuba's files: where they lie, and which way their green leans."""

from __future__ import annotations

import shutil
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.scene.scene import Mesh, NormalMap, Placement
from tests.mitsuba_samples import BALL, SCENES, WOOD, read
from tests.pictured import put

MOVED = """<transform name="to_uv"><scale x="2" y="3"/><translate x="0.1" y="0.2"/></transform>
<string name="wrap_mode" value="mirror"/><string name="filter_type" value="nearest"/>"""
PLACED = Placement(scale=(2, 3), offset=(0.1, 0.2), wrap="mirror", filter="nearest")
OVER = Placement(scale=(2, -3), offset=(0.1, 3.2), wrap="mirror", filter="nearest")
PLY = """ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
property float s
property float t
element face 1
property list uchar int vertex_indices
end_header
0 0 0 0 0
1 0 0 1 0
0 1 0 0 1
3 0 1 2
"""


FLIPPED = (0, 0, 1, 1)


def bumps(how: str = "", inner: str = "", file: str = "tile-normals.png") -> str:
    return f"""<bsdf type="normalmap"><texture name="normalmap" type="bitmap">{how}
      <string name="filename" value="{file}"/></texture><bsdf type="diffuse">{inner}</bsdf></bsdf>"""


def colored(how: str = "") -> str:
    return f'<texture name="reflectance" type="bitmap">{WOOD}{how}</texture>'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("wood.png", "tile-normals.png"):
        shutil.copy(SCENES / name, tmp_path)
    (tmp_path / "a.ply").write_text(PLY)
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n")
    return tmp_path


def found(folder: Path, shape: str) -> Any:
    scene = read(folder, shape)
    return scene.material_of(scene.shapes[0]).normal_map


@pytest.mark.parametrize(
    ("bsdf", "placement"),
    [
        (bumps(), None),
        (bumps(MOVED), PLACED),
        (bumps(MOVED, colored(MOVED)), None),
        (bumps("", colored(MOVED)), Placement()),
        (bumps(MOVED, colored()), PLACED),
        (f'<bsdf type="blendbsdf"><float name="weight" value="0.9"/>{bumps(MOVED, colored(MOVED))}'
         '<bsdf type="conductor"/></bsdf>', None),
        (f'<bsdf type="blendbsdf"><float name="weight" value="0.9"/>{bumps(MOVED, colored(MOVED))}'
         f'<bsdf type="diffuse">{colored()}</bsdf></bsdf>', PLACED),
    ],
)
def test_a_map_lies_as_its_own_bitmap_says(folder: Path, bsdf: str, placement: Placement | None) -> None:
    assert found(folder, BALL.format(bsdf)) == NormalMap(file="tile-normals.png", placement=placement)


@pytest.mark.parametrize(
    ("bsdf", "placement"),
    [
        (bumps(), Placement(scale=(1, -1), offset=(0, 1))), (bumps(MOVED), OVER),
        (bumps("", colored()), None), (bumps(MOVED, colored()), OVER),
    ],
)  # fmt: skip
@pytest.mark.parametrize("shape", ["ply", "obj"])
def test_a_map_is_turned_over_as_other_pictures_are(
    folder: Path, shape: str, bsdf: str, placement: Placement | None
) -> None:
    """Of a PLY, and of an OBJ that says so, Mitsuba reads v as it stands."""
    file = f'<string name="filename" value="a.{shape}"/>'
    for flip in (False, True):
        keys = f'{file}<boolean name="flip_tex_coords" value="{str(flip).lower()}"/>'
        there = found(folder, f'<shape type="{shape}">{keys}{bsdf}</shape>')
        if not flip:
            assert there == NormalMap(file="tile-normals.png", placement=placement)
        else:
            assert there.placement in (None, PLACED)


@pytest.mark.parametrize(("flip", "across"), [(False, 1), (True, 1), (False, -1), (True, -1)])
def test_green_leans_across_u_on_a_rectangle(folder: Path, flip: bool, across: int) -> None:
    """Mitsuba's frame: the normal, the way of u and their cross product, on the side that it looks to."""
    put(folder / "lean.exr", np.full((2, 2, 3), (0.5, 0.9, 0.8)))
    shape = f"""<shape type="rectangle"><boolean name="flip_normals" value="{str(flip).lower()}"/>
      <transform name="to_world"><scale x="{across}"/></transform>{bumps(file="lean.exr")}</shape>"""
    side = -1.0 if flip else 1.0
    green = side * across  # along y: side z x across x
    scene = read(folder, f"""{shape}<emitter type="directional">
      <vector name="direction" x="0" y="{-green}" z="{-side}"/></emitter>""")
    with clrt.Tracer(scene.replace({"ambient": 0.0})) as tracer:
        seen = tracer.radiance([[0.3, 0.2, side]], [[0.0, 0.0, -side]])[0][0, 0]
    light = 1 / np.pi / np.sqrt(2)
    assert seen == pytest.approx(0.5 * light * (0.8 + 0.6), rel=1e-5)


def test_a_rectangle_shows_its_picture_the_same_way_with_a_map(folder: Path) -> None:
    plain, bent = (
        read(folder, f'<shape type="rectangle">{bsdf}</shape>')
        for bsdf in (f'<bsdf type="diffuse">{colored(MOVED)}</bsdf>', bumps("", colored(MOVED)))
    )
    rows = []
    for scene in (plain, bent):
        (mesh,), color = scene.shapes, scene.material_of(scene.shapes[0]).color
        assert isinstance(mesh, Mesh)
        rows.append(np.asarray(mesh.data().uv) * color.scale + color.offset)
    np.testing.assert_allclose(rows[0], rows[1], atol=1e-12)
    assert bent.material_of(bent.shapes[0]).normal_map.placement == Placement(scale=(1, -1), offset=(0, 1))


@pytest.mark.parametrize(
    ("shape", "as_it_is", "fronts"),
    [("sphere", (0, 0, 1, 1), FLIPPED), ("cube", (0, 1, 1, 0), FLIPPED), ("cylinder", (1, 0, 0, 1), FLIPPED),
     ("disk", (1, 0, 0, 1), FLIPPED), ("a.obj", (0, 0, 1, 1), (0, 1, 1, 0)),
     ("stated.obj", (0, 1, 1, 0), FLIPPED), ("back.obj", (1, 1, 0, 0), (0, 1, 1, 0)),
     ("stated-back.obj", (1, 0, 0, 1), FLIPPED), ("a.ply", (0, 0, 1, 1), (0, 1, 1, 0)),
     ("rectangle", (0, 0, 0, 0), (0, 0, 0, 0))],
)  # fmt: skip
def test_green_that_leans_the_other_way_is_named(
    folder: Path, shape: str, as_it_is: tuple[int, ...], fronts: tuple[int, ...]
) -> None:
    """And where the front there is the back here, from which all of the map is turned over. As they
    are, mirrored, with normals flipped, both: where Mitsuba's own pictures differ from ours.

    Normals that a file states go with a mirror, others with the faces; u of a file may run back.
    """
    flat, turned = (folder / "a.obj").read_text(), "vt 0 0\nvt -1 0\nvt 0 1"
    back = flat.replace("vt 0 0\nvt 1 0\nvt 0 1", turned)
    stated = [text.replace("f 1/1 2/2 3/3", "vn 0 0 1\nf 1/1/1 2/2/1 3/3/1") for text in (flat, back)]
    for name, text in {"stated": stated[0], "back": back, "stated-back": stated[1]}.items():
        (folder / f"{name}.obj").write_text(text)
    file, shape = (f'<string name="filename" value="{shape}"/>' if "." in shape else ""), shape.split(".")[-1]
    cases = [(across, flip) for flip in ("false", "true") for across in (1, -1)]
    for (across, flip), told, front in zip(cases, as_it_is, fronts, strict=True):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            read(folder, f"""<shape type="{shape}">{file}<boolean name="flip_normals" value="{flip}"/>
              <transform name="to_world"><scale x="{across}"/></transform>{bumps()}</shape>""")
        said = " ".join(str(warning.message) for warning in caught)
        assert (f"green of a normal map leans on a {shape}" in said) == bool(told), (across, flip)
        assert (f"which side of a {shape} is the front of" in said) == bool(front), (across, flip)


def test_shapes_that_refer_to_one_map_have_one_material(folder: Path) -> None:
    named = bumps(MOVED, colored(MOVED)).replace('type="normalmap"', 'type="normalmap" id="m"', 1)
    refer = '<ref id="m"/></shape>'
    scene = read(folder, f'{named}<shape type="rectangle">{refer}<shape type="rectangle">{refer}')
    one, other = (scene.material_of(shape) for shape in scene.shapes)
    assert one.normal_map is not None and one == other


@pytest.mark.parametrize(
    ("shape", "inside_out"),
    [("sphere", (0, 1, 1, 0)), ("cube", (0, 0, 1, 1)), ("out.obj", (0, 1, 1, 0)),
     ("stated.obj", (0, 0, 1, 1)), ("against.obj", (1, 1, 0, 0))],
)  # fmt: skip
def test_glass_that_is_inside_out_is_named(folder: Path, shape: str, inside_out: tuple[int, ...]) -> None:
    """As they are, mirrored, with normals flipped, both; of a mesh the normals that it states tell there.

    As compared with Mitsuba 3.9.1's pictures under an envmap. Thin glass has no inside.
    """
    points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    faces = [(1, 3, 2), (1, 2, 4), (1, 4, 3), (2, 3, 4)]
    plain = "".join(f"f {a} {b} {c}\n" for a, b, c in faces)
    normals = "vn -1 -1 -1\nvn 1 -1 -1\nvn -1 1 -1\nvn -1 -1 1\n"
    stated = normals + "".join(f"f {a}//{a} {b}//{b} {c}//{c}\n" for a, b, c in faces)
    against = normals + "".join(f"f {a}//{a} {c}//{c} {b}//{b}\n" for a, b, c in faces)
    for name, text in {"out": plain, "stated": stated, "against": against}.items():
        (folder / f"{name}.obj").write_text(points + text)
    file, kind = (f'<string name="filename" value="{shape}"/>' if "." in shape else ""), shape.split(".")[-1]
    cases = [(across, flip) for flip in ("false", "true") for across in (1, -1)]
    for glass in ("dielectric", "thindielectric"):
        for (across, flip), told in zip(cases, inside_out, strict=True):
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                how = f'<boolean name="flip_normals" value="{flip}"/><bsdf type="{glass}"/>'
                how += f'<transform name="to_world"><scale x="{across}"/></transform>'
                read(folder, f'<shape type="{kind}">{file}{how}</shape>')
            said = " ".join(str(warning.message) for warning in caught)
            assert ("which side of glass is its inside" in said) == bool(told and glass == "dielectric")
