"""Pictures that are within model files, as files."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import unquote

import numpy as np

from clrt.base.errors import LimitError, SceneError
from clrt.base.files import read_bytes, resolve
from clrt.base.limits import Limits
from clrt.base.places import At
from clrt.images.file import read_samples
from clrt.meshfiles.gltf import read_picture
from clrt.meshfiles.gltf_document import BrokenMesh
from clrt.meshfiles.gltf_textures import Itself


@contextmanager
def picture_file(path: Path, part: int | None, limits: Limits, data: bytes | None = None) -> Iterator[Path]:
    """A file with a picture: `path`, or while the block lasts one with a part of it.

    `data` is what is in `path`, where that is known. SceneError names the model and the picture's number.
    """
    if part is None:
        yield path
        return
    where = f"{path}: images[{part}]"
    try:
        picture = read_picture(read_bytes(path, limits) if data is None else data, _binary(path), part)
    except BrokenMesh as error:
        raise SceneError(f"{path}: {error}"[:300]) from None
    descriptor, name = tempfile.mkstemp()
    try:
        with open(descriptor, "wb") as file:
            file.write(picture)
        yield Path(name)
    except (SceneError, LimitError) as error:
        raise type(error)(str(error).replace(name, where)) from None
    finally:
        os.unlink(name)


def itself_of(path: Path, at: At, limits: Limits, data: bytes) -> Itself:
    """What a glTF file's look has to know of the file, which holds `data`."""

    def beside(uri: str) -> str | None:
        name = unquote(uri)
        if not os.path.exists(path.parent / name):
            return None
        return resolve(name, path.parent, at).relative_to(path.parent.resolve()).as_posix()

    def mean(file: str, part: int | None) -> np.ndarray:
        with picture_file(path.parent / file, part, limits, data if part is not None else None) as picture:
            return read_samples(picture, limits, _plain).reshape(-1, 3).mean(axis=0)

    return Itself(path.name, beside, mean)


def _plain(samples: np.ndarray) -> np.ndarray:
    """Samples as parts of the largest."""
    if samples.dtype.kind != "u":
        return samples
    return (samples / float(np.iinfo(samples.dtype).max)).astype(np.float32)


def _binary(path: Path) -> bool:
    return path.suffix.lower() == ".glb"
