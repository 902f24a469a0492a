"""A series of pictures: to files, with a manifest by which a later run goes on, or to a video."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from clrt.base.errors import ClrtError
from clrt.base.places import listed
from clrt.cli import interrupted
from clrt.cli.source import read, stem

if TYPE_CHECKING:
    from clrt.cli.frames import Frames
    from clrt.cli.manifest import Manifest
    from clrt.device.settings import Settings
    from clrt.engine.request import Request
    from clrt.scene.scene import Scene

_ONE_SIZE: Final = (
    "a video's frames have one size; leave the camera's width and height as they are, or write pictures"
)
Values = dict[str, Any]
Series = Callable[["Scene", argparse.Namespace], tuple["Scene", list[Values]]]
"""From a scene and the options: the scene that all pictures start from, and what changes for each."""


def render_series(options: argparse.Namespace, file: Path, values_of: Series) -> int:
    """Render a scene file for all values, to where `options.output` says."""
    try:
        return _render(options, file, values_of)
    except KeyboardInterrupt:
        return interrupted()


def _render(options: argparse.Namespace, file: Path, values_of: Series) -> int:
    import clrt
    from clrt.cli.clusters import cluster
    from clrt.cli.frames import Frames, Maker, OneTracer, Workers
    from clrt.cli.manifest import Manifest
    from clrt.cli.outputs import check_apart
    from clrt.cli.progress import progress
    from clrt.engine.request import Request
    from clrt.engine.sweep import check_once
    from clrt.images.file import DEPTHS, check_writable
    from clrt.images.naming import frame_name
    from clrt.images.video import SUFFIXES

    limits = clrt.Limits(**dict(options.limit))
    scene, series = values_of(read(file, limits), options)
    changes: dict[str, list[Any]] = {}
    for values in series:
        for place, value in values.items():
            changes.setdefault(place, []).append(value)
    check_once(scene, changes, vars(options), _said)
    film = Path(options.output).suffix.lower() in SUFFIXES
    names = [options.output] if film else [frame_name(options.output, i, v) for i, v in enumerate(series)]
    if len(set(names)) < (1 if film else len(series)):
        twice = next(name for name, count in Counter(names).items() if count > 1)
        try:
            check_writable(twice)  # advice of a name that is then refused is none
        except ClrtError as error:
            videos = "" if Path(twice).suffix.lower() in DEPTHS else f"; a video is one of {listed(SUFFIXES)}"
            raise ClrtError(f"{error}{videos}") from None
        raise ClrtError(f"{options.output}: several pictures would be {twice}; put {{index}} into the name")
    outputs = {f"-o ({name})" if len(names) > 1 else "-o": name for name in names}
    manifest = options.manifest or (None if film else str(Path(names[0]).parent / "frames.csv"))
    if manifest:
        outputs["--manifest"] = manifest
    check_apart(outputs, {"the scene": file, "the keyframes": getattr(options, "keyframes", None)})
    known = Manifest(manifest, [] if film else names, series, limits)
    settings = clrt.Settings(threads=options.threads, limits=limits)
    picture = {
        "width": options.width, "height": options.height, "spp": options.spp, "max_depth": options.max_depth,
        "crop": tuple(options.crop) if options.crop else None,
    }  # fmt: skip
    sizes = _check_series(scene, series, options, Request(**picture), settings)
    if film and len(sizes) > 1:
        raise ClrtError(f"{options.output}: {_ONE_SIZE}")
    with ExitStack() as stack:
        workers, settings = stack.enter_context(cluster(options, settings))
        maker: Maker
        if workers:
            maker = Workers(workers["executor"], options.device, settings, picture)
        else:
            maker = OneTracer(stack.enter_context(clrt.Tracer(scene, options.device, settings)), picture)
        frames = Frames(maker, scene, series, stack.enter_context(progress(stem(file), options.quiet)))
        if film:
            _to_video(frames, options, known)
        else:
            _to_files(frames, names, options, known)
    if film:
        known.save()
    if not options.quiet:
        there = f", {known.kept} of them were there" if known.kept else ""
        print(f"{options.output}: {len(known.finished())} pictures{there}")
    return 0


def _to_files(frames: Frames, names: list[str], options: argparse.Namespace, known: Manifest) -> None:
    """One file a frame; those that a manifest of before says to be right are kept."""
    from clrt.images.file import check_writable
    from clrt.images.views import check_shown

    for name in names:
        check_shown(name, check_writable(name, options.exposure), options.view)
    exposure = str(options.exposure).removesuffix(".0")  # with all its digits
    shown = f"{exposure} {options.view or ''}".rstrip()

    def is_there(index: int, identity: str) -> bool:
        return known.keeps(index, Path(names[index]), f"{identity} {shown}")

    try:
        for index, image in frames.images(is_there):
            saved = image.save(names[index], options.exposure, view=options.view)
            known.note(index, image.hash, saved, image.stats["traced"])
    finally:  # of a series that was broken off, too
        known.save()


def _to_video(frames: Frames, options: argparse.Namespace, known: Manifest) -> None:
    from clrt.images.video import writing
    from clrt.images.views import check_shown, encode_view

    check_fps(options.fps)
    check_shown(options.output, 8, options.view)

    def is_there(index: int, identity: str) -> bool:
        known.rows[index] = {"index": index, "file": "", "identity": identity}
        return False

    with ExitStack() as stack:
        for index, image in frames.images(is_there):
            if index == 0:
                size = image.width, image.height
                put = stack.enter_context(writing(options.output, *size, options.fps))
            if (image.width, image.height) != size:
                raise ClrtError(f"{options.output}: {_ONE_SIZE}")
            put(encode_view(image.pixels, options.exposure, view=options.view))
            known.note(index, image.hash, None, image.stats["traced"])


def _said(name: str, place: str) -> tuple[str, str]:
    """An option, and the values for a place in the scene."""
    return f"--{name.replace('_', '-')}", f"--set {place}"


def _check_series(
    scene: Scene, series: list[Values], options: argparse.Namespace, asked: Request, settings: Settings
) -> set[tuple[int, int]]:
    """The pictures' sizes. ClrtError where one cannot be rendered; it says which, and for what values."""
    from clrt.engine.foresight import check_series
    from clrt.flatten.flatten import flatten_ahead

    given = dict(options.set)

    def said(places: list[str], index: int) -> str:
        values = " and ".join(f"--set {place}" for place in places if place in given)
        return f"{values}, picture {index}" if values else f"picture {index}"

    # the Tracer has the same scene first, and does not flatten it again
    known = None if getattr(options, "cluster", None) else (scene, flatten_ahead(scene))
    return check_series(scene, series, asked, settings, said, known)


def check_fps(fps: float) -> None:
    """ClrtError for what is no number of frames a second."""
    if not 0.001 <= fps <= 1000:  # a video has it as a fraction, over 1001 at most
        raise ClrtError(f"--fps: {fps} is not allowed; it must be from 0.001 to 1000 frames a second")
