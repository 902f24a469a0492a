"""The formats of other programs, read a second time and from nothing but their description: tests compare.

What comes back is plain: lists of tuples in the file's own order and words, no scene.
"""

from __future__ import annotations

import re
from typing import Any

NFF = {"b": 3, "f": 8, "s": 4, "c": 8}


def nff(text: str) -> dict[str, list[Any]]:
    """Haines' Neutral File Format by entity; shapes with the number of the fill before them (-1: none)."""
    found: dict[str, list[Any]] = {key: [] for key in ("b", "f", "l", "view", "s", "c", "p", "pp")}
    lines = [line.partition("#")[0].split() for line in text.splitlines()]
    words = [(word, number) for number, line in enumerate(lines) for word in line]
    at = 0

    def numbers(count: int) -> tuple[float, ...]:
        nonlocal at
        at += count
        return tuple(float(word) for word, _ in words[at - count : at])

    while at < len(words):
        key, at = words[at][0], at + 1
        fill = len(found["f"]) - 1
        if key == "v":
            view = {}
            for _ in range(6):
                name, at = words[at][0], at + 1
                view[name] = numbers({"angle": 1, "hither": 1, "resolution": 2}.get(name, 3))
            found["view"].append(view)
        elif key == "l":
            start, at = numbers(3), at
            coloured = at < len(words) and words[at][1] == words[at - 1][1] and words[at][0] not in found
            found["l"].append((start, numbers(3) if coloured else None))
        elif key in ("p", "pp"):
            (count,) = numbers(1)
            found[key].append((fill, [numbers(3 if key == "p" else 6) for _ in range(int(count))]))
        else:
            found[key].append((fill, numbers(NFF[key])) if key in "sc" else numbers(NFF[key]))
    return found


LAYOUT = {
    "Width": "1", "Height": "1", "Pixel": "1", "Ambient": "1", "Focal": "3",
    "Light": "Point 3 Spectrum S Intensity 1", "Sphere": "Point 3 Radius 1 F", "Plane": "Point 3 Vector 3 F",
    "Ellipsoid": "Center 3 Radii 3 F", "Quadric": "Constants 10 F", "Polygon": "P F", "Mesh": "M F",
}  # fmt: skip


def thesis(text: str) -> list[tuple[str, list[Any]]]:
    """The objects of a scene of the thesis' program, each with its numbers as they stand in LAYOUT.

    A spectrum is a name or (low, high); a surface None or (spectrum, (diffuse ... smoothness)).
    """
    words = re.findall(r"\S+", text)[::-1]

    def numbers(count: int) -> tuple[float, ...]:
        return tuple(float(words.pop()) for _ in range(count))

    def spectrum() -> Any:
        return words.pop() if words[-1].isalpha() else numbers(2)

    def surface() -> Any:
        assert words.pop() == "Surface"
        if words[-1] == "None":
            return words.pop() and None
        assert words.pop() == "Spectrum"
        shown = spectrum()
        assert words.pop() == "Constants"
        return shown, numbers(5)

    def points() -> list[Any]:
        return [(words.pop(), numbers(3))[1] for _ in iter(lambda: words and words[-1] == "Point", False)]

    def faces() -> list[Any]:
        return [(words.pop(), points(), surface())[1]
                for _ in iter(lambda: words and words[-1] == "Polygon", False)]  # fmt: skip

    parts = {"S": spectrum, "F": surface, "P": points, "M": faces}
    found = []
    while words:
        word = words.pop()
        if word in LAYOUT:
            said = []
            for part in LAYOUT[word].split():
                if part in parts:
                    said.append(parts[part]())
                elif part.isdigit():
                    said.append(numbers(int(part)))
                else:
                    assert words.pop() == part
            found.append((word, said))
    return found
