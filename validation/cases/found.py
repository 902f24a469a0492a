"""Scenes on which an oracle and the kernels once disagreed, or a fault went unnoticed; each says which."""

from __future__ import annotations

from collections.abc import Iterator

from .parts import CLEAR, OPAQUE, Table, room


def scenes() -> Iterator[tuple[str, Table, set[str]]]:
    """Name, scene and what nobody can see from the scene's tables."""
    yield "next to the camera", _next_to_the_camera(), set()
    yield "cylinder upon cylinder", _cylinder_upon_cylinder(), set()


def _next_to_the_camera() -> Table:
    """Something 0.02 from a camera at 8.5: its distance is as exact as the coordinates, not as itself.

    Random scene 1/0, where a box was 0.011 away, failed the gate on distances: 4e-5 of them.
    """
    disk = {"type": "disk", "center": [0.001, 0.7975, 8.48], "normal": [0.1, 0.3, 1], "radius": 0.004}
    ball = {"type": "sphere", "center": [1.2, -0.6, 0.5], "radius": 1.2, "material": OPAQUE["shiny"]}
    return room([{**disk, "material": OPAQUE["metal"]}, ball])


def _cylinder_upon_cylinder() -> Table:
    """Cylinders of one axis and one radius, the lower one of clear sheets.

    Mitsuba's meshes around them reach beyond their ends and coincided there; of two hits at once it gave one,
    which then counted as a miss. The pencil's glass, a scene that ships, had half of its rim.
    """
    tube = {"type": "cylinder", "radius": 1.2}
    return room([
        {**tube, "p0": [0.3, -2.0, 0.4], "p1": [0.3, 0.5, 0.4], "material": {**CLEAR["glass"], "thin": True}},
        {**tube, "p0": [0.3, 0.5, 0.4], "p1": [0.3, 1.1, 0.4], "material": OPAQUE["matte"]},
    ])  # fmt: skip
