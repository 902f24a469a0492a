"""How scenes show themselves in notebooks: as a page without scripts, and live where what stands above can.

`clrt` itself puts the live view in place: the rooms below know nothing of it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Bundle = dict[str, Any]  # by MIME type, as IPython's `_repr_mimebundle_` gives it

live: Callable[[Any], Bundle] = lambda shown: {}  # noqa: E731


def bundle(shown: Any, html: str) -> Bundle:
    """What a notebook is given: the page, and beside it what shows it live; the notebook chooses."""
    return {"text/html": html, **live(shown)}
