"""Reading takes time and memory in proportion to the file, whatever the file says."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import clrt
from clrt.base.resources import shipped_scenes
from clrt.base.suggest import nearest
from clrt.flatten.flatten import flatten
from clrt.flatten.inside import count_inside
from clrt.flatten.lightsurfaces import add_surfaces
from clrt.flatten.materials import flatten_lights
from clrt.formats import load_dict
from clrt.scene.arealights import SphereLight
from clrt.scene.mesh import Mesh
from tests.cost import bounded
from tests.growth import check_growth, loading, names


def toml_spheres(n: int) -> str:
    return "".join(f'[[shapes]]\ntype = "sphere"\ncenter = [{i}, 0.5, 1.5]\nradius = 0.5\n' for i in range(n))


def toml_materials(n: int) -> str:
    return "".join(f"[materials.{name}]\ncolor = [0.1, 0.2, 0.3]\n" for name in names(n))


def json_shapes(n: int, **shape: object) -> str:
    return json.dumps({"shapes": [shape] * n})


def json_mesh(n: int) -> str:
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    faces = [[4 * i + k for k in range(4)] for i in range(n)]
    mesh = {"type": "mesh", "vertices": corners * n, "faces": faces}
    return json.dumps({"shapes": [mesh]})


def json_faces(n: int) -> str:
    faces = ",".join(["[0,1,2,3]"] * n)
    return f'{{"shapes":[{{"type":"mesh","vertices":[[0,0,0],[1,0,0],[1,1,0],[0,1,0]],"faces":[{faces}]}}]}}'


def json_twice(n: int) -> str:
    return "{" + "".join(f'"{name}":1,' for name in names(n)) + '"zzzz":1,"zzzz":1}'


def nff_fills(n: int) -> str:
    return "".join(f"f .1 .2 .3 1 0 0 0 {1 + i / n}\ns 0 0 0 1\n" for i in range(n))


def toml_within(n: int) -> str:
    return f"a = {{{','.join(f'{name}.b=1' for name in names(n))}}}"


SPHERE = {"type": "sphere", "center": [0.5, 1, 2], "radius": 1}
FILES: dict[str, tuple[str, Callable[[int], str], int]] = {
    "toml spheres": ("a.toml", toml_spheres, 4000),
    "toml materials": ("a.toml", toml_materials, 4000),
    "toml numbers": ("a.toml", lambda n: f"background = [{'1,' * n}]", 25000),
    "toml dotted key": ("a.toml", lambda n: "a." * n + "b = 1", 150_000),
    "toml dotted keys": ("a.toml", lambda n: "".join(f"{name}.b = 1\n" for name in names(n)), 20000),
    "toml dotted keys within": ("a.toml", toml_within, 20000),
    "toml headers": ("a.toml", lambda n: "".join(f"[{name}]\n" for name in names(n)), 15000),
    "toml brackets": ("a.toml", lambda n: "a = " + "[" * n, 500_000),
    "toml quotes": ("a.toml", lambda n: 'a = """' + '\\"""' * n, 100_000),
    "json spheres": ("a.json", lambda n: json_shapes(n, **SPHERE), 6000),
    "json transforms": ("a.json", lambda n: json_shapes(n, **SPHERE, transform=[{"scale": 2}]), 1500),
    "json steps": ("a.json", lambda n: json_shapes(1, **SPHERE, transform=[{"scale": 1}] * n), 5000),
    "json own materials": ("a.json", lambda n: json_shapes(n, **SPHERE, material={}), 4000),
    "json materials": ("a.json", lambda n: json.dumps({"materials": {k: {} for k in names(n)}}), 8000),
    "json curves": ("a.json", lambda n: json.dumps({"ambient": [[400 + i / n, 1] for i in range(n)]}), 20000),
    "json mesh": ("a.json", json_mesh, 4000),
    "json key twice": ("a.json", json_twice, 40000),
    "json unknown material": (
        "a.json",
        lambda n: json.dumps(
            {"materials": {k: {} for k in names(n)}, "shapes": [{**SPHERE, "material": "aabbcc"}]}
        ),
        8000,
    ),
    "json unknown key": ("a.json", lambda n: json.dumps({"x" * n: 1}), 4_000_000),
    "json brackets": ("a.json", lambda n: '{"a": ' + "[" * n, 4_000_000),
    "nff spheres": ("a.nff", lambda n: "s 0 0 0 1\n" * n, 6000),
    "nff fills": ("a.nff", nff_fills, 3000),
    "nff polygons": ("a.nff", lambda n: "p 4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n" * n, 3000),
    "nff long line": ("a.nff", lambda n: "s 0 0 0 1 " * n, 6000),
    "thesis surfaces": (
        "a.txt",
        lambda n: "".join(
            f"Sphere Point {i} 0 0 Radius 1\nSurface Spectrum 400 700 Constants .1 .2 .3 {1 + i / n} 0\n"
            for i in range(n)
        ),
        1000,
    ),
    "thesis words": ("a.txt", lambda n: "word\n" * n, 60000),
    "obj": ("a.obj", lambda n: "".join(f"v {i} 0 0\nv {i} 1 0\nv {i} 0 1\n" for i in range(n))
            + "".join(f"f {3 * i + 1} {3 * i + 2} {3 * i + 3}\n" for i in range(n)), 4000),
    "stl": ("a.stl", lambda n: "solid a\n" + "".join(
        f"facet normal 0 0 1\nouter loop\nvertex {i} 0 0\nvertex {i} 1 0\nvertex 0 {i} 1\nendloop\nendfacet\n"
        for i in range(n)) + "endsolid a\n", 6000),
    "ply": ("a.ply", lambda n: "ply\nformat ascii 1.0\n" + f"element vertex {3 * n}\n"
            + "property float x\nproperty float y\nproperty float z\n" + f"element face {n}\n"
            + "property list uchar int vertex_indices\nend_header\n"
            + "".join(f"{i} 0 0\n{i} 1 0\n{i} 0 1\n" for i in range(n))
            + "".join(f"3 {3 * i} {3 * i + 1} {3 * i + 2}\n" for i in range(n)), 4000),
}  # fmt: skip


@pytest.mark.parametrize("case", FILES)
def test_files(case: str, tmp_path: Path) -> None:
    name, text, n = FILES[case]

    def make(size: int) -> Callable[[], object]:
        folder = tmp_path / str(size)
        folder.mkdir()
        (folder / name).write_text(text(size))
        return loading(folder / name)

    check_growth(make, n)


def glass(n: int, nested: bool, kinds: int) -> clrt.Scene:
    materials = {f"g{k}": {"transmission": 1, "ior": 1.1 + k / 10, "absorption": 0.1} for k in range(kinds)}
    shapes = []
    for i in range(n):
        center = [0, 0, 0] if nested else [3 * (i % 20), 3 * (i // 20), 0]
        radius = 1 + i / n if nested else 1
        shapes.append({"type": "sphere", "center": center, "radius": radius, "material": f"g{i % kinds}"})
    return load_dict({"materials": materials, "shapes": shapes})


@pytest.mark.parametrize(("nested", "kinds"), [(False, 2), (True, 2), (True, 1)])
@pytest.mark.filterwarnings("ignore")
def test_media_and_their_overlaps(nested: bool, kinds: int) -> None:
    check_growth(lambda n: partial(flatten, glass(n, nested, kinds)), 4000)


@pytest.mark.filterwarnings("ignore")
def test_rays_into_more_media_than_fit() -> None:
    """The first ninth is enough to refuse the picture: a ray need not find all others."""
    camera = clrt.scene.scene.Camera(origin=(0, 0, 9), target=(0, 0, 0), width=8, height=8)

    def make(n: int) -> Callable[[], object]:
        scene = clrt.Scene(
            materials={"glass": {"transmission": 1, "absorption": 0.1}},
            shapes=[
                {"type": "sphere", "center": (0, 0, 0), "radius": 1 + i / n, "material": "glass"}
                for i in range(n)
            ],
            camera=camera,
        )

        def render() -> None:
            with pytest.raises(clrt.LimitError, match="more than 8 media"):
                clrt.render(scene)

        return render

    check_growth(make, 3000)


@pytest.mark.filterwarnings("ignore")
def test_the_media_that_rays_start_in() -> None:
    def make(n: int) -> Callable[[], object]:
        media = flatten(glass(n, False, 2)).media
        assert media is not None
        points = np.random.default_rng(1).uniform(0, (60, 3 * n / 20, 1), (n, 3))
        return lambda: media.lists(points)

    check_growth(make, 2000)


def test_what_a_mesh_encloses() -> None:
    """Points times faces: either may grow."""

    def mesh(faces: int) -> Mesh:
        points = np.random.default_rng(1).normal(size=(3 * faces, 3))
        scene = load_dict(
            {"shapes": [{"type": "mesh", "vertices": points, "faces": np.arange(3 * faces).reshape(-1, 3)}]}
        )
        shape = scene.shapes[0]
        assert isinstance(shape, Mesh)
        return shape

    points = np.random.default_rng(2).normal(size=(800, 3))
    check_growth(lambda n: partial(count_inside, mesh(n), points[:100]), 2000)
    check_growth(lambda n: partial(count_inside, mesh(2000), points[:n]), 100)


def test_lights_that_are_seen() -> None:
    """Their surfaces follow all primitives; each alone would copy those before it."""
    lamp = SphereLight(center=(0.0, 0.0, 0.0), radius=1.0)

    def make(n: int) -> Callable[[], object]:
        scene = clrt.Scene(lights=(lamp,) * n)
        sections = vars(flatten(clrt.Scene())) | {"lights": flatten_lights(scene, None)}
        return lambda: add_surfaces(scene, dict(sections), dict.fromkeys(range(n), 0))

    check_growth(make, 2000)


def test_suggestions() -> None:
    many = [f"material_{i}" for i in range(80_000)]
    check_growth(lambda n: lambda: nearest("materail_199", many[:n]), 20_000)
    long = ["m" * 1_000_000 + str(i) for i in range(20)]
    check_growth(lambda n: lambda: [nearest("m" * n, long) for _ in range(20)], 250_000)


def test_the_nearest_of_many_is_found() -> None:
    many = [f"material_{i}" for i in range(20_000)]
    assert nearest("materail_12345", many) == "material_12345"
    assert nearest("Material_777", many) == "material_777"
    assert nearest("sphre", ["plane", "sphere"]) == "sphere"
    assert nearest("xyz", ["plane"], cutoff=0.6) is None and nearest("x", []) is None


def mitsuba_shapes(kind: str, n: int, within: str = "", before: str = "") -> str:
    shape = f'<shape type="{kind}">{within}</shape>'
    return f'<scene version="3.0.0">{before}{shape * (n // len(shape))}</scene>'


def mitsuba_sizes(kind: str, n: int, before: str) -> str:
    """Shapes of as many sizes that refer to the BSDF `s` before them."""
    size = '<transform name="to_world"><scale value="{:.5f}"/></transform>'
    shape = f'<shape type="{kind}">{size}{SHOWN}</shape>'
    shapes = (shape.format(1 + k / n) for k in range(n // len(shape)))
    return f'<scene version="3.0.0">{before}{"".join(shapes)}</scene>'


SHOWN = '<ref id="s"/>'
SQUARES = '<bsdf type="diffuse" id="s"><texture type="checkerboard" name="reflectance"/></bsdf>'
PICTURE = '<texture type="bitmap" name="{}"><string name="filename" value="a.png"/></texture>'
PICTURED = f'<bsdf type="diffuse" id="s">{PICTURE.format("reflectance")}</bsdf>'
BENT = f'<bsdf type="normalmap" id="s">{PICTURE.format("normalmap")}<bsdf type="diffuse"/></bsdf>'


HOSTILE: dict[str, tuple[str, Callable[[int], str]]] = {
    "toml lists": ("a.toml", lambda n: f"a=[{'[],' * (n // 3)}]"),
    "toml headers": ("a.toml", lambda n: "".join(f"[{name}]\n" for name in names(n // 7))),
    "toml dotted keys": ("a.toml", lambda n: "a." * (n // 2) + "b=1"),
    "json lists": ("a.json", lambda n: '{"a":[' + ",".join(["[]"] * (n // 3)) + "]}"),
    "json materials": ("a.json", lambda n: json.dumps({"materials": {k: {} for k in names(n // 11)}})),
    "json faces": ("a.json", lambda n: json_faces(n // 10)),
    "mitsuba spheres": ("a.xml", lambda n: mitsuba_shapes("sphere", n)),
    "mitsuba disks": ("a.xml", lambda n: mitsuba_shapes("disk", n)),
    "mitsuba rectangles": ("a.xml", lambda n: mitsuba_shapes("rectangle", n)),
    **{f"mitsuba {what} on a {kind}": ("a.xml", partial(mitsuba_shapes, kind, within=SHOWN, before=bsdf))
       for kind in ("rectangle", "sphere", "disk")
       for what, bsdf in (("squares", SQUARES), ("pictures", PICTURED), ("normal maps", BENT))},
    **{f"mitsuba {what} on a {kind} of each size": ("a.xml", partial(mitsuba_sizes, kind, before=bsdf))
       for kind, what, bsdf in (("rectangle", "squares", SQUARES), ("sphere", "squares", SQUARES),
                                ("rectangle", "pictures", PICTURED))},
    "nff spheres": ("a.nff", lambda n: "s 0 0 0 1\n" * (n // 10)),
    "nff spheres seen from within": ("a.nff", lambda n: "s 0 0 0 -1\n" * (n // 11)),
    "nff cones seen from within": ("a.nff", lambda n: "c 0 0 0 0\n0 1 0 -2\n" * (n // 19)),
    "nff cylinders seen from within": ("a.nff", lambda n: "c 0 0 0 -1\n0 1 0 0\n" * (n // 19)),
    "mitsuba lights": ("a.xml", lambda n: mitsuba_shapes("rectangle", n, '<emitter type="area"/>')),
    "thesis spheres": ("a.txt", lambda n: "Sphere\nPoint 0 0 0\nRadius 1\nSurface None\n" * (n // 43)),
}  # fmt: skip


@pytest.mark.parametrize("case", HOSTILE)
def test_a_file_costs_no_more_than_its_size_allows(case: str, tmp_path: Path) -> None:
    """At most 100 MiB + 60 bytes for each byte of the file, and 1 s + 1 s for each million bytes."""
    name, text = HOSTILE[case]
    file = tmp_path / name
    shutil.copy(shipped_scenes()["cabinet"].parent / "tile-normals.png", tmp_path / "a.png")
    file.write_text(text(1_500_000))
    bounded("read", file)


def test_lights_that_are_too_many_are_not_built(tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_text(mitsuba_shapes("rectangle", 800_000, '<emitter type="area"/>'))
    assert "lights: 237 0" in bounded("load", tmp_path / "a.xml").error


def spectrum(name: str) -> str:
    pairs = " ".join(f"{100 + 2 * i}:1" for i in range(4000))
    return f'<spectrum name="{name}" value="{pairs}"/>'


DIFFUSE = f'<bsdf type="diffuse" id="d">{spectrum("reflectance")}</bsdf>'
CHECKER = f'<texture type="checkerboard" id="t">{spectrum("color0")}</texture>'
TEXTURED = '<bsdf type="diffuse" {}><ref name="reflectance" id="t"/></bsdf>'
DEFAULT = '<default name="a" value=""/>'
REF = '<ref id="{}"/>'
BALL = '<shape type="sphere"><ref id="{}"/></shape>'
CHAIN = "".join(f'<integrator type="aov" id="i{k}"><ref id="i{k + 1}"/></integrator>' for k in range(300))
REFERRED: dict[str, tuple[str, str, bool]] = {
    "emitters": (
        f'<shape type="sphere"><emitter type="area" id="e">{spectrum("radiance")}</emitter></shape>',
        BALL.format("e"), True,
    ),
    "emitters of many parts": (
        '<shape type="sphere"><emitter type="area" id="e">' + DEFAULT * 4000 + "</emitter></shape>",
        BALL.format("e"), False,
    ),
    "bsdfs": (DIFFUSE, BALL.format("d"), False),
    "bsdfs on two sides": (DIFFUSE, f'<bsdf type="twosided"><ref id="d"/></bsdf>{BALL.format("d")}', True),
    "blends": (DIFFUSE, '<bsdf type="blendbsdf"><ref id="d"/><ref id="d"/></bsdf>', True),
    "textures": (CHECKER, TEXTURED.format(""), True),
    "textures on shapes": (CHECKER + TEXTURED.format('id="d"'), BALL.format("d"), False),
    "integrators": (
        f'{CHAIN}<integrator type="path" id="i300"/>',
        '<integrator type="aov"><ref id="i0"/></integrator>', False,
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", REFERRED)
def test_what_many_refer_to_is_read_once(case: str, tmp_path: Path) -> None:
    """And is refused where a scene has its own of it at each place, and these take too much together."""
    once, again, refused = REFERRED[case]
    (tmp_path / "a.xml").write_text(f'<scene version="3.0.0">{once}{again * 4000}</scene>')
    error = bounded("read", tmp_path / "a.xml").error
    assert ("have more than 262 144 points" in error) == bool(error) == refused, error
    loading(tmp_path / "a.xml")()


def test_a_film_is_one_however_often_it_is_referred_to(tmp_path: Path) -> None:
    film = f'<film type="hdrfilm" id="f">{REF.format("r") * 4000}</film><rfilter type="tent" id="r"/>'
    sensor = f'<sensor type="perspective">{REF.format("f") * 4000}</sensor><shape type="sphere"/>'
    (tmp_path / "a.xml").write_text(f'<scene version="3.0.0">{film}{sensor}</scene>')
    assert bounded("read", tmp_path / "a.xml").error == ""
    camera = clrt.load(tmp_path / "a.xml").camera
    assert camera is not None and camera.filter == "tent"


def test_parameters_that_are_filled_in(tmp_path: Path) -> None:
    """Each place may hold 4096 letters, where its name takes two."""
    parameter = f'<default name="a" value="{"b" * 4090}"/>'
    (tmp_path / "a.xml").write_text(f'<scene version="3.0.0">{parameter}{REF.format("x$a") * 40_000}</scene>')
    assert "add more than 16 777 216 letters; write less" in bounded("read", tmp_path / "a.xml").error
    loading(tmp_path / "a.xml")()
