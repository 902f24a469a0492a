"""matplotlib, without a screen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from clrt.base.atomic import replacing
from clrt.base.errors import ClrtError
from clrt.base.install import pip_install


def pyplot() -> Any:
    """matplotlib's drawing module, without a screen. ClrtError where it is not installed."""
    try:
        import matplotlib
    except ModuleNotFoundError:
        raise ClrtError(f"charts need matplotlib; install it with: {pip_install('matplotlib')}") from None
    matplotlib.use("Agg")
    matplotlib.rcParams |= {"svg.hashsalt": "clrt", "axes.spines.top": False, "axes.spines.right": False}
    import matplotlib.pyplot as plt

    return plt


def save(figure: Any, path: str | Path) -> Path:
    """Write a figure as what its name ends with (.png, .svg, .pdf); whole or not at all."""
    target = Path(path)
    try:
        with replacing(target) as temporary:
            figure.savefig(temporary, format=target.suffix.lstrip(".") or "png", dpi=120, bbox_inches="tight")
    except ValueError as error:  # an unknown format
        raise ClrtError(f"{path}: {error}") from None
    pyplot().close(figure)
    return target
