"""Deliberate faults in what comes before and after passes: refitted trees, adaptive sampling, mattes.

A refitted tree is judged by a new tracer, whose bits its pictures have to have; the others by checks that say
themselves what is right (`checks`).
"""

from __future__ import annotations

from typing import Final

from .checks import CHECK
from .kernels import Mutant
from .plant import REFITTED

_MOVED: Final = (REFITTED + "shipped sphereflake",)
_MOVED_MESH: Final = (REFITTED + "shipped mesh",)  # of which a patched package reads the scene, too
# A fault in the order of levels reads memory that nobody wrote: such a tree may count as worn and be built
# anew, which no picture shows; the check asks what was done, too.
_REFIT: Final = (
    Mutant("a refitted leaf has the box of its first primitive", "kernels/refit.cl",
           "if (number[i] < 0) continue;", "if (number[i] < 0 || i > 0) continue;", _MOVED),
    Mutant("refitted leaves keep their boxes", "kernels/refit.cl", "put_box(out + n, k, low, high);",
           "put_box(out + n, k, low_of(before + n, k), high_of(before + n, k));", _MOVED),
    Mutant("a refitted node holds two of its children", "kernels/refit.cl", "j < WIDE; j++", "j < 2; j++",
           _MOVED),
    Mutant("refitted nodes end a little below their children", "kernels/refit.cl",
           "high = fmax(high, high_of(below, j));", "high = fmax(high, high_of(below, j) - 0.02f);", _MOVED),
    Mutant("levels are refitted from the root on", "clrt/engine/tree.py",
           "for size in reversed(levels.sizes):", "for size in levels.sizes:", (CHECK + "refits",)),
    Mutant("the refitted tree is over where primitives were", "clrt/engine/tree.py",
           "boxes = device.upload(_by_number(flat))\n    out = {",
           "boxes = device.upload(_by_number(flat)[::-1].copy())\n    out = {", _MOVED_MESH),
)  # fmt: skip

_ADAPTIVE: Final = tuple(
    Mutant(name, "clrt/engine/adaptive.py", old, new, (CHECK + "adaptive",))
    for name, old, new in (
        ("a threshold 5 % too high", "> np.float32(threshold)", "> np.float32(1.05 * threshold)"),
        ("colours compared as light, not as seen",
         "np.sqrt(np.clip(one, 0, 1)) - np.sqrt(np.clip(other, 0, 1))",
         "np.clip(one, 0, 1) - np.clip(other, 0, 1)"),
        ("one channel alone compared", "(difference * difference > np.float32(threshold)).any(axis=1)",
         "(difference * difference > np.float32(threshold))[:, 0]"),
        ("the neighbour above not asked", "(y > 0, -width), (y < height - 1, width)",
         "(y < height - 1, width)"),
        ("the neighbour below not asked", "(y > 0, -width), (y < height - 1, width)", "(y > 0, -width)"),
        ("the neighbour to the left not asked", "(x > 0, -1), (x < width - 1, 1)", "(x < width - 1, 1)"),
        ("the neighbour to the right not asked", "(x > 0, -1), (x < width - 1, 1)", "(x > 0, -1)"),
        ("outlines not refined", "(shape[here] != shape[there]) | bent", "bent"),
        ("bent surfaces not refined", "(shape[here] != shape[there]) | bent", "shape[here] != shape[there]"),
        ("bent only beyond 32 degrees", "np.float32(0.9)", "np.float32(0.85)"),
        ("normals compared without their height", "one[:, 1] * other[:, 1] + ", ""),
        ("grids of four times as many a side", "grid *= 2", "grid *= 4"),
        ("what has settled is refined on", "chosen = chosen[changed]", "chosen = chosen[:]"),
        ("rays of neighbours beyond a part counted", "uncounted = _Run(device, world, observers, budget)",
         "uncounted = run"),
        ("neighbours beyond a part's upper and lower edge left out", "_sides(pixels, width, height):",
         "_sides(pixels, width, height)[:2]:"),
    )
)

_MATTES: Final = tuple(
    Mutant(name, "clrt/images/cryptomatte.py", old, new, (CHECK + "names as numbers",))
    for name, old, new in (
        ("a hash rotated by 15", "h << 13 | h >> 19", "h << 15 | h >> 17"),
        ("a hash with another constant", "0xE6546B64", "0xE6546B65"),
        ("a hash without its length", " ^ len(data)", ""),
        ("a hash mixed by 15", "h ^ h >> 13", "h ^ h >> 15"),
        ("the last bytes of a name lost", "data[whole:]", "data[whole:whole]"),
        ("numbers that are no normal floats", "number ^ 1 << 23 if", "number if"),
    )
)

ENGINE_FAULTS: Final = (*_REFIT, *_ADAPTIVE, *_MATTES)
