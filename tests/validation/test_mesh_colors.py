"""Colours of a PLY's vertices and faces against Mitsuba's attributes of meshes, which it reads by itself."""

from __future__ import annotations

from pathlib import Path

import pytest

from clrt.base.resources import validation_module

cases = validation_module("cases")
worker = validation_module("suite.worker")
_CORNERS = [(0, 0, 0, 255, 0, 0), (3, 0, 0.4, 0, 255, 0), (3, 2, -0.3, 0, 0, 255), (0, 2, 0.2, 255, 255, 255),
            (0, 4, 0, 9, 80, 200)]  # fmt: skip
_FACES = [(0, 1, 2), (0, 2, 3), (3, 2, 4)]
_SCENE = """
ambient = 0.3
background = [0.1, 0.2, 0.3]
camera = { origin = [1.5, 2.2, 7.0], target = [1.5, 1.9, 0.0], fov = 38.0, width = 96, height = 72 }
lights = [{ type = "point", position = [4.0, 5.0, 6.0] }]

[[shapes]]
type = "mesh"
file = "scan.ply"
part = 0
smooth = SMOOTH
material = { color = { type = "image", file = "scan.ply", part = 0, wrap = "clamp" }, diffuse = 0.8 }

[[shapes]]
type = "sphere"
center = [1.0, 1.6, 1.2]
radius = 0.5
material = { diffuse = 0.4, reflection = 0.5 }
"""


def scan(path: Path, of_faces: bool) -> None:
    """Three triangles with a colour at each corner, or on each face."""
    color = "property uchar red\nproperty uchar green\nproperty uchar blue\n"
    head = "ply\nformat ascii 1.0\nelement vertex 5\n" + "".join(f"property float {a}\n" for a in "xyz")
    head += "" if of_faces else color
    head += "element face 3\nproperty list uchar int vertex_indices\n" + (color if of_faces else "")
    rows = [" ".join(map(str, corner[: 3 if of_faces else 6])) for corner in _CORNERS]
    last = [_CORNERS[face[1]][3:] if of_faces else () for face in _FACES]
    rows += [" ".join(map(str, (3, *face, *color))) for face, color in zip(_FACES, last, strict=True)]
    path.write_text(f"{head}end_header\n" + "\n".join(rows) + "\n", "utf-8")


@pytest.mark.parametrize(("of_faces", "smooth"), [(False, False), (True, False), (False, True)])
def test_colors_are_those_of_mitsubas_attributes(of_faces: bool, smooth: bool, tmp_path: Path) -> None:
    scan(tmp_path / "scan.ply", of_faces)
    (tmp_path / "scene.toml").write_text(_SCENE.replace("SMOOTH", str(smooth).lower()), "utf-8")
    name = cases.own_case(str(tmp_path / "scene.toml"))
    found = worker.run_case(worker.Task(name, ("oracle64", "mitsuba-table")))
    assert not found.unproven
    failed = {oracle: [gate for gate in comparison.gates if not gate.passed]
              for oracle, (_, comparison) in found.results.items()}  # fmt: skip
    assert failed == {"oracle64": [], "mitsuba-table": []}
