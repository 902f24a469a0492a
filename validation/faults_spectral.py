"""Deliberate faults in media and absorption."""

from __future__ import annotations

from typing import Final

from .faults import Mutant

_MEDIA: Final = (
    Mutant("absorption that adds light", "kernels/boundaries.cl", "exponential(-absorption * hit_t[i])",
           "exponential(absorption * hit_t[i])", ("absorption",)),
    Mutant("absorption 1 % low", "kernels/boundaries.cl", "exponential(-absorption * hit_t[i])",
           "exponential(-0.99f * absorption * hit_t[i])", ("absorption",)),
    Mutant("absorption of the medium entered first", "kernels/boundaries.cl",
           "const int within = top_of(world, list);", "const int within = list.medium[0];",
           ("ice in water in a glass",)),
    Mutant("all boundaries seen", "kernels/boundaries.cl", "if (before != after) break;", "break;",
           ("hidden media",)),
    Mutant("media not left in hidden boundaries", "kernels/boundaries.cl", "        list = next;\n", "",
           ("water in a glass", "absorption by pieces", "hidden media")),
)  # fmt: skip

SPECTRAL_FAULTS: Final = _MEDIA
