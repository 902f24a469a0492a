"""What it takes to add a term (`docs/adding-a-term.md`): fuzz, which shines at grazing angles, in a copy."""

from __future__ import annotations

from typing import Final

# file -> text that stands there once -> the same with the term
ENTRIES: Final[dict[str, dict[str, str]]] = {
    "clrt/base/layers.py": {'"diffuse", "highlight")': '"diffuse", "highlight", "fuzz")'},
    "clrt/layout/__init__.py": {'"kd": "diffuse",': '"kd": "diffuse", "fuzz": "fuzz",'},
    "clrt/scene/materials.py": {
        "    specular: Coefficient = 0.0\n": "    specular: Coefficient = 0.0\n    fuzz: Coefficient = 0.0\n",
    },
    "kernels/light.clh": {
        "material->ks > 0.0f);\n}": """material->ks > 0.0f)
        || (terms & TERM_FUZZ && material->fuzz > 0.0f);
}""",
        "    floatP shine = ": """\
    const floatP grazing = material->fuzz * (1.0f + dot3(s.ns, u)) * cosine;
    const floatP fuzz = terms & TERM_FUZZ ? grazing : (floatP)(0.0f);
    floatP shine = """,
        "(diffuse * colors(": "((diffuse + fuzz) * colors(",
    },
}
