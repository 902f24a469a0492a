"""Write the pictures that lie on surfaces of the scenes: wood.png, tiles.png, tile-normals.png, globe.png.

All are made of noise that a whole-number hash gives, so nothing of them comes from elsewhere. wood, tiles and
their normals go on beyond their edges; the globe maps no place: longitude to the right, north on top.

    python scenes/generate_textures.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
from numpy.typing import NDArray

Array = NDArray[np.float64]


def hashed(x: NDArray[np.int64], y: NDArray[np.int64], z: NDArray[np.int64], seed: int) -> Array:
    """A number in [0, 1) for each point of a lattice."""
    h = (x * 374761393 + y * 668265263 + z * 2147483647 + seed * 144269) & 0xFFFFFFFF
    h = ((h ^ (h >> 13)) * 1274126177) & 0xFFFFFFFF
    return ((h ^ (h >> 16)) & 0xFFFFFF) / float(1 << 24)


def noise(x: Array, y: Array, z: Array, seed: int, period: int = 1 << 20) -> Array:
    """Smooth noise in [0, 1) with one bump a unit; it repeats in x and y after `period` units."""
    cells = [np.floor(a).astype(np.int64) for a in (x, y, z)]
    parts = [a - cell for a, cell in zip((x, y, z), cells, strict=True)]
    fades = [t * t * t * (t * (t * 6 - 15) + 10) for t in parts]
    out = np.zeros(np.broadcast(x, y, z).shape)
    for corner in range(8):
        steps = [corner >> axis & 1 for axis in range(3)]
        weight = np.ones(out.shape)
        for fade, step in zip(fades, steps, strict=True):
            weight = weight * (fade if step else 1 - fade)
        at = [cell + step for cell, step in zip(cells, steps, strict=True)]
        out += weight * hashed(at[0] % period, at[1] % period, at[2], seed)
    return out


def fractal(x: Array, y: Array, z: Array, seed: int, octaves: int, period: int = 1 << 20) -> Array:
    """Octaves of noise, each half as strong and twice as fine; about 0, mostly within +-0.5."""
    total = np.zeros(np.broadcast(x, y, z).shape)
    for octave in range(octaves):
        scale = 1 << octave
        part = noise(x * scale, y * scale, z * scale, seed + octave, period * scale)
        total += (part - 0.5) / scale
    return total


def mixed(a: Array, b: Array, share: Array) -> Array:
    """From colours a to colours b."""
    return a + (b - a) * np.clip(share, 0.0, 1.0)[..., None]


def grid(width: int, height: int) -> tuple[Array, Array]:
    """u and v of the middles of pixels (height, width)."""
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    return u, v


def wood(width: int = 512, height: int = 512) -> Array:
    """Four planks side by side, their grain along v; sRGB (height, width, 3) in [0, 1]."""
    u, v = grid(width, height)
    plank = np.floor(u * 4)
    across, zero = u * 4 - plank, np.zeros_like(u)
    drift = fractal(u * 8, v * 2, plank * 7.3, 3, 3, 8) * 0.9
    number, none = plank.astype(np.int64), np.zeros(plank.shape, np.int64)
    rings = (across - 0.35 - 0.3 * hashed(number, none, none, 5)) * 4.5 + drift
    ring = np.abs(np.mod(np.abs(rings), 1.0) * 2 - 1) ** 1.6
    fibre = fractal(u * 128, v * 4, zero + 2.5, 11, 3, 128)
    light, dark = np.array([0.80, 0.58, 0.36]), np.array([0.52, 0.31, 0.16])
    color = mixed(np.broadcast_to(light, (*u.shape, 3)), dark, 0.75 * ring + 0.55 * fibre)
    tone = 0.88 + 0.22 * hashed(number, none + 1, none, 9)
    seam = np.minimum(across, 1 - across) * (width / 4)  # pixels to the next plank
    return color * tone[..., None] * (1 - 0.75 * np.clip(1.6 - seam, 0, 1))[..., None]


def tile_heights(width: int, height: int) -> tuple[Array, Array]:
    """How high tiles stand over their joints, 0 to 1, and which of 4 x 4 it is."""
    u, v = grid(width, height)
    x, y = np.mod(u * 4, 1.0), np.mod(v * 4, 1.0)
    edge = np.minimum(np.minimum(x, 1 - x), np.minimum(y, 1 - y))
    high = np.clip((edge - 0.02) / 0.05, 0.0, 1.0)
    return high * high * (3 - 2 * high), np.floor(u * 4) + 4 * np.floor(v * 4)


def tiles(width: int = 256, height: int = 256) -> Array:
    """Glazed tiles in two blues and white, their joints grey; sRGB."""
    u, v = grid(width, height)
    high, number = tile_heights(width, height)
    cell = number.astype(np.int64)
    tone = hashed(cell, 0 * cell, 0 * cell, 21)
    glaze = fractal(u * 16, v * 16, np.zeros_like(u), 31, 3, 16)
    x, y = np.mod(u * 4, 1.0) - 0.5, np.mod(v * 4, 1.0) - 0.5
    flower = np.hypot(x, y) - 0.22 * (1 + 0.35 * np.cos(4 * np.arctan2(y, x)))
    white, blue = np.array([0.90, 0.89, 0.84]), np.array([0.10, 0.27, 0.52])
    odd = np.mod(np.floor(u * 4) + np.floor(v * 4), 2) == 1
    pattern = np.clip(flower * width / 4 + 0.5, 0, 1)  # 1 outside of the flower
    share = np.where(odd, 1 - pattern, pattern)
    color = mixed(np.broadcast_to(blue, (*u.shape, 3)), white, share)
    color = color * (0.94 + 0.08 * tone + 0.10 * glaze)[..., None]
    return mixed(np.broadcast_to([0.46, 0.45, 0.43], color.shape), color, high)


def tile_normals(width: int = 256, height: int = 256) -> Array:
    """The normals of the same tiles, rounded at their edges, as a map with green up in the picture."""
    high, number = tile_heights(width, height)
    u, v = grid(width, height)
    bumps = 5.0 * high + 0.6 * fractal(u * 8, v * 8, number * 3.7, 41, 2, 8)
    slope_x = (np.roll(bumps, -1, axis=1) - np.roll(bumps, 1, axis=1)) / 2
    slope_y = (np.roll(bumps, -1, axis=0) - np.roll(bumps, 1, axis=0)) / 2
    normal = np.stack([-slope_x, slope_y, np.ones_like(bumps)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    return (normal * 127 + 128) / 255


def globe(width: int = 1024, height: int = 512) -> Array:
    """Seas, coasts, woods, deserts, mountains, ice and clouds of a planet that there is not; sRGB."""
    u, v = grid(width, height)
    phi, theta = 2 * np.pi * u, np.pi * v
    x, y, z = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
    far = 10.0  # away from the lattice's origin
    land = fractal(1.7 * x + far, 1.7 * y + far, 1.7 * z + far, 75, 7) + 0.06 * np.cos(3 * phi) - 0.02
    dry = fractal(2.3 * x + far, 2.3 * y + far, 2.3 * z + far, 91, 5)
    cloud = fractal(2.6 * x + far + 0.9 * dry, 2.6 * y + far, 5.2 * z + far, 57, 7)
    latitude = np.abs(z) + 0.10 * dry
    deep, shallow = np.array([0.03, 0.12, 0.32]), np.array([0.10, 0.42, 0.58])
    sea = mixed(np.broadcast_to(deep, (*u.shape, 3)), shallow, np.exp(np.minimum(land, 0.0) * 14))
    green, sand = np.array([0.16, 0.40, 0.14]), np.array([0.78, 0.66, 0.42])
    rock, ice, white = np.array([0.45, 0.38, 0.31]), np.array([0.93, 0.95, 0.97]), np.full(3, 0.97)
    ground = mixed(np.broadcast_to(green, sea.shape), sand, 4.5 * dry + 0.7 - 2.2 * np.abs(latitude - 0.38))
    ground = mixed(ground, rock, (land - 0.20) * 7)
    ground = ground * (0.9 + 0.5 * dry)[..., None]
    color = mixed(sea, ground, land * 70 + 0.5)
    color = mixed(color, ice, (latitude - 0.86 + 0.5 * land) * 22)
    return mixed(color, white, (cloud - 0.12) * 3.4)


PICTURES = {"wood": wood, "tiles": tiles, "tile-normals": tile_normals, "globe": globe}


def main(folder: Path) -> None:
    """Write all of them."""
    for name, make in PICTURES.items():
        pixels = np.floor(np.clip(make(), 0, 1) * 255 + 0.5).astype(np.uint8)
        height, width, channels = pixels.shape
        output = oiio.ImageOutput.create("png")
        spec = oiio.ImageSpec(width, height, channels, "uint8")
        spec.attribute("png:compressionLevel", 9)
        assert output.open(str(folder / f"{name}.png"), spec) and output.write_image(pixels)
        output.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
