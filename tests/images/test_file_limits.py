"""Pictures under `ulimit -f`, which holds for files in memory, too: whole, or refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from clrt.base.errors import ClrtError
from clrt.images.image import Image
from tests.disk import small_files


@pytest.mark.parametrize("name", ["a.exr", "a.png", "a.tif", "a.jpg", "a.bmp"])
def test_a_picture_is_whole_or_refused(tmp_path: Path, name: str) -> None:
    image = Image(np.random.default_rng(1).random((30, 40, 3), np.float32))
    image.save(tmp_path / name)
    before = (tmp_path / name).read_bytes()
    for most in (0, 100, 512, 1024, len(before) // 2, len(before) - 1):
        with small_files(most), pytest.raises(ClrtError, match=f"{name}: cannot be written: .") as caught:
            image.save(tmp_path / name)
        assert "\n" not in str(caught.value)
        assert [file.name for file in tmp_path.iterdir()] == [name]
        assert (tmp_path / name).read_bytes() == before
    (tmp_path / name).unlink()
    with small_files(200_000):
        image.save(tmp_path / name)
    assert (tmp_path / name).read_bytes() == before


def test_layers_are_whole_under_a_limit(tmp_path: Path) -> None:
    pixels = np.ones((8, 8, 3), np.float32)
    with small_files(1 << 20):
        Image(pixels, {"depth": np.full((8, 8), np.inf, np.float32)}).save(tmp_path / "a.exr")
    assert (tmp_path / "a.exr").stat().st_size > 100
