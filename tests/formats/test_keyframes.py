"""Keyframes of a camera's path: what a file says, on top of the scene's camera, and what is wrong with it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import clrt
from clrt.formats.keyframes import Keyframes, load_keyframes

PLACED = {"origin": (0.0, 1.0, 5.0), "target": (0.0, 0.0, 0.0)}
BASE = clrt.Camera(**PLACED, fov=40.0, width=16, height=12, aperture=0.1)
TWO = "[[keyframes]]\n[[keyframes]]\norigin = [3, 1, 4]\n"


def read(folder: Path, text: str, base: clrt.Camera | None = BASE, name: str = "path.toml") -> Keyframes:
    (folder / name).write_text(text)
    return load_keyframes(folder / name, base, clrt.Limits())


def test_a_keyframe_changes_the_scene_s_camera(tmp_path: Path) -> None:
    keys = read(tmp_path, TWO + "fov = 30\nfocus = 2\n")
    first, last = keys.cameras
    assert first == BASE.upright() and keys.times is None and not keys.closed and keys.frames(25) is None
    assert (last.origin, last.target, last.width) == ((3, 1, 4), (0, 0, 0), 16)
    assert (last.fov, last.focus, last.aperture) == (30, 2, 0.1)
    two = [{"time": 1, **PLACED}, {"time": 2.5, "pose": last.pose, "K": last.K}]
    table = {"keyframes": two, "closed": True, "until": 3}
    keys = read(tmp_path, json.dumps(table), None, "path.json")
    assert keys.times == (1, 2.5, 3) and keys.closed and keys.frames(10) == 20 and keys.cameras[1].has_pose
    assert read(tmp_path, TWO.replace("]]\n", "]]\ntime = 0\n", 1) + "time = 2\n").frames(10) == 21
    again = read(tmp_path, "[[keyframes]]\nnear = 1\n[[keyframes]]\nfov = 9\n", keys.cameras[1])
    assert not again.cameras[1].has_k and again.cameras[1].has_pose, "what says the same is taken away"


WRONG = {
    "[[keyframes": "path.toml: wrong syntax: ",
    "": "path.toml: keyframes: None is not allowed; it must be a list of 2 tables or more",
    "[[keyframes]]": "it must be a list of 2 tables or more: [[keyframes]]",
    "closed = 1\n" + TWO: "path.toml:1: closed: 1 is not allowed; it must be true or false",
    "loop = true\n" + TWO: "path.toml:1: unknown key 'loop' (keys here: keyframes, closed, until)",
    "keyframes = [1, 2]": "path.toml:1: keyframes[0]: 1 is not allowed; a keyframe must be a table",
    TWO + "spp = 4": "path.toml:4: keyframes[1]: unknown key 'spp'",
    TWO + "fvo = 4": "unknown key 'fvo'; did you mean 'fov'?",
    TWO + "fov = 200": "path.toml:4: keyframes[1].fov: 200 is not allowed; fov must be an angle",
    TWO + "target = [3, 1, 4]": "path.toml:4: keyframes[1].target: (3.0, 1.0, 4.0) is not allowed",
    TWO + "time = 3": "path.toml:1: keyframes[0]: the key 'time' is missing; give each",
    "until = 3\n" + TWO: "path.toml:1: until: 3 is not allowed; there are no times",
    "[[keyframes]]\ntime = 1\n[[keyframes]]\ntime = 1.0": "keyframes[1].time: 1.0 is not allowed; times must",
    "[[keyframes]]\ntime = true\n[[keyframes]]\ntime = 1": "keyframes[0].time: True is not allowed",
    "[[keyframes]]\ntime = nan\n[[keyframes]]\ntime = 1": "keyframes[0].time: nan is not allowed",
    "[[keyframes]]\ntime = 1\n[[keyframes]]\ntime = '2'": "keyframes[1].time: '2' is not allowed",
    "until = 3\n[[keyframes]]\ntime = 1\n[[keyframes]]\ntime = 2": "until: 3 is not allowed; it is of a",
    "closed = true\n[[keyframes]]\ntime = 1\n[[keyframes]]\ntime = 2": "path.toml: until: missing; a",
}


@pytest.mark.parametrize("text", WRONG)
def test_what_is_wrong_names_its_place(text: str, tmp_path: Path) -> None:
    with pytest.raises(clrt.SceneError) as caught:
        read(tmp_path, text)
    assert WRONG[text] in str(caught.value), caught.value


def test_other_faults(tmp_path: Path) -> None:
    with pytest.raises(clrt.SceneError, match=r"path\.json: \[1\] is not allowed; keyframes are a table"):
        read(tmp_path, "[1]", BASE, "path.json")
    with pytest.raises(clrt.SceneError, match=r"keyframes\[0\]: the key 'origin' is missing"):
        read(tmp_path, TWO, None)
    with pytest.raises(clrt.SceneError, match=r"path\.yaml: the suffix '\.yaml' is not known"):
        read(tmp_path, TWO, BASE, "path.yaml")
    with pytest.raises(clrt.SceneError, match=r"no\.toml: .*no such file"):
        load_keyframes(tmp_path / "no.toml", BASE, clrt.Limits())


def test_keyframes_have_a_most(tmp_path: Path) -> None:
    """Each is a whole camera, in as few as three bytes."""
    path = tmp_path / "a.json"
    base = clrt.Camera(origin=(0, 1, 5), target=(0, 0, 0))
    path.write_text(json.dumps({"keyframes": [{}] * 8192}))
    assert len(load_keyframes(path, base, clrt.Limits()).cameras) == 8192
    path.write_text(json.dumps({"keyframes": [{}] * 8193}))
    with pytest.raises(clrt.SceneError, match="8 193 keyframes are too many; at most 8 192 are read"):
        load_keyframes(path, base, clrt.Limits())
