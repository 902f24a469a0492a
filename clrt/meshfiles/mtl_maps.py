"""Pictures that an MTL file names, as images of a scene file."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from clrt.meshfiles.look import Table, placement_of

Beside = Callable[[str], str | None]
"""The name in the scene's folder of a file that a materials file names; None where it is not there."""

_ONE: Final = ("-blendu", "-blendv", "-cc", "-texres", "-bm", "-boost", "-imfchan", "-type")
_TURBULENCE: Final = "-t"
_PLACES: Final = ("-s", "-o", _TURBULENCE)


def texture(words: list[str]) -> Table:
    """The image that the words after `map_Kd` name, its file as it stands there; ValueError for no image.

    v = 0 is at the bottom there, on top here: `1 - (s (1 - v) + o) = s v + (1 - s - o)`.
    """
    left, wrap = list(words), "repeat"
    places = {"-s": (1.0, 1.0), "-o": (0.0, 0.0)}
    while left and left[0].startswith("-"):
        option = left.pop(0).lower()
        if option in _PLACES:
            numbers = _numbers(left)
            if option != _TURBULENCE:
                places[option] = numbers[0], numbers[1] if len(numbers) > 1 else places[option][1]
        elif option == "-clamp":
            wrap = "clamp" if left.pop(0).lower() == "on" else "repeat"
        elif option in _ONE:
            left.pop(0)
        elif option == "-mm":
            del left[:2]
        else:
            raise ValueError(option)
    if not left:
        raise ValueError("no file")
    (su, sv), (ou, ov) = places["-s"], places["-o"]
    table: Table = {"type": "image", "file": " ".join(left).replace("\\", "/")}
    table |= {"wrap": wrap} if wrap != "repeat" else {}
    table |= {"scale": [su, sv]} if (su, sv) != (1.0, 1.0) else {}
    offset = [ou, 1.0 - sv - ov]
    return table | ({"offset": offset} if any(offset) else {})


def normals_of(picture: Table) -> Table:
    """The normal map in an image; it lies by its own options, whatever those of `map_Kd` are."""
    return {"file": picture["file"], "placement": placement_of(picture)}


def finite(word: str) -> float:
    """A number; ValueError for what is none, or not finite."""
    value = float(word)
    if not math.isfinite(value):
        raise ValueError(word)
    return value


def _numbers(left: list[str]) -> list[float]:
    """The up to three numbers that come first, taken away; ValueError where there is none."""
    found = [finite(left.pop(0))]
    while left and len(found) < 3:
        try:
            found.append(finite(left[0]))
        except ValueError:
            break
        left.pop(0)
    return found
