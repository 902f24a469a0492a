"""Where kernels, scenes and the validation package are: in a wheel, an editable install, a bare checkout.

A wheel holds them inside itself (`clrt/_kernels`, `clrt/_scenes`, `clrt_validation`); an editable install
and a bare checkout have them beside `clrt/`. The packed folder is taken when it is there, so that an
installed clrt never picks up whatever happens to lie beside it in site-packages.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import sys
from pathlib import Path
from types import ModuleType

from clrt.base.errors import ClrtError, SceneError
from clrt.base.room import check_date
from clrt.base.suggest import nearest

PACKAGE = Path(__file__).resolve().parents[1]
if not PACKAGE.is_dir():
    raise ImportError(f"{PACKAGE}: clrt cannot run from within an archive; unpack or install it")
SCENE_SUFFIXES = (".toml", ".json", ".nff", ".txt", ".xml", ".py")
TOOL_PREFIX = "generate_"  # scripts that write what scenes load, and are none themselves


def kernel_folder() -> Path:
    """Folder of the `.cl` and `.clh` files. ClrtError when the installation lacks it."""
    return _folder("_kernels", "kernels", "*.cl")


def kernel_text(file: Path) -> str:
    """The text of a kernel file. ClrtError when it cannot be read."""
    try:
        return file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ClrtError(f"{file}: the kernel file cannot be read ({error}); install clrt again") from None


def scene_folder() -> Path:
    """Folder of the scenes that ship with the package. ClrtError when the installation lacks it."""
    return _folder("_scenes", "scenes", "*.toml")


def shipped_scenes() -> dict[str, Path]:
    """The scenes that ship, name (file name without suffix) -> file or script, in alphabetical order."""
    files = (file for file in scene_folder().iterdir() if file.suffix in SCENE_SUFFIXES)
    scenes = {file.stem: file for file in files if not file.name.startswith(TOOL_PREFIX)}
    return dict(sorted(scenes.items()))


def scene_file(name: str) -> Path:
    """The file that `name` means: a file, or else a scene that ships. SceneError names the nearest one.

    A scene that ships is known by its name ("showcase") and by its place in a checkout
    ("scenes/showcase.toml"), as documents write it.
    """
    path, shipped = Path(name), shipped_scenes()
    folder = os.path.isdir(name)
    if _is_something(name) and not folder:
        return path
    if name in shipped:
        return shipped[name]
    if path.parts == ("scenes", path.name) and getattr(shipped.get(path.stem), "name", "") == path.name:
        return shipped[path.stem]
    if folder:
        return path
    if path.suffix or len(path.parts) > 1:
        raise SceneError(f"{name}: there is no such file")
    if not name:
        raise SceneError("'' is no file's name; `clrt scenes` lists the scenes that ship")
    near = nearest(name, shipped, cutoff=0.6)
    hint = f"did you mean {near!r}?" if near else "`clrt scenes` lists the ones that ship"
    raise SceneError(f"{name}: neither a file nor a scene that ships with clrt; {hint}")


def _is_something(name: str) -> bool:
    """Whether a name is not merely that of a missing file: what cannot be looked at, opening it says."""
    try:
        os.lstat(name)
    except (FileNotFoundError, NotADirectoryError):
        return False
    except (OSError, ValueError):
        return True
    return True


def validation_module(name: str) -> ModuleType:
    """Import `clrt_validation.<name>`, in a checkout from its `validation/`.

    There the folder is registered under its installed name, so that its relative imports work and one copy
    of each module exists whichever way it was reached. (An editable install leaves a copy in site-packages,
    which does not follow the checkout.) ClrtError where the libraries that it uses would fail.
    """
    check_date()
    folder = PACKAGE.parent / "validation"
    checkout = not (PACKAGE / "_kernels").is_dir() and folder.is_dir()
    installed = not checkout and importlib.util.find_spec("clrt_validation") is not None
    if "clrt_validation" not in sys.modules and not installed:
        spec = importlib.util.spec_from_file_location(
            "clrt_validation", folder / "__init__.py", submodule_search_locations=[str(folder)]
        )
        if spec is None or spec.loader is None or not (folder / "__init__.py").is_file():
            raise ClrtError(f"{folder}: the validation package is missing; install clrt again")
        package = importlib.util.module_from_spec(spec)
        sys.modules["clrt_validation"] = package
        spec.loader.exec_module(package)
    return importlib.import_module(f"clrt_validation.{name}")


def _folder(packed: str, beside: str, pattern: str) -> Path:
    for folder in (PACKAGE / packed, PACKAGE.parent / beside):
        if next(folder.glob(pattern), None) is not None:
            return folder
    raise ClrtError(f"{PACKAGE}: its folder {beside} is missing; install clrt again")
