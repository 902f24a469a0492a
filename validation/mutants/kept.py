"""What oracles say of cases, kept from run to run: it takes minutes, and no fault changes it."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Final
from zipfile import BadZipFile

import numpy as np
from platformdirs import user_cache_dir

from clrt.base.atomic import replacing
from clrt.base.errors import ClrtError
from clrt.base.resources import scene_folder

from ..independence import code
from ..types import OracleImage

_PACKAGES: Final = ("mitsuba", "drjit", "numpy", "scipy", "openimageio", "trimesh")
_LONGEST: Final = 255  # of a file's name


def once(
    oracle: str, what: Any, folder: str | Path | None, make: Callable[[], OracleImage]
) -> OracleImage:
    """What `make` gives, an oracle's picture; or what an earlier run kept of the same question and code.

    what: the question, all that the answer is made from; its repr tells it from others. Files in the folder
    that it names count by what is in them, those that ship wherever they are.
    """
    asked = f"{folder} {what!r}".replace(str(scene_folder()), "scenes")
    held = hashlib.sha256(f"{code(oracle)} {_harness()} {versions()} {asked}".encode())
    for path in sorted(_files(what, Path(folder or "."))):
        held.update(hashlib.sha256(path.read_bytes()).digest())
    name = held.hexdigest()[:32]
    file = Path(user_cache_dir("clrt", appauthor=False)) / "references" / f"{name}.npz"
    with suppress(OSError, ValueError, KeyError, EOFError, BadZipFile):
        return _picture(file)
    made = make()
    with suppress(OSError, ClrtError):  # only time is lost
        file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with replacing(file) as temporary, temporary.open("wb") as opened:
            np.savez(opened, **_arrays(made))
    return made


def _arrays(made: OracleImage) -> dict[str, Any]:
    """A picture as named arrays: numbers only, so that reading them runs nothing."""
    arrays: dict[str, Any] = {"pixels": made.pixels, "name": made.name, "seconds": made.seconds}
    arrays |= {name: value for name in ("t", "shape") if (value := getattr(made, name)) is not None}
    for group in ("by_ray", "layers"):
        arrays |= {f"{group}/{name}": value for name, value in getattr(made, group).items()}
    return arrays


def _picture(file: Path) -> OracleImage:
    """It again. OSError, ValueError, KeyError, EOFError, BadZipFile where there is none, or it is damaged."""
    with np.load(file, allow_pickle=False) as kept:
        arrays = {name: kept[name] for name in kept.files}
    groups: dict[str, dict[str, np.ndarray]] = {"by_ray": {}, "layers": {}}
    for name, value in arrays.items():
        group, _, key = name.partition("/")
        if group in groups:
            groups[group][key] = value
    t, shape = arrays.get("t"), arrays.get("shape")
    of, seconds = str(arrays["name"]), float(arrays["seconds"])
    return OracleImage(
        arrays["pixels"], groups["by_ray"], t, shape, of, seconds, layers=groups["layers"]
    )


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
def versions() -> str:
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
