"""Answers of oracles that are kept: of another picture, or by another package, they are asked anew."""

from __future__ import annotations

from pathlib import Path

import pytest

from validation.mutants import kept
from validation.oracles import ORACLE64


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
        def make() -> int:
            asked.append(1)
            return len(asked)

        return kept.once(ORACLE64, what, tmp_path, make)

    assert [ask(), ask()] == [1, 1]
    (tmp_path / "a.png").write_bytes(b"two")
    assert [ask(), ask()] == [2, 2]
    (tmp_path / "parts" / "a.mtl").write_bytes(b"newmtl b")
    assert [ask(), ask()] == [3, 3]
    monkeypatch.setattr(kept, "_versions", lambda: "mitsuba 9")
    assert [ask(), ask()] == [4, 4]
