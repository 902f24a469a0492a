"""The tree over the finite primitives, on the device: built, or refitted to primitives that moved.

A refitted tree has the nodes and leaves of the one before, and new boxes. The picture depends on neither.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from clrt import layout
from clrt.device import hugepages
from clrt.device.device import Device
from clrt.flatten.flatten import FlatScene
from clrt.scene.mesh import Mesh
from clrt.scene.scene import Scene

Sections = dict[str, Any]

_SUBTREES: Final = 32  # parts of the tree that cores build side by side
_SHARED_SUBTREE: Final = 4096  # a part of fewer primitives is not split further for the sake of sharing
_SIZE: Final = {
    name: layout.dtype(layout.WORLD[name]).itemsize for name in ("nodes", "triangle_blocks", "sphere_blocks")
}
# bytes of a face: its primitive, box, two nodes and number twice; if smooth, its triangle and three normals
_PARTS: Final = ("Primitive", "Box", "BuildNode", "BuildNode")
_LEAST: Final = sum(layout.dtype(name).itemsize for name in _PARTS) + 8
_SMOOTH: Final = layout.dtype("Triangle").itemsize + 3 * layout.dtype("float4").itemsize
WORN: Final = 1.5  # a tree that costs so many times what it did when it was built is built anew


def least_bytes(scene: Scene) -> int:
    """What a device holds at least while the tree over a scene's meshes is built, from counts alone."""
    total = 0
    for mesh in (shape for shape in scene.shapes if type(shape) is Mesh):
        smooth = mesh.data().normals is not None
        total += mesh.primitives * (_LEAST + (_SMOOTH if smooth else 0))
    return total


def _space(device: Device, section: str, count: int) -> Any:
    """A buffer for so many records of a section, on large pages."""
    nbytes = max(count, 1) * _SIZE[section]
    found = device.buffer(nbytes, layout.WORLD[section])
    hugepages.ask(device.queue, found, nbytes)
    return found


def build(device: Device, flat: FlatScene, world: dict[str, Any]) -> Sections:
    """The tree over the finite primitives: the sections that the builder writes, and `count`, its nodes."""
    n = len(flat.finite)
    if n == 0:
        empty = {name: _space(device, name, 1) for name in _SIZE}
        return {"count": 0, "order": device.buffer(32, "int"), **empty}
    kinds = flat.primitives["kind"][flat.finite]
    block_kinds = np.full(n, layout.BLOCKS["BLOCK_OTHER"], np.uint8)
    block_kinds[kinds == layout.KINDS["TRIANGLE"]] = layout.BLOCKS["BLOCK_TRIANGLE"]
    block_kinds[kinds == layout.KINDS["SPHERE"]] = layout.BLOCKS["BLOCK_SPHERE"]
    boxes, kind_buffer, finite = (
        device.upload(flat.boxes),
        device.upload(block_kinds),
        device.upload(flat.finite),
    )
    item = device.upload(np.arange(n, dtype=np.int32))
    binary = device.buffer((2 * n + 2 * _SUBTREES) * layout.dtype("BuildNode").itemsize, "BuildNode")
    tasks, counts = device.buffer(16 * _SUBTREES, "int4"), device.buffer(16, "int")
    ways = device.buffer(layout.dtype("Ways").itemsize * _SUBTREES, "Ways")
    device.launch(
        "split_top",
        1,
        boxes,
        kind_buffer,
        np.int32(n),
        np.int32(_SUBTREES),
        np.int32(_SHARED_SUBTREE),
        item,
        binary,
        tasks,
        counts,
        local_size=1,
    )
    parts = (boxes, kind_buffer, tasks, counts, item, binary, ways)
    device.launch("build_subtree", _SUBTREES, *parts, local_size=1)

    # binary nodes that are no leaves, of which wide ones are made: few of the 2 n that there might be
    inner = _SUBTREES + int(device.read(ways, np.empty(_SUBTREES, layout.dtype("Ways")))["inner"].sum())
    most = inner + 2  # leaves, and the empty one
    wide, leaves = device.buffer(inner * _SIZE["nodes"], "WideNode"), device.buffer(3 * most * 8, "int2")
    device.launch("collapse", 1, binary, ways, wide, np.int32(most), leaves, counts, local_size=1)
    used, *blocks = (int(c) for c in device.read(counts, np.empty(4, np.int32)))
    del parts, binary, ways, boxes, kind_buffer, tasks  # as much memory as all that stays
    nodes = _space(device, "nodes", used)
    device.copy(nodes, wide, used * _SIZE["nodes"])
    del wide
    order = device.buffer(max(blocks[2], 1) * 32, "int")
    out: Sections = {"count": used, "blocks": tuple(blocks), "nodes": nodes, "order": order}
    host_leaves = device.read(leaves, np.empty((3, most, 2), np.int32))
    for kind, (name, packer, source) in enumerate(
        (("triangle_blocks", "pack_triangles", "triangles"), ("sphere_blocks", "pack_spheres", "spheres"))
    ):
        out[name] = _space(device, name, blocks[kind])
        device.launch(
            packer,
            blocks[kind],
            device.upload(host_leaves[kind], kind="int2"),
            np.int32(blocks[kind]),
            item,
            finite,
            world["primitives"],
            world[source],
            out[name],
        )
    device.launch(
        "pack_others",
        blocks[2],
        device.upload(host_leaves[2], kind="int2"),
        np.int32(blocks[2]),
        item,
        finite,
        out["order"],
    )
    device.finish()
    return out


@dataclass(frozen=True)
class Levels:
    """What a refit must know of a tree.

    nodes: their numbers (device, uint), level by level. sizes: how many each level has, the root's first.
    cost: of the tree when it was built.
    """

    nodes: Any
    sizes: tuple[int, ...]
    cost: float


def levels_of(device: Device, tree: Sections) -> Levels:
    """Those of a tree that was just built."""
    children = device.read(tree["nodes"], np.empty(tree["count"], layout.dtype("WideNode")))["child"]
    levels = [np.zeros(1, np.int32)]
    while len(levels[-1]):
        below = children[levels[-1]]
        levels.append(below[below >= 0])
    numbers = device.upload(np.concatenate(levels).astype(np.uint32))
    return Levels(numbers, tuple(map(len, levels[:-1])), _cost(device, tree["nodes"], tree["count"]))


def refitted(
    device: Device, flat: FlatScene, world: Sections, tree: Sections, levels: Levels
) -> Sections | None:
    """What is new of a tree over the primitives of `tree` where these are now, in `world`.

    None where it would be worn: costs more than WORN times what it did when built. `tree` stays as it is.
    """
    count, blocks = tree["count"], tree["blocks"]
    boxes = device.upload(_by_number(flat))
    out = {name: _space(device, name, blocks[k]) for k, name in enumerate(_BLOCKS)}
    out["nodes"] = _space(device, "nodes", count)
    for k, (name, (kernel, source)) in enumerate(_BLOCKS.items()):
        parts = (np.int32(blocks[k]), tree[name], world["primitives"], world[source], out[name])
        device.launch(kernel, blocks[k], *parts)
    held = (tree["triangle_blocks"], tree["sphere_blocks"], tree["order"])
    device.launch("refit_leaves", count, np.int32(count), boxes, *held, tree["nodes"], out["nodes"])
    first = count
    for size in reversed(levels.sizes):
        first -= size
        device.launch("refit_level", size, levels.nodes, np.int32(first), np.int32(size), out["nodes"])
    return out if _cost(device, out["nodes"], count) <= WORN * levels.cost else None


_BLOCKS: Final = {
    "triangle_blocks": ("refill_triangles", "triangles"), "sphere_blocks": ("refill_spheres", "spheres")
}  # fmt: skip


def _by_number(flat: FlatScene) -> np.ndarray:
    """The boxes by the numbers of their primitives."""
    if int(flat.finite[-1]) == len(flat.finite) - 1:
        return flat.boxes
    out = np.zeros(int(flat.finite[-1]) + 1, flat.boxes.dtype)
    out[flat.finite] = flat.boxes
    return out


def _cost(device: Device, nodes: Any, count: int) -> float:
    """Boxes that a ray which meets the whole tree is likely to meet (the surface-area heuristic)."""
    areas = device.buffer(8 * count, "float")
    device.launch("box_areas", count, np.int32(count), nodes, areas)
    found = device.read(areas, np.empty((count, 2), np.float32)).astype(np.float64)
    with np.errstate(invalid="ignore", divide="ignore"):  # a tree without extent, or beyond float32
        return float(found[:, 0].sum() / found[0, 1])
