"""Pictures within files of all kinds of models, as files."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from clrt.base.errors import SceneError
from clrt.base.files import read_bytes
from clrt.base.limits import Limits
from clrt.base.places import At
from clrt.images.file import write
from clrt.meshfiles import embedded
from clrt.meshfiles.file import broken_said, open_mesh
from clrt.meshfiles.vertex_colors import picture


@contextmanager
def picture_file(path: Path, part: int | None, limits: Limits) -> Iterator[Path]:
    """A file with a picture: `path`, or while the block lasts one with a part of it.

    The only part of a PLY are the colours of its vertices or faces. Raises as `embedded.picture_file`.
    """
    if part is None or path.suffix.lower() != ".ply":
        with embedded.picture_file(path, part, limits) as file:
            yield file
        return
    at = At(path.name)
    with broken_said(path, at):
        colors = picture(open_mesh(read_bytes(path, limits), path, at, limits, apart=True))
    if colors is None or part:
        has = "no colours of vertices or faces" if colors is None else "its colours of vertices or faces"
        raise SceneError(f"{path}: images[{part}] is not there; it has {has}")
    limits.check("texture_bytes", 12 * colors.shape[0] * colors.shape[1], str(path))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "colors.exr")
        write(file, [colors])
        yield file
