"""Materials and lights as the device reads them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from clrt import layout
from clrt.flatten.images import Pictures, TextureTable
from clrt.scene.arealights import AreaLight
from clrt.scene.lights import (
    DirectionalLight,
    DiskLight,
    Light,
    PointLight,
    RectangleLight,
    SphereLight,
    SpotLight,
)
from clrt.scene.materials import Tint
from clrt.scene.scene import Checker, Disk, ImageTexture, Material, Plane, Polygon, Scene, Shape, Sphere
from clrt.spectra.bands import Bands, conductor, curve, light, reflectance
from clrt.spectra.curves import ior_at

_FLAT = (Plane, Polygon, Disk)
_FRESNEL = {False: "CONSTANT", True: "FRESNEL", "schlick": "SCHLICK"}
_FALLOFF = {"none": "FALLOFF_NONE", "inverse-square": "INVERSE_SQUARE"}


class MaterialTable:
    """The distinct materials of a scene, numbered as they come up."""

    def __init__(self, scene: Scene, bands: Bands | None) -> None:
        self._scene = scene
        self._bands = bands
        self._group = 1 if scene.spectrum is None else scene.spectrum.group
        self._by_identity: dict[
            tuple[int, str], int
        ] = {}  # the scene keeps its materials alive, so an id lasts
        # records Material and Pictured, and what makes a medium of its own
        self._by_value: dict[tuple[bytes, bytes, Material | None], int] = {}
        self._textures = TextureTable(scene)
        self._plain = self._textures.record(Material()).tobytes()
        black = Material(color=0.0, diffuse=0.0)
        self._black = _material(black, "PLAIN", False, self._bands, self._group)

    def number(self, shape: Shape) -> int:
        """The number of this shape's material; equal materials share one."""
        material = self._scene.material_of(shape)
        checker = "PLAIN"
        if isinstance(material.color, Checker):
            checker = "CHECKER_SPHERE" if isinstance(shape, Sphere) else "CHECKER_FLAT"
            assert isinstance(shape, (Sphere, *_FLAT)), "the scene refuses other checkered shapes"
        key = id(material), checker
        if key not in self._by_identity:
            one_sided = self._scene.one_sided == "opaque" and material.kt == 0
            record = _material(material, checker, one_sided, self._bands, self._group).tobytes()
            pictured = self._textures.record(material).tobytes() if material.pictures else self._plain
            medium = material if material.kt > 0 and not material.thin else None
            value = record, pictured, medium
            self._by_identity[key] = self._by_value.setdefault(value, len(self._by_value))
        return self._by_identity[key]

    def glowing(self, source: AreaLight) -> int:
        """The number of what a visible light's surface is made of: black, it sends the radiance."""
        record = self._black.copy()
        record["emission"] = light(source.radiance, self._bands)
        record["light"] = 2 if source.two_sided else 1
        return self._by_value.setdefault((record.tobytes(), self._plain, None), len(self._by_value))

    def records(self) -> np.ndarray:
        """All of them in the order of their numbers, dtype Material."""
        records = b"".join(record for record, _, _ in self._by_value)
        out = np.frombuffer(records, layout.dtype("Material", _count(self._bands))).copy()
        first: dict[Material, int] = {}  # not by records: a checker is laid out by shape
        for number, (_, _, medium) in enumerate(self._by_value):
            if medium is not None and out["kt"][number] > 0:
                out["medium"][number] = first.setdefault(medium, number)
        return out

    def pictures(
        self, known: Pictures | None
    ) -> tuple[dict[str, np.ndarray], Pictures] | None:
        """The sections of pictures but for those of geometry, and what was read; None where there are none.

        `known` is not read again. Raises as `clrt.read_image`, LimitError where they are too large together.
        """
        records = b"".join(pictures for _, pictures, _ in self._by_value)
        pictured = np.frombuffer(records, layout.dtype("Pictured")).copy()
        if not shows_pictures(pictured).any():
            return None
        sections, pictures = self._textures.sections(known, self._bands)
        there = [(pictured[name] >= 0).any() for name in layout.PICTURES]
        sections["primaries"]["shown"] = sum(1 << number for number, any_ in enumerate(there) if any_)
        return sections | {"pictured": pictured}, pictures


def _material(
    material: Material, checker: str, one_sided: bool, bands: Bands | None, group: int
) -> np.ndarray:
    out = np.zeros(1, layout.dtype("Material", _count(bands)))
    record = out[0]
    for field, name in layout.COEFFICIENTS.items():
        record[field] = getattr(material, name)
    record["ior"] = material.ior_d
    record["fresnel"] = layout.FRESNEL[_FRESNEL[material.fresnel]]
    record["thin"] = material.thin
    record["alpha"] = material.alpha
    record["one_sided"] = one_sided
    record["checker"] = layout.CHECKER[checker]
    record["medium"], record["priority"] = -1, material.priority
    first = second = material.color
    if isinstance(material.color, Checker):
        first, second = material.color.colors
        record["checker_size"] = (
            material.color.divisions if checker == "CHECKER_SPHERE" else material.color.size
        )
    assert not isinstance(first, Checker) and not isinstance(second, Checker)
    record["color"], record["color2"] = _reflectance(first, bands), _reflectance(second, bands)
    record["highlight"] = _reflectance(material.highlight_color, bands)
    record["mirror"] = _reflectance(material.reflection_color, bands)
    record["tint"] = _reflectance(material.transmission_color, bands)
    if not isinstance(material.emission, ImageTexture):
        record["emission"] = light(material.emission, bands)
    record["absorption"] = curve(material.absorption, bands)
    if material.conductor is not None:
        record["fresnel"] = layout.FRESNEL["CONDUCTOR"]
        record["eta"], record["k"] = conductor(material.conductor, bands)
    record["dispersive"] = bands is not None and material.dispersive
    record["band_ior"] = material.ior_d if bands is None else _band_ior(material, bands, group)
    return out


def _reflectance(value: Tint, bands: Bands | None) -> np.ndarray:
    """A colour's bands; 1 in place of a picture, which kernels look up."""
    return reflectance(1.0 if isinstance(value, ImageTexture) else value, bands)


def shows_pictures(pictured: np.ndarray) -> np.ndarray:
    """Of each record Pictured whether it has any."""
    return np.any([pictured[name] >= 0 for name in (*layout.PICTURES, "normal_map")], axis=0)


def _band_ior(material: Material, bands: Bands, group: int) -> np.ndarray:
    """For each band the index of refraction in the middle of its dispersion group."""
    first = np.arange(bands.n) // group * group
    centers = (bands.edges[first] + bands.edges[np.minimum(first + group, bands.n)]) / 2
    return ior_at(material.ior, centers)


def _count(bands: Bands | None) -> int:
    return layout.BANDS if bands is None else bands.n


def flatten_lights(scene: Scene, bands: Bands | None) -> np.ndarray:
    """One record for each light of the scene, dtype Light."""
    out = np.zeros(len(scene.lights), layout.dtype("Light", _count(bands)))
    for record, source in zip(out, scene.lights, strict=True):
        kind, fill = _LIGHTS[type(source)]
        record["kind"] = (layout.LIGHT_KINDS | layout.EXTENDED_KINDS)[kind]
        record["samples"], record["surface"] = 1, -1
        record["intensity"] = light(source.intensity, bands)
        fill(record, source)
    return out


def _point(record: np.void, source: PointLight | SpotLight) -> None:
    record["place"][:3] = source.position
    record["falloff"] = layout.FALLOFF[_FALLOFF[source.falloff]]


def _directional(record: np.void, source: DirectionalLight) -> None:
    record["place"][:3] = -_unit(source.direction)


def _spot(record: np.void, source: SpotLight) -> None:
    _point(record, source)
    record["axis"][:3] = _unit(np.subtract(source.target, source.position))
    record["angle"] = math.radians(source.angle)
    record["width"] = math.radians(source.angle * source.penumbra)


def _rectangle(record: np.void, source: RectangleLight) -> None:
    _area(record, source)
    record["axis"][:3] = _unit(source.normal)
    record["u"][:3], record["v"][:3] = source.u, source.v
    record["share"] = source.area / (math.pi * source.samples)


def _disk(record: np.void, source: DiskLight) -> None:
    _area(record, source)
    x, y, z = normal = _unit(source.normal)
    record["axis"][:3] = normal
    sign = -1.0 if z < 0 else 1.0  # the frame about the normal, as in kernels/frame.clh
    a = -1 / (sign + z)
    record["u"][:3] = source.radius * np.array([1 + sign * x * x * a, sign * x * y * a, -sign * x])
    record["v"][:3] = source.radius * np.array([x * y * a, sign + y * y * a, -y])
    record["share"] = source.area / (math.pi * source.samples)


def _sphere(record: np.void, source: SphereLight) -> None:
    _area(record, source)
    record["radius"] = source.radius


def _area(record: np.void, source: RectangleLight | DiskLight | SphereLight) -> None:
    record["place"][:3] = source.center
    record["samples"], record["extended"] = source.samples, 1
    record["two_sided"] = source.two_sided


def _unit(way: Any) -> np.ndarray:
    """A way of any length but 0, as (3,) float64 of length 1."""
    return np.asarray(way, np.float64) / np.linalg.norm(way)


# class of a scene's lights -> the kernels' kind, and what fills in a record's other fields
_LIGHTS: Final[dict[type[Light], tuple[str, Callable[[np.void, Any], None]]]] = {
    PointLight: ("POINT", _point),
    DirectionalLight: ("DIRECTIONAL", _directional),
    SpotLight: ("SPOT", _spot),
    RectangleLight: ("RECTANGLE", _rectangle),
    DiskLight: ("DISK", _disk),
    SphereLight: ("SPHERE", _sphere),
}
