"""What a .glb of a tree takes has an end, however many shapes a scene has; and `explain`'s device is one."""

from __future__ import annotations

import io
import warnings
from typing import Any

import pytest

import clrt
from clrt.raytree.tree import RayTree
from clrt.raytree.tubes import glb
from tests.cli.test_terminal import fault

MESH = {"type": "mesh", "vertices": [[9, 9, i] for i in range(90)], "faces": [[0, 1, 2]] * 9}


def tree_of(shapes: list[dict[str, Any]]) -> RayTree:
    """Its rays meet the last shape alone."""
    camera = {"origin": [0, 0, 9], "target": [0, 0, 0], "width": 1, "height": 1}
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "name": "met"}
    with clrt.Tracer({"camera": camera, "shapes": [*shapes, ball]}) as tracer:
        tree = tracer.explain(0, 0)
    assert [ray.hit and ray.hit.shape for ray in tree.rays] == [len(shapes)]
    return tree


def spheres(n: int) -> list[dict[str, Any]]:
    return [{"type": "sphere", "center": [3 + i % 100, i // 100, 0], "radius": 0.3} for i in range(n)]


def made(tree: RayTree) -> tuple[bytes, list[str]]:
    """The file, and what was said."""
    pytest.importorskip("trimesh", reason="needs the optional dependency clrt[mesh]")
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        written = glb(tree)
    return written, [str(one.message) for one in found if issubclass(one.category, clrt.ClrtWarning)]


def test_very_many_shapes_are_coarser_and_then_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    trimesh = pytest.importorskip("trimesh", reason="needs the optional dependency clrt[mesh]")
    monkeypatch.setattr("clrt.raytree.tubes._MOST", 10_000)
    written, said = made(tree_of([*spheres(60), MESH]))
    model = trimesh.load_scene(io.BytesIO(written), "glb")
    sizes = {name: len(mesh.vertices) for name, mesh in model.geometry.items() if "shapes[" in name}
    assert sizes.pop("met (shapes[61])") == 1225
    assert sorted({*sizes.values()}) == [91, 1225] and sum(sizes.values()) < 10_000
    assert said == [
        f"a .glb holds about 10000 vertices of shapes: {61 - len(sizes)} of 62, which no ray of this "
        "pixel meets, are left out"
    ]


def test_a_mesh_of_more_vertices_than_are_left_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("clrt.raytree.tubes._MOST", 2000)
    few = {**MESH, "vertices": [[9, 9, i] for i in range(3)]}
    _, (said,) = made(tree_of([{**MESH, "vertices": [[9, 9, i] for i in range(900)]}, few]))
    assert "1 of 3" in said


def test_a_file_is_not_out_of_proportion() -> None:
    """1.2 MB of spheres were 300 MB."""
    written, (said,) = made(tree_of(spheres(8000)))
    assert "of 8001" in said and len(written) < 30e6
    assert not made(tree_of(spheres(20)))[1]


@pytest.mark.parametrize("name", ["", " "])
def test_an_empty_device_is_refused_in_the_words_of_the_api(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(clrt.ClrtError) as api:
        clrt.Tracer("bubble", device=name)
    _, words = str(api.value).split("device: ")
    assert f"--device: {words};" in fault(capsys, "explain", "bubble", "1", "1", "--device", name)
