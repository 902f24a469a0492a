"""Meshes of files in `Scene.replace`: arrays take the file's place, and a file takes that of arrays."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.scene.mesh import Mesh

VERTICES = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.2], [1, 1, 0.5]])
FACES = np.array([[0, 1, 2], [1, 3, 2]])
BARE = "v {} {} {}\nv {} {} {}\nv {} {} {}\nv {} {} {}\n".format(*VERTICES.ravel())
FILES = {
    "bare.obj": BARE + "f 1 2 3\nf 2 4 3\n",
    "whole.obj": BARE + "vn 0 0 1\nvn 1 0 1\nvn 0 1 1\nvn 0 0 2\nvt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n"
    "f 1/1/1 2/2/2 3/3/3\nf 2/2/2 4/4/4 3/3/3\n",
    "other.obj": "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n",
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


def scene_of(folder: Path, **keys: Any) -> clrt.Scene:
    ball = {"type": "sphere", "center": [0, 0, 3], "radius": 1}
    mesh = {"type": "mesh", "name": "net", "material": {"diffuse": 0.5}, **keys}
    camera = {"origin": [0.4, 0.4, 2], "target": [0.4, 0.4, 0], "width": 16, "height": 16}
    lights = [{"type": "point", "position": [0, 0, 1.9]}]
    table = {"shapes": [ball, mesh], "camera": camera, "lights": lights}
    return clrt.load_dict(table, folder=folder)


def mesh_in(scene: clrt.Scene) -> Mesh:
    mesh = scene.shapes[1]
    assert isinstance(mesh, Mesh)
    return mesh


@pytest.mark.parametrize("smooth", [None, True, False])
@pytest.mark.parametrize("file", ["bare.obj", "whole.obj"])
def test_moved_vertices_keep_the_rest_of_the_file(file: str, smooth: bool | None, folder: Path) -> None:
    scene = scene_of(folder, file=file, **({} if smooth is None else {"smooth": smooth}))
    old = mesh_in(scene).data()
    with clrt.Tracer(scene) as tracer:
        for move in (0.1, 0.2):  # the second is of a mesh that has no file any more
            moved = old.vertices * [1, 1, 1 + move]
            other = scene.replace({"shapes.net.vertices": moved})
            assert tracer.update(other) == "refit"
            scene = other
        found, new = mesh_in(other), mesh_in(other).data()
        assert tracer.render().hash == clrt.render(other).hash
    assert found.file is None and found.smooth is smooth and found.name == "net"
    assert np.array_equal(new.vertices, moved) and np.array_equal(new.faces, old.faces)
    assert (new.uv is None and old.uv is None) or np.array_equal(new.uv, old.uv)
    keys: dict[str, Any] = {"vertices": moved, "faces": old.faces, "uv": old.uv, "smooth": smooth}
    if file == "whole.obj" and smooth is not False:
        assert np.array_equal(new.normals, old.normals)
        keys["normals"] = old.normals
    keys = {name: value for name, value in keys.items() if value is not None}
    assert other == scene_of(folder, **keys), "what a file of these arrays says"


@pytest.mark.parametrize("file", ["bare.obj", "whole.obj"])
@pytest.mark.parametrize("smooth", [None, True, False])
def test_the_same_vertices_are_the_same_picture(file: str, smooth: bool | None, folder: Path) -> None:
    scene = scene_of(folder, file=file, **({} if smooth is None else {"smooth": smooth}))
    same = scene.replace({"shapes[1].vertices": mesh_in(scene).data().vertices})
    assert clrt.render(same).hash == clrt.render(scene).hash


CHANGES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "a corner": ({"vertices[1]": [2, 0, 0]}, {"vertices": [[0, 0, 0], [2, 0, 0], [0, 1, 0.2], [1, 1, 0.5]]}),
    "a number": ({"vertices[1][2]": 2}, {"vertices": [[0, 0, 0], [1, 0, 2], [0, 1, 0.2], [1, 1, 0.5]]}),
    "two corners": ({"vertices[0][2]": 2, "vertices[1][2]": 2},
                    {"vertices": [[0, 0, 2], [1, 0, 2], [0, 1, 0.2], [1, 1, 0.5]]}),
    "after the material": ({"material": {"diffuse": 1}, "vertices[0][0]": 0.5},
                           {"material": {"diffuse": 1},
                            "vertices": [[0.5, 0, 0], [1, 0, 0], [0, 1, 0.2], [1, 1, 0.5]]}),
    "before the material": ({"vertices[0][0]": 0.5, "material": {"diffuse": 1}},
                            {"material": {"diffuse": 1},
                             "vertices": [[0.5, 0, 0], [1, 0, 0], [0, 1, 0.2], [1, 1, 0.5]]}),
    "faces": ({"faces": [[0, 1, 3]]}, {"faces": [[0, 1, 3]]}),
    "a face": ({"faces[1]": [0, 1, 3]}, {"faces": [[0, 1, 2], [0, 1, 3]]}),
    "no file": ({"file": None}, {}),
    "no file before": ({"file": None, "vertices": 2 * VERTICES}, {"vertices": 2 * VERTICES}),
    "no file after": ({"vertices": 2 * VERTICES, "file": None}, {"vertices": 2 * VERTICES}),
    "all": ({"file": None, "vertices": 2 * VERTICES, "faces": FACES}, {"vertices": 2 * VERTICES}),
    "smooth": ({"smooth": True, "vertices": 2 * VERTICES}, {"vertices": 2 * VERTICES, "smooth": True}),
    "uv": ({"uv": VERTICES[:, :2]}, {"uv": VERTICES[:, :2]}),
    "normals": ({"normals": VERTICES + 1}, {"normals": VERTICES + 1}),
    "nothing": ({"vertices": None}, {"file": "bare.obj", "vertices": None, "faces": None}),
    "another file": ({"file": "other.obj"}, {"file": "other.obj", "vertices": None, "faces": None}),
    "another file's": ({"file": "other.obj", "vertices[2]": [0, 3, 0]},
                       {"vertices": [[0, 0, 0], [1, 0, 0], [0, 3, 0]], "faces": [[0, 1, 2]]}),
    "a file in place of arrays": ({"vertices[0][0]": 0.5, "file": "other.obj"},
                                  {"file": "other.obj", "vertices": None, "faces": None}),
}  # fmt: skip


@pytest.mark.parametrize("name", CHANGES)
def test_it_is_what_arrays_of_these_values_say(name: str, folder: Path) -> None:
    changes, keys = CHANGES[name]
    right = {"vertices": VERTICES, "faces": FACES, **keys}
    made = scene_of(folder, file="bare.obj").replace({f"shapes[1].{k}": v for k, v in changes.items()})
    assert made == scene_of(folder, **{k: v for k, v in right.items() if v is not None})


def test_a_file_takes_the_place_of_arrays(folder: Path) -> None:
    made = scene_of(folder, vertices=VERTICES, faces=FACES, uv=VERTICES[:, :2], normals=VERTICES + 1)
    assert made.replace({"shapes[1].file": "bare.obj"}) == scene_of(folder, file="bare.obj")
    assert made.replace({"shapes[1].file": None}) == made


def test_a_mesh_of_another_number_of_vertices_has_nothing_of_the_file(folder: Path) -> None:
    vertices, faces = np.eye(3), [[0, 1, 2]]
    changes = {"shapes[1].vertices": vertices, "shapes[1].faces": faces}
    made = scene_of(folder, file="whole.obj").replace(changes)
    assert made == scene_of(folder, vertices=vertices, faces=faces)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"vertices": np.zeros((3, 3))}, r"^shapes\[1\]\.vertices: 3 in place of 4; give as many, or faces"),
        ({"vertices[4]": [0, 0, 0]}, r"^shapes\[1\]\.vertices: there is no number 4; there are 4"),
        ({"vertices": "there"}, r"^shapes\[1\]\.vertices: not allowed .*must be 3 numbers each"),
        ({"faces[0][0]": 4}, r"^shapes\[1\]\.faces\[0\]\[0\]: 4 is not allowed"),
        ({"uv": [[0, 0]]}, r"^shapes\[1\]\.uv: 1 uv for 4 vertices"),
        ({"file": "none.obj", "vertices[0]": [0, 0, 0]}, r"^shapes\[1\]\.file: .*none\.obj"),
        ({"part": 7, "vertices[0]": [0, 0, 0]}, r"^shapes\[1\]\.file: part 7 is not allowed; bare"),
        ({"smooth": 3, "vertices[0]": [0, 0, 0]}, r"^shapes\[1\]\.smooth: 3 is not allowed"),
    ],
)
def test_what_is_wrong_names_the_place(changes: dict[str, Any], says: str, folder: Path) -> None:
    with pytest.raises(clrt.SceneError, match=says) as caught:
        scene_of(folder, file="bare.obj").replace({f"shapes[1].{k}": v for k, v in changes.items()})
    assert "\n" not in str(caught.value)


def test_shapes_that_are_given_whole(folder: Path) -> None:
    scene = scene_of(folder, file="bare.obj")
    mesh = {"type": "mesh", "file": "other.obj"}
    made = scene.replace({"shapes": [mesh], "shapes[0].vertices[2]": [0, 3, 0]})
    assert made.shapes[0].data().vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 3, 0]]
    made = scene.replace({"shapes[0]": mesh, "shapes[0].vertices[2]": [0, 3, 0]})
    assert made.shapes[0].data().vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 3, 0]]


@pytest.mark.parametrize("kind", [np.zeros(2), None, "box"])
def test_parts_of_what_is_no_mesh(kind: Any, folder: Path) -> None:
    scene = scene_of(folder, file="bare.obj")
    with pytest.raises(clrt.SceneError):
        scene.replace({"shapes[0]": {"type": kind, "file": "bare.obj"}, "shapes[0].vertices": VERTICES})


def test_a_deforming_model(folder: Path) -> None:
    scene = clrt.load(folder / "whole.obj")
    vertices = scene.shapes[0].data().vertices
    with clrt.Tracer(scene) as tracer:
        assert tracer.update(scene.replace({"shapes[0].vertices": 1.01 * vertices})) == "refit"
