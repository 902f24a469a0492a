"""What it takes to add a light (`docs/adding-a-light.md`): a small flat lamp, in a copy of the tree."""

from __future__ import annotations

from typing import Final

# file -> text that stands there once -> the same with the lamp
ENTRIES: Final[dict[str, dict[str, str]]] = {
    "kernels/light.clh": {
        '#include "light_point.clh"\n': '#include "light_point.clh"\n#include "light_patch.clh"\n'
    },
    "clrt/layout/__init__.py": {
        '"SPOT": 2}': '"SPOT": 2, "PATCH": 3}',
    },
    "clrt/scene/lights.py": {
        "Light = PointLight |": '''\
class PatchLight(Colored, frozen=True, kw_only=True, tag="patch", tag_field="type"):
    """A small flat lamp at `position`, bright on the side of `normal`."""

    position: Vector
    normal: Vector
    intensity: LightColor = 1.0
    falloff: ClassVar[str] = "inverse-square"

    def check(self, at: At) -> None:
        Colored.check(self, at)
        if is_zero(self.normal):
            raise at.key("normal").error(self.normal, "a normal must not be zero")

    @property
    def place(self) -> tuple[float, float, float, float]:
        """As `PointLight.place`."""
        return (*self.position, 1.0)


Light = PatchLight | PointLight |''',
        '    "point": PointLight,\n': '    "point": PointLight,\n    "patch": PatchLight,\n',
    },
    "clrt/flatten/materials.py": {
        "    Light,\n    PointLight,\n": "    Light,\n    PatchLight,\n    PointLight,\n",
        "def _directional(": '''\
def _patch(record: np.void, source: PatchLight) -> None:
    record["place"][:3] = source.position
    record["axis"][:3] = source.normal / np.linalg.norm(source.normal)
    record["falloff"] = layout.FALLOFF["INVERSE_SQUARE"]


def _directional(''',
        '    PointLight: ("POINT", _point),\n': '''\
    PointLight: ("POINT", _point),
    PatchLight: ("PATCH", _patch),
''',
    },
}
