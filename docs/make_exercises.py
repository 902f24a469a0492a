"""Draw docs/exercises.png, some exercises as a student sees them: `python docs/make_exercises.py`.

Each pair is the right picture and, below it, that of the kernels with the fault. Kernels compile for each.
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import clrt
from clrt.base.resources import kernel_folder
from clrt.device.device import Device
from clrt.exercises.table import Exercise, exercise, scenes
from docs.make_contact_sheet import Pixels, captioned, fitting_width, sheet, write

SHOWN = (1, 5, 9, 13, 27, 30)


def pictures(one: Exercise) -> tuple[Pixels, Pixels]:
    """The right picture and the wrong one, small."""
    scene = clrt.load(scenes()[one.scene])
    width = fitting_width(scene)
    with tempfile.TemporaryDirectory() as folder:
        kernels = Path(shutil.copytree(kernel_folder(), Path(folder) / "kernels"))
        file = kernels / one.file
        file.write_text(one.planted(file.read_text("utf-8")), "utf-8")
        wrong = clrt.Tracer(scene, Device(kernels=kernels)).render(width=width, spp=4).pixels
    return clrt.render(scene, width=width, spp=4).pixels, wrong


def main() -> None:
    pairs = [(pictures(one), one) for one in map(exercise, SHOWN)]
    cells: list[Pixels] = []
    for start in range(0, len(pairs), 3):
        row = pairs[start : start + 3]
        cells += [captioned(right, "right") for (right, _), _ in row]
        cells += [captioned(wrong, f"{one.number}: {one.title}") for (_, wrong), one in row]
    write("exercises", sheet(cells, columns=3))


if __name__ == "__main__":
    main()
