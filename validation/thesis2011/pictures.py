"""The thesis program's pictures, computed anew in float64, with or without its faults.

An independent tracer: it shares the scene and its spectra with clrt, not geometry, shading or colours.
`faults` names what that program does wrong; each can be switched on alone, to see what comes of it.
Run `python -m validation.thesis2011.check FOLDER` for the program's own scenes and pictures.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np

from clrt.scene.scene import Checker, ImageTexture, PointLight, Scene, Shape, Sphere
from clrt.spectra.bands import Bands, light, reflectance

from .shapes import Form, Spheres, form_of, unit

FAULTS: Final = {
    "shadow epsilon": "a feeler starts at 1e-4 of its way to the light, 0.1 units and more off the surface",
    "lost reflection": "total internal reflection makes a ray that is no number and brings nothing",
    "highlight behind": "the highlight does not ask whether the light is in front of the surface",
    "no linear quadric": "a quadric is missed by rays whose equation is not quadratic",
    "lost distance": "hits more than 1e6 units away are lost",
    "plane at once": "a ray that starts in a plane and stays in it hits it there",
    "power of nothing": "0 to the power of 0 is 1",
}
"""What the program does wrong, by the names that `picture` takes."""
_EPSILON: Final = 1e-4  # the least parameter of a hit along a ray's direction
_TINY: Final = 1e-9  # the same where that is no fault: float64 needs some room, too
_FAR: Final = 1e6
_DEPTH: Final = 3  # generations after the camera's
_CHUNK: Final = 1 << 14  # rays at a time


@dataclass(frozen=True, eq=False)
class _Rays:
    """Origins and directions (n, 3), of any length, and the index of what they are in, (n,)."""

    origin: np.ndarray
    direction: np.ndarray
    medium: np.ndarray

    def of(self, which: np.ndarray) -> _Rays:
        return _Rays(self.origin[which], self.direction[which], self.medium[which])


@dataclass(frozen=True, eq=False)
class _Surfaces:
    """Materials of all primitives in the program's terms: colours (m, bands), the others (m,)."""

    color: np.ndarray
    diffuse: np.ndarray
    specular: np.ndarray
    transmissive: np.ndarray
    index: np.ndarray
    smoothness: np.ndarray


class Program:
    """The thesis program on one scene, whose response must be "thesis-2011".

    `faults`: those of FAULTS that are on; None: all where the scene's `spectrum.faults` is true, else none.
    """

    def __init__(self, scene: Scene, faults: Iterable[str] | None = None) -> None:
        assert scene.spectrum is not None and scene.spectrum.response == "thesis-2011"
        self.scene = scene
        if faults is None:
            faults = FAULTS if scene.spectrum.faults else ()
        self.faults = frozenset(faults)
        assert self.faults <= FAULTS.keys(), self.faults - FAULTS.keys()
        self.bands = Bands(scene.spectrum.bands, *scene.spectrum.range)
        round_ = [s for s in scene.shapes if isinstance(s, Sphere)]
        others = [s for s in scene.shapes if not isinstance(s, Sphere)]
        strict = "no linear quadric" in self.faults, "plane at once" in self.faults
        self.forms: list[Form] = [Spheres(round_)] if round_ else []
        self.forms += [form_of(shape, *strict) for shape in others]
        self.surfaces = self._surfaces([*round_, *others])
        self.ambient = light(scene.ambient, self.bands)
        self.lights = []
        for source in scene.lights:
            assert isinstance(source, PointLight)
            self.lights.append((np.array(source.position), light(source.intensity, self.bands)))

    def _surfaces(self, shapes: list[Shape]) -> _Surfaces:
        found = [self.scene.material_of(shape) for shape in shapes]
        colors = []
        for material in found:
            assert not isinstance(material.color, (Checker, ImageTexture))
            colors.append(reflectance(material.color, self.bands))
        return _Surfaces(
            np.array(colors),
            np.array([m.diffuse for m in found]),
            np.array([m.specular for m in found]),
            np.array([m.kt for m in found]),
            np.array([m.ior_d for m in found]),
            np.array([m.shininess for m in found]),
        )

    def picture(self, step: int = 1) -> np.ndarray:
        """(h, w, 3) uint8: the pixels at every `step`-th row and column, from the first."""
        camera = self.scene.camera
        assert camera is not None
        width, height = camera.width, camera.height
        spacing = 2 * np.tan(np.radians(camera.fov) / 2) / width
        y, x = np.mgrid[0:height:step, 0:width:step]
        right, up = (x - width // 2) * spacing, (height // 2 - y) * spacing
        direction = np.stack([right, up, np.ones_like(right)], -1).reshape(-1, 3)
        out = np.empty(direction.shape, np.uint8)
        for start in range(0, len(out), _CHUNK):
            d = direction[start : start + _CHUNK]
            medium = np.full(len(d), self.scene.medium_ior)
            out[start : start + _CHUNK] = self._shown(self.trace(_Rays(camera.origin + d, d, medium), 0))
        return out.reshape(*y.shape, 3)

    def _shown(self, radiance: np.ndarray) -> np.ndarray:
        """Three Gaussians, divided by the largest, times the integral; 255 is 1, fractions are cut off."""
        nm = self.bands.midpoints
        curves = [
            np.exp(-(((nm - center) / width) ** 2) / 2) / (width * np.sqrt(2 * np.pi))
            for center, width in ((610, 25), (540, 30), (445, 25))
        ]
        xyz = radiance @ np.array(curves).T
        largest = xyz.max(axis=1, keepdims=True)
        integral = radiance.sum(axis=1, keepdims=True) * self.bands.width
        shown = 255 * integral * np.divide(xyz, largest, out=np.zeros_like(xyz), where=largest > 0)
        return np.clip(shown, 0, 255).astype(np.uint8)

    def trace(self, rays: _Rays, depth: int) -> np.ndarray:
        """(n, bands) radiances that rays bring."""
        out = np.zeros((len(rays.origin), self.bands.n))
        if depth > _DEPTH:
            return out
        far = _FAR if "lost distance" in self.faults else np.inf
        t, form, number = self._nearest(rays, _EPSILON if self.faults else _TINY, far)
        (hit,) = np.nonzero(form >= 0)
        if len(hit):
            out[hit] = self._shade(rays.of(hit), t[hit], form[hit], number[hit], depth)
        return out

    def _nearest(self, rays: _Rays, low: float, high: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Parameter, form (-1: none) and number in `surfaces` of the first hits, (n,) each."""
        t = np.full(len(rays.origin), high)
        form, number = np.full(len(t), -1), np.zeros(len(t), int)
        first = 0
        for i, each in enumerate(self.forms):
            found, inner = each.nearest(rays.origin, rays.direction, low)
            nearer = found < t
            t[nearer], form[nearer], number[nearer] = found[nearer], i, first + inner[nearer]
            first += each.count
        return t, form, number

    def _shade(
        self, rays: _Rays, t: np.ndarray, form: np.ndarray, number: np.ndarray, depth: int
    ) -> np.ndarray:
        point = rays.origin + t[:, None] * rays.direction
        outward = np.empty_like(point)
        first = 0
        for i, each in enumerate(self.forms):
            here = form == i
            outward[here] = each.normals(point[here], number[here] - first)
            first += each.count
        u = unit(rays.direction)
        inside = (outward * u).sum(axis=1) > 0
        normal = np.where(inside[:, None], -outward, outward)
        of = self.surfaces
        out = of.color[number] * self.ambient * of.diffuse[number, None]
        for place, spectrum in self.lights:
            out += self._lit(point, normal, u, number, place, spectrum)
        reflected = u - 2 * (normal * u).sum(axis=1, keepdims=True) * normal
        mirror = of.specular[number]
        new = np.where(inside, self.scene.medium_ior, of.index[number])
        eta = rays.medium / np.where(new > 0, new, 1.0)
        cosine = -(normal * u).sum(axis=1)
        k = 1 - eta**2 * (1 - cosine**2)
        clear = of.transmissive[number]
        if "lost reflection" not in self.faults:
            mirror = mirror + np.where(k < 0, clear, 0.0)
        (which,) = np.nonzero(mirror > 0)
        back = _Rays(point[which], reflected[which], rays.medium[which])
        out[which] += mirror[which, None] * self.trace(back, depth + 1)
        (which,) = np.nonzero((clear > 0) & (k >= 0))
        bent = eta * cosine - np.sqrt(np.maximum(k, 0))
        through = eta[:, None] * u + bent[:, None] * normal
        onward = _Rays(point[which], through[which], new[which])
        out[which] += clear[which, None] * self.trace(onward, depth + 1)
        return out

    def _lit(
        self,
        point: np.ndarray,
        normal: np.ndarray,
        u: np.ndarray,
        number: np.ndarray,
        place: np.ndarray,
        spectrum: np.ndarray,
    ) -> np.ndarray:
        """(n, bands): diffuse light and highlight from one light, where it is seen."""
        of = self.surfaces
        way = place - point
        to = unit(way)
        facing = (normal * to).sum(axis=1)
        mirrored = 2 * facing[:, None] * normal - to
        towards = np.maximum(-(mirrored * u).sum(axis=1), 0)
        power = of.smoothness[number]
        highlight = of.specular[number] * towards**power
        if "power of nothing" not in self.faults:
            highlight = np.where(towards > 0, highlight, 0.0)
        if "highlight behind" not in self.faults:
            highlight = np.where(facing > 0, highlight, 0.0)
        diffuse = of.diffuse[number] * np.maximum(facing, 0)
        share = highlight[:, None] * spectrum + diffuse[:, None] * of.color[number] * spectrum
        (asked,) = np.nonzero((highlight > 0) | (diffuse > 0))
        low = _EPSILON if "shadow epsilon" in self.faults else _TINY
        feelers = _Rays(point[asked], way[asked], np.empty(len(asked)))
        _, form, _ = self._nearest(feelers, low, 1.0)
        share[asked[form >= 0]] = 0.0
        return share
