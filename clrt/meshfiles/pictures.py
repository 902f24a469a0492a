"""Pictures within files of all kinds of models, as files."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from clrt.base.errors import SceneError
from clrt.base.files import read_bytes
from clrt.base.limits import Limits
from clrt.base.places import At
from clrt.base.scratch import scratch
from clrt.images.file import write
from clrt.meshfiles.embedded import Models
from clrt.meshfiles.file import broken_said, open_mesh
from clrt.meshfiles.vertex_colors import picture


class PictureFiles:
    """Files with pictures, and those within models, of which each is read once (`Models`)."""

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._models = Models(limits)

    def corners(self, path: Path, part: int | None) -> bool:
        """Whether a part of a file is the colours of its vertices or faces (vertex_colors.py)."""
        if part is None:
            return False
        return path.suffix.lower() == ".ply" or part == self._models.count(path)

    @contextmanager
    def file(self, path: Path, part: int | None) -> Iterator[Path]:
        """A file with a picture: `path`, or while the block lasts one with a part of it.

        The only part of a PLY are the colours of its vertices or faces; those of a glTF's vertices come after
        its last picture. Raises as `Models.file`.
        """
        if not self.corners(path, part):
            with self._models.file(path, part) as file:
                yield file
            return
        at = At(path.name)
        with broken_said(path, at):
            data = read_bytes(path, self._limits)
            colors = picture(open_mesh(data, path, at, self._limits, apart=True))
        if colors is None or (part and path.suffix.lower() == ".ply"):
            has = "no colours of vertices or faces" if colors is None else "its colours of vertices or faces"
            raise SceneError(f"{path}: images[{part}] is not there; it has {has}")
        self._limits.check("texture_bytes", 12 * colors.shape[0] * colors.shape[1], str(path))
        with scratch() as folder:
            file = folder / "colors.exr"
            write(file, [colors])
            yield file
