"""What lights with extent, lens, gloss and seen lights cost the kernels of a scene that has none of them.

    python docs/measure_off_cost.py [ROUNDS] [SCENE ...]

The kernels as they are and a copy in which no scene has any of these, so that the compiler leaves them out,
render the same pictures in turns, on one thread. Each has the same bits from both. Printed: of each scene
the median ratio of processor times, the kernels as they are over those without, its quartiles, and the
geometric mean. Only a quiet machine can tell 1 %.
"""

from __future__ import annotations

import re
import shutil
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import numpy as np

import clrt
from clrt.base.resources import kernel_folder
from clrt.bench import scenes
from clrt.device.device import Device
from clrt.scene.scene import Scene

# what asks whether a scene has them, and what then stands there
OFF: Final = {
    r"\bworld(\.|->)scene->(extended|surfaces|rough)\b": "0",
    r"\blight->(extended|two_sided)\b": "0",
    r"\blight->surface >= 0\b": "false",
    r"\bmaterial->light\b": "0",
    r"\bmaterial->alpha > 0\.0f": "false",
    r"\bcamera\.aperture > 0\.0f": "false",
    r"\bEXTENDED_KINDS\(SAMPLE_OF\)": "",
}
SHIPPED: Final = ("ambient", "mirrors", "refraction", "room", "showcase", "sky", "tinted_shadows",
                  "whitted_1980")  # fmt: skip
WIDTH: Final = 320


def without(folder: Path) -> Path:
    """A copy of the kernels in the folder, without them; AssertionError where a text is gone."""
    copy = folder / "kernels"
    shutil.copytree(kernel_folder(), copy)
    found = dict.fromkeys(OFF, 0)
    for path in copy.glob("*.cl*"):
        text = path.read_text("utf-8")
        for old, new in OFF.items():
            text, count = re.subn(old, new, text)
            found[old] += count
        path.write_text(text, "utf-8")
    assert all(found.values()), found
    return copy


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
        copy = without(Path(folder))
        for name, scene in pictures(sys.argv[2:]).items():
            both = [clrt.Tracer(scene, Device(None, settings, kernels=kernels)) for kernels in (None, copy)]
            hashes = {tracer.render(width=WIDTH).hash for tracer in both}
            assert len(hashes) == 1, f"{name}: has other bits without"
            ratios = []
            for number in range(rounds):
                spent = [0.0, 0.0]
                for which in (0, 1) if number % 2 else (1, 0):
                    start = time.process_time()
                    both[which].render(width=WIDTH)
                    spent[which] = time.process_time() - start
                ratios.append(spent[0] / spent[1])
            medians.append(float(np.median(ratios)))
            low, high = np.quantile(ratios, [0.25, 0.75])
            print(f"{name:16s} {medians[-1]:.3f}  ({low:.3f} to {high:.3f})", flush=True)
    print(f"{'geometric mean':16s} {np.exp(np.mean(np.log(medians))):.4f}")


if __name__ == "__main__":
    main()
