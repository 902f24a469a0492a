"""The scene on the device: the flattened arrays as buffers, and the tree built over them there."""

from __future__ import annotations

from copy import copy
from typing import Any, Final

import numpy as np

from clrt import layout
from clrt.base.log import log
from clrt.device import hugepages
from clrt.device.device import Device
from clrt.flatten.flatten import FlatScene

_SUBTREES: Final = 32  # parts of the tree that cores build side by side
_SHARED_SUBTREE: Final = 4096  # a part of fewer primitives is not split further for the sake of sharing

_SMALL: Final = 1024  # nodes: they and what their leaves hold stay in a core's own caches


# what the builder writes, and the record that counts it
_MADE: Final = ("scene", "nodes", "triangle_blocks", "sphere_blocks", "order")


class World:
    """Owns the scene's buffers on a device. `arguments` are what a kernel's WORLD_PARAMETERS take; `small`:
    the tree is.

    The device's kernels must be those for the scene's rays: `device.variant(flat.ray_format)`.
    """

    flat: FlatScene
    _buffers: dict[str, Any]  # the sections by name, and `count`, the nodes of the tree

    def __init__(self, device: Device, flat: FlatScene) -> None:
        if device.ray_format != flat.ray_format:
            raise ValueError(f"kernels for {device.ray_format}; the scene has {flat.ray_format}")
        self.overflow = device.upload(np.zeros(1, np.uint32))  # 1 once a list of media was too short
        buffers: dict[str, Any] = {
            name: device.upload(getattr(flat, name), kind=kind) for name, kind in _tables(flat).items()
        }
        self._take(device, flat, buffers | _build_tree(device, flat, buffers))

    def update(self, device: Device, flat: FlatScene) -> str:
        """Hold another scene, for rays of the same format, at the least cost, and say which.

        "nothing" where all arrays are equal; "tables" where some were sent; "rebuild" where the tree was
        built anew.
        """
        tables = _tables(flat)
        changed = [name for name in tables if not _same(getattr(self.flat, name), getattr(flat, name))]
        buffers = self._buffers.copy()
        for name in changed:
            buffers[name] = device.upload(getattr(flat, name), kind=tables[name])
        moved = {"primitives", "triangles", "spheres"} & set(changed) or self.flat.boxes is not flat.boxes
        if moved and not all(map(_same, _in_tree(self.flat), _in_tree(flat))):
            buffers |= _build_tree(device, flat, buffers)
            changed.append("tree")
        elif not changed and _same(self.flat.scene, flat.scene):
            self.flat = flat
            return "nothing"
        self._take(device, flat, buffers)
        return "rebuild" if "tree" in changed else "tables"

    def lit_by(self, device: Device, number: int) -> World:
        """The same world with one of its lights alone, for passes that are to say what that one brings."""
        alone, lights = copy(self), self.flat.lights.copy()
        # the others keep their numbers, by which points are drawn
        lights["samples"][np.arange(len(lights)) != number] = 0
        alone._buffers = self._buffers | {"lights": device.upload(lights)}
        alone.arguments = tuple(alone._buffers[name] for name in _sections(self.flat))
        return alone

    def _take(self, device: Device, flat: FlatScene, buffers: dict[str, Any]) -> None:
        """Hold a scene whose sections are on the device, all but its own record."""
        info = flat.scene.copy()
        info["nodes"] = buffers["count"]
        buffers["scene"] = device.upload(info)
        self.flat, self._buffers = flat, buffers
        self.arguments: tuple[Any, ...] = tuple(buffers[name] for name in _sections(flat))
        nodes = int(info["nodes"][0])
        log.info("scene on the device: %d primitives, tree of %d nodes", int(info["primitives"][0]), nodes)
        self.small = nodes < _SMALL
        self.lights = int(info["lights"][0])
        self.surfaces = bool(info["surfaces"][0])
        self.tinted = bool(info["tinted"][0])
        self.ambient_samples = int(info["ambient_samples"][0])


def _sections(flat: FlatScene) -> dict[str, str]:
    return layout.world(flat.ray_format.images)


def _tables(flat: FlatScene) -> dict[str, str]:
    """The sections that the scene has as arrays, and their element types."""
    return {name: kind for name, kind in _sections(flat).items() if name not in _MADE}


def _in_tree(flat: FlatScene) -> list[np.ndarray]:
    """What the tree is made of, and the kinds: all but the surfaces of lights, which are the last of each."""
    own = flat.primitives[: int(flat.scene["primitives"][0] - flat.scene["surfaces"][0])]
    spheres = np.count_nonzero(own["kind"] == layout.KINDS["SPHERE"])
    return [flat.boxes, flat.finite, flat.triangles, flat.spheres[:spheres], own["kind"], own["index"]]


def _same(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two arrays hold the same bits; the same array is not looked at."""
    if one is other:
        return True
    if one.dtype != other.dtype or one.shape != other.shape:
        return False
    first, second = (np.ascontiguousarray(array).view(np.uint8) for array in (one, other))
    return bool(np.array_equal(first, second))


def _build_tree(device: Device, flat: FlatScene, world: dict[str, Any]) -> dict[str, Any]:
    """The tree over the finite primitives: the sections that the builder writes, and `count`, its nodes."""
    n = len(flat.finite)
    size = {
        name: layout.dtype(layout.WORLD[name]).itemsize
        for name in ("nodes", "triangle_blocks", "sphere_blocks")
    }
    if n == 0:
        empty = {name: device.buffer(nbytes, layout.WORLD[name]) for name, nbytes in size.items()}
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
    nodes, leaves = device.buffer(inner * size["nodes"], "WideNode"), device.buffer(3 * most * 8, "int2")
    hugepages.ask(device.queue, nodes, inner * size["nodes"])
    device.launch("collapse", 1, binary, ways, nodes, np.int32(most), leaves, counts, local_size=1)
    used, *blocks = (int(c) for c in device.read(counts, np.empty(4, np.int32)))
    out = {"count": used, "nodes": nodes, "order": device.buffer(max(blocks[2], 1) * 32, "int")}
    host_leaves = device.read(leaves, np.empty((3, most, 2), np.int32))
    for kind, (name, packer, source) in enumerate(
        (("triangle_blocks", "pack_triangles", "triangles"), ("sphere_blocks", "pack_spheres", "spheres"))
    ):
        out[name] = device.buffer(max(blocks[kind], 1) * size[name], layout.WORLD[name])
        hugepages.ask(device.queue, out[name], blocks[kind] * size[name])
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
