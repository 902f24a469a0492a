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


@pytest.mark.parametrize("root", _ROOTS.split("|"))
def test_what_such_a_folder_is(root: str) -> None:
    place = f"/{root}/some-one/a.py"
    for before, after in (('File "', '", line 1'), ("in ", " and"), ("(", ")"), ("=", "")):
        assert FOLDERS.findall(before + place + after) == [place]
    for before in ("https://some.org", "docs", "..", "~"):
        assert FOLDERS.findall(before + place) == []
    assert FOLDERS.findall(r"C:\Users\me") == ["C:\\Users\\"]
