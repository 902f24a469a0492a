"""Scenes on which an oracle and the kernels once disagreed, or a fault went unnoticed; each says which."""

from __future__ import annotations

from collections.abc import Iterator

from .crossed import INSIDE
from .parts import CAMERA, CLEAR, HEIGHT, LIGHTS, OPAQUE, WALL, WIDTH, Table, room


def scenes() -> Iterator[tuple[str, Table, set[str]]]:
    """Name, scene and what nobody can see from the scene's tables."""
    yield "next to the camera", _next_to_the_camera(), set()
    yield "cylinder upon cylinder", _cylinder_upon_cylinder(), set()
    yield "checkers and ambient rays", _checkers_and_ambient_rays(), set()
    yield "shifted near plane in glass", _shifted_near_plane(), {INSIDE}
    yield "squares that share edges", _squares_that_share_edges(), set()
    yield "lamps in the ceiling", _lamps_in_the_ceiling(), set()
    yield "seams seen straight on", _seams_seen_straight_on(0.5), set()
    yield "seams seen straight on at half the size", _seams_seen_straight_on(1.0), set()  # as mutants are
    yield "blocks seen straight on at half the size", _blocks_seen_straight_on(), set()


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


def _checkers_and_ambient_rays() -> Table:
    """Ambient rays from both colours of a checker: fault `&` for `|` in what tells these went unnoticed."""
    tiles = {"type": "checker", "colors": [[0.7, 0.3, 0.2], [0.2, 0.4, 0.6]], "size": 1.1}
    floor = {"type": "polygon", "points": [[-3, -2.3, 3], [3, -2.3, 3], [3, -1.8, -2.8], [-3, -1.8, -2.8]]}
    ball = {"type": "sphere", "center": [0.2, -0.3, 0.2], "radius": 1.3, "material": OPAQUE["checker"]}
    material = {"color": tiles, "diffuse": 0.4, "ambient": 0.9}
    return room([{**floor, "material": material}, ball], ambient_samples=3, max_depth=2, lights=LIGHTS[:1])


def _shifted_near_plane() -> Table:
    """Rays start in a block that a near plane meets only as far as the picture is shifted: with its corners
    mirrored about the middle no ray was thought to start there, and it went unnoticed."""
    block = {"type": "box", "min": [0.4, -0.9, 4.6], "max": [1.9, 0.9, 5.9],
             "material": {"diffuse": 0.0, "fresnel": True, "ior": 1.3, "absorption": [0.5, 0.1, 0.2]}}
    ball = {"type": "sphere", "center": [1.1, 0.0, 5.05], "radius": 0.3, "material": OPAQUE["matte"]}
    camera = {**CAMERA, "near": 3.0, "shift": [55, 30]}
    return room([block, ball], camera=camera, lights=LIGHTS[:1])


def _squares_that_share_edges() -> Table:
    """A wall of squares, seen so that rays pass exactly through their edges: what is behind it showed there.

    An edge of which one way is told from the other where it meets the ray is nobody's. The float64 oracle had
    the same rule.
    """
    sides = (-2.03, -1.0, 0.0, 1.0, 2.03)  # pixels lie on multiples of a tenth, and not on the rim
    lattice = [(x, y) for y in sides for x in sides]
    squares = [[5 * j + i, 5 * j + i + 1, 5 * j + i + 6, 5 * j + i + 5] for j in range(4) for i in range(4)]
    wall = {"type": "mesh", "vertices": [[x, y, 0] for x, y in lattice], "faces": squares}
    behind = {"type": "box", "min": [-2.96, -2.36, -2], "max": [2.96, 2.36, -1], "material": OPAQUE["shiny"]}
    camera = {"type": "orthographic", "origin": [0, 0, 8], "target": [0, 0, 0], "up": [0, 1, 0], "size": 6.5,
              "width": 65, "height": 49}  # fmt: skip
    return room([{**wall, "material": OPAQUE["matte"]}, behind], camera=camera)


def _lamps_in_the_ceiling() -> Table:
    """Lamps in the very plane of a ceiling, which rounding put before them as often as behind.

    There were black speckles, and in each oracle's picture others.
    """
    ceiling = {"type": "polygon", "points": [[-3, 2.3, -3], [3, 2.3, -3], [3, 2.3, 4], [-3, 2.3, 4]]}
    lights = [
        {"type": "point", "position": [-0.9, 2.3, 0.7], "intensity": 0.4},
        {"type": "rectangle", "center": [1.1, 2.3, 0.3], "u": [0.5, 0, 0], "v": [0, 0, 0.4], "radiance": 6,
         "visible": False},
    ]  # fmt: skip
    ball = {"type": "sphere", "center": [0.2, -1.2, 0.2], "radius": 1.1, "material": OPAQUE["matte"]}
    return room([{**ceiling, "material": OPAQUE["matte"]}, ball], lights=lights)


def _seams_seen_straight_on(shift: float) -> Table:
    """A floor and a wall, a bar of tinted glass: rays meet exactly the seam, and an edge of the bar.

    Rays that go on from the seam started a rounding behind the wall, where all is dark, and those that enter
    at the edge entered by both of its sides. Either of two sides may be the one that is met: they are lit
    nearly alike, but for as much as makes an edge of them, and the glass bends nothing.
    """
    y, z, wide = -1.35, 0.89, 9.0
    corners = [[x, up, depth] for up, depth in ((y, z + wide), (y, z), (y + wide, z)) for x in (-wide, wide)]
    corner = {"type": "mesh", "vertices": corners, "faces": [[0, 1, 3, 2], [2, 3, 5, 4]],
              "material": OPAQUE["matte"]}  # fmt: skip
    low, high, front, half = y + 0.28, y + 1.98, z + 1.54, 0.74
    ring = [(0, front + half), (half, front), (0, front - half), (-half, front)]
    glass = {"diffuse": 0.03, "transmission": 1.0, "ior": 1.0, "absorption": [0.9, 0.2, 0.5]}
    bar = {"type": "mesh", "vertices": [[x, level, depth] for level in (low, high) for x, depth in ring],
           "faces": [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
           "material": glass}  # fmt: skip
    camera = {**CAMERA, "origin": [0, y + 2.1, z + 7.9], "target": [0, y, z], "shift": [shift, shift]}
    return {
        "max_depth": 4, "background": [0.3, 0.32, 0.35], "ambient": 0.2, "camera": camera,
        "lights": [{"type": "directional", "direction": [-0.4, -1, -1.02], "intensity": 0.8}],
        "shapes": [corner, bar],
    }  # fmt: skip


def _blocks_seen_straight_on() -> Table:
    """Outlines through the middles of pixels, of blocks whose sides are numbered before or after the front.

    Of two faces at an edge the one with the lower number is met: the outline was shaded as the inside of a
    side is, and of glass that is met by its front and only touched, bent and lost. Rays within the glass that
    came to the edge of two sides got out of it. The outlines are lit as the wall is, so that it does not
    matter on which side of them a ray is.
    """
    front_first = [[4, 5, 7, 6], [0, 2, 3, 1], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    front_last = front_first[::-1]
    clear = {"diffuse": 0.0, "transmission": 1.0, "ior": 1.0, "absorption": [0.9, 0.2, 0.5]}

    def corners(left: float, right: float) -> list[list[float]]:
        ends = ((0.25, -1.0), (0.0, 0.0))  # at the back narrower
        return [[x, y, z] for s, z in ends for y in (s - 1.5, 1.5 - s) for x in (left + s, right - s)]

    sides = [[corners(1.2, 2.5)[number] for number in face] for face in front_last]
    shapes: list[Table] = [
        {"type": "plane", "point": [0, 0, -3], "normal": [0, 0, 1], "material": WALL},
        {"type": "mesh", "vertices": corners(-2.5, -1.2), "faces": front_last, "material": WALL},
        {"type": "mesh", "vertices": corners(-1.0, 1.0), "faces": front_first, "material": clear},
        *({"type": "polygon", "points": points, "material": WALL} for points in sides),
    ]
    return {
        "max_depth": 4, "background": [0.3, 0.32, 0.35], "ambient": 0.2, "shapes": shapes,
        "camera": {"type": "orthographic", "origin": [0, 0, 8], "target": [0, 0, 0], "size": 10.0,
                   "width": WIDTH, "height": HEIGHT, "shift": [1.0, 1.0]},
        "lights": [{"type": "directional", "direction": [3, 0, -1], "intensity": 2.5}],
    }  # fmt: skip
