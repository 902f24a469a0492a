"""What a scene and a render may cost, checked before the memory or the time is spent."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, fields
from typing import Final

from clrt.base import errors
from clrt.base.arguments import whole
from clrt.base.errors import ClrtError, LimitError, MemoryLimitError, fault, located, show
from clrt.base.suggest import did_you_mean

# What to do about each limit besides raising it; those of loading are raised where the scene is made.
_LOADING = {
    "file_bytes": "use a smaller file",
    "text_bytes": "use a smaller file, or give meshes as binary files",
    "nesting": "nest the file's tables and arrays less deeply",
    "tables": "write the scene as JSON",
    "primitives": "use fewer shapes or faces",
    "vertices": "use meshes with fewer vertices",
    "lights": "use fewer lights",
    "image_pixels": "use a smaller picture",
    "image_bytes": "use a smaller picture, or one of fewer channels and smaller tiles",
    "texture_bytes": "use smaller pictures",
}
_RENDERING = {
    "pixels": "lower width or height",
    "samples": "lower spp",
    "depth": "lower max_depth",
    "bands": "use fewer bands",
    "device_bytes": "use a smaller scene or a smaller tile",
    "host_bytes": "lower width or height, use fewer layers or fewer rays, or crop",
    "work": "it counts rays, and what each is tried on in no tree (planes, lights' surfaces): "
    "lower width, height, spp, max_depth, how many rays are given, or the number of these and of lights",
}

_call: ContextVar[str] = ContextVar("clrt_limits_call", default="")


@contextmanager
def advising(call: str) -> Iterator[None]:
    """Let messages within the block advise this call, which takes `limits`, in place of the usual one."""
    token = _call.set(f"{call}(..., limits=Limits({{}}))")
    try:
        yield
    finally:
        _call.reset(token)


TESTS: Final = 100
"""So many surfaces in no tree take as long as a ray: 0.5 to 2.3 ns each beside 0.12 us were measured."""


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Upper bounds, whole numbers, each inclusive. A violation is a `LimitError` that says what to change.

    What the kernels can count is bounded besides, whatever is allowed here: `clrt.layout.ceilings`.
    """

    file_bytes: int = 512 << 20
    """Bytes of one scene, mesh or image file."""
    text_bytes: int = 128 << 20
    """Bytes of one scene file (.toml .json .nff .txt .xml), of which reading takes up to 60 times as many."""
    nesting: int = 16
    """Depth of tables and arrays in a scene file."""
    tables: int = 1 << 16
    """Tables and arrays with a name in a TOML file, not counting those in arrays of tables."""
    primitives: int = 1 << 24
    """Spheres, polygons, mesh faces ... of a scene together."""
    vertices: int = 1 << 24
    """Vertices of a scene's meshes together."""
    lights: int = (1 << 16) - 1
    """Lights of a scene."""
    image_pixels: int = 1 << 26
    """Width times height of a picture that a scene reads."""
    image_bytes: int = 5 << 28
    """Bytes that reading a picture takes: 12 a pixel, and what its decoder unpacks at a time."""
    texture_bytes: int = 1 << 30
    """Bytes of the pictures on all surfaces of a scene together: 12 a pixel."""
    pixels: int = 1 << 27
    """Width times height of the picture."""
    samples: int = 1 << 12
    """Samples per pixel (`spp`)."""
    depth: int = 64
    """`max_depth` of a scene."""
    bands: int = 64
    """Wavelength bands a ray carries."""
    device_bytes: int = 4 << 30
    """Bytes of all buffers on the device together."""
    host_bytes: int = 4 << 30
    """Bytes of a picture with its layers, or of the answers about rays, in the host's memory."""
    work: int = 10**14
    """An upper bound of rays to trace, and of what each is tried on: see `check_work`."""

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = whole(f"limits.{entry.name}", getattr(self, entry.name))
            object.__setattr__(self, entry.name, value)

    def check(self, name: str, value: int, source: str = "", place: str = "") -> None:
        """Raise `LimitError` if `value` is above the limit called `name`; it says what call allows more."""
        most: int = getattr(self, name)
        if value <= most:
            return
        if name in _LOADING:
            advice, usual = _LOADING[name], "clrt.load(..., limits=Limits({}))"
        else:
            advice, usual = _RENDERING[name], "Settings(limits=Limits({}))"
        how = (_call.get() or usual).format(f"{name}=N")
        how = f"or allow more with {f'--limit {name}=N or ' if errors.has_limit else ''}{how}"
        text = f"{written(value)} is above the limit of {written(most)}; {advice}, {how}"
        kind = MemoryLimitError if name == "device_bytes" else LimitError
        raise kind(located(source, place, f"{name}: {text}"))

    def check_work(
        self, samples: int, lights: int, branching: Branching, alone: int = 0, place: str = ""
    ) -> None:
        """Stop what cannot end in a reasonable time.

        `samples` is width x height x spp, or how many rays a caller gives; each ray sends a feeler to each
        light, and both are tried on the `alone` primitives that no tree holds, TESTS of which count as a ray.
        """
        rays = samples * max(lights, 1) * branching.rays
        self.check("work", rays + rays * alone // TESTS, place=place)


def parse(text: str) -> tuple[str, int]:
    """Name and number of a limit written as `name=number`. ClrtError names the nearest known one."""
    name, _, number = text.partition("=")
    known = [field.name for field in fields(Limits)]
    if name not in known:
        raise ClrtError(f"{show(name)} is no limit{did_you_mean(name, known)} (limits: {', '.join(known)})")
    if not (number.isascii() and number.isdecimal()) or len(number) > 18:
        raise ClrtError(fault("", name, number, "a limit must be a whole number: NAME=N"))
    return name, int(number)


@dataclass(frozen=True)
class Branching:
    """What bounds the rays that descend from one camera ray.

    depth: generations after the camera's. doubling: some surface both reflects and transmits. share: the
    largest part of a ray's weight that a bounce passes on; with min_weight it ends the family early.
    ambient: rays that sample the ambient light at a hit.
    """

    depth: int
    doubling: bool
    share: float = 1.0
    min_weight: float = 0.0
    ambient: int = 0

    @property
    def rays(self) -> int:
        """An upper bound, within a factor of 2."""
        depth = self.depth
        if self.min_weight > 0 and self.share < 1:
            least = math.log(self.min_weight) / math.log(max(self.share, 1e-30))
            depth = min(depth, max(math.floor(least), 0) + 1)
        family = _family(depth, self.doubling)
        if not self.ambient or self.depth == 0:
            return family
        # every ray gathers but those that descend from ambient rays
        return family * (1 + self.ambient * _family(depth, self.doubling))


def _family(depth: int, doubling: bool) -> int:
    return 1 << depth if doubling else depth + 1


def written(value: int) -> str:
    """A number as messages write it: thousands apart, huge ones rounded."""
    return (
        f"{value:,}".replace(",", " ")
        if value < 10**15
        else f"{float(value):.3g}"
        if value < 10**300
        else "> 1e300"
    )
