"""`clrt render`: load, render with progress, save; whatever happens, no file is half-written."""

from __future__ import annotations

import argparse
import os
import re
import time
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from clrt.base import notices
from clrt.base.atomic import check_replaceable, write_json
from clrt.base.errors import ClrtError
from clrt.base.records import Unstated
from clrt.cli import interrupted, terminal
from clrt.cli.outputs import check_apart
from clrt.cli.source import STREAM, read, scene_path, stem
from clrt.cli.tracing import tracing

if TYPE_CHECKING:
    from clrt.device.settings import Settings
    from clrt.images.image import Image
    from clrt.scene.scene import Scene

_SMOOTH = 2  # side of a pixel's grid of samples where nobody says a number; filters may need more
_LOOKED_AT = (".png", ".jpg", ".jpeg", ".bmp")  # what is a picture for eyes, not for measuring
_DEEPEST = 1000  # generation whose layer's file is looked at beforehand: renders of more are refused, mostly


_ONE: Final = ("stats", "trace", "checkpoint")  # files that a render of several scenes has no names for

_BLACK: Final = (
    "the picture is black: no light comes to what it shows; do the lights point there, and does nothing "
    "stand before them?"
)

_FIELDS: Final = re.compile(r"\{(name|index)[:}]")


def run(options: argparse.Namespace) -> int:
    """Render each of `options.scene` to a file. ClrtError, before rendering, when one cannot be saved."""
    each = [argparse.Namespace(**{**vars(options), "scene": name}) for name in options.scene]
    if len(each) > 1 or _FIELDS.search(options.output):
        _name_apart(each)
    for one in each:
        code = _run(one)
        if code:
            return code
    return 0


def _name_apart(each: list[argparse.Namespace]) -> None:
    """Give each of several scenes an output of its own, and look at all of them."""
    from clrt.images.naming import frame_name

    pattern = each[0].output
    for name in _ONE if len(each) > 1 else ():
        if getattr(each[0], name):
            raise ClrtError(f"--{name}: is for one scene; give it {len(each)} renders of their own")
    if [one.scene for one in each].count(STREAM) > 1:
        raise ClrtError("-: standard input can be read once")
    files = [scene_path(one.scene) for one in each]
    for number, (one, file) in enumerate(zip(each, files, strict=True)):
        one.output = frame_name(pattern, number, {"name": stem(file)})
        if one.output in [other.output for other in each[:number]]:
            field = "{index}" if "{name" in pattern else "{name} or {index}"
            what = f"several pictures would be {one.output}; put {field} into the name"
            raise ClrtError(f"{pattern}: {what}")
    inputs = {f"the scene {file}": file for file in files}
    check_apart({f"-o ({one.output})": one.output for one in each}, inputs)
    for one, file in zip(each, files, strict=True):
        _check_outputs(one, file)
    if len(each) > 1:
        # all are read before the first is rendered: its files must be none that a later one reads or writes
        written: dict[str, str] = {}
        for one, file in zip(each, files, strict=True):
            scene = _read(file, one)
            # others are read again, for all of them at once may take much memory
            one.loaded = scene if one.scene == STREAM else None
            outputs = _outputs(_with_layers_named(one, scene))
            written |= {f"{option} ({file}, {output})": output for option, output in outputs.items()}
        check_apart(written, inputs)


def _run(options: argparse.Namespace, keep: bool = False) -> int:
    """Render `options.scene` to `options.output`. keep: the checkpoint is still needed after that."""
    if options.output == STREAM:
        return _to_stream(options)
    try:
        file = scene_path(options.scene)
        _check_outputs(options, file)
        start = time.perf_counter()
        with tracing(options.trace) as save_trace:
            image = render(file, options, layers=options.layers)
        seconds = time.perf_counter() - start
        if not (image.pixels.any() or options.crop):
            notices.warn(options.scene, "", _BLACK)
        saved = image.save(options.output, options.exposure, options.bits, options.view)
        beside = []
        if image.layers and not _holds_layers(options.output):
            beside = image.save_layers(options.output, options.exposure, options.bits, options.view)
        if options.stats:
            write_json(options.stats, image.stats, indent=2)
        save_trace()
        if not keep:
            _drop_checkpoint(options)
        if not options.quiet:
            print(summary(image, saved, seconds))
            if beside:
                print(f"layers: {', '.join(path.name for path in beside)}")
    except KeyboardInterrupt:
        return interrupted(options.checkpoint)
    return 0


def _to_stream(options: argparse.Namespace) -> int:
    """The picture as PNG on standard output, and nothing else there."""
    from clrt.base.scratch import scratch

    if options.layers:
        raise ClrtError("-o -: --layers needs files; give -o the name of an .exr")
    try:
        with scratch() as folder:
            file = str(folder / "a.png")
            named = argparse.Namespace(**{**vars(options), "output": file, "quiet": True})
            code = _run(named, keep=True)
            data = Path(named.output).read_bytes() if code == 0 else b""
    except KeyboardInterrupt:
        return interrupted(options.checkpoint)
    if terminal.write_bytes(data) and code == 0:
        _drop_checkpoint(options)
    return code


def _drop_checkpoint(options: argparse.Namespace) -> None:
    """Not before the picture is where it should be; what a link leads to, as that was written."""
    if options.checkpoint:
        Path(os.path.realpath(options.checkpoint)).unlink(missing_ok=True)


def render(file: Path, options: argparse.Namespace, layers: tuple[str, ...] = ()) -> Image:
    """The image of a scene file, with a progress bar on stderr where that is a terminal."""
    from clrt.device.ahead import loading

    with loading():
        import clrt.device.driver
        import clrt.flatten.flatten
        import clrt.formats.shipped
        from clrt.cli.clusters import cluster
        from clrt.cli.progress import progress

    scene = _read(file, options)
    _check_layers(options, file, scene)
    limits = clrt.Limits(**dict(options.limit))
    settings = clrt.Settings(threads=options.threads, limits=limits, check=getattr(options, "check", False))
    quiet = getattr(options, "quiet", False)
    with cluster(options, settings) as (workers, settings), progress(stem(file), quiet) as report:
        output = getattr(options, "output", "")
        opened = options.device if workers else _ahead(scene, options.device, settings, output)
        return clrt.render(
            scene,
            width=options.width,
            height=options.height,
            spp=_samples(options, scene),
            max_depth=options.max_depth,
            device=opened,
            layers=layers,
            progress=report,
            settings=settings,
            crop=tuple(options.crop) if options.crop else None,
            checkpoint=getattr(options, "checkpoint", None),
            **workers,
        )


def _read(file: Path, options: argparse.Namespace) -> Scene:
    """The scene that is rendered, with the values of --set."""
    from clrt.base.limits import Limits
    from clrt.formats.native import with_values

    known: Scene | None = getattr(options, "loaded", None)
    return known or with_values(read(file, Limits(**dict(options.limit))), options.set)


def _ahead(scene: Scene, device: str | None, settings: Settings, output: str) -> Any:
    """The device, opened for a scene; what renders and saves is imported while it reads its kernels.

    `device` itself where it cannot be opened: the render does it again, and tells what is wrong. Errors of
    the scene come at once.
    """
    from clrt.device.ahead import building
    from clrt.device.driver import Driver
    from clrt.engine.needed import needed
    from clrt.flatten.flatten import flatten_ahead
    from clrt.images.file import load_colours

    flat = flatten_ahead(scene)
    with suppress(ClrtError, MemoryError):
        driver = Driver(device, settings, None)
        with building(driver, flat.ray_format, needed(flat)):
            import_module("clrt.cluster.pictures")
            if not _holds_layers(output):
                load_colours()
        return import_module("clrt.device.device").Device(driver, ray_format=flat.ray_format)
    return device


def _samples(options: argparse.Namespace, scene: Scene) -> int | None:
    """Samples a pixel in place of the scene's: first pictures to look at are not jagged."""
    from clrt.layout import filter_grid

    output = Path(getattr(options, "output", "")).suffix.lower()
    unsaid = options.spp is None and scene.camera is not None and isinstance(scene.camera.spp, Unstated)
    if not unsaid or output not in _LOOKED_AT or scene.conformance != "none":
        return options.spp
    assert scene.camera is not None
    wanted = max(_SMOOTH, filter_grid(scene.camera.filter)) ** 2
    allowed = dict(options.limit).get("samples", wanted) >= wanted
    allowed = allowed and (scene.adaptive is None or scene.adaptive.spp >= wanted)
    return wanted if allowed else options.spp


def summary(image: Image, path: Path, seconds: float) -> str:
    """The line after a render: where the picture is, its size, how long and how fast, and on what."""
    rate = image.stats["traced"] / seconds / 1e6
    size = f"{image.width} x {image.height}"
    return f"{path}: {size}, {seconds:.2f} s, {rate:.2f} Mrays/s on {image.stats['device']}"


def _outputs(options: argparse.Namespace) -> dict[str, str]:
    """The files that are to be written, by option."""
    given = {name: getattr(options, name, None) for name in ("output", "stats", "trace", "checkpoint")}
    files = {f"--{name}": path for name, path in given.items() if path}
    return files | {f"--layers {name}": str(file) for name, file in _layer_files(options).items()}


def _layer_files(options: argparse.Namespace) -> dict[str, Path]:
    """The files of the layers that are asked for by name, where the picture's own cannot hold them."""
    from clrt.images.image import layer_file

    output = getattr(options, "output", None)
    if output is None or _holds_layers(output):
        return {}
    return {name: layer_file(output, name) for name in options.layers if name != "all"}


def _check_layers(options: argparse.Namespace, file: Path, scene: Scene) -> None:
    """The rest of `_check_outputs`, once the scene says which pictures it reads, and which layers are all."""
    options = _with_layers_named(options, scene)
    check_apart(_outputs(options), {"the scene": file})
    for layer in _layer_files(options).values():
        check_replaceable(layer)


def _with_layers_named(options: argparse.Namespace, scene: Scene) -> argparse.Namespace:
    """The options with the names of all layers that have files of their own in place of "all"."""
    from clrt.base.layers import check_layers, find

    if "all" not in getattr(options, "layers", ()):
        return options
    depth = scene.max_depth if options.max_depth is None else options.max_depth
    names = check_layers("all", min(depth, _DEEPEST), spectral=True, pictured=True)
    shown = [name for name in names if find(name).is_shown]
    return argparse.Namespace(**{**vars(options), "layers": shown})


def _check_outputs(options: argparse.Namespace, scene: Path) -> None:
    from clrt.base.layers import find
    from clrt.images.image import check_writable
    from clrt.images.views import check_shown

    bits = check_writable(options.output, options.exposure, options.bits)
    check_shown(options.output, bits, options.view)
    hidden = [name for name in options.layers if not find(name).is_shown]
    if hidden and not _holds_layers(options.output):
        raise ClrtError(f"{options.output}: --layers {hidden[0]} needs an .exr, which alone holds them")
    check_apart(_outputs(options), {"the scene": scene})
    for file in _layer_files(options).values():
        check_replaceable(file)
    for path in filter(None, (options.stats, options.trace, options.checkpoint)):
        check_replaceable(path)


def _holds_layers(output: str) -> bool:
    return Path(output).suffix.lower() == ".exr"
