"""What a scene and a render may cost, checked before the memory or the time is spent."""

from __future__ import annotations

from dataclasses import dataclass

from clrt.errors import LimitError, MemoryLimitError, located

# What to do about each limit besides raising it; those of loading are raised where the scene is made.
_LOADING = {
    "file_bytes": "use a smaller file",
    "nesting": "nest the file's tables and arrays less deeply",
    "primitives": "use fewer shapes or faces",
    "vertices": "use a mesh with fewer vertices",
    "lights": "use fewer lights",
}
_RENDERING = {
    "pixels": "lower width or height",
    "samples": "lower spp",
    "depth": "lower max_depth",
    "bands": "use fewer bands",
    "device_bytes": "use a smaller scene or a smaller tile",
    "work": "lower width, height, spp, max_depth or the number of lights",
}


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Upper bounds, each inclusive. A violation is a `LimitError` that says what to change."""

    file_bytes: int = 512 << 20
    """Bytes of one scene, mesh or image file."""
    nesting: int = 64
    """Depth of tables and arrays in a scene file."""
    primitives: int = 1 << 24
    """Spheres, polygons, mesh faces ... of a scene together."""
    vertices: int = 1 << 24
    """Vertices of one mesh."""
    lights: int = 1 << 16
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
    work: int = 10**14
    """An upper bound of feelers: see `check_work`."""

    def check(self, name: str, value: int, source: str = "", place: str = "") -> None:
        """Raise `LimitError` if `value` is above the limit called `name`."""
        most: int = getattr(self, name)
        if value <= most:
            return
        if name in _LOADING:
            advice, how = _LOADING[name], f"clrt.load(..., limits=Limits({name}=...))"
        else:
            advice, how = _RENDERING[name], f"Settings(limits=Limits({name}=...))"
        text = f"{_number(value)} is above the limit of {_number(most)}; {advice}, or allow more with {how}"
        kind = MemoryLimitError if name == "device_bytes" else LimitError
        raise kind(located(source, place, f"{name}: {text}"))

    def check_work(self, samples: int, lights: int, depth: int, branching: bool, source: str = "") -> None:
        """Stop a render that cannot end in a reasonable time.

        `samples` is width x height x spp. A camera ray has at most 2^(depth + 1) - 1 descendants where some
        surface both reflects and transmits (`branching`), else depth + 1; each sends a feeler to each
        light.
        """
        rays = 1 << depth if branching else depth + 1
        self.check("work", samples * max(lights, 1) * rays, source)


def _number(value: int) -> str:
    return (
        f"{value:,}".replace(",", " ")
        if value < 10**15
        else f"{float(value):.3g}"
        if value < 10**300
        else "> 1e300"
    )
