"""What there is to prove, and which oracles proved it: the table of features.

A feature counts as proven by an oracle where a case agrees with it whose picture is another one without the
feature (`ticks`). Oracles of one family share code, so a feature needs two families.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Final

from clrt.scene.scene import (
    Box,
    Checker,
    Cone,
    Cylinder,
    Ellipsoid,
    ImageTexture,
    Material,
    Mesh,
    Polygon,
    Quadric,
    Scene,
    Shape,
    Spectrum,
    Sphere,
    SpotLight,
)
from clrt.scene.transforms import is_similarity

from .types import CaseResult, CountResult

SHAPES: Final = (
    "sphere", "sphere, transformed", "sphere, made an ellipsoid", "ellipsoid", "plane", "polygon",
    "polygon of many corners",
    "disk", "box", "box, mirrored", "mesh of triangles", "mesh of polygons", "smooth mesh",
    "mesh with normals", "cylinder",
    "cylinder with caps", "cone", "cone with caps", "cone with a tip", "paraboloid", "quadric",
    "quadric, clipped",
    "transform",
)  # fmt: skip
MATERIALS: Final = (
    "ambient, constant", "emission", "diffuse", "highlight", "highlight tint", "checker on a plane",
    "checker on a disk",
    "checker on a polygon", "checker on a sphere", "mirror", "mirror tint", "schlick mirror",
    "schlick highlight",
    "transmission", "transmission tint", "fresnel", "thin", "equal indices", "absorption", "priority",
    "rough mirror", "rough metal",
    "picture", "picture of a tint", "picture of light", "nearest texel", "clamped picture",
    "mirrored picture", "moved picture", "normal map", "placed normal map", "mip levels",
    "colours of a mesh",
)  # fmt: skip
LIGHTS: Final = ("point light", "inverse square", "directional light", "spot light", "spot without penumbra",
                 "rectangle light", "disk light", "sphere light", "two-sided light", "visible light",
                 "several lights", "no light", "shadows", "tinted shadows")
SETTINGS: Final = (
    "background colour", "background image", "ambient rays", "depth colour", "least weight", "medium index",
    "one-sided surfaces", "no bounces",
)  # fmt: skip
CAMERAS: Final = (
    "perspective", "orthographic", "vertical field of view", "up vector", "near", "mirrored camera",
    "shifted camera", "pose", "K", "jitter", "4 samples", "16 samples", "64 samples", "lens",
    "tent filter", "gaussian filter", "mitchell filter", "adaptive",
)  # fmt: skip
SPECTRA: Final = (
    "bands", "colours in bands", "spectra in RGB", "named spectrum", "black body", "gaussian", "band", "line",
    "samples", "white balance", "metal by name", "metal by index", "dispersion", "groups of bands",
)  # fmt: skip
# what a scene's tables do not show
SITUATIONS: Final = (
    "from inside", "camera in glass", "total internal reflection", "deep mirrors", "light behind the surface",
    "equal distances", "invisible boundary", "surface in a medium",
)  # fmt: skip
COUNTS: Final = ("ray counts",)
FEATURES: Final = {"shapes": SHAPES, "materials": MATERIALS, "lights": LIGHTS, "scene": SETTINGS,
                   "camera": CAMERAS, "spectra": SPECTRA,
                   "situations": SITUATIONS, "counting": COUNTS}  # fmt: skip


def features_of(scene: Scene) -> set[str]:
    """The features that a scene's tables show."""
    found = _scene_features(scene) | _light_features(scene) | _camera_features(scene)
    found |= _spectral_features(scene)
    for shape in scene.shapes:
        found |= shape_features(shape) | _material_features(scene, shape)
    return found


PROGRAM: Final = "program "
"""Before the name of an oracle that is somebody else's program: nobody knows what it shares with others."""


def coverage(results: Iterable[CaseResult], counts: Iterable[CountResult] = ()) -> dict[str, set[str]]:
    """Feature -> oracles under which it passed, for every feature there is."""
    table: dict[str, set[str]] = {name: set() for names in FEATURES.values() for name in names}
    for result in results:
        agree = {oracle for oracle, (_, comparison) in result.results.items()
                 if comparison.passed and not oracle.startswith(PROGRAM)}  # fmt: skip
        for feature in result.case.shows:
            table.setdefault(feature, set()).update(agree)
    by_oracle: dict[str, list[bool]] = {}
    for count in counts:
        by_oracle.setdefault(count.scene.partition(", ")[2] or "published", []).append(count.passed)
    table[COUNTS[0]] = {oracle for oracle, passed in by_oracle.items() if all(passed)}
    return table


def fewest_cases(features: Mapping[str, frozenset[str]]) -> list[str]:
    """A few of these cases (name -> features) that have all of the features: the greedy choice."""
    missing = set().union(*features.values()) if features else set()
    chosen: list[str] = []
    while missing:
        best = max(features, key=lambda name: len(features[name] & missing))
        chosen.append(best)
        missing -= features[best]
    return chosen


def _scene_features(scene: Scene) -> set[str]:
    bounces = any(m.kr > 0 or m.kt > 0 for m in map(scene.material_of, scene.shapes))
    image = isinstance(scene.background, str)
    tests = {
        "background image": image, "background colour": not image, "ambient rays": scene.ambient_samples > 0,
        "depth colour": bounces and scene.depth_color != 0, "least weight": bounces and scene.min_weight > 0,
        "medium index": scene.medium_ior != 1, "one-sided surfaces": scene.one_sided == "opaque",
        "no bounces": bounces and scene.max_depth == 0,
    }  # fmt: skip
    return {name for name, holds in tests.items() if holds}


def _light_features(scene: Scene) -> set[str]:
    lights = scene.lights
    kinds = {light.type for light in lights}
    spots = [light for light in lights if isinstance(light, SpotLight)]
    tinted = scene.shadow == "tinted" and any(scene.material_of(shape).kt > 0 for shape in scene.shapes)
    tests = {
        "point light": "point" in kinds, "directional light": "directional" in kinds,
        "spot light": any(light.penumbra > 0 for light in spots),
        "spot without penumbra": any(light.penumbra == 0 for light in spots),
        "visible light": any(getattr(light, "visible", False) for light in lights),
        "two-sided light": any(getattr(light, "two_sided", False) for light in lights),
        **{f"{kind} light": kind in kinds for kind in ("rectangle", "disk", "sphere")},
        "several lights": len(lights) > 1,
        "inverse square": any(light.falloff != "none" for light in lights),
        "no light": not lights, "shadows": bool(lights) and len(scene.shapes) > 1,
        "tinted shadows": tinted and bool(lights),
    }  # fmt: skip
    return {name for name, holds in tests.items() if holds}


def _camera_features(scene: Scene) -> set[str]:
    camera = scene.camera
    if camera is None:
        return set()
    tests = {
        camera.type: True, "vertical field of view": camera.fov_axis == "vertical", "near": camera.near > 0,
        "up vector": camera.up not in (None, (0.0, 1.0, 0.0)), "mirrored camera": camera.mirror,
        "shifted camera": camera.shift != (0.0, 0.0), "jitter": camera.jitter is not None,
        f"{camera.spp} samples": camera.spp in (4, 16, 64), "lens": camera.aperture > 0,
        f"{camera.filter} filter": camera.filter != "box" and camera.spp > 1,
        "pose": camera.has_pose, "K": camera.has_k, "adaptive": scene.adaptive is not None,
    }  # fmt: skip
    return {name for name, holds in tests.items() if holds}


def shape_features(shape: Shape) -> set[str]:
    """The features that a shape alone has: its kind, and whether a transform moved it."""
    moved = getattr(shape, "transform", None) is not None
    return {_shape_name(shape, moved), *(["transform"] if moved else [])}


def _shape_name(shape: Any, moved: bool) -> str:
    if isinstance(shape, Sphere) and moved:
        return "sphere, transformed" if is_similarity(shape.matrix) else "sphere, made an ellipsoid"
    if isinstance(shape, Polygon) and len(shape.points) > 4:
        return "polygon of many corners"
    if isinstance(shape, Box) and _mirrors(shape):
        return "box, mirrored"
    if isinstance(shape, Mesh):
        if shape.normals is not None or shape.smooth:
            return "mesh with normals" if shape.normals is not None else "smooth mesh"
        polygons = any(len(face) > 3 for face in shape.data().faces)
        return "mesh of polygons" if polygons else "mesh of triangles"
    if isinstance(shape, Cone):
        return "cone with a tip" if 0 in (shape.r0, shape.r1) else "cone with caps" if shape.caps else "cone"
    if isinstance(shape, Cylinder) and shape.caps:
        return "cylinder with caps"
    if isinstance(shape, Quadric) and shape.clip is not None:
        return "quadric, clipped"
    return "ellipsoid" if isinstance(shape, Ellipsoid) else shape.type


def _mirrors(shape: Shape) -> bool:
    import numpy as np

    return bool(np.linalg.det(shape.matrix[:3, :3]) < 0)


def _material_features(scene: Scene, shape: Shape) -> set[str]:
    material = scene.material_of(shape)
    lit = bool(scene.lights)
    schlick = material.fresnel == "schlick"
    tests = {
        "ambient, constant": material.ka > 0 and _is_lit(scene.ambient) and not scene.ambient_samples,
        "emission": _is_lit(material.emission), "diffuse": lit and material.diffuse > 0,
        "highlight": lit and material.specular > 0,
        "highlight tint": lit and material.specular > 0 and _tinted(material.highlight_color),
        "schlick highlight": lit and material.specular > 0 and schlick,
        f"checker on a {shape.type}": isinstance(material.color, Checker),
    }  # fmt: skip
    found = {name for name, holds in tests.items() if holds} | _picture_features(material, lit)
    return found | _bounce_features(scene, material)


def _picture_features(material: Material, lit: bool) -> set[str]:
    shown = material.pictures.keys()
    pictures = [value for value in material.pictures.values() if isinstance(value, ImageTexture)]
    tests = {
        "picture": "color" in shown,
        "picture of a tint": bool(shown & {"highlight_color", "reflection_color", "transmission_color"}),
        "picture of light": "emission" in shown,
        "nearest texel": any(picture.filter == "nearest" for picture in pictures),
        "clamped picture": any(picture.wrap == "clamp" for picture in pictures),
        "mirrored picture": any(picture.wrap == "mirror" for picture in pictures),
        "moved picture": any(
            (picture.scale, picture.offset) != ((1.0, 1.0), (0.0, 0.0)) for picture in pictures
        ),
        "mip levels": any(picture.filter == "mipmap" for picture in pictures),
        "colours of a mesh": any(_of_corners(picture) for picture in pictures),
        "normal map": lit and material.normal_map is not None,
        "placed normal map": lit and material.normal_map is not None
        and material.normal_map.placement is not None,
    }
    return {name for name, holds in tests.items() if holds}


def _of_corners(picture: ImageTexture) -> bool:
    """Whether a picture is the colours of a file's vertices or faces."""
    return picture.part is not None and str(picture.file).lower().endswith(".ply")


def _bounce_features(scene: Scene, material: Material) -> set[str]:
    kr, kt, fresnel = material.kr > 0, material.kt > 0, material.fresnel is True
    same = material.ior_d == scene.medium_ior
    tests = {
        "mirror": kr, "mirror tint": kr and _tinted(material.reflection_color),
        "schlick mirror": kr and material.fresnel == "schlick",
        "transmission": kt and not same and not material.thin,
        "transmission tint": kt and _tinted(material.transmission_color),
        "fresnel": fresnel and (kr or kt) and not same,
        "thin": kt and material.thin, "equal indices": kt and same,
        "absorption": material.is_medium and _is_lit(material.absorption),
        "priority": material.is_medium and material.priority != 0,
        "rough mirror": material.alpha > 0 and material.conductor is None,
        "rough metal": material.alpha > 0 and material.conductor is not None,
    }  # fmt: skip
    return {name for name, holds in tests.items() if holds}


def _is_lit(color: Any) -> bool:
    return color not in (0, (0, 0, 0))


def _spectral_features(scene: Scene) -> set[str]:
    wanted, used = scene.spectrum, [scene.material_of(shape) for shape in scene.shapes]
    spectra = list(_spectra(scene, used))
    metals = [m.conductor for m in used if m.conductor is not None]
    found = {"named spectrum"} if any(isinstance(value, str) for value in spectra) else set()
    kinds = {"name": "named spectrum", "blackbody": "black body", "gaussian": "gaussian", "band": "band",
             "line": "line", "samples": "samples"}  # fmt: skip
    found |= {kinds[kind] for kind in kinds for value in spectra
              if not isinstance(value, str) and getattr(value, kind) is not None}  # fmt: skip
    found |= {"metal by name" if isinstance(metal, str) else "metal by index" for metal in metals}
    if wanted is None:
        return found | ({"spectra in RGB"} if spectra or metals else set())
    tests = {
        "bands": True, "colours in bands": len(spectra) < len(used), "white balance": wanted.white_balance,
        "dispersion": any(m.dispersive and m.kt > 0 for m in used), "groups of bands": wanted.group > 1,
    }  # fmt: skip
    return found | {name for name, holds in tests.items() if holds}


def _spectra(scene: Scene, materials: list[Material]) -> Iterator[Any]:
    """Every name and record of a spectrum in a scene."""
    values: list[Any] = [scene.ambient, scene.background, scene.depth_color]
    values += [light.intensity for light in scene.lights]
    for m in materials:
        values += m.color.colors if isinstance(m.color, Checker) else [m.color]
        values += [m.emission, m.absorption, m.highlight_color, m.reflection_color, m.transmission_color]
    if scene.background_path is not None:
        values.remove(scene.background)
    return (value for value in values if isinstance(value, (str, Spectrum)))


def _tinted(color: Any) -> bool:
    return color not in (1, (1, 1, 1))
