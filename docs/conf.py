"""Sphinx' settings: `make docs` builds the site from these pages, offline. See docs/site/."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from clrt.version import __version__  # noqa: E402
from docs.site import figures, gallery, notebooks, pages, reference  # noqa: E402

project, author, copyright = "clrt", "the clrt authors", "the clrt authors"
version = release = __version__
extensions = ["myst_parser", "sphinx.ext.autodoc"]
myst_heading_anchors = 3
exclude_patterns = ["site", "__pycache__"]
highlight_language = "none"
default_role = "code"
suppress_warnings = ["misc.highlighting_failure"]  # Pygments does not know all of TOML 1.1
autodoc_typehints = "description"
autodoc_member_order = "bysource"
html_theme = "furo"
html_title = f"clrt {__version__}"
html_static_path = ["site/static"]
html_css_files = ["clrt.css"]
html_copy_source = False
html_show_sphinx = False


def _made(app: Any) -> None:
    """Write the pages and figures that are made, before Sphinx looks for pages."""
    folder = HERE / "generated"
    for part in (gallery, reference, figures, notebooks):
        part.write(folder)


def _prepared(app: Any, name: str, text: list[str]) -> None:
    text[0] = pages.prepared(name, text[0])


def _plain_types(app: Any, *_: Any) -> None:
    """After autodoc has noted the types of a signature."""
    for noted in app.env.current_document.autodoc_annotations.values():
        for name, text in noted.items():
            noted[name] = reference.plain_type(text)


def _skipped(app: Any, what: str, name: str, value: Any, skip: bool, options: Any) -> bool | None:
    """What api.md does not name is not public."""
    return None if name in reference.public_words() else True


def setup(app: Any) -> None:
    app.connect("builder-inited", _made)
    app.connect("source-read", _prepared)
    app.connect("autodoc-skip-member", _skipped)
    app.connect("autodoc-process-signature", _plain_types, priority=900)
