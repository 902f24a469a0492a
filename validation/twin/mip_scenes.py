"""Scenes with pictures made to show them at mip levels."""

from __future__ import annotations

from typing import Any


def at_levels(part: Any) -> Any:
    """The same part of a scene, with mip levels where no filter is asked for, and 25 pictures for one."""
    if isinstance(part, list | tuple):
        return [at_levels(entry) for entry in part]
    if not isinstance(part, dict):
        return part
    found = {key: at_levels(value) for key, value in part.items()}
    if "placement" in found:
        found["placement"] |= {"filter": "mipmap"}
    if found.get("type") == "image" and "filter" not in found:
        across, down = found.get("scale", (1, 1))
        found |= {"filter": "mipmap", "scale": [5 * across, 5 * down]}
    return found
