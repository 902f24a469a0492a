"""A file with its author's materials, cameras and lights, taken apart to what each material holds for."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from clrt.base.errors import show
from clrt.base.limits import Limits
from clrt.base.places import At
from clrt.meshfiles.file import broken_said, mesh_bytes, open_mesh
from clrt.meshfiles.look import NONE, Look, Names
from clrt.meshfiles.parts import Arrays, Placed
from clrt.meshfiles.ply import has_colors, textures

# possessive: each empty line anew
_LIBRARY: Final = re.compile(rb"(?:^|\r|^\xef\xbb\xbf)[ \t]*+mtllib\b", re.MULTILINE)


@dataclass(frozen=True, eq=False)
class Piece:
    """A part of a file: its number, what it is called (None: nothing) with all at its node, its material's
    number, or NONE, and the mean of its vertices' colours, linear, or None where they have none, or are the
    file's picture of this number, `colors`."""

    number: int
    name: str | None
    material: int
    arrays: Arrays
    color: tuple[float, float, float] | None
    colors: int | None = None

    @property
    def used(self) -> tuple[int, bool]:
        """The number of its material, and whether it has uv."""
        return self.material, self.arrays[3] is not None


@dataclass(frozen=True, eq=False)
class Model:
    """The parts of a file, the least and the largest of all their coordinates, and how they look."""

    pieces: list[Piece]
    low: np.ndarray
    high: np.ndarray
    look: Look


def read_model(path: Path, at: At, limits: Limits, smooth: bool | None) -> Model | None:
    """What is in a file that says how it looks; None for others: meshes are all that is in them."""
    data = mesh_bytes(path, at, limits)
    suffix = path.suffix.lower()
    obj = suffix == ".obj" and _LIBRARY.search(data)
    shown = textures(data) if suffix == ".ply" else []
    ply = suffix == ".ply" and (has_colors(data) or len(shown) > 0)
    if not (suffix in (".glb", ".gltf") or obj or ply):
        return None
    with broken_said(path, at):
        placed = open_mesh(data, path, at, limits, apart=True)
        if placed.look is None and suffix == ".obj":
            return None
        if not len(placed.which):
            raise at.says("it has no faces")
        more = placed.sizes(smooth)
        limits.check("primitives", more[1], at.source, at.path)
        limits.check("vertices", more[0], at.source, at.path)
        pieces = list(_pieces(placed, smooth))
        low = np.min([piece.arrays[0].min(axis=0) for piece in pieces], axis=0)
        high = np.max([piece.arrays[0].max(axis=0) for piece in pieces], axis=0)
        pairs = {piece.used for piece in pieces if piece.material != NONE}
        used = sorted(pairs, key=lambda pair: (pair[0], not pair[1]))
        look = Look()
        if placed.look is not None:
            look = placed.look(used, (low + high) / 2, float(np.linalg.norm(high - low)) / 2)
        if any(piece.color is not None for piece in pieces):
            look.left_out["the colours of vertices, but for their mean"] = None
        look.left_out.update({f"the texture {show(name[:60])}": None for name in shown})
        if ply and has_colors(data) and all(part.corners is None for part in placed.parts):
            look.left_out["colours beside uv"] = None
        look.left_out.update(dict.fromkeys(placed.left_out))
    return Model(pieces, low, high, look)


def _pieces(placed: Placed, smooth: bool | None) -> Iterator[Piece]:
    names = Names()
    called: dict[int, str | None] = {}  # by where it stands: what stands at one node is one thing
    for number, (where, material, places) in enumerate(placed.groups):
        if where not in called:
            name = placed.names[where] if where != NONE and len(placed.names) else ""
            called[where] = names.new(name) if name else None
        here = placed.only(places)
        yield Piece(number, called[where], material, here.joined(smooth), _color(here), _pictured(here))


def _pictured(placed: Placed) -> int | None:
    """The number of the file's picture that has colours of these parts (vertex_colors.py)."""
    return placed.colors if any(part.corners is not None for part in placed.parts) else None


def _color(placed: Placed) -> tuple[float, float, float] | None:
    """The mean of the colours of all vertices of these parts that have one."""
    colored = [(part.color(), part.vertices) for part in placed.parts if part.color is not None]
    if not colored:
        return None
    red, green, blue = np.average([c for c, _ in colored], axis=0, weights=[n for _, n in colored]).tolist()
    return red, green, blue
