"""Files that nobody keeps: gone whatever ends the block, and one line where there is no place for them."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import numpy as np
import pytest

import clrt
from clrt.base import interrupts
from clrt.base.atomic import write_text
from clrt.base.scratch import scratch
from clrt.cli import main


def test_nothing_is_left_whatever_ends_the_block() -> None:
    with pytest.raises(KeyboardInterrupt), scratch() as folder:
        (folder / "file").write_text("")
        raise KeyboardInterrupt
    assert not folder.exists() and not interrupts.folders
    with scratch() as folder:
        (folder / "file").write_text("")
        interrupts.sweep()  # a second signal: the process ends within the block
        assert not folder.exists()


def test_what_goes_with_the_block_is_not_told_as_saved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(interrupts, "saved", [])
    with scratch() as folder:
        write_text(folder / "a.txt", "")
        write_text(tmp_path / "b.txt", "")
    assert interrupts.saved == [tmp_path / "b.txt"]


def test_folders_of_any_depth_are_removed() -> None:
    """Whoever goes down level by level needs a frame and a descriptor for each."""
    here = os.open(".", os.O_RDONLY)
    with scratch() as folder:
        try:
            os.chdir(folder)
            for _ in range(1500):
                os.mkdir("d" * 100)
                os.chdir("d" * 100)
        finally:
            os.fchdir(here)
            os.close(here)
    assert not folder.exists()


def test_no_place_for_temporary_files_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "missing"))
    (tmp_path / "s.toml").write_text("")
    assert main(["render", str(tmp_path / "s.toml"), "-o", "-"]) == 2
    says = "there is no place for temporary files: No such file or directory; let the variable TMPDIR"
    assert says in capsys.readouterr().err
    with pytest.raises(clrt.ClrtError, match="no place for temporary files"):
        clrt.Image(np.zeros((1, 1, 3), np.float32))._repr_png_()
