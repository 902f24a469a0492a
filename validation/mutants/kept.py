"""What oracles say of cases, kept from run to run: it takes minutes, and no fault changes it."""

from __future__ import annotations

import hashlib
import pickle
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Final, TypeVar

from platformdirs import user_cache_dir

from clrt.base.atomic import replacing
from clrt.base.errors import ClrtError

from ..independence import code

Answer = TypeVar("Answer")

_PACKAGES: Final = ("mitsuba", "drjit", "numpy", "scipy", "openimageio", "trimesh")
_LONGEST: Final = 255  # of a file's name


def once(oracle: str, what: Any, folder: str | Path | None, make: Callable[[], Answer]) -> Answer:
    """What `make` gives, an oracle's answer; or what an earlier run kept of the same question and code.

    what: the question, all that the answer is made from; its repr tells it from others. Files in the folder
    that it names count by what is in them.
    """
    held = hashlib.sha256(f"{code(oracle)} {_harness()} {_versions()} {folder} {what!r}".encode())
    for path in sorted(_files(what, Path(folder or "."))):
        held.update(hashlib.sha256(path.read_bytes()).digest())
    name = held.hexdigest()[:32]
    file = Path(user_cache_dir("clrt", appauthor=False)) / "references" / f"{name}.pickle"
    with suppress(OSError, pickle.UnpicklingError, EOFError):
        kept: Answer = pickle.loads(file.read_bytes())
        return kept
    made = make()
    with suppress(OSError, ClrtError):  # only time is lost
        file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with replacing(file) as temporary:
            temporary.write_bytes(pickle.dumps(made))
    return made


def _files(what: Any, folder: Path) -> set[Path]:
    """The files that any text in a question names; of a model that names more, all that lie beside it."""
    if isinstance(what, Mapping):
        what = list(what.values())
    if isinstance(what, list | tuple):
        return set().union(*(_files(part, folder) for part in what))
    if not isinstance(what, str) or not what or len(what) > _LONGEST or not (folder / what).is_file():
        return set()
    path = folder / what
    if path.suffix.lower() not in (".gltf", ".obj"):
        return {path}
    return {file for file in path.parent.iterdir() if file.is_file()}


@cache
def _versions() -> str:
    """Of Python, and of the packages that make answers."""
    found = [sys.version]
    for name in _PACKAGES:
        with suppress(PackageNotFoundError):
            found.append(f"{name} {version(name)}")
    return " ".join(found)


@cache
def _harness() -> str:
    """Of what asks the oracles."""
    texts = [Path(__file__).parents[1].joinpath(name).read_bytes() for name in ("oracles.py", "types.py")]
    return hashlib.sha256(b"".join(texts)).hexdigest()
