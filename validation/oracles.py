"""Who renders a case: our kernels, and the oracles by name."""

from __future__ import annotations

import atexit
import dataclasses
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np

from clrt.base.errors import ClrtWarning
from clrt.base.install import install_extra, pip_install
from clrt.base.resources import scene_folder
from clrt.device.device import Device
from clrt.engine.tracer import Tracer
from clrt.scene.scene import Scene

from .cases import TABLES, loaded, tables
from .compare.metrics import EDGE_CHANGE, EDGE_STEP, brightening
from .compare.rays import FINE
from .oracle64 import edge_mask, render64
from .oracle64.adaptive import adaptive64, even
from .oracle64.world import Lift
from .oracle_mitsuba import Mitsuba, Source
from .oracle_mitsuba.handed import tables as mesh_tables
from .oracle_mitsuba.modes import SPECTRAL as BY_WAVELENGTH
from .oracle_mitsuba.modes import supports
from .oracle_mitsuba.reading import Untranslated, read
from .oracle_mitsuba.stock import lift
from .oracle_povray.scene import not_in_pov, too_far
from .ours import LAYERS, TERMS, ray_key, render_adaptive, render_ours
from .types import Case, OracleImage

ORACLE64: Final = "oracle64"
POVRAY: Final = "povray"  # its pictures are clipped to [0, 1], and have no layers
SPECTRAL: Final = f"mitsuba-{BY_WAVELENGTH}"  # its table mode, wavelength by wavelength
_FLOAT32_STEP: Final = 1e-4  # pixels: what float32 moves what a path's rays see by, see `edges64`
_ROUNDED: Final = 2.5
_AMBIENT: Final = ray_key(0, "camera ambient")  # says nothing new where later rays bring the ambient light


def scene_of(case: Case) -> Scene:
    """The case's scene as the renderer reads it, of the case's size, samples and depth."""
    scene = loaded(case.scene)
    if isinstance(case.scene, Path) and scene.adaptive is not None:  # far more samples than a case has
        with _unwarned():
            scene = msgspec.structs.replace(scene, adaptive=None)
    return scene.override(width=case.width, height=case.height, spp=case.spp, max_depth=case.max_depth)


def stand_in_of(case: Case) -> Scene:
    """The scene of the same picture for oracles that cannot express the case's own, if it has one."""
    return scene_of(case if case.stand_in is None else dataclasses.replace(case, scene=case.stand_in))


def source_of(case: Case) -> Source:
    """The case's tables for oracles that read them themselves; those of its stand-in, if it has one.

    Of files that only the renderer reads, such as NFF, what it has read is handed on.
    """
    source = case.stand_in or case.scene
    if isinstance(source, Path) and source.suffix not in TABLES:
        return handed_on(scene_of(case))
    folder = source.parent if isinstance(source, Path) else scene_folder()
    said = tables(source)
    if isinstance(source, Path):
        said = {key: value for key, value in said.items() if key != "adaptive"}
    return Source(said, str(folder), case.width, case.height, case.spp, case.max_depth)


def handed_on(scene: Scene) -> Source:
    """A scene that exists only as the renderer has read it, say from an NFF file, as tables.

    Whatever Mitsuba says of it, it says of what `clrt` read. But files of meshes its side reads by itself,
    where it reads what is in them.
    """
    folder = None if scene.folder is None else str(scene.folder)
    camera = scene.camera
    assert camera is not None
    size = camera.width, camera.height, camera.spp
    return Source(mesh_tables(scene, whole=False), folder, *size, scene.max_depth)


@contextmanager
def _unwarned() -> Iterator[None]:
    """Without the warnings that are due: cases are to have open glass, media that overlap, bright sums."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ClrtWarning)
        yield


def tracer_of(scene: Scene, device: Device) -> Tracer:
    """A tracer on a device that is already open, so that its kernels are built once for many scenes."""
    with _unwarned():
        return Tracer(scene, device)


def our_picture(scene: Scene, device: Device) -> OracleImage:
    """The kernels' picture of a scene from its camera."""
    tracer = tracer_of(scene, device)
    return render_ours(tracer) if scene.adaptive is None else render_adaptive(tracer)


@dataclass(frozen=True, eq=False)
class Picture64(OracleImage):
    """The float64 oracle's picture, and what each sample of a pixel sees (spp, h, w, 3)."""

    samples: np.ndarray


def picture64(scene: Scene, lift: Lift | None = None) -> Picture64:
    """The float64 oracle's; lift: how far from surfaces its rays start (no adaptive scene)."""
    start = time.perf_counter()
    if scene.adaptive is None:
        result, names = render64(scene, layers=(*TERMS, *LAYERS), lift=lift), LAYERS
        terms = {ray_key(0, f"camera {name}"): result.layers[name] for name in TERMS}
    else:
        result, names, terms = adaptive64(scene, LAYERS), (*LAYERS, "samples"), {}
    layers = {name: result.layers[name] for name in names if name not in ("depth", "shape")}
    if scene.ambient_samples:
        terms.pop(_AMBIENT, None)
    t, shape, seconds = result.layers["depth"], result.layers["shape"], time.perf_counter() - start
    name, by_ray = "float64 oracle", result.by_ray | terms
    return Picture64(result.pixels, by_ray, t, shape, name, seconds, result.samples, layers=layers)


def lifted64(case: Case) -> np.ndarray:
    """What it changes of a case's picture (h, w, 3) that Mitsuba's plugins start rays farther from surfaces.

    That is 9e-5 of the coordinates, ours a few units in their last place; so it shows where a shadow meets
    what casts it, and nowhere else.
    """
    scene = stand_in_of(case)
    return np.asarray(picture64(scene, lift(read(source_of(case)))).pixels - picture64(scene).pixels)


def edges64(scene: Scene, reference: Picture64) -> np.ndarray:
    """Pixels (h, w) where a sample of the float64 oracle's picture jumps; never made from ours.

    Samples move by EDGE_STEP / spp pixel: with 16 of them 16 times as many lie near to an edge, so that a
    pixel which an edge crosses is as likely to be left out as at one sample. 0.003 pixel is still some 300
    times what float32 rounds a camera ray by, and 30 times what it moves the edges by that all rays of a path
    see: 1e-4 pixel, as the pixels of 4 random scenes show that differ (0.3 to 1.5 %, where 12 to 33 % lie
    within the step).

    A jump counts from what moves the pixel by FINE where two of its samples make it. The slope of a smooth
    surface never counts: it is 16 times less under a step so much smaller.

    Where surfaces show pictures, every texel is an edge, and in a mirror far away a pixel holds many of them:
    half of the still life would be left out, and in the other half jumps of less than EDGE_CHANGE, of 5 %
    mirrors, would not. There it counts what the gates count: a pixel is left out where its samples move by
    more than FINE on average when they move by 2.5 times what float32 moves them by.

    Of an adaptive picture each pixel is asked in the even one that it shows.
    """
    if scene.adaptive is not None:
        count = reference.layers["samples"]
        masks = {spp: _edges_of(even(scene, spp)) for spp in np.unique(count).tolist()}
        return np.select([count == spp for spp in masks], list(masks.values()))
    times = brightening(reference.pixels)  # as they are compared
    if any(scene.material_of(shape).pictures for shape in scene.shapes):
        step = _ROUNDED * _FLOAT32_STEP
        return np.asarray(
            edge_mask(scene, reference=reference.samples, step=step, change=FINE / times, together=True)
        )
    spp = len(reference.samples)
    change = max(EDGE_CHANGE / spp, spp * FINE / 2) / times
    return np.asarray(edge_mask(scene, reference=reference.samples, step=EDGE_STEP / spp, change=change))


def _edges_of(scene: Scene) -> np.ndarray:
    return edges64(scene, picture64(scene))


class Oracles:
    """All oracles, of which Mitsuba is a process of its own. A context manager."""

    def __init__(self, timeout: float = 300.0) -> None:
        self.mitsuba = Mitsuba(timeout, _command)
        self._missing: str | None = None
        self._asked = False

    def __enter__(self) -> Oracles:
        return self

    def __exit__(self, *_: Any) -> None:
        self.mitsuba.close()

    def missing(self) -> str | None:
        """Why Mitsuba does not run here, or None."""
        if not self._asked:
            self._missing, self._asked = self.mitsuba.available(), True
        return self._missing

    def unable(self, oracle: str, source: Source) -> str | None:
        """Why the float64 oracle (never) or a mode of Mitsuba cannot render a scene; None where it can."""
        if oracle == ORACLE64:
            return None
        return self.missing() or self.mitsuba.supports(source, mode_of(oracle))

    def render(self, oracle: str, source: Source) -> OracleImage:
        """A picture from the scene's camera by one of Mitsuba's modes, which reads the tables itself."""
        picture = self.mitsuba.render(source, mode_of(oracle))
        if source.tables.get("ambient_samples"):
            picture.by_ray.pop(_AMBIENT, None)
        return picture


@cache
def oracles() -> Oracles:
    """This process' oracles."""
    opened = Oracles()
    atexit.register(opened.mitsuba.close)
    return opened


def able(oracle: str, case: Case) -> bool:
    """Whether an oracle can express a case, wherever it runs."""
    return why_not(oracle, case) is None


def why_not(oracle: str, case: Case) -> str | None:
    """Why an oracle cannot express a case; None where it can, wherever it runs."""
    if oracle == ORACLE64:
        return None
    if oracle == POVRAY:
        scene = stand_in_of(case)
        return not_in_pov(scene) or too_far(scene)
    try:
        return supports(read(source_of(case)), mode_of(oracle))
    except Untranslated as reason:
        return str(reason)


def mode_of(oracle: str) -> str:
    """Mitsuba's mode for an oracle's name: "mitsuba-table" -> "table"."""
    return oracle.removeprefix("mitsuba-")


def _command(package: str) -> str:
    """What installs a package that Mitsuba needs."""
    return pip_install(package) if package == "karellen-llvm-core" else install_extra("validation")
