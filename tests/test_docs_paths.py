"""Pages and figures name no folder of the machine that they were made on."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[1] / "docs"
_ROOTS = "tmp|work|home|root|usr|var|opt|mnt|srv|Users|private"
FOLDERS = re.compile(rf"(?<![\w.~<)}}\]/:-])(?:/(?:{_ROOTS})/[\w.~/-]*"
                     r"|[A-Z]:\\{1,2}[Uu]sers\\)")  # fmt: skip
# documented examples, as they stand there
EXAMPLES: dict[str, tuple[str, ...]] = {}
FILES = sorted(file for end in ("md", "json", "svg", "ipynb") for file in DOCS.rglob(f"*.{end}"))


def test_no_page_and_no_figure_has_a_folder_of_some_machine() -> None:
    found = {}
    for file in FILES:
        name = file.relative_to(DOCS).as_posix()
        paths = set(FOLDERS.findall(file.read_text("utf-8"))) - set(EXAMPLES.get(name, ()))
        if paths:
            found[name] = sorted(paths)[:5]
    assert len(FILES) > 20 and found == {}


@pytest.mark.parametrize(("text", "path"), [
    ('File "/tmp/clrt-mutant-agj/validation/a.py", line 1', "/tmp/clrt-mutant-agj/validation/a.py"),
    ("in /work/main/.venv/lib", "/work/main/.venv/lib"), ("(/home/me/scene.toml)", "/home/me/scene.toml"),
    ("=/usr/lib/x.so", "/usr/lib/x.so"), (r"C:\Users\me", "C:\\Users\\"),
    ("https://some.org/usr/x", None), ("docs/tmp/x", None), ("../usr/x", None), ("~/work/x", None),
])  # fmt: skip
def test_what_such_a_folder_is(text: str, path: str | None) -> None:
    assert FOLDERS.findall(text) == ([path] if path else [])
