"""Runs POV-Ray, and reads what it wrote: 16 bits a sample, linear."""

from __future__ import annotations

import re
import shutil
import subprocess
import time
from functools import cache
from typing import Final

import numpy as np
import OpenImageIO as oiio

from clrt.base.scratch import scratch
from clrt.scene.scene import Scene

from ..types import OracleImage
from .scene import write_pov

INSTALL: Final = "POV-Ray is not installed (Debian: apt-get install povray)"
DARK: Final = "POV-Ray's 16 bits cannot hold so dark a picture"
_TIMEOUT: Final = 600.0  # seconds
_OPTIONS: Final = (
    "+FN16", "File_Gamma=1", "Display=off", "Antialias=off", "Work_Threads=1", "All_Console=off",
)  # fmt: skip


class PovrayError(Exception):
    """POV-Ray gave no picture."""


def missing() -> str | None:
    """Why POV-Ray cannot be run here; None where it can."""
    return None if shutil.which("povray") else INSTALL


def too_dark(pixels: np.ndarray) -> bool:
    """Whether 16 bits cannot hold a picture (h, w, 3): they move its mean by half of what may be wrong."""
    shown = np.clip(pixels, 0, 1)
    off = np.abs((np.round(shown * 65535) / 65535 - shown).mean(axis=(0, 1))).max()
    return bool(off > 5e-5 * shown.mean())


@cache
def version() -> str:
    """As "POV-Ray 3.7.0.10"; "not installed" where it is not."""
    if missing():
        return "not installed"
    said = subprocess.run(["povray", "--version"], capture_output=True, text=True, check=False)
    found = re.search(r"POV-Ray \S+", said.stdout + said.stderr)
    return found.group() if found else "POV-Ray"


def render(scene: Scene) -> OracleImage:
    """POV-Ray's picture of a scene, clipped to [0, 1] as its file is."""
    assert scene.camera is not None
    start = time.perf_counter()
    with scratch() as folder:
        write_pov(scene, folder / "scene.pov")
        size = f"+W{scene.camera.width}", f"+H{scene.camera.height}"
        command = ["povray", "+Iscene.pov", "+Oout.png", *size, *_OPTIONS]
        try:
            ran = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=_TIMEOUT,
                                 stdin=subprocess.DEVNULL, check=False)  # fmt: skip
        except (OSError, subprocess.TimeoutExpired) as error:
            raise PovrayError(f"POV-Ray: {error}") from None
        out = folder / "out.png"
        if ran.returncode != 0 or not out.exists():
            words = " ".join((ran.stderr or ran.stdout).split())[-300:]
            raise PovrayError(f"POV-Ray wrote no picture: {words}")
        pixels = oiio.ImageBuf(str(out)).get_pixels(oiio.UINT16)
    values = np.asarray(pixels, np.float64)[:, :, :3] / 65535
    return OracleImage(values, {}, None, None, version(), time.perf_counter() - start)
