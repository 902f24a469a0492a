"""Pages with code as notebooks, with the pictures that the code makes.

    python -m docs.site.notebooks      writes docs/site/hashes.json anew, after pictures were meant to change
"""

from __future__ import annotations

import base64
import contextlib
import io
import json
import os
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final
from unittest import mock

import clrt

DOCS: Final = Path(__file__).resolve().parents[1]
HASHES: Final = Path(__file__).with_name("hashes.json")
PAGES: Final = (
    "tutorial", "concepts/wavefront", "concepts/queues", "concepts/same-bits", "concepts/media",
    "concepts/dispersion", "colour",
)
_BLOCK = re.compile(r"```python\n(.*?)```\n", re.S)
_SAVED = re.compile(r'\.save\("(\w+\.png)"\)')
_MADE = re.compile(r"<!-- (figure|table|code): \w+ -->\n\n?")
_LINK = re.compile(r"\[([^\]]+)\]\((?!http)[^)]*\)")  # to a page that is not beside the notebook


def write(folder: Path) -> None:
    """Run the code of PAGES; write each as a notebook, and leave the tutorial's pictures in tutorial/."""
    notebooks = folder / "notebooks"
    notebooks.mkdir(parents=True, exist_ok=True)
    for page in PAGES:
        name = page.split("/")[-1]
        place = folder / name
        place.mkdir(exist_ok=True)
        text = json.dumps(notebook(page, place), indent=1) + "\n"
        (notebooks / f"{name}.ipynb").write_text(text, "utf-8")


def notebook(page: str, folder: Path) -> dict[str, Any]:
    """A page as a notebook, executed: files that its code writes are written to the folder."""
    parts = _BLOCK.split(_MADE.sub("", (DOCS / f"{page}.md").read_text("utf-8")))
    cells: list[dict[str, Any]] = []
    space: dict[str, Any] = {}
    for number, text in enumerate(parts):
        if number % 2:
            cells.append(_code(text, _run(text, space, folder), folder, len(cells)))
        elif text.strip():
            source = _LINK.sub(r"\1", text.strip()).splitlines(keepends=True)
            own = f"cell-{len(cells)}"
            cells.append({"cell_type": "markdown", "id": own, "metadata": {}, "source": source})
    about = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    return {"cells": cells, "metadata": about, "nbformat": 4, "nbformat_minor": 5}


def hashes() -> dict[str, str]:
    """The hash of each picture that the pages' code saves, by page and file name."""
    found: dict[str, str] = {}
    save = clrt.Image.save
    for page in PAGES:
        def noted(image: clrt.Image, path: Any, *more: Any, page: str = page) -> Path:
            found[f"{page}: {path}"] = image.hash
            return save(image, path, *more)

        with tempfile.TemporaryDirectory() as folder, mock.patch.object(clrt.Image, "save", noted):
            notebook(page, Path(folder))
    return found


def _run(code: str, space: dict[str, Any], folder: Path) -> str:
    """What the code prints, run in a folder."""
    said = io.StringIO()
    with _within(folder), contextlib.redirect_stdout(said):
        exec(code, space)
    return said.getvalue()


def _code(text: str, said: str, folder: Path, number: int) -> dict[str, Any]:
    """A cell, and what it printed and drew."""
    outputs: list[dict[str, Any]] = []
    if said:
        outputs.append({"name": "stdout", "output_type": "stream", "text": said.splitlines(keepends=True)})
    for file in _SAVED.findall(text):
        data = base64.b64encode((folder / file).read_bytes()).decode()
        outputs.append({"data": {"image/png": data}, "metadata": {}, "output_type": "display_data"})
    return {"cell_type": "code", "execution_count": None, "id": f"cell-{number}", "metadata": {},
            "outputs": outputs, "source": text.rstrip().splitlines(keepends=True)}  # fmt: skip


@contextlib.contextmanager
def _within(folder: Path) -> Iterator[None]:
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


if __name__ == "__main__":
    HASHES.write_text(json.dumps(hashes(), indent=1) + "\n", "utf-8")
