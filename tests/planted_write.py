"""Plant a write past the end of a buffer in a copy of the kernels and render with them.

For `.ci/run`: Oclgrind must report it, or its silence about the real kernels would prove nothing. The fault
is the commonest one, `<=` for `<`, in the last pass; work-groups do not divide the frame's 63 x 3 values.
"""

import shutil
import tempfile
from pathlib import Path
from unittest import mock

import clrt
import watched
from clrt.resources import kernel_folder

GOOD, BAD = "if (i < n) film[i] /= samples;", "if (i <= n) film[i] /= samples;"

with tempfile.TemporaryDirectory() as folder:
    kernels = Path(folder) / "kernels"
    shutil.copytree(kernel_folder(), kernels)
    film = kernels / "film.cl"
    text = film.read_text()
    assert text.count(GOOD) == 1, "the place of the planted fault has changed"
    film.write_text(text.replace(GOOD, BAD))
    for name, replacement in (*watched.PATCHES, ("clrt.device.kernel_folder", lambda: kernels)):
        mock.patch(name, replacement).start()
    scene = clrt.load_dict({"camera": {"origin": [0, 0, 4], "target": [0, 0, 0], "width": 9, "height": 7}})
    clrt.render(scene)
