"""What the kernels' own formats can hold, whatever `Limits` allows: each ceiling follows from `clrt.layout`.

Beyond them counts would run over into their neighbours' bits, and places in queues would be wrong. So they
are checked before anything is launched. (The list of media is checked where rays enter: `media.too_deep`.)
"""

from __future__ import annotations

from typing import Final

from clrt import layout
from clrt.base.errors import LimitError, located
from clrt.base.limits import written

_INT: Final = (1 << 31) - 1
_UINT: Final = (1 << 32) - 1

LIGHTS: Final = layout.SPAWN["SPAWN_FEELERS"]  # a hit counts its feelers in these bits
GROUPS: Final = layout.SPAWN["SPAWN_GROUPS"] // layout.SPAWN["SPAWN_GROUP"]  # and its narrow rays in these
MATERIALS: Final = _INT // layout.SURFACE["SURFACE_MATERIAL"]  # a surface's word: number, flags
PRIMITIVES: Final = (_INT >> 3) - 64  # a leaf has 8 places, and is ~(block * 4 + kind); 2 n + 64 nodes
RAYS: Final = _INT - layout.CHUNK  # of a queue: places are ints, and a chunk's end is looked at
PRIVATE: Final = 1 << 19  # bytes of one private array of a work-group: a few lie on a CPU thread's stack
PACKETS: Final = 128  # of a work-group: the stacks of their walks through the tree lie there, too
BANDS: Final = PRIVATE // (4 * 16)  # such an array holds a float a band and ray of a packet
PIXELS: Final = _UINT  # of a picture: a pixel's number is a uint
SIDE: Final = _INT  # width and height in the record Camera
DEPTH: Final = 1 << 16  # as in a scene: `max_depth`
AMBIENT: Final = _UINT // layout.CHUNK  # a chunk's ambient rays are added up in a uint

_WHY: Final = "is the most that the kernels can hold, whatever the limits are"
_ADVICE: Final = {
    "lights": "use fewer lights, or lower their samples",
    "dispersion groups": "use fewer bands, or a larger spectrum.group",
    "bands": "use fewer bands",
    "materials": "use fewer materials",
    "primitives": "use fewer shapes or faces",
    "ambient_samples": "lower ambient_samples",
    "pixels": "lower width or height",
    "samples": "lower spp",
    "depth": "lower max_depth",
}


def check(name: str, value: int, most: int, source: str = "") -> None:
    """Raise LimitError if `value`, called `name` (a key of _ADVICE), is above the ceiling `most`."""
    if value > most:
        text = f"{written(value)} is too many: {written(most)} {_WHY}; {_ADVICE[name]}"
        raise LimitError(located(source, name, text))


def check_picture(pixels: int, samples: int) -> None:
    """Raise LimitError for a picture whose pixels, or whose samples of one pixel, cannot be numbered."""
    check("pixels", pixels, PIXELS)
    check("samples", samples, RAYS)


def check_depth(depth: int) -> None:
    """Raise LimitError for more generations than a scene can ask for."""
    check("depth", depth, DEPTH)
