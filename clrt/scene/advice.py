"""What joins a scene's parts: spectra within its range (else an error), and what is probably not meant."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import chain
from typing import TYPE_CHECKING, Any

from clrt.base import notices
from clrt.base.errors import show
from clrt.base.places import At
from clrt.scene.arealights import AreaLight
from clrt.scene.materials import Checker, ImageTexture, Material
from clrt.spectra.colors import color_fields
from clrt.spectra.curves import D_LINE, curve_of
from clrt.spectra.spectrum import Spectrum

if TYPE_CHECKING:
    from clrt.scene.scene import Scene

_BYTES = "are these numbers from 0 to 255? They go from 0 to 1, linear: sRGB's v is (v / 255) ** 2.2"
_LARGE = 32  # a whole number from which on a colour looks like one of bytes
_RETURNED = ("color", "colors", "reflection_color", "transmission_color")
"""Fields of a material that say what share of the light a surface returns."""


def check_lines(scene: Scene) -> None:
    """Raise for a spectral line outside the scene's range, which no band would hold."""
    if scene.spectrum is None:
        return
    low, high = scene.spectrum.range
    for place, key, value in colors(scene):
        line = value.line if isinstance(value, Spectrum) else None
        if line is not None and not low <= line <= high:
            raise _at(place, key).key("line").error(line, f"the scene's light has {low:g} to {high:g} nm")


def colors(scene: Scene) -> Iterator[tuple[At, str | int, Any]]:
    """Every colour and spectrum of a scene: the table that holds it, and its key there (`_at` joins them)."""
    at = At(scene.source)
    tables: list[tuple[At, Any]] = [(at, scene)]
    tables += [(at.key("lights").item(i), light) for i, light in enumerate(scene.lights)]
    for place, table in tables + list(materials(scene)):
        for name in color_fields(table.__class__):
            value = getattr(table, name)
            if isinstance(value, Checker):
                for i, color in enumerate(value.colors):
                    yield place.key(name).key("colors"), i, color
            elif not isinstance(value, ImageTexture):
                yield place, name, value


def _at(place: At, key: str | int) -> At:
    return place.item(key) if isinstance(key, int) else place.key(key)


def materials(scene: Scene) -> Iterator[tuple[At, Material]]:
    """The materials by name, and those that shapes have of their own."""
    named, shapes = At(scene.source, "materials"), At(scene.source, "shapes")
    for name, material in scene.materials.items():
        yield named.key(name), material
    for i, shape in enumerate(scene.shapes):
        if isinstance(shape.material, Material):
            yield shapes.item(i).key("material"), shape.material


def warn(scene: Scene) -> None:
    """Warn, once each, of what is allowed but probably not meant."""
    for kind in (
        _makes_light, _open_glass, _lit_twice, _rough_matte, _too_bright, _of_bytes, _unlit, _undispersed,
    ):  # fmt: skip
        found = kind(scene)
        if found:
            notices.warn(scene.source, *found)


def _makes_light(scene: Scene) -> tuple[str, str] | None:
    bright = _first(scene, lambda material: material.returned > 1 + 1e-6)
    if bright is None:
        return None
    index, material = bright
    text = f"diffuse + max(specular, reflection) + transmission is {material.returned:.4g}"
    return f"shapes[{index}]", f"{text}; above 1 a surface makes light"


def _open_glass(scene: Scene) -> tuple[str, str] | None:
    sheet = _first(scene, lambda material: material.kt > 0 and not material.thin, only_open=True)
    if sheet is None:
        return None
    kind = scene.shapes[sheet[0]].type
    text = f"an open {kind} transmits but encloses nothing; a sheet of glass has thin = true"
    return f"shapes[{sheet[0]}]", text


def _lit_twice(scene: Scene) -> tuple[str, str] | None:
    """Light behind glass that feelers go through, and that ambient rays then meet."""
    if scene.shadow != "tinted" or not scene.ambient_samples:
        return None
    if not any(isinstance(light, AreaLight) and light.visible for light in scene.lights):
        return None
    if _first(scene, lambda material: material.kt > 0) is None:
        return None
    text = "tinted feelers and ambient rays both count the light of visible lights behind what transmits"
    return "shadow", f"{text}; let the lights be not visible, or shadow be 'opaque'"


def _rough_matte(scene: Scene) -> tuple[str, str] | None:
    """Roughness of what has no reflections to blur."""
    for place, material in materials(scene):
        if material.roughness > 0 and material.kr == 0:
            text = f"{material.roughness:g} blurs reflections, of which it has none"
            return place.key("roughness").path, f"{text}; set reflection, fresnel or conductor, too"
    return None


def _first(
    scene: Scene, wanted: Callable[[Material], bool], only_open: bool = False
) -> tuple[int, Material] | None:
    """The first shape whose material is `wanted`, which is asked once a material."""
    known: dict[int, bool] = {}
    for index, shape in enumerate(scene.shapes):
        material = scene.material_of(shape)
        answer = known.get(id(material))
        if answer is None:
            answer = known[id(material)] = wanted(material)
        if answer and (shape.is_open or not only_open):
            return index, material
    return None


def _too_bright(scene: Scene) -> tuple[str, str] | None:
    for place, key, value in colors(scene):
        if value.__class__ is float and value <= 1:  # most of many materials
            continue
        if (key if isinstance(key, str) else place.name) not in _RETURNED:
            continue
        most = _peak(value)
        if most > 1 + 1e-6:
            hint = f"; {_BYTES}" if _in_bytes(value) else ""
            return _at(place, key).path, f"a reflectance of {most:.4g}; above 1 a surface makes light{hint}"
    return None


def _peak(color: Any) -> float:
    """The largest value of a colour or spectrum."""
    if isinstance(color, (int, float)):
        return float(color)
    if isinstance(color, tuple):
        return float(max(color))
    if isinstance(color, Spectrum) and color.samples is not None:
        return max(value for _, value in color.samples) * color.scale
    if isinstance(color, Spectrum) and any(
        kind is not None for kind in (color.gaussian, color.band, color.line)
    ):
        return color.scale
    return float(curve_of(color).values.max())


def _of_bytes(scene: Scene) -> tuple[str, str] | None:
    """Light in numbers from 0 to 255; but light that fades with the distance is strong where it starts."""
    at = At(scene.source)
    light = [(at, name, getattr(scene, name)) for name in ("background", "ambient", "depth_color")]
    for i, one in enumerate(scene.lights):
        if one.falloff != "inverse-square":
            light.append((at.key("lights").item(i), "intensity", one.intensity))
    glowing = ((place, "emission", material.emission) for place, material in materials(scene))
    for place, key, value in chain(light, glowing):
        if _in_bytes(value):
            text = f"{show(value)} is {_peak(value):g} times the light of white; {_BYTES}"
            return place.key(key).path, text
    return None


def _in_bytes(value: Any) -> bool:
    """Whether a colour looks like one of bytes: whole numbers up to 255, one of them large."""
    if isinstance(value, (str, Spectrum, Checker, ImageTexture)):
        return False
    numbers = value if isinstance(value, (tuple, list)) else (value,)
    return _LARGE <= max(numbers) <= 255 and all(float(number).is_integer() for number in numbers)


def _unlit(scene: Scene) -> tuple[str, str] | None:
    """A picture of surfaces on which no light falls."""
    intensities = (one.intensity for one in scene.lights)
    emissions = (material.emission for _, material in materials(scene))
    light = chain((scene.ambient,), intensities, emissions)
    named = (str, Spectrum, ImageTexture)
    if scene.camera is None or any(isinstance(value, named) or _peak(value) > 0 for value in light):
        return None
    black = _first(scene, _is_black)
    if black is None:
        return None
    text = "there is no light: no lights, no ambient, no emission; it is black. Add [[lights]] or ambient"
    return f"shapes[{black[0]}]", text


def _is_black(material: Material) -> bool:
    """Whether a surface shows nothing where no light falls on it."""
    return material.kr == 0 and material.kt == 0 and material.conductor is None


def _undispersed(scene: Scene) -> tuple[str, str] | None:
    if scene.spectrum is not None:
        return None
    for place, material in materials(scene):
        if material.dispersive and material.kt > 0:
            text = f"without [spectrum] its one index is that at {D_LINE:.2f} nm, {material.ior_d:.6g}"
            return place.key("ior").path, text
    return None
