"""Render models as ten programs and extensions write them, for docs/models.md: docs/foreign-models.png.

    python -m docs.make_models

The models are made by tests/foreign_models.py.
"""

from __future__ import annotations

import tempfile
import warnings
from pathlib import Path

import clrt
from docs.make_contact_sheet import CELL, captioned, sheet, write
from tests.foreign_models import MODELS

COLUMNS = 5


def main() -> None:
    """Make, render and caption each of them."""
    cells = []
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", clrt.ClrtWarning)
        for name, make in MODELS.items():
            scene = clrt.load(make(Path(folder)))
            cells.append(captioned(clrt.render(scene, width=CELL[0], height=CELL[1], spp=4).pixels, name))
    write("foreign-models", sheet(cells, COLUMNS))


if __name__ == "__main__":
    main()
