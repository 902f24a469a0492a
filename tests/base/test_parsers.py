"""Whatever the text: a parser gives what it reads, or a `ClrtError` of one line. Hypothesis writes them."""

from __future__ import annotations

import io
import json
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

import clrt
from clrt.base.limits import Limits, parse
from clrt.base.resources import validation_module
from clrt.cli.options import parser

pytestmark = pytest.mark.filterwarnings("ignore::clrt.ClrtWarning")
many = settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.too_slow])
few = settings(many, max_examples=40)

NUMBERS = ("0", "1", "-1", "3", "0.5", "1e30", "1e-40", "1e999", "nan", "inf", "9" * 400, "0x1", "1_0", "")
NAMES = (
    "camera", "origin", "target", "shapes", "type", "sphere", "center", "radius", "materials", "glass",
    "lights", "point", "position", "transform", "rotate", "background", "mesh", "file", "vertices",
)  # fmt: skip
TOML = (*"[]{}=.,\n\"'# \0", "[[", "]]", "'''", '"""', "true", "\\u1")
JSON = (*'[]{}:,"\n', "null", "true", "\\ud800", "\ufeff", "NaN")
NFF = (*"bvlfscp# \n", "pp", "from", "at", "up", "angle", "hither", "resolution")
THESIS = (
    "Width", "Height", "Focal", "Ambient", "Light", "Point", "Spectrum", "Intensity", "Sphere", "Radius",
    "Surface", "Constants", "Plane", "Vector", "Polygon", "Mesh", "None", "Red", "Ellipsoid", "Center",
    "Radii", "Quadric", "\n", " ",
)  # fmt: skip


def texts(*words: str, between: str = "") -> st.SearchStrategy[str]:
    """Texts of these words, of numbers, and of a few characters that nobody foresaw."""
    word = st.sampled_from([*words, *words, *NUMBERS]) | st.text(max_size=3)
    return st.lists(word, max_size=60).map(between.join)


def good(error: clrt.ClrtError) -> bool:
    """One line, of a length that somebody reads."""
    text = str(error)
    return 0 < len(text) < 2000 and text.isprintable()


def loads(text: str, suffix: str) -> clrt.Scene | None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, f"scene{suffix}")
        file.write_bytes(text.encode("utf-8", "surrogatepass"))
        try:
            return clrt.load(file)
        except clrt.ClrtError as error:
            assert good(error), str(error)[:3000]
            return None


@many
@given(texts(*NAMES, *TOML))
@example("[camera]\norigin = [0, 0, 1]\ntarget = [0, 0, 0]")
def test_toml(text: str) -> None:
    loads(text, ".toml")


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=9) | st.sampled_from(NAMES),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.sampled_from(NAMES), inner, max_size=5),
    max_leaves=30,
)


@many
@given(texts(*(f'"{name}"' for name in NAMES), *JSON) | values.map(json.dumps))
def test_json(text: str) -> None:
    loads(text, ".json")


@many
@given(st.dictionaries(st.sampled_from(NAMES), values, max_size=6) | values)
def test_dicts(data: object) -> None:
    try:
        clrt.load_dict(data)
    except clrt.ClrtError as error:
        assert good(error), str(error)[:3000]


@many
@given(texts(*NFF, between=" "))
@example("v from 0 0 5 at 0 0 0 up 0 1 0 angle 40 hither 1 resolution 9 9")
def test_nff(text: str) -> None:
    loads(text, ".nff")


@many
@given(texts(*THESIS, between=" "))
def test_thesis(text: str) -> None:
    loads(text, ".txt")


LIMITS = tuple(Limits.__dataclass_fields__)


@many
@given(st.text(max_size=40) | st.builds("{}={}".format, st.sampled_from(LIMITS), st.text()))
@example("depth=" + "9" * 19)
@example("depth=²")
def test_limits(text: str) -> None:
    try:
        name, number = parse(text)
    except clrt.ClrtError as error:
        assert good(error), str(error)[:3000]
    else:
        assert Limits(**{name: number})


WORDS = (
    "render", "hash", "compare", "convert", "-o", "x.png", "--width", "--crop", "--spp", "--limit", "--bits",
    "--layers", "--exposure", "--help", "--",
)  # fmt: skip


@many
@given(st.lists(st.sampled_from(WORDS) | st.sampled_from(NUMBERS) | st.text(max_size=5), max_size=12))
def test_command_lines(words: list[str]) -> None:
    """They are understood, or the process ends with 2 and one line (0 for --help)."""
    try:
        parser().parse_args(words)
    except SystemExit as end:
        assert end.code in (0, 2)


headers = st.builds(
    "{{'descr': {!r}, 'fortran_order': {}, 'shape': {}, }}".format,
    st.sampled_from(["<f4", "|u1", "|b1", "|O", "<U9", "x", "<f8", "(2,)<f4"]),
    st.sampled_from(["False", "True", "1", "[" * 300]),
    st.lists(st.integers(-1, 2**63), max_size=4).map(tuple) | st.text(max_size=4),
) | st.text(max_size=40)


@pytest.fixture(scope="module")
def resume() -> Callable[[bytes], None]:
    """Goes on from a checkpoint with these bytes; what comes out is the scene's picture or an error."""
    tracer = clrt.Tracer(clrt.load_dict(validation_module("hostile.seeds").RESUMED))
    whole = tracer.render().hash

    def attempt(data: bytes) -> None:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "part.ck")
            file.write_bytes(data)
            try:
                assert tracer.render(checkpoint=file).hash == whole
            except clrt.ClrtError as error:
                assert good(error), str(error)[:3000]

    return attempt


@few
@given(st.sampled_from(["pixels.npy", "done.npy", "told.npy"]), headers, st.binary(max_size=64))
def test_arrays_of_checkpoints(resume: Callable[[bytes], None], name: str, header: str, body: bytes) -> None:
    whole = validation_module("hostile.archives").contents(validation_module("hostile.seeds").checkpoint())
    held, words = io.BytesIO(), header.encode("latin-1", "replace")
    with zipfile.ZipFile(held, "w") as archive:
        for other, data in whole:
            spoiled = b"\x93NUMPY\x01\x00" + len(words).to_bytes(2, "little") + words + body
            archive.writestr(other, spoiled if other == name else data)
    resume(held.getvalue())


@few
@given(values)
def test_texts_of_checkpoints(resume: Callable[[bytes], None], rays: object) -> None:
    whole = validation_module("hostile.archives").contents(validation_module("hostile.seeds").checkpoint())
    arrays = {name[:-4]: np.load(io.BytesIO(data)) for name, data in whole}
    told = {**json.loads(arrays["told"].tobytes()), "rays": rays}
    arrays["told"] = np.frombuffer(json.dumps(told).encode(), np.uint8)
    held = io.BytesIO()
    np.savez(held, **arrays)
    resume(held.getvalue())
