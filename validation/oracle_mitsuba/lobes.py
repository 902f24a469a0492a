"""The BSDF mode: directions, Fresnel shares, diffuse light and the lights themselves are Mitsuba's own
plugins.

Every material is up to three of them: `diffuse`, a mirror (`conductor`), a boundary (`dielectric`,
`thindielectric`). A plugin is asked for one lobe at a time by BSDFContext.type_mask, so nothing is random.
Left to the table are: constant coefficients in place of Fresnel's (Mitsuba still gives the direction, and
says whether reflection is total), ambient light, emission, and whatever the recursion itself decides.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from . import engine
from .engine import dr, mi
from .lights import Way
from .optics import Optics, dot, normalized
from .plugins import rgb
from .skies import environment
from .spot import Spot
from .surfaces import emitter
from .table import Table

Array = np.ndarray


class Lobes(Table):
    """The BSDF mode; job as for Table."""

    def __init__(self, job: dict[str, Any]) -> None:
        super().__init__(job)
        of = self.of
        number = range(len(of["kd"]))
        self.made: dict[str, Any] = {}
        diffuse = [_twosided("diffuse", reflectance=of["kd"][i] * of["F"][i]) for i in number]
        mirrors = [_twosided("conductor", specular_reflectance=of["kr"][i] * of["M"][i]) for i in number]
        self.diffuse, self.mirror = (_pointers(plugins, self.made) for plugins in (diffuse, mirrors))
        self.emitters = {
            emitter.id(): emitter for emitter in self.world.scene.emitters() if not emitter.is_environment()
        }

    def plugins(self) -> dict[str, Any]:
        """Emitters."""
        plugins = {"sky": environment(self.settings["background"])}
        for index, light in enumerate(self.lights):
            plugins[f"light_{index}"] = emitter(light, self.center, rgb)
        return plugins

    def background(self, direction: Array) -> Array:
        """Radiance (n, 3) that Mitsuba's environment sends."""
        n = len(direction)
        if not n:
            return np.zeros((0, 3))
        si = dr.zeros(mi.SurfaceInteraction3f, n)
        si.wi = engine.vector(-direction)
        return engine.rows(self.world.scene.environment().eval(si), n)

    def local(self, index: int, u: Array, spot: Spot, way: Way) -> Array:
        """Light number `index` on diffuse surfaces, and no highlight (2, n, 3)."""
        n, light = len(u), self.lights[index]
        si = self._interaction(u, spot, spot.ns)
        emitter = self.emitters[f"light_{index}"]
        sample, strength = emitter.sample_direction(si, mi.Point2f(0.5), mi.Bool(True))
        if light["near"] and not light["falloff"]:
            strength = strength * dr.square(sample.dist)
        reflected = self._plugin(self.diffuse, spot).eval(
            mi.BSDFContext(), si, si.to_local(sample.d), mi.Bool(True)
        )
        diffuse = engine.rows(reflected * strength, n)
        return np.stack([diffuse, np.zeros_like(diffuse)])

    def optics(self, u: Array, spot: Spot, n: Array) -> Optics:
        """Mitsuba's reflection and transmission at the normals n."""
        of, shape, count = self.of, spot.shape, len(u)
        flags = mi.BSDFFlags
        si = self._interaction(u, spot, n)
        boundary, mirror = self._boundaries(spot), self._plugin(self.mirror, spot)
        transmits, is_thin = of["kt"][shape] > 0, of["thin"][shape]
        d_t, w_t = self._lobe(boundary, si, flags.DeltaTransmission | flags.Null, count, radiance=~is_thin)
        d_r, w_r = self._lobe(boundary, si, flags.DeltaReflection, count)
        d_m, w_m = self._lobe(mirror, si, flags.DeltaReflection, count)
        by_metal = of["conductor"][shape]

        kr, kt = of["kr"][shape, None] * of["M"][shape], of["kt"][shape, None] * of["Tt"][shape]
        by_fresnel = of["fresnel"][shape] | by_metal
        total = transmits & ~is_thin & (w_t.max(axis=1) <= 0)
        # with constant coefficients the boundary's plugin has no tints: w_t says how much is not reflected
        reflected = np.where((transmits | by_metal)[:, None], d_r, d_m)
        straight = is_thin | (spot.eta_i == spot.eta_t)
        transmitted = np.where(straight[:, None], u, d_t)
        lost = np.where(total[:, None], kt, 0.0)
        reflects = np.where(by_fresnel[:, None], w_r, w_m + lost)
        passes = np.where(by_fresnel[:, None], w_t, np.where(transmits[:, None], kt, 0.0) - lost)
        reflects = np.where((kr.max(axis=1) > 0)[:, None] | (lost > 0), reflects, 0.0)
        return Optics(
            normalized(reflected),
            normalized(transmitted),
            reflects,
            np.where(total[:, None], 0.0, passes),
            total,
        )

    def gloss(self, u: Array, spot: Spot, n: Array, draws: tuple[Array, Array]) -> tuple[Array, Array]:
        """Mitsuba's `roughconductor`; of what is no metal it gives the direction and Smith's share."""
        count, metal = len(u), self.of["conductor"][spot.shape]
        si = self._interaction(u, spot, n, facing=True)
        plugin = self._facets(spot)
        # its first axis across the plane of incidence points the other way
        at = mi.Point2f(*(mi.Float(np.ascontiguousarray(d, np.float32)) for d in (1 - draws[0], draws[1])))
        sample, weight = plugin.sample(mi.BSDFContext(), si, mi.Float(0.5), at, mi.Bool(True))
        back = normalized(engine.rows(si.to_world(sample.wo), count))
        cosine = np.sqrt(np.maximum((1 - dot(u, back)) / 2, 0.0))  # half of the angle between the two
        share = np.nan_to_num(engine.rows(weight, count).copy())
        return back, np.where(metal[:, None], share, share * self.on_facet(cosine, spot))

    def _facets(self, spot: Spot) -> Any:
        kinds, row = np.unique(np.stack([spot.shape, spot.eta_i]), axis=1, return_inverse=True)
        plugins = [
            _rough({name: self.of[name][int(shape)] for name in self.of}, outer) for shape, outer in kinds.T
        ]
        return _as_plugins(_pointers(plugins, self.made)[row.ravel()])

    def _interaction(self, u: Array, spot: Spot, n: Array, facing: bool = False) -> Any:
        """A hit for Mitsuba: `n` is on the ray's side, its frame is the surface's, or with `facing` n's."""
        outward = np.where(((dot(spot.outward, spot.n) < 0) & (not facing))[:, None], -n, n)
        si = dr.zeros(mi.SurfaceInteraction3f, len(u))
        si.t = mi.Float(1.0)
        si.p = engine.point(spot.start_before - self.center)
        si.n = mi.Normal3f(engine.vector(outward))
        si.sh_frame = mi.Frame3f(engine.vector(outward))
        si.wi = si.to_local(engine.vector(-u))
        return si

    def _plugin(self, pointers: Array, spot: Spot) -> Any:
        return _as_plugins(pointers[spot.shape])

    def _boundaries(self, spot: Spot) -> Any:
        """Plugins for what lies on both sides of the hits; a shape's inside is where its normal comes from"""
        enters = spot.enters | self.of["thin"][spot.shape] | self.of["conductor"][spot.shape]
        outer, inner = np.where(enters, [spot.eta_i, spot.eta_t], [spot.eta_t, spot.eta_i])
        kinds, row = np.unique(np.stack([spot.shape, outer, inner]), axis=1, return_inverse=True)
        plugins = [
            _boundary({name: self.of[name][int(shape)] for name in self.of}, out, into)
            for shape, out, into in kinds.T
        ]
        return _as_plugins(_pointers(plugins, self.made)[row.ravel()])

    def _lobe(self, plugin: Any, si: Any, mask: Any, n: int, radiance: Any = None) -> tuple[Array, Array]:
        """Direction (n, 3) and weight (n, 3) of one lobe.

        radiance: where Mitsuba scales transmitted radiance by (eta_i / eta_t)^2, which is undone.
        """
        context = mi.BSDFContext()
        context.type_mask = int(mask)
        sample, weight = plugin.sample(context, si, mi.Float(0.5), mi.Point2f(0.5), mi.Bool(True))
        if radiance is not None:
            weight = weight * dr.square(sample.eta)
        return engine.rows(si.to_world(sample.wo), n), engine.rows(weight, n).copy()


def _twosided(kind: str, **colors: Array) -> dict[str, Any]:
    plain = {"type": kind, **{name: rgb(color) for name, color in colors.items()}}
    if kind == "conductor" and "eta" not in colors:
        plain["material"] = "none"
    return {"type": "twosided", "inner": plain}


def _rough(of: dict[str, Any], outer: float) -> dict[str, Any]:
    made = {"type": "roughconductor", "distribution": "ggx", "sample_visible": True}
    made["alpha"] = float(of["alpha"])
    if not of["conductor"]:
        return {**made, "material": "none", "specular_reflectance": rgb(np.full(3, float(of["kr"])))}
    index = {"eta": rgb(of["n"] / outer), "k": rgb(of["k"] / outer)}
    return {**made, **index, "specular_reflectance": rgb(of["kr"] * of["M"])}


def _boundary(of: dict[str, Any], outer: float, inner: float) -> dict[str, Any]:
    if of["conductor"]:
        index = {"eta": of["n"] / outer, "k": of["k"] / outer}
        return _twosided("conductor", specular_reflectance=of["kr"] * of["M"], **index)
    tinted = bool(of["fresnel"])
    return {
        "type": "thindielectric" if of["thin"] else "dielectric",
        "int_ior": float(inner),
        "ext_ior": float(outer),
        "specular_reflectance": rgb(of["kr"] * of["M"] if tinted else 1.0),
        "specular_transmittance": rgb(of["kt"] * of["Tt"] if tinted else 1.0),
    }


def _as_plugins(pointers: Array) -> Any:
    return dr.reinterpret_array(mi.BSDFPtr, mi.UInt32(pointers.astype(np.uint32)))


def _pointers(plugins: list[dict[str, Any]], made: dict[str, Any]) -> Array:
    """Plugins as pointers; equal ones are made once, and kept in `made` as long as pointers to them are
    used."""
    for plugin in plugins:
        if repr(plugin) not in made:
            made[repr(plugin)] = engine.load(plugin)
    return np.array([engine.words(mi.BSDFPtr(made[repr(plugin)]), 1)[0] for plugin in plugins])
