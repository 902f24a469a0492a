"""A kernel that is given something else than it takes is refused before it is launched."""

from __future__ import annotations

import re

import numpy as np
import pytest

from clrt import layout
from clrt.device.device import Device
from clrt.engine import passes
from clrt.engine.queues import CAMERA, new_queue
from clrt.engine.world import World
from clrt.flatten.flatten import flatten
from clrt.formats import load_dict
from clrt.layout import parameters


def test_the_signatures_are_those_of_the_source() -> None:
    device = Device()
    found = parameters.signatures(device.kernels.source)
    assert set(found) == set(re.findall(r"__kernel\s+void\s+(\w+)", device.kernels.source))
    world = [(name, kind) for name, kind in layout.WORLD.items()]
    rays, words = [("rays", "float")], [("pixel_of", "uint"), ("path", "uint")]
    queue = [*rays, *words, ("weights", "float"), ("media", "int")]
    hits = [("hit_t", "float"), ("hit_primitive", "int"), ("surfaces", "float"), ("surface_code", "int")]
    assert list(found["closest"]) == [*world, *queue, ("n", np.uint32), *hits, ("sequence", "uint")]
    assert found["resolve"] == (("n", np.uint32), ("samples", np.float32), ("film", "float"))
    assert ("leaves", "int2") in found["pack_triangles"] and found["offsets"][2] == ("totals", "ulong")


def test_what_a_kernel_uses_of_its_groups() -> None:
    source = Device().kernels.source
    names = [name for name, _ in parameters.signatures(source)["generate"]]
    assert {names[k] for k in parameters.used(source, "generate")} == set(names) - {"media"}
    names = [name for name, _ in parameters.signatures(source)["reflect"]]
    unused = {"hit_primitive", "local_radiance", "generation"}
    assert not unused & {names[k] for k in parameters.used(source, "reflect")}
    assert {"weights", "slot", "child_rays"} <= {names[k] for k in parameters.used(source, "reflect")}


def test_a_wrong_argument_is_an_error_before_the_launch() -> None:
    device = Device()
    film = device.upload(np.ones(4, np.float32))
    right = (np.uint32(4), np.float32(2), film)
    wrong = {
        "takes 3 arguments, not 2": right[:2],
        "argument 1, samples, is uint32, not float32": (right[0], right[0], film),
        "argument 0, n, is float32, not uint32": (right[1], right[0], film),
        "argument 2, film, is a buffer of uint, not a buffer of float": (
            *right[:2],
            device.upload(np.ones(4, np.uint32)),
        ),
        "argument 2, film, is a buffer of no kind, not a buffer of float": (*right[:2], device.buffer(16)),
    }
    for text, arguments in wrong.items():
        with pytest.raises(TypeError, match=f"kernel resolve.* {text}"):
            device.launch("resolve", 4, *arguments)
    assert (device.read(film, np.empty(4, np.float32)) == 1).all(), "nothing was launched"
    device.launch("resolve", 4, *right)
    assert (device.read(film, np.empty(4, np.float32)) == 0.5).all()


def test_groups_are_in_the_order_of_the_table() -> None:
    """Swapped, missing or doubled groups do not pass for each other."""
    device = Device()
    shapes = [{"type": "sphere", "center": [0, 0, 0], "radius": 1}]
    world = World(device, flatten(load_dict({"shapes": shapes})))
    queue = new_queue(device, CAMERA, 5)
    hits = passes.closest(device, world, queue)
    groups = (world.arguments, queue.arguments, hits.arguments)
    for mixed in ((0, 2, 1), (0, 1), (1, 0, 2), (0, 1, 2, 2)):
        with pytest.raises(TypeError, match="kernel surface"):
            device.launch_packets("surface", queue.n, *(one for k in mixed for one in groups[k]))


def test_every_record_is_known_by_its_fields() -> None:
    for bands in (3, 4, 20):
        for name in layout.RECORDS:
            assert parameters.element(layout.dtype(name, bands)) == name
    assert parameters.element(np.dtype(np.uint8)) == "uchar"
    assert parameters.element(np.dtype(np.complex64)) is None
