"""What is left of a scene, or of the renderer, without one feature.

A case shows a feature only where its picture is another one without it: a scene that merely contains a mirror
out of sight proves nothing about mirrors. Most features go by an edit of the scene; those that are of a
situation, and not of a key, by deliberate faults (`mutants`), any of which counts; they are named here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

import msgspec.structs
import numpy as np

from clrt.flatten.inside import count_inside
from clrt.scene.materials import Checker, Material
from clrt.scene.scene import PointLight, Scene, Shape, Spectrum, SpotLight
from clrt.scene.textures import PICTURED

from .coverage import SHAPES, shape_features

Deletion = Callable[[Scene], Scene]
Faults = tuple[str, ...]
Holds = Callable[[Material], bool]
_GREY: Final = 0.5  # in place of a spectrum
_SPECTRUM_KINDS: Final = {"black body": "blackbody", "gaussian": "gaussian", "band": "band", "line": "line",
                          "samples": "samples"}  # fmt: skip


def edited(scene: Scene, **changes: Any) -> Scene:
    """The scene with other values of these keys, not checked anew: what is left is a scene, too."""
    return msgspec.structs.replace(scene, **changes)


def _settings(**changes: Any) -> Deletion:
    return lambda scene: edited(scene, **changes)


def _camera(**changes: Any) -> Deletion:
    def deletion(scene: Scene) -> Scene:
        assert scene.camera is not None
        return edited(scene, camera=msgspec.structs.replace(scene.camera, **changes))

    return deletion


def _other_projection(scene: Scene) -> Scene:
    """What is at the target is seen in the same size by the other kind of camera."""
    camera = scene.camera
    assert camera is not None
    distance = math.dist(camera.origin, camera.target)
    if camera.type == "perspective":
        size = 2 * distance * camera.half_extents(camera.width, camera.height)[0]
        return _camera(type="orthographic", K=None, fov_axis="horizontal", size=size)(scene)
    fov = 2 * math.degrees(math.atan2(camera.size / 2, distance))
    return _camera(type="perspective", fov=fov)(scene)


def _level(scene: Scene) -> Scene:
    """A pose that says where the camera is, and not how it is turned."""
    assert scene.camera is not None
    x, y, z = scene.camera.origin
    pose = ((1.0, 0.0, 0.0, x), (0.0, -1.0, 0.0, y), (0.0, 0.0, -1.0, z), (0.0, 0.0, 0.0, 1.0))
    return _camera(pose=pose)(scene)


def with_materials(change: Callable[[Material], Material]) -> Deletion:
    """Every shape with its own material, changed."""

    def deletion(scene: Scene) -> Scene:
        shapes = tuple(
            msgspec.structs.replace(shape, material=change(scene.material_of(shape)))
            for shape in scene.shapes
        )
        return edited(scene, shapes=shapes)

    return deletion


def _material(when: Holds = lambda material: True, **changes: Any) -> Deletion:
    def change(material: Material) -> Material:
        return msgspec.structs.replace(material, **changes) if when(material) else material

    return with_materials(change)


def _pictures(*fields: str, plain: float) -> Deletion:
    """One number in place of pictures."""
    return with_materials(lambda material: msgspec.structs.replace(
        material, **dict.fromkeys(material.pictures.keys() & set(fields), plain)
    ))  # fmt: skip


def _unplaced(material: Material) -> Material:
    """Normals lie as the picture of the colour does."""
    normals = material.normal_map
    plain = None if normals is None else msgspec.structs.replace(normals, placement=None)
    return msgspec.structs.replace(material, normal_map=plain)


def _each_picture(**changes: Any) -> Deletion:
    def change(material: Material) -> Material:
        shown = {name: value for name, value in material.pictures.items() if name in PICTURED}
        return msgspec.structs.replace(
            material, **{name: msgspec.structs.replace(value, **changes) for name, value in shown.items()}
        )

    return with_materials(change)


def _equal_indices(scene: Scene) -> Scene:
    """A body of the index around it bends light as others do."""
    return _material(lambda m: m.kt > 0 and m.ior_d == scene.medium_ior, ior=1.5 * scene.medium_ior)(scene)


def _constant_shares(material: Material) -> Material:
    if material.fresnel is not True:
        return material
    shares = {"reflection": 0.1 * material.kr, "transmission": 0.6 * material.kt}
    return msgspec.structs.replace(material, fresnel=False, **shares)


def _one_index(material: Material) -> Material:
    return msgspec.structs.replace(material, ior=material.ior_d) if material.dispersive else material


def _first_colour(kind: str) -> Deletion:
    """Checkers on shapes of one kind are their first colour."""

    def deletion(scene: Scene) -> Scene:
        def plain(shape: Shape) -> Shape:
            material = scene.material_of(shape)
            if shape.type != kind or not isinstance(material.color, Checker):
                return shape
            material = msgspec.structs.replace(material, color=material.color.colors[0])
            return msgspec.structs.replace(shape, material=material)

        return edited(scene, shapes=tuple(map(plain, scene.shapes)))

    return deletion


def _without_shapes(feature: str) -> Deletion:
    def deletion(scene: Scene) -> Scene:
        return edited(scene, shapes=tuple(s for s in scene.shapes if feature not in shape_features(s)))

    return deletion


def _unmoved(scene: Scene) -> Scene:
    shapes = tuple(
        msgspec.structs.replace(shape, transform=None) if "transform" in shape_features(shape) else shape
        for shape in scene.shapes
    )
    return edited(scene, shapes=shapes)


def _outside(scene: Scene) -> Scene:
    """What the camera is in, or looks at from behind, is not there."""
    assert scene.camera is not None
    at = np.asarray([scene.camera.origin], np.float64)
    outside = tuple(shape for shape in scene.shapes if count_inside(shape, at)[0] % 2 == 0)
    return edited(scene, shapes=outside)


def _lights(keep: Callable[[Any], bool]) -> Deletion:
    return lambda scene: edited(scene, lights=tuple(filter(keep, scene.lights)))


def _without_lights(kind: str) -> Deletion:
    return _lights(lambda light: light.type != kind)


def _without_spots(those: Callable[[SpotLight], bool]) -> Deletion:
    return _lights(lambda light: not (isinstance(light, SpotLight) and those(light)))


def _each_light(**changes: Any) -> Deletion:
    """Lights that have these keys, with other values of them."""

    def change(light: Any) -> Any:
        known = {name: value for name, value in changes.items() if name in light.__struct_fields__}
        return msgspec.structs.replace(light, **known)

    return lambda scene: edited(scene, lights=tuple(map(change, scene.lights)))


def _lamp(scene: Scene) -> Scene:
    assert scene.camera is not None
    return edited(scene, lights=(PointLight(position=scene.camera.origin, intensity=0.5),))


def _mapped(value: Any, change: Callable[[Any], Any]) -> Any:
    """A record with every value in it changed, however deep; shapes' own are their materials."""
    new = change(value)
    if new is not value or not isinstance(value, Material | Checker):
        return new
    fields = {name: getattr(value, name) for name in value.__struct_fields__}
    return msgspec.structs.replace(value, **{
        name: tuple(_mapped(part, change) for part in old) if name == "colors" else _mapped(old, change)
        for name, old in fields.items() if name not in _NO_COLOURS
    })  # fmt: skip


_NO_COLOURS: Final = {"fresnel", "ior", "conductor"}  # hold words and curves that are not colours


def _colours(change: Callable[[Any], Any]) -> Deletion:
    """Every colour of lights, materials and the scene changed."""

    def deletion(scene: Scene) -> Scene:
        lights = tuple(
            msgspec.structs.replace(light, **{name: change(getattr(light, name))})
            for light in scene.lights
            for name in ("intensity", "radiance")
            if name in light.__struct_fields__
        )
        background = scene.background if scene.background_path else change(scene.background)
        scene = edited(scene, lights=lights, ambient=change(scene.ambient), background=background,
                       depth_color=change(scene.depth_color))  # fmt: skip
        return with_materials(lambda material: _mapped(material, change))(scene)

    return deletion


def _grey_where(holds: Callable[[Any], bool]) -> Deletion:
    return _colours(lambda value: _GREY if holds(value) else value)


def _is_named(value: Any) -> bool:
    return isinstance(value, str) or (isinstance(value, Spectrum) and value.name is not None)


def _is_kind(key: str) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, Spectrum) and getattr(value, key) is not None


def _is_tinted(value: Any) -> bool:
    return isinstance(value, tuple) and len(value) == 3 and len(set(value)) > 1


def _no_spectrum(**changes: Any) -> Deletion:
    def deletion(scene: Scene) -> Scene:
        assert scene.spectrum is not None
        return edited(scene, spectrum=msgspec.structs.replace(scene.spectrum, **changes))

    return deletion


def _without_spectra(scene: Scene) -> Scene:
    grey = _grey_where(lambda value: isinstance(value, str | Spectrum))(scene)
    return _material(conductor=None)(grey)


def _is_thin_sheet(material: Material) -> bool:
    return material.kt > 0 and material.thin


_CAMERAS: Final[dict[str, Deletion | Faults]] = {
    "perspective": _other_projection, "orthographic": _other_projection,
    "vertical field of view": _camera(fov_axis="horizontal"), "up vector": _camera(up=None),
    "near": _camera(near=0.0), "mirrored camera": _camera(mirror=False),
    "shifted camera": _camera(shift=(0.0, 0.0)), "jitter": _camera(jitter=None),
    "adaptive": _settings(adaptive=None), "lens": _camera(aperture=0.0), "pose": _level, "K": _camera(K=None),
    **{f"{name} filter": _camera(filter="box") for name in ("tent", "gaussian", "mitchell")},
    **{f"{spp} samples": _camera(spp=1) for spp in (4, 16, 64)},
}  # fmt: skip

_MATERIALS: Final[dict[str, Deletion | Faults]] = {
    "ambient, constant": _settings(ambient=0.0), "emission": _material(emission=0.0),
    "diffuse": _material(diffuse=0.0), "highlight": _material(specular=0.0),
    "highlight tint": _material(highlight_color=1.0),
    **{f"checker on a {kind}": _first_colour(kind) for kind in ("plane", "disk", "polygon", "sphere")},
    "mirror": _material(reflection=0.0), "mirror tint": _material(reflection_color=1.0),
    "schlick mirror": _material(lambda m: m.fresnel == "schlick" and m.kr > 0, fresnel=False),
    "schlick highlight": _material(lambda m: m.fresnel == "schlick" and m.specular > 0, fresnel=False),
    "transmission": _material(lambda m: m.kt > 0 and not m.thin, transmission=0.0),
    "transmission tint": _material(transmission_color=1.0),
    "fresnel": with_materials(_constant_shares),
    "thin": _material(_is_thin_sheet, transmission=0.0), "equal indices": _equal_indices,
    "absorption": _material(absorption=0.0), "priority": _material(priority=0),
    "rough mirror": _material(lambda m: m.conductor is None, roughness=0.0),
    "picture": _pictures("color", plain=0.5), "picture of light": _pictures("emission", plain=0.0),
    "picture of a tint": _pictures("highlight_color", "reflection_color", "transmission_color", plain=1.0),
    "nearest texel": _each_picture(filter="linear"), "clamped picture": _each_picture(wrap="repeat"),
    "mirrored picture": _each_picture(wrap="repeat"),
    "moved picture": _each_picture(scale=(1.0, 1.0), offset=(0.0, 0.0)),
    "normal map": _material(normal_map=None), "placed normal map": with_materials(_unplaced),
    "mip levels": _each_picture(filter="linear"),
    "colours of a mesh": _pictures("color", plain=0.5),
    "rough metal": _material(lambda m: m.conductor is not None, roughness=0.0),
}  # fmt: skip

_SPECTRA: Final[dict[str, Deletion | Faults]] = {
    "bands": _settings(spectrum=None), "colours in bands": _grey_where(_is_tinted),
    "spectra in RGB": _without_spectra,
    "named spectrum": _grey_where(_is_named),
    **{feature: _grey_where(_is_kind(key)) for feature, key in _SPECTRUM_KINDS.items()},
    "white balance": _no_spectrum(white_balance=False), "groups of bands": _no_spectrum(group=1),
    "metal by name": _material(lambda m: isinstance(m.conductor, str), conductor=None),
    "metal by index": _material(lambda m: m.conductor is not None and not isinstance(m.conductor, str),
                                conductor=None),
    "dispersion": with_materials(_one_index),
}  # fmt: skip

_LIGHTS: Final[dict[str, Deletion | Faults]] = {
    **{f"{kind} light": _without_lights(kind)
       for kind in ("point", "directional", "rectangle", "disk", "sphere")},
    "spot light": _without_spots(lambda light: light.penumbra > 0),
    "spot without penumbra": _without_spots(lambda light: light.penumbra == 0),
    "inverse square": _each_light(falloff="none"),
    "two-sided light": _each_light(two_sided=False), "visible light": _each_light(visible=False),
    "several lights": lambda scene: edited(scene, lights=scene.lights[:1]), "no light": _lamp,
    "shadows": ("lost shadow", "what stands in a shaft stops nothing",
                "what stands in a shaft stops no tinted feeler"),
    "tinted shadows": _settings(shadow="opaque"),
}  # fmt: skip

_OTHERS: Final[dict[str, Deletion | Faults]] = {
    "background colour": _settings(background=0.0), "background image": _settings(background=0.0),
    "ambient rays": _settings(ambient_samples=0), "depth colour": _settings(depth_color=0.0),
    "least weight": _settings(min_weight=0.0), "medium index": _settings(medium_ior=1.0),
    "one-sided surfaces": _settings(one_sided="none"), "no bounces": _settings(max_depth=3),
    "from inside": _outside, "deep mirrors": _settings(max_depth=3),
    "camera in glass": ("cameras start in no medium",),
    "total internal reflection": ("lost share at total internal reflection", "not all is reflected totally"),
    "light behind the surface": ("light from behind the true surface",
                                 "light from behind the shaded surface"),
    "equal distances": ("wrong tie", "wrong tie of shapes that go one by one"),
    "invisible boundary": ("all boundaries seen", "media not left in hidden boundaries"),
    "surface in a medium": ("things in a medium stand outside it", "media in media stand outside them"),
}  # fmt: skip

DELETIONS: Final[dict[str, Deletion | Faults]] = {
    **{feature: _without_shapes(feature) for feature in SHAPES}, "transform": _unmoved,
    **_MATERIALS, **_LIGHTS, **_CAMERAS, **_SPECTRA, **_OTHERS,
}  # fmt: skip
