"""Gates of the caller's own: limits by the names of figures."""

from __future__ import annotations

from collections.abc import Mapping

from clrt.base.errors import ClrtError, show
from clrt.base.suggest import did_you_mean

from ..types import Gate
from .metrics import without_flip
from .oracle import gate

_HIGH = ("SSIM", "PSNR", "PSNR above white", "worst window")  # figures that are to be high
_LOW = ("FLIP", "largest difference", "mean difference", "largest, of 255", "mean, of 255",
        "pixels that differ", "widest place", "thin place")  # fmt: skip


def check_wanted(wanted: Mapping[str, float] | None) -> None:
    """ClrtError where gates ask for nothing, or for what is no figure, or cannot be measured here."""
    if wanted is None:
        return
    figures = (*_HIGH, *_LOW)
    for name in wanted:
        if name not in figures:
            raise ClrtError(f"gates: {show(name)} is no figure{did_you_mean(name, figures)} "
                            f"(figures: {', '.join(figures)})")  # fmt: skip
    if not wanted:
        raise ClrtError("gates: {} asks for nothing; name a figure and its limit, such as {'SSIM': 0.99}")
    if "FLIP" in wanted and without_flip():
        raise ClrtError(f"gates: 'FLIP' cannot be measured here: {without_flip()}")


def asked(wanted: Mapping[str, float], metrics: dict[str, float]) -> tuple[Gate, ...]:
    """The gates on the figures that were measured; nothing is above white where that was not."""
    return tuple(
        gate(name, metrics.get(name, float("inf")), limit, "high" if name in _HIGH else "low", "as asked")
        for name, limit in wanted.items()
    )
