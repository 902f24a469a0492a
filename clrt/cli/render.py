"""`clrt render`: load, render with progress, save; whatever happens, no file is half-written."""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from clrt.atomic import check_replaceable, replacing
from clrt.cli import INTERRUPTED, say
from clrt.errors import ClrtError
from clrt.resources import scene_file

if TYPE_CHECKING:
    from clrt.image import Image


def run(options: argparse.Namespace) -> int:
    """Render `options.scene` to `options.output`. ClrtError, before rendering, when it cannot be saved."""
    saved: list[Path] = []
    try:
        file = scene_file(options.scene)
        _check_outputs(options)
        start = time.perf_counter()
        image = render(file, options, layers=options.layers)
        seconds = time.perf_counter() - start
        saved.append(image.save(options.output, options.exposure, options.bits))
        beside = []
        if image.layers and not _holds_layers(options.output):
            beside = image.save_layers(options.output, options.exposure, options.bits)
            saved += beside
        if options.stats:
            saved.append(_save_stats(image, options.stats))
    except KeyboardInterrupt:
        return say(f"interrupted; {_left_behind(saved, options.checkpoint)}", INTERRUPTED)
    if options.checkpoint:
        Path(options.checkpoint).unlink(missing_ok=True)  # only now: had saving failed, it would be needed
    if not options.quiet:
        print(summary(image, saved[0], seconds))
        if beside:
            print(f"layers: {', '.join(path.name for path in beside)}")
    return 0


def render(file: Path, options: argparse.Namespace, layers: tuple[str, ...] = ()) -> Image:
    """The image of a scene file, with a progress bar on stderr where that is a terminal."""
    import clrt
    from clrt.cli.progress import progress
    from clrt.shipped import load_scene

    limits = clrt.Limits(**dict(options.limit))
    scene = load_scene(file, limits=limits)
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


def _left_behind(saved: list[Path], checkpoint: str | None) -> str:
    if saved:
        return f"saved: {', '.join(map(str, saved))}"
    if checkpoint and Path(checkpoint).exists():
        return f"{checkpoint} holds what is finished: the same command goes on from there"
    return "nothing was saved"


def summary(image: Image, path: Path, seconds: float) -> str:
    """The line after a render: where the picture is, its size, how long and how fast, and on what."""
    rate = image.stats["traced"] / seconds / 1e6
    size = f"{image.width} x {image.height}"
    return f"{path}: {size}, {seconds:.2f} s, {rate:.2f} Mrays/s on {image.stats['device']}"


def _check_outputs(options: argparse.Namespace) -> None:
    from clrt.image import check_writable, layer_file

    check_writable(options.output, options.exposure, options.bits)
    if not _holds_layers(options.output):
        for name in options.layers:
            if name == "bands":
                raise ClrtError(f"{options.output}: --layers bands needs an .exr, which alone holds them")
            if name != "all":
                check_replaceable(layer_file(options.output, name))
    if options.stats:
        if Path(options.stats).resolve() == Path(options.output).resolve():
            raise ClrtError(f"{options.stats}: is the picture's file too; give --stats one of its own")
        check_replaceable(options.stats)
    if options.checkpoint:
        others = [Path(name).resolve() for name in (options.output, options.stats) if name]
        if Path(options.checkpoint).resolve() in others:
            raise ClrtError(f"{options.checkpoint}: is another file's name, too; give --checkpoint its own")


def _holds_layers(output: str) -> bool:
    return Path(output).suffix.lower() == ".exr"


def _save_stats(image: Image, path: str) -> Path:
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(dict(image.stats), indent=2, default=_plain) + "\n")
    return Path(path).resolve()


def _plain(value: Any) -> Any:
    """A numpy number or array as JSON has it."""
    return value.tolist()
