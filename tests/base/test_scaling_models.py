"""Reading models, Mitsuba's XML, keyframes and checkpoints takes time in proportion to the file."""

from __future__ import annotations

import base64
import json
from collections import Counter
from collections.abc import Callable
from functools import partial
from itertools import cycle, islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.engine.checkpoint import Checkpoint
from clrt.engine.picture import Picture
from clrt.engine.wavefront import RayCounts
from clrt.formats.keyframes import load_keyframes
from tests.growth import check_growth, loading, names
from tests.model_samples import PICTURE, shining, write_glb

PLACES = {"componentType": 5126, "type": "VEC3"}
LIGHTS = "KHR_lights_punctual"


def corners(n: int) -> np.ndarray:
    """(3 n, 3) of n triangles that nobody joins."""
    return np.random.default_rng(1).normal(size=(3 * n, 3)).astype("<f4")


def whole(n: int) -> tuple[dict[str, Any], bytes]:
    """A mesh of n triangles, by index."""
    data = corners(n).tobytes() + np.arange(3 * n, dtype="<u4").tobytes()
    views = [{"buffer": 0, "byteLength": 36 * n}, {"buffer": 0, "byteOffset": 36 * n, "byteLength": 12 * n}]
    table = document(
        bufferViews=views,
        buffers=[{"byteLength": 48 * n}],
        accessors=[
            {"bufferView": 0, "count": 3 * n, **PLACES},
            {"bufferView": 1, "count": 3 * n, "componentType": 5125, "type": "SCALAR"},
        ],
        meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    )
    return table, data


def document(**more: Any) -> dict[str, Any]:
    """A triangle in a node."""
    return {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "count": 3, **PLACES}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    } | more


def nodes(n: int) -> dict[str, Any]:
    return document(
        nodes=[{"mesh": 0, "name": name, "translation": [1, 2, 3]} for name in names(n)],
        scenes=[{"nodes": list(range(n))}],
    )


def chain(n: int) -> dict[str, Any]:
    return document(nodes=[*({"children": [i + 1]} for i in range(n)), {"mesh": 0}])


def parts(n: int) -> dict[str, Any]:
    primitive = {"attributes": {"POSITION": 0}}
    return document(meshes=[{"primitives": [{**primitive, "material": i} for i in range(n)]}],
                    materials=[{"name": name} for name in names(n)])  # fmt: skip


def meshes(n: int) -> dict[str, Any]:
    return document(
        buffers=[{"byteLength": 36 * n}],
        bufferViews=[{"buffer": 0, "byteOffset": 36 * i, "byteLength": 36} for i in range(n)],
        accessors=[{"bufferView": i, "count": 3, **PLACES} for i in range(n)],
        meshes=[{"primitives": [{"attributes": {"POSITION": i}}]} for i in range(n)],
        nodes=[{"mesh": i} for i in range(n)],
        scenes=[{"nodes": list(range(n))}],
    )


def lamps(n: int) -> dict[str, Any]:
    return document(
        nodes=[{"mesh": 0}, *(shining(i, name="lamp") for i in range(n))],
        scenes=[{"nodes": list(range(n + 1))}],
        extensions={LIGHTS: {"lights": [{"type": "point"}] * n}},
    )


def textures(n: int) -> dict[str, Any]:
    url = "data:image/png;base64," + base64.b64encode(PICTURE).decode()
    shown = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": i}}} for i in range(n)]
    primitive = {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}}
    return document(
        buffers=[{"byteLength": 60}],
        bufferViews=[{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 24}],
        accessors=[
            {"bufferView": 0, "count": 3, **PLACES},
            {"bufferView": 1, "count": 3, "componentType": 5126, "type": "VEC2"},
        ],
        meshes=[{"primitives": [{**primitive, "material": i} for i in range(n)]}],
        materials=shown,
        textures=[{"source": i} for i in range(n)],
        images=[{"uri": url} for _ in range(n)],
    )


def glb(make: Callable[[int], dict[str, Any] | tuple[dict[str, Any], bytes]], folder: Path, n: int) -> Path:
    made = make(n)
    table, data = made if isinstance(made, tuple) else (made, corners(n).tobytes()[: 36 * n] + bytes(60))
    table["buffers"][0]["byteLength"] = len(data)
    return write_glb(folder / "a.glb", table, data)


def gltf(folder: Path, n: int) -> Path:
    """The numbers within the text, as base64."""
    table, data = whole(n)
    table["buffers"] = [{"byteLength": len(data), "uri": "data:;base64," + base64.b64encode(data).decode()}]
    (folder / "a.gltf").write_text(json.dumps(table))
    return folder / "a.gltf"


def obj(folder: Path, n: int, used: int) -> Path:
    """n materials, and as many faces, each of the next of the first `used`."""
    (folder / "a.mtl").write_text("".join(f"newmtl {name}\nKd .1 .2 .3\nNs 9\n" for name in names(n)))
    faces = "".join(f"usemtl {name}\nf 1 2 3\n" for name in islice(cycle(names(used)), n))
    (folder / "a.obj").write_text(f"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}")
    return folder / "a.obj"


def ply(folder: Path, n: int) -> Path:
    rows = np.zeros(n, [("count", "u1"), ("corners", "<i4", 3)])
    rows["count"], rows["corners"] = 3, np.arange(3 * n).reshape(-1, 3)
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {3 * n}\n"
    head += "property float x\nproperty float y\nproperty float z\n"
    head += f"element face {n}\nproperty list uchar int vertex_indices\nend_header\n"
    (folder / "a.ply").write_bytes(head.encode() + corners(n).tobytes() + rows.tobytes())
    return folder / "a.ply"


def stl(folder: Path, n: int) -> Path:
    rows = np.zeros(n, [("normal", "<f4", 3), ("corners", "<f4", 9), ("more", "<u2")])
    rows["corners"] = corners(n).reshape(n, 9)
    (folder / "a.stl").write_bytes(bytes(80) + np.uint32(n).tobytes() + rows.tobytes())
    return folder / "a.stl"


XML: dict[str, tuple[Callable[[str], str], int]] = {
    "shapes": (lambda name: '<shape type="sphere"><float name="radius" value="2"/></shape>', 1000),
    "bsdfs": (lambda name: '<shape type="sphere"><bsdf type="diffuse"/></shape>', 1000),
    "ids": (
        lambda name: f'<bsdf type="diffuse" id="{name}"/><shape type="sphere"><ref id="{name}"/></shape>',
        500,
    ),
    "ids of nobody": (lambda name: f'<shape type="sphere"><ref id="{name}"/></shape>', 1000),
    "ids twice": (lambda name: '<bsdf type="diffuse" id="a"/>', 4000),
    "values": (lambda name: f'<default name="{name}" value="1"/>', 4000),
    "lights": (
        lambda name: '<emitter type="point"><point name="position" x="1" y="2" z="3"/></emitter>',
        1000,
    ),
}  # fmt: skip


def xml(part: Callable[[str], str], folder: Path, n: int) -> Path:
    (folder / "a.xml").write_text(f'<scene version="3.0.0">{"".join(map(part, names(n)))}</scene>')
    return folder / "a.xml"


def within(tag: str, folder: Path, n: int) -> Path:
    """n steps of one transform, n values of one shape, or n tables, one in the other."""
    inner = {
        "steps": lambda: '<transform name="to_world">' + '<scale value="1"/>' * n + "</transform>",
        "names": lambda: "".join(f'<float name="{name}" value="1"/>' for name in names(n)),
        "nested": lambda: '<bsdf type="twosided">' * n + "</bsdf>" * n,
    }[tag]()
    (folder / "a.xml").write_text(f'<scene version="3.0.0"><shape type="sphere">{inner}</shape></scene>')
    return folder / "a.xml"


MODELS: dict[str, tuple[Callable[[Path, int], Path], int]] = {
    "glb": (partial(glb, whole), 40_000),
    "glb nodes": (partial(glb, nodes), 1500),
    "glb nodes in nodes": (partial(glb, chain), 4000),
    "glb parts": (partial(glb, parts), 500),
    "glb meshes": (partial(glb, meshes), 500),
    "glb lights": (partial(glb, lamps), 1500),
    "glb textures": (partial(glb, textures), 200),
    "gltf": (gltf, 20_000),
    "mtl": (partial(obj, used=1), 2000),
    "mtl of many parts": (partial(obj, used=200), 2000),
    "ply": (ply, 40_000),
    "stl": (stl, 40_000),
    **{f"xml {name}": (partial(xml, part), n) for name, (part, n) in XML.items()},
    "xml steps": (partial(within, "steps"), 2000),
    "xml names": (partial(within, "names"), 4000),
    "xml nested": (partial(within, "nested"), 100_000),
}


@pytest.mark.parametrize("case", MODELS)
def test_models(case: str, tmp_path: Path) -> None:
    write, n = MODELS[case]

    def make(size: int) -> Callable[[], None]:
        folder = tmp_path / str(size)
        folder.mkdir()
        return loading(write(folder, size))

    check_growth(make, n)


@pytest.mark.parametrize("suffix", ["toml", "json"])
def test_keyframes(suffix: str, tmp_path: Path) -> None:
    base = clrt.Camera(origin=(0, 1, 5), target=(0, 0, 0))

    def text(n: int) -> str:
        if suffix == "json":
            return json.dumps({"keyframes": [{"time": i, "origin": [i, 1, 4]} for i in range(n)]})
        return "".join(f"[[keyframes]]\ntime = {i}\norigin = [{i}, 1, 4]\n" for i in range(n))

    def make(n: int) -> Callable[[], None]:
        path = tmp_path / f"{n}.{suffix}"
        path.write_text(text(n))
        return loading(path, lambda file: load_keyframes(file, base, clrt.Limits()))

    check_growth(make, 1000)


def test_checkpoints(tmp_path: Path) -> None:
    """Of n pixels, every second one finished, in as many runs."""

    def opened(path: Path, n: int) -> Checkpoint:
        task = {"size": f"{n} x 1", "spp": "1", "refinements": "0", "max_depth": "5"}
        ranges = {"image": (0.0, 1e30), "depth": (0.0, np.inf)}
        return Checkpoint(path, task, Picture((0, 0, n, 1), n, ("depth",), 3), RayCounts(), ranges)

    def make(n: int) -> Callable[[], object]:
        saved = opened(tmp_path / f"{n}.ck", n)
        saved.add(np.arange(0, n, 2), RayCounts([Counter({"camera": n // 2})]))
        saved.save()

        def work() -> None:
            again = opened(tmp_path / f"{n}.ck", n)
            assert sum(map(len, again.unfinished([np.arange(n)]))) == n // 2

        return work

    check_growth(make, 100_000)
