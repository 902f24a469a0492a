"""What lights with extent, seen lights, gloss, lens and filters cost a scene that has none of them.

    python -m docs.measure_off_cost [ROUNDS] [SCENE ...]

Three kernels render the same pictures in turns, on one thread, with the same bits: as they are; "without", a
copy in which nothing asks whether a scene has any of these, so that the compiler leaves them out; "asking", a
copy that asks at run time what EXTENT (kernels/extent.clh) says when it compiles. Printed: of each scene the
median ratios of processor times to those without, with quartiles, and their geometric means. Only a quiet
machine can tell 1 %. (Least times cannot: where the clock changes they are those of its fastest moments.)
"""

from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import numpy as np

import clrt
from clrt.base.resources import kernel_folder
from clrt.bench import scenes
from clrt.device.device import Device
from clrt.scene.scene import Scene
from docs.in_turns import ratios

# of each copy: what asks whether a scene has them, and what then stands there
COPIES: Final = {
    "without": {r"\bcamera\.aperture > 0\.0f": "false", r"\bcamera\.filter\b": "0"},
    "asking": {r"\bEXTENT\b": "1"},
}
SHIPPED: Final = ("ambient", "mirrors", "refraction", "room", "showcase", "sky", "tinted_shadows",
                  "whitted_1980")  # fmt: skip
WIDTH: Final = 320


def copied(folder: Path, changes: dict[str, str]) -> Path:
    """A changed copy of the kernels in the folder; AssertionError where a text is gone."""
    shutil.copytree(kernel_folder(), folder)
    found = dict.fromkeys(changes, 0)
    for path in folder.glob("*.cl*"):
        text = path.read_text("utf-8")
        for old, new in changes.items():
            text, count = re.subn(old, new, text)
            found[old] += count
        path.write_text(text, "utf-8")
    assert all(found.values()), found
    return folder


def pictures(names: list[str]) -> dict[str, Scene]:
    """The scenes named, or the bench's own and some that ship."""
    ours = {} if names else {"terrain": scenes.terrain_frame(), "flake": scenes.flake_frame(),
                             "glass ball": scenes.glass_ball(1.5, None)}  # fmt: skip
    return ours | {name: clrt.load(name) for name in names or SHIPPED}


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 15
    settings = clrt.Settings(threads=1)
    medians = []
    with TemporaryDirectory() as folder:
        kernels = [None, *(copied(Path(folder, name), changes) for name, changes in COPIES.items())]
        print(f"{'':16s} as it is                 asking")
        for name, scene in pictures(sys.argv[2:]).items():
            tracers = [clrt.Tracer(scene, Device(None, settings, kernels=which)) for which in kernels]
            assert not tracers[0].flat.ray_format.extent, f"{name}: has some of them"
            hashes = {tracer.render(width=WIDTH).hash for tracer in tracers}
            assert len(hashes) == 1, f"{name}: has other bits without"
            found = list(ratios(tracers, 1, rounds, WIDTH))
            medians.append([median for median, _ in found])
            print(f"{name:16s} {'  '.join(told for _, told in found)}", flush=True)
    means = np.exp(np.mean(np.log(medians), axis=0))
    print(f"{'geometric mean':16s} {means[0]:.4f}                   {means[1]:.4f}")


if __name__ == "__main__":
    main()
