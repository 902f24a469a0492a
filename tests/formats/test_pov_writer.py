"""Scenes written for POV-Ray: what a file of its own language cannot say is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

import clrt
from clrt.cli import main
from tests.formats.test_mitsuba_return import GREY


@pytest.mark.parametrize("kind", ["box", "tent", "gaussian", "mitchell"])
def test_a_filter_is_refused(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Even with one sample a pixel, which then lies anywhere that the filter reaches: POV-Ray's is in the
    middle."""
    monkeypatch.chdir(tmp_path)
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": GREY}
    camera = {"origin": [0, 0, 5], "target": [0, 0, 0], "filter": kind}
    lights = [{"type": "point", "position": [3, 5, 4]}]
    clrt.load_dict({"camera": camera, "lights": lights, "shapes": [ball]}).save("a.toml")
    assert main(["convert", "a.toml", "a.pov"]) == (0 if kind == "box" else 2)
    said = capsys.readouterr().err
    refused = "clrt: error: a.toml: POV-Ray has no filter as the model has them\n"
    assert said == ("" if kind == "box" else refused)
    assert Path("a.pov").exists() == (kind == "box")
