"""Checkpoints that are not whole, whatever is wrong with them: one error, and no memory that they ask for."""

from __future__ import annotations

import io
import json
import tracemalloc
import zipfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.engine.checkpoint import Checkpoint
from clrt.engine.picture import Picture
from clrt.engine.wavefront import RayCounts

TASK = {"size": "40 x 30", "spp": "4", "refinements": "0", "max_depth": "5", "layers": "depth,shape",
        "scene": "0" * 64}  # fmt: skip
RAYS = [Counter({"camera": 1200, "hits": 700, "camera_hits": 700}), Counter({"reflection": 5})]
RANGES = {"image": (0.0, 1e30), "depth": (0.0, np.inf), "shape": (-1.0, 6.0)}
Parts = dict[str, bytes]


def opened(path: Path, task: dict[str, str] = TASK) -> Checkpoint:
    return Checkpoint(path, task, Picture((0, 0, 40, 30), 40, ("depth", "shape"), 3), RayCounts(), RANGES)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "a.ck"
    saved = opened(path)
    saved.picture.pixels[...] = np.linspace(0, 1, saved.picture.pixels.size).reshape(30, 40, 3)
    saved.add(np.arange(300), RayCounts([Counter(row) for row in RAYS]))
    saved.save()
    return path


def members(path: Path) -> Parts:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def write(path: Path, parts: Parts, compression: int = zipfile.ZIP_STORED) -> None:
    with zipfile.ZipFile(path, "w", compression) as archive:
        for name, data in parts.items():
            archive.writestr(name, data)


def npy(array: np.ndarray) -> bytes:
    out = io.BytesIO()
    np.save(out, array, allow_pickle=True)
    return out.getvalue()


def told(text: str) -> Callable[[Parts], Parts]:
    return lambda parts: {**parts, "told.npy": npy(np.frombuffer(text.encode(), np.uint8))}


def rays(value: Any) -> Callable[[Parts], Parts]:
    return told(json.dumps({"mark": "clrt checkpoint 1", "job": TASK, "rays": value}))


def array(name: str, value: np.ndarray) -> Callable[[Parts], Parts]:
    return lambda parts: {**parts, f"{name}.npy": npy(value)}


def spoiled(name: str, value: float) -> Callable[[Parts], Parts]:
    """One number of a part, the last one."""

    def change(parts: Parts) -> Parts:
        numbers = np.load(io.BytesIO(parts[f"{name}.npy"]))
        numbers.flat[-1] = value
        return {**parts, f"{name}.npy": npy(numbers)}

    return change


def header(name: str, old: str, new: str) -> Callable[[Parts], Parts]:
    """A header that says something else of the same data; `new` has the length of `old`."""
    assert len(old) == len(new)
    return lambda parts: {**parts, f"{name}.npy": parts[f"{name}.npy"].replace(old.encode(), new.encode())}


DAMAGED: dict[str, Callable[[Parts], Parts]] = {
    "a shape of 1e12 pixels": header("pixels", "(30, 40, 3), }" + " " * 11, "(1000000000000, 40, 3), }"),
    "one pixel for all": array("pixels", np.ones((1, 1, 3), np.float32)),
    "one row for all": array("done", np.ones((1, 40), bool)),
    "doubles": array("pixels", np.ones((30, 40, 3))),
    "columns first": header("pixels", "False", "True "),
    "objects": array("told", np.array([{"a": 1}], object)),
    "a layer less": lambda parts: {n: d for n, d in parts.items() if "depth" not in n},
    "a layer of another kind": array("layer shape", np.ones((30, 40), np.float32)),
    "neither finished nor not": array("done", np.full((30, 40), 2, np.uint8).view(bool)),
    "nested brackets": told("[" * 200_000),
    "nested tables": told('{"mark":' * 20_000),
    "a number of many digits": told("9" * 100_000),
    "a long text": told('"' + "x" * 10_000_000 + '"'),
    "not text": told("\x80"),
    "no job": told('{"mark": "clrt checkpoint 1"}'),
    "a job of numbers": told('{"mark": "clrt checkpoint 1", "job": {"size": 3}}'),
    "a job of escapes": told('{"mark": "clrt checkpoint 1", "job": {"size": "\\u001b[2J"}}'),
    "rays that are no list": rays({"camera": 1}),
    "rays that are no tables": rays([3]),
    "rays that are no numbers": rays([{"camera": "many"}]),
    "rays below none": rays([{"camera": -1}]),
    "rays that are true": rays([{"camera": True}]),
    "rays in parts": rays([{"camera": 0.5}]),
    "rays beyond 64 bits": rays([{"camera": 1 << 63}]),
    "rays of 7 generations": rays([{}] * 7),
    "no rays at all": rays([]),
    "rays of other kinds": rays([*RAYS, {"photons": 1}]),
    "rays of too many pixels": rays([{**RAYS[0], "camera": 1204}]),
    "rays of a cleared picture": array("done", np.zeros((30, 40), bool)),
    "rays of a picture that is whole": array("done", np.ones((30, 40), bool)),
    "camera rays after the camera's": rays([{**RAYS[0], "camera": 1199}, {"camera": 1}]),
    "more hits than rays": rays([{**RAYS[0], "hits": 1201, "camera_hits": 1201}]),
    "other hits of the camera": rays([{**RAYS[0], "camera_hits": 5}]),
    "hits of the camera later": rays([RAYS[0], {"reflection": 5, "camera_hits": 5, "hits": 5}]),
    "children of nobody": rays([{"camera": 1200}, {"reflection": 1}]),
    "children without end": rays([RAYS[0], {"ambient": 1 << 62}]),
    "feelers of nobody": rays([{"camera": 1200, "feelers": 1}]),
    "feelers without end": rays([{**RAYS[0], "feelers": 1 << 62}]),
    "inner reflection without end": rays([{**RAYS[0], "total_internal_reflection": 1 << 62}]),
    **{
        f"{name} of {value}": spoiled(name, value)
        for name, values in {
            "pixels": (np.nan, np.inf, -np.inf, -1e-30, 1.1e30, -1e38),
            "layer depth": (np.nan, -1.0, -np.inf),
            "layer shape": (-2, 7, 2**31 - 1),
        }.items()
        for value in values
    },
}


@pytest.mark.parametrize("name", DAMAGED)
def test_parts_that_do_not_fit_the_render(path: Path, name: str) -> None:
    parts = members(path)
    changed = DAMAGED[name](parts)
    assert changed != parts
    write(path, changed)
    refused(path)


@pytest.mark.parametrize("method", [zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_compressed_parts(path: Path, method: int) -> None:
    parts = members(path)
    write(path, parts | {"pixels.npy": parts["pixels.npy"] + bytes(200_000_000)}, method)
    refused(path)  # a bomb
    write(path, parts, method)
    refused(path)
    data = bytearray(path.read_bytes())
    data[60:200] = b"\xff" * 140
    path.write_bytes(data)
    refused(path)  # and a broken one


@pytest.mark.parametrize(
    ("place", "value"), [(8, 1), (8, 0x41), (10, 99), (10, 14), (20, 0), (24, 0xFFFFFFFF), (42, 0x7FFFFFFF)]
)
def test_what_the_directory_says(path: Path, place: int, value: int) -> None:
    """Flags (encrypted, strongly), method (unknown, LZMA), sizes, offset of each member in turn."""
    whole = path.read_bytes()
    for _ in members(path):
        start = whole.index(b"PK\1\2", locals().get("start", 0) + 1)
        width = 2 if place < 12 else 4
        field = slice(start + place, start + place + width)
        path.write_bytes(whole[: field.start] + value.to_bytes(width, "little") + whole[field.stop :])
        refused(path)


def test_any_byte_changed_is_noticed_or_of_no_account(path: Path) -> None:
    whole = path.read_bytes()
    good = opened(path).picture.pixels
    for at in range(0, len(whole), 97):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1 :])
        try:
            again = opened(path)
        except clrt.ClrtError as error:
            assert "is not a whole checkpoint" in str(error)
        else:
            assert np.array_equal(again.picture.pixels, good) and again.counts.generations == RAYS


def test_a_whole_one_is_taken(path: Path) -> None:
    found = opened(path)
    assert np.count_nonzero(found.done) == 300 and found.counts.generations == RAYS
    assert found.picture.pixels[0, 1, 0] > 0
    with pytest.raises(clrt.ClrtError, match=r"another render: scene was 0{12}\.\.\., is 1"):
        opened(path, TASK | {"scene": "1"})


class Interrupted(RayCounts):
    """Counts during whose adding Ctrl-C comes: before, or after the first row."""

    def __init__(self, after: int) -> None:
        super().__init__(RAYS)
        self.after = after

    @property
    def generations(self) -> Any:
        for number, row in enumerate(self.rows):
            if number == self.after:
                raise KeyboardInterrupt
            yield row

    @generations.setter
    def generations(self, rows: Any) -> None:
        self.rows = rows


@pytest.mark.parametrize("after", [0, 1])
def test_an_interrupt_while_pixels_are_added_leaves_a_file_that_fits(path: Path, after: int) -> None:
    before = opened(path)
    with pytest.raises(KeyboardInterrupt), before:
        before.add(np.arange(300, 600), RayCounts([Counter(row) for row in RAYS]))
        before.add(np.arange(600, 900), Interrupted(after))
    found = opened(path)
    assert np.count_nonzero(found.done) == 600 and not found.done.reshape(-1)[600:].any()
    assert found.counts.generations == [Counter({kind: 2 * n for kind, n in row.items()}) for row in RAYS]


def refused(path: Path) -> None:
    before = path.read_bytes()
    tracemalloc.start()
    try:
        with pytest.raises(clrt.ClrtError, match=r"a\.ck: is not a whole checkpoint of clrt; give another"):
            opened(path)
        assert tracemalloc.get_traced_memory()[1] < (16 << 20)
    finally:
        tracemalloc.stop()
    assert path.read_bytes() == before
