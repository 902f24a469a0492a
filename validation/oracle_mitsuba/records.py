"""A scene as Mitsuba's side reads it: from the tables of a scene file, by docs/scene-files.md and
docs/model.md.

Nothing here comes from the renderer: defaults, names of indices, references to materials, transforms, normals
and overrides stand here a second time. What is wrong in a scene is the renderer's to say; this takes it as
right.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from . import published
from .shapes import Shape

Array = np.ndarray
NAMED_INDEX = {"air": 1.0, "water": 1.333, "ice": 1.31, "glass": 1.5, "diamond": 2.419}
LIGHTS = ("D65", "A", "E", *(f"F{number}" for number in range(1, 13)), "sun")
HELIUM_D = 587.5618  # nm


@dataclass(frozen=True)
class Source:
    """A scene file's tables as tomllib or json reads them, and what a caller wants otherwise.

    folder: where the files that it names lie.
    """

    tables: Mapping[str, Any]
    folder: str | None = None
    width: int | None = None
    height: int | None = None
    spp: int | None = None
    max_depth: int | None = None


@dataclass(frozen=True)
class Spectrum:
    """kind: name, blackbody, gaussian, band, line or samples; value: what is said of it."""

    kind: str
    value: Any
    scale: float = 1.0


@dataclass(frozen=True)
class Checker:
    colors: tuple[Any, Any] = (0.9, 0.1)
    size: float = 1.0
    divisions: int = 16


@dataclass(frozen=True)
class Picture:
    """An image where a colour may stand."""

    file: str
    wrap: str = "repeat"
    filter: str = "linear"
    encoding: str | None = None
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)
    tint: tuple[float, float, float] = (1.0, 1.0, 1.0)
    part: int | None = None  # of a PLY: the colours of its vertices or faces


@dataclass(frozen=True)
class NormalMap:
    file: str
    scale: float = 1.0
    placement: Picture | None = None  # where it lies, of no file


@dataclass(frozen=True)
class Formula:
    """An index of refraction over the wavelength: kind "sellmeier" (B, C) or "cauchy" (A, B, ...)."""

    kind: str
    numbers: tuple[Any, ...]


@dataclass(frozen=True)
class Conductor:
    eta: Any
    k: Any


@dataclass(frozen=True)
class Material:
    color: Any = 0.8
    ambient: float | None = None
    diffuse: float = 1.0
    specular: float = 0.0
    shininess: float = 32.0
    reflection: float | None = None
    transmission: float | None = None
    ior: Any = 1.5
    fresnel: bool | str = False
    highlight_color: Any = 1.0
    reflection_color: Any = 1.0
    transmission_color: Any = 1.0
    emission: Any = 0.0
    absorption: Any = 0.0
    priority: int = 0
    thin: bool = False
    conductor: Any = None
    roughness: float = 0.0
    normal_map: NormalMap | None = None

    @property
    def pictures(self) -> list[str]:
        """The files of its pictures and normals."""
        values = (self.color, self.highlight_color, self.reflection_color, self.transmission_color,
                  self.emission, self.normal_map)  # fmt: skip
        return [value.file for value in values if isinstance(value, (Picture, NormalMap))]

    @property
    def ka(self) -> float:
        return self.ambient if self.ambient is not None else self.diffuse

    @property
    def kr(self) -> float:
        if self.reflection is not None:
            return self.reflection
        return 1.0 if self.fresnel is True or self.conductor is not None else 0.0

    @property
    def kt(self) -> float:
        if self.transmission is not None:
            return self.transmission
        return 1.0 if self.fresnel is True and self.conductor is None else 0.0

    @property
    def alpha(self) -> float:
        """GGX's, 0 of a perfect mirror."""
        return self.roughness**2 if self.roughness >= 0.01 and self.kr > 0 else 0.0

    @property
    def varies(self) -> bool:
        """Whether the index is a curve over the wavelength."""
        return not isinstance(self.ior, (int, float)) and self.ior not in NAMED_INDEX

    @property
    def ior_d(self) -> float:
        """The index in RGB."""
        return float(index(self, np.array([HELIUM_D]))[0])


@dataclass(frozen=True, eq=False)
class PointLight:
    position: Any
    intensity: Any = 1.0
    falloff: str = "none"
    type: str = "point"


@dataclass(frozen=True, eq=False)
class DirectionalLight:
    direction: Any
    intensity: Any = 1.0
    type: str = "directional"


@dataclass(frozen=True, eq=False)
class SpotLight:
    position: Any
    target: Any
    intensity: Any = 1.0
    angle: float = 30.0
    penumbra: float = 0.1
    falloff: str = "none"
    type: str = "spot"


@dataclass(frozen=True, eq=False)
class AreaLight:
    """A rectangle, a disk or a sphere, by its `type`."""

    type: str
    center: Any
    u: Any = None
    v: Any = None
    normal: Any = None
    radius: Any = None
    radiance: Any = 1.0
    samples: int = 16
    two_sided: bool = False
    visible: bool = True

    @property
    def intensity(self) -> Any:
        return self.radiance


@dataclass(frozen=True, eq=False)
class Camera:
    origin: Any = None
    target: Any = None
    type: str = "perspective"
    up: Any = None
    fov: float = 45.0
    fov_axis: str = "horizontal"
    size: float = 2.0
    near: float = 0.0
    aperture: float = 0.0
    focus: float | None = None
    mirror: bool = False
    shift: Any = (0.0, 0.0)
    width: int = 640
    height: int = 480
    spp: int = 1
    filter: str = "box"
    jitter: int | None = None
    pose: Any = None
    K: Any = None

    def __post_init__(self) -> None:
        if self.pose is not None:
            _, down, forward, origin = np.array(self.pose, float)[:3].T
            for name, vector in (("origin", origin), ("target", origin + forward), ("up", -down)):
                object.__setattr__(self, name, vector)


@dataclass(frozen=True)
class Spectral:
    bands: int = 24
    range: tuple[float, float] = (380.0, 750.0)
    white: str = "D65"
    white_balance: bool = False
    response: str = "cie"
    group: int = 1
    faults: bool = False


@dataclass(frozen=True, eq=False)
class Scene:
    camera: Camera | None = None
    materials: dict[str, Material] = field(default_factory=dict)
    lights: tuple[Any, ...] = ()
    shapes: tuple[Any, ...] = ()
    max_depth: int = 5
    min_weight: float = 0.0
    depth_color: Any = 0.0
    background: Any = 0.0
    ambient: Any = 0.0
    ambient_samples: int = 0
    medium_ior: float = 1.0
    one_sided: str = "none"
    shadow: str = "opaque"
    conformance: str = "none"
    spectrum: Spectral | None = None
    adaptive: dict[str, Any] | None = None
    folder: str | None = None

    def material_of(self, shape: Shape) -> Material:
        if isinstance(shape.material, str):
            return self.materials[shape.material]
        return Material() if shape.material is None else shape.material

    @property
    def background_path(self) -> Path | None:
        return Path(self.folder or ".") / self.background if isinstance(self.background, str) else None


def index(of: Material, nm: Array) -> Array:
    """A material's index of refraction at wavelengths."""
    if of.varies:
        return published.index(of.ior, nm)
    return np.full(len(nm), NAMED_INDEX[of.ior] if isinstance(of.ior, str) else float(of.ior))


def rgb(value: Any) -> tuple[float, float, float]:
    """A plain colour as three numbers."""
    red, green, blue = np.broadcast_to(np.asarray(value, float), (3,)).tolist()
    return red, green, blue
