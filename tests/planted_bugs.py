"""Plant ten memory faults in copies of the kernels and render with each under Oclgrind.

For `.ci/run`: each must be reported, or Oclgrind's silence about the real kernels would prove nothing.
Prints a line a fault; the exit code says whether all were found.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from unittest import mock

import clrt
from clrt.base.resources import kernel_folder
from tests import watched

# name: (file, the text that stands there once, what takes its place, what Oclgrind says of it)
BUGS: dict[str, tuple[str, str, str, str]] = {
    "an idle item writes": (
        "film.cl",
        "if (i >= n) return;\n    const float mean",
        "if (i > n) return;\n    const float mean",
        "Invalid write",
    ),
    "a plane of the film too far": (
        "film.cl",
        "(size_t)plane * pixels",
        "((size_t)plane + 1) * pixels",
        "Invalid",
    ),
    "a sum without a start": (
        "film.cl",
        "for (int b = 4 * FOURS; b < BANDS; b++) sum[b] = 0.0f;",
        "",
        "Uninitialized",
    ),
    "past the end of the queue": (
        "film.cl",
        "i < n && pixel_of[i] == pixel",
        "pixel_of[i] == pixel",
        "Invalid read",
    ),
    "all means in one place": (
        "film.cl",
        "film[i] = mean <= BRIGHTEST",
        "film[0] = mean <= BRIGHTEST",
        "data race",
    ),
    "a chunk past the end": (
        "compact.cl",
        "min((chunk + 1) * CHUNK, n);\n    for (uint i = chunk * CHUNK; i < end; i++) {",
        "(chunk + 1) * CHUNK;\n    for (uint i = chunk * CHUNK; i < end; i++) {",
        "Invalid",
    ),
    "a total of nothing": (
        "compact.cl",
        "for (uint s = 0; s < STREAMS; s++) total[s] = (uintP)(0);",
        "",
        "Uninitialized",
    ),
    "one light too many": ("light.cl", "l < world.scene->lights", "l <= world.scene->lights", "Invalid read"),
    "a material before the first": (
        "surfaces.clh",
        "return world.materials + number;",
        "return world.materials + number - 1;",
        "Invalid read",
    ),
    "a hit beside its place": (
        "surface.clh",
        "store_word(surface_code, first, n,",
        "store_word(surface_code, first + 8, n + 8,",
        "Invalid write",
    ),
}

SCENE = clrt.load_dict(
    {
        "camera": {"origin": [0, 0, 4], "target": [0, 0, 0], "width": 9, "height": 7},
        "max_depth": 1,
        "lights": [{"type": "point", "position": [3, 4, 5]}],
        "shapes": [
            {
                "type": "sphere",
                "center": [0, 0, 0],
                "radius": 1,
                "material": {"diffuse": 0.5, "reflection": 0.5},
            }
        ],
    }
)
SMALL = clrt.Settings(local_size=8)


def planted(folder: Path, number: int, file: str, good: str, bad: str) -> Path:
    """A copy of the kernels with one text replaced."""
    kernels = folder / f"kernels{number}"
    shutil.copytree(kernel_folder(), kernels)
    text = (kernels / file).read_text()
    if text.count(good) < 1:
        sys.exit(f"{file}: the place of a planted fault has changed: {good!r}")
    (kernels / file).write_text(text.replace(good, bad))
    return kernels


def main() -> int:
    missed = 0
    for name, replacement in watched.PATCHES:
        mock.patch(name, replacement).start()
    clrt.render(SCENE, settings=SMALL)
    assert watched.findings() == "", "the kernels themselves have faults"
    with tempfile.TemporaryDirectory() as folder:
        for number, (name, (file, good, bad, said)) in enumerate(BUGS.items()):
            kernels = planted(Path(folder), number, file, good, bad)
            before = len(watched.findings())
            with (
                mock.patch("clrt.device.driver.kernel_folder", lambda kernels=kernels: kernels),
                suppress(Exception),
            ):
                clrt.render(SCENE, settings=SMALL)  # what comes of a fault may also stop it
            found = watched.findings()[before:]
            missed += said.lower() not in found.lower()
            print(f"{'found' if said.lower() in found.lower() else 'MISSED'}: {name} ({file}): {said}")
    print(f"{len(BUGS) - missed} of {len(BUGS)} planted faults were found")
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
