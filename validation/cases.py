"""The cases by name: scenes on which our kernels and the oracles must agree.

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

from .coverage import features_of
from .limits import note_of
from .scenes import chance, crossed, found, matrix, media, pictures, spectral, stock, terms, views
from .scenes.parts import HEIGHT, WIDTH
from .ticks import shown
from .types import Case

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
    features = frozenset(features_of(scene) | tags)
    case = Case(name, table, features, oracles, *size, spp, is_test=True)
    return dataclasses.replace(case, shows=shown(case))


def _of_scene(name: str, source: dict[str, Any] | Path, size: tuple[int, int] | None, many: bool) -> Case:
    scene = loaded(source)
    assert scene.camera is not None
    width = _WIDTHS.get(name, _WIDTH_AT_16 if many else WIDTH)
    width, height = size or (width, max(round(width * scene.camera.height / scene.camera.width), 1))
    if many and size:
        width, height = size[0] * 2 // 3, size[1] * 2 // 3
    features = frozenset(features_of(scene))
    return Case(name, source, features, ORACLES, width, height, 16 if many else 1, note=note_of(name))
