"""Thousands of wrong calls of every public function: each is a ClrtError, in clrt's own words."""

from __future__ import annotations

import copy
import errno
import inspect
import json
import sys
import warnings
from collections import UserList, deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from tests.scene_samples import every_kind

SCENE = {
    "camera": {"origin": [0, 1, 4], "target": [0, 0, 0], "width": 8, "height": 6},
    "lights": [{"type": "point", "position": [3, 5, 4]}],
    "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}],
}
HUGE = 10**400


class Strange:
    """An object with which nothing can be done."""

    def __repr__(self) -> str:
        raise ValueError("cannot even be shown")


class Pathlike:
    def __fspath__(self) -> int:  # type: ignore[override]
        return 5


ONE = [[0.0, 0.0, 4.0]]
EVERYTHING: list[Any] = [
    None, True, False, np.True_, 0, 1, -1, 3, HUGE, -HUGE, 10**5000, 1.5, float("nan"), float("inf"), 1j,
    "", "x", "a\0b", "x" * 200, "no\nlines", "\ud800", b"bytes", b"\xff", [], [None], [1, [2, 3]], ["x", 5],
    (), (1, 2, 3, 4), (0, 0, 1.5, 2), ("a", "b", "c", "d"), {}, {1: 2}, {"shapes": 5}, set(), {"x"}, object(),
    Strange(), Pathlike(), Path("nothing.toml"), Path("a\0b"), np.int64(3), np.float32(2), np.array(5),
    np.array(["x"]), np.array([None]), np.zeros((2, 3)), np.zeros((2, 3), complex), np.zeros(0),
    np.zeros((1, 2)),
    np.zeros((1, 3), "datetime64[s]"), np.zeros((1, 3), bool), [[HUGE, 0, 0]], [[1, 2, 3], [4, 5]],
    [["a"] * 3], ONE, lambda: None, len, int, range(3), clrt, clrt.Limits(), clrt.Settings(),
    NotImplemented, ..., memoryview(b"abc"), iter([]), (n for n in ()), Exception("x"), bytearray(b"abc"),
    np.array(None), np.array({}), memoryview(np.eye(3)), memoryview(np.array([[0, 1, 2]])),
    np.zeros((2, 3), ">f4"),
    np.timedelta64(5, "s"), np.timedelta64(5), np.datetime64(5, "ns"), np.array([np.timedelta64(1)], object),
    np.zeros(2, [("x", "f4")]), np.zeros((1,) * 40), UserList([1, 2, 3]), deque([1, 2, 3]), map(str, ()),
]  # fmt: skip


def accepted(error: BaseException) -> bool:
    """Whether an error is one that clrt may raise for a wrong argument."""
    return isinstance(error, clrt.ClrtError) and "\n" not in str(error) and len(str(error)) > 10


def attempt(call: Callable[..., Any], named: dict[str, Any]) -> str:
    """What is wrong with how a call ends; nothing where it succeeds or a ClrtError says what is wrong."""
    try:
        call(**named)
    except BaseException as error:
        return "" if accepted(error) else f"{type(error).__name__}: {str(error)[:100]}"
    return ""


@pytest.fixture(autouse=True)
def _shown_elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures for a viewer stay among temporary files."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))


@pytest.fixture(scope="module")
def tracer() -> clrt.Tracer:
    return clrt.Tracer(clrt.load_dict(SCENE))


@pytest.fixture(scope="module")
def image(tracer: clrt.Tracer) -> clrt.Image:
    return tracer.render(layers=["depth", "crypto_shape"])


def _calls(
    tracer: clrt.Tracer, image: clrt.Image, folder: Path
) -> dict[str, tuple[Callable[..., Any], dict]]:
    """Every public entry point with arguments that are right."""
    trimesh = pytest.importorskip("trimesh", reason="needs the optional dependency clrt[mesh]")
    mesh = trimesh.creation.icosphere(subdivisions=1)
    mesh_rays = clrt.RayMeshIntersector(mesh)
    rays = {"origins": ONE, "directions": [[0, 0, -1]]}
    bounds = {"t_max": 5.0, "t_min": 0.5}
    many = {"ray_origins": ONE, "ray_directions": [[0, 0, -1]]}
    (folder / "scene.toml").write_text('[[shapes]]\ntype = "sphere"\ncenter = [0, 0, 0]\nradius = 1\n')
    picture = image.save(folder / "picture.png")
    scene = tracer.scene
    small: dict[str, Any] = {
        "width": 4,
        "height": 3,
        "spp": 1,
        "max_depth": 1,
        "layers": ["depth"],
        "crop": None,
    }
    small |= {"progress": None, "checkpoint": None, "camera": None}
    limits = dict.fromkeys(inspect.signature(clrt.Limits).parameters, 5)
    settings: dict[str, Any] = {"tile": 5, "local_size": 1, "lanes": 8, "threads": 1, "check": False}
    settings |= {"limits": clrt.Limits()}
    given = {"pixels": image.pixels, "layers": {}, "stats": {}, "metadata": {}, "wavelengths": ()}
    own = {"path": folder / "scene.toml", "limits": None}
    return {
        "load": (clrt.load, own),
        "load of an option": (clrt.load, {**own, "conformance": None, "smooth": None}),
        "load_dict": (clrt.load_dict, {"data": SCENE, "folder": None, "source": "", "limits": None}),
        "render": (clrt.render, {"scene": scene, "device": None, "settings": None, "executor": None,
                                 **small}),
        "Tracer": (clrt.Tracer, {"scene": scene, "device": None, "settings": None}),
        "Tracer.render": (tracer.render, small),
        "Tracer.intersect": (tracer.intersect, {**rays, **bounds, "fields": ["t"]}),
        "Tracer.occluded": (tracer.occluded, {**rays, **bounds}),
        "Tracer.count_hits": (tracer.count_hits, {**rays, **bounds}),
        "Tracer.all_hits": (tracer.all_hits, {**rays, **bounds, "fields": ["t"]}),
        "Tracer.radiance": (tracer.radiance, {**rays, "max_depth": 1}),
        "Tracer.update": (clrt.Tracer(scene).update, {"scene": scene}),
        "Tracer.explain": (tracer.explain, {"x": 1, "y": 2, "width": 4, "height": 3, "spp": 1, "max_depth": 1,
                                            "camera": None}),
        "RayTree.save": (tracer.explain(1, 2).save, {"path": folder / "tree.json"}),
        "Tracer.camera_rays": (tracer.camera_rays, {"camera": None}),
        "Tracer.identity": (tracer.identity, {"width": 4, "height": 3, "spp": 1, "max_depth": 1,
                                              "layers": ["depth"], "crop": None, "camera": None}),
        "sweep": (clrt.sweep, {"scene": scene, "changes": {"max_depth": [1]}, "device": None,
                               "settings": None, "executor": None}),
        "widget": (clrt.widget, {"scene": scene, "device": None}),
        "turntable": (clrt.turntable, {"camera": scene.camera, "frames": 2}),
        "camera_path": (clrt.camera_path, {"keys": [scene.camera] * 2, "frames": 3, "closed": False,
                                           "times": [0, 1]}),
        "Image": (clrt.Image, given),
        "Image.save": (image.save, {"path": folder / "out.png", "exposure": 0.0, "bits": 8}),
        "Image.show": (image.show, {"exposure": 0.0}),
        "Image.save in a view": (image.save, {"path": folder / "out.png", "view": None}),
        "Image.save_layers": (image.save_layers, {"path": folder / "out.png", "exposure": 0.0, "bits": 8,
                                                  "view": None}),
        "Image.matte": (image.matte, {"name": "shapes[0]", "of": "shape"}),
        "read_image": (clrt.read_image, {"path": picture, "limits": None, "layers": "all"}),
        "Settings": (clrt.Settings, settings),
        "Limits": (clrt.Limits, limits),
        "Scene": (clrt.Scene, {"camera": tracer.scene.camera, "lights": [], "shapes": [],
                               "materials": {}, "folder": None, "source": "", "limits": clrt.Limits(),
                               "max_depth": 1, "background": 0.0, "medium_ior": 1.0, "spectrum": None}),
        "Scene.override": (scene.override, {"width": 4, "height": 3, "spp": 1, "max_depth": 1}),
        "Scene.replace": (scene.replace, {"changes": {"max_depth": 2}}),
        "Scene.save": (scene.save, {"path": folder / "out.toml"}),
        "RayMeshIntersector": (clrt.RayMeshIntersector, {"geometry": mesh, "device": None, "settings": None}),
        "intersects_first": (mesh_rays.intersects_first, many),
        "intersects_any": (mesh_rays.intersects_any, many),
        "intersects_id": (mesh_rays.intersects_id,
                          {**many, "multiple_hits": True, "max_hits": 3, "return_locations": True}),
        "intersects_location": (mesh_rays.intersects_location,
                                {**many, "multiple_hits": True, "max_hits": 3}),
        "contains_points": (mesh_rays.contains_points, {"points": ONE}),
    }  # fmt: skip


def test_wrong_arguments_are_errors_of_clrt(
    tracer: clrt.Tracer, image: clrt.Image, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("clrt.images.image._viewer", lambda: ["true"])
    found, tried = [], 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # numpy's, too, are foreign words
        warnings.simplefilter("ignore", clrt.ClrtWarning)
        for name, (call, right) in _calls(tracer, image, tmp_path).items():
            for parameter in right:
                for value in EVERYTHING:
                    if parameter == "progress" and callable(value):
                        continue  # what it raises is the user's own
                    fault = attempt(call, {**right, parameter: value})
                    tried += 1
                    if fault:
                        found.append(f"{name}: {parameter} = {type(value).__name__} {_short(value)}: {fault}")
    assert not found, f"{len(found)} of {tried}:\n" + "\n".join(found)
    assert tried > 5000


def places(table: Any, *above: str | int) -> Iterator[tuple[str | int, ...]]:
    """Where in a table of dicts and lists a value stands, from the whole down."""
    keys = table if isinstance(table, dict) else range(min(len(table), 2)) if isinstance(table, list) else ()
    for key in keys:
        yield (*above, key)
        yield from places(table[key], *above, key)


def test_wrong_values_are_errors_of_clrt_wherever_they_stand(tmp_path: Path) -> None:
    every_kind().save(tmp_path / "all.json")
    table = json.loads((tmp_path / "all.json").read_text())
    shapes = {shape["type"]: number for number, shape in enumerate(table["shapes"])}
    table["shapes"] = [table["shapes"][number] for number in shapes.values()]
    found, tried = [], 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", clrt.ClrtWarning)
        for number in range(len(table["shapes"])):
            one = {**table, "shapes": [table["shapes"][number]]}
            for place in places(one if number == 0 else {"shapes": one["shapes"]}):
                for value in EVERYTHING:
                    changed = copy.deepcopy(one)
                    inner: Any = changed
                    for key in place[:-1]:
                        inner = inner[key]
                    inner[place[-1]] = value
                    tried += 1
                    fault = attempt(clrt.load_dict, {"data": changed, "folder": tmp_path})
                    if fault:
                        found.append(f"{place} = {type(value).__name__} {_short(value)}: {fault}")
    assert not found, f"{len(found)} of {tried}:\n" + "\n".join(found[:99])
    assert tried > 5000


def test_right_arguments_of_numpy_are_taken(tracer: clrt.Tracer, image: clrt.Image) -> None:
    three = np.int64(3)
    given = tracer.render(width=np.int32(8), spp=np.uint8(1), max_depth=three, layers={"depth"},
                          crop=np.array([1, 2, 3, 4]))  # fmt: skip
    assert given.pixels.tobytes() == image.pixels[2:6, 1:4].tobytes()
    assert tracer.intersect(ONE, [[0, 0, -1]], np.int64(5)).t.tolist() == [3.0]
    assert clrt.Settings(tile=three, check=np.False_) == clrt.Settings(tile=3)
    assert type(clrt.Limits(depth=three).depth) is int


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda tracer: tracer.render(width=True), "width: True is not allowed; it must be a whole number"),
        (lambda tracer: tracer.render(layers="depth"), r"must be a list of names, such as \['depth'\]"),
        (lambda tracer: tracer.intersect(ONE, ONE, None), "t_max: None is not allowed; it must be numbers"),
        (lambda tracer: tracer.occluded([[1, 2, 3], [4, 5]], ONE), "origins: .* must be numbers in an array"),
        (lambda tracer: clrt.load(None), "path: None is not allowed; it must be a file's name"),
        (lambda tracer: clrt.load("a\0b.toml"), "a file's name cannot hold the character"),
        (lambda tracer: clrt.render(None), "scene: None is not allowed; it must be a clrt.Scene, a dict"),
        (
            lambda tracer: clrt.render({}, settings={}),
            "settings: {} is not allowed; it must be a clrt.Settings",
        ),
    ],
)
def test_the_message_names_the_argument(
    tracer: clrt.Tracer, call: Callable[[clrt.Tracer], Any], words: str
) -> None:
    with pytest.raises(clrt.ClrtError, match=words):
        call(tracer)


def test_a_tracers_scene_and_settings_cannot_be_replaced(tracer: clrt.Tracer, image: clrt.Image) -> None:
    other = clrt.load_dict({**SCENE, "materials": {"red": {"color": [1, 0, 0]}}})
    with pytest.raises(clrt.ClrtError, match=r"tracer.scene: .* for another scene call tracer.update"):
        tracer.scene = other
    with pytest.raises(clrt.ClrtError, match=r"tracer.settings: .* Tracer\(scene, settings=...\)"):
        tracer.settings = clrt.Settings(check=True)
    assert tracer.render().hash == image.hash


def test_a_scene_may_be_a_name_a_file_or_a_dict(
    image: clrt.Image, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert clrt.render(SCENE).hash == image.hash
    clrt.load_dict(SCENE).save(tmp_path / "own.toml")
    assert (
        clrt.render(tmp_path / "own.toml").hash == clrt.render(str(tmp_path / "own.toml")).hash == image.hash
    )
    monkeypatch.chdir(tmp_path)  # no checkout
    for name in ("bubble", "scenes/bubble.toml", Path("scenes/bubble.toml"), "tetrahedron"):
        clrt.load(name)
    assert clrt.render("bubble", width=8).hash == clrt.Tracer(clrt.load("scenes/bubble.toml")).render(8).hash
    (tmp_path / "bubble").mkdir()  # a folder is no scene
    assert clrt.load("bubble") == clrt.load("scenes/bubble.toml")
    for wrong, words in (("bubbel", "did you mean 'bubble'"), ("scenes/no.toml", "there is no such file")):
        with pytest.raises(clrt.SceneError, match=words):
            clrt.render(wrong)
    with pytest.raises(clrt.SceneError, match="no option 'smooth' for scenes that are generated"):
        clrt.load("tetrahedron", smooth=True)


def test_a_shape_whose_material_is_asked_for_is_one_of_the_scene() -> None:
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
    scene = clrt.load_dict({"materials": {"red": {}}, "shapes": [{**ball, "material": "red"}]})
    with pytest.raises(clrt.ClrtError, match=r"shape: .red. is not allowed; it must be one of scene\.shapes"):
        scene.material_of("red")  # type: ignore[arg-type]
    with pytest.raises(clrt.ClrtError, match=r"shape\.material: .red. is not allowed; it is no"):
        clrt.Scene().material_of(scene.shapes[0])


def test_memory_that_runs_out_is_one_line(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def none(*arguments: object, **named: object) -> None:
        raise MemoryError

    for place in ("clrt.engine.tracer.flatten", "clrt.formats.read_scene", "clrt.images.file.read_samples"):
        monkeypatch.setattr(place, none)
    calls: list[Callable[[], object]] = [
        lambda: clrt.render(clrt.Scene()), lambda: clrt.load_dict({}), lambda: clrt.read_image("x.png"),
        lambda: clrt.load("bubble"),
    ]  # fmt: skip
    monkeypatch.setattr("clrt.formats.native.read_scene", none)
    for call in calls:
        with pytest.raises(clrt.LimitError, match="no memory left"):
            call()


@pytest.mark.skipif(sys.platform != "linux", reason="others promise memory that there is not")
def test_a_view_of_one_number_as_more_than_memory_holds() -> None:
    endless = np.broadcast_to(np.float32(0.5), (10**6, 10**6, 3))
    calls: list[Callable[[], object]] = [
        lambda: clrt.Image(endless), lambda: clrt.compare(endless, endless),
    ]  # fmt: skip
    for call in calls:
        with pytest.raises(clrt.LimitError, match="no memory left"):
            call()


def test_such_views_where_a_few_numbers_are_wanted() -> None:
    scene, endless = clrt.load_dict(SCENE), np.broadcast_to(0.5, (10**6, 10**6))
    for name in ("pose", "K"):
        with pytest.raises(clrt.ClrtError, match=r"camera: .* too many entries"):
            clrt.render(scene, camera=clrt.Camera(**{name: endless}))
    with pytest.raises(clrt.ClrtError, match=r"shapes\[0\].* too many entries"):
        clrt.render({**SCENE, "shapes": [{"type": "polygon", "points": endless}]})
    for values in (np.broadcast_to(0.5, (10**12,)), np.array(3)):
        with pytest.raises(clrt.ClrtError, match=r"changes\['ambient'\]: .* a list of values"):
            clrt.sweep(scene, {"ambient": values})



def test_a_thread_that_cannot_be_started_is_want_of_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*arguments: object, **named: object) -> None:
        raise RuntimeError(words)

    monkeypatch.setattr("clrt.engine.tracer.flatten", none)
    words = "can't start new thread"
    with pytest.raises(clrt.LimitError, match="no more processes or threads can be started") as caught:
        clrt.render(clrt.Scene())
    assert isinstance(caught.value.__cause__, RuntimeError)
    words = "a fault of clrt's own"
    with pytest.raises(RuntimeError, match=words):
        clrt.render(clrt.Scene())


@pytest.mark.parametrize(
    "error", [OSError(errno.EAGAIN, "full"), RuntimeError("can't start new thread"), MemoryError("mine")]
)
def test_what_progress_raises_is_the_callers(error: Exception) -> None:
    def progress(*_: int) -> None:
        raise error

    for use in (clrt.render, lambda *given, **named: [*clrt.sweep(given[0], {"ambient": [0.1]}, **named)]):
        with pytest.raises(type(error)) as caught:
            use("bubble", width=8, progress=progress)
        assert caught.value is error
    with ThreadPoolExecutor(1) as executor, pytest.raises(type(error)) as caught:
        clrt.render("bubble", width=8, progress=progress, executor=executor)
    assert caught.value is error


class Full(ThreadPoolExecutor):
    def submit(self, *_: object, **named: object) -> Any:
        raise self.error  # type: ignore[attr-defined]


def test_what_an_executor_raises_is_told() -> None:
    with Full(1) as executor:
        executor.error = OSError(errno.EAGAIN, "full")
        with pytest.raises(OSError) as raised:
            clrt.render("bubble", width=8, executor=executor)
        assert raised.value is executor.error
        for text, kind in ("can't start new thread", clrt.LimitError), ("shut down", clrt.ClrtError):
            executor.error = RuntimeError(text)
            with pytest.raises(kind) as caught:
                clrt.render("bubble", width=8, executor=executor)
            assert type(caught.value) is kind
            assert caught.value.__cause__ is executor.error


def _short(value: object) -> str:
    try:
        return repr(value)[:40]
    except ValueError:
        return "(cannot be shown)"
