"""Light sources with extent: rectangles, disks and spheres of a radiance."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Final

import numpy as np
from msgspec import Meta

from clrt.base.places import At
from clrt.base.records import Triple, Vector, cross, float32, is_zero
from clrt.spectra.colors import Colored, LightColor

MOST_SAMPLES: Final = (1 << 16) - 1  # feelers that a hit can count
Samples = Annotated[
    int,
    Meta(ge=1, le=MOST_SAMPLES, description=f"must be a whole number from 1 to {MOST_SAMPLES}"),
]
Radius = Annotated[float, Meta(gt=0, description="a radius must be > 0")]


_FAR: Final = 1e18  # three squares of twice that are a float32, and so is a distance


def check_reach(at: At, **lengths: Vector) -> None:
    """`SceneError` for a light so far away that float32 takes its distance for infinite: it would be dark."""
    for name, length in lengths.items():
        if max(map(abs, length)) > _FAR:
            text = f"a light reaches {_FAR:g} at most; a directional one shines from infinitely far"
            raise at.key(name).error(length, text)


class AreaLight(Colored, frozen=True, kw_only=True):
    """A surface of `radiance`, which each hit sees by feelers to `samples` of its points.

    It shines on the side of its normal, a sphere outwards; `two_sided`: on both. `visible`: rays see it.
    """

    radiance: LightColor = 1.0
    samples: Samples = 16
    two_sided: bool = False
    visible: bool = True

    falloff: ClassVar[str] = "inverse-square"

    @property
    def intensity(self) -> LightColor:
        """What stands in the place of a point's intensity."""
        return self.radiance

    @property
    def place(self) -> tuple[float, float, float, float]:
        """The middle, as `PointLight.place`."""
        return (*self.center, 1.0)  # type: ignore[attr-defined]


class RectangleLight(AreaLight, frozen=True, kw_only=True, tag="rectangle", tag_field="type"):
    """A parallelogram: `u`, `v` reach from its `center` to the middles of two sides. Its normal is u x v."""

    center: Vector
    u: Vector
    v: Vector

    @property
    def area(self) -> float:
        """In units of length squared."""
        return 4 * float(np.linalg.norm(self.normal))

    @property
    def normal(self) -> Triple:
        """Of any length."""
        return cross(self.u, self.v)

    def check(self, at: At) -> None:
        Colored.check(self, at)
        for name in ("u", "v"):
            if is_zero(getattr(self, name)):
                raise at.key(name).error(getattr(self, name), "a half side must not be zero")
        if is_zero(cross(float32(self.u).tolist(), float32(self.v).tolist())) or not _has_area(self.area):
            text = "u and v must not be parallel, nor the area 0 or infinite in float32"
            raise at.key("v").error(self.v, text)
        check_reach(at, center=self.center, u=self.u, v=self.v)


class DiskLight(AreaLight, frozen=True, kw_only=True, tag="disk", tag_field="type"):
    """A disk of `radius` about `center`, across its `normal` (of any length but 0)."""

    center: Vector
    normal: Vector
    radius: Radius

    @property
    def area(self) -> float:
        """In units of length squared."""
        return math.pi * self.radius * self.radius

    def check(self, at: At) -> None:
        Colored.check(self, at)
        if is_zero(self.normal):
            raise at.key("normal").error(self.normal, "a normal must not be zero")
        if not _has_area(self.area):
            raise at.key("radius").error(self.radius, "the disk's area is 0 or infinite in float32")
        check_reach(at, center=self.center)


class SphereLight(AreaLight, frozen=True, kw_only=True, tag="sphere", tag_field="type"):
    """A ball of `radius` about `center`."""

    center: Vector
    radius: Radius

    def check(self, at: At) -> None:
        Colored.check(self, at)
        if not _has_area(math.pi * self.radius * self.radius):
            raise at.key("radius").error(self.radius, "the sphere's area is 0 or infinite in float32")
        check_reach(at, center=self.center)


def _has_area(area: float) -> bool:
    return 1e-37 < area < 1e37  # divided by the samples it is still a float32
