"""A scene from a stream is that of a file, as TOML or JSON; with its limits."""

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest

import clrt
from clrt.formats.native import load_stream

TOML = b'ambient = 0.5\n[[shapes]]\ntype = "sphere"\ncenter = [0, 0, 0]\nradius = 1\n'


@pytest.mark.parametrize("before", [b"", b"\xef\xbb\xbf", b"\n  "])
def test_a_stream_is_toml_or_json(before: bytes, tmp_path: Path) -> None:
    (tmp_path / "ball.toml").write_bytes(TOML)
    scene = clrt.load(tmp_path / "ball.toml")
    for data in (TOML, json.dumps(scene.to_dict()).encode()):
        assert load_stream(io.BytesIO(before + data), "here", clrt.Limits()) == scene


def test_a_stream_has_limits_and_faults_have_lines() -> None:
    with pytest.raises(clrt.LimitError, match=r"here: .*text_bytes"):
        load_stream(io.BytesIO(TOML), "here", clrt.Limits(text_bytes=len(TOML) - 1))
    assert load_stream(io.BytesIO(TOML), "here", clrt.Limits(text_bytes=len(TOML))).shapes
    with pytest.raises(clrt.SceneError, match=r"here:5: shapes\[0\]\.radius: -1"):
        load_stream(io.BytesIO(TOML.replace(b"radius = 1", b"radius = -1")), "here", clrt.Limits())
