"""What is taken over from a scene flattened before: the arrays are those of one flattened from scratch."""

from __future__ import annotations

import warnings
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import clrt
from clrt.flatten.flatten import FlatScene, flatten
from clrt.scene.scene import Scene

CAMERA = {"origin": [0, 0, 20], "target": [0, 0, 0]}
CUBE = {
    "vertices": [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)],
    "faces": [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]],
    "uv": [[0, 0], [1, 0], [0, 1], [1, 1], [0.5, 0], [0, 0.5], [1, 0.5], [0.5, 1]],
}
PICTURE = {"type": "image", "file": "tile.png"}
CHECKER: dict[str, Any] = {"type": "checker", "colors": [[0.9, 0.1, 0.1], [0.1, 0.1, 0.9]]}
CLEAR = {"diffuse": 0.2, "transmission": 0.6, "ior": 1.3}
ANY: list[dict[str, Any] | str] = [
    "a", "b", {}, {"color": [0.7, 0.5, 0.2]}, {"color": PICTURE}, {**CLEAR, "color": PICTURE},
    {"color": PICTURE, "reflection": 0.2}, CLEAR, {**CLEAR, "thin": True}, {**CLEAR, "absorption": 0.4},
    {"fresnel": True, "transmission": 0.0, "ior": 1.4}, {"reflection": 0.3, "gloss": 0.2, "diffuse": 0.1},
    {"conductor": "gold"}, {"emission": 0.5},
]  # fmt: skip
NAMED: list[dict[str, Any]] = [m for m in ANY if isinstance(m, dict)]
CHECKERED: list[dict[str, Any]] = [
    {"color": CHECKER | {"divisions": divisions, "size": size}, **more}
    for divisions in (8, 16) for size in (0.5, 1.0) for more in ({}, CLEAR)
]  # fmt: skip
SHAPES: list[dict[str, Any]] = [
    {"type": "mesh", **CUBE},
    {"type": "sphere", "center": [0, 1.4, 0], "radius": 0.5},
    {"type": "mesh", **CUBE, "transform": [{"translate": [3, 0, 0]}]},
    {"type": "plane", "point": [0, -2, 0], "normal": [0, 1, 0]},
    {"type": "box", "min": [-4, 0, 0], "max": [-3, 1, 1]},
    {"type": "mesh", "vertices": [[0, 0, 2], [1, 0, 2], [0, 1, 2]], "faces": [[0, 1, 2]],
     "uv": [[0, 0], [1, 0], [0, 1]]},
    {"type": "disk", "center": [0, 3, 0], "normal": [0, 1, 0], "radius": 1},
    {"type": "cylinder", "p0": [5, 0, 0], "p1": [5, 1, 0], "radius": 0.4},
    {"type": "polygon", "points": [[0, 5, 0], [1, 5, 0], [1, 6, 0], [0, 6, 0]]},
]  # fmt: skip
ROUND_OR_FLAT = ("sphere", "plane", "disk", "polygon")
LIGHT: dict[str, Any] = {"type": "sphere", "center": [0, 8, 0], "radius": 0.5, "radiance": 3.0, "samples": 4}
MATERIAL = st.tuples(st.just("material"), st.sampled_from([0, 2, *range(9)]), st.integers(0, 99))
EDIT = st.one_of(
    *[MATERIAL] * 5,
    st.tuples(st.just("named"), st.sampled_from("ab"), st.integers(0, 99)),
    st.tuples(st.just("lights"), st.booleans(), st.booleans()),
    st.tuples(st.just("one_sided"), st.booleans(), st.none()),
    st.tuples(st.just("spectrum"), st.sampled_from([None, 3, 5]), st.none()),
    st.tuples(st.just("place"), st.integers(0, 8), st.integers(0, 3)),
    st.tuples(st.just("fewer"), st.integers(0, 8), st.none()),
    st.tuples(st.just("first"), st.none(), st.none()),
)


def edited(scene: Scene, edit: Any) -> dict[str, Any]:
    """The changes that an edit makes."""
    what, which, how = edit
    if what == "material" and which < len(scene.shapes):
        able = scene.shapes[which].type in ROUND_OR_FLAT
        choice = [*ANY, *CHECKERED] if able else ANY
        return {f"shapes[{which}].material": choice[how % len(choice)]}
    if what == "named":
        return {f"materials.{which}": NAMED[how % len(NAMED)]}
    if what == "lights":
        return {"lights": [LIGHT | {"visible": how}] if which else []}
    if what == "one_sided":
        return {"one_sided": "opaque" if which else "none"}
    if what == "spectrum":
        return {"spectrum": None if which is None else {"bands": which}}
    if what == "place" and which < len(scene.shapes):
        return {f"shapes[{which}].transform": [{"translate": [0.25 * how, 0, 0]}]}
    if what == "fewer" and len(scene.shapes) > 1:
        return {"shapes": [s for i, s in enumerate(scene.shapes) if i != which]}
    return {"shapes": [*scene.shapes[1:], scene.shapes[0]]} if what == "first" else {}


def arrays(flat: FlatScene) -> dict[str, object]:
    """The sections, by name, and what they come to."""
    named = {entry.name: getattr(flat, entry.name) for entry in fields(FlatScene)}
    kept = {name: value for name, value in named.items() if name not in ("media", "pictures", "extents")}
    kept["numbers of media"] = None if flat.media is None else flat.media.numbers
    bits = {name: v.tobytes() if isinstance(v, np.ndarray) else v for name, v in kept.items()}
    return bits | {"hash": flat.hash}


def differing(one: FlatScene, other: FlatScene) -> list[str]:
    """The names of sections that differ by a bit."""
    found = arrays(other)
    return [name for name, value in arrays(one).items() if value != found[name]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """With a picture of 4 x 4 texels."""
    folder = tmp_path_factory.mktemp("pictures")
    clrt.Image(np.linspace(0, 1, 48, dtype=np.float32).reshape(4, 4, 3)).save(folder / "tile.png")
    return folder


@pytest.fixture(scope="module")
def beginning(folder: Path) -> Scene:
    material = [ANY[i % len(ANY)] for i in range(len(SHAPES))]
    shapes = [shape | {"material": m} for shape, m in zip(SHAPES, material, strict=True)]
    materials = {"a": {}, "b": CLEAR}
    return clrt.load_dict({"camera": CAMERA, "materials": materials, "shapes": shapes}, folder=folder)


@settings(max_examples=200, deadline=None, suppress_health_check=list(HealthCheck))
@given(edits=st.lists(EDIT, min_size=1, max_size=8))
def test_edits_give_the_arrays_of_a_new_scene(beginning: Scene, edits: list[Any]) -> None:
    """Materials inline and by name, pictures on faces of four corners, visible lights, one after another."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", clrt.ClrtWarning)
        scene, flat = beginning, flatten(beginning)
        for edit in edits:
            try:
                changed = scene.replace(edited(scene, edit))
                found = flatten(changed)
            except clrt.ClrtError:
                continue
            flat = flatten(changed, (scene, flat))
            scene = changed
            assert not differing(flat, found), edit


@pytest.mark.parametrize("back", [False, True])
def test_a_picture_that_comes_or_goes_makes_or_unmakes_triangles(back: bool, folder: Path) -> None:
    shapes = [SHAPES[0] | {"material": {}}, SHAPES[1] | {"material": {"color": PICTURE}}]
    plain = clrt.load_dict({"camera": CAMERA, "shapes": shapes}, folder=folder)
    pictured = plain.replace({"shapes[0].material": {"color": PICTURE}})
    scene, then = (pictured, plain) if back else (plain, pictured)
    assert not differing(flatten(then, (scene, flatten(scene))), flatten(then))


@pytest.mark.parametrize("keys", [{"smooth": True}, {"uv": [[0, 0], [1, 0], [1, 1], [0, 1]]}, {}])
def test_a_face_that_gets_or_loses_a_dent_is_cut_anew(keys: dict[str, Any]) -> None:
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    dart = [*square[:1], [0.3, 0.3, 0], *square[2:]]
    scenes = [
        clrt.load_dict({"shapes": [{"type": "mesh", "vertices": corners, "faces": [[0, 1, 2, 3]], **keys}]})
        for corners in (square, dart, square)
    ]
    scene, flat = scenes[0], flatten(scenes[0])
    for fresh, corners in zip(scenes[1:], (dart, square), strict=True):
        changed = scene.replace({"shapes[0].vertices": corners})
        flat = flatten(changed, (scene, flat))
        assert not differing(flat, flatten(fresh))
        scene = changed
