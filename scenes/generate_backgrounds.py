"""Write the lat-long background images that the scenes use: sky.exr, studio.exr, underwater.exr.

A lat-long image has its centre towards -z, +y up and u to the right; all values are linear Rec.709 radiance.
The images are smooth, so that half floats in a zip-compressed EXR stay small.

    python scenes/generate_backgrounds.py [FOLDER]
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
from numpy.typing import NDArray

Array = NDArray[np.float64]
Colour = tuple[float, float, float]


def directions(width: int, height: int) -> Array:
    """Unit directions of the pixel centres of a lat-long image, shape (height, width, 3)."""
    longitude = ((np.arange(width) + 0.5) / width - 0.5) * 2.0 * np.pi
    colatitude = (np.arange(height) + 0.5) / height * np.pi
    phi, theta = np.meshgrid(longitude, colatitude)
    return np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)], axis=-1)


def smoothstep(low: float, high: float, x: Array) -> Array:
    """Hermite step from 0 at `low` to 1 at `high`."""
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def gradient(x: Array, stops: list[tuple[float, Colour]]) -> Array:
    """Piecewise linear colours over `x` (ascending stops), shape x.shape + (3,)."""
    positions = [position for position, _ in stops]
    return np.stack([np.interp(x, positions, [colour[k] for _, colour in stops]) for k in range(3)], axis=-1)


def lobe(d: Array, towards: Colour, sharpness: float) -> Array:
    """A glow around a direction, 1 at its centre: exp(sharpness (cos - 1))."""
    axis = np.asarray(towards) / np.linalg.norm(towards)
    return np.exp(sharpness * (d @ axis - 1.0))


def softbox(d: Array, towards: Colour, half_width: float, half_height: float, feather: float) -> Array:
    """A rectangular lamp with soft edges; half sides in tangents of angles seen from the origin."""
    axis = np.asarray(towards) / np.linalg.norm(towards)
    right = np.cross(axis, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    along = d @ axis
    facing = np.maximum(along, 1e-6)
    x, y = np.abs(d @ right) / facing, np.abs(d @ np.cross(right, axis)) / facing
    inside = 1.0 - smoothstep(half_width - feather, half_width + feather, x)
    inside = inside * (1.0 - smoothstep(half_height - feather, half_height + feather, y))
    return np.where(along > 0.0, inside, 0.0)


def sky(width: int = 256, height: int = 128) -> Array:
    """A clear afternoon: blue zenith, pale horizon, a warm glow around the sun, soft bands of cloud."""
    d = directions(width, height)
    up = d[..., 1]
    image = gradient(
        up,
        [
            (-1.0, (0.16, 0.14, 0.12)),
            (-0.08, (0.34, 0.31, 0.28)),
            (0.0, (0.72, 0.78, 0.84)),
            (0.12, (0.46, 0.64, 0.86)),
            (0.45, (0.20, 0.40, 0.75)),
            (1.0, (0.08, 0.20, 0.50)),
        ],
    )
    longitude = np.arctan2(d[..., 0], -d[..., 2])
    wave = np.sin(3.0 * longitude + 9.0 * up) + np.sin(5.0 * longitude - 14.0 * up + 1.0)
    wave = wave + 0.6 * np.sin(11.0 * longitude + 23.0 * up + 2.0)
    cloud = smoothstep(0.3, 1.9, wave) * smoothstep(0.06, 0.2, up) * (1.0 - smoothstep(0.4, 0.75, up))
    image += cloud[..., None] * (np.array([0.92, 0.92, 0.94]) - image) * 0.65
    sun = (0.70, 0.60, 0.55)
    image += lobe(d, sun, 8.0)[..., None] * np.array([0.30, 0.22, 0.10])
    return image + lobe(d, sun, 400.0)[..., None] * np.array([3.0, 2.7, 2.0])


def studio(width: int = 384, height: int = 192) -> Array:
    """A photographer's backdrop, amber at the horizon and petrol above, with soft boxes around the camera."""
    d = directions(width, height)
    up = d[..., 1]
    behind = gradient(
        up,
        [
            (-1.0, (0.020, 0.026, 0.032)),
            (-0.35, (0.030, 0.045, 0.055)),
            (-0.20, (0.20, 0.115, 0.065)),
            (-0.13, (0.52, 0.27, 0.12)),
            (-0.07, (0.36, 0.22, 0.135)),
            (0.0, (0.125, 0.150, 0.150)),
            (0.08, (0.050, 0.115, 0.145)),
            (0.30, (0.030, 0.095, 0.125)),
            (1.0, (0.014, 0.045, 0.070)),
        ],
    )
    away = 0.45 + 0.55 * smoothstep(-0.6, 0.9, -d[..., 2])
    image = behind * away[..., None]
    image += lobe(d, (0.28, -0.13, -1.0), 40.0)[..., None] * np.array([0.36, 0.17, 0.06])
    image += softbox(d, (-0.9, 0.85, 0.55), 0.55, 0.36, 0.05)[..., None] * np.array([1.12, 1.02, 0.90])
    image += softbox(d, (1.0, 0.55, 0.35), 0.16, 0.62, 0.04)[..., None] * np.array([0.85, 1.35, 1.75])
    return image + softbox(d, (0.05, 1.0, -0.35), 0.70, 0.22, 0.06)[..., None] * np.array([1.05, 1.02, 1.0])


def underwater(width: int = 128, height: int = 64) -> Array:
    """Sunlit sea from below: bright overhead, turquoise around, deep blue downwards."""
    d = directions(width, height)
    image = gradient(
        d[..., 1],
        [
            (-1.0, (0.004, 0.040, 0.070)),
            (-0.1, (0.010, 0.110, 0.170)),
            (0.15, (0.020, 0.210, 0.290)),
            (0.55, (0.085, 0.430, 0.500)),
            (0.85, (0.360, 0.760, 0.780)),
            (1.0, (0.760, 0.940, 0.900)),
        ],
    )
    return image + lobe(d, (-0.25, 1.0, -0.35), 40.0)[..., None] * np.array([0.5, 0.5, 0.42])


BACKGROUNDS: dict[str, Callable[[], Array]] = {"sky": sky, "studio": studio, "underwater": underwater}


def write(folder: Path) -> None:
    """Write every background as NAME.exr into `folder`."""
    for name, make in BACKGROUNDS.items():
        pixels = np.ascontiguousarray(make(), dtype=np.float32)
        spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], 3, "half")
        spec.attribute("compression", "zip")
        path = str(folder / f"{name}.exr")
        output = oiio.ImageOutput.create(path)
        if not (output and output.open(path, spec) and output.write_image(pixels) and output.close()):
            raise SystemExit(f"{path}: {oiio.geterror()}")


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
