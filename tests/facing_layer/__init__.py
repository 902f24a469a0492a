"""What it takes to add a layer (`docs/adding-a-layer.md`): the cosine of incidence, in a copy of the tree."""

from __future__ import annotations

from typing import Final

# file -> text that stands there once -> the same with the layer
ENTRIES: Final[dict[str, dict[str, str]]] = {
    "clrt/base/layers.py": {
        '    "bands": Layer(': '''\
    "facing": Layer(_HIT, "cosine between the ray and the normal, 0 on a miss", 1, "float", ("V",)),
    "bands": Layer(''',
    },
    "kernels/film.cl": {
        "    put3(out_position": """\
    out_facing[i] = fabs(dot3(at.outward, ray.direction));
    put3(out_position""",
    },
}
