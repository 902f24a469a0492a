"""What `Scene.replace` makes of a draft's materials and shapes: what is new is checked as a file is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from clrt.base.frozen import FrozenDict
from clrt.base.places import At
from clrt.base.records import read
from clrt.scene.edit import Draft
from clrt.scene.materials import Material
from clrt.scene.mesh import Mesh, Meshes, edited_mesh
from clrt.scene.shapes import Shape
from clrt.scene.tables import check_material, check_pictures, read_materials

if TYPE_CHECKING:
    from clrt.scene.scene import Scene


def edited_materials(scene: Scene, draft: Draft, at: At) -> dict[str, Material]:
    """The materials as the draft has them; all shapes of those that are new can have them."""
    materials, touched = draft.values["materials"], draft.touched.get("materials")
    if touched is None:
        materials = read_materials(materials, at)
    else:
        materials = FrozenDict({
            name: read(Material, value, at.key(name)) if name in touched else value
            for name, value in materials.items()
        })  # fmt: skip
    known: set[str] = set()
    for name, material in materials.items():
        check_pictures(material, scene.folder, at.key(name), known)
    place = At(scene.source, "shapes")
    for index, shape in enumerate(scene.shapes if "shapes" not in draft.values else ()):
        if isinstance(shape.material, str) and (touched is None or shape.material in touched):
            check_material(shape, materials, place.item(index))
    return materials


def edited_shapes(scene: Scene, draft: Draft, materials: Mapping[str, Material], at: At) -> tuple[Shape, ...]:
    """The shapes as the draft has them."""
    shapes, touched = draft.values["shapes"], draft.touched.get("shapes")
    if touched is None:
        return scene._read_shapes(shapes, materials, at)
    numbers = sorted(number for number in touched if isinstance(number, int))
    for index in numbers:
        place, before = at.item(index), scene.shapes[index]
        new = shapes[index]
        if isinstance(before, Mesh) and isinstance(new, Mapping) and _is_mesh(new.get("type")):
            shapes[index] = edited_mesh(before, new, place, scene.folder, scene.limits)
        else:
            shapes[index] = scene._read_shape(new, place, Meshes())
    for index in range(len(shapes)) if "materials" in draft.values else numbers:
        check_material(shapes[index], materials, at.item(index))
    scene.limits.check("primitives", sum(shape.primitives for shape in shapes), at.source, at.path)
    vertices = sum(len(shape.data().vertices) for shape in shapes if isinstance(shape, Mesh))
    scene.limits.check("vertices", vertices, at.source, at.path)
    return tuple(shapes)


def _is_mesh(kind: object) -> bool:
    return isinstance(kind, str) and kind == "mesh"
