"""The mesh shape: vertices and faces given in place or by a file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from itertools import chain, pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import msgspec
import numpy as np
from msgspec import Meta

from clrt.base.files import resolve
from clrt.base.limits import Limits
from clrt.base.notices import warn
from clrt.base.places import At, known_keys
from clrt.base.records import read
from clrt.scene.mesh_arrays import FEW, check_flat, read_arrays
from clrt.scene.shapes import FiniteShape

if TYPE_CHECKING:  # most scenes have no file of a mesh, and need not wait for what reads one
    from clrt.meshfiles.outlines import Outlines
    from clrt.meshfiles.parts import Arrays, Placed

if TYPE_CHECKING:  # arrays once a mesh is read, which is what all but its maker see
    Points = Any
    Faces = Any
    Places = Any
else:

    def _rows(description: str, items: dict[str, Any], **length: int) -> Any:
        """An array whose schema is lists of such items, each of such a length."""
        row = {"type": "array", "items": items, **length}
        meta = Meta(description=description, extra_json_schema={"type": "array", "items": row})
        return Annotated[np.ndarray, meta]

    Points = _rows("must be an array of 3 numbers each", {"type": "number"}, minItems=3, maxItems=3)
    Faces = _rows(
        "faces must be an array of 3 or more vertex numbers each, counted from 0",
        {"type": "integer", "minimum": 0}, minItems=3,
    )  # fmt: skip
    Places = _rows("uv must be an array of 2 numbers each", {"type": "number"}, minItems=2, maxItems=2)
ARRAYS: Final = ("vertices", "faces", "normals", "uv")
"""The fields of a mesh in place, in the order of a file's arrays."""
_OF_FILE = ("file", "smooth", "part")


@dataclass(frozen=True, eq=False)
class MeshData:
    """A mesh ready for use.

    `vertices` (n, 3) float64, `faces` (m, 3) int32 or a tuple of int32 arrays of 3 or more indices,
    `normals` None (flat) or (n, 3) float64 as given, of any length but 0. `uv` None or (n, 2) float64, the
    vertices' places in pictures, v = 0 at the top.
    """

    vertices: np.ndarray
    faces: np.ndarray | tuple[np.ndarray, ...]
    normals: np.ndarray | None
    uv: np.ndarray | None = None

    def to_dict(self) -> dict[str, Any]:
        """The keys of a mesh in place that has this data."""
        faces = (
            self.faces.tolist() if isinstance(self.faces, np.ndarray) else [f.tolist() for f in self.faces]
        )
        normals = {} if self.normals is None else {"normals": self.normals.tolist()}
        uv = {} if self.uv is None else {"uv": self.uv.tolist()}
        return {"vertices": self.vertices.tolist(), "faces": faces, **normals, **uv}


class Mesh(FiniteShape, frozen=True, kw_only=True, eq=False, dict=True, tag="mesh"):
    """Triangles or n-gons that share vertices.

    Either `vertices` (n, 3) and `faces`, with optional vertex `normals` (n, 3) and `uv` (n, 2), places in
    pictures, or a `file`. Vertex normals make the mesh smooth; `smooth = True` computes them, weighted by
    area, where they are not given, False shades flat. `smooth` left out (None) follows what is given or in
    the file: normals if it has some, else flat. `part` is the number of one of the file's parts, as a scene
    made of the file has them as shapes; left out, all are one mesh.
    """

    vertices: Points | None = None
    faces: Faces | None = None
    normals: Points | None = None
    uv: Places | None = None
    file: Annotated[str, Meta(min_length=1, description="file must be the path of a mesh file")] | None = None
    smooth: bool | None = None
    part: Annotated[int, Meta(ge=0, description="part must be a whole number from 0")] | None = None

    @property
    def primitives(self) -> int:
        """Faces of a flat mesh, triangles of a smooth one."""
        data = self.data()
        if data.normals is None or isinstance(data.faces, np.ndarray):
            return len(data.faces)
        return sum(len(face) - 2 for face in data.faces)

    def data(self) -> MeshData:
        """The arrays, read from the file and with normals computed where need be."""
        if "_data" not in self.__dict__:
            checked = read_mesh(self, At(path=self.name or "mesh"), None, Limits())
            self.__dict__["_data"] = checked.__dict__["_data"]
        data: MeshData = self.__dict__["_data"]
        return data

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Mesh):
            return NotImplemented
        if not all(_same(getattr(self, name), getattr(other, name)) for name in self.__struct_fields__):
            return False
        mine, others = self.__dict__.get("_data"), other.__dict__.get("_data")
        if self.file is None or mine is others or mine is None or others is None:
            return True
        return all(_same(getattr(mine, part.name), getattr(others, part.name)) for part in fields(mine))

    def __ne__(self, other: object) -> bool:  # the base class has one that only looks at identity
        return not self == other

    __hash__ = None  # type: ignore[assignment]  # arrays are compared by value


@dataclass
class Meshes:
    """What a scene has come to so far: mesh files read, vertices of meshes, primitives of all shapes.

    A file is read once, however many shapes name it; `named` says how many do (`named_files`).
    """

    named: Counter[tuple[object, ...]] = field(default_factory=Counter)
    files: dict[tuple[str, bool | None, int | None], tuple[Path, MeshData]] = field(default_factory=dict)
    paths: dict[str, Path] = field(default_factory=dict)
    pictures: set[str] = field(default_factory=set)
    opened: dict[Path, Placed] = field(default_factory=dict)
    vertices: int = 0
    primitives: int = 0


def named_files(shapes: Iterable[object]) -> Counter[tuple[object, ...]]:
    """How many of a scene's shapes, read or not, name each file, with the same `smooth` and `part`."""
    found: Counter[tuple[object, ...]] = Counter()
    for one in shapes:
        table = one if isinstance(one, Mapping) else {name: getattr(one, name, None) for name in _OF_FILE}
        key = tuple(table.get(name) for name in _OF_FILE)
        if all(value is None or isinstance(value, (str, int)) for value in key):  # else no mesh has it
            found[key] += 1
    return found


def read_mesh(
    data: object, at: At, folder: Path | None, limits: Limits, others: Meshes | None = None
) -> Mesh:
    """The checked mesh that `data` (a mapping or a Mesh) describes, its file read from below `folder`.

    `others` are the scene's meshes before this one, which is added to them; LimitError when all of them have
    too many vertices, or the file too many faces beside the other shapes' primitives.
    """
    others = others or Meshes()
    mesh = _read_mesh(data, at, folder, limits, others)
    others.vertices += len(mesh.data().vertices)
    place = at.key("vertices" if mesh.file is None else "file")
    limits.check("vertices", others.vertices, place.source, place.path)
    return mesh


def _read_mesh(data: object, at: At, folder: Path | None, limits: Limits, others: Meshes) -> Mesh:
    given: dict[str, Any]
    if isinstance(data, Mesh):
        given = {name: getattr(data, name) for name in Mesh.__struct_fields__}
    else:
        given = dict(data)  # type: ignore[call-overload]
        known_keys(given, [*Mesh.__struct_fields__, "type"], at)
    rest = {name: value for name, value in given.items() if name not in ARRAYS}
    mesh = read(Mesh, rest, at)
    arrays = {name: given[name] for name in ARRAYS if given.get(name) is not None}
    if mesh.file is not None:
        if arrays:
            raise at.says(f"file and {', '.join(arrays)} exclude each other; give one or the other")
        place = at.key("file")
        key = mesh.file, mesh.smooth, mesh.part  # as _OF_FILE
        if key in others.files:
            mesh.__dict__["_path"], mesh.__dict__["_data"] = others.files[key]
            return mesh
        path = others.paths.get(mesh.file) or resolve(mesh.file, folder, place)
        others.paths[mesh.file] = path
        mesh.__dict__["_path"] = path
        if isinstance(data, Mesh) and data.__dict__.get("_path") == path:  # read before, for another scene
            mesh.__dict__["_data"] = data.data()
            return mesh
        sizes = others.vertices, others.primitives
        times = max(others.named[key], 1)
        from clrt.meshfiles.file import read_mesh_file

        found = read_mesh_file(path, place, limits, mesh.smooth, *sizes, mesh.part, others.opened, times)
        _keep(mesh, path, found, place)
        others.files[key] = path, mesh.__dict__["_data"]
        return mesh
    if mesh.part is not None:
        raise at.key("part").says("only a file has parts; name one, or leave part out")
    for name in ("vertices", "faces"):
        if name not in arrays:
            raise at.says(f"the key {name!r} is missing; a mesh has vertices and faces, or a file")
    checked = read_arrays(arrays, at)
    mesh = msgspec.structs.replace(mesh, **checked)
    vertices, faces = checked["vertices"], checked["faces"]
    normals, uv = None if mesh.smooth is False else checked.get("normals"), checked.get("uv")
    smooth = bool(mesh.smooth) or normals is not None
    if not smooth:
        check_flat(vertices, faces, at.key("faces"))
    if isinstance(faces, tuple) and (smooth or uv is not None):
        faces = _without_concave(vertices, faces, at)
    if smooth and normals is None:  # of triangles that are in the mesh: others may face the other way
        from clrt.meshfiles.parts import vertex_normals

        normals = vertex_normals(vertices, faces if isinstance(faces, np.ndarray) else _fan(faces))
        normals.flags.writeable = False
    mesh.__dict__["_data"] = MeshData(vertices, faces, normals, uv)
    return mesh


def _without_concave(vertices: np.ndarray, faces: tuple[np.ndarray, ...], at: At) -> tuple[np.ndarray, ...]:
    """The faces, with triangles in place of those that a fan about their first corner would not cover alone.

    What is smooth or shows a picture is made of fans, so these would reach beyond the face.
    """
    from clrt.meshfiles.outlines import Outlines

    outlines = Outlines()
    if len(faces) <= FEW:
        found = [outlines.few(vertices, face) for face in faces]
        clear = [part for part in found if part is not None]
        if len(clear) == len(faces):
            return _told(outlines, at, clear)
    sizes = np.fromiter(map(len, faces), np.int64, len(faces))
    parts: list[Sequence[np.ndarray]] = [(face,) for face in faces]
    for size in np.unique(sizes[sizes > 3]):
        which = np.flatnonzero(sizes == size)
        corners = np.array([faces[k] for k in which])
        rows, cuts = outlines.cut(vertices, corners)
        for row, cut in zip(rows, cuts, strict=True):
            triangles = corners[row][cut]
            triangles.flags.writeable = False
            parts[which[row]] = tuple(triangles)
    return _told(outlines, at, parts)


def _told(outlines: Outlines, at: At, parts: Iterable[Iterable[np.ndarray]]) -> tuple[np.ndarray, ...]:
    """The parts of all faces as one; what stays as it was is told."""
    for text in outlines.left_over:
        warn(at.source, at.path, text)
    return tuple(chain.from_iterable(parts))


def mesh_of_file(path: Path, arrays: Arrays, at: At, **keys: Any) -> Mesh:
    """The mesh of a file that is read already; `path` is resolved, `keys` are those of its table."""
    mesh = read(Mesh, keys, at)
    _keep(mesh, path, arrays, at)
    return mesh


def _keep(mesh: Mesh, path: Path, arrays: Arrays, at: At) -> None:
    """Give a mesh the checked arrays of its file."""
    loaded = dict(zip(ARRAYS, arrays, strict=True))
    present = {name: array for name, array in loaded.items() if array is not None}
    checked = read_arrays(present, at, own=True)
    mesh.__dict__["_path"] = path
    mesh.__dict__["_data"] = MeshData(**{"normals": None} | checked)


def edited_mesh(before: Mesh, table: Mapping[str, Any], at: At, folder: Path | None, limits: Limits) -> Mesh:
    """The checked mesh of a table made of `before`; arrays that are still its own are not read again."""
    own = [name for name in (*ARRAYS, *_OF_FILE) if table.get(name) is getattr(before, name)]
    if len(own) == len(ARRAYS) + len(_OF_FILE):
        rest = {name: value for name, value in table.items() if name not in ARRAYS}
        mesh = msgspec.structs.replace(read(Mesh, rest, at), **{name: table[name] for name in ARRAYS})
        mesh.__dict__.update(before.__dict__)
        return mesh
    given = before if before.file is None else before.data()
    vertices = table.get("vertices")
    if given.vertices is not None and isinstance(vertices, (list, tuple, np.ndarray)):
        count, most = len(vertices), len(given.vertices)
        if count != most and table.get("faces") is given.faces:
            raise at.key("vertices").says(f"{count} in place of {most}; give as many, or faces as well")
        if count != most and given is not before:  # another mesh than the file's
            of_file = {name for name in ("normals", "uv") if table.get(name) is getattr(given, name)}
            table = {name: None if name in of_file else value for name, value in table.items()}
    return read_mesh(dict(table), at, folder, limits)


def _fan(faces: tuple[np.ndarray, ...]) -> np.ndarray:
    rows = map(np.ndarray.tolist, faces)  # numpy takes far longer for so few
    return np.array([(row[0], *pair) for row in rows for pair in pairwise(row[1:])], np.int32)


def _same(mine: Any, other: Any) -> bool:
    if isinstance(mine, (list, tuple)) or isinstance(other, (list, tuple)):
        if type(mine) is not type(other) or len(mine) != len(other):
            return False
        return all(map(np.array_equal, mine, other))
    if isinstance(mine, np.ndarray) or isinstance(other, np.ndarray):
        return mine is not None and other is not None and np.array_equal(mine, other)
    return bool(mine == other)
