"""Published spectra and indices as small text files (sources in their first lines), and how to read them."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parent


@cache
def columns(file: str) -> dict[str, np.ndarray]:
    """The columns of `file`.csv by their names, float64, read-only; `nm`, the wavelengths, ascends."""
    head, *lines = _lines(file)
    values = np.array([[float(word) for word in line] for line in lines]).T
    values.flags.writeable = False
    return dict(zip(head, values, strict=True))


@cache
def rows(file: str) -> dict[str, dict[str, float]]:
    """The rows of `file`.csv by their first words; each gives numbers by the columns' names."""
    head, *lines = _lines(file)
    return {name: dict(zip(head[1:], map(float, words), strict=True)) for name, *words in lines}


def _lines(file: str) -> list[list[str]]:
    text = (FOLDER / f"{file}.csv").read_text("utf-8")
    return [line.split(",") for line in text.splitlines() if not line.startswith("#")]
