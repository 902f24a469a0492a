"""The scene model: what is accepted, and what it means."""

from __future__ import annotations

import importlib
import json
import tomllib
import warnings
from pathlib import Path

import jsonschema
import msgspec
import numpy as np
import pytest

import clrt
from clrt.base.records import Record, _rounds_safely
from clrt.scene.scene import (
    Camera,
    DirectionalLight,
    Material,
    Mesh,
    PointLight,
    Scene,
    Sphere,
    Step,
    rgb,
)
from clrt.scene.schema import SCHEMA_FILE, schema, schema_text
from tests.scene_samples import QUAD, every_kind

EXAMPLE = """
max_depth = 5
background = [0.05, 0.1, 0.2]
ambient = 0.1
[camera]
origin = [0.0, 2.2, 6.5]
target = [0.0, 0.7, 0.0]
[materials.glass]
diffuse = 0.0
reflection = 0.1
transmission = 0.85
ior = "glass"
[[lights]]
type = "point"
position = [3.0, 5.0, 4.0]
[[shapes]]
type = "sphere"
center = [0.6, 0.8, 1.2]
radius = 0.8
material = "glass"
"""


def test_defaults_are_those_of_the_documentation() -> None:
    scene = Scene(camera=Camera(origin=(0, 0, 1), target=(0, 0, 0)))
    assert scene.max_depth == 5 and scene.min_weight == 0 and scene.background == 0 and scene.medium_ior == 1
    assert scene.one_sided == "none" and scene.shadow == "opaque" and scene.conformance == "none"
    camera = scene.camera
    assert camera is not None
    assert (camera.type, camera.up, camera.fov, camera.size) == ("perspective", (0, 1, 0), 45, 2)
    assert (camera.width, camera.height, camera.spp, camera.jitter) == (640, 480, 1, None)
    material = Material()
    assert (material.color, material.ka, material.diffuse, material.kr, material.kt) == (0.8, 1, 1, 0, 0)
    assert (material.shininess, material.ior_d, material.fresnel, material.thin) == (32, 1.5, False, False)


def test_same_scene_from_toml_json_dict_and_objects(tmp_path: Path) -> None:
    table = tomllib.loads(EXAMPLE)
    (tmp_path / "a.toml").write_text(EXAMPLE)
    (tmp_path / "a.json").write_text(json.dumps({"$schema": "scene.schema.json", **table}))
    objects = Scene(
        background=np.array([0.05, 0.1, 0.2]),
        ambient=0.1,
        camera=Camera(origin=np.array([0.0, 2.2, 6.5]), target=(0, 0.7, 0)),
        materials={"glass": Material(diffuse=0, reflection=0.1, transmission=0.85, ior="glass")},
        lights=[PointLight(position=[3, 5, 4])],
        shapes=[Sphere(center=[0.6, 0.8, 1.2], radius=0.8, material="glass")],
    )
    assert (
        objects == clrt.load_dict(table) == clrt.load(tmp_path / "a.toml") == clrt.load(tmp_path / "a.json")
    )
    assert clrt.load(tmp_path / "a.toml").folder == tmp_path


def test_scenes_differ_where_any_value_differs() -> None:
    scene = every_kind()
    assert scene != msgspec.structs.replace(scene, max_depth=4)
    assert scene != msgspec.structs.replace(scene, shapes=scene.shapes[:-1])
    moved = msgspec.structs.replace(scene.shapes[3], vertices=np.array(QUAD) + 0.5)
    assert scene != msgspec.structs.replace(scene, shapes=(*scene.shapes[:3], moved, *scene.shapes[4:]))


def test_to_dict_has_builtin_types_only_and_no_defaults() -> None:
    table = every_kind().to_dict()
    assert json.loads(json.dumps(table)) == table
    assert clrt.load_dict(table) == every_kind()
    assert table["shapes"][0] == {
        "type": "sphere",
        "name": "ball",
        "center": [0, 0, 0],
        "radius": 1,
        "material": "red",
    }
    assert "version" not in table and "folder" not in table and "ambient" not in table


def test_places_of_lights() -> None:
    assert PointLight(position=(1, 2, 3)).place == (1, 2, 3, 1)
    sun = DirectionalLight(direction=(0, -2, 1))
    assert (sun.place, sun.falloff) == ((0, 2, -1, 0), "none")


def test_colours_and_presets() -> None:
    assert rgb(0.5) == (0.5, 0.5, 0.5)
    assert rgb((1, 2, 3)) == (1.0, 2.0, 3.0)
    presets = {"air": 1.0, "water": 1.333, "ice": 1.31, "glass": 1.5, "diamond": 2.419}
    assert {name: Material(ior=name).ior_d for name in presets} == presets
    assert Material(ior=1.7).ior_d == 1.7


def test_fresnel_switches_the_default_of_both_coefficients() -> None:
    assert (Material(fresnel=True).kr, Material(fresnel=True).kt) == (1, 1)
    assert (Material(fresnel=True, reflection=0.5).kr, Material(fresnel=True, transmission=0).kt) == (0.5, 0)
    assert (Material(fresnel="schlick").kr, Material(fresnel="schlick").kt) == (0, 0)
    assert Material(diffuse=0.3, ambient=0.1).ka == 0.1


def test_up_falls_back_to_z_only_by_default() -> None:
    down = {"origin": [0, 5, 0], "target": [0, 0, 0]}
    assert clrt.load_dict({"camera": down}).camera.up == (0, 0, 1)
    assert clrt.load_dict({"camera": {**down, "up": [1, 0, 0]}}).camera.up == (1, 0, 0)


def test_transform_steps_apply_in_order() -> None:
    sphere = Sphere(center=(0, 0, 0), radius=1, transform=[Step(translate=(1, 0, 0)), Step(rotate=("z", 90))])
    np.testing.assert_array_equal(sphere.matrix @ [0, 0, 0, 1], [0, 1, 0, 1])
    other = Sphere(center=(0, 0, 0), radius=1, transform=[Step(rotate=("z", 90)), Step(translate=(1, 0, 0))])
    np.testing.assert_array_equal(other.matrix @ [0, 0, 0, 1], [1, 0, 0, 1])
    scaled = Sphere(center=(0, 0, 0), radius=1, transform=[Step(scale=(1, 2, 3)), Step(scale=2)])
    np.testing.assert_array_equal(scaled.matrix, np.diag([2, 4, 6, 1]))
    np.testing.assert_array_equal(Sphere(center=(0, 0, 0), radius=1).matrix, np.eye(4))
    rows = [*np.arange(12.0).reshape(3, 4).tolist(), [0, 0, 0, 1]]
    np.testing.assert_array_equal(Sphere(center=(0, 0, 0), radius=1, transform=rows).matrix, rows)


@pytest.mark.parametrize("axis", [(1, 2, 3), (0, 0, -4), "x", "y"])
@pytest.mark.parametrize("degrees", [-90, 30, 123.4, 180, 360])
def test_rotations_are_those_of_quaternions(axis: object, degrees: float) -> None:
    unit = np.eye(3)["xyz".index(axis)] if isinstance(axis, str) else np.array(axis) / np.linalg.norm(axis)
    w, v = np.cos(np.radians(degrees) / 2), np.sin(np.radians(degrees) / 2) * unit
    point = np.array([0.3, -0.7, 1.1])
    expected = point + 2 * np.cross(v, np.cross(v, point) + w * point)
    np.testing.assert_allclose(Step(rotate=(axis, degrees)).matrix[:3, :3] @ point, expected, atol=1e-15)


def test_mesh_data() -> None:
    scene = every_kind()
    triangles, mixed = scene.shapes[3].data(), scene.shapes[4].data()
    assert triangles.faces.dtype == np.int32 and triangles.faces.shape == (2, 3)
    assert triangles.normals.shape == (4, 3) and triangles.vertices.dtype == np.float64
    assert [face.tolist() for face in mixed.faces] == [[0, 1, 2, 3], [0, 1, 2]] and mixed.normals is None
    quads = Scene(shapes=[Mesh(vertices=np.array(QUAD, np.float32), faces=np.array([[0, 1, 2, 3]]))]).shapes[
        0
    ]
    assert [face.tolist() for face in quads.data().faces] == [[0, 1, 2, 3]]
    assert Mesh(vertices=QUAD, faces=[[0, 1, 2]]).data().faces.tolist() == [[0, 1, 2]]  # without a scene, too
    with pytest.raises(ValueError, match="read-only"):
        triangles.vertices[0, 0] = 9


@pytest.mark.parametrize("smooth", [None, True, False])
def test_normals_in_place_count_unless_smooth_is_false(smooth: bool | None) -> None:
    table = {"type": "mesh", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]],
             "normals": [[0, 0.6, 0.8]] * 3, "smooth": smooth}  # fmt: skip
    scene = clrt.load_dict({"ambient": 1, "shapes": [{k: v for k, v in table.items() if v is not None}]})
    (shape,) = scene.shapes
    assert isinstance(shape, Mesh) and (shape.data().normals is None) == (smooth is False)
    assert scene == clrt.load_dict(scene.to_dict())


def test_smooth_normals_are_weighted_by_area() -> None:
    vertices = [[0, 0, 0], [2, 0, 0], [0, 3, 0], [0, 0, 1]]
    mesh = Scene(shapes=[Mesh(vertices=vertices, faces=[[0, 1, 2], [0, 3, 1]], smooth=True)]).shapes[0]
    normals = mesh.data().normals  # the faces' normals, twice their areas long: (0, 0, 6) and (0, 2, 0)
    np.testing.assert_allclose(normals[0], [0, 1 / 10**0.5, 3 / 10**0.5])
    np.testing.assert_allclose(normals[2], [0, 0, 1])
    np.testing.assert_allclose(normals[3], [0, 1, 0])


def test_primitive_counts() -> None:
    assert [shape.primitives for shape in every_kind().shapes] == [1, 1, 1, 2, 2, 1, 1, 3, 2, 1, 1, 6]
    fan = Mesh(vertices=QUAD, faces=[[0, 1, 2, 3], [0, 1, 2]], smooth=True)
    assert fan.primitives == 3


def test_branching_needs_one_surface_that_does_both() -> None:
    mirror, glass = Material(reflection=0.5, diffuse=0.5), Material(transmission=0.5, diffuse=0)
    ball = Sphere(center=(0, 0, 0), radius=1)

    def branching(*materials: Material, **settings: str) -> bool:
        shapes = [msgspec.structs.replace(ball, material=material) for material in materials]
        return Scene(shapes=shapes, **settings).branching

    assert not branching(mirror, glass)
    assert branching(mirror, Material(transmission=0.5, reflection=0.1, diffuse=0))
    assert branching(glass, conformance="spd")  # there a reflection of weight 0 is traced, too
    unused = Material(transmission=0.5, reflection=0.1)
    assert not Scene(materials={"unused": unused}, shapes=[ball]).branching


def test_override_checks_what_it_changes() -> None:
    scene = every_kind()
    other = scene.override(width=10, height=20, spp=9, max_depth=0)
    assert (other.camera.width, other.camera.height, other.camera.spp, other.max_depth) == (10, 20, 9, 0)
    assert other.shapes is scene.shapes and scene.max_depth == 3 and scene.camera.width == 640
    with pytest.raises(clrt.SceneError, match=r"camera.width: 0 is not allowed"):
        scene.override(width=0)
    with pytest.raises(clrt.SceneError, match=r"max_depth: -1 is not allowed"):
        scene.override(max_depth=-1)
    with pytest.raises(clrt.SceneError, match="there is no camera"):
        Scene().override(width=5)


def test_an_empty_scene_is_valid() -> None:
    assert clrt.load_dict({}) == Scene()
    assert Scene().shapes == () and Scene().lights == () and Scene().camera is None


def warned(table: dict[str, object]) -> list[str]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        clrt.load_dict(table, source="room.toml")
    assert all(issubclass(warning.category, clrt.ClrtWarning) for warning in caught)
    return [str(warning.message) for warning in caught]


def test_bright_materials_are_warned_about_once() -> None:
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
    bright = {**ball, "material": {"diffuse": 0.6, "specular": 0.5, "reflection": 0.3, "transmission": 0.1}}
    (message,) = warned({"shapes": [ball, bright, bright]})
    assert message.startswith(
        "room.toml: shapes[1]: diffuse + max(specular, reflection) + transmission is 1.2"
    )
    exact = {**ball, "material": {"diffuse": 0.6, "specular": 0.3, "transmission": 0.1}}
    glass = {**ball, "material": {"diffuse": 0.0, "fresnel": True}}
    assert warned({"shapes": [exact, glass]}) == []


@pytest.mark.parametrize(
    ("shape", "opens"),
    [
        ({"type": "polygon", "points": QUAD}, True),
        ({"type": "disk", "center": [0, 0, 0], "normal": [0, 0, 1], "radius": 1}, True),
        ({"type": "cylinder", "p0": [0, 0, 0], "p1": [0, 0, 1], "radius": 1}, True),
        ({"type": "cylinder", "p0": [0, 0, 0], "p1": [0, 0, 1], "radius": 1, "caps": True}, False),
        ({"type": "cone", "p0": [0, 0, 0], "r0": 1, "p1": [0, 0, 1], "r1": 0}, True),
        ({"type": "quadric", "coefficients": [1, 1, 0, 0, 0, 0, 0, 0, 0, -1]}, False),
        (
            {
                "type": "quadric",
                "coefficients": [1, 1, 0, 0, 0, 0, 0, 0, 0, -1],
                "clip": [[-2, -2, 0], [2, 2, 1]],
            },
            True,
        ),
        ({"type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1]}, False),
        ({"type": "sphere", "center": [0, 0, 0], "radius": 1}, False),
        ({"type": "box", "min": [0, 0, 0], "max": [1, 1, 1]}, False),
    ],
)
def test_open_glass_is_warned_about(shape: dict[str, object], opens: bool) -> None:
    glass = {"diffuse": 0.0, "transmission": 0.9}
    messages = warned({"shapes": [{**shape, "material": glass}]})
    assert [message.startswith("room.toml: shapes[0]: an open") for message in messages] == [True] * opens
    assert warned({"shapes": [{**shape, "material": {**glass, "thin": True}}]}) == []
    assert warned({"shapes": [shape]}) == []


@pytest.mark.parametrize(("table", "visible", "transmission", "told"), [
    ({}, True, 1.0, True), ({"shadow": "opaque"}, True, 1.0, False),
    ({"ambient_samples": 0}, True, 1.0, False),
    ({}, False, 1.0, False), ({}, True, 0.0, False),
])  # fmt: skip
def test_light_behind_glass_that_is_counted_twice_is_told(
    table: dict[str, object], visible: bool, transmission: float, told: bool
) -> None:
    """By tinted feelers and by ambient rays: below a lamp and a clear sheet a floor was twice as bright."""
    lamp = {"type": "rectangle", "center": [0, 2, 0], "u": [1, 0, 0], "v": [0, 0, 1], "radiance": 1}
    material = {"diffuse": 0.0, "transmission": transmission, "thin": True}
    sheet = {"type": "disk", "center": [0, 1, 0], "normal": [0, 1, 0], "radius": 3, "material": material}
    given = {"shadow": "tinted", "ambient": 1, "ambient_samples": 16, "shapes": [sheet]}
    said = warned({**given, "lights": [{**lamp, "visible": visible}], **table})
    starts = "room.toml: shadow: tinted feelers and ambient rays"
    assert [text.startswith(starts) for text in said] == [True] * told


@pytest.mark.parametrize(("more", "told"), [
    ({}, True), ({"specular": 0.5, "fresnel": "schlick"}, True), ({"reflection": 0.2}, False),
    ({"conductor": "gold"}, False), ({"roughness": 0.0}, False),
])  # fmt: skip
def test_roughness_without_reflections_is_told(more: dict[str, object], told: bool) -> None:
    material = {"diffuse": 0.0, "roughness": 0.3, **more}
    shape = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": material}
    text = "room.toml: shapes[0].material.roughness: 0.3 blurs reflections, of which it has none; "
    text += "set reflection, fresnel or conductor, too"
    assert warned({"shapes": [shape]}) == [text] * told


def test_a_scene_s_classes_are_public_names_of_its_room() -> None:
    room = importlib.import_module("clrt.scene")
    assert room.RectangleLight is importlib.import_module("clrt.scene.arealights").RectangleLight
    assert {"Scene", "Material", "SpotLight", "Adaptive", "Sphere"} <= set(dir(room))
    for name in ("Nothing", "nothing", "read_scene"):
        with pytest.raises(AttributeError, match=f"module 'clrt.scene' has no attribute {name!r}"):
            getattr(room, name)


def test_the_schema_file_is_current() -> None:
    assert SCHEMA_FILE.read_text("utf-8") == schema_text(), "run: python -m clrt.scene.schema"


def test_the_schema_accepts_scenes_and_refuses_faults() -> None:
    validator = jsonschema.Draft202012Validator(schema())
    validator.check_schema(schema())
    for table in (every_kind().to_dict(), tomllib.loads(EXAMPLE), {"$schema": "a.json"}):
        assert list(validator.iter_errors(table)) == []
    for fault in ({"max_dept": 3}, {"ambient": -1}, {"shapes": [{"type": "sphere", "radius": 1}]}):
        assert not validator.is_valid(fault)


def test_a_million_triangles_are_read_without_a_loop() -> None:
    side = 708
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    vertices = np.stack([x, y, np.sin(x + y)], axis=-1).reshape(-1, 3)
    corner = (x[:-1, :-1] + side * y[:-1, :-1]).reshape(-1)
    lower = np.stack([corner, corner + 1, corner + side], axis=1)
    upper = np.stack([corner + 1, corner + side + 1, corner + side], axis=1)
    faces = np.concatenate([lower, upper])
    scene = Scene(shapes=[Mesh(vertices=vertices, faces=faces)])
    assert scene.shapes[0].primitives == len(faces) == 999698


def test_a_scene_shows_itself_in_a_notebook() -> None:
    scene = clrt.load_dict({"shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "name": "<b>"}]})
    page = scene._repr_html_()
    assert "1 sphere" in page and "<b>" not in page.replace("<b>1", "")
    assert scene._repr_mimebundle_()["text/html"] == page


def test_adaptive_grids_do_not_go_with_counted_rays() -> None:
    with pytest.raises(clrt.SceneError, match=r"adaptive: conformance counts the rays of one even grid"):
        clrt.load_dict({"adaptive": {"spp": 64}, "conformance": "spd"})
    assert clrt.load_dict({"adaptive": {"spp": 64}}).camera is None


def test_only_cameras_say_one_thing_in_two_ways() -> None:
    assert Camera.instead_of("pose", {}) and not Material.instead_of("color", {})


def test_numbers_may_be_of_numpy() -> None:
    plain = {"ambient": 0.5, "shapes": [{"type": "sphere", "center": [0, 1, 0], "radius": 1}]}
    theirs = {"ambient": np.float32(0.5), "shapes": [{**plain["shapes"][0], "center": np.array([0, 1, 0])}]}
    assert clrt.load_dict(theirs).to_dict() == clrt.load_dict(plain).to_dict()


@pytest.mark.parametrize("kind", [Sphere, Mesh, Material])
def test_scenes_of_millions_are_read_the_short_way(kind: type[Record]) -> None:
    """Their tables are checked once: rounding to float32 leaves no range of theirs, closed at 0 and 1."""
    assert _rounds_safely(kind) and not _rounds_safely(Camera), "fov is open at 180"


def test_the_material_of_what_is_no_shape_of_the_scene() -> None:
    red = clrt.load_dict({
        "materials": {"red": {"color": [1, 0, 0]}},
        "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "red"}],
    })
    assert red.material_of(red.shapes[0]) is red.materials["red"]
    with pytest.raises(clrt.ClrtError, match=r"shape: 'red' is not allowed; it must be one of scene\.shapes"):
        red.material_of("red")  # type: ignore[arg-type]
    with pytest.raises(clrt.ClrtError, match=r"shape\.material: 'red' is not allowed; it is no material of"):
        clrt.Scene().material_of(red.shapes[0])
