"""The gallery: each scene that ships, cut from the contact sheet, with what to look at and its file."""

from __future__ import annotations

import re
from pathlib import Path

import OpenImageIO as oiio

from clrt.base.resources import shipped_scenes
from docs.make_contact_sheet import CAPTION, CELL, GAP

DOCS = Path(__file__).resolve().parents[1]
_COLUMNS = 5
_LONGEST = 260  # lines of a scene that are shown; meshes follow
_LENGTH = 150  # characters of a line


def names() -> list[str]:
    """The scenes, in the order of scenes.md, which is that of the contact sheet."""
    text = (DOCS / "scenes.md").read_text("utf-8")
    return sorted(shipped_scenes(), key=lambda name: text.index(f"`{name}`"))


def write(folder: Path) -> None:
    """Write gallery.md and its pictures."""
    pictures = folder / "gallery"
    pictures.mkdir(parents=True, exist_ok=True)
    sheet = oiio.ImageBuf(str(DOCS / "contact-sheet.png"))
    lines = ["# Gallery", "", "Every scene that ships. `clrt render NAME -o NAME.png` renders one at its own",
             "size; a scene is a text file, or a script that makes one, and stands below its picture.",
             ""]  # fmt: skip
    for number, (name, file) in enumerate((name, shipped_scenes()[name]) for name in names()):
        _cut(sheet, number, pictures / f"{name}.png")
        lines += _entry(name, file)
    (folder / "gallery.md").write_text("\n".join(lines) + "\n", "utf-8")


def _cut(sheet: oiio.ImageBuf, number: int, file: Path) -> None:
    x, y = GAP + number % _COLUMNS * (CELL[0] + GAP), GAP + number // _COLUMNS * (CELL[1] + CAPTION + GAP)
    tile = oiio.ImageBufAlgo.cut(sheet, oiio.ROI(x, x + CELL[0], y, y + CELL[1]))
    if not tile.write(str(file)):
        raise SystemExit(f"{file}: {tile.geterror()}")


def _entry(name: str, file: Path) -> list[str]:
    text = file.read_text("utf-8").split("# Below: what generate_meshes.py writes.")[0]
    comment = " ".join(line.lstrip("# ").rstrip() for line in _head(text, file.suffix))
    shown = [line[:_LENGTH] for line in text.splitlines()[:_LONGEST]]
    more = len(file.read_text("utf-8").splitlines()) - len(shown)
    return [
        f"## {name}", "", f"![{name}](gallery/{name}.png)", "", comment.replace("`", ""), "",
        f"    clrt render {name} -o {name}.png", "",
        "<details>", f"<summary>{file.name}</summary>", "",
        "```toml" if file.suffix == ".toml" else "```python", *shown,
        *([f"# ... and {more} lines more"] if more else []), "```", "", "</details>", "",
    ]  # fmt: skip


def _head(text: str, suffix: str) -> list[str]:
    """The comment or docstring that a file begins with."""
    if suffix == ".py":
        found = re.match(r'"""(.*?)"""', text, re.S)
        return found[1].splitlines() if found else []
    lines = text.splitlines()
    return lines[: next((i for i, line in enumerate(lines) if not line.startswith("#")), 0)]
