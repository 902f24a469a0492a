"""CLRT_KERNELS: kernels of the user's own are used, said, and never taken for those that ship."""

from __future__ import annotations

import os
import shutil
import warnings
from pathlib import Path

import pytest

import clrt
from clrt.base.resources import kernel_folder
from clrt.device.device import Device
from clrt.device.foreign import VARIABLE

BALL = {
    "ambient": 1.0,
    "camera": {"origin": [0, 0, 5], "target": [0, 0, 0], "width": 8, "height": 8},
    "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}],
}


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = Path(shutil.copytree(kernel_folder(), tmp_path / "kernels"))
    monkeypatch.setenv(VARIABLE, str(folder))
    return folder


def replace(file: Path, old: str, new: str) -> None:
    text = file.read_text("utf-8")
    assert text.count(old) == 1
    file.write_text(text.replace(old, new), "utf-8")


def test_they_are_used_and_said(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    said = f"{VARIABLE}: the kernels in {own} are used, not those of clrt"
    with pytest.warns(clrt.ClrtWarning, match=said):
        image = clrt.render(clrt.load_dict(BALL))
    monkeypatch.delenv(VARIABLE)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        right = clrt.render(clrt.load_dict(BALL))
    assert image.hash == right.hash and image.metadata["kernel_hash"] == right.metadata["kernel_hash"]


@pytest.mark.filterwarnings("ignore::clrt.ClrtWarning")
def test_another_source_has_another_key_everywhere(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    replace(own / "trace.cl", "((primitive) < 0)", "((primitive) == (primitive))")
    foreign = Device().kernels
    monkeypatch.delenv(VARIABLE)
    right = Device().kernels
    assert "((primitive) < 0)" in right.source and "((primitive) < 0)" not in foreign.source
    assert foreign.key != right.key and foreign.hash != right.hash


def test_the_folder_that_ships_is_not_foreign(
    monkeypatch: pytest.MonkeyPatch, recwarn: pytest.WarningsRecorder
) -> None:
    for value in ("", str(kernel_folder())):
        monkeypatch.setenv(VARIABLE, value)
        assert Device().driver.foreign is None
    assert not [warning for warning in recwarn if issubclass(warning.category, clrt.ClrtWarning)]


@pytest.mark.parametrize("name", ["nowhere", "generate.cl", "\udc80"])
def test_no_folder_of_kernels(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "generate.cl").write_text("")
    monkeypatch.setenv(VARIABLE, os.fspath(tmp_path / name))
    says = r"CLRT_KERNELS: .* has no generate\.cl; it must be a folder .*; else: unset CLRT_KERNELS"
    with pytest.raises(clrt.ClrtError, match=says):
        Device()


def _self(own: Path) -> None:
    (own / "light.clh").write_text('#include "draws.clh"\n')
    (own / "draws.clh").write_text('#include "light.clh"\n')


def _pipe(own: Path) -> None:
    (own / "light.cl").unlink()
    os.mkfifo(own / "light.cl")


FAULTS = {
    "a file is missing": (lambda own: (own / "light.clh").unlink(), "clh: there is no such file"),
    "not text": (lambda own: (own / "light.clh").write_bytes(b"a\xff"), "light.clh: is not text in UTF-8"),
    "too long": (lambda own: (own / "light.clh").write_text(" " * (1 << 20) + " "), "file_bytes"),
    "itself": (_self, r"clh: includes itself"),
    "no C": (lambda own: replace(own / "film.cl", "= film[i] / samples;", "= film[i] / "), "film.cl:"),
}  # fmt: skip


@pytest.mark.filterwarnings("ignore::clrt.ClrtWarning")
@pytest.mark.parametrize("name", FAULTS)
def test_kernels_that_cannot_be_used(name: str, own: Path) -> None:
    plant, reason = FAULTS[name]
    plant(own)
    with pytest.raises(clrt.ClrtError, match=reason) as caught:
        clrt.render(clrt.load_dict(BALL))
    assert "doctor" not in str(caught.value) and "install clrt again" not in str(caught.value)


def test_a_kernel_with_another_signature(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    replace(own / "film.cl", "__kernel void develop(", "__kernel void evolve(")
    with pytest.warns(clrt.ClrtWarning):
        kernels = Device().kernels
    with pytest.raises(clrt.DeviceError, match=f"{own}: there is no kernel develop"):
        kernels.check("develop", ())
    with pytest.raises(clrt.DeviceError, match=f"{own}: kernel generate takes"):
        kernels.check("generate", ())
    monkeypatch.delenv(VARIABLE)
    with pytest.raises(TypeError):  # ours is no fault of the user's
        Device().kernels.check("generate", ())


@pytest.mark.skipif(os.name != "posix", reason="pipes have names on POSIX systems alone")
def test_a_pipe_is_not_waited_for(own: Path) -> None:
    _pipe(own)
    with pytest.raises(clrt.ClrtError, match=r"light\.cl"):
        clrt.render(clrt.load_dict(BALL))
