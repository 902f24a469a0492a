"""Pictures that are within model files, as files."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path
from urllib.parse import unquote

import numpy as np

from clrt.base import notices
from clrt.base.errors import LimitError, SceneError
from clrt.base.files import opened, read_bytes, resolve
from clrt.base.limits import Limits
from clrt.base.places import At
from clrt.base.scratch import scratch
from clrt.images.file import read_samples
from clrt.meshfiles.broken import BrokenMesh
from clrt.meshfiles.gltf.stored import pictures_in
from clrt.meshfiles.gltf.textures import HEAD, Itself, readable


class Models:
    """Model files, of which each is read and parsed once however many of its pictures are asked for.

    All that is taken from one file is within `limits.file_bytes`: its pictures may be the same bytes.
    """

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._pictures: dict[Path, tuple[int, Callable[[int], bytes]]] = {}
        self._taken: dict[Path, int] = {}

    @contextmanager
    def file(self, path: Path, part: int | None, data: bytes | None = None) -> Iterator[Path]:
        """A file with a picture: `path`, or while the block lasts one with a part of it.

        `data` is what is in `path`, where that is known. SceneError names the model and the picture's number.
        """
        if part is None:
            yield path
            return
        where = f"{path}: images[{part}]"
        picture = self._picture(path, part, data)
        with scratch() as folder:
            file = folder / "picture"
            try:
                file.write_bytes(picture)
                with notices.without("its colours are "):  # glTF 2.0, "Images": what they declare is ignored
                    yield file
            except (SceneError, LimitError) as error:
                raise error.reworded(str(error).replace(str(file), where)) from None

    def count(self, path: Path) -> int:
        """How many pictures a model file names."""
        return self._opened(path, None)[0]

    def _opened(self, path: Path, data: bytes | None) -> tuple[int, Callable[[int], bytes]]:
        if path not in self._pictures:
            whole = read_bytes(path, self._limits) if data is None else data
            try:
                self._pictures[path] = pictures_in(whole, _binary(path))
            except BrokenMesh as error:
                raise SceneError(f"{path}: {error}"[:300]) from None
        return self._pictures[path]

    def _picture(self, path: Path, part: int, data: bytes | None) -> bytes:
        try:
            picture = self._opened(path, data)[1](part)
        except BrokenMesh as error:
            raise SceneError(f"{path}: {error}"[:300]) from None
        self._taken[path] = self._taken.get(path, 0) + len(picture)
        self._limits.check("file_bytes", self._taken[path], f"{path}: its pictures together")
        return picture


def itself_of(path: Path, at: At, limits: Limits, data: bytes) -> Itself:
    """What a glTF file's look has to know of the file, which holds `data`."""
    models, pixels = Models(limits), 0

    @cache
    def beside(uri: str) -> str | None:
        name = unquote(uri)
        if not os.path.isfile(path.parent / name):  # some name a folder where a picture has no name
            return None
        return resolve(name, path.parent, at).relative_to(path.parent.resolve()).as_posix()

    @cache
    def shows(file: str) -> bool:
        with opened(path.parent / file, limits) as picture:
            return readable(picture.read(HEAD))

    @cache
    def mean(file: str, part: int | None) -> np.ndarray:
        nonlocal pixels
        with models.file(path.parent / file, part, data if part is not None else None) as picture:
            # all these pictures together are as one: they are few and small where nobody means harm
            left = replace(limits, image_pixels=max(limits.image_pixels - pixels, 0))
            samples = read_samples(picture, left, _plain).reshape(-1, 3)
        pixels += len(samples)
        return samples.mean(axis=0)

    return Itself(path.name, beside, mean, shows)


def _plain(samples: np.ndarray) -> np.ndarray:
    """Samples as parts of the largest."""
    if samples.dtype.kind != "u":
        return samples
    return (samples / float(np.iinfo(samples.dtype).max)).astype(np.float32)


def _binary(path: Path) -> bool:
    return path.suffix.lower() == ".glb"
