"""How a file's author means it to look: materials, cameras and lights, as tables of a scene file."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Any, Final

from clrt.base.errors import show
from clrt.meshfiles.facets import Facets

NONE: Final = -1
"""In place of a number: no material, nowhere."""

Table = dict[str, Any]
Used = Collection[tuple[int, bool]]
"""Materials that shapes have, by the file's own numbers, and whether these shapes have uv: those first."""


@dataclass(frozen=True, eq=False)
class Look:
    """`materials` by name, `called` the names by what of `Used` has them; `cameras` by name, the first first.

    `facets` has by name what those materials were made of that are surfaces of facets.
    `left_out` is what of the file has no counterpart here, in words, in the order in which it was met.
    """

    materials: dict[str, Table] = field(default_factory=dict)
    called: dict[tuple[int, bool], str] = field(default_factory=dict)
    cameras: dict[str, Table] = field(default_factory=dict)
    lights: list[Table] = field(default_factory=list)
    left_out: dict[str, None] = field(default_factory=dict)
    facets: dict[str, Facets] = field(default_factory=dict)

    def add(self, names: Names, used: tuple[int, bool], name: str, surface: Table | Facets) -> None:
        """A material that the file calls `name`; without uv it is another one where uv make a difference."""
        table = surface.table() if isinstance(surface, Facets) else surface
        other = self.called.get((used[0], True))
        if other is None or self.materials[other] != table:
            self.called[used] = name = names.new(name)
            self.materials[name] = table
            self.facets.update({name: surface} if isinstance(surface, Facets) else {})
        else:
            self.called[used] = other


def textures_without_uv(material: str) -> str:
    """What is left out of a material that shows pictures, where what has it has no uv."""
    return f"textures of {show(material[:60])} where it has no uv"


def not_there(file: str) -> str:
    """What is left out of a material that names a picture where no file is."""
    return f"the picture {show(file[:60])}, which is not there"


def placement_of(picture: Table) -> Table:
    """Where an image lies, in the keys that say so: the `placement` of a normal map in it."""
    return {key: picture[key] for key in ("wrap", "filter", "scale", "offset") if key in picture}


class Names:
    """Names that are given once each: a second "wood" is called "wood-2"."""

    def __init__(self) -> None:
        self._given: dict[str, int] = {}

    def new(self, name: str) -> str:
        """`name`, with a number behind it where it was given before."""
        found = name
        while found in self._given:
            self._given[name] += 1
            found = f"{name}-{self._given[name]}"
        self._given[found] = 1
        return found
