"""The scenes on which our kernels and the oracles must agree.

    parts    primitives, materials and a room, of which the others are made
    matrix   every primitive with every material, from outside and inside
    terms    one term of the model a case
    views    cameras, samples, total internal reflection, mirrors of mirrors
    media    media in media, and how they absorb
    spectral light in bands, metals and dispersion
    chance   scenes drawn from a seed
    stock    what Mitsuba's own plugins can express
    crossed  features that meet in one ray
    found    scenes on which something once failed

A case is known by its name, so that a run can be repeated and shared out to processes.
"""

from __future__ import annotations

import dataclasses
import json
import re
import runpy
import tomllib
import warnings
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

from clrt.base.errors import ClrtError, ClrtWarning, show
from clrt.base.resources import scene_file, scene_folder, shipped_scenes
from clrt.base.suggest import did_you_mean
from clrt.formats import load_dict
from clrt.formats.shipped import load_scene
from clrt.scene.scene import Scene

from ..compare.oracle import Limits, exact, limits
from ..coverage import features_of
from ..ticks import shown
from ..types import Case
from . import chance, crossed, found, matrix, media, pictures, spectral, stock, terms, views
from .parts import HEIGHT, WIDTH

# that express whole scenes
ORACLES = ("oracle64", "mitsuba-table", "mitsuba-bsdf", "mitsuba-spectral", "povray")
_AT_16 = " at 16 samples"
_WIDTH_AT_16 = 80
_WIDTHS = {
    # of smaller pictures more than 30 % are edges
    "shipped refraction at 16 samples": 100, "shipped tetrahedron at 16 samples": 100,
    # 28 ambient rays for each of 16 samples: a larger one takes the oracles minutes
    "shipped ambient at 16 samples": 40,
    # of smaller ones more than 30 % are edges of its many small facets
    "shipped mountain": 256,
}  # fmt: skip
_SIZES = {16: (72, 54), 64: (48, 36)}  # smaller, or the oracles take too long
# scenes that ship and need limits of their own -> which, and why
_FAR = (
    "3000 units from the origin float32 coordinates are 2.4e-4 apart. Half of that turns the normal of a "
    "body of radius 0.6 by 2e-4, and so much of its light; at a distance of 8, on a surface seen at 10 "
    "degrees, it moves the hit by 1e-4 of the distance. Feelers start 1.4e-3 above the ground, which moves "
    "shadows there by up to 3.4e-3: 0.04 pixel, 13 times what is left out at 16 samples, where the one that "
    "is on the other side moves its pixel by 0.014, or 4 % of the picture's mean."
)
_CAUSTIC = (
    "The drop's two images of the lamp join in a caustic, where a ray's direction no longer changes with its "
    "place: rounding a hit by 1e-7 moves the image there by more than is left out as an edge. Rounding the "
    "scene once moves 0.18 % of the pixels by more than 1e-4 (validation/noise.json); light is rounded four "
    "times, when the scene is read and at each of its three hits on the drop: 0.71 %."
)
_ONE_SAMPLE = (
    "In one pixel Mitsuba's rounding, magnified by the round glass and the water, takes one of 16 samples "
    "across an edge, where ours agree with the float64 oracle's within 1e-7. In a picture of 80 x 93 that "
    "pixel is half of all squared differences, or 3 dB. Rounding the scene once brings 60.5 dB "
    "(validation/noise.json): two programs in float32 may be 54.5 dB apart."
)
_FLAKE = (
    "A generation has 9 times the spheres at a third of the radius, and so 3 times the outlines, until they "
    "are smaller than a pixel: of 160 x 160 pixels 37 % are edges. Larger pictures show more "
    "generations, and the share hardly falls: 44, 37 and 35 % at a width of 80, 160 and 240. "
    "Apart from edges rounding moves nothing (validation/noise.json)."
)
OWN_LIMITS: dict[str, tuple[dict[str, float], str]] = {
    "shipped thesis_3_07_acne": ({"fine": 0.997, "rays": 0.997, "distance": 2e-4}, _FAR),
    "shipped thesis_3_07_acne (oracle64)": (
        {"fine": 0.997, "rays": 0.997, "distance": 2e-4, "layers": 0.9}, _FAR),
    "shipped thesis_3_07_acne at 16 samples": ({"masked": 0.03}, _FAR),
    "shipped thesis_3_07_acne at 16 samples (oracle64)": (
        {"fine": 0.998, "rays": 0.998, "coarse": 0.9992, "distance": 2e-4, "masked": 0.03, "mean": 8e-5,
         "layers": 0.9}, _FAR),
    "shipped sphereflake": ({"mask": 0.4}, _FLAKE),
    "shipped sphereflake at 16 samples": ({"mask": 0.55}, _FLAKE + " Of 80 x 80 at 16 samples 51 %."),
    "shipped rainbow": ({"fine": 0.993, "rays": 0.9941}, _CAUSTIC),
    "shipped straw at 16 samples (mitsuba-table)": ({"psnr": 58}, _ONE_SAMPLE),
    "shipped rainbow (oracle64)": ({"fine": 0.993, "rays": 0.9941, "coarse": 0.999}, _CAUSTIC),
}
_RANDOM = re.compile(r"random ([0-9]{1,18})/([0-9]{1,18})( at 16 samples)?")
TABLES = (".toml", ".json", ".py")  # of files whose tables others can read, too
_FILE = "file "  # before the path of somebody's own scene
_SHIPPED = re.compile(r"shipped ([\w-]+)( at 16 samples)?")


@cache
def matrix_cases() -> dict[str, Case]:
    """The small scenes that were made to test something, by name."""
    modules = (terms, views, media, spectral, crossed, matrix, found, pictures)
    cases = [_case(name, scene, tags) for module in modules for name, scene, tags in module.scenes()]
    cases += [_case(name, scene, set(), ("oracle64", f"stock-{mode}")) for name, scene,
              mode in stock.scenes()]
    cases += [_case(name, scene, tags) for name, scene, tags in pictures.at_levels()]
    stand_ins = {"equal distances": terms.ties(moved=50.0)}
    return {c.name: dataclasses.replace(c, stand_in=stand_ins.get(c.name)) for c in cases}


def shipped_cases() -> list[str]:
    """Names of the cases of the scenes that ship."""
    return [f"shipped {name}{samples}" for name in shipped_scenes() for samples in ("", _AT_16)]


def random_cases(count: int, seed: int) -> list[str]:
    """Names of the cases of `count` scenes drawn from a seed."""
    return [f"random {seed}/{number}{samples}" for number in range(count) for samples in ("", _AT_16)]


def case_named(name: str) -> Case:
    """The case of a name; ClrtError suggests the nearest one."""
    if name in matrix_cases():
        return matrix_cases()[name]
    drawn, shipped = _RANDOM.fullmatch(name), _SHIPPED.fullmatch(name)
    if drawn:
        scene = chance.scene(int(drawn.group(1)), int(drawn.group(2)))
        return _of_scene(name, scene, (112, 84), bool(drawn.group(3)))
    if shipped and shipped.group(1) in shipped_scenes():
        return _of_scene(name, shipped_scenes()[shipped.group(1)], None, bool(shipped.group(2)))
    if file := own_file(name):
        return _of_scene(name, file, None, False)
    known = [*matrix_cases(), *shipped_cases()]
    near = did_you_mean(name, known)
    raise ClrtError(f"case: {show(name)} is not a case{near}; a random one is 'random SEED/NUMBER'")


def own_case(name: str) -> str:
    """The case of somebody's own scene: a file, or a scene that ships. ClrtError where it has no camera."""
    file = scene_file(name)
    scene = quietly(partial(load_scene, file))
    if scene.camera is None:
        raise ClrtError(f"{name}: camera: missing; a picture needs a [camera]")
    return name_of_own(file)


def name_of_own(file: Path) -> str:
    """The name of the case that a file is."""
    return _FILE + str(file.resolve())


def own_file(name: str) -> Path | None:
    """The file of a case that is somebody's own scene."""
    return Path(name.removeprefix(_FILE)) if name.startswith(_FILE) else None


def limits_of(case: Case, oracle: str) -> Limits:
    """The limits of a case's comparison: strict for what was made as a test and for the oracle in float64."""
    made = case.name in matrix_cases()
    base = limits(case.spp, many_edges=not made)
    if oracle == "oracle64":
        # one pixel of an edge can spoil a window; where a checkered floor ends, three can move the whole
        base = dataclasses.replace(exact(base), window=base.window)
        if not made:
            ssim = max(base.ssim if case.spp > 1 and base.ssim else 0, 0.999)
            base = dataclasses.replace(base, ssim=ssim, fine=0.999, rays=0.999, coarse=0.9998, distance=5e-5)
    elif oracle.startswith("stock"):
        # its shadow rays start elsewhere, which shows where shadows meet what casts them
        base = dataclasses.replace(base, masked=0.03, psnr=(base.psnr or 0) - 2)
    own = OWN_LIMITS.get(f"{case.name} ({oracle})") or OWN_LIMITS.get(case.name, ({}, ""))
    return dataclasses.replace(base, **own[0])


def quietly(load: Callable[[], Scene]) -> Scene:
    """A scene without the warnings that are due: cases are to have open glass and bright sums."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ClrtWarning)
        return load()


def loaded(scene: dict[str, Any] | Path) -> Scene:
    """A case's scene as the renderer reads it, without the warnings that are due."""
    if isinstance(scene, Path):
        return quietly(partial(load_scene, scene))
    return quietly(partial(load_dict, scene, folder=scene_folder()))


def tables(scene: dict[str, Any] | Path) -> dict[str, Any]:
    """A case's scene as the tables that stand in its file: what oracles get that read it themselves."""
    if not isinstance(scene, Path):
        return scene
    if scene.suffix == ".py":
        found: dict[str, Any] = runpy.run_path(str(scene), run_name="clrt_scene")["scene"]()
        return found
    text = scene.read_text("utf-8-sig")
    return dict(json.loads(text)) if scene.suffix == ".json" else tomllib.loads(text)


def _case(name: str, table: dict[str, Any], tags: set[str], oracles: tuple[str, ...] = ORACLES) -> Case:
    scene = loaded(table)
    assert scene.camera is not None
    spp = scene.camera.spp
    finest = spp if scene.adaptive is None else scene.adaptive.spp
    size = _SIZES.get(finest, (WIDTH, HEIGHT))
    case = Case(name, table, frozenset(features_of(scene) | tags), oracles, *size, spp)
    return dataclasses.replace(case, shows=shown(case))


def _of_scene(name: str, source: dict[str, Any] | Path, size: tuple[int, int] | None, many: bool) -> Case:
    scene = loaded(source)
    assert scene.camera is not None
    width = _WIDTHS.get(name, _WIDTH_AT_16 if many else WIDTH)
    width, height = size or (width, round(width * scene.camera.height / scene.camera.width))
    if many and size:
        width, height = size[0] * 2 // 3, size[1] * 2 // 3
    features = frozenset(features_of(scene))
    whose = (why for of, (_, why) in OWN_LIMITS.items() if of == name or of.startswith(f"{name} ("))
    note = next(whose, "")
    return Case(name, source, features, ORACLES, width, height, 16 if many else 1, note=note)
