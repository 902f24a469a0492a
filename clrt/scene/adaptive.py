"""More samples where neighbours differ, as a scene states it."""

from __future__ import annotations

import math
from typing import Annotated, Any, Final

from msgspec import Meta

from clrt.base.places import At
from clrt.base.records import Record


class Adaptive(Record, frozen=True, kw_only=True):
    """How far a picture's samples are increased where it needs them.

    All pixels get `camera.spp` samples; those that differ from a neighbour get the grid of twice as many a
    side, and so on up to `spp`, which is `camera.spp` times a power of 4. `threshold`, from 0 to 1: colours
    differ where square roots of a channel do by more than its root; 0 refines wherever they differ at all.
    """

    spp: Annotated[
        int, Meta(ge=1, le=1 << 24, description="must be camera.spp times a power of 4, such as 16 or 64")
    ] = 64
    threshold: Annotated[
        float, Meta(ge=0, le=1, description="must be a number from 0 to 1, such as 0.01")
    ] = 0.01

    def check_reached(self, spp: int, at: At) -> None:
        """SceneError where doubling the sides of a grid of `spp` samples does not lead to this one."""
        if not is_reached(spp, self.spp):
            near = f"{' or '.join(map(str, _reached(spp, self.spp)))}"
            text = f"grids double their sides from camera.spp = {spp} on: it must be {spp} times a power of 4"
            raise at.key("spp").error(self.spp, f"{text}, such as {near}")


SAMPLED: Final = ("camera", "adaptive", "conformance")  # fields of a scene that `check_samples` looks at


def check_samples(scene: Any) -> None:
    """SceneError where the samples that a `Scene` states and those of its `adaptive` do not go together.

    Not after `override`: pictures are looked at by themselves.
    """
    check_uneven(scene)
    if scene.adaptive is not None and scene.camera is not None:
        scene.adaptive.check_reached(scene.camera.spp, At(scene.source, "adaptive"))


def check_uneven(scene: Any) -> None:
    """SceneError where the samples of a `Scene` differ from pixel to pixel and must not."""
    if scene.adaptive is not None and scene.conformance != "none":
        text = "conformance counts the rays of one even grid; leave one of them out"
        raise At(scene.source, "adaptive").says(text)


def is_reached(first: int, last: int) -> bool:
    """Is `last` the number `first` times a power of 4?"""
    while first < last:
        first *= 4
    return first == last


def _reached(first: int, wanted: int) -> tuple[int, int]:
    """Two numbers about `wanted` that can be."""
    steps = max(0, math.floor(math.log(max(wanted / first, 1.0), 4)))
    return first * 4**steps, first * 4 ** (steps + 1)
