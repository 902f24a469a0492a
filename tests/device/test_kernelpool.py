"""Kernel objects and the text of kernels are made once and handed on: a picture leaves nothing behind."""

from __future__ import annotations

import gc
import linecache
import os
import shutil
from pathlib import Path
from typing import Any

import numpy as np

import clrt
from clrt.base.resources import kernel_folder
from clrt.device import source

SCENE: dict[str, Any] = {
    "camera": {"origin": [0, 0, 5], "target": [0, 0, 0], "width": 16, "height": 12},
    "lights": [{"type": "point", "position": [3, 4, 5]}],
    "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}],
}


def test_one_picture_after_the_other_compiles_no_more_python() -> None:
    """pyopencl keeps the code that sets a kernel object's arguments, and its names make the next slow."""
    scene = clrt.load_dict(SCENE)
    first = clrt.render(scene).hash
    gc.collect()
    before = len(linecache.cache)
    for _ in range(20):
        assert clrt.render(scene).hash == first
        gc.collect()
    assert len(linecache.cache) - before < 20, "a picture takes 16 kernels, each a piece of code"


def test_tracers_that_live_at_once_share_no_kernel_object() -> None:
    """Arguments that one sets would be those of the other."""
    scene = clrt.load_dict(SCENE)
    with clrt.Tracer(scene) as one, clrt.Tracer(scene) as other:
        assert one.render().hash == other.render().hash
        ours, theirs = (set(map(id, t.device.kernels._kernels.values())) for t in (one, other))
        assert ours and theirs and not ours & theirs
        origins = np.tile([0.0, 0.0, 5.0], (4, 1))
        with clrt.Tracer(clrt.load_dict({**SCENE, "ambient": 1})) as third:
            assert third.render().hash != one.render().hash == other.render().hash
            assert np.array_equal(one.occluded(origins, -origins), third.occluded(origins, -origins))


def test_a_kernel_file_that_changes_is_read_again(tmp_path: Path) -> None:
    folder = Path(shutil.copytree(kernel_folder(), tmp_path / "kernels"))
    before = source.kernel_source(folder=folder)
    assert source.kernel_source(folder=folder) is not None and before.endswith("\n")
    file = folder / "film.cl"
    text = file.read_text()
    file.write_text(text.replace("__kernel", "__kernel ", 1))
    longer = source.kernel_source(folder=folder)
    assert len(longer) == len(before) + 1
    file.write_text(text.replace("__kernel", "__kernel\t", 1))  # as long
    os.utime(file, ns=(1, 1))  # some file systems count time in steps of milliseconds
    again = source.kernel_source(folder=folder)
    assert again != longer and len(again) == len(longer)
    file.write_text(text)
    assert source.kernel_source(folder=folder) == before
