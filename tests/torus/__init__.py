"""What it takes to add a primitive (`docs/adding-a-primitive.md`): a torus, entered in a copy of the tree."""

from __future__ import annotations

from typing import Final

# file -> text that stands there once -> the same with the torus
ENTRIES: Final[dict[str, dict[str, str]]] = {
    "kernels/generic.clh": {'#include "quadric.clh"\n': '#include "quadric.clh"\n#include "torus.clh"\n'},
    "clrt/layout/__init__.py": {
        '    "Disk": ((': """    "Torus": (("center_ring", "float4"), ("axis_tube", "float4")),
    "Disk": ((""",
        '"QUADRIC": "quadrics",': '"QUADRIC": "quadrics", "TORUS": "tori",',
        '    "quadrics": "Quadric",\n': '    "quadrics": "Quadric",\n    "tori": "Torus",\n',
    },
    "clrt/scene/shapes.py": {
        "class Plane(Shape": '''class Torus(Shape, frozen=True, kw_only=True, tag="torus"):
    center: Vector
    axis: Vector
    radius: Radius
    tube: Radius

    @property
    def primitives(self) -> int:
        return 2


class Plane(Shape''',
    },
    "clrt/scene/scene.py": {
        "    Sphere,\n)\n": "    Sphere,\n    Torus,\n)\n",
        "AnyShape = Sphere |": "AnyShape = Torus | Sphere |",
        '    "sphere": Sphere,\n': '    "sphere": Sphere,\n    "torus": Torus,\n',
    },
    "clrt/flatten/flatten.py": {
        "    quadrics: np.ndarray\n": "    quadrics: np.ndarray\n    tori: np.ndarray\n"
    },
    "clrt/flatten/shapes.py": {
        "def _plane(out": '''def _torus(
    out: Collected, shape: Torus, index: int, material: int, at: str
) -> None:
    out.tori += [(*shape.center, shape.radius, *unit(shape.axis), shape.tube)] * 2
    out.number("TORUS", index, material, 2)


def _plane(out''',
        "    planes: list": """    tori: list[tuple[float, ...]] = field(default_factory=list)
    planes: list""",
        "    Sphere: _sphere,\n": "    Sphere: _sphere,\n    Torus: _torus,\n",
        "from clrt.scene.transforms import":
            "from clrt.scene.shapes import Torus\nfrom clrt.scene.transforms import",
    },
    "clrt/flatten/geometry.py": {
        "    _check_kinds(collected, sections, boxes)\n": '''\
    sections["tori"], boxes["TORUS"] = _tori(collected)
    _check_kinds(collected, sections, boxes)
''',
        "def _planes(": '''def _tori(collected: Collected) -> tuple[np.ndarray, Boxes]:
    out = np.zeros(len(collected.tori), layout.dtype("Torus"))
    rows = np.reshape(collected.tori, (-1, 8))
    out["center_ring"], out["axis_tube"] = rows[:, :4], rows[:, 4:]
    center, reach = rows[:, :3], rows[:, 3:4] + rows[:, 7:8]
    return out, padded(center - reach, center + reach, layout.PAD)


def _planes(''',
    },
    "clrt/flatten/inside.py": {
        "def _plane(shape": '''def _torus(shape: Torus, p: np.ndarray) -> np.ndarray:
    local = p - shape.center
    height = local @ (np.asarray(shape.axis, np.float64) / np.linalg.norm(shape.axis))
    across = np.sqrt(np.maximum(np.square(local).sum(axis=1) - height**2, 0))
    return np.asarray((across - shape.radius) ** 2 + height**2 < shape.tube**2)


def _plane(shape''',
        "    Sphere: _sphere,\n": "    Sphere: _sphere,\n    Torus: _torus,\n",
        "    Sphere,\n)\n": "    Sphere,\n    Torus,\n)\n",
    },
    "clrt/flatten/mapping.py": {
        "def _plane(shape": '''def _torus(shape: Torus) -> list[np.ndarray]:
    axis = unit(shape.axis)
    ways = *about(axis), axis / (2 * shape.tube)
    rows = [_from(shape.center, way, rest) for way, rest in zip(ways, (0.0, 0.0, 0.5), strict=True)]
    return [_record("MAP_AXIAL", shape.matrix, *rows)] * 2


def _plane(shape''',
        "    Sphere: _sphere,\n": "    Sphere: _sphere,\n    Torus: _torus,\n",
        "from clrt.scene.transforms import":
            "from clrt.scene.shapes import Torus\nfrom clrt.scene.transforms import",
    },
}
