"""What a picture says of how it was made: `Image.stats` and `Image.metadata`."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from clrt.device.settings import Settings
from clrt.engine.wavefront import RayCounts
from clrt.flatten.flatten import FlatScene, bands_of
from clrt.scene.scene import Scene
from clrt.version import __version__


def stats(counts: RayCounts, local_size: int, seconds: dict[str, float], device: str) -> dict[str, Any]:
    """Rays by kind and generation, the seconds of each kernel, and the device's name."""
    return {
        **counts.table(),
        "seconds": seconds,
        "traced": counts.traced,
        "device": device,
        "local_size": local_size,
    }


def metadata(kernels: str, device: str, settings: Settings, flat: FlatScene) -> dict[str, str]:
    """What a file of the picture carries. kernels: the hash of their source."""
    shown = {name: value for name, value in asdict(settings).items() if name != "limits"}
    return {
        "scene_hash": flat.hash,
        "kernel_hash": kernels,
        "device": device,
        "version": __version__,
        "settings": ", ".join(f"{name}={value}" for name, value in shown.items()),
    }


def wavelengths(scene: Scene) -> tuple[float, ...]:
    """The middles (nm) of a scene's bands, as an Image has them; none in RGB mode."""
    bands = bands_of(scene)
    return () if bands is None else tuple(bands.midpoints.tolist())
