"""Answers of oracles that are kept: of another picture, or by another package, they are asked anew."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

from validation.mutants import kept
from validation.oracles import ORACLE64
from validation.types import OracleImage


def picture(seconds: float) -> OracleImage:
    """One of noise, which says how long it took."""
    noise = np.random.default_rng(0).random((4, 5, 3))
    rays = {"generation 1 reflection": noise / 2}
    layers = {"uv": noise[:, :, :2].astype(np.float32)}
    return OracleImage(noise, rays, noise[:, :, 0], None, "an oracle", seconds, layers=layers)


def test_a_question_is_asked_anew_once_what_decides_is_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kept, "user_cache_dir", lambda *_, **__: str(tmp_path / "cache"))
    (tmp_path / "parts").mkdir()
    (tmp_path / "a.png").write_bytes(b"one")
    (tmp_path / "parts" / "a.obj").write_bytes(b"mtllib a.mtl")
    (tmp_path / "parts" / "a.mtl").write_bytes(b"newmtl a")
    what = {"shapes": [{"file": "a.png", "name": "x" * 5000}, {"file": "parts/a.obj"}], "ambient": 0.1}
    asked: list[int] = []

    def ask() -> int:
        def make() -> OracleImage:
            asked.append(1)
            return picture(len(asked))

        return int(kept.once(ORACLE64, what, tmp_path, make).seconds)

    assert [ask(), ask()] == [1, 1]
    (tmp_path / "a.png").write_bytes(b"two")
    assert [ask(), ask()] == [2, 2]
    (tmp_path / "parts" / "a.mtl").write_bytes(b"newmtl b")
    assert [ask(), ask()] == [3, 3]
    monkeypatch.setattr(kept, "versions", lambda: "mitsuba 9")
    assert [ask(), ask()] == [4, 4]


def test_what_is_kept_is_what_was_made_and_a_damaged_file_is_made_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Files hold numbers only: a pickle in the folder's place runs nothing."""
    monkeypatch.setattr(kept, "user_cache_dir", lambda *_, **__: str(tmp_path))
    made = picture(7)
    assert kept.once(ORACLE64, {}, None, lambda: made) is made
    again = kept.once(ORACLE64, {}, None, lambda: picture(8))
    assert (again.name, again.seconds, again.shape) == (made.name, 7, None)
    for found, wanted in ((again.pixels, made.pixels), (again.t, made.t)):
        assert found is not None and np.array_equal(found, wanted) and found.dtype == wanted.dtype
    assert np.array_equal(again.by_ray["generation 1 reflection"], made.by_ray["generation 1 reflection"])
    assert np.array_equal(again.layers["uv"], made.layers["uv"])
    (file,) = (tmp_path / "references").iterdir()
    for damaged in (file.read_bytes()[:100], pickle.dumps({"pixels": 1}), b""):
        file.write_bytes(damaged)
        assert kept.once(ORACLE64, {}, None, lambda: picture(9)).seconds == 9
        file.unlink()
