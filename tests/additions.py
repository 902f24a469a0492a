"""Copies of the product to which something was added, as the pages `docs/adding-a-....md` tell it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from clrt.base.resources import PACKAGE, kernel_folder

Entries = Mapping[str, Mapping[str, str]]  # file -> text that stands there once -> what stands there then

RENDER = """
import sys, numpy as np, clrt
assert clrt.__file__.startswith(sys.argv[1]), clrt.__file__
settings = clrt.Settings(lanes=int(sys.argv[4]))
image = clrt.render(clrt.load_dict(eval(sys.argv[3])), layers=sys.argv[5:], settings=settings)
np.savez(sys.argv[2], pixels=image.pixels, feelers=image.stats["rays"]["feelers"], **image.layers)
"""


def grown(root: Path, thing: str, entries: Entries) -> Path:
    """A copy of the product in `root`, with the headers of `tests/<thing>` and these entries."""
    shutil.copytree(PACKAGE, root / "clrt", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(kernel_folder(), root / "kernels")
    for header in (Path(__file__).parent / thing).glob("*.clh"):
        shutil.copy(header, root / "kernels")
    changed(root, entries)
    return root


def changed(root: Path, entries: Entries) -> None:
    """Make the entries in a copy."""
    for file, texts in entries.items():
        text = (root / file).read_text()
        for old, new in texts.items():
            assert text.count(old) == 1, f"{file}: {old!r}"
            text = text.replace(old, new)
        (root / file).write_text(text)


def run(tree: Path, script: str, *arguments: object) -> subprocess.CompletedProcess[str]:
    """A script with the copy's own `clrt`."""
    command = [sys.executable, "-c", script, *map(str, arguments)]
    environment = os.environ | {"PYTHONPATH": str(tree)}
    return subprocess.run(command, cwd=tree, env=environment, capture_output=True, text=True, check=False)


def render(
    tree: Path, scene: object, out: Path, lanes: int = 16, layers: tuple[str, ...] = ()
) -> dict[str, np.ndarray]:
    """`pixels` and the layers that the copy makes of a scene's table, and its count of `feelers`."""
    done = run(tree, RENDER, tree, out / "found.npz", repr(scene), lanes, *layers)
    assert done.returncode == 0, done.stderr
    with np.load(out / "found.npz") as found:
        return dict(found)


def camera_rays(camera: Mapping[str, object], fov: float) -> np.ndarray:
    """Unit directions (height, width, 3) float64 of a scene's perspective camera, `up` y, one sample."""
    eye, target = np.array(camera["origin"], float), np.array(camera["target"], float)
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [0, 1, 0])
    right /= np.linalg.norm(right)
    width, height = (int(str(camera[side])) for side in ("width", "height"))
    half = np.tan(np.radians(fov) / 2)
    x = (2 * (np.arange(width) + 0.5) / width - 1) * half
    y = (1 - 2 * (np.arange(height) + 0.5) / height) * half * height / width
    d = forward + x[:, None] * right + (y[:, None] * np.cross(right, forward))[:, None]
    return d / np.linalg.norm(d, axis=-1, keepdims=True)
