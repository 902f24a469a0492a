"""Videos say which colours they hold, and hold these."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from clrt.images.video import writing

COLORS = np.array([[0, 255, 0], [255, 0, 0], [200, 100, 50], [255, 255, 255]], np.uint8)


@pytest.mark.parametrize("suffix", [".mp4", ".webm", ".mkv"])
@pytest.mark.parametrize("size", [(64, 48), (640, 360)])
def test_colours_come_back_by_the_tags(tmp_path: Path, suffix: str, size: tuple[int, int]) -> None:
    """Without tags players guess by the size: (0, 255, 0) was (19, 255, 8)."""
    av = pytest.importorskip("av", reason="needs the optional dependency clrt[video]")
    (width, height), path = size, tmp_path / f"a{suffix}"
    frame = np.repeat(np.repeat(COLORS[None], height, axis=0), width // 4, axis=1)
    with writing(path, width, height) as put:
        put(frame)
        put(frame)
    with av.open(str(path)) as container:
        (stream,) = container.streams.video
        decoded = next(container.decode(stream))
        codec = stream.codec_context
        assert (codec.color_primaries, codec.color_trc) == (1, 13), "Rec.709, sRGB"
        if suffix == ".mkv":
            assert np.array_equal(decoded.to_ndarray(format="rgb24"), frame)
            return
        assert (decoded.colorspace, decoded.color_range) == (1, 1), "Rec.709, not the full range"
        rgb = decoded.reformat(format="rgb24", src_colorspace="ITU709", dst_colorspace="ITU709").to_ndarray()
    middles = rgb[height // 2, width // 8 :: width // 4]
    assert np.abs(middles.astype(int) - COLORS).max() <= 3
