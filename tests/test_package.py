"""What is shipped: the wheel holds the tree's files, and works where there is no tree."""

from __future__ import annotations

import subprocess
import sys
import venv
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

import clrt
from clrt.base import resources
from clrt.base.errors import ClrtError
from clrt.device import intel
from clrt.device.platforms import choose
from clrt.version import __version__

ROOT = Path(__file__).resolve().parent.parent
PACKED = {
    "clrt": "clrt", "kernels": "clrt/_kernels", "scenes": "clrt/_scenes", "validation": "clrt_validation",
}  # fmt: skip


def tree() -> Iterator[str]:
    """Names in the wheel of all files that the tree has for it."""
    for folder, packed in PACKED.items():
        for file in (ROOT / folder).rglob("*"):
            if file.is_file() and "__pycache__" not in file.parts:
                yield f"{packed}/{file.relative_to(ROOT / folder).as_posix()}"


def pip(environment: Path | None, command: str, *arguments: str) -> None:
    where = ["--python", str(environment / "bin" / "python")] if environment else []
    subprocess.run([sys.executable, "-m", "pip", *where, command, "--quiet", *arguments], check=True)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    pip(None, "wheel", "--no-deps", "--wheel-dir", str(folder), str(ROOT))
    (built,) = folder.glob("clrt-*.whl")
    return built


@pytest.mark.slow
def test_the_wheel_holds_the_files_of_the_tree(wheel: Path):
    with zipfile.ZipFile(wheel) as archive:
        held = {name for name in archive.namelist() if ".dist-info/" not in name}
        beside = {name.partition(".data/data/")[2] for name in held if ".data/data/" in name}
        held = {name for name in held if ".data/" not in name}
        (metadata,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        text = archive.read(metadata).decode()
    assert held == set(tree())
    assert beside == {
        "share/man/man1/clrt.1", "share/bash-completion/completions/clrt",
        "share/zsh/site-functions/_clrt", "share/clrt/completion/clrt.csh",
    }  # fmt: skip
    assert f"Version: {__version__}\n" in text and "License-File: LICENSE\n" in text


def test_nothing_in_the_tree_is_a_link():
    """A wheel holds what a link leads to on the machine of who built it, and pip takes no sdist with one."""
    folders = (*PACKED, "docs", "installers", "tests", ".ci")
    assert [file for folder in folders for file in (ROOT / folder).rglob("*") if file.is_symlink()] == []


@pytest.mark.slow
def test_an_installed_wheel_renders_from_another_folder(wheel: Path, tmp_path: Path):
    """In a new environment that has nothing but what the wheel says it needs."""
    home = tmp_path / "environment"
    venv.create(home, with_pip=False, symlinks=True)
    (packages,) = home.glob("lib/python3*/site-packages")
    # with the driver that the tests run on, where it is one from PyPI
    driver = "intel" if choose()[0].platform == intel.PLATFORM else "pocl"
    pip(home, "install", f"{wheel}[{driver}]")
    elsewhere = tmp_path / "else where"
    elsewhere.mkdir()

    def python(*arguments: str) -> str:
        done = subprocess.run(
            [home / "bin" / "python", *arguments], cwd=elsewhere, capture_output=True, text=True, check=True
        )
        return done.stdout

    folders = "r.PACKAGE, r.kernel_folder(), r.scene_folder(), r.validation_module('selftest').__file__"
    where = python("-c", f"import clrt.base.resources as r; print({folders})")
    assert where.count(str(packages)) == 4 and str(ROOT) not in where
    line = python("-m", "clrt", "render", "showcase", "--width", "64", "-o", "a.exr")
    assert line.startswith(f"{elsewhere}/a.exr: 64 x 36, ")
    held = python("-m", "clrt", "hash", "a.exr").split()[0]
    assert held == clrt.render(clrt.load(resources.scene_file("showcase")), width=64).hash


def test_every_public_name_is_there():
    for name in clrt.__all__:
        assert getattr(clrt, name) is not None
    assert set(clrt.__all__) <= set(dir(clrt))
    with pytest.raises(AttributeError, match="rendr"):
        clrt.rendr  # noqa: B018


def test_the_packed_folder_comes_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    package = tmp_path / "clrt"
    monkeypatch.setattr(resources, "PACKAGE", package)
    with pytest.raises(ClrtError, match="kernels is missing"):
        resources.kernel_folder()
    for folder in (tmp_path / "kernels", package / "_kernels"):
        folder.mkdir(parents=True)
        (folder / "trace.cl").write_text("")
        assert resources.kernel_folder() == folder


def test_validation_is_found_in_a_checkout_from_anywhere(tmp_path: Path):
    """Bare: the folder alone is on the path, as for somebody who has installed nothing."""
    code = (
        "import sys; sys.path.append(sys.argv[1])\n"
        "import clrt.base.resources as r; print(r.validation_module('selftest').__name__)"
    )
    command = [sys.executable, "-c", code, str(ROOT)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout == "clrt_validation.selftest\n"
