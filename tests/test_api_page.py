"""docs/api.md lists every public name, with defaults as they are; its code runs, and so does README's."""

from __future__ import annotations

import importlib.util
import inspect
import re
import shlex
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.cli import main
from tests.cli_samples import with_options

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE = (DOCS / "api.md").read_text()
BALL = {
    "camera": {"origin": [0, 0, 5], "target": [0, 0, 0], "width": 8, "height": 8},
    "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}],
}


def rows(heading: str) -> dict[str, list[str]]:
    """The rows of the table below a heading, by the name in their first cell."""
    part = PAGE.split(f"## {heading}\n")[1].split("\n## ")[0]
    found = re.findall(r"^\| `(\w+)[^|]*\| (.+) \|$", part, re.MULTILINE)
    return {name: rest.split(" | ") for name, rest in found}


def test_every_public_name_is_on_the_page():
    words = set(re.findall(r"\w+", PAGE))
    assert [name for name in clrt.__all__ if name not in words] == []
    listed = {*rows("Scenes and pictures"), "Crossings", "Hits", "RayMeshIntersector"}
    errors = {"SceneError", "DeviceError", "LimitError", "DeviceInfo"}
    assert set(clrt.__all__) - errors == listed


@pytest.mark.parametrize(
    "name", ["Tracer", "Image", "Scene", "RayMeshIntersector", "Hits", "Crossings", "DeviceInfo", "Verdict"]
)
def test_every_method_is_on_the_page(name: str):
    kind = getattr(clrt, name)
    own = [key for key, value in vars(kind).items() if not key.startswith("_") and inspect.isfunction(value)]
    records = ("Crossings", "Hits", "DeviceInfo", "Image", "Verdict")
    own += [field.name for field in fields(kind)] if name in records else []
    words = set(re.findall(r"\w+", PAGE))
    assert own and [method for method in own if method not in words] == []


def test_limits_and_settings_are_as_the_page_says():
    said = {name: cells[0] for name, cells in rows("Limits").items()}
    assert said == {field.name: str(field.default) for field in fields(clrt.Limits)}
    settings = clrt.Settings()
    said = {name: cells[0] for name, cells in rows("Settings").items()}
    assert said.pop("limits") == "`Limits()`" and settings.limits == clrt.Limits()
    assert said == {key: str(getattr(settings, key)) for key in said}
    assert {*said, "limits"} == {field.name for field in fields(settings)}


def test_statistics_are_as_the_page_says():
    image = clrt.render(clrt.load_dict(BALL))
    said = rows("Statistics")
    assert set(said) == set(image.stats)
    assert set(re.findall(r"`(\w+)`", said["rays"][0])) == set(image.stats["rays"])
    named = re.search(r"`image.metadata` says what made the picture: (.*)\.", PAGE)
    assert named and set(re.findall(r"`(\w+)`", named[1])) == set(image.metadata)


def test_the_page_s_code_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    space: dict[str, Any] = {}
    blocks = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert len(blocks) == 6
    for block in blocks:
        exec(block, space)
    assert space["pixels"].shape == (24, 32, 3) and (tmp_path / "ball.png").exists()


def test_the_code_about_many_pictures_runs(capsys: pytest.CaptureFixture[str]):
    (block,) = re.findall(r"```python\n(.*?)```", (DOCS / "sweeps.md").read_text("utf-8"), re.DOTALL)
    exec(block, {})
    assert capsys.readouterr().out.count("'materials.glass.ior': 1.5") == 2


def test_the_commands_about_many_pictures_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The page's lines with smaller and fewer pictures, along the path that it shows."""
    text = (DOCS / "sweeps.md").read_text("utf-8")
    (toml,) = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    block = text.split("## On the command line\n\n")[1].split("\n\n")[0]
    folder, *lines = map(str.strip, block.splitlines())
    assert folder.startswith("mkdir -p ")
    assert [line.split()[1] for line in lines] == ["sweep", "turntable", "sweep"]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "path.toml").write_text(toml)
    (tmp_path / folder.split()[2]).mkdir()
    for line in lines:
        film = line.endswith(".mp4")
        if film and not importlib.util.find_spec("av"):
            continue
        smaller = with_options(line, width=16, height=10, **{"frames": 4} if film else {})
        assert main([*shlex.split(smaller)[1:], "--quiet"]) == 0
    names = {file.name for file in (tmp_path / "out").iterdir()}
    assert len([name for name in names if name.endswith(".png")]) == 10 and "000_20.png" in names
    if importlib.util.find_spec("av"):
        assert {"spin.mp4", "flight.mp4"} <= {file.name for file in tmp_path.iterdir()}


def test_the_code_about_scenes_as_objects_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    (block,) = re.findall(r"```python\n(.*?)```", (DOCS / "scene-files.md").read_text("utf-8"), re.DOTALL)
    space: dict[str, Any] = {}
    exec(block, space)
    assert clrt.load("room.toml") == space["scene"]


@pytest.mark.parametrize(("page", "count"), [("queries.md", 5), ("live-scenes.md", 3)])
def test_the_code_of_pages_about_tracers_runs(page: str, count: int):
    blocks = re.findall(r"```python\n(.*?)```", (DOCS / page).read_text("utf-8"), re.DOTALL)
    space: dict[str, Any] = {}
    assert len(blocks) == count
    for block in blocks:
        exec(block, space)


def test_the_code_of_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """As it stands, but for the size of its picture, a window on it, and where the checkout is."""
    text = (DOCS.parent / "README.md").read_text()
    (code,) = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    assert code.count("tracer.") > 5 and "clrt.sweep" in code
    monkeypatch.chdir(tmp_path)
    shown: list[Any] = []
    monkeypatch.setattr(clrt.Image, "show", lambda image, *_: shown.append(image))
    rays = np.array([[0, 1, 9.0], [3, 1, 9.0]]), np.array([[0, 0, -1.0], [0, 0, -1.0]])
    names: dict[str, Any] = {"origins": rays[0], "directions": rays[1]}
    code = code.replace("scenes/showcase.toml", (DOCS.parent / "scenes/showcase.toml").as_posix())
    exec(code.replace("width=640", "width=64"), names)
    assert len(shown) == 2 and names["tree"].rays
    pictures = ("out.depth", "out.reflection", "out", "fov30", "fov40", "fov50")
    assert {file.name for file in tmp_path.iterdir()} == {"out.exr", *(f"{name}.png" for name in pictures)}
