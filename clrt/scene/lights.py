"""Light sources: points and directions."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from msgspec import Meta

from clrt.base.places import At
from clrt.base.records import Vector, is_zero
from clrt.spectra.colors import Colored, LightColor


class PointLight(Colored, frozen=True, kw_only=True, tag="point", tag_field="type"):
    """Light from `position`, by default without loss over the distance (T 3.2)."""

    position: Vector
    intensity: LightColor = 1.0
    falloff: Annotated[
        Literal["none", "inverse-square"], Meta(description="falloff must be 'none' or 'inverse-square'")
    ] = "none"

    @property
    def place(self) -> tuple[float, float, float, float]:
        """Where it is, (x, y, z, 1); of a light infinitely far away (x, y, z, 0), a way towards it."""
        return (*self.position, 1.0)


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


Light = PointLight | DirectionalLight
LIGHTS: dict[str, type[Light]] = {
    "point": PointLight,
    "directional": DirectionalLight,
}
