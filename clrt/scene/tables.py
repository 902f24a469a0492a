"""The lists and tables of a scene: materials, lights, and which shape may have which material."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from clrt.base.frozen import FrozenDict
from clrt.base.limits import Limits
from clrt.base.places import At, listed
from clrt.base.records import float32, read, tagged
from clrt.base.suggest import did_you_mean
from clrt.scene.lights import LIGHTS, Light
from clrt.scene.materials import Checker, Material
from clrt.scene.mesh import Mesh
from clrt.scene.shapes import Disk, Plane, Polygon, Shape, Sphere
from clrt.scene.textures import picture_path
from clrt.scene.transforms import is_similarity

_CHECKERED = (Sphere, Plane, Polygon, Disk)


def read_materials(data: object, at: At) -> dict[str, Material]:
    """The named materials that a table describes."""
    if not isinstance(data, Mapping):
        raise at.error(data, "materials must be a table of named materials")
    for name in data:
        if not isinstance(name, str):
            raise at.error(name, "a material's name must be a text")
    return FrozenDict({name: read(Material, value, at.key(name)) for name, value in data.items()})


def read_lights(data: object, at: At, limits: Limits) -> tuple[Light, ...]:
    """The lights that a list of tables describes; LimitError for too many."""
    lights = listing(data, at, "lights")
    limits.check("lights", len(lights), at.source, at.path)
    return tuple(
        read(tagged(LIGHTS, light, at.item(i), "light"), light, at.item(i)) for i, light in enumerate(lights)
    )


def names_files(shapes: object) -> bool:
    """Does reading these shapes read files?"""
    if not isinstance(shapes, (list, tuple)):
        return False
    return any(isinstance(s, Mesh) or (isinstance(s, Mapping) and "file" in s) for s in shapes)


def listing(data: object, at: At, noun: str) -> list[Any] | tuple[Any, ...]:
    """`data`, if it is a list; `noun` is the key it stands under."""
    if isinstance(data, Mapping):
        raise at.error(data, f"{noun} must be a list of tables; in TOML each is a [[{noun}]]: two brackets")
    if not isinstance(data, (list, tuple)):
        raise at.error(data, f"{noun} must be a list of tables")
    return data


def special_on_shapes(material: Material) -> bool:
    """Whether not every shape can have a material."""
    return isinstance(material.color, Checker) or bool(material.pictures)


def check_material(shape: Shape, materials: Mapping[str, Material], at: At) -> None:
    """Raise SceneError where a shape cannot have the material that it names."""
    material: object = shape.material
    if isinstance(material, str):
        if material not in materials:
            known = f"the materials are {listed(materials)}{did_you_mean(material, materials)}"
            raise at.key("material").error(material, known if materials else "the scene has no materials")
        material = materials[material]
    if isinstance(material, Material) and isinstance(shape, Mesh) and material.pictures:
        if shape.data().uv is None:
            key = next(iter(material.pictures))
            text = f"its {key} is a picture, and the mesh has no uv; give each vertex one, or a plain colour"
            raise at.key("material").says(text)
    if isinstance(material, Material) and isinstance(material.color, Checker):
        if not isinstance(shape, _CHECKERED):
            raise at.key("material").says(
                f"a checker is for spheres, planes, polygons and disks, not a {shape.type}"
            )
        if isinstance(shape, Sphere) and not is_similarity(float32(shape.matrix)):
            raise at.key("transform").says(
                "a sphere with a checker must stay round; use one scale for all axes"
            )


def check_pictures(material: Material, folder: Path | None, at: At, known: set[str]) -> None:
    """Raise SceneError for a picture of a material that is no file of the scene's folder.

    `known` are the names of those that are, to which this material's are added.
    """
    for name, picture in material.pictures.items():
        if picture.file not in known:
            picture_path(picture, folder, at.key(name))
            known.add(picture.file)
