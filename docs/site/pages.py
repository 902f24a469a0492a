"""Markdown of the repository as Sphinx takes it: comments become figures, files outside of docs/ names."""

from __future__ import annotations

import re
from pathlib import Path

from docs.site.notebooks import PAGES

DOCS = Path(__file__).resolve().parents[1]
ROOT = DOCS.parent
_OUTSIDE = re.compile(r"\[([^\]\[]+)\]\(((?:\.\./)+[\w./-]+)\)")
_MARK = re.compile(r"^<!-- (figure|table|code): (\w+) -->$", re.M)
_SAVED = re.compile(r"```python\n.*?```\n", re.S)
_PICTURE = re.compile(r'\.save\("(\w+)\.png"\)')


def prepared(name: str, text: str) -> str:
    """The text of the page `name` (without its suffix, below docs/)."""
    up = "../" * name.count("/")
    if name in PAGES:
        stem = name.split("/")[-1]
        text = _SAVED.sub(lambda match: _with_pictures(match[0], f"{up}generated/{stem}"), text)
        file = f"{up}generated/notebooks/{stem}.ipynb"
        text += f"\n---\n\n[This page as a notebook]({file}), with its pictures.\n"
    text = _OUTSIDE.sub(lambda match: _named(name, match[1], match[2]), text)
    text = _MARK.sub(lambda match: _made(match[1], match[2], up), text)
    return text.replace("<!-- others -->", "\n".join(others())) if name == "index" else text


def others() -> list[str]:
    """Pages that the index does not list by name: who adds one need not touch the index."""
    listed = (DOCS / "index.md").read_text("utf-8")
    stems = [page.stem for page in sorted(DOCS.glob("*.md")) if page.stem != "index"]
    return [stem for stem in stems if not re.search(rf"^(.*<{stem}>|{stem})$", listed, re.M)]


def _named(name: str, label: str, target: str) -> str:
    """A link that leads out of docs/, as the label and the file's name: the site does not hold the source."""
    path = (DOCS / name).parent.joinpath(target).resolve()
    if path.is_relative_to(DOCS):
        return f"[{label}]({target})"
    if not path.exists():
        raise SystemExit(f"docs/{name}.md: {target} is not there")
    place = f"`{path.relative_to(ROOT)}`"
    plain = label.strip("`")
    return place if plain.endswith(Path(target).name) or plain in place else f"{label} ({place})"


def _made(kind: str, what: str, up: str) -> str:
    if kind == "figure":
        (file,) = (DOCS / "generated" / "figures").glob(f"{what}.*")
        return f"![{what}]({up}generated/figures/{file.name})"
    return (DOCS / "generated" / f"{what}.txt").read_text("utf-8")


def _with_pictures(block: str, folder: str) -> str:
    """A block of code, and below it the pictures that it saves."""
    pictures = [f"![{name}]({folder}/{name}.png)" for name in _PICTURE.findall(block)]
    return block + ("\n" + "\n".join(pictures) + "\n" if pictures else "")
