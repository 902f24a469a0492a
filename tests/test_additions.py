"""A light, a term and a layer are added as `docs/adding-a-....md` say, to copies of the tree.

Each is what a formula in float64 says in every pixel, and what each entry is for is seen without it.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from clrt.scene.schema import schema_text
from tests import facing_layer, fuzz_term, patch_light, torus
from tests.additions import camera_rays, changed, grown, render, run

DOCS = Path(__file__).resolve().parents[1] / "docs"
EYE = np.array([0.5, 1.2, 4.0])
CAMERA = {"origin": EYE.tolist(), "target": [0.0, 0.0, 0.0], "fov": 40, "width": 45, "height": 36}
CENTER, RADIUS, FLOOR = np.array([0.2, 0.3, -0.1]), 0.9, -0.8
LAMP, AXIS = np.array([0.9, 1.5, 1.2]), np.array([-1.0, -0.5, 0.0])
INTENSITY, COLOR, DIFFUSE = 6.0, 0.5, 0.8
TOLERANCE = 1e-5  # three times what float32 was seen to be off, relative to the brightest pixel


@pytest.fixture(scope="module")
def copies(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Gives the copy of the product with a thing, made once."""
    made: dict[str, Path] = {}

    def copy(thing: ModuleType) -> Path:
        name = thing.__name__.split(".")[-1]
        if name not in made:
            made[name] = grown(tmp_path_factory.mktemp(name), name, thing.ENTRIES)
        return made[name]

    return copy


def scene(lamp: Mapping[str, Any], **material: float) -> dict[str, Any]:
    """A ball on a floor."""
    of = {"color": COLOR, "diffuse": DIFFUSE, **material}
    return {
        "camera": CAMERA,
        "lights": [{"position": LAMP.tolist(), "intensity": INTENSITY, **lamp}],
        "shapes": [
            {"type": "sphere", "center": CENTER.tolist(), "radius": RADIUS, "material": of},
            {"type": "plane", "point": [0, FLOOR, 0], "normal": [0, 1, 0], "material": of},
        ],
    }


def hits(o: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distances to the first hit, inf without one, and outward normals there, of rays (..., 3) in float64."""
    p = o - CENTER
    b, c = (p * d).sum(-1), (p * p).sum(-1) - RADIUS**2
    with np.errstate(all="ignore"):
        ball = -b - np.sqrt(b * b - c)
        floor = (FLOOR - o[..., 1]) / d[..., 1]
    ball, floor = (np.where(t > 1e-9, t, np.inf) for t in (ball, floor))  # NaN is no hit
    on_ball = ball < floor
    t = np.where(on_ball, ball, floor)
    with np.errstate(all="ignore"):
        round_normal = (p + ball[..., None] * d) / RADIUS
    return t, np.where(on_ball[..., None], round_normal, [0.0, 1.0, 0.0])


def seen() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Of each pixel: the ray's direction, whether it hits, where, and the normal."""
    d = camera_rays(CAMERA, CAMERA["fov"])
    t, n = hits(EYE, d)
    hit = np.isfinite(t)
    return d, hit, EYE + np.where(hit, t, 0.0)[..., None] * d, n


def towards_lamp() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Of each pixel: unit way to the lamp, its distance, cosine at the surface, and whether it is seen."""
    _, hit, p, n = seen()
    way = LAMP - p
    far = np.linalg.norm(way, axis=-1)
    way /= far[..., None]
    cosine = (way * n).sum(-1)
    return way, far, cosine, hit & (cosine > 0) & (hits(p + 1e-7 * n, way)[0] > far)


def wrong(found: np.ndarray, right: np.ndarray) -> int:
    assert len(np.unique(right.round(3))) > 100, "the picture must show something"
    off = np.abs(found - right.reshape(*right.shape, *[1] * (found.ndim - right.ndim)))
    return int((off > TOLERANCE * right.max()).reshape(*right.shape, -1).any(axis=-1).sum())


PATCH = scene({"type": "patch", "normal": AXIS.tolist()})


def right_patch() -> tuple[np.ndarray, int]:
    """The picture, and the number of feelers: where the lamp is above the surface and bright."""
    way, far, cosine, lit = towards_lamp()
    shine = -(way @ AXIS) / np.linalg.norm(AXIS)
    value = INTENSITY * np.maximum(shine, 0) / far**2 * DIFFUSE * COLOR * cosine
    above, bright = seen()[1] & (cosine > 0), shine > 0
    assert (above & ~bright).sum() > 100, "some of what is seen lies behind the lamp"
    return np.where(lit, value, 0.0), int((above & bright).sum())


@pytest.mark.parametrize("lanes", [16, 8])
def test_a_light_is_right_in_every_pixel(copies: Any, tmp_path: Path, lanes: int) -> None:
    found = render(copies(patch_light), PATCH, tmp_path, lanes)
    right, feelers = right_patch()
    assert wrong(found["pixels"], right) == 0 and found["feelers"] == feelers


@pytest.mark.parametrize(
    ("old", "new"), [("sample.factor *= cosine;", ""), ("!(cosine > 0.0f)", "cosine != cosine")]
)
def test_a_light_s_formula_matters(copies: Any, tmp_path: Path, old: str, new: str, hasty: None) -> None:
    other = shutil.copytree(copies(patch_light), tmp_path / "other")
    changed(other, {"kernels/light_patch.clh": {old: new}})
    assert wrong(render(other, PATCH, tmp_path)["pixels"], right_patch()[0]) > 50


def test_a_light_without_its_formula_does_not_build(copies: Any, tmp_path: Path) -> None:
    other = shutil.copytree(copies(patch_light), tmp_path / "other")
    changed(other, {"kernels/light.clh": {'#include "light_patch.clh"\n': ""}})
    done = run(other, "import sys, clrt; clrt.Tracer(clrt.load_dict(eval(sys.argv[1])))", repr(PATCH))
    assert done.returncode and "do not build" in done.stderr


def test_a_light_is_in_the_schema(copies: Any) -> None:
    done = run(copies(patch_light), "from clrt.scene.schema import schema_text; print(schema_text())")
    assert '"PatchLight"' in done.stdout and '"PatchLight"' not in schema_text()


FUZZ = scene({"type": "point"}, diffuse=0.3, fuzz=0.6)


def right_fuzz() -> np.ndarray:
    _, _, cosine, lit = towards_lamp()
    d, _, _, n = seen()
    return np.where(lit, INTENSITY * 0.6 * COLOR * (1 + (n * d).sum(-1)) * cosine, 0.0)


def test_a_term_is_right_in_every_pixel(copies: Any, tmp_path: Path) -> None:
    found = render(copies(fuzz_term), FUZZ, tmp_path, layers=("fuzz", "diffuse"))
    _, _, cosine, lit = towards_lamp()
    plain = np.where(lit, INTENSITY * 0.3 * COLOR * cosine, 0.0)
    assert wrong(found["fuzz"], right_fuzz()) == 0
    assert wrong(found["diffuse"], plain) == 0
    assert wrong(found["pixels"], plain + right_fuzz()) == 0
    alone = render(copies(fuzz_term), scene({"type": "point"}, diffuse=0.0, fuzz=0.6), tmp_path)
    assert wrong(alone["pixels"], right_fuzz()) == 0


def test_a_term_that_asks_for_no_light_gets_none(copies: Any, tmp_path: Path) -> None:
    other = shutil.copytree(copies(fuzz_term), tmp_path / "other")
    changed(other, {"kernels/light.clh": {"|| (terms & TERM_FUZZ && material->fuzz > 0.0f)": ""}})
    assert not render(other, scene({"type": "point"}, diffuse=0.0, fuzz=0.6), tmp_path)["pixels"].any()


def right_facing() -> np.ndarray:
    d, hit, _, n = seen()
    return np.where(hit, np.abs((n * d).sum(-1)), 0.0)


def test_a_layer_is_right_in_every_pixel(copies: Any, tmp_path: Path) -> None:
    found = render(copies(facing_layer), scene({"type": "point"}), tmp_path, layers=("all",))
    assert {"facing", "depth", "diffuse"} < set(found)
    assert found["facing"].dtype == np.float32 and wrong(found["facing"], right_facing()) == 0


def test_a_layer_s_line_in_the_kernel_matters(copies: Any, tmp_path: Path, hasty: None) -> None:
    other = shutil.copytree(copies(facing_layer), tmp_path / "other")
    changed(other, {"kernels/film.cl": {"= fabs(dot3(at.outward,": "= (dot3(at.outward,"}})
    found = render(other, scene({"type": "point"}), tmp_path, layers=("facing",))
    assert wrong(found["facing"], right_facing()) > 100


AGAIN = """
import sys, numpy as np, clrt
tracer = clrt.Tracer(clrt.load_dict(eval(sys.argv[1])))
first, again = (tracer.render(layers="all", checkpoint=sys.argv[2]) for _ in range(2))
assert np.isinf(first.layers["facing"]).any() and list(first.layers) == list(again.layers)
assert all(np.array_equal(layer, again.layers[name]) for name, layer in first.layers.items())
"""


def test_a_layer_that_may_be_infinite_is_in_a_checkpoint(copies: Any, tmp_path: Path) -> None:
    other = shutil.copytree(copies(facing_layer), tmp_path / "other")
    text = "fabs(dot3(at.outward, ray.direction))"
    changed(other, {"kernels/film.cl": {text: f"hit ? {text} : INFINITY"}})
    ball = scene({"type": "point"})
    del ball["shapes"][1]
    done = run(other, AGAIN, repr(ball), tmp_path / "a.checkpoint")
    assert done.returncode == 0, done.stderr


PAGES = {
    "adding-a-primitive": (torus, 10),
    "adding-a-light": (patch_light, 5),
    "adding-a-term": (fuzz_term, 4),
    "adding-a-layer": (facing_layer, 2),
}


@pytest.mark.parametrize("page", PAGES)
def test_the_page_is_a_screen_and_names_what_the_test_touches(page: str) -> None:
    thing, files = PAGES[page]
    text, root = (DOCS / f"{page}.md").read_text(), DOCS.parent
    folder = Path(str(thing.__file__)).parent
    headers = {f"kernels/{file.name}" for file in folder.glob("*.clh")}
    assert len(thing.ENTRIES) + len(headers) == files
    assert len(text.splitlines()) <= 40
    named = set(re.findall(r"`((?:kernels|clrt|validation|tests)/[\w/.]+)`", text))
    assert not [name for name in sorted(named - headers) if not (root / name).exists()]
    assert named >= set(thing.ENTRIES) | headers
    assert f"{files} files" in text
