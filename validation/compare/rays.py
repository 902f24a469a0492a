"""Our picture against an oracle's by generation and kind of ray: what cancels in the whole does not here."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..types import OracleImage
from .metrics import largest, relative, share

FINE = 1e-4  # difference of linear radiance, relative above 1
_KINDS = ("camera", "reflection", "transmission", "ambient")


@dataclass(frozen=True)
class RayRow:
    """What rays of one generation and kind brought to a picture, ours against the reference's."""

    key: str  # "generation 2 transmission"
    mean: float  # of the reference's radiance, over the picture
    mean_difference: float  # ours - reference, outside the mask
    largest: float  # |difference| outside the mask
    within: float  # share of pixels within FINE outside the mask
    off: float  # share of the pixels they light, outside the mask, that are off by more than 1e-3 of it

    @property
    def label(self) -> str:
        """As people read it: "generation 2, transmission"."""
        return key_label(self.key)

    @property
    def generation(self) -> int:
        return int(self.key.split()[1])

    @property
    def is_term(self) -> bool:
        """Whether the row is a part of another one: "generation 0 camera diffuse"."""
        return len(self.key.split()) == 4


def key_label(key: str) -> str:
    """A key as people read it: "generation 0, camera, diffuse"."""
    word, number, *rest = key.split()
    return ", ".join([f"{word} {number}", *rest])


def ray_rows(ours: OracleImage, reference: OracleImage, mask: np.ndarray) -> list[RayRow]:
    """A row for each generation and kind of ray; [] where one picture does not tell them apart.

    A kind that only one of them has is compared with black. Terms ("generation 0 camera diffuse") are
    compared where both have them; a reference that tells only generations apart is compared with our sums.
    """
    if not ours.by_ray or not reference.by_ray:
        return []
    black = np.zeros(reference.pixels.shape)
    mine = _by_generation(ours.by_ray) if all(len(k.split()) == 2 for k in reference.by_ray) else ours.by_ray
    keys = {
        key
        for key in {*mine, *reference.by_ray}
        if len(key.split()) < 4 or (key in mine and key in reference.by_ray)
    }
    rows: list[RayRow] = []
    for key in sorted(keys, key=_order):
        theirs = reference.by_ray.get(key, black)
        difference = np.nan_to_num(mine.get(key, black).astype(np.float64) - theirs, nan=math.inf)[~mask]
        off, light = largest(difference), largest(theirs[~mask])
        wrong = off > 1e-3 * light + 1e-7
        mean = float(difference.mean()) if off.size else 0.0
        rows.append(
            RayRow(
                key,
                float(np.mean(theirs)),
                mean,
                float(off.max(initial=0.0)),
                1 - share(largest(relative(difference, theirs[~mask])) > FINE),
                share(wrong[wrong | (light > 0)]),
            )
        )
    return rows


def _by_generation(by_ray: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    sums: dict[str, np.ndarray] = {}
    for key, values in by_ray.items():
        word, number, *rest = key.split()
        if len(rest) < 2:
            name = f"{word} {number}"
            sums[name] = sums[name] + values if name in sums else values
    return sums


def _order(key: str) -> tuple[int, int, str]:
    _, number, *rest = key.split()
    kind = rest[0] if rest else ""
    return int(number), _KINDS.index(kind) if kind in _KINDS else len(_KINDS), " ".join(rest)
