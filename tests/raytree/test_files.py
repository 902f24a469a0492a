"""What a tree of rays is written to: JSON with every bit, a page that runs nothing, a model of tubes."""

from __future__ import annotations

import copy
import dataclasses
import io
import json
import pickle
import re
import warnings
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import tostring

import numpy as np
import pytest

import clrt
from clrt.raytree.drawing import VIEWS, drawing
from clrt.raytree.page import page
from clrt.raytree.solids import triangles_of
from clrt.raytree.tree import Ray, RayTree
from tests.random_scenes import random_scene

EVIL = "<script>alert(1)</script>\x1b[31m\u202e&\"'"


def evil_tree() -> RayTree:
    """Of a scene whose texts are all hostile."""
    scene = clrt.load_dict({
        "camera": {"origin": [0, 1, 5], "target": [0, 0, 0], "width": 9, "height": 9},
        "lights": [{"type": "point", "position": [0, 5, 3]}], "background": 0.2,
        "materials": {EVIL: {"transmission": 0.9, "reflection": 0.1, "ior": 1.5, "diffuse": 0.1}},
        "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "name": EVIL, "material": EVIL},
                   {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0], "name": EVIL}],
    }, source=EVIL)  # fmt: skip
    return clrt.Tracer(scene).explain(4, 4)


@pytest.fixture(scope="module")
def tree() -> RayTree:
    return clrt.Tracer("bubble").explain(70, 50, width=160, spp=4)


@pytest.mark.parametrize("again", [lambda tree: pickle.loads(pickle.dumps(tree)), copy.deepcopy, copy.copy],
                         ids=["pickled", "deeply copied", "copied"])  # fmt: skip
def test_a_tree_is_sent_and_copied_however_deep(tree: RayTree, again: Any) -> None:
    """Two mirrors face each other: each ray is in the one before."""
    mirror = {"type": "plane", "material": {"diffuse": 0, "reflection": 1}}
    hall = {"camera": {"origin": [0, 0, 1], "target": [0, 0, 0], "width": 1, "height": 1},
            "shapes": [mirror | {"point": [0, 0, z], "normal": [0, 0, -z]} for z in (-2, 2)]}  # fmt: skip
    settings = clrt.Settings(limits=clrt.Limits(depth=2000))
    deep = clrt.Tracer(hall, settings=settings).explain(0, 0, max_depth=2000)
    assert len(deep.rays) == 2001
    for whole in (tree, deep):
        found = again(whole)
        assert found.to_json() == whole.to_json() and [ray.number for ray in found.walk()] == [
            ray.number for ray in whole.walk()
        ]
        assert shape(again(whole.rays[1])) == shape(whole.rays[1]), "a ray by itself"
        for some in (whole.rays[1:3], whole.rays[::-1]):
            part = again(dataclasses.replace(whole, rays=some))
            assert [*map(shape, part.rays)] == [*map(shape, some)]
            among = [[child in rays for child in rays[0].children] for rays in (part.rays, some)]
            assert among[0] == among[1], "what is a ray of both is one ray"
        both, ray = pickle.loads(pickle.dumps((whole, whole.rays[3])))
        assert ray is both.rays[3]
        assert len(pickle.dumps(whole.rays)) <= len(pickle.dumps(whole)), "each ray is sent once"


def shape(ray: Ray) -> list[tuple[int, int | None, int]]:
    """A ray and all below it: their numbers, parents and numbers of children."""
    found = [ray]
    for one in found:
        found += one.children
    return [(one.number, one.parent, len(one.children)) for one in found]


@pytest.mark.parametrize("name", ["a.html/", "a.json/"])
def test_a_folder_s_name_is_no_file_s(tree: RayTree, tmp_path: Path, name: str) -> None:
    with pytest.raises(clrt.ClrtError, match="is the name of a folder"):
        tree.save(f"{tmp_path}/{name}")
    assert not [*tmp_path.iterdir()]


def test_json_holds_every_bit(tree: RayTree, tmp_path: Path) -> None:
    table = json.loads(tree.save(tmp_path / "tree.json").read_text("utf-8"))
    assert table["value"] == tree.value.tolist() and table["pixel"] == [70, 50]
    assert {name: table[name] for name in ("rays", "generations")} == tree.stats()
    film = np.zeros(3, np.float32)
    queues: dict[tuple[int, int], np.ndarray] = {}
    for ray in table["tree"]:
        total = queues.setdefault((ray["generation"], ray["queue"]), np.zeros(3, np.float32))
        total += np.array(ray["brings"] or [0, 0, 0], np.float32)
    for total in queues.values():
        film += total
    assert (film / np.float32(4)).tobytes() == tree.value.tobytes()
    for ray, own in zip(table["tree"], tree.rays, strict=True):
        assert ray["direction"] == list(own.direction) and ray["parent"] == own.parent
        assert ray["children"] == [child.number for child in own.children]
        assert (ray["hit"] is None) == (own.hit is None)


class _Reader(HTMLParser):
    """Collects tags and where they lead."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.names: set[str] = set()
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.names |= {name for name, _ in attrs}
        self.links += [value or "" for name, value in attrs if name in ("src", "href")]


def test_a_page_runs_nothing_and_asks_nobody() -> None:
    tree = evil_tree()
    text = page(tree)
    reader = _Reader()
    reader.feed(text)
    assert "script" not in reader.tags and reader.links == []
    assert not [name for name in reader.names if name.startswith("on")]
    assert reader.tags.count("details") == len(tree.rays) and reader.tags.count("svg") == len(VIEWS)
    assert "default-src 'none'" in text and "&lt;script&gt;" in text
    assert "\x1b" not in text and "\u202e" not in text
    assert not re.search(r"https?://(?!www\.w3\.org/2000/svg)", text)
    assert tree._repr_html_() in text


def test_a_page_of_very_many_generations(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two mirrors that face each other: nested as deep as browsers go, then side by side; and what is no
    number makes no page fail."""
    mirror = {"reflection": 1.0, "diffuse": 0.0}
    disks = [{"type": "disk", "center": [0, 0, z], "normal": [0, 0, 1], "radius": 9, "material": mirror}
             for z in (-1, 3)]  # fmt: skip
    camera = {"origin": [0, 0, 1], "target": [0, 0.01, 0], "width": 1, "height": 1}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", clrt.ClrtWarning)
        scene = clrt.load_dict({"camera": camera, "shapes": disks, "max_depth": 64})
    monkeypatch.setattr("clrt.raytree.page._NESTED", 20)
    tree = clrt.Tracer(scene).explain(0, 0)
    reader = _Reader()
    reader.feed(page(tree))
    assert reader.tags.count("details") == len(tree.rays) == 65
    assert tree.shares == (0.0,) * 65  # a black pixel has no parts


def test_a_page_of_very_many_rays_has_no_drawing(tree: RayTree, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("clrt.raytree.page._DRAWN", 3)
    assert "<svg" not in page(tree) and "Too many rays to draw" in page(tree)


@pytest.mark.parametrize("view", VIEWS)
def test_drawings_hold_every_ray(tree: RayTree, view: str) -> None:
    svg = tostring(drawing(tree, view), encoding="unicode")
    feelers = tree.stats()["rays"]["feelers"]
    assert svg.count("<line") == len(tree.rays) + feelers
    assert svg.count("<polygon") == len({ray.hit.shape for ray in tree.rays if ray.hit})
    assert tostring(drawing(tree, view, feelers=False), encoding="unicode").count("<line") == len(tree.rays)
    assert "nan" not in svg and "inf" not in svg.replace("info", "")


def test_a_model_holds_every_ray_among_the_shapes(tree: RayTree, tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh", reason="needs the optional dependency clrt[mesh]")
    model = trimesh.load_scene(io.BytesIO(tree.save(tmp_path / "tree.glb").read_bytes()), "glb")
    feelers = tree.stats()["rays"]["feelers"]
    assert len(model.geometry) == len(tree.rays) + feelers + len(tree.scene.shapes)
    for ray in tree.rays:
        name = next(name for name in model.geometry if name.startswith(f"{ray.kind} of ray {ray.number} ("))
        low, high = model.geometry[name].bounds
        assert (low <= np.array(ray.origin) + 0.1).all() and (high >= np.array(ray.origin) - 0.1).all()
        red = model.geometry[name].visual.material.baseColorFactor
        assert (red[0] > 200) == (ray.kind == "reflection")


def test_shapes_are_triangles_on_their_surfaces() -> None:
    """Random shapes of all kinds: rays through the middles of the triangles meet the shape close to them."""
    low, high = np.full(3, -4.0), np.full(3, 4.0)
    scene, checked = random_scene(5, shapes=40), 0
    for shape in scene.shapes:
        made = triangles_of(shape, low, high)
        if made is None:
            continue
        vertices, faces = made
        corners = vertices[faces]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area = np.linalg.norm(normal, axis=1)
        large = area > 0.05 * area.max()
        middle = corners.mean(axis=1)[large][:60]
        normal = (normal / np.where(area > 0, area, 1)[:, None])[large][:60]
        tracer = clrt.Tracer({"shapes": [shape]})
        near = 0.15
        hits = tracer.intersect(middle + near * normal, -normal, t_max=2 * near)
        assert (hits.shape == 0).mean() > 0.9, shape
        assert np.abs(hits.t[hits.shape == 0] - near).mean() < 0.04, shape
        checked += 1
    assert checked > 30


def test_a_kind_of_shape_that_is_not_known_is_left_out() -> None:
    assert triangles_of(object(), np.zeros(3), np.ones(3)) is None  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["tree.txt", "tree", "tree.html.gz"])
def test_other_endings_are_refused(tree: RayTree, name: str, tmp_path: Path) -> None:
    with pytest.raises(clrt.ClrtError, match=r"the name must end in \.json, \.html or \.glb"):
        tree.save(tmp_path / name)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["tree.html", "tree.json", "tree"])
def test_a_model_has_the_ending_of_one(tree: RayTree, name: str, tmp_path: Path) -> None:
    with pytest.raises(clrt.ClrtError, match=rf"{name}: the name must end in \.glb; save writes \.json and"):
        tree.to_glb(tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_missing_is_said(tree: RayTree, tmp_path: Path) -> None:
    for suffix in ("json", "html", "glb"):
        with pytest.raises(clrt.ClrtError, match="there is no folder"):
            tree.save(tmp_path / "none" / f"tree.{suffix}")


def test_a_model_without_trimesh_is_refused_first(
    tree: RayTree, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(clrt.ClrtError, match=r"tree\.glb: needs trimesh; install it with"):
        tree.save(tmp_path / "tree.glb")


MIRROR = [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]


@pytest.mark.parametrize("transform", [None, MIRROR])
@pytest.mark.parametrize(
    "shape",
    [
        {"type": "sphere", "center": [0, 0, 0], "radius": 1},
        {"type": "ellipsoid", "center": [0, 0, 0], "radii": [1, 2, 3]},
        {"type": "box", "min": [-1, -1, -1], "max": [1, 1, 1]},
        {"type": "cylinder", "p0": [0, -1, 0], "p1": [0, 1, 0], "radius": 1, "caps": True},
        {"type": "cone", "p0": [0, -1, 0], "p1": [0, 1, 0], "r0": 1, "r1": 0.5, "caps": True},
        {"type": "disk", "center": [0, 0, 1], "normal": [0, 0, 1], "radius": 1},
        {"type": "polygon", "points": [[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]},
        {"type": "mesh", "vertices": [[-1, -1, 0], [1, -1, 0], [0, 1, 0], [0, 0, 1]],
         "faces": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]},
    ],
)  # fmt: skip
def test_outer_sides_stay_outside(shape: dict[str, Any], transform: list[list[float]] | None) -> None:
    """Mirrored shapes, and all disks, were inside out in a .glb."""
    placed = shape | ({"transform": transform} if transform else {})
    (solid,) = clrt.load_dict({"ambient": 1, "shapes": [placed]}).shapes
    made = triangles_of(solid, np.full(3, -3.0), np.full(3, 3.0))
    assert made is not None
    a, b, c = np.moveaxis(made[0][made[1]], 1, 0)
    assert np.sum(np.cross(b - a, c - a) * a) > 0
