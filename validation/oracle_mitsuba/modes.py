"""What each mode can express."""

from __future__ import annotations

from . import stock
from .patches import Unreadable
from .records import AreaLight, Checker, Picture, Scene
from .shapes import Mesh, Quadric

LAYER_B = ("table", "bsdf")
SPECTRAL = "spectral"  # the table mode, three bands at a time
MODES = (*LAYER_B, *(f"stock-{name}" for name in stock.CONFIGURATIONS))


def supports(scene: Scene, mode: str) -> str | None:
    """None where `mode` can express the scene, else why not."""
    if mode not in (*MODES, SPECTRAL):
        return f"unknown mode; the modes are {', '.join((*MODES, SPECTRAL))}"
    for number, shape in enumerate(scene.shapes):
        if isinstance(shape, Mesh):
            try:
                if not len(shape.data().faces):
                    return f"shapes[{number}]: a mesh without faces"
            except Unreadable as reason:
                return f"shapes[{number}]: {reason}"
        material = scene.material_of(shape)
        shown = [value for value in vars(material).values() if isinstance(value, Picture)]
        of_mesh = [value for value in shown if value.part is not None]
        if of_mesh:
            known = isinstance(shape, Mesh) and shape.data().colors is not None
            if not known or any(value.file != shape.file for value in of_mesh):
                return f"shapes[{number}]: colours of another mesh"
            if material.normal_map is not None or len(of_mesh) < len(shown):
                return f"shapes[{number}]: pictures beside the colours of a mesh"
        elif isinstance(shape, Mesh) and material.pictures and shape.data().uv is None:
            return f"shapes[{number}]: a mesh whose u and v are not read"
        if scene.shadow == "tinted" and isinstance(material.transmission_color, Picture):
            return f"shapes[{number}]: tinted shadows of a picture"
        fine = any(isinstance(of, Picture) and of.filter == "mipmap" for of in vars(material).values())
        if fine and isinstance(shape, Quadric):
            return f"shapes[{number}]: mip levels on a quadric, by whose normals u and v go"
    if scene.adaptive is not None and mode not in LAYER_B:
        return "adaptive sampling is left to the table mode"
    if mode == SPECTRAL:
        return not_by_wavelength(scene)
    if scene.spectrum is not None:
        return "Mitsuba has three bands; ask wavelength by wavelength"
    if mode == "table":
        return None
    return _bsdf_supports(scene) if mode == "bsdf" else stock.supports(scene, mode.removeprefix("stock-"))


def not_by_wavelength(scene: Scene) -> str | None:
    """Why a scene is no sum of pictures of its bands; None where it is."""
    if scene.spectrum is None:
        return "the scene is in RGB"
    if scene.spectrum.response != "cie":
        return "the thesis program's colours are no sums over rays"
    return None


def _bsdf_supports(scene: Scene) -> str | None:
    """Mitsuba's own plugins have no Phong lobe and no Schlick mirror."""
    if scene.ambient_samples:
        return "Mitsuba has no ambient rays (ambient_samples)"
    if scene.shadow == "tinted":
        return "Mitsuba has no tinted shadows"
    for number, light in enumerate(scene.lights):
        if isinstance(light, AreaLight):
            return f"lights[{number}]: the points of lights with extent are left to the table mode"
    for number, shape in enumerate(scene.shapes):
        material = scene.material_of(shape)
        if material.pictures:
            return f"shapes[{number}]: pictures are left to the table mode"
        if material.specular > 0 and scene.lights:
            return f"shapes[{number}]: Mitsuba has no Phong highlight (specular > 0)"
        if material.fresnel == "schlick":
            return f"shapes[{number}]: Mitsuba has no mirror by Schlick's formula"
        if isinstance(material.color, Checker):
            return f"shapes[{number}]: checkers are left to the table mode"
    return None
