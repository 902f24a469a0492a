"""What the shapes, materials and lights of a scene are called in a tree of rays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from clrt.scene.scene import Scene


@dataclass(frozen=True)
class Names:
    """shape_of: for each number of a material a shape that has it."""

    scene: Scene
    shape_of: Mapping[int, int]

    def shape(self, number: int) -> str:
        """The shape's own name, else its kind; with its number in the scene file."""
        count = len(self.scene.shapes)
        if number >= count:  # a light that is seen
            return self.light(number - count)
        shape = self.scene.shapes[number]
        return f"{shape.name or kind_of(shape)} (shapes[{number}])"

    def material_of(self, number: int) -> str:
        """The name of a shape's material; "" for one that has none."""
        if number >= len(self.scene.shapes):
            return ""
        material = self.scene.shapes[number].material
        return material if isinstance(material, str) else ""

    def material(self, number: int) -> str:
        """A material's name, else whose it is; of a medium, too. -1: what is around everything."""
        if number < 0:
            return "outside"
        if number not in self.shape_of:
            return f"material {number}"
        return self.material_of(self.shape_of[number]) or f"that of {self.shape(self.shape_of[number])}"

    def light(self, number: int) -> str:
        """The light's kind and number in the scene file."""
        return f"{kind_of(self.scene.lights[number])} light (lights[{number}])"


def kind_of(record: object) -> str:
    """The `type` of a shape or a light in scene files."""
    return str(type(record).__struct_config__.tag)  # type: ignore[attr-defined]
