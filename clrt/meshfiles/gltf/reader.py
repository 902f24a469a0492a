"""Triangles of glTF files: what the nodes of its scene place where.

The sizes that accessors declare are summed over all nodes before an array is made of any; the numbers of an
accessor are then a view of the file's bytes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final

import numpy as np

from clrt.meshfiles.broken import BrokenMesh
from clrt.meshfiles.gltf.document import (
    Attributes,
    Document,
    Node,
    Primitive,
    SceneNodes,
    animated,
    item,
    parse,
    unread,
)
from clrt.meshfiles.gltf.look import Held, look_of
from clrt.meshfiles.gltf.nodes import matrix_of
from clrt.meshfiles.gltf.stored import Fetch, Stored
from clrt.meshfiles.gltf.textures import Itself, picture_count, textured_in
from clrt.meshfiles.look import NONE, Look, Used
from clrt.meshfiles.parts import Arrays, Part, Placed

_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_BARE: Final = {0: "points", 1: "lines", 2: "lines", 3: "lines"}


def read_gltf(
    data: bytes, binary: bool, fetch: Fetch, check: Callable[[int], None], itself: Itself, colors: bool = True
) -> Placed:
    """The triangles in a .gltf, or, if `binary`, a .glb.

    `fetch` gives the contents of a file beside it, `check` raises where there are too many triangles,
    `itself` is what its look has to know of the file, `colors` whether those of vertices are of use.
    BrokenMesh where the file contradicts itself. Points, lines and morph targets are left out; animations and
    skins are not read; materials, cameras and lights only by the `look` of what is placed, which also names
    what of all this is not in `left_out`.
    """
    document, chunk = parse(data, binary)
    return _Reader(document, chunk, fetch, itself, colors).placed(check)


@dataclass(eq=False)
class _Reader:
    document: Document
    chunk: memoryview | None
    fetch: Fetch
    itself: Itself | None = None
    colors: bool = False

    def __post_init__(self) -> None:
        self.stored = Stored(self.document, self.chunk, self.fetch)
        self.numbers: dict[tuple[Any, ...], int | None] = {}  # what a primitive shows -> number of its part
        self.parts: list[Part] = []
        self.left_out: dict[str, None] = {}  # in the order in which it was met
        self.unseen: dict[str, None] = {}  # likewise, of what a mesh alone may well lack
        self.leaning: set[int] = set()  # materials of what has tangents
        self.names: list[str] = []  # of the nodes that have a mesh
        self.cameras: list[Held] = []
        self.lights: list[Held] = []
        self.textured = textured_in(self.document)

    def placed(self, check: Callable[[int], None]) -> Placed:
        """What the nodes of the scene show, in the order of a walk that takes the last child first."""
        shown: dict[int, np.ndarray] = {}  # mesh -> (n, 2) the numbers of its parts and their materials
        matrices, meshes = self._nodes()
        faces: dict[int, int] = {}
        for mesh in meshes:
            if mesh not in shown:
                primitives = item(self.document.meshes, mesh, "meshes").primitives
                pairs = [(self._number(primitive), primitive.material) for primitive in primitives]
                rows = [(n, NONE if m is None else m) for n, m in pairs if n is not None]
                shown[mesh] = np.array(rows, np.int64).reshape(-1, 2)
                faces[mesh] = sum(self.parts[n].faces for n, _ in rows)
        check(sum(faces[mesh] for mesh in meshes))
        found = [shown[mesh] for mesh in meshes]
        which = np.concatenate([np.zeros((0, 2), np.int64), *found])
        where = np.repeat(np.arange(len(found), dtype=np.int32), [len(rows) for rows in found])
        says = self.cameras or self.lights or (which[:, 1] != NONE).any()
        says = says or any(part.colored for part in self.parts) or unread(self.document) or self.unseen
        return Placed(
            self.parts,
            which[:, 0].astype(np.int32),
            where,
            matrices,
            tuple(self.left_out),
            materials=which[:, 1],
            names=self.names,
            look=self._look if says else None,
            colors=picture_count(self.document) if any(part.corners for part in self.parts) else 0,
            textured=self.textured,
        )

    def _look(self, materials: Used, center: np.ndarray, radius: float) -> Look:
        assert self.itself is not None
        itself = replace(self.itself, within=self.stored.first)
        look = look_of(self.document, itself, materials, self.cameras, self.lights, center, radius)
        leaning = [name for (number, _), name in look.called.items() if number in self.leaning]
        if any("normal_map" in look.materials[name] for name in leaning):
            look.left_out["tangents of normal maps"] = None
        look.left_out.update(self.unseen)
        return look

    def _nodes(self) -> tuple[np.ndarray, list[int]]:
        """Matrices to the world (n, 4, 4) of the scene's nodes that have a mesh, and the meshes' numbers."""
        nodes = self.document.nodes
        scene = self._scene()
        seen = bytearray(len(nodes))
        matrices: list[np.ndarray] = []
        meshes: list[int] = []
        root = np.eye(4)
        left = [(number, root, True) for number in scene.nodes]
        while left:
            number, above, seen_above = left.pop()
            node = item(nodes, number, "nodes")
            if seen[number]:
                raise BrokenMesh(f"nodes[{number}] is below two nodes, or below itself")
            seen[number] = 1
            matrix = matrix_of(node, number, above)
            visible = seen_above and (node.extensions is None or node.extensions.KHR_node_visibility.visible)
            left += [(child, matrix, visible) for child in node.children]
            self._hold(number, node, matrix, visible)
            if node.mesh is not None and visible:
                # joints place a mesh with a skin, its node does not: without them it is as it was made
                matrices.append(matrix if node.skin is None else root)
                meshes.append(node.mesh)
                self.names.append(node.name or item(self.document.meshes, node.mesh, "meshes").name)
                self._note(node, node.mesh)
        self._check_above(seen)
        return np.array(matrices).reshape(-1, 4, 4), meshes

    def _check_above(self, seen: bytearray) -> None:
        """Raise BrokenMesh where a node is seen that a node which is not would move."""
        for number, node in enumerate(self.document.nodes):
            for child in () if seen[number] else node.children:
                if child < len(seen) and seen[child]:
                    text = f"nodes[{child}] is in the scene, but stands below nodes[{number}], which is not"
                    raise BrokenMesh(text)

    def _scene(self) -> SceneNodes:
        """The scene that is shown: the one that the file names, or its first."""
        scenes, number = self.document.scenes, self.document.scene
        if number is None and not scenes:
            raise BrokenMesh("it has no scene that would say which of its nodes are shown; save it with one")
        self.unseen.update({"further scenes": None} if len(scenes) > 1 else {})
        self.unseen.update({"animations": None} if animated(self.document) else {})
        return item(scenes, number or 0, "scenes")

    def _hold(self, number: int, node: Node, matrix: np.ndarray, visible: bool) -> None:
        """Keep the camera and the light that stand at a node; a hidden one's camera still looks."""
        if node.camera is not None:
            self.cameras.append(Held(number, node.name, node.camera, matrix))
        if visible and node.extensions is not None and node.extensions.KHR_lights_punctual is not None:
            self.lights.append(Held(number, node.name, node.extensions.KHR_lights_punctual.light, matrix))

    def _note(self, node: Node, mesh: int) -> None:
        """Keep in mind what of a node with a mesh is not read and would move or multiply it."""
        if node.skin is not None:
            self.left_out["skins"] = None
        if any(node.weights or item(self.document.meshes, mesh, "meshes").weights):
            self.left_out["morph targets"] = None
        if node.extensions and node.extensions.EXT_mesh_gpu_instancing is not None:
            self.left_out["instances"] = None

    def _number(self, primitive: Primitive) -> int | None:
        """The number of the part that a primitive shows; None where it has no triangles."""
        attributes, mode = primitive.attributes, primitive.mode
        if attributes.POSITION is None:
            return None
        if mode not in (_TRIANGLES, _STRIP, _FAN):
            self.unseen[_BARE.get(mode, "primitives of unknown modes")] = None
            return None
        if attributes.TANGENT is not None and primitive.material is not None:
            self.leaning.add(primitive.material)
        plain = not self.colors or primitive.material is None or not self.textured(primitive.material)
        key = (attributes, primitive.indices, mode, plain)
        if key not in self.numbers:
            if primitive.extensions and primitive.extensions.KHR_draco_mesh_compression is not None:
                raise BrokenMesh("it is compressed (KHR_draco_mesh_compression); save it without compression")
            part = self._part(attributes, primitive.indices, mode, plain)
            self.numbers[key] = len(self.parts) if part.faces else None
            self.parts += [part] if part.faces else []
        return self.numbers[key]

    def _part(self, attributes: Attributes, indices: int | None, mode: int, plain: bool) -> Part:
        """A part; of one that shows no picture (`plain`) the colours of vertices are one."""
        assert attributes.POSITION is not None
        vertices = self.stored.accessor(attributes.POSITION, "VEC3").count
        corners = vertices if indices is None else self.stored.accessor(indices, "SCALAR").count
        if mode == _TRIANGLES and corners % 3:
            raise BrokenMesh(f"a primitive has {corners} corners, which make no triangles")
        faces = corners // 3 if mode == _TRIANGLES else max(corners - 2, 0)
        normals = attributes.NORMAL
        if normals is not None and self.stored.accessor(normals, "VEC3").count != vertices:
            raise BrokenMesh(f"accessors[{normals}] has not one normal for each of {vertices} vertices")
        uv = attributes.TEXCOORD_0
        if uv is not None and self.stored.accessor(uv, "VEC2").count != vertices:
            raise BrokenMesh(f"accessors[{uv}] has not one uv for each of {vertices} vertices")
        read = partial(self._arrays, attributes, indices, mode)
        colors = attributes.COLOR_0
        if colors is not None:
            found = item(self.document.accessors, colors, "accessors")
            if found.type not in ("VEC3", "VEC4") or found.count != vertices:
                raise BrokenMesh(f"accessors[{colors}] has not one colour for each of {vertices} vertices")
        part = Part(vertices, faces, normals is not None, colors is not None, read, uv is not None)
        if colors is None or not self.colors:
            return part
        if not plain:
            return replace(part, color=lambda: np.asarray(self._colors(colors).mean(axis=0)))

        def checked() -> Arrays:
            self._colors(colors)
            return read()

        return replace(part, read=checked, corners=lambda: self._colors(colors)[read()[1]])

    def _colors(self, number: int) -> np.ndarray:
        """The colours (n, 3) of vertices, which are linear; alpha is not read, but named if there is some."""
        colors, alpha = np.split(self.stored.fractions(number), [3], axis=1)
        if (alpha < 1).any():
            self.unseen["alpha of vertices' colours"] = None
        if not np.isfinite(colors).all():
            raise BrokenMesh(f"accessors[{number}] holds colours that are not finite")
        return np.asarray(np.clip(colors, 0.0, 1.0))

    def _arrays(self, attributes: Attributes, indices: int | None, mode: int) -> Arrays:
        assert attributes.POSITION is not None
        vertices = self.stored.numbers(attributes.POSITION)
        if indices is None:
            corners = np.arange(len(vertices))
        else:
            corners = self.stored.indices(indices)
            if corners.max() >= len(vertices):
                raise BrokenMesh(f"a face names vertex {corners.max()} of a part that has {len(vertices)}")
        normals = None if attributes.NORMAL is None else self.stored.numbers(attributes.NORMAL)
        # a file with quantization says what is scaled; in others uv of whole numbers can be parts alone
        quantized = "KHR_mesh_quantization" in self.document.extensionsRequired
        read = self.stored.numbers if quantized else self.stored.fractions
        uv = None if attributes.TEXCOORD_0 is None else read(attributes.TEXCOORD_0)
        return vertices, _triangles(corners, mode), normals, uv


def _triangles(corners: np.ndarray, mode: int) -> np.ndarray:
    """The triangles (m, 3) of corners in a row, one side out."""
    if mode == _TRIANGLES:
        return corners.reshape(-1, 3)
    if mode == _FAN:
        return np.stack([np.broadcast_to(corners[0], len(corners) - 2), corners[1:-1], corners[2:]], axis=1)
    faces = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    faces[1::2] = faces[1::2, ::-1]
    return faces
