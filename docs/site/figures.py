"""Figures of the concepts, made by the code that they are about. Needs a device."""

from __future__ import annotations

import inspect
import logging
import shutil
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np

import clrt
from clrt.engine import wavefront
from clrt.exercises.table import scenes
from clrt.spectra.bands import Bands, light
from clrt.spectra.colorimetry import matching, xyz_matrix
from clrt.spectra.curves import ior_at

_GLASSES = ("BK7", "SF11", "water-dispersive", "diamond-dispersive")
_XYZ = ("#c8553d", "#4a9150", "#3d78c8")
_BITS = {
    "as it comes": clrt.Settings(), "tiles of 256 rays": clrt.Settings(tile=256),
    "one work-item a group": clrt.Settings(local_size=1),
    "tiles of 100, groups of 4": clrt.Settings(tile=100, local_size=4),
}  # fmt: skip


def write(folder: Path) -> None:
    """Write figures/, tutorial/, and the texts that pages ask for."""
    figures = folder / "figures"
    figures.mkdir(parents=True, exist_ok=True)
    matplotlib.use("agg")
    logging.getLogger("clrt").setLevel(logging.WARNING)  # Sphinx prints what is logged
    _generations(figures / "generations.svg")
    _glasses(figures / "glasses.svg")
    _observer(figures / "observer.svg")
    (figures / "scan.svg").write_text(_scan(), "utf-8")
    clrt.render(clrt.load(scenes()["wine"])).save(figures / "media.png")
    shutil.copy(folder / "gallery" / "rainbow.png", figures / "rainbow.png")
    (folder / "wavefront.txt").write_text(f"```python\n{inspect.getsource(wavefront.trace)}```\n", "utf-8")
    (folder / "bits.txt").write_text(_bits(), "utf-8")


def _axes(title: str, across: str, up: str) -> Any:
    from matplotlib import pyplot

    pyplot.rcParams["svg.hashsalt"] = "clrt"
    _, axes = pyplot.subplots(figsize=(7, 3), layout="constrained")
    axes.set(title=title, xlabel=across, ylabel=up)
    axes.spines[["top", "right"]].set_visible(False)
    return axes


def _save(axes: Any, file: Path) -> None:
    axes.figure.savefig(file, metadata={"Date": None})
    axes.figure.clear()


def _generations(file: Path) -> None:
    rows = clrt.render(clrt.load("showcase"), width=160, spp=1).stats["generations"]
    axes = _axes("rays of the showcase, 160 x 90 pixels", "generation", "rays")
    number, base = range(len(rows)), np.zeros(len(rows))
    for kind, colour in (("camera", "#888888"), ("reflection", "#c8553d"), ("transmission", "#3d78c8")):
        count = np.array([row.get(kind, 0) for row in rows], float)
        axes.bar(number, count, bottom=base, label=kind, color=colour)
        base += count
    axes.legend(frameon=False)
    _save(axes, file)


def _glasses(file: Path) -> None:
    nm = np.linspace(380, 780, 201)
    axes = _axes("indices of refraction, relative to 587.56 nm", "wavelength in nm", "n / n(d)")
    for glass in _GLASSES:
        curve = ior_at(glass, nm)
        axes.plot(nm, curve / ior_at(glass, np.array([587.56])), label=glass)
    axes.legend(frameon=False)
    _save(axes, file)


def _observer(file: Path) -> None:
    """A lamp's bands, and each times the three matching functions: what these enclose are X, Y and Z."""
    bands = Bands(24)
    lamp = light("F11", bands)
    axes = _axes("F11 in 24 bands, and what the observer sees of it", "wavelength in nm", "a band's value")
    axes.stairs(lamp, bands.edges, fill=True, color="#cccccc", label="the lamp, L")
    seen = lamp * matching(bands.midpoints)
    for name, row, total, colour in zip("XYZ", seen, xyz_matrix(bands) @ lamp, _XYZ, strict=True):
        label = f"L {name.lower()}: {name} = {total:.2f}"
        axes.stairs(row, bands.edges, color=colour, linewidth=2, label=label)
    axes.set_ylim(bottom=0)
    axes.legend(frameon=False)
    _save(axes, file)


def _scan() -> str:
    """Hits that spawn, the sums before them, and where their rays go."""
    spawns = np.array([1, 0, 0, 1, 1, 0, 1, 0])
    places = np.cumsum(spawns) - spawns
    out = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 520 190" font-family="sans-serif" '
           'font-size="13" text-anchor="middle"><rect width="520" height="190" fill="white"/>']  # fmt: skip
    for i, (one, place) in enumerate(zip(spawns.tolist(), places.tolist(), strict=True)):
        x = 100 + 50 * i
        colour = "#c8553d" if one else "#dddddd"
        out.append(f'<rect x="{x - 18}" y="20" width="36" height="28" rx="4" fill="{colour}"/>')
        out.append(f'<text x="{x}" y="39">{one}</text><text x="{x}" y="84">{place}</text>')
        if one:
            to = 100 + 50 * place
            out.append(f'<path d="M{x} 92 L{to} 132" stroke="#c8553d" fill="none" stroke-width="2"/>')
            out.append(f'<rect x="{to - 18}" y="134" width="36" height="28" rx="4" fill="#3d78c8"/>')
            out.append(f'<text x="{to}" y="153" fill="white">{i}</text>')
    for y, text in ((39, "spawns"), (84, "sum before"), (153, "children of")):
        out.append(f'<text x="40" y="{y}">{text}</text>')
    return "\n".join([*out, "</svg>\n"])


def _bits() -> str:
    scene, rows = clrt.load("refraction"), ["| how | hash |", "|---|---|"]
    pictures = {how: clrt.render(scene, width=64, spp=1, settings=used) for how, used in _BITS.items()}
    hashes = {how: picture.hash for how, picture in pictures.items()}
    if len(set(hashes.values())) != 1:
        raise SystemExit(f"the same bits? {hashes}")
    return "\n".join([*rows, *(f"| {how} | `{found[:32]}...` |" for how, found in hashes.items())]) + "\n"
