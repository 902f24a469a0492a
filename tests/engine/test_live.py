"""A Tracer that follows a scene: pictures are those of a new one, bit for bit, at the cost that it names."""

from __future__ import annotations

import os
import threading
import warnings
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

import clrt
from clrt.device.device import Device
from clrt.scene.mesh import Mesh

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


NUMBER = st.floats(-2, 2, width=32)
POINT = st.tuples(NUMBER, NUMBER, NUMBER)
COLOR = st.tuples(*[st.floats(0, 1, width=32)] * 3)


LIVES = int(os.environ.get("CLRT_EDITS", "8"))
MANY = LIVES > 8


class Edits(RuleBasedStateMachine):
    """Random edits, one after the other: the picture is that of a new Tracer. CLRT_EDITS: how many lives."""

    tracer: clrt.Tracer
    device: Device

    def __init__(self) -> None:
        super().__init__()
        warnings.simplefilter("ignore")
        many = {"type": "mesh", "vertices": scattered(np.random.default_rng(2), 0.1), "material": "a",
                "faces": np.arange(1200).reshape(-1, 3), "name": "many"}  # fmt: skip
        self.scene = clrt.load_dict({**BASE, "shapes": [*BASE["shapes"], many]})
        self.tracer = clrt.Tracer(self.scene)
        self.left = self.scene

    def edit(self, changes: dict[str, Any]) -> None:
        try:
            self.scene = self.scene.replace(changes)
        except clrt.SceneError:  # a camera in its own target, say
            return

    @rule(origin=POINT, fov=st.floats(5, 120))
    def camera(self, origin: Any, fov: float) -> None:
        self.edit({"camera.origin": [3 * x for x in origin], "camera.fov": fov})

    @rule(name=st.sampled_from("abc"), color=COLOR, kr=st.floats(0, 0.5), kt=st.sampled_from([0, 0.5]))
    def material(self, name: str, color: Any, kr: float, kt: float) -> None:
        here = f"materials.{name}"
        self.edit({f"{here}.color": color, f"{here}.reflection": kr, f"{here}.transmission": kt})

    @rule(name=st.sampled_from("abc"), index=st.integers(0, 4))
    def whose(self, name: str, index: int) -> None:
        if index < len(self.scene.shapes):
            self.edit({f"shapes[{index}].material": name})

    @rule(lights=st.lists(POINT, max_size=3))
    def lights(self, lights: Any) -> None:
        self.edit({"lights": [{"type": "point", "position": [3 * x for x in place]} for place in lights]})

    @rule(index=st.integers(1, 3), center=POINT, radius=st.floats(0.1, 1.5))
    def sphere(self, index: int, center: Any, radius: float) -> None:
        if index < len(self.scene.shapes) and self.scene.shapes[index].type == "sphere":
            self.edit({f"shapes[{index}].center": center, f"shapes[{index}].radius": radius})

    @rule(corners=st.lists(POINT, min_size=4, max_size=4), factor=st.sampled_from([1, 1, 1e4]))
    def mesh(self, corners: Any, factor: float) -> None:
        for index, shape in enumerate(self.scene.shapes):
            if isinstance(shape, Mesh) and len(shape.data().vertices) == len(corners):
                self.edit({f"shapes[{index}].vertices": factor * np.array(corners)})

    @rule(seed=st.integers(0, 99), far=st.sampled_from([0.01, 0.1, 0.5, 3.0]))
    def scatter(self, seed: int, far: float) -> None:
        if any(shape.name == "many" for shape in self.scene.shapes):
            self.edit({"shapes.many.vertices": scattered(np.random.default_rng(seed), far)})

    @rule(
        index=st.integers(0, 5), scale=st.sampled_from([0.5, 1, -2]), degrees=st.floats(-180, 180), by=POINT
    )  # fmt: skip
    def transform(self, index: int, scale: float, degrees: float, by: Any) -> None:
        if index < len(self.scene.shapes):
            steps = [{"scale": scale}, {"rotate": ["y", degrees]}, {"translate": list(by)}]
            self.edit({f"shapes[{index}].transform": steps})

    @rule(absorption=st.sampled_from([0.0, 0.7]), thin=st.booleans(), ior=st.sampled_from([1.0, 1.3, 2.4]))
    def medium(self, absorption: float, thin: bool, ior: float) -> None:
        of = {"absorption": 0.0 if thin else absorption, "thin": thin, "ior": ior}
        self.edit({f"materials.b.{key}": value for key, value in of.items()})

    @rule(center=POINT, samples=st.sampled_from([1, 4]))
    def light_with_extent(self, center: Any, samples: int) -> None:
        light = {"type": "rectangle", "center": [2 * x + 3 for x in center], "u": [0.5, 0, 0],
                 "v": [0, 0.5, 0], "radiance": 9.0, "samples": samples}  # fmt: skip
        self.edit({"lights": [light]})

    @rule(center=POINT, kind=st.sampled_from(["sphere", "cone", "box", "mesh"]))
    def more(self, center: Any, kind: str) -> None:
        x, y, z = center
        more: dict[str, dict[str, Any]] = {
            "sphere": {"center": center, "radius": 0.4},
            "box": {"min": center, "max": [x + 1, y + 1, z + 1]},
            "cone": {"p0": center, "r0": 0.5, "p1": [x, y + 1, z], "r1": 0.0},
            "mesh": {"vertices": [center, [x + 1, y, z], [x, y + 1, z]], "faces": [[0, 1, 2]]},
        }
        if len(self.scene.shapes) < 9:
            self.edit({"shapes": [*self.scene.shapes, {"type": kind, "material": "a", **more[kind]}]})

    @precondition(lambda _: MANY)  # other kernels, which have to be compiled
    @rule(bands=st.sampled_from([None, 4, 9]))
    def spectrum(self, bands: int | None) -> None:
        self.edit({"spectrum": None if bands is None else {"bands": bands}})

    @rule(drop=st.integers(0, 5))
    def fewer(self, drop: int) -> None:
        self.edit({"shapes": [s for i, s in enumerate(self.scene.shapes) if i != drop]})

    @rule(shadow=st.sampled_from(["opaque", "tinted"]), ambient=st.floats(0, 1), depth=st.integers(0, 3))
    def globals(self, shadow: str, ambient: float, depth: int) -> None:
        self.edit({"shadow": shadow, "ambient": ambient, "max_depth": depth})

    @rule()
    def back(self) -> None:
        self.scene, self.left = self.left, self.scene

    @precondition(lambda self: self.scene is not self.tracer.scene)
    @invariant()
    def pictures_are_equal(self) -> None:
        cost = self.tracer.update(self.scene)
        assert cost in ("nothing", "camera", "tables", "refit", "rebuild")
        found = self.tracer.render()
        assert found.hash == clrt.render(self.scene).hash, cost
        assert found.metadata["scene_hash"] == clrt.Tracer(self.scene).flat.hash

    def teardown(self) -> None:
        self.tracer.close()


TestEdits = Edits.TestCase
TestEdits.settings = settings(
    max_examples=LIVES, stateful_step_count=25, deadline=None,
    suppress_health_check=list(HealthCheck),
)  # fmt: skip
