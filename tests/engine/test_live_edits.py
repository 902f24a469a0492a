"""A Tracer that follows thousands of random edits: pictures are those of a new one, bit for bit."""

from __future__ import annotations

import os
import tempfile
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

import clrt
from clrt.device.device import Device
from clrt.scene.mesh import Mesh
from tests.engine.test_live import BASE, scattered

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
        self.folder = tempfile.TemporaryDirectory()
        texels = np.random.default_rng(3).random((4, 4, 3)).astype(np.float32)
        clrt.Image(texels).save(f"{self.folder.name}/p.png")
        *round_ones, flat_one = BASE["shapes"]
        table = {**BASE, "shapes": [*round_ones, {**flat_one, "material": "a"}, many]}
        self.scene = clrt.load_dict(table, folder=Path(self.folder.name))
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

    @rule(key=st.sampled_from(["color", "emission", "normal_map"]), there=st.booleans())
    def picture(self, key: str, there: bool) -> None:
        """On a sphere, for meshes here have no u and v; with the last one kernels for pictures go, too."""
        plain = {"color": 1.0, "emission": 0.0, "normal_map": None}[key]
        shown = {"file": "p.png"} | ({} if key == "normal_map" else {"type": "image"})
        self.edit({"shapes[1].material": "c", f"materials.c.{key}": shown if there else plain})

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
        self.folder.cleanup()


TestEdits = Edits.TestCase
TestEdits.settings = settings(
    max_examples=LIVES, stateful_step_count=25, deadline=None,
    suppress_health_check=list(HealthCheck),
)  # fmt: skip
