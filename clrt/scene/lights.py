"""Light sources: points and directions."""

from __future__ import annotations

from typing import Annotated, Literal

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


class DirectionalLight(Colored, frozen=True, kw_only=True, tag="directional", tag_field="type"):
    """Parallel light that travels along `direction` (any length but 0)."""

    direction: Vector
    intensity: LightColor = 1.0

    def check(self, at: At) -> None:
        Colored.check(self, at)
        if is_zero(self.direction):
            raise at.key("direction").error(self.direction, "a direction must not be zero")


Light = PointLight | DirectionalLight
LIGHTS: dict[str, type[Light]] = {
    "point": PointLight,
    "directional": DirectionalLight,
}
