"""Data within the addresses of a glTF file: RFC 2397, and what the specification asks of buffers."""

from __future__ import annotations

import base64
from pathlib import Path
from urllib.parse import quote

import numpy as np
import pytest

from clrt.base.errors import SceneError
from clrt.flatten.flatten import flatten
from tests.meshfiles.test_gltf import data_uri, document, read, write
from tests.model_samples import BASE, PICTURE, load, textured

CORNERS = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0029999017715454, 0.7699999809265137)]
NUMBERS = np.array(CORNERS, "<f4").tobytes()  # whose base64 has a + and a /
TEXT = base64.b64encode(NUMBERS).decode()
TYPE = "application/octet-stream"


def corners(folder: Path, uri: str, length: int = 36) -> list[list[float]]:
    vertices, *_ = read(write(folder, document(buffers=[{"uri": uri, "byteLength": length}])))
    return [*vertices.tolist()]


def percents(data: bytes) -> str:
    return "".join(f"%{byte:02x}" for byte in data)


@pytest.mark.parametrize(
    "begin",
    [f"data:{TYPE};base64", f"data:{TYPE};BASE64", f"DATA:{TYPE.upper()};Base64", "data:;bAsE64",
     "data:application/gltf-buffer;base64", f"data:{TYPE};charset=utf-8;base64",
     f'data:{TYPE};name="a;b";base64'],
)  # fmt: skip
@pytest.mark.parametrize("form", ["plain", "percents", "lines", "padded"])
def test_base64_is_read_however_it_is_written(tmp_path: Path, begin: str, form: str) -> None:
    assert {"+", "/"} <= set(TEXT)
    text = {
        "plain": TEXT,
        "percents": quote(TEXT, safe=""),
        "lines": f"{TEXT[:19]}\r\n{TEXT[19:40]}%0D%0A {TEXT[40:]}\n",
        "padded": base64.b64encode(NUMBERS + b"x").decode().replace("=", "%3D"),
    }[form]
    assert corners(tmp_path, f"{begin},{text}") == [list(corner) for corner in CORNERS]


@pytest.mark.parametrize("begin", [f"data:{TYPE},", "DATA:,", "Data:;x=y,", "data:application/gltf-buffer,"])
def test_data_in_percent_signs(tmp_path: Path, begin: str) -> None:
    assert corners(tmp_path, begin + percents(NUMBERS)) == [list(corner) for corner in CORNERS]


@pytest.mark.parametrize(
    ("uri", "says"),
    [
        (f"data:{TYPE};bas64,{TEXT}", r"uri begins with 'data:.*;bas64,'; data begins like data:TYPE;base"),
        (f"data:{TYPE};base64;x=y,{TEXT}", r"uri begins with 'data:.*;base64;x=y,'"),
        (f"data:base64,{TEXT}", r"uri begins with 'data:base64,'"),
        (f"data:{TYPE};base64", r"uri begins with 'data:application/octet-stream;base64'"),
        (f"data:{TYPE};base64{TEXT}", "uri begins with "),
        (f"data:image/png;base64,{TEXT}", f"uri is of the type 'image/png'; it must be {TYPE} or app"),
        (f"data:text/plain,{percents(NUMBERS)}", "uri is of the type 'text/plain'"),
        (f"data:{TYPE};base64,{TEXT[:8]}!!!!{TEXT[8:]}", "is not in base64: letter 9 is '!'; it must be"),
        (f"data:{TYPE};base64,{TEXT.replace('+', '-')}", r"is not in base64: letter \d+ is '-'"),
        (f"data:{TYPE};base64,AAA=AAA={TEXT}", "is not in base64: letter 4 is '='"),
        (f"data:{TYPE};base64,{TEXT}====", "is not in base64: letter 49 is '='"),
        (f"data:{TYPE};base64,{TEXT[:8]}é{TEXT[8:]}", "is not in base64: letter 9 is "),
        (f"data:{TYPE};base64,{TEXT[:-1]}", "is not in base64: it has 47 letters, not 4 for every 3 bytes"),
        (f"data:{TYPE};base64,{TEXT[:8]}%zz{TEXT[8:]}", "uri has '%zz'; % stands before two digits"),
        (f"data:{TYPE},{percents(NUMBERS)[:-1]}", "uri has '%3'"),
        (f"data:{TYPE};base64,{TEXT[:-4]}", "byteLength is 36, and it has 33 bytes; it may be cut short"),
        (f"data:{TYPE},{percents(NUMBERS[:35])}", "byteLength is 36, and it has 35 bytes"),
        ("data:,", "byteLength is 36, and it has 0 bytes"),
    ],
)
def test_what_is_no_such_data_is_refused(tmp_path: Path, uri: str, says: str) -> None:
    with pytest.raises(SceneError, match=rf"a\.gltf .*buffers\[0\](\.| ){says}") as caught:
        corners(tmp_path, uri)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 400


@pytest.mark.parametrize("more", [0, 1, 400])
def test_of_a_file_beside_it_as_many_bytes_count_as_are_declared(tmp_path: Path, more: int) -> None:
    (tmp_path / "b in.bin").write_bytes(NUMBERS + bytes(more))
    assert corners(tmp_path, "b%20in.bin") == [list(corner) for corner in CORNERS]
    with pytest.raises(SceneError, match=rf"buffers\[0\]\.byteLength is 999, and it has {36 + more} bytes"):
        corners(tmp_path, "b%20in.bin", 999)
    with pytest.raises(SceneError, match=r"accessors\[0\] reaches beyond the 24 bytes of its buffer"):
        corners(tmp_path, "b%20in.bin", 24)


@pytest.mark.parametrize(
    "uri",
    [
        f"DATA:image/png;BASE64,{base64.b64encode(PICTURE).decode()}",
        "data:image/png;base64," + percents(base64.b64encode(PICTURE)),
        "data:;Base64," + "".join(f"%{byte:02X}%0D%0A" for byte in base64.b64encode(PICTURE)),
        "data:image/png," + percents(PICTURE),
    ],
)
def test_pictures_are_read_by_the_same_rules(tmp_path: Path, uri: str) -> None:
    (tmp_path / "x.png").write_bytes(PICTURE)
    found, wanted = (flatten(load(tmp_path, textured(BASE, ({"uri": name},)))) for name in (uri, "x.png"))
    np.testing.assert_array_equal(np.asarray(found.texels), np.asarray(wanted.texels))


def test_a_picture_at_two_places_is_refused(tmp_path: Path) -> None:
    image = {"uri": data_uri(PICTURE), "bufferView": 1}
    with pytest.raises(SceneError, match=r"its images are not .*: an image has a uri or a bufferView, not"):
        load(tmp_path, textured(BASE, (image,)))
