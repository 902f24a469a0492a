"""A Tracer that follows a scene: pictures are those of a new one, bit for bit, at the cost that it names."""

from __future__ import annotations

import threading
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt

SIZE = {"width": 24, "height": 18}
BASE: dict[str, Any] = {
    "max_depth": 3,
    "background": [0.1, 0.2, 0.4],
    "camera": {"origin": [0, 1.5, 6], "target": [0, 0, 0], **SIZE},
    "materials": {
        "a": {"color": [0.9, 0.3, 0.1], "reflection": 0.3},
        "b": {"transmission": 0.8, "ior": 1.5, "reflection": 0.1, "diffuse": 0.1},
        "c": {"color": [0.2, 0.8, 0.3], "specular": 0.4},
    },
    "lights": [{"type": "point", "position": [3, 5, 4]}],
    "shapes": [
        {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]},
        *({"type": "sphere", "center": [1.2 * i - 1.5, 0, 0.3 * i], "radius": 0.6, "material": name}
          for i, name in enumerate("abc")),
        {"type": "mesh", "vertices": [[-2, -1, -2], [2, -1, -2], [2, 2, -2], [-2, 2, -2]],
         "faces": [[0, 1, 2], [0, 2, 3]], "material": "c"},
    ],
}  # fmt: skip


@pytest.fixture(scope="module")
def scene() -> clrt.Scene:
    return clrt.load_dict(BASE)


@pytest.mark.parametrize(
    ("changes", "cost"),
    [
        ({}, "nothing"),
        ({"camera.fov": 20}, "camera"),
        ({"max_depth": 1}, "nothing"),
        ({"materials.a.color": [0, 1, 0]}, "tables"),
        ({"lights[0].intensity": 0.5}, "tables"),
        ({"lights": []}, "tables"),
        ({"background": 0.5, "ambient": 0.1}, "tables"),
        ({"shapes[1].material": "c"}, "tables"),
        ({"materials.a": {"color": [0.2, 0.8, 0.3], "specular": 0.4}}, "tables"),  # two are one now
        ({"shapes[0].point": [0, -2, 0]}, "tables"),  # no plane is in the tree
        ({"shapes[1].radius": 0.3}, "refit"),
        ({"shapes[4].vertices[2]": [1, 1, -1]}, "refit"),
        ({"shapes[4].transform": [{"rotate": [[0, 1, 0], 20]}, {"translate": [0, 0, 1]}]}, "refit"),
        ({"shapes[4].material": "a"}, "tables"),
        ({"shapes[4].faces": [[0, 1, 2], [0, 3, 1]]}, "refit"),
        ({"shapes[4].faces": [[0, 1, 2]]}, "rebuild"),
        ({"shapes": []}, "rebuild"),
        ({"spectrum": {"bands": 4}}, "tables"),
        ({"materials.b.absorption": 0.4}, "tables"),  # rays carry lists of media from now on
    ],
    ids=str,
)
def test_the_least_is_done_and_said(changes: dict[str, Any], cost: str, scene: clrt.Scene) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        other = scene.replace(changes)
        tracer = clrt.Tracer(scene)
        tracer.render()
        assert tracer.update(other) == cost and tracer.scene is other
        found, right = tracer.render(layers=["depth", "shape"]), clrt.render(other, layers=["depth", "shape"])
        assert found.hash == right.hash and found.metadata == right.metadata
        assert all(np.array_equal(found.layers[name], right.layers[name]) for name in right.layers)
        assert tracer.update(clrt.load_dict(other.to_dict())) in ("nothing", "camera"), "equal by value"
        assert tracer.update(scene) == cost and tracer.render().hash == clrt.render(scene).hash


def scattered(rng: np.random.Generator, far: float) -> np.ndarray:
    """Corners of 400 small triangles, each thrown up to so far from where it was."""
    places = np.stack(np.meshgrid(*[np.linspace(-1, 1, 20)] * 2, [0.0]), axis=-1).reshape(-1, 1, 3)
    corners = places + 0.05 * np.random.default_rng(1).normal(size=(400, 3, 3))
    return (corners + far * rng.uniform(-1, 1, (400, 1, 3))).reshape(-1, 3)


def test_a_tree_that_no_longer_fits_is_built_anew() -> None:
    rng = np.random.default_rng(7)
    place = {"type": "disk", "center": [0, -1, 0], "normal": [0, 1, 0], "radius": 1}
    plane = {"type": "plane", "point": [0, -2, 0], "normal": [0, 1, 0]}  # numbers are not places in the tree
    mesh = {"type": "mesh", "vertices": scattered(rng, 0), "faces": np.arange(1200).reshape(-1, 3)}
    scene = clrt.load_dict({"shapes": [plane, mesh, place]})
    tracer = clrt.Tracer(scene)
    o = (3 * rng.normal(size=(2000, 3))).astype(np.float32)
    d = (rng.normal(size=(2000, 3)) - o).astype(np.float32)
    costs = []
    for far in (0.005, 0.01, 0.02, 2.0, 0.005, 0.01):
        scene = scene.replace({"shapes[1].vertices": scattered(rng, far)})
        costs.append(tracer.update(scene))
        hits, right = tracer.intersect(o, d), clrt.Tracer(scene).intersect(o, d)
        assert all(np.array_equal(getattr(hits, name), getattr(right, name)) for name in ("t", "primitive"))
    assert costs == ["refit", "refit", "refit", "rebuild", "rebuild", "refit"]


def test_a_scene_that_cannot_be_held_leaves_the_one_before(scene: clrt.Scene) -> None:
    tracer = clrt.Tracer(scene, settings=clrt.Settings(limits=clrt.Limits(device_bytes=8 << 20)))
    before = tracer.render().hash
    n = 400_000
    corners = np.random.default_rng(1).random((n, 3))
    large = {"type": "mesh", "vertices": corners, "faces": np.arange(n - n % 3).reshape(-1, 3)}
    for wrong, kind in (
        ({"shapes": [large]}, clrt.LimitError),
        ({"shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": -1}]}, clrt.SceneError),
        ("there is no such file.toml", clrt.ClrtError),
        (3, clrt.ClrtError),
    ):
        with pytest.raises(kind):
            tracer.update(wrong)  # type: ignore[arg-type]
        assert tracer.scene is scene and tracer.render().hash == before
    with pytest.raises(clrt.ClrtError, match=r"call tracer\.update"):
        tracer.scene = scene  # type: ignore[misc]


@pytest.mark.parametrize("way", [1, -1])
def test_faces_of_four_corners_may_get_a_picture(way: int, tmp_path: Path) -> None:
    """They are triangles then, and polygons else, though vertices and places are the same."""
    clrt.Image(np.linspace(0, 1, 48, dtype=np.float32).reshape(4, 4, 3)).save(tmp_path / "tile.png")
    pictured = {"color": {"type": "image", "file": "tile.png"}}
    corners = [[x, y, 0] for y in (-1, 1) for x in (-1, 1)]
    square = [[0, 0], [1, 0], [0, 1], [1, 1]]
    quad = {"type": "mesh", "vertices": corners, "faces": [[0, 1, 3, 2]], "uv": square}
    ball = {"type": "sphere", "center": [0, 0, -2], "radius": 1.5, "material": pictured}
    plain = clrt.load_dict({**BASE, "shapes": [quad, ball]}, folder=tmp_path)
    scene, then = (plain, plain.replace({"shapes[0].material": pictured}))[::way]
    with clrt.Tracer(scene) as tracer, clrt.Tracer(then) as fresh:
        tracer.update(then)
        assert tracer.identity() == fresh.identity() and tracer.render().hash == fresh.render().hash


def test_an_update_within_a_picture_leaves_that_picture_whole() -> None:
    """`progress` may do so; the picture was of both scenes, under the new one's name."""
    one = clrt.load_dict(BASE)
    for changes in ({"materials.a.color": [0, 1, 0]}, {"lights": []}, {"spectrum": {"bands": 8}}):
        other = one.replace(changes)
        expected, then = clrt.render(one), clrt.render(other)
        with clrt.Tracer(one, settings=clrt.Settings(tile=64)) as tracer:

            def look(done: int, total: int, rays: int, tracer: clrt.Tracer = tracer, to: Any = other) -> None:
                tracer.update(to)

            image = tracer.render(progress=look)
            assert image.hash == expected.hash
            assert image.metadata["scene_hash"] == expected.metadata["scene_hash"]
            assert tracer.render().hash == then.hash


def test_an_update_that_is_broken_off_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C when the scene's record had been sent: the next update said "nothing", for ever."""

    class Interrupting:
        def info(self, *_: object) -> None:
            raise KeyboardInterrupt

    one = clrt.load_dict(BASE)
    other = one.replace({"materials.a.color": [0, 1, 0]})
    with clrt.Tracer(one) as tracer:
        before = tracer.render().hash
        with monkeypatch.context() as patched:
            patched.setattr("clrt.engine.world.log", Interrupting())
            with pytest.raises(KeyboardInterrupt):
                tracer.update(other)
        assert tracer.render().hash == before
        assert tracer.update(other) == "tables" and tracer.render().hash == clrt.render(other).hash


def test_a_camera_for_one_picture(scene: clrt.Scene) -> None:
    tracer = clrt.Tracer(scene)
    view = {"origin": [4, 2, 4], "target": [0, 0, 0], "fov": 30, **SIZE}
    right = clrt.render(scene.replace({"camera": view})).hash
    assert tracer.render(camera=view).hash == right
    assert tracer.render(camera=clrt.Camera(**view)).hash == right
    assert clrt.render(scene.replace({"camera": None}), camera=view).hash == right
    assert tracer.render().hash == clrt.render(scene).hash, "the scene's own is as it was"
    with pytest.raises(clrt.SceneError, match=r"camera: missing"):
        clrt.Tracer(scene.replace({"camera": None})).render()
    with pytest.raises(clrt.SceneError, match=r"camera\.fov: 200 is not allowed"):
        tracer.render(camera={**view, "fov": 200})
    with pytest.raises(clrt.ClrtError, match="camera: 'x' is not allowed"):
        tracer.render(camera="x")  # type: ignore[arg-type]


def test_the_rays_of_a_camera(scene: clrt.Scene) -> None:
    tracer = clrt.Tracer(scene, settings=clrt.Settings(tile=100))
    origins, directions = tracer.camera_rays()
    assert origins.shape == directions.shape == (18, 24, 3) and origins.dtype == np.float32
    light, _ = tracer.radiance(origins.reshape(-1, 3), directions.reshape(-1, 3))
    far = np.abs(light.reshape(18, 24, 3) - tracer.render().pixels).max(axis=2)
    assert np.mean(far < 1e-5) > 0.98, "directions are made unit anew, which may move their last bits"
    flat = {"type": "orthographic", "origin": [0, 0, 5], "target": [0, 0, 0], "size": 2, **SIZE, "width": 2}
    flat["height"] = 2
    origins, directions = tracer.camera_rays(flat)
    assert np.allclose(directions, [0, 0, -1]) and np.allclose(origins[0, 1], [0.5, 0.5, 5])


def test_it_can_be_closed(scene: clrt.Scene) -> None:
    with clrt.Tracer(scene) as tracer:
        tracer.render()
    for use in (tracer.render, tracer.camera_rays, lambda: tracer.update(scene), lambda: tracer.world):
        with pytest.raises(clrt.ClrtError, match="this Tracer is closed"):
            use()
    tracer.close()
    assert tracer.device.held_bytes < 1 << 16


def test_memory_does_not_grow(scene: clrt.Scene) -> None:
    tracer = clrt.Tracer(scene)
    held = []
    for i in range(300):
        moved = {"shapes[1].radius": 0.3 + 0.001 * i, "lights[0].intensity": 0.001 * i}
        assert tracer.update(scene.replace(moved)) == "refit"
        tracer.render()
        held.append(tracer.device.held_bytes)
    assert max(held[50:]) <= 1.05 * max(held[:50]) + (1 << 14), "what is kept for use varies by a block"


def test_threads_may_share_it(scene: clrt.Scene) -> None:
    tracer = clrt.Tracer(scene)
    scenes = [scene.replace({"lights[0].intensity": k / 4}) for k in range(4)]
    right = {clrt.render(one).hash for one in scenes}
    found: list[str] = []
    wrong: list[Exception] = []

    def work(one: clrt.Scene) -> None:
        try:
            for _ in range(5):
                tracer.update(one)
                found.append(tracer.render().hash)
        except Exception as error:  # of a thread nobody else hears
            wrong.append(error)

    threads = [threading.Thread(target=work, args=(one,)) for one in scenes]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == [] and len(found) == 4 * 5 and {*found} <= right


@pytest.mark.parametrize(("key", "picture", "plain"), [
    ("color", {"type": "image", "file": "p.png"}, 1.0), ("emission", {"type": "image", "file": "p.png"}, 0.0),
    ("transmission_color", {"type": "image", "file": "p.png"}, 1.0), ("normal_map", {"file": "p.png"}, None),
    ("color", {"type": "image", "file": "p.png"}, 0.5),
])  # fmt: skip
def test_the_last_picture_goes_and_comes_back(key: str, picture: Any, plain: Any, tmp_path: Path) -> None:
    """No number of the material need change with it; kernels for pictures take more than others."""
    texels = np.random.default_rng(3).random((4, 4, 3)).astype(np.float32)
    clrt.Image(texels).save(tmp_path / "p.png")
    table = {**BASE, "shapes": BASE["shapes"][:4]}
    pictured = clrt.load_dict(table, folder=tmp_path).replace({f"materials.b.{key}": picture})
    bare = pictured.replace({f"materials.b.{key}": plain})
    for first, *others in ([pictured, bare, pictured], [bare, pictured, bare]):
        with clrt.Tracer(first) as tracer:
            for scene in others:
                assert tracer.update(scene) == "tables"
                assert tracer.render(**SIZE).hash == clrt.render(scene, **SIZE).hash
                assert tracer.intersect([0, 0, 5], [0, 0, -1]).t > 0
