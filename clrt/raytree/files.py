"""Files of a tree of rays, by the ending of their name; whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Final

from clrt.base.atomic import check_replaceable, replacing, write_json, write_text
from clrt.base.errors import ClrtError, MissingPackage
from clrt.base.install import pip_install

if TYPE_CHECKING:
    from clrt.raytree.tree import RayTree

SUFFIXES: Final = (".json", ".html", ".glb")


def check(path: str | os.PathLike[str]) -> str:
    """The ending of a file that can be written. ClrtError, before anything is computed, where it cannot."""
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise ClrtError(f"{path}: the name must end in {', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}")
    if suffix == ".glb":
        import importlib.util

        if importlib.util.find_spec("trimesh") is None:
            raise MissingPackage(f"{path}: needs trimesh; install it with: {pip_install('trimesh')}")
    check_replaceable(path)
    return suffix


def write(tree: RayTree, path: str | os.PathLike[str]) -> Path:
    """Write it; return where."""
    suffix = check(path)
    if suffix == ".json":
        write_json(path, tree.as_dict(), finite=True)
    elif suffix == ".html":
        from clrt.raytree.page import page

        write_text(path, page(tree))
    else:
        from clrt.raytree.tubes import glb

        made = glb(tree)
        with replacing(path) as temporary:
            temporary.write_bytes(made)
    return Path(path)
