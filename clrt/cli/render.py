"""`clrt render`: load, render with progress, save; whatever happens, no file is half-written."""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from clrt.atomic import check_replaceable, replacing
from clrt.cli import interrupted
from clrt.cli.outputs import check_apart, check_spares
from clrt.errors import ClrtError
from clrt.resources import scene_file

if TYPE_CHECKING:
    from clrt.image import Image


def run(options: argparse.Namespace) -> int:
    """Render `options.scene` to `options.output`. ClrtError, before rendering, when it cannot be saved."""
    try:
        file = scene_file(options.scene)
        _check_outputs(options, file)
        start = time.perf_counter()
        image = render(file, options, layers=options.layers)
        seconds = time.perf_counter() - start
        saved = image.save(options.output, options.exposure, options.bits)
        if options.stats:
            _save_stats(image, options.stats)
        if options.checkpoint:
            Path(options.checkpoint).unlink(missing_ok=True)  # not before: it is needed if saving fails
        if not options.quiet:
            print(summary(image, saved, seconds))
    except KeyboardInterrupt:
        return interrupted(options.checkpoint)
    return 0


def render(file: Path, options: argparse.Namespace, layers: tuple[str, ...] = ()) -> Image:
    """The image of a scene file, with a progress bar on stderr where that is a terminal."""
    import clrt
    from clrt.cli.progress import progress
    from clrt.shipped import load_scene

    limits = clrt.Limits(**dict(options.limit))
    scene = load_scene(file, limits=limits)
    check_spares(_outputs(options), scene)
    with progress(file.stem, getattr(options, "quiet", False)) as report:
        return clrt.render(
            scene,
            width=options.width,
            height=options.height,
            spp=options.spp,
            max_depth=options.max_depth,
            device=options.device,
            layers=layers,
            progress=report,
            settings=clrt.Settings(
                threads=options.threads, limits=limits, check=getattr(options, "check", False)
            ),
            crop=tuple(options.crop) if options.crop else None,
            checkpoint=getattr(options, "checkpoint", None),
        )


def summary(image: Image, path: Path, seconds: float) -> str:
    """The line after a render: where the picture is, its size, how long and how fast, and on what."""
    rate = image.stats["traced"] / seconds / 1e6
    size = f"{image.width} x {image.height}"
    return f"{path}: {size}, {seconds:.2f} s, {rate:.2f} Mrays/s on {image.stats['device']}"


def _outputs(options: argparse.Namespace) -> dict[str, str]:
    """The files that are to be written, by option."""
    given = {name: getattr(options, name, None) for name in ("output", "stats", "checkpoint")}
    return {f"--{name}": path for name, path in given.items() if path}


def _check_outputs(options: argparse.Namespace, scene: Path) -> None:
    from clrt.image import check_writable

    check_apart(_outputs(options), {"the scene": scene})

    bits = check_writable(options.output, options.exposure, options.bits)
    if options.layers and bits != 32:
        raise ClrtError(f"{options.output}: --layers needs an .exr, which alone holds layers")
    if options.stats:
        check_replaceable(options.stats)


def _save_stats(image: Image, path: str) -> None:
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(dict(image.stats), indent=2, default=_plain) + "\n")


def _plain(value: Any) -> Any:
    """A numpy number or array as JSON has it."""
    return value.tolist()
