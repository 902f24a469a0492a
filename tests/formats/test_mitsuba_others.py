"""What Mitsuba's own scenes and exporters write beside shapes and materials: as Mitsuba has it, or named."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from tests.mitsuba_samples import read, table


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
