"""One comparison of two pictures as a page that needs nothing else, for `clrt.Verdict.save_report`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from clrt.base.atomic import write_text
from clrt.version import __version__

from ..compare.oracle import compare
from ..types import OracleImage
from .pictures import DECADES, FLOOR, case_pictures, picture_bytes, png
from .report import environment, figure, script_data, templated

_REFERENCE = "reference"


def write_page(verdict: Any, path: Path) -> Path:
    """Write the page of a `clrt.Verdict`, whole or not at all; returns the absolute path."""
    write_text(path, page(verdict))
    return path.resolve()


def page(verdict: Any) -> str:
    """The page."""
    data, images = _pictures(verdict.picture, verdict.reference)
    limits = {gate.name: gate for gate in verdict.gates}
    rows = [
        (name, verdict.figures.get(name, limits[name].value if name in limits else 0.0), limits.get(name))
        for name in dict.fromkeys([*limits, *verdict.figures])
    ]
    return environment().get_template("comparison.html").render(
        verdict=verdict,
        rows=[(name, figure(value), gate) for name, value, gate in rows],
        images=images,
        data=data,
        version=__version__,
        script_data=script_data,
        scale={"floor": FLOOR, "decades": DECADES},
        css=templated("report.css"),
        scripts=[templated(name) for name in ("maps.js", "viewer.js")],
    )


def _pictures(picture: np.ndarray, reference: np.ndarray) -> tuple[dict[str, Any], list[tuple[str, str]]]:
    """What the viewer needs, {} where sizes differ; and both as PNGs for whoever has no script."""
    finite = [np.nan_to_num(image, nan=0.0, posinf=0.0, neginf=0.0) for image in (picture, reference)]
    images = list(zip(("picture", _REFERENCE), map(png, map(picture_bytes, finite)), strict=True))
    if picture.shape != reference.shape:
        return {}, images
    ours, other = (OracleImage(image, {}, None, None, "", 0.0) for image in finite)
    return case_pictures(ours, {_REFERENCE: (other, compare(ours, other))}), images
