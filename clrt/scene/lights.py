"""Light sources: points, directions, spots, and those with extent."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from msgspec import Meta

from clrt.base.places import At
from clrt.base.records import Vector, float32, is_zero
from clrt.scene.arealights import DiskLight, RectangleLight, SphereLight, check_reach
from clrt.spectra.colors import Colored, LightColor

Falloff = Annotated[
    Literal["none", "inverse-square"], Meta(description="falloff must be 'none' or 'inverse-square'")
]


class PointLight(Colored, frozen=True, kw_only=True, tag="point", tag_field="type"):
    """Light from `position`, by default without loss over the distance (T 3.2)."""

    position: Vector
    intensity: LightColor = 1.0
    falloff: Falloff = "none"

    @property
    def place(self) -> tuple[float, float, float, float]:
        """Where it is, (x, y, z, 1); of a light infinitely far away (x, y, z, 0), a way towards it."""
        return (*self.position, 1.0)

    def check(self, at: At) -> None:
        Colored.check(self, at)
        check_reach(at, position=self.position)


class DirectionalLight(Colored, frozen=True, kw_only=True, tag="directional", tag_field="type"):
    """Parallel light that travels along `direction` (any length but 0)."""

    direction: Vector
    intensity: LightColor = 1.0
    falloff: ClassVar[str] = "none"

    @property
    def place(self) -> tuple[float, float, float, float]:
        """As `PointLight.place`."""
        x, y, z = self.direction
        return -x, -y, -z, 0.0

    def check(self, at: At) -> None:
        Colored.check(self, at)
        if is_zero(self.direction):
            raise at.key("direction").error(self.direction, "a direction must not be zero")


class SpotLight(Colored, frozen=True, kw_only=True, tag="spot", tag_field="type"):
    """A point light that shines from `position` towards `target`, into a cone.

    `angle`: from the axis to where the light ends, in degrees. `penumbra`: the part of it, from outside, over
    which the light grows to all of it, linearly in the angle.
    """

    position: Vector
    target: Vector
    intensity: LightColor = 1.0
    angle: Annotated[
        float, Meta(gt=0, le=90, description="must be an angle from the axis, above 0 and up to 90 degrees")
    ] = 30.0
    penumbra: Annotated[
        float, Meta(ge=0, le=1, description="must be a part of the angle, from 0 to 1")
    ] = 0.1
    falloff: Falloff = "none"

    @property
    def place(self) -> tuple[float, float, float, float]:
        """As `PointLight.place`."""
        return (*self.position, 1.0)

    def check(self, at: At) -> None:
        Colored.check(self, at)
        if is_zero(float32(self.target) - float32(self.position)):
            raise at.key("target").error(self.target, "a spot's target must not be at its position")
        check_reach(at, position=self.position)


Light = PointLight | DirectionalLight | SpotLight | RectangleLight | DiskLight | SphereLight
LIGHTS: dict[str, type[Light]] = {
    "point": PointLight,
    "directional": DirectionalLight,
    "spot": SpotLight,
    "rectangle": RectangleLight,
    "disk": DiskLight,
    "sphere": SphereLight,
}
