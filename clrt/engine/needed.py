"""Which kernels a picture will launch, as far as its scene tells: so that some can be compiled ahead."""

from __future__ import annotations

from clrt.flatten.flatten import FlatScene


def needed(flat: FlatScene) -> dict[str, bool]:
    """The kernels of the passes (`clrt.engine.passes`), as they come, and whether work-items take packets.

    Those that build the tree are not there: they are first, quickly compiled, and loop where they are given
    nothing. Nor are those of few pictures (layers, filters, lists of ambient rays).
    """
    lit = bool(flat.scene["lights"][0])
    reflects, transmits = (bool((flat.materials[name] > 0).any()) for name in ("kr", "kt"))
    asked = {
        "generate": (True, True),
        "closest": (True, True),
        "surface": (True, True),
        "cross_boundaries": (flat.media is not None, True),
        "shade": (True, True),
        "count": (True, False),
        "feelers": (lit, True),
        "occluded_tinted" if flat.scene["tinted"][0] else "occluded": (lit, True),
        "illuminate": (lit, True),
        "gather": (True, True),
        "scan": (reflects or transmits, False),
        "reflect": (reflects, True),
        "transmit": (transmits, True),
        "rank": (reflects and transmits, False),
    }
    return {name: packets for name, (is_needed, packets) in asked.items() if is_needed}
