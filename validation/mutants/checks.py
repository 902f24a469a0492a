"""Checks of what no oracle renders: how many samples pixels get, and the numbers of names in mattes.

What is right stands here, from docs/model.md and from published values; nothing of it is taken from clrt.
Each raises AssertionError where clrt does otherwise. A fault is planted in a copy of the package, and the
check runs there, in a process of its own.
"""

from __future__ import annotations

import math
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np

import clrt
from clrt.base.resources import PACKAGE
from clrt.images import cryptomatte

CHECK: Final = "check "
"""Before the name of a check, where a mutant names its cases."""
_RUN: Final = "import sys; from clrt.base.resources import validation_module as find; " \
              "find('mutants.checks').CHECKS[sys.argv[1]]()"  # fmt: skip
_SECONDS: Final = 300
# docs/model.md: the cosine between normals below which neighbours differ
_BENT: Final = 0.9
# a strip of three flat pieces that bend by 29 degrees and by 24, on both sides of what counts as bent
_STRIP: Final = [(1.1, 0.0), (1.5, 0.0)]
for _turn in (29.0, 53.0):
    _STRIP.append((_STRIP[-1][0] + 0.4 * math.cos(math.radians(_turn)),
                   _STRIP[-1][1] - 0.4 * math.sin(math.radians(_turn))))  # fmt: skip
_SCENE: Final[dict[str, Any]] = {
    "background": [0.1, 0.2, 0.3], "ambient": 0.2,
    "camera": {"origin": [0, 0.6, 4], "target": [0, 0, 0], "width": 40, "height": 28, "spp": 4, "jitter": 2},
    "lights": [{"type": "point", "position": [3, 5, 4]}],
    "shapes": [
        {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {"diffuse": 0.5, "specular": 0.4}},
        {"type": "box", "min": [-2, -1, -1], "max": [-1.2, 0, 0.5], "transform": [{"rotate": ["y", 30]}]},
        {"type": "mesh", "vertices": [[x, y, z] for x, z in _STRIP for y in (-0.7, 0.8)],
         "faces": [[0, 2, 3, 1], [2, 4, 5, 3], [4, 6, 7, 5]], "material": {"diffuse": 0.0, "ambient": 0.5}},
        {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0],
         "material": {"color": {"type": "checker", "colors": [0.3, 0.6], "size": 0.7}}},
    ],
}  # fmt: skip
_LAYERS: Final = ("samples", "shape", "normal")


def adaptive() -> None:
    """Pixels get as many samples as docs/model.md says, and have the bits of even pictures of so many; the
    same in parts."""
    scene = clrt.load_dict(_SCENE)
    even = {spp: clrt.render(scene, spp=spp, layers=_LAYERS) for spp in (4, 16, 64)}
    for threshold in (0.004, 1.0):  # 1: outlines alone
        asked = clrt.load_dict({**_SCENE, "adaptive": {"spp": 64, "threshold": threshold}})
        image = clrt.render(asked, layers=_LAYERS)
        count = image.layers["samples"]
        assert np.array_equal(count, _samples(even, threshold)), f"samples at threshold {threshold}"
        for spp, whole in even.items():
            assert np.array_equal(image.pixels[count == spp], whole.pixels[count == spp]), f"bits of {spp}"
        parts = [clrt.render(asked, crop=crop) for crop in ((0, 0, 17, 28), (17, 0, 23, 28))]
        assert np.array_equal(parts[0].pixels, image.pixels[:, :17]), "bits of a part"
        part = clrt.render(asked, crop=(10, 3, 17, 20))
        assert np.array_equal(part.pixels, image.pixels[3:23, 10:27]), "bits of a part"
        rays = {kind: sum(part.stats["rays"][kind] for part in parts) for kind in image.stats["rays"]}
        assert rays == image.stats["rays"], "rays of parts"


def _samples(even: dict[int, clrt.Image], threshold: float) -> np.ndarray:
    """How many samples each pixel has to get."""
    root = {spp: np.sqrt(np.clip(whole.pixels, 0, 1)) for spp, whole in even.items()}
    shape, normal = even[4].layers["shape"], even[4].layers["normal"]
    height, width = shape.shape
    most = np.float32(threshold)
    found = np.full((height, width), 4)
    for y in range(height):
        for x in range(width):
            for j, i in ((y, x - 1), (y, x + 1), (y - 1, x), (y + 1, x)):
                if 0 <= j < height and 0 <= i < width:
                    colour = ((root[4][y, x] - root[4][j, i]) ** 2 > most).any()
                    bent = min(shape[y, x], shape[j, i]) >= 0 and normal[y, x] @ normal[j, i] < _BENT
                    if colour or bent or shape[y, x] != shape[j, i]:
                        found[y, x] = 16
            if found[y, x] == 16 and ((root[16][y, x] - root[4][y, x]) ** 2 > most).any():
                found[y, x] = 64
    return found


def names_as_numbers() -> None:
    """Published values of MurmurHash3_x86_32 (seed 0), those of Psyop's own tests of Cryptomatte, and its
    rule for numbers that are no normal floats: an exponent of all zeros or ones has its lowest bit turned."""
    hashes = {b"": 0, b"test": 0xBA6BD213, b"Hello, world!": 0xC0363E43, b"\0\0\0\0": 0x2362F9DE,
              b"The quick brown fox jumps over the lazy dog": 0x2E4FF723}  # fmt: skip
    assert {data: cryptomatte.murmur3(data) for data in hashes} == hashes
    floats = {"hello": 6.0705627102400005616e-17, "cube": -4.08461912519e15, "sphere": 2.79018604383e15,
              "plane": 3.66557617593e-11, "mädchen": 6.2361298211599995797e25}  # fmt: skip
    found = cryptomatte.ids_of(list(floats))
    assert found.tolist() == [float(np.float32(value)) for value in floats.values()]
    changed = 0
    for name in (f"n{number}" for number in range(4000)):
        plain = cryptomatte.murmur3(name.encode())
        odd = plain >> 23 & 255 in (0, 255)
        assert cryptomatte.id_of(name) == (plain ^ 1 << 23 if odd else plain), name
        changed += odd
    assert changed


def mattes() -> None:
    """The parts of a pixel that names cover, the largest first: of a grid of 2 x 2 samples they are the
    pixels of a picture twice as large."""
    camera = {key: value for key, value in _SCENE["camera"].items() if key != "jitter"}
    scene = clrt.load_dict({**_SCENE, "camera": camera})
    ranked = clrt.render(scene, layers=["crypto_shape"]).layers["crypto_shape"].reshape(28, 40, -1, 2)
    fine = clrt.load_dict({**_SCENE, "camera": {**camera, "width": 80, "height": 56, "spp": 1}})
    shape = clrt.render(fine, layers=["shape"]).layers["shape"].reshape(28, 2, 40, 2)
    part = np.stack([(shape == number).mean(axis=(1, 3)) for number in range(len(_SCENE["shapes"]))], axis=-1)
    counts = (part > 0).sum(axis=-1)
    assert counts.max() >= 2 and part.sum(axis=-1).min() == 0, "the scene shows too little"
    expected = np.zeros(ranked.shape[:3])
    expected[..., : part.shape[-1]] = -np.sort(-part, axis=-1)
    assert np.array_equal(ranked[..., 1], expected), "parts"
    ids = np.ascontiguousarray(ranked[..., 0]).view(np.uint32)
    of_shape = {}
    for number in range(part.shape[-1]):
        found = np.unique(ids[part[..., number] == 1][:, 0])
        assert len(found) == 1, "one name a shape"
        of_shape[number] = found[0]
    assert len(set(of_shape.values())) == len(of_shape), "a name a shape"
    for y, x in np.argwhere(counts > 0):
        covered = {of_shape[int(number)] for number in np.flatnonzero(part[y, x])}
        assert set(ids[y, x, : counts[y, x]]) == covered, "names"


def alpha() -> None:
    """The part of a filter's weights whose samples hit anything is what a thing of light 1 before the dark
    shows, within 0 and 1: on a grid, and of few jittered samples, whose weights cancel here and there."""
    lamp = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {"emission": 1, "diffuse": 0.0}}
    for changes in ({"spp": 16, "jitter": None}, {"spp": 4, "jitter": 2}):
        camera = {**_SCENE["camera"], "filter": "mitchell", **changes}
        table = {"background": 0, "camera": camera, "shapes": [lamp]}
        image = clrt.render(clrt.load_dict(table), layers=["alpha"])
        shown = image.pixels[..., 0]
        assert shown.min() < -0.01 and shown.max() > 1.01, "the scene shows too little"
        # two sums of 16 products each, whose terms are at most 4 times their sum: half a unit a rounding
        most = 2 * 2 * 16 * 4 * 2.0**-24
        assert np.abs(image.layers["alpha"] - np.clip(shown, 0, 1)).max() <= most, "parts"


def overflow() -> None:
    """Light beyond float32's range is the brightest that a pixel holds, 1e30 in each of its bands."""
    shine = {"emission": 3e38, "diffuse": 0.0}
    lamp = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": shine}
    table = {"background": 0.5, "camera": {**_SCENE["camera"], "jitter": None}, "shapes": [lamp]}
    pixels = clrt.render(clrt.load_dict(table)).pixels
    assert np.isfinite(pixels).all(), "not finite"
    assert pixels.max() == np.float32(1e30) and pixels.min() == 0.5, "the brightest"


def refits() -> None:
    """Spheres that move: their tree, of three levels, is refitted each time, and pictures are those of a new
    one. Each time to where none was, for what a fault reads may be memory that holds the boxes of before."""
    draw = np.random.default_rng(0)
    places = draw.uniform(-1, 1, (4000, 3)) - [2, 0, 0]
    tracer = None
    for _ in range(6):
        shapes = [{"type": "sphere", "center": list(place), "radius": 0.03} for place in places]
        now = {**_SCENE, "camera": {**_SCENE["camera"], "spp": 1}, "shapes": shapes}
        tracer = tracer or clrt.Tracer(now)
        assert tracer.update(now) in ("refit", "nothing"), "worn at once"
        assert tracer.render().hash == clrt.render(now).hash, "bits of a new tree"
        places = places + np.array([0.7, 0, 0]) + draw.uniform(-0.01, 0.01, places.shape)


CHECKS: Final[dict[str, Callable[[], None]]] = {"adaptive": adaptive, "names as numbers": names_as_numbers,
                                                "mattes": mattes, "overflow": overflow, "alpha": alpha,
                                                "refits": refits}  # fmt: skip


def failed(root: Path, name: str) -> str:
    """What a check says of the package in a folder, or of its kernels where it has only these; "" where all
    is right."""
    if not (root / PACKAGE.name).is_dir():
        ignored = shutil.ignore_patterns("__pycache__", "_kernels")
        shutil.copytree(PACKAGE, root / PACKAGE.name, ignore=ignored)
        for beside in ("scenes", "validation"):
            if (PACKAGE.parent / beside).is_dir():
                (root / beside).symlink_to(PACKAGE.parent / beside)
    path = os.pathsep.join(filter(None, (str(root), os.environ.get("PYTHONPATH"))))
    command = [sys.executable, "-P", "-W", "ignore", "-c", _RUN, name]
    ran = subprocess.run(command, cwd=root, env={**os.environ, "PYTHONPATH": path}, capture_output=True,
                         text=True, timeout=_SECONDS, check=False)  # fmt: skip
    return "" if ran.returncode == 0 else (ran.stderr.strip().splitlines() or ["it ended"])[-1]


@cache
def passes(name: str) -> bool:
    """Whether clrt as it is passes a check; AssertionError, for else failing says nothing of a fault."""
    CHECKS[name]()
    return True
