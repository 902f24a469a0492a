"""`clrt plot-spectrum`: a spectrum with its colours, as the thesis' figures 3.1 to 3.5 draw them."""

from __future__ import annotations

import argparse
import re
import tomllib
from pathlib import Path

from clrt.base import toml_scan
from clrt.base.arguments import whole
from clrt.base.atomic import check_replaceable
from clrt.base.errors import ClrtError
from clrt.base.limits import Limits
from clrt.base.places import At, listed
from clrt.base.records import read
from clrt.base.suggest import did_you_mean
from clrt.spectra.indices import GLASSES
from clrt.spectra.spectrum import LAMPS, METALS, REFLECTANCES, Spectrum

GROUPS = ("matching", "rgb", "metals", "glasses")
"""Several curves in one plot: the observer's functions, the upsampling curves, all metals, all glasses."""


def run(options: argparse.Namespace) -> int:
    """Draw `options.spectrum`. ClrtError for an unknown name, or where the file cannot be written."""
    name: str = options.spectrum
    value = name if name in (*GROUPS, *LAMPS, *REFLECTANCES, *GLASSES) else _stated(name)
    stem = re.sub(r"[^\w.-]+", "_", name).strip("_") or "spectrum"
    if options.bands is not None:
        options.bands = whole("--bands", options.bands, 1, Limits().bands)
    if options.output == "-":
        raise ClrtError("-o -: a plot goes to a file; give its name")
    path = Path(options.output or f"{stem}.png")
    check_replaceable(options.output or path)
    from clrt.images.plotting import save  # with matplotlib: only where something is drawn
    from clrt.spectra.plot import draw

    print(save(draw(value, options.bands), path))
    return 0


def _stated(text: str) -> str | Spectrum:
    """The spectrum that a text in a scene file's form states."""
    at = At("NAME")
    if not text.lstrip().startswith(("{", "[")):
        known = [*GROUPS, *LAMPS, *METALS, "patch-1 to patch-24", *GLASSES]
        names = [*GROUPS, *LAMPS, *REFLECTANCES, *GLASSES]
        raise at.error(text, f"it is one of {listed(known)}{did_you_mean(text, names)}")
    stated = f"value = {text}"
    try:
        toml_scan.check(stated, Limits(), at.source)
        tables = tomllib.loads(stated)
    except RecursionError:
        raise at.error(text, "it is nested too deeply") from None
    except ValueError as error:  # not TOML, or an int of too many digits
        raise ClrtError(f"NAME: {text}: {error}") from None
    if len(tables) > 1:
        raise at.error(text, "one spectrum is drawn, and nothing stands behind it")
    table = tables["value"]
    if isinstance(table, list):
        table = {"samples": table}
    spectrum = read(Spectrum, {"type": "spectrum", **table}, at)
    if spectrum.name is not None and spectrum.name not in (*LAMPS, *REFLECTANCES):
        return _stated(spectrum.name)
    return spectrum
