"""Concave faces of OBJ and PLY files, cut into triangles; shapely judges what these cover."""

from __future__ import annotations

import math
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from clrt.base.limits import Limits
from clrt.base.places import At
from clrt.meshfiles import outlines
from clrt.meshfiles.file import open_mesh, read_mesh_file

pytest.importorskip("trimesh", reason="needs the optional dependency clrt[mesh]")
pytest.importorskip("mapbox_earcut", reason="needs the optional dependency clrt[mesh]")
shapely = pytest.importorskip("shapely", reason="needs the optional dependency clrt[validation]")

DART = [(2, 0), (0.5, 0.5), (0, 2), (0, 0)]
ELL = [(2, 0), (2, 1), (1, 1), (1, 2), (0, 2), (0, 0)]
HOUSE = [(0, 0), (2, 0), (2, 1), (1, 2), (0, 1)]
STAR = [(math.cos(k * 0.8 * math.pi), math.sin(k * 0.8 * math.pi)) for k in range(5)]
HOURGLASS = [(0, 0), (1, 1), (1, 0), (0, 1)]
# Cells on a lattice, turned by 0.3 with all lattice points as corners: ear clipping loses one to rounding.
LOST = np.array(
    [(1, -2), (0, -2), (-1, -2), (-2, -2), (-2, -1), (-2, 0), (-1, 0), (-1, -1), (0, -1), (0, 0), (0, 1),
     (-1, 1), (-2, 1), (-2, 2), (-1, 2), (0, 2), (1, 2), (1, 1), (2, 1), (2, 0), (2, -1), (2, -2)],
) @ [[math.cos(0.3), -math.sin(0.3)], [math.sin(0.3), math.cos(0.3)]]  # fmt: skip


def write(path: Path, faces: list[Any], more: str = "") -> Path:
    """A file of separate faces of points (x, y), in the plane z = 0."""
    lists, points = [], []
    for face in faces:
        lists.append([len(points) + k for k in range(len(face))])
        points += [(float(x), float(y), 0.0) for x, y in face]
    if path.suffix == ".obj":
        lines = ["v {!r} {!r} {!r}".format(*point) for point in points]
        lines += ["f " + " ".join(str(k + 1) for k in numbers) for numbers in lists]
    else:
        lines = ["ply", "format ascii 1.0", f"element vertex {len(points)}",
                 *(f"property double {axis}" for axis in "xyz"), f"element face {len(lists)}",
                 "property list int int vertex_indices", "end_header"]  # fmt: skip
        lines += ["{!r} {!r} {!r}".format(*point) for point in points]
        lines += [" ".join(map(str, [len(numbers), *numbers])) for numbers in lists]
    path.write_text("\n".join([*lines, more]))
    return path


def read(path: Path) -> tuple[np.ndarray, list[str]]:
    """The triangles' corners (m, 3, 3), and what was warned of."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        vertices, faces, _, _ = read_mesh_file(path, At(path="mesh"), Limits(), False)
    return vertices[faces], [str(warning.message) for warning in said]


def lattice(random: np.random.Generator, cells: int) -> np.ndarray:
    """A simple polygon of unit squares, whose corners are all lattice points of its outline; no holes."""
    found = [(0, 0)]
    while True:
        x, y = found[random.integers(len(found))]
        step = [(1, 0), (-1, 0), (0, 1), (0, -1)][random.integers(4)]
        found = list(dict.fromkeys([*found, (x + step[0], y + step[1])]))
        whole = shapely.union_all([shapely.box(x, y, x + 1, y + 1) for x, y in found])
        if len(found) >= cells and whole.geom_type == "Polygon" and not whole.interiors:
            return np.array(shapely.segmentize(whole, 1.0).exterior.coords)[:-1]


def radial(random: np.random.Generator, size: int) -> np.ndarray:
    """A star-shaped polygon."""
    angles = 2 * np.pi * (np.arange(size) + random.random(size)) / size
    return random.uniform(0.2, 2, size)[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)


@pytest.mark.parametrize("suffix", [".obj", ".ply"])
def test_triangles_cover_a_face_and_no_more(tmp_path: Path, suffix: str) -> None:
    random = np.random.default_rng(11)
    faces: list[Any] = [LOST, DART, ELL, HOUSE]
    for k in range(60):
        face = lattice(random, 2 + k % 12) if k % 2 else radial(random, 4 + k % 9)
        turn = random.uniform(0, 6)
        face = face @ [[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]]
        faces.append(np.roll(face[:: (-1) ** (k // 2)], random.integers(len(face)), axis=0))
    faces = [np.add(face, [20.0 * k, 0.0]) for k, face in enumerate(faces)]
    found, said = read(write(tmp_path / f"a{suffix}", faces))
    assert not said
    assert len(found) == sum(len(face) - 2 for face in faces)
    outline = {k: shapely.Polygon(face) for k, face in enumerate(faces)}
    mine: dict[int, list[np.ndarray]] = {k: [] for k in outline}
    for three in found[..., :2]:
        mine[round(three[:, 0].mean() / 20)].append(three)
    for k, face in enumerate(faces):
        triangles = np.array(mine[k])
        sides = np.roll(triangles, -1, axis=1) - triangles
        areas = 0.5 * (sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0])
        assert len(triangles) == len(face) - 2
        # of some tens of terms of 53 bits, at up to 1300 units from the origin
        assert areas.sum() == pytest.approx(shapely.Polygon(face).area * _turns(face), abs=1e-9)
        assert np.abs(areas).sum() == pytest.approx(outline[k].area, abs=1e-9)  # so none lies on another
        assert shapely.covers(outline[k].buffer(1e-9), shapely.polygons(triangles)).all()
        assert _edges(face[None]) <= _edges(triangles)


def _edges(faces: np.ndarray) -> set[frozenset[tuple[float, ...]]]:
    """The edges of faces (m, n, 2), their ends to 1e-6."""
    pairs = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2, 2).round(6)
    return {frozenset(map(tuple, pair.tolist())) for pair in pairs}


def _turns(face: np.ndarray) -> int:
    """1 where a face runs counter-clockwise, else -1."""
    return 1 if shapely.LinearRing(face).is_ccw else -1


@pytest.mark.parametrize("suffix", [".obj", ".ply"])
def test_faces_that_a_fan_covers_stay_as_trimesh_cuts_them(tmp_path: Path, suffix: str) -> None:
    import trimesh

    angles = 2 * np.pi * np.arange(9) / 9
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1).round(3)  # of decimals: hardly ever convex
    good = np.roll(DART, -1, axis=0)
    path = write(tmp_path / f"a{suffix}", [ring, HOUSE, good, HOUSE[:4], HOUSE[:3]])
    plain = trimesh.load(path, process=False)
    assert np.array_equal(read(path)[0], plain.vertices[plain.faces])


@pytest.mark.parametrize("normals", [True, False])
def test_what_corners_have_goes_with_them(tmp_path: Path, normals: bool) -> None:
    lines = []
    for k, face in enumerate((ELL, DART)):
        lines += [f"v {x} {y} {k}" for x, y in face] + [f"vt {x / 4} {y / 4}" for x, y in face]
        lines += [f"vn {x} {y} 1" for x, y in face]
    corner = "{0}/{0}/{0}" if normals else "{0}/{0}"
    lines += ["f " + " ".join(corner.format(k) for k in range(*ends)) for ends in ((1, 7), (7, 11))]
    (tmp_path / "a.obj").write_text("\r\n".join(lines))
    vertices, faces, given, uv = read_mesh_file(tmp_path / "a.obj", At(path="mesh"), Limits(), None)
    assert len(faces) == 6
    assert uv is not None
    assert np.allclose(uv * (4, -4) + (0, 4), vertices[:, :2], atol=1e-12)
    if normals:
        assert given is not None
        assert np.allclose(given[:, :2] / given[:, 2:], vertices[:, :2], atol=1e-6)


@pytest.mark.parametrize("kind", ["vertex", "face"])
def test_colours_of_a_ply_go_with_their_faces(tmp_path: Path, kind: str) -> None:
    """A dart's and a square's: all four corners, or both halves, have one colour."""
    colors = [(255, 0, 0), (0, 0, 255)]
    faces = [DART, [(9, 0), (10, 0), (10, 1), (9, 1)]]
    text = write(tmp_path / "plain.ply", faces).read_text().splitlines()
    props = [f"property uchar {name}" for name in ("red", "green", "blue")]
    for k, line in list(enumerate(text))[::-1]:
        if line.startswith("property double z" if kind == "vertex" else "property list"):
            text[k + 1 : k + 1] = props
    body = text.index("end_header") + 1
    first, count, each = (body, 8, 4) if kind == "vertex" else (body + 8, 2, 1)
    for k in range(count):
        text[first + k] += " {} {} {}".format(*colors[k // each])
    (tmp_path / "a.ply").write_text("\n".join(text))
    path = tmp_path / "a.ply"
    placed = open_mesh(path.read_bytes(), path, At(path="mesh"), Limits())
    part = placed.parts[0]
    assert part.corners is not None
    vertices, triangles = part.read()[:2]
    if kind == "vertex":
        red = vertices[triangles][:, :, 0] < 5
        assert np.array_equal(part.corners()[:, :, 0] > 0.5, red)
    area = np.cross(*np.moveaxis(np.diff(vertices[triangles], axis=1), 1, 0))[:, 2].sum() / 2
    assert area == pytest.approx(2.0)


@pytest.mark.parametrize("suffix", [".obj", ".ply"])
@pytest.mark.parametrize("face", [STAR, HOURGLASS])
def test_faces_that_cross_themselves_are_told_in_a_line(tmp_path: Path, suffix: str, face: Any) -> None:
    found, said = read(write(tmp_path / f"a{suffix}", [face, DART, face, HOUSE]))
    assert len(said) == 1
    assert "a" + suffix + ": its faces that cross themselves or are far from plane" in said[0]
    triangles = [sorted(map(tuple, three[:, :2].tolist())) for three in found]
    fans = [[face[0], face[k], face[k + 1]] for k in range(1, len(face) - 1)]
    for fan in fans:
        assert triangles.count(sorted((float(x), float(y)) for x, y in fan)) == 2


def test_without_the_package_larger_faces_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mapbox_earcut", None)
    assert not read(write(tmp_path / "a.obj", [DART, HOUSE]))[1]
    (said,) = read(write(tmp_path / "b.obj", [DART, ELL]))[1]
    assert "more than 4 corners" in said
    assert "install mapbox-earcut with: " in said


def test_without_the_package_another_may_clip(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mapbox_earcut", None)
    right = np.array([[2, 3, 4], [2, 4, 5], [5, 0, 1], [1, 2, 5]])
    cutter = outlines.Outlines(lambda points, ends: right)
    rows, cuts = cutter.cut(np.insert(np.array(ELL, float), 2, 0.0, axis=1), np.array([[*range(6)]]))
    assert rows.tolist() == [0] and np.array_equal(cuts[0], right) and not cutter.left_over


def test_what_would_take_long_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    comb = [(k, 1 if k % 2 else 3) for k in range(100)] + [(99, 0), (0, 0)]
    assert not read(write(tmp_path / "a.obj", [ELL, comb, comb]))[1]
    monkeypatch.setattr(outlines, "_MOST", 15000)
    found, said = read(write(tmp_path / "a.obj", [ELL, comb, comb]))
    assert len(said) == 1
    assert "too many or too large to be cut well" in said[0]
    assert len(found) == 204


def test_faces_without_area_are_passed_over(tmp_path: Path) -> None:
    line = [(0, 0), (1, 1), (3, 3), (2, 2), (0.1, 0.1)]
    tenths = [(k * 0.1, k * 0.3) for k in (0, 7, 3, 9, 1, 6)]  # in a line but for rounding
    found, said = read(write(tmp_path / "a.obj", [line, line[:4], [(0, 0)] * 5, tenths, DART]))
    assert not said
    assert len(found) == 14


def test_triangles_that_lie_on_one_another_stay(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_text("v 0 0 0\nv 2 0 0\nv 0.5 0.5 0\nv 0 2 0\nf 2 3 4\nf 2 4 1\n")
    found, said = read(path)
    assert not said
    assert found[:, :, :2].tolist() == [[[2, 0], [0.5, 0.5], [0, 2]], [[2, 0], [0, 2], [0, 0]]]


def test_a_ply_may_call_its_lists_otherwise() -> None:
    corners = np.array([*DART, *DART], float)
    vertices = np.concatenate([corners, np.zeros((8, 1))], axis=1)
    fans = np.array([[0, 1, 2], [4, 5, 6], [2, 3, 0], [6, 7, 4]])
    rows = np.zeros(2, [("corners", [("f0", "u1"), ("f1", "<i4", 4)])])
    rows["corners"]["f1"] = [[0, 1, 2, 3], [4, 5, 6, 7]]
    cut = [[1, 2, 3], [5, 6, 7], [3, 0, 1], [7, 4, 5]]
    assert outlines.Outlines().ply(vertices, fans, {"face": {"data": rows}}).tolist() == cut
    for data in (None, {"corners": [[0, 1, 2, 3]]}):
        assert outlines.Outlines().ply(vertices, fans, {"face": {"data": data}}) is fans
