"""What joins a scene's parts: spectra within its range (else an error), and what is probably not meant."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from clrt import notices
from clrt.colors import color_fields
from clrt.curves import D_LINE, curve_of
from clrt.materials import Checker, Material
from clrt.places import At
from clrt.spectrum import Spectrum

if TYPE_CHECKING:
    from clrt.scene import Scene

_RETURNED = ("color", "reflection_color", "transmission_color")
"""Fields of a material that say what share of the light a surface returns."""


def check_lines(scene: Scene) -> None:
    """Raise for a spectral line outside the scene's range, which no band would hold."""
    if scene.spectrum is None:
        return
    low, high = scene.spectrum.range
    for place, value in colors(scene):
        line = value.line if isinstance(value, Spectrum) else None
        if line is not None and not low <= line <= high:
            raise place.key("line").error(line, f"the scene's light has {low:g} to {high:g} nm")


def colors(scene: Scene) -> Iterator[tuple[At, Any]]:
    """Every colour and spectrum of a scene, with its place."""
    at = At(scene.source)
    tables: list[tuple[At, Any]] = [(at, scene)]
    tables += [(at.key("lights").item(i), light) for i, light in enumerate(scene.lights)]
    for place, table in tables + list(materials(scene)):
        for name in color_fields(table.__class__):
            value = getattr(table, name)
            if isinstance(value, Checker):
                for i, color in enumerate(value.colors):
                    yield place.key(name).key("colors").item(i), color
            else:
                yield place.key(name), value


def materials(scene: Scene) -> Iterator[tuple[At, Material]]:
    """The materials by name, and those that shapes have of their own."""
    at = At(scene.source)
    for name, material in scene.materials.items():
        yield at.key("materials").key(name), material
    for i, shape in enumerate(scene.shapes):
        if isinstance(shape.material, Material):
            yield at.key("shapes").item(i).key("material"), shape.material


def warn(scene: Scene) -> None:
    """Warn, once each, of what is allowed but probably not meant."""
    for kind in (_makes_light, _open_glass, _too_bright, _undispersed):
        found = kind(scene)
        if found:
            notices.warn(scene.source, *found)


def _makes_light(scene: Scene) -> tuple[str, str] | None:
    bright = _first(scene, lambda material: material.gain > 1 + 1e-6)
    if bright is None:
        return None
    index, material = bright
    text = f"diffuse + max(specular, reflection) + transmission is {material.gain:.4g}"
    return f"shapes[{index}]", f"{text}; above 1 a surface makes light"


def _open_glass(scene: Scene) -> tuple[str, str] | None:
    sheet = _first(scene, lambda material: material.kt > 0 and not material.thin, only_open=True)
    if sheet is None:
        return None
    kind = scene.shapes[sheet[0]].type
    text = f"an open {kind} transmits but encloses nothing; a sheet of glass has thin = true"
    return f"shapes[{sheet[0]}]", text


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
    for place, material in materials(scene):
        for name in _RETURNED:
            color = getattr(material, name)
            checks = color.colors if isinstance(color, Checker) else None
            for i, part in enumerate(checks or (color,)):
                most = _peak(part)
                if most > 1:
                    inner = place.key(name) if checks is None else place.key(name).key("colors").item(i)
                    return inner.path, f"a reflectance of {most:.4g}; above 1 a surface makes light"
    return None


def _peak(color: Any) -> float:
    """The largest value of a colour or spectrum."""
    if isinstance(color, (int, float)):
        return float(color)
    if isinstance(color, tuple):
        return float(max(color))
    if isinstance(color, Spectrum) and color.samples is not None:
        return max(value for _, value in color.samples) * color.scale
    if isinstance(color, Spectrum) and (color.gaussian is not None or color.band is not None):
        return color.scale
    return float(curve_of(color).values.max())


def _undispersed(scene: Scene) -> tuple[str, str] | None:
    if scene.spectrum is not None:
        return None
    for place, material in materials(scene):
        if material.dispersive and material.kt > 0:
            text = f"without [spectrum] its one index is that at {D_LINE:.2f} nm, {material.eta:.6g}"
            return place.key("ior").path, text
    return None
