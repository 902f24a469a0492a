"""The files around the code say what the code says: version, dependencies, identity of the schema."""

from __future__ import annotations

import json
import re
import subprocess
import tomllib
from pathlib import Path

from clrt.scene.schema import SCHEMA_FILE, SCHEMA_ID, schema
from clrt.version import __version__

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
CONDA_NAMES = {"OpenImageIO": "py-openimageio"}


def test_the_citation_is_of_this_version() -> None:
    text = (ROOT / "CITATION.cff").read_text("utf-8")
    assert f'version: "{__version__}"' in text and "cff-version: 1.2.0" in text
    assert f"license: {PROJECT['license']}" in text and PROJECT["authors"][0]["name"] in text


def test_the_recipe_needs_what_the_wheel_needs() -> None:
    text = (ROOT / "installers" / "conda" / "recipe.yaml").read_text("utf-8")
    assert f'version: "{__version__}"' in text and PROJECT["description"].split(":")[0] in text
    run = text.split("  run:\n")[1].split("\ntests:")[0]
    listed = dict(re.findall(r"- ([\w-]+) >=([\d.]+)", run))
    assert listed.pop("python") == PROJECT["requires-python"].removeprefix(">=")
    form = r"([\w-]+)>=([\d.]+)(?:; .+)?"
    needed = dict(re.fullmatch(form, line).groups() for line in PROJECT["dependencies"])  # type: ignore[union-attr]
    assert listed == {CONDA_NAMES.get(name, name): version for name, version in needed.items()}
    for command in re.findall(r"- (clrt .+)", text.split("\ntests:")[1]):
        from clrt.cli.options import parser

        words = command.split()[1:]
        if words != ["--version"]:
            assert parser().parse_args(words).command


def test_the_schema_is_known_by_one_name() -> None:
    held = json.loads(SCHEMA_FILE.read_text("utf-8"))
    assert held["$id"] == schema()["$id"] == SCHEMA_ID
    assert re.fullmatch(r"urn:uuid:[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}", SCHEMA_ID)


def test_pages_lead_to_files_that_are_there() -> None:
    docs = ("docs/versions.md", "docs/explain.md", "docs/viewer.md")
    for page in ("CHANGELOG.md", "CONTRIBUTING.md", "README.md", *docs):
        file = ROOT / page
        for target in re.findall(r"\]\(([\w./-]+)\)", file.read_text("utf-8")):
            assert (file.parent / target).exists(), (page, target)


def test_changes_name_what_there_is() -> None:
    from clrt.cli.options import parser

    text = (ROOT / "CHANGELOG.md").read_text("utf-8")
    named = set(re.findall(r"`clrt (\w[\w-]*)", text))
    assert named and named <= set(parser().commands)


def test_tests_under_oclgrind_are_where_ci_looks_for_them() -> None:
    """`.ci/run` collects one folder there: collecting all takes every process its time."""
    mark = "mark" + ".oclgrind"
    tests = Path(__file__).parent
    marked = [file for file in tests.rglob("*.py") if mark in file.read_text("utf-8")]
    assert {file.parent for file in marked} == {tests / "device"}
    assert "-m oclgrind tests/device\n" in (tests.parent / ".ci/run").read_text("utf-8")


def listed(line: str) -> set[str]:
    """The test files that a list of `.ci/run` names, its braces and folders opened."""
    opened = subprocess.check_output(["bash", "-c", f"printf '%s\\n' {line}"], cwd=ROOT, text=True)
    paths = [ROOT / name for name in opened.split()]
    assert all(path.exists() for path in paths), paths
    files = {file for path in paths for file in (path.rglob("test_*.py") if path.is_dir() else [path])}
    return {str(file.relative_to(ROOT)) for file in files}


def test_ci_runs_what_needs_debian_s_pocl() -> None:
    """`make test` leaves those tests out."""
    mark, text = "mark" + ".debian_pocl", (ROOT / ".ci/run").read_text("utf-8")
    marked = {str(file.relative_to(ROOT)) for file in (ROOT / "tests").rglob("*.py")
              if mark in file.read_text("utf-8")}  # fmt: skip
    (both,) = map(listed, re.findall(r"^both=\((.*)\)$", text, re.M))
    assert "tests/exercises/test_exercises.py" in marked and marked == both
    assert '-m debian_pocl "${both[@]}"\n' in text
