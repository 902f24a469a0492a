"""Reads and renders hostile inputs, one a line of standard input; answers each in a line of JSON.

A line is either `{"folder": F, "scene": NAME}` or `{"seed": S, "index": I}`, an input of `mutate.make`.
Reading is under the limits that a user has who says nothing. Rendering is, too, but for the size of the
picture and the rays: a scene that the product would render for hours has to be left at some point.
"""

from __future__ import annotations

import gc
import json
import re
import sys
import time
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import asdict
from pathlib import Path
from traceback import walk_tb
from typing import Any, Final

import clrt
from clrt.device import cachelock
from clrt.device.opencl import cl
from clrt.engine import wavefront
from clrt.scene.mesh import Mesh

from . import finite, seeds, xmlfiles
from .memory import Cost, measured
from .mutate import make

SIDES: Final = (12, 9)  # of the picture where the scene's is larger, but not too large
LARGEST: Final = 1 << 12  # pixels that are rendered as the scene says
SAMPLES: Final = 16
WORK: Final = 2_000_000  # rays of a picture, at most: less than a second
_PICTURES: Final = re.compile(r"\.(png|jpe?g|bmp|tiff?|exr|hdr)$", re.IGNORECASE)
_RAW: Final = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069\ud800-\udfff]")


def attempt(path: Path, device: int | str | None, checkpoint: Path | None = None) -> dict[str, Any]:
    """What becomes of a scene file: {"status": "rendered" | "refused" | "foreign" | "not finite", "text"}.

    "traced" says that it was refused for what rays met, so was rendered until then. "read" and "render" are
    what reading it (with its pictures and meshes) and rendering it cost, with the tripwire: the film hides a
    NaN.
    """
    read, render, triangles, meshes, traced = Cost(), Cost(), 0, 0, False
    try:
        with measured() as read:
            scene = _read(path)
        triangles = sum(shape.primitives for shape in scene.shapes)
        meshes = sum(isinstance(shape, Mesh) for shape in scene.shapes)
        with measured(collect=False) as render:
            broken = finite.rendered(scene, device, checkpoint, frame(scene))
        said = {"status": "not finite" if broken else "rendered", "text": broken}
    except clrt.ClrtError as error:
        text = str(error)
        fine = text and len(text) < 2000 and not _RAW.search(text)
        said = {"status": "refused" if fine else "foreign", "text": text[:2000]}
        frames = (frame for frame, _ in walk_tb(error.__traceback__))
        traced = any(frame.f_globals.get("__name__") == wavefront.__name__ for frame in frames)
    except Exception:  # what must not happen: told, so that it can be mended
        said = {"status": "foreign", "text": traceback.format_exc()[-3000:]}
    costs = {"read": asdict(read), "render": asdict(render)}
    return {**said, "triangles": triangles, "meshes": meshes, "traced": traced, **costs}


def _read(path: Path) -> clrt.Scene:
    scene = clrt.load(path)
    if scene.background_path is not None:
        _look_at(scene.background_path, scene.limits)
    return scene


def _look_at(picture: Path, limits: clrt.Limits) -> None:
    """Read a picture with all its layers, and ask for mattes of any name."""
    image = clrt.read_image(picture, limits, layers="all")
    for kind in ("shape", "material"):
        if f"crypto_{kind}" in image.layers:
            with suppress(clrt.ClrtError):  # not of that name
                image.matte("shapes[0]", kind)


def frame(scene: clrt.Scene) -> dict[str, Any]:
    """How to render a scene: as it says, but for what the product allows and would take long."""
    limits = clrt.Limits()
    how: dict[str, Any] = {"settings": clrt.Settings(limits=clrt.Limits(work=WORK), check=True)}
    camera = scene.camera
    if camera is not None and LARGEST < camera.width * camera.height <= limits.pixels:
        how["width"], how["height"] = SIDES
    if camera is not None and SAMPLES < camera.spp <= limits.samples:
        how["spp"] = 1
    return how


def answer(task: dict[str, Any], folder: Path, device: int | str | None) -> dict[str, Any]:
    """One task done: its outcome, the bytes of its files, the pixels of its pictures, and what it cost."""
    path, checkpoint = Path(task.get("folder", folder), task.get("scene", "")), None
    if "folder" not in task:
        for old in folder.iterdir():
            old.unlink()
        made = make(task["seed"], task["index"])
        for name, data in made.files.items():
            (folder / name).write_bytes(data)
        path = folder / made.scene
        checkpoint = folder / made.checkpoint if made.checkpoint else None
        files = list(folder.iterdir())
    else:
        files = [path]
        words = path.read_bytes()[: 1 << 16]
        files += [file for file in Path(task["folder"]).glob("part_*") if file.name.encode() in words]
    size, pixels = sum(file.stat().st_size for file in files), _pixels(files)
    built = _Builds.seconds
    outcome = attempt(path, device, checkpoint)
    outcome["render"]["seconds"] -= _Builds.seconds - built
    return {**task, **outcome, "size": size, "pixels": pixels}


def _pixels(files: list[Path]) -> int:
    """What pictures among these declare, as far as the product's limits allow it: limits of their own.

    A picture counts as often as it is named: each way in which a surface shows it has its own texels. All
    channels of an EXR are read (`_look_at`), three are a picture.
    """
    import OpenImageIO as oiio

    most, found = clrt.Limits().image_pixels, 0
    words = b"".join(file.read_bytes() for file in files if not _PICTURES.search(file.name))
    for file in files:
        if _PICTURES.search(file.name) and (source := oiio.ImageInput.open(str(file))):
            spec = source.spec()
            # an EXR's picture is its display window, however little of it is stored
            many = max(spec.width * spec.height, spec.full_width * spec.full_height)
            read = -(-spec.nchannels // 3) if source.format_name() == "openexr" else 1
            found += many * max(read, words.count(file.name.encode())) if 0 < many <= most else 0
            source.close()
    return min(found, clrt.Limits().texture_bytes // 12)


class _Builds:
    """Kernels for what rays carry are built once a machine: the seconds are no input's."""

    seconds = 0.0

    @classmethod
    def watch(cls) -> None:
        """Count programs that are built, and launches for which the driver compiles: PoCL does most then."""
        build, compiling = cl.Program.build, cachelock.compiling

        def timed(*arguments: Any, **options: Any) -> Any:
            with cls._counted():
                return build(*arguments, **options)

        @contextmanager
        def watched(program: str, *sizes: object) -> Iterator[bool]:
            with compiling(program, *sizes) as known, nullcontext() if known else cls._counted():
                yield known

        cl.Program.build = timed  # type: ignore[method-assign]
        cachelock.compiling = watched

    @classmethod
    @contextmanager
    def _counted(cls) -> Iterator[None]:
        before, start = cls.seconds, time.process_time()
        try:
            yield
        finally:
            cls.seconds = before + time.process_time() - start  # with what was counted within it, once


def warm(folder: Path, device: int | str | None) -> None:
    """Open the device and import every reader, which is done once a process and is no input's cost."""
    for name, data in {**seeds.meshes(), **seeds.images()}.items():
        suffix = name[name.rindex(".") :]
        file = folder / f"warm{suffix}"
        file.write_bytes(data)
        if suffix in seeds.images():
            clrt.read_image(file)
        else:
            clrt.load(file)
    for suffix, text in (
        (".nff", seeds.NFF),
        (".txt", seeds.THESIS),
        (".xml", xmlfiles.SCENE),
        (".toml", "[camera]\norigin=[0,0,1]\ntarget=[0,0,0]"),
    ):
        (folder / f"warm{suffix}").write_text(text)
        clrt.load(folder / f"warm{suffix}")
    clrt.render(clrt.load_dict(seeds.RESUMED), device=device)


def main(device: str | None, place: str) -> None:
    """Answer until standard input ends; the inputs are written to the folder `place`, which others remove."""
    warnings.simplefilter("ignore")
    _Builds.watch()
    folder = Path(place)
    warm(folder, device)
    gc.collect()
    gc.freeze()  # else each collection looks through all modules, which takes longer than most inputs
    print(json.dumps({"ready": True}), flush=True)
    for line in sys.stdin:
        print(json.dumps(answer(json.loads(line), folder, device)), flush=True)
