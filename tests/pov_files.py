"""Reads the published .pov files of the Standard Procedural Databases: the language that they use."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

_NUMBER = r"-?\d[\d.e+-]*"
_VECTOR = rf"<({_NUMBER}), ({_NUMBER}), ({_NUMBER})>"


def vectors(text: str) -> list[list[float]]:
    return [[float(part) for part in found] for found in re.findall(_VECTOR, text)]


def value(name: str, text: str, otherwise: float = 0.0) -> float:
    found = re.search(rf"\b{name} ({_NUMBER})", text)
    return float(found[1]) if found else otherwise


def color(text: str) -> list[float]:
    return [value(name, text) for name in ("red", "green", "blue")]


def material(text: str) -> dict[str, Any]:
    """What passes is taken from the surface's own light, as POV-Ray does."""
    clear = value("filter", text)
    found: dict[str, Any] = {
        "color": color(text), "ambient": value("ambient", text) * (1 - clear),
        "diffuse": value("diffuse", text) * (1 - clear),
        "specular": value("phong", text), "shininess": value("phong_size", text, 40.0),
        "reflection": value("reflection", text),
    }  # fmt: skip
    if clear:
        found |= {"transmission": clear, "ior": value("ior", text)}
    return found


def scene(file: Path, size: int) -> dict[str, Any]:
    """The scene of a file as `clrt.load_dict` takes it, `size` pixels wide and high."""
    text = re.sub(r"//[^\n]*", "", file.read_text())
    blocks = re.split(r"\n(?=[a-z#])", text)[1:]
    table: dict[str, Any] = {"ambient": 1.0, "shadow": "tinted", "lights": [], "shapes": [], "materials": {}}
    meshes: dict[tuple[str, bool], dict[str, Any]] = {}
    for block in blocks:
        kind = block.split()[0]
        found = vectors(block)
        used = re.findall(r"texture \{ (\w+) \}", block)
        if kind == "global_settings":
            table["max_depth"] = int(value("max_trace_level", block)) - 1
        elif kind == "background":
            table["background"] = color(block)
        elif kind == "camera":
            origin, direction, right, up = found
            across = np.linalg.norm(right) / 2 / np.linalg.norm(direction)
            table["camera"] = {
                "origin": origin, "target": list(np.add(origin, direction)), "up": up,
                "width": size, "height": size,
                "fov": float(np.degrees(2 * np.arctan(across))),
            }  # fmt: skip
        elif kind == "light_source":
            table["lights"].append({"type": "point", "position": found[0], "intensity": color(block)})
        elif kind == "#declare":
            table["materials"][block.split()[1]] = material(block)
        elif kind == "sphere":
            radius = float(re.findall(rf">, ({_NUMBER})", block)[0])
            table["shapes"].append(
                {"type": "sphere", "center": found[0], "radius": radius, "material": used[0]}
            )
        elif kind == "cone":
            r0, r1 = (float(radius) for radius in re.findall(rf">, ({_NUMBER})", block))
            table["shapes"].append(
                {"type": "cone", "p0": found[0], "r0": r0, "p1": found[1], "r1": r1, "material": used[0]}
            )
        elif kind == "object":
            smooth = "smooth_triangle" in block
            if (used[0], smooth) not in meshes:
                mesh = {"type": "mesh", "vertices": [], "faces": [], "material": used[0]} | (
                    {"normals": []} if smooth else {}
                )
                meshes[used[0], smooth] = mesh
                table["shapes"].append(mesh)
            mesh = meshes[used[0], smooth]
            first = len(mesh["vertices"])
            mesh["vertices"] += found[::2] if smooth else found
            mesh["faces"].append([first, first + 1, first + 2])
            if smooth:
                mesh["normals"] += found[1::2]
        else:
            raise ValueError(f"{file}: {kind} is not known")
    return table
