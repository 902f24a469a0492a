"""A spectral scene as scenes in RGB whose three channels are bands of it, and their pictures as its own.

Programs that know three colours, and indices of refraction without dispersion, can so render it band by band.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import numpy as np

from clrt.scene.scene import Checker, Material, Scene
from clrt.spectra.indices import Conductor

from .oracle64.camera import background_image
from .oracle64.palette import Palette
from .types import OracleImage

Triple = tuple[int, int, int]
_REFLECTANCES = ("highlight_color", "reflection_color", "transmission_color")


def at_bands(scene: Scene, bands: Triple) -> Scene:
    """The scene in RGB mode, its channels these bands: numbers in place of all spectra, and of the name of a
    background image the image itself, (h, w, 3).

    ValueError for what `not_by_wavelength` names, and where bands that are not the same would need a
    metal or an index of refraction of their own (see `triples`).
    """
    reason = not_by_wavelength(scene)
    if reason is not None:
        raise ValueError(reason)
    palette, picked = Palette.of(scene), np.array(bands)

    def literal(values: np.ndarray) -> tuple[float, ...]:
        return tuple(float(value) for value in values[picked])

    def material(old: Material) -> Material:
        return _material(old, palette, picked, literal)

    other = copy.copy(scene)
    changes: dict[str, Any] = {name: literal(palette.light(getattr(scene, name)))
                               for name in ("ambient", "depth_color")}  # fmt: skip
    image = background_image(scene)
    changes["background"] = (
        literal(palette.light(scene.background)) if image is None else palette.light_image(image)[..., picked]
    )
    changes["materials"] = {name: material(old) for name, old in scene.materials.items()}
    changes["shapes"] = tuple(
        msgspec.structs.replace(shape, material=material(scene.material_of(shape))) for shape in scene.shapes
    )
    changes["lights"] = tuple(
        msgspec.structs.replace(light, intensity=literal(palette.light(light.intensity)))
        for light in scene.lights
    )
    for name, value in (changes | {"spectrum": None}).items():
        msgspec.structs.force_setattr(other, name, value)
    return other


def _material(
    old: Material, palette: Palette, picked: np.ndarray, literal: Callable[[np.ndarray], Any]
) -> Material:
    changes: dict[str, Any] = {name: literal(palette.reflectance(getattr(old, name)))
                               for name in _REFLECTANCES}  # fmt: skip
    color = old.color
    if isinstance(color, Checker):
        first, second = (literal(palette.reflectance(value)) for value in color.colors)
        changes["color"] = msgspec.structs.replace(color, colors=(first, second))
    else:
        changes["color"] = literal(palette.reflectance(color))
    changes["emission"] = literal(palette.light(old.emission))
    changes["absorption"] = literal(palette.curve(old.absorption))
    changes["ior"] = _one(palette.index(old.ior)[palette.group_of[picked]], "an index of refraction")
    if old.conductor is not None:
        index = _one(palette.metal(old.conductor)[picked], "a metal")
        changes["conductor"] = Conductor(eta=float(index.real), k=float(index.imag))
    return msgspec.structs.replace(old, **changes)


def _one(values: np.ndarray, noun: str) -> Any:
    if (values != values[0]).any():
        raise ValueError(f"{noun} is not the same in all three bands")
    return values[0].item()


def not_by_wavelength(scene: Scene) -> str | None:
    """Why a scene has no scenes in RGB for its bands; None where it has."""
    if scene.spectrum is None:
        return "the scene is in RGB"
    if scene.spectrum.response != "cie":
        return "the thesis program's colours are no sums over rays"
    return None


def triples(scene: Scene) -> Iterator[Triple]:
    """Bands to render together: all are among them, one at a time where metals and dispersion need that."""
    assert scene.spectrum is not None
    count = scene.spectrum.bands
    used = [scene.material_of(shape) for shape in scene.shapes]
    if any(m.conductor is not None or m.dispersive for m in used):
        yield from ((band, band, band) for band in range(count))
    else:
        last = count - 1
        yield from ((band, min(band + 1, last), min(band + 2, last)) for band in range(0, count, 3))


def joined(scene: Scene, pictures: list[tuple[Triple, OracleImage]]) -> OracleImage:
    """The spectral picture of pictures whose channels are these bands of it."""
    palette = Palette.of(scene)
    first = pictures[0][1]

    def developed(parts: list[np.ndarray | None]) -> np.ndarray:
        bands = np.zeros((*first.pixels.shape[:2], palette.bands))
        for (picked, _), part in zip(pictures, parts, strict=True):
            if part is not None:
                bands[..., list(picked)] = part
        return palette.developed(bands)

    keys = sorted({key for _, picture in pictures for key in picture.by_ray})
    by_ray = {key: developed([picture.by_ray.get(key) for _, picture in pictures]) for key in keys}
    pixels = developed([picture.pixels for _, picture in pictures])
    seconds = sum(picture.seconds for _, picture in pictures)
    return OracleImage(pixels, by_ray, first.t, first.shape, f"{first.name} by wavelength", seconds)
