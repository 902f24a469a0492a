"""What a picture says of how it was made: `Image.stats` and `Image.metadata`."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from clrt.device.device import Device
from clrt.engine.wavefront import RayCounts
from clrt.flatten.flatten import FlatScene
from clrt.version import __version__


def stats(device: Device, counts: RayCounts, local_size: int) -> dict[str, Any]:
    """Rays by kind and generation, and the device's seconds since they were last taken."""
    return {
        **counts.table(),
        "seconds": device.driver.take_seconds(),
        "traced": counts.traced,
        "device": device.info.label,
        "local_size": local_size,
    }


def metadata(device: Device, flat: FlatScene) -> dict[str, str]:
    """What a file of the picture carries."""
    settings = {name: value for name, value in asdict(device.settings).items() if name != "limits"}
    return {
        "scene_hash": flat.hash,
        "kernel_hash": device.kernels.hash,
        "device": device.info.label,
        "version": __version__,
        "settings": ", ".join(f"{name}={value}" for name, value in settings.items()),
    }
