"""matplotlib, without a screen, and without what others tell it: charts are the same for everybody.

When it is imported, matplotlib obeys a file `matplotlibrc` in the current folder before all others, where
anybody may have put one: it may name programs to run, or be a pipe that never answers. So it is imported in
its own folder, whose file has the usual values.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from clrt.base.atomic import replacing
from clrt.base.elsewhere import within, without
from clrt.base.errors import ClrtError
from clrt.base.install import pip_install
from clrt.base.room import check_date

_STYLE: Final = {"svg.hashsalt": "clrt", "axes.spines.top": False, "axes.spines.right": False}


@contextmanager
def drawing() -> Iterator[None]:
    """matplotlib as it is made, and our style, for figures that are drawn or saved within.

    Also a decorator. ClrtError where matplotlib is not installed.
    """
    matplotlib = _imported()
    with matplotlib.rc_context():
        # as `rcdefaults`, which looks for styles in the user's folder; the backend is for windows only
        usual = {name: value for name, value in dict.items(matplotlib.rcParamsDefault) if name != "backend"}
        dict.update(matplotlib.rcParams, usual | _STYLE)
        yield


def subplots(rows: int = 1, columns: int = 1, *, figsize: tuple[float, float]) -> Any:
    """A figure of that many inches and its axes, within `drawing`."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=figsize)
    return figure, figure.subplots(rows, columns)


@drawing()
def known_formats() -> set[str]:
    """The endings, without a dot, of names under which `save` writes a figure."""
    from matplotlib.backend_bases import FigureCanvasBase

    return set(FigureCanvasBase.get_supported_filetypes())


@drawing()
def save(figure: Any, path: str | Path) -> Path:
    """Write a figure as what its name ends with (.png, .svg, .pdf); whole or not at all."""
    target = Path(path)
    check_date()
    try:
        with replacing(target) as temporary:
            figure.savefig(temporary, format=target.suffix.lstrip(".") or "png", dpi=120, bbox_inches="tight")
    except ValueError as error:  # an unknown format
        raise ClrtError(f"{path}: {error}") from None
    return target


def _imported() -> Any:
    """The package matplotlib. What a program has imported before stays as it is."""
    if "matplotlib" not in sys.modules:
        found = importlib.util.find_spec("matplotlib")
        if found is None or found.origin is None:
            raise ClrtError(f"charts need matplotlib; install it with: {pip_install('matplotlib')}")
        with within(Path(found.origin).with_name("mpl-data")), without("MPLBACKEND"):
            importlib.import_module("matplotlib")
    return importlib.import_module("matplotlib")
