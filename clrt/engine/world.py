"""The scene on the device: the flattened arrays as buffers, and the tree over them."""

from __future__ import annotations

from copy import copy
from typing import Any, Final

import numpy as np

from clrt import layout
from clrt.base.log import log
from clrt.device.device import Device
from clrt.engine import tree
from clrt.flatten.flatten import FlatScene

_CHUNK: Final = 1 << 18  # bytes compared at once

_SMALL: Final = 1024  # nodes: they and what their leaves hold stay in a core's own caches


# what the builder writes, and the record that counts it
_MADE: Final = ("scene", "nodes", "triangle_blocks", "sphere_blocks", "order")


class World:
    """Owns the scene's buffers on a device. `arguments` are what a kernel's WORLD_PARAMETERS take; `small`:
    the tree is.

    The device's kernels must be those for the scene's rays: `device.variant(flat.ray_format)`.
    """

    flat: FlatScene
    _buffers: dict[str, Any]  # the sections by name, and what `tree.build` says of the tree
    _levels: tree.Levels | None = None  # of the tree, once it was refitted

    def __init__(self, device: Device, flat: FlatScene) -> None:
        if device.ray_format != flat.ray_format:
            raise ValueError(f"kernels for {device.ray_format}; the scene has {flat.ray_format}")
        buffers: dict[str, Any] = {
            name: device.upload(getattr(flat, name), kind=kind) for name, kind in _tables(flat).items()
        }
        self._take(device, flat, buffers | tree.build(device, flat, buffers))

    def update(self, device: Device, flat: FlatScene) -> str:
        """Hold another scene, whose rays the device's kernels are for, at the least cost, and say which.

        "nothing" where all arrays are equal; "tables" where some were sent; "refit" where the tree's boxes
        were made anew; "rebuild" where the tree was built anew.
        """
        tables = _tables(flat)
        changed = [name for name in tables if not _same(getattr(self.flat, name), getattr(flat, name))]
        buffers = self._buffers.copy()
        for name in changed:
            buffers[name] = device.upload(getattr(flat, name), kind=tables[name])
        cost = "tables"
        moved = {"primitives", "triangles", "spheres"} & set(changed) or self.flat.boxes is not flat.boxes
        if moved and not all(map(_same, _in_tree(self.flat), _in_tree(flat))):
            fitting = self._refitted(device, flat, buffers)
            buffers |= fitting or tree.build(device, flat, buffers)
            cost = "refit" if fitting else "rebuild"
            if not fitting:
                self._levels = None
        elif not changed and _same(self.flat.scene, flat.scene) and _sections(self.flat) == _sections(flat):
            self.flat = flat
            return "nothing"
        self._take(device, flat, buffers)
        return cost

    def _refitted(self, device: Device, flat: FlatScene, buffers: dict[str, Any]) -> dict[str, Any] | None:
        """The tree's sections for primitives that only moved; None where it must be built."""
        if not len(flat.finite) or not all(map(_same, _numbers(self.flat), _numbers(flat))):
            return None
        if self._levels is None:
            self._levels = tree.levels_of(device, self._buffers)
        return tree.refitted(device, flat, buffers, self._buffers, self._levels)

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
    """What the tree is made of: all but the surfaces of lights, the last primitives of each kind."""
    spheres = np.count_nonzero(_own(flat)["kind"] == layout.KINDS["SPHERE"])
    return [flat.boxes, flat.triangles, flat.spheres[:spheres], *_numbers(flat)]


def _numbers(flat: FlatScene) -> list[np.ndarray]:
    """Which primitives the tree is made of."""
    own = _own(flat)
    return [flat.finite, own["kind"], own["index"]]


def _own(flat: FlatScene) -> np.ndarray:
    """The primitives without the surfaces of lights."""
    return flat.primitives[: int(flat.scene["primitives"][0] - flat.scene["surfaces"][0])]


def _same(one: np.ndarray | None, other: np.ndarray | None) -> bool:
    """Whether two arrays hold the same bits; the same array is not looked at. None: a scene has none."""
    if one is other:
        return True
    if one is None or other is None or one.dtype != other.dtype or one.shape != other.shape:
        return False
    first, second = (np.ascontiguousarray(array).reshape(-1).view(np.uint8) for array in (one, other))
    # what differs mostly does from the start; and the processor's caches hold as much
    return all(
        np.array_equal(first[start : start + _CHUNK], second[start : start + _CHUNK])
        for start in range(0, len(first), _CHUNK)
    )
