"""Files that a command writes: none of them may take the place of what it reads, or of another one.

Before anything is computed by the names that are known, once more where a scene was loaded and so says
what it reads, and whenever a file is replaced by all that was read until then (`clrt.base.inputs`).
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from clrt.base.errors import ClrtError
from clrt.base.inputs import Name, identity, noted

_WRITES: Final = {
    "--stats": ("JSON", "stats.json"),
    "--trace": ("JSON", "trace.json"),
    "--junit": ("XML", "results.xml"),
    "--json": ("JSON", "bench.json"),
    "--manifest": ("a table in CSV", "frames.csv"),
    "--checkpoint": ("what is finished in a format of its own", "picture.checkpoint"),
}
"""What an option writes, and how such a file may be called."""

_MEANING: Final = frozenset(
    (
        ".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".exr", ".hdr", ".mp4", ".webm", ".mkv", ".toml",
        ".json", ".csv", ".nff", ".xml", ".pov", ".obj", ".ply", ".glb", ".gltf", ".stl", ".html", ".svg",
        ".py",
    )
)  # fmt: skip
"""Suffixes by which programs know what is in a file."""


def check_named(option: str, file: Name, such: str) -> None:
    """ClrtError for `-`, which elsewhere is a stream: a file or folder of that name is nobody's wish."""
    if os.fsdecode(file) == "-":
        raise ClrtError(f"{option} -: it is no stream; give it a name, such as {such}")


def check_apart(outputs: Mapping[str, Name | None], inputs: Mapping[str, Name | None]) -> None:
    """ClrtError where an output (by option) is one of the inputs (by what they are) or another output, or has
    a name that promises something else than is written.

    What was read, or is named by a scene that was, counts among the inputs; None: a file was not given.
    """
    taken = {identity(file): what for what, file in inputs.items() if file is not None}
    for found, name in noted().items():
        taken.setdefault(found, f"{name}, which is read")
    for option, file in outputs.items():
        if file is None:
            continue
        what = taken.setdefault(identity(file), f"the file of {option}")
        if what != f"the file of {option}":
            raise ClrtError(f"{file}: is {what}; give {option} a file of its own")
    for option, file in outputs.items():
        if file is not None and option in _WRITES:
            what, name = _WRITES[option]
            check_named(option, file, name)
            suffix = Path(os.fsdecode(file)).suffix.lower()
            if suffix in _MEANING and suffix != Path(name).suffix:
                raise ClrtError(f"{file}: {option} writes {what}; give it a name such as {name}")
