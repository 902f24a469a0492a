"""`Scene.replace`: what changes is checked as in a file, what does not stays the same object."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import clrt
from clrt.formats.native import with_values
from clrt.scene.scene import previewed

BASE: dict[str, Any] = {
    "max_depth": 3,
    "camera": {"origin": [0, 1, 5], "target": [0, 0, 0], "width": 32, "height": 24},
    "materials": {
        "red": {"color": [0.9, 0.1, 0.1]},
        "glass": {"transmission": 0.9, "ior": 1.5},
        "my.tiles": {"color": {"type": "checker", "colors": [[1, 1, 1], [0, 0, 0]], "size": 1}},
    },
    "lights": [{"type": "point", "position": [2, 4, 3]}, {"type": "directional", "direction": [0, -1, 0]}],
    "shapes": [
        {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "red", "name": "ball"},
        {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0], "material": "my.tiles"},
        {"type": "mesh", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]], "name": "sail"},
        {"type": "box", "min": [2, 0, 0], "max": [3, 1, 1], "material": {"diffuse": 0.5}},
    ],
}


@pytest.fixture(scope="module")
def scene() -> clrt.Scene:
    return clrt.load_dict(BASE, source="base.toml")


CHANGES: dict[str, tuple[dict[str, Any], Any]] = {
    "number": ({"camera.fov": 30}, lambda t: t["camera"].update(fov=30)),
    "list": ({"shapes[0].center": [0, 1, 0]}, lambda t: t["shapes"][0].update(center=[0, 1, 0])),
    "one number of a list": ({"shapes[0].center[1]": 2}, lambda t: t["shapes"][0].update(center=[0, 2, 0])),
    "shape by name": ({"shapes.ball.radius": 2}, lambda t: t["shapes"][0].update(radius=2)),
    "material": ({"materials.glass.ior": 1.4}, lambda t: t["materials"]["glass"].update(ior=1.4)),
    "quoted name": (
        {'materials."my.tiles".color.size': 2}, lambda t: t["materials"]["my.tiles"]["color"].update(size=2)
    ),
    "new material": (
        {"materials.blue": {"color": [0, 0, 1]}, "shapes[0].material": "blue"},
        lambda t: (t["materials"].update(blue={"color": [0, 0, 1]}), t["shapes"][0].update(material="blue")),
    ),
    "own material": (
        {"shapes[3].material.diffuse": 1}, lambda t: t["shapes"][3]["material"].update(diffuse=1)
    ),
    "whole table": ({"camera": {"origin": [0, 0, 9], "target": [0, 0, 0]}},
                    lambda t: t.update(camera={"origin": [0, 0, 9], "target": [0, 0, 0]})),
    "whole list": ({"lights": []}, lambda t: t.update(lights=[])),
    "part of a new list": (
        {"lights": [{"type": "point", "position": [1, 1, 1]}], "lights[0].intensity": 2},
        lambda t: t.update(lights=[{"type": "point", "position": [1, 1, 1], "intensity": 2}]),
    ),
    "two of one": ({"lights[0].intensity": 2, "lights[0].falloff": "inverse-square"},
                   lambda t: t["lights"][0].update(intensity=2, falloff="inverse-square")),
    "setting": ({"max_depth": 0, "ambient": 0.2}, lambda t: t.update(max_depth=0, ambient=0.2)),
    "spectrum": ({"spectrum": {"bands": 4}}, lambda t: t.update(spectrum={"bands": 4})),
    "vertices": (
        {"shapes.sail.vertices": np.eye(3)}, lambda t: t["shapes"][2].update(vertices=np.eye(3).tolist())
    ),
    "vertices and faces": (
        {"shapes[2].vertices": np.eye(4)[:, :3], "shapes[2].faces": [[0, 1, 2], [1, 2, 3]]},
        lambda t: t["shapes"][2].update(vertices=np.eye(4)[:, :3].tolist(), faces=[[0, 1, 2], [1, 2, 3]]),
    ),
    "another shape for a mesh": (
        {"shapes[2]": {"type": "sphere", "center": [0, 0, 0], "radius": 1}},
        lambda t: t["shapes"].__setitem__(2, {"type": "sphere", "center": [0, 0, 0], "radius": 1}),
    ),
    "another mesh": (
        {"shapes[2]": {"type": "mesh", "vertices": np.eye(3), "faces": [[2, 1, 0]]}},
        lambda t: t["shapes"].__setitem__(
            2, {"type": "mesh", "vertices": np.eye(3).tolist(), "faces": [[2, 1, 0]]}
        ),
    ),
    "a mesh for another shape": (
        {"shapes.ball": {"type": "mesh", "vertices": np.eye(3), "faces": [[2, 1, 0]]}},
        lambda t: t["shapes"].__setitem__(
            0, {"type": "mesh", "vertices": np.eye(3).tolist(), "faces": [[2, 1, 0]]}
        ),
    ),
    "one corner": ({"shapes[2].vertices[1]": [2, 0, 0]},
                   lambda t: t["shapes"][2].update(vertices=[[0, 0, 0], [2, 0, 0], [0, 1, 0]])),
    "two of one by its name": ({"shapes.ball.radius": 2, "shapes.ball.center": [0, 1, 0]},
                               lambda t: t["shapes"][0].update(radius=2, center=[0, 1, 0])),
    "by its new name": ({"shapes.ball.name": "moon", "shapes.moon.radius": 2},
                        lambda t: t["shapes"][0].update(name="moon", radius=2)),
    "four corners for three": (
        {"shapes[2].vertices": [*np.eye(3).tolist(), [1, 1, -1]], "shapes[2].faces": [[0, 1, 2]],
         "shapes[2].faces[0]": [0, 1, 3, 2], "shapes[2].smooth": True},
        lambda t: t["shapes"][2].update(
            vertices=[*np.eye(3).tolist(), [1, 1, -1]], faces=[[0, 1, 3, 2]], smooth=True),
    ),
    "transform": (
        {"shapes[0].transform": [{"scale": 2}]}, lambda t: t["shapes"][0].update(transform=[{"scale": 2}])
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CHANGES)
def test_it_is_what_a_file_with_these_values_says(name: str, scene: clrt.Scene) -> None:
    changes, edit = CHANGES[name]
    table = clrt.load_dict(BASE).to_dict()
    edit(table)
    assert scene.replace(changes) == clrt.load_dict(table)
    assert scene == clrt.load_dict(BASE), "the scene itself stays"


def test_what_does_not_change_stays_the_same_object(scene: clrt.Scene) -> None:
    other = scene.replace({"shapes[0].radius": 2, "materials.red.diffuse": 1})
    assert other.shapes[0] is not scene.shapes[0]
    assert all(a is b for a, b in zip(other.shapes[1:], scene.shapes[1:], strict=True))
    assert [a is b for a, b in zip(other.materials.values(), scene.materials.values(), strict=True)] == [
        False, True, True
    ]  # fmt: skip
    assert other.lights is scene.lights and other.camera is scene.camera
    moved = scene.replace({"shapes.sail.material": "red"}).shapes[2]
    assert moved.data() is scene.shapes[2].data(), "a mesh's arrays are not read again"


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "key": ({"camera.fv": 3}, "base.toml: camera: unknown key 'fv'; did you mean 'fov'?"),
    "table": ({"camra.fov": 3}, "base.toml: unknown key 'camra'; did you mean 'camera'?"),
    "number": ({"shapes[9].radius": 3}, "shapes: there is no number 9; there are 4, numbered from 0"),
    "material": ({"materials.galss.ior": 1}, "materials: there is no 'galss'; did you mean 'glass'?"),
    "name": ({"shapes.bell.radius": 1}, "no shape has the name 'bell'; did you mean 'ball'?"),
    "two of one name": ({"shapes[1].name": "ball", "shapes.ball.radius": 2},
                        "shapes: 2 shapes have that name; say which by its number"),
    "value": ({"camera.fov": 300}, "camera.fov: 300 is not allowed; fov must be an angle"),
    "kind": ({"shapes[0].center": "here"}, "shapes[0].center: 'here' is not allowed"),
    "nan": ({"shapes[0].center[0]": float("nan")}, "shapes[0].center[0]: nan"),
    "no part": ({"camera.fov.x": 3}, "camera.fov: 45.0 has no part 'x'"),
    "none": ({"spectrum.bands": 3}, "spectrum: there is none whose 'bands' could be set; give it whole"),
    "form": ({"shapes[x].radius": 3}, "'shapes[x].radius' names no place; a place in a scene is written"),
    "other digits": ({"shapes[\u0663].radius": 3}, "names no place"),
    "empty": ({"": 3}, "'' names no place"),
    "vertices": ({"shapes[2].vertices": np.zeros((4, 3))}, "4 in place of 3; give as many, or faces as well"),
    "faces": ({"shapes[2].faces": [[0, 1, 3]]}, "shapes[2].faces[0][2]: 3 is not allowed"),
    "a mesh's new kind": ({"shapes[2]": {"type": "box", "min": [0, 0, 0]}}, "the key 'max' is missing"),
    "unknown kind": ({"shapes[2].type": "mash"}, "shapes[2].type: 'mash' is not allowed; a shape is one of"),
    "no kind": ({"shapes[2]": {"vertices": np.eye(3), "faces": [[0, 1, 2]]}}, "the key 'type' is missing"),
    "kinds": ({"shapes[2]": {"type": np.zeros(2)}}, "shapes[2].type: "),
    "unknown material": ({"shapes[0].material": "rad"}, "did you mean 'red'?"),
    "checker": ({"shapes[3].material": "my.tiles"}, "a checker is for spheres, planes, polygons and disks"),
    "checker for all": ({"materials.red.color": {"type": "checker", "colors": [0, 1], "size": 1},
                         "shapes[2].material": "red"}, "a checker is for"),
    "whole materials": ({"materials": {}}, "shapes[0].material: 'red' is not allowed"),
    "up": ({"camera.up": [0, 0, 0]}, "camera.up: (0.0, 0.0, 0.0) is not allowed; up must not be zero"),
    "line": ({"spectrum": {"bands": 3}, "ambient": {"line": 2000}}, "ambient.line: 2000"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_names_the_place(name: str, scene: clrt.Scene) -> None:
    changes, text = WRONG[name]
    with pytest.raises(clrt.SceneError) as caught:
        scene.replace(changes)
    message = str(caught.value)
    assert text in message and message.startswith("base.toml: ") and "\n" not in message, message


@pytest.mark.parametrize("value", [1.5, "1", True, None, [1], 7, [1, 2], ["1", 2, 0], [True, 0, 0], -1])
@pytest.mark.parametrize("place", ["vertices[0]", "vertices[0][1]", "faces[0]", "faces[0][1]"])
def test_a_part_of_an_array_is_what_it_is_in_a_file(place: str, value: Any, scene: clrt.Scene) -> None:
    """numpy casts what is put into an array without a word."""
    table = clrt.load_dict(BASE).to_dict()
    name, *steps = place.replace("]", "").split("[")
    rows = table["shapes"][2][name]
    for step in steps[:-1]:
        rows = rows[int(step)]
    rows[int(steps[-1])] = value
    assert _outcome(lambda: scene.replace({f"shapes.sail.{place}": value})) == _outcome(
        lambda: clrt.load_dict(table, source="base.toml")
    )


def _outcome(make: Any) -> Any:
    try:
        return make()
    except clrt.SceneError as error:
        return str(error)


def test_numbers_of_numpy_are_as_pythons(scene: clrt.Scene, tmp_path: Path) -> None:
    given = {"width": 8, "height": 6, "spp": 4, "max_depth": 2}
    other = scene.override(**{name: np.int64(value) for name, value in given.items()})
    assert other == scene.override(**given)
    other.save(tmp_path / "scene.json")
    assert clrt.load(tmp_path / "scene.json") == other


@pytest.mark.parametrize("changes", [None, 3, {3: 4}, [("camera.fov", 3)]])
def test_changes_are_a_dict(changes: Any, scene: clrt.Scene) -> None:
    with pytest.raises(clrt.ClrtError, match=r"changes: .* it must be a dict whose keys are texts"):
        scene.replace(changes)


def test_limits_hold(scene: clrt.Scene) -> None:
    few = clrt.load_dict(BASE, limits=clrt.Limits(lights=2, primitives=9, vertices=3))
    for changes in ({"lights": [BASE["lights"][0]] * 3}, {"shapes": BASE["shapes"] + [BASE["shapes"][3]]}):
        with pytest.raises(clrt.LimitError):
            few.replace(changes)
    with pytest.raises(clrt.LimitError, match="vertices"):
        few.replace({"shapes[2].vertices": np.eye(4)[:, :3], "shapes[2].faces": [[0, 1, 2]]})


PATHS = st.one_of(
    st.text(max_size=20),
    st.lists(st.sampled_from(["camera", "fov", "shapes", "[0]", "[99]", ".", '"', "center", "materials",
                              "red", "lights", "[1]", "color", "vertices", "[", "]", "spectrum"]),
             max_size=6).map("".join),
    st.lists(st.sampled_from(["camera", "fov", "shapes", "materials", "red", "lights", "origin"]),
             min_size=1, max_size=3).map(".".join),
)  # fmt: skip
VALUES = st.one_of(
    st.none(), st.booleans(), st.floats(), st.integers(), st.text(max_size=5), st.just([0, 1, 2]),
    st.just({}), st.just([[0, 0, 0]]),
    st.dictionaries(st.sampled_from(["type", "origin", "x"]), st.floats(), max_size=2),
)  # fmt: skip


@given(changes=st.dictionaries(PATHS, VALUES, max_size=3))
def test_whatever_is_asked_for_is_a_scene_or_one_error(changes: dict[str, Any], scene: clrt.Scene) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            other = scene.replace(changes)
            assert other == clrt.load_dict(other.to_dict())
        except clrt.ClrtError as error:
            assert "\n" not in str(error)


@pytest.mark.parametrize("whole", [None, 5, "abc", 1.5])
@pytest.mark.parametrize("top", ["lights", "shapes", "materials"])
def test_parts_of_what_is_no_list_and_no_table(scene: clrt.Scene, top: str, whole: Any) -> None:
    with pytest.raises(clrt.SceneError, match=rf"{top}: .* has no part '0'"):
        scene.replace({top: whole, f"{top}[0]": None})


@pytest.mark.parametrize("whole", [5, "abc", [1], None])
def test_parts_of_what_is_no_camera(scene: clrt.Scene, whole: Any) -> None:
    with pytest.raises(clrt.SceneError, match=r"base.toml: camera: .*('fov'|give it whole)"):
        scene.replace({"camera": whole, "camera.fov": 30})


def test_what_is_given_stays_as_it_is(scene: clrt.Scene) -> None:
    light = {"type": "point", "position": [0, 1, 0]}
    for told in ([light], (light,)):
        found = scene.replace({"lights": told, "lights[0].position": [0, 2, 0]})
        assert found.lights[0].position == (0.0, 2.0, 0.0) and told[0]["position"] == [0, 1, 0]


def test_a_part_of_adaptive_makes_a_scene_adaptive(scene: clrt.Scene) -> None:
    assert scene.adaptive is None
    made = scene.replace({"adaptive.spp": 16})
    assert made == scene.replace({"adaptive": {"spp": 16}})
    assert made.replace({"adaptive.threshold": 0.5}).to_dict()["adaptive"] == {"spp": 16, "threshold": 0.5}
    with pytest.raises(clrt.SceneError, match="adaptive: unknown key 'steps'"):
        scene.replace({"adaptive.steps": 16})


def test_samples_go_together_as_in_a_file(scene: clrt.Scene, tmp_path: Path) -> None:
    """What is saved loads again; a picture may be asked for with other samples than the scene states."""
    adaptive = scene.replace({"camera.spp": 9, "adaptive": {"spp": 36}})
    adaptive.save(tmp_path / "s.toml")
    assert clrt.load(tmp_path / "s.toml").adaptive == adaptive.adaptive
    text = r"^base.toml: adaptive.spp: 36 is not allowed; grids double their sides from camera.spp = "
    for changes in ({"camera.spp": 4}, {"camera": dict(BASE["camera"], spp=4)}):
        with pytest.raises(clrt.SceneError, match=text + "4 on: .*such as 16 or 64$"):
            adaptive.replace(changes)
    with pytest.raises(clrt.SceneError, match=text + "1 on"):
        scene.replace({"adaptive": {"spp": 36}})
    with pytest.raises(clrt.SceneError, match=r"^base.toml: adaptive: conformance counts the rays"):
        adaptive.replace({"conformance": "spd"})
    assert adaptive.replace({"max_depth": 2, "camera.fov": 20, "adaptive.spp": 144}).max_depth == 2
    assert previewed(adaptive, 9) is adaptive and previewed(scene, 4) is scene
    even = previewed(adaptive, 4)
    assert even.adaptive is None and even.shapes is adaptive.shapes
    # clrt render --spp 9 --adaptive 36
    asked = with_values(scene, [("adaptive", "{spp = 36}")]).override(spp=9)
    assert asked.camera and asked.adaptive and (asked.camera.spp, asked.adaptive.spp) == (9, 36)
