"""The scene on the device: the flattened arrays as buffers, and the tree built over them there."""

from __future__ import annotations

from typing import Any

import numpy as np

from clrt import layout
from clrt.device import Device
from clrt.flatten import FlatScene


class World:
    """Owns the scene's buffers on a device. `arguments` are what a kernel's WORLD_PARAMETERS take."""

    def __init__(self, device: Device, flat: FlatScene) -> None:
        self.flat = flat
        nodes, order, info = _build_tree(device, flat)
        buffers: dict[str, Any] = {"nodes": nodes, "order": order, "scene": device.upload(info)}
        for name in layout.WORLD:
            if name not in buffers:
                buffers[name] = device.upload(getattr(flat, name))
        self.arguments: tuple[Any, ...] = tuple(buffers[name] for name in layout.WORLD)
        self.lights = int(info["lights"][0])
        self.tinted = bool(info["tinted"][0])
        self.ambient_samples = int(info["ambient_samples"][0])


def _build_tree(device: Device, flat: FlatScene) -> tuple[Any, Any, np.ndarray]:
    """Buffers of nodes and leaf order, and the scene's record with the number of nodes filled in."""
    count = len(flat.finite)
    node_bytes = max(2 * count - 1, 1) * layout.dtype("Node").itemsize
    nodes = device.buffer(node_bytes)
    order = device.upload(np.arange(max(count, 1), dtype=np.int32))
    info = flat.scene.copy()
    info["nodes"] = 0
    if count:
        boxes, finite = device.upload(flat.boxes), device.upload(flat.finite)
        used = device.buffer(4)
        device.launch("build_tree", 1, boxes, np.int32(count), order, nodes, used, local_size=1)
        device.launch("number_leaves", count, finite, np.int32(count), order)
        info["nodes"] = device.read(used, np.empty(1, np.int32))[0]
    return nodes, order, info
