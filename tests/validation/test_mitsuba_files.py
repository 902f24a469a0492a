"""Scenes as Mitsuba's XML."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import clrt
from clrt.base.errors import ClrtError
from clrt.cli import main
from tests.mitsuba_rooms import (
    CAMERA,
    CHECKER,
    GREY,
    HEIGHT,
    MATTE,
    NEAR,
    SCENES,
    WIDTH,
    as_read,
    off,
    ours,
    room,
    stock_room,
)
from validation.oracle_mitsuba import faces, meshing, stock
from validation.oracle_mitsuba.reading import read
from validation.oracle_mitsuba.shapes import Box
from validation.oracle_mitsuba.xml import to_xml, write_xml


def test_xml_is_the_scene(mitsuba: Any, tmp_path: Path) -> None:
    """The file, read by Mitsuba, gives the picture that the scene gives."""
    materials = {"floor": CHECKER, "a": CHECKER, "b": MATTE, "c": GREY, "d": MATTE}
    scene = stock_room(materials, {"lights": [NEAR], "background": 0.0})
    file = tmp_path / "room.xml"
    write_xml(as_read(scene), file)
    assert len(list((tmp_path / "room_meshes").iterdir())) == 3  # box, cone and ellipsoid
    (render,) = stock.work(read(scene), "S1", None).renders
    job = {
        **render,
        "scene": {"type": "file", "path": str(file)},
        "owners": {},
        "eye": np.array(CAMERA["origin"]),
    }
    (answer,) = mitsuba.request("stock", {"renders": [job]})
    assert (
        off(answer["mean"].reshape(HEIGHT, WIDTH, 3), ours(scene).pixels, 1e-3) <= 2e-3
    )  # meshes are coarser in files


def test_xml_says_what_it_changes() -> None:
    scene = as_read(room(SCENES["schlick, thin, emission"]["materials"], background="sky.exr"))
    text = to_xml(scene)
    tree = ElementTree.fromstring(text)
    kinds = {element.get("type") for element in tree.iter()}
    assert {"perspective", "rectangle", "sphere", "ply", "point", "directional", "envmap", "area"} <= kinds
    assert {"blendbsdf", "thindielectric"} <= kinds
    for note in ("ambient", "specular", "falloff", "emission", "fresnel"):
        assert note in text.split("<integrator")[0]


def test_convert_writes_xml(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "gallery.xml"
    assert main(["convert", "gallery", str(out)]) == 0
    tree = ElementTree.parse(out)
    names = [element.get("value") for element in tree.iter("string") if element.get("name") == "filename"]
    assert names and all((tmp_path / str(name)).is_file() for name in names)
    assert "Mitsuba lacks" in capsys.readouterr().err
    (tmp_path / "sky_meshes").write_text("in the way")
    assert main(["convert", "gallery", str(tmp_path / "sky.xml")]) == 2
    assert capsys.readouterr().err.count("\n") == 1 and not (tmp_path / "sky.xml").exists()
    assert main(["convert", "gallery", str(tmp_path / "nowhere" / "sky.xml")]) == 2


def test_outlines_that_cross_themselves_take_little_more_than_to_be_cut_up() -> None:
    """Where a point is inside was asked piece by piece, and took thrice as long as the pieces."""
    shapely = pytest.importorskip("shapely", reason="needs the optional dependency clrt[validation]")
    pytest.importorskip("mapbox_earcut", reason="needs the optional dependency clrt[validation]")

    def star(count: int) -> np.ndarray:
        angle = 2 * np.pi * np.arange(count) * (count // 2) / count
        return np.round(np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1), 6)

    def taken(work: Any) -> float:
        start = time.process_time()
        work()
        return time.process_time() - start

    outline = star(151)
    lines = shapely.LineString([*outline, outline[0]])
    alone = min(taken(lambda: shapely.polygonize([shapely.unary_union(lines)])) for _ in range(3))
    assert min(taken(lambda: meshing.polygon(outline)) for _ in range(3)) < 2.7 * alone
    for count in (5, 7, 9):
        places, faces = meshing.polygon(star(count))
        a, b, c = (places[faces[:, k]] for k in range(3))
        area = np.cross(b - a, c - a)[:, 2] / 2
        right = shapely.make_valid(shapely.Polygon(star(count)[:, :2])).area
        assert area.min() > 0 and area.sum() == pytest.approx(right, rel=1e-9)


def test_a_missing_package_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)

    monkeypatch.setattr(meshing, "import_module", missing)
    square = {"type": "polygon", "points": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]}
    with pytest.raises(ClrtError, match=r"need mapbox_earcut; .* 'clrt\[validation\]'|need shapely"):
        write_xml(clrt.load_dict({"shapes": [square]}), tmp_path / "room.xml")


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_boxes_are_made_whole(turn: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not side by side, which took a millisecond each; their outer sides stay outside, mirrored or not."""
    monkeypatch.setattr(meshing, "polygon", lambda outline: pytest.fail("a side by itself"))
    matrix = np.array([[turn, 0.3, 0, 1], [0, 2, 0.1, 2], [0, 0, 1, 3], [0, 0, 0, 1]])
    low, high = (-0.1, -0.2, -0.3), (0.7, 0.1, 0.4)
    mesh, smooth = faces.triangles(Box(min=low, max=high, transform=matrix.tolist()))
    assert not smooth
    corners = mesh.vertices[mesh.faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    volume = np.einsum("mk,mk->m", corners[:, 0], across).sum() / 6
    assert volume == pytest.approx(0.8 * 0.3 * 0.7 * 2) and len(corners) == 12
    assert (np.einsum("mk,mk->m", across, mesh.normals[mesh.faces[:, 0]]) > 0).all()
    at = {tuple(corner) for corner in mesh.vertices.round(9).tolist()}
    picks = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, 8)
    assert at == {tuple(c) for c in (matrix[:3, :3] @ picks + matrix[:3, 3:]).T.round(9).tolist()}
    flat, _ = faces.triangles(Box(min=(0, 0, 0), max=(1, 0, 1)))
    assert len(flat.faces) == 4


@pytest.mark.parametrize(
    ("more", "place"),
    [
        ({"spectrum": {"bands": 8}}, "spectrum"),
        ({"ambient": {"blackbody": 4000}}, "ambient"),
        ({"background": "D65"}, "background"),
        ({"lights": [{"type": "point", "position": [0, 5, 0], "intensity": "A"}]}, r"lights\[0\]\.intensity"),
        ({"materials": {"m": {"conductor": "gold"}}}, r"shapes\[0\]\.material\.conductor"),
        ({"materials": {"m": {"color": "patch-3"}}}, r"shapes\[0\]\.material\.color"),
    ],
)
def test_spectra_are_refused(more: dict[str, Any], place: str) -> None:
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "m"}
    scene = clrt.load_dict({"shapes": [ball], "materials": {"m": {}}, **more})
    with pytest.raises(clrt.ClrtError, match=rf"^{place}: .* red, green and blue only"):
        to_xml(scene)


@pytest.mark.parametrize("others", [[], [{"type": "sphere", "center": [0, 0, 0], "radius": 1}]])
def test_a_mesh_without_faces_is_left_out(others: list[Any], tmp_path: Path) -> None:
    mesh = {"type": "mesh", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": []}
    scene = clrt.load_dict({
        "ambient": 1.0, "camera": {"origin": [0, 0, 5], "target": [0, 0, 0]}, "shapes": [mesh, *others],
    })  # fmt: skip
    write_xml(scene, tmp_path / "a.xml")
    assert "<shape" not in (tmp_path / "a.xml").read_text() or others
    assert list((tmp_path / "a_meshes").glob("*")) == [] if not others else True
