"""The manual page and the shells' completion are made from the parser: all of it, the same each time."""

from __future__ import annotations

import importlib.util
import re
import shutil
import subprocess
from pathlib import Path
from types import ModuleType

import pytest

from clrt.base.resources import shipped_scenes
from clrt.cli.options import parser
from clrt.version import __version__

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def shell() -> ModuleType:
    for name in ("shtab", "argparse_manpage"):
        pytest.importorskip(name, reason="needs the extra [dev]")
    spec = importlib.util.spec_from_file_location("shell", ROOT / "installers" / "shell.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_files_are_the_same_each_time(shell: ModuleType, tmp_path: Path) -> None:
    placed = shell.write(tmp_path / "here")
    assert {Path(file).name: place for file, place in placed.items()} == shell.PLACES
    assert {Path(file).name: Path(file).read_text("utf-8") for file in placed} == shell.made()


def test_the_manual_has_every_command_and_option(shell: ModuleType) -> None:
    text = shell.made()["clrt.1"].replace("\\-", "-")
    assert text.startswith(f'.TH CLRT "1" "version {__version__}"') and str(ROOT) not in text
    for name, command in parser().commands.items():
        assert f"COMMAND \\fI\\,'clrt {name}'" in text, name
        for action in command._actions:
            for option in set(action.option_strings) - {"-h", "--help"}:
                assert option in text, (name, option)


def completed(script: Path, *words: str) -> list[str]:
    """What bash offers for the last word."""
    line = 'source "$0"; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _shtab_clrt; echo "${COMPREPLY[@]}"'
    call = ["bash", "-c", line, str(script), *words]
    return subprocess.run(call, capture_output=True, text=True, check=True).stdout.split()


def test_no_text_of_the_manual_is_taken_for_a_macro(shell: ModuleType) -> None:
    """As that of `-o`, which begins with the names of formats, was, and dropped."""
    text = shell.made()["clrt.1"]
    macros = set(re.findall(r"^[.'](\w+)", text, flags=re.MULTILINE))
    assert macros <= {"TH", "SH", "SS", "TP", "PP", "B", "br", "nf", "fi"}
    assert ".exr .png" in text and ".mp4" in text


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash here; .ci/run itself needs one")
def test_bash_completes_commands_options_and_scenes(
    shell: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    script = tmp_path / "clrt.bash"
    script.write_text(shell.made()["clrt.bash"])
    assert set(completed(script, "clrt", "ex")) == {"exercise", "explain"}
    assert set(completed(script, "clrt", "render", "--lay")) == {"--layers"}
    (tmp_path / "showroom.toml").touch()
    assert set(completed(script, "clrt", "render", "show")) == {"showcase", "showroom.toml"}
    assert set(shell.scenes()) == set(shipped_scenes())


@pytest.mark.skipif(shutil.which("zsh") is None, reason="no zsh here; .ci/run installs it")
def test_zsh_reads_its_file(shell: ModuleType, tmp_path: Path) -> None:
    (tmp_path / "_clrt").write_text(shell.made()["_clrt"])
    subprocess.run(["zsh", "-n", str(tmp_path / "_clrt")], check=True)


def test_no_name_of_a_scene_can_be_a_command(shell: ModuleType) -> None:
    assert all(re.fullmatch(r"[\w.-]+", name) for name in shell.scenes())
