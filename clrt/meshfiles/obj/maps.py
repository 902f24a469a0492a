"""Pictures that an MTL file names, as images of a scene file."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import Final

from clrt.base.errors import decimal, show
from clrt.meshfiles.look import Table, placement_of

Beside = Callable[[str], str | None]
"""The name in the scene's folder of a file that a materials file names; None where it is not there."""

_ONE: Final = ("-blendu", "-blendv", "-texres", "-boost", "-type")  # what they ask for is no other colour
_NAMED: Final = {"-cc": "colour correction", "-imfchan": "one channel"}
_TURBULENCE: Final = "-t"
_PLACES: Final = ("-s", "-o", _TURBULENCE)


def texture(words: list[str], left_out: dict[str, None], normals: bool = False) -> Table | None:
    """The image that the words after `map_Kd` name, its file as it stands there; None where they name none.

    Some programs write the line for every material. ValueError for options that are none.

    v = 0 is at the bottom there, on top here: `1 - (s (1 - v) + o) = s v + (1 - s - o)`. What of the options
    has no counterpart goes to `left_out`. `normals`: of `norm`, whose `-bm` is its `strength`.
    """
    left, wrap, strength, gain = deque(words), "repeat", 1.0, 1.0
    places = {"-s": (1.0, 1.0), "-o": (0.0, 0.0)}
    while left and left[0].startswith("-"):
        option = left.popleft().lower()
        if option in _PLACES:
            numbers = _numbers(left)
            if option == _TURBULENCE:
                left_out.update({"turbulence of textures (-t)": None} if any(numbers) else {})
            else:
                places[option] = numbers[0], numbers[1] if len(numbers) > 1 else places[option][1]
        elif option == "-clamp":
            wrap = "clamp" if left.popleft().lower() == "on" else "repeat"
        elif option in _ONE:
            left.popleft()
        elif option in _NAMED:
            if left.popleft().lower() != "off":
                left_out[f"{_NAMED[option]} of textures ({option})"] = None
        elif option == "-bm":
            strength = finite(left.popleft())
        elif option == "-mm":
            base, gain = finite(left.popleft()), finite(left.popleft())
            if base != 0 or gain < 0 or (normals and gain != 1):
                left_out["the range of textures (-mm)"], gain = None, 1.0
        else:
            left_out[f"a picture with the option {show(option[:20])}"] = None
            return None
    if not left:
        left_out["a picture without a name"] = None
        return None
    (su, sv), (ou, ov) = places["-s"], places["-o"]
    table: Table = {"type": "image", "file": unquoted(" ".join(left)).replace("\\", "/")}
    table |= {"wrap": wrap} if wrap != "repeat" else {}
    table |= {"scale": [su, sv]} if (su, sv) != (1.0, 1.0) else {}
    table |= {"tint": [gain] * 3} if gain != 1 else {}
    table |= {"strength": strength} if normals and strength != 1 else {}
    offset = [ou, 1.0 - sv - ov]
    return table | ({"offset": offset} if any(offset) else {})


def unquoted(name: str) -> str:
    """A name of a file without the quotes around it, which some programs write."""
    return name[1:-1] if len(name) > 1 and name[0] == name[-1] and name[0] in "\"'" else name


def normals_of(picture: Table) -> Table:
    """The normal map in an image; it lies by its own options, whatever those of `map_Kd` are."""
    table = {"file": picture["file"], "placement": placement_of(picture)}
    return table | ({"scale": picture["strength"]} if "strength" in picture else {})


def finite(word: str) -> float:
    """A number; ValueError for what is none, or not finite."""
    value = decimal(word)
    if not math.isfinite(value):
        raise ValueError(word)
    return value


def _numbers(left: deque[str]) -> list[float]:
    """The up to three numbers that come first, taken away; ValueError where there is none."""
    found = [finite(left.popleft())]
    while left and len(found) < 3:
        try:
            found.append(finite(left[0]))
        except ValueError:
            break
        left.popleft()
    return found
