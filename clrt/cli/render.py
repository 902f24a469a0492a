"""`clrt render`: load, render with progress, save; whatever happens, no file is half-written."""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path
from typing import TYPE_CHECKING

from clrt.base.atomic import check_replaceable, write_json
from clrt.base.errors import ClrtError
from clrt.base.resources import scene_file
from clrt.cli import interrupted
from clrt.cli.outputs import check_apart, check_spares

if TYPE_CHECKING:
    from clrt.images.image import Image
    from clrt.scene.scene import Scene

_DEEPEST = 1000  # generation whose layer's file is looked at beforehand: renders of more are refused, mostly


def run(options: argparse.Namespace) -> int:
    """Render `options.scene` to `options.output`. ClrtError, before rendering, when it cannot be saved."""
    try:
        file = scene_file(options.scene)
        _check_outputs(options, file)
        start = time.perf_counter()
        image = render(file, options, layers=options.layers)
        seconds = time.perf_counter() - start
        saved = image.save(options.output, options.exposure, options.bits)
        beside = []
        if image.layers and not _holds_layers(options.output):
            beside = image.save_layers(options.output, options.exposure, options.bits)
        if options.stats:
            write_json(options.stats, image.stats, indent=2)
        if options.checkpoint:
            # not before: it is needed if saving fails; what a link leads to, as that was written
            Path(os.path.realpath(options.checkpoint)).unlink(missing_ok=True)
        if not options.quiet:
            print(summary(image, saved, seconds))
            if beside:
                print(f"layers: {', '.join(path.name for path in beside)}")
    except KeyboardInterrupt:
        return interrupted(options.checkpoint)
    return 0


def render(file: Path, options: argparse.Namespace, layers: tuple[str, ...] = ()) -> Image:
    """The image of a scene file, with a progress bar on stderr where that is a terminal."""
    import clrt
    from clrt.cli.clusters import cluster
    from clrt.cli.progress import progress
    from clrt.formats.native import with_values
    from clrt.formats.shipped import load_scene

    limits = clrt.Limits(**dict(options.limit))
    scene = with_values(load_scene(file, limits=limits), options.set)
    _check_layers(options, file, scene)
    settings = clrt.Settings(threads=options.threads, limits=limits, check=getattr(options, "check", False))
    quiet = getattr(options, "quiet", False)
    with cluster(options, settings) as (workers, settings), progress(file.stem, quiet) as report:
        return clrt.render(
            scene,
            width=options.width,
            height=options.height,
            spp=options.spp,
            max_depth=options.max_depth,
            device=options.device,
            layers=layers,
            progress=report,
            settings=settings,
            crop=tuple(options.crop) if options.crop else None,
            checkpoint=getattr(options, "checkpoint", None),
            **workers,
        )


def summary(image: Image, path: Path, seconds: float) -> str:
    """The line after a render: where the picture is, its size, how long and how fast, and on what."""
    rate = image.stats["traced"] / seconds / 1e6
    size = f"{image.width} x {image.height}"
    return f"{path}: {size}, {seconds:.2f} s, {rate:.2f} Mrays/s on {image.stats['device']}"


def _outputs(options: argparse.Namespace) -> dict[str, str]:
    """The files that are to be written, by option."""
    given = {name: getattr(options, name, None) for name in ("output", "stats", "checkpoint")}
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
    from clrt.base.layers import check_layers, find

    if "all" in getattr(options, "layers", ()):
        depth = scene.max_depth if options.max_depth is None else options.max_depth
        names = check_layers("all", min(depth, _DEEPEST), spectral=True)
        shown = [name for name in names if find(name).is_shown]
        options = argparse.Namespace(**{**vars(options), "layers": shown})
        check_apart(_outputs(options), {"the scene": file})
        for layer in _layer_files(options).values():
            check_replaceable(layer)
    check_spares(_outputs(options), scene)


def _check_outputs(options: argparse.Namespace, scene: Path) -> None:
    from clrt.base.layers import find
    from clrt.images.image import check_writable

    check_writable(options.output, options.exposure, options.bits)
    hidden = [name for name in options.layers if not find(name).is_shown]
    if hidden and not _holds_layers(options.output):
        raise ClrtError(f"{options.output}: --layers {hidden[0]} needs an .exr, which alone holds them")
    check_apart(_outputs(options), {"the scene": scene})
    for file in _layer_files(options).values():
        check_replaceable(file)
    if options.stats:
        check_replaceable(options.stats)


def _holds_layers(output: str) -> bool:
    return Path(output).suffix.lower() == ".exr"
