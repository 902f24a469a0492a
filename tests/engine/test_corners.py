"""What is told of triangles' corners is of those that the scene's faces name, whatever the transform."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from tests.pictured import image, put


def matrix_of(rng: np.random.Generator, mirrored: bool) -> np.ndarray:
    """(4, 4): any of the asked sense, that squeezes nothing by more than a factor of some ten."""
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    made = turn @ np.diag(rng.uniform(0.5, 2, 3)) @ np.linalg.qr(rng.normal(size=(3, 3)))[0]
    if (np.linalg.det(made) < 0) != mirrored:
        made[:, 0] = -made[:, 0]
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = made, rng.uniform(-1, 1, 3)
    return out


def mesh_of(kind: str, rng: np.random.Generator) -> dict[str, Any]:
    """Faces apart from each other, none of which hides another from above."""
    corners = 3 if kind == "triangles" else 5
    angle = np.sort(rng.uniform(0, 2 * np.pi / corners, (6, corners)), axis=1)
    angle += 2 * np.pi / corners * np.arange(corners)
    flat = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)
    flat += np.array([[3.0 * (k % 3), 3.0 * (k // 3), 0.3 * k] for k in range(6)])[:, None]
    made = {"type": "mesh", "vertices": flat.reshape(-1, 3), "faces": np.arange(6 * corners).reshape(6, -1)}
    if kind == "normals":
        made["normals"] = rng.uniform(-0.4, 0.4, (6 * corners, 3)) + np.array([0, 0, 1])
    if kind == "smooth":
        made["smooth"] = True
    return made


def triangles_of(faces: np.ndarray) -> np.ndarray:
    """(n, 3): fans about the first corners."""
    return np.array([(face[0], *pair) for face in faces.tolist() for pair in pairwise(face[1:])])


@pytest.mark.parametrize("mirrored", [False, True], ids=["turned", "mirrored"])
@pytest.mark.parametrize("kind", ["triangles", "normals", "smooth"])
def test_u_and_v_are_those_of_the_corners_that_the_faces_name(kind: str, mirrored: bool) -> None:
    rng = np.random.default_rng(len(kind) + mirrored)
    mesh, matrix = mesh_of(kind, rng), matrix_of(rng, mirrored)
    plain = {"type": "sphere", "center": [0, 0, -40], "radius": 1}
    tracer = clrt.Tracer({"shapes": [plain, mesh | {"transform": matrix}, plain]})
    triangles = triangles_of(mesh["faces"])
    corners = (np.asarray(mesh["vertices"]) @ matrix[:3, :3].T + matrix[:3, 3])[triangles]
    number = rng.integers(0, len(triangles), 2000)
    weights = rng.dirichlet([1.5] * 3, 2000)
    points = np.einsum("nk,nki->ni", weights, corners[number])
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[number]
    away = 0.05 * normals / np.linalg.norm(normals, axis=1)[:, None] * rng.choice([-1, 1], 2000)[:, None]
    hits = tracer.intersect(points + away, -away)
    crossed = tracer.all_hits(points + away, -away, t_max=0.1)
    assert (hits.primitive == number + 1).mean() > 0.99  # but for edges that two triangles share
    same = hits.primitive == number + 1
    assert np.allclose(np.stack([hits.u, hits.v], 1)[same], weights[same, 1:], atol=2e-5)
    first = crossed.primitive == number[crossed.rays] + 1
    assert first.sum() > 1950
    right = weights[crossed.rays[first]]
    assert np.allclose(np.stack([crossed.u, crossed.v], 1)[first], right[:, 1:], atol=2e-5)
    for names in (["u"], ["v"], ["u", "v"], ["v", "shape"]):  # the same with others not asked for
        few = tracer.intersect(points + away, -away, fields=names)
        some = tracer.all_hits(points + away, -away, t_max=0.1, fields=names)
        for name in names:
            assert getattr(few, name).tobytes() == getattr(hits, name).tobytes()
            assert getattr(some, name).tobytes() == getattr(crossed, name).tobytes()


@pytest.mark.parametrize("mirrored", [False, True], ids=["turned", "mirrored"])
def test_what_pictures_interpolate_is_what_u_and_v_say(mirrored: bool, tmp_path: Path) -> None:
    rng = np.random.default_rng(5 + mirrored)
    put(tmp_path / "grey.png", np.full((2, 2, 3), 0.5))
    mesh, matrix = mesh_of("normals", rng), matrix_of(rng, mirrored)
    mesh |= {"uv": rng.random((len(mesh["vertices"]), 2)), "material": {"color": image("grey.png")}}
    middle = matrix[:3, :3] @ [3, 1.5, 0.7] + matrix[:3, 3]
    above = np.linalg.solve(matrix[:3, :3].T, [0, 0, 1])  # the sheet's normal
    camera = clrt.Camera(
        origin=middle + 12 * above / np.linalg.norm(above), target=middle, width=64, height=48
    )
    shapes = [mesh | {"transform": matrix}]
    scene = clrt.load_dict({"camera": camera, "ambient": 1, "shapes": shapes}, folder=tmp_path)
    tracer = clrt.Tracer(scene)
    found = tracer.render(layers=["uv", "shading_normal"]).layers
    hits = tracer.intersect(*tracer.camera_rays())
    hit = hits.primitive >= 0
    assert hit.sum() > 100
    triangles = triangles_of(mesh["faces"])[hits.primitive[hit]]
    weights = np.stack([1 - hits.u - hits.v, hits.u, hits.v], axis=-1)[hit]
    assert np.allclose(np.einsum("nk,nki->ni", weights, mesh["uv"][triangles]), found["uv"][hit], atol=1e-5)
    normals = np.asarray(mesh["normals"]) @ np.linalg.inv(matrix[:3, :3])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    blend = np.einsum("nk,nki->ni", weights, normals[triangles])
    blend /= np.linalg.norm(blend, axis=1)[:, None]
    assert np.allclose(np.abs(np.einsum("ni,ni->n", blend, found["shading_normal"][hit])), 1, atol=1e-5)
