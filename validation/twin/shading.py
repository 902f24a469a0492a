"""The float32 twin's light: what a surface sends back, reflects and transmits (docs/model.md)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from clrt import layout
from clrt.flatten.flatten import FlatScene

from .math import ONE, Array, combine, dot, larger, mix_bits, power, sine_cosine, unit, unit_interval, vector
from .surface import Surface, bands, color_of

EMISSION, AMBIENT, DIFFUSE, HIGHLIGHT, ALL = (
    layout.TERMS[f"TERM_{name}"] for name in ("EMISSION", "AMBIENT", "DIFFUSE", "HIGHLIGHT", "ALL")
)
_ZERO = np.float32(0.0)


@dataclass(frozen=True)
class LightSample:
    """The way from n points to one light, and the factor (n,) by which its intensity arrives.

    Unit directions (3, n), 0 where it does not shine; distances (n,), infinite where it is directional.
    """

    direction: Array
    distance: Array
    factor: Array


def light_sample(light: np.void, start: Array) -> LightSample:
    """By kind of light, as `kernels/light.clh`."""
    return _SAMPLES[int(light["kind"])](light, start)


def _point(light: np.void, start: Array) -> LightSample:
    way = _place(light, start) - start
    distance = np.sqrt(dot(way, way))
    fades = light["falloff"] == layout.FALLOFF["INVERSE_SQUARE"]
    factor = ONE / (distance * distance) if fades else np.ones_like(distance)
    return LightSample(way * (ONE / distance), distance, factor)


def _directional(light: np.void, start: Array) -> LightSample:
    far = np.full(start.shape[1], np.inf, np.float32)
    return LightSample(_place(light, start), far, np.ones_like(far))


def _place(light: np.void, start: Array) -> Array:
    return np.repeat(light["place"][:3, None], start.shape[1], axis=1)


_SAMPLES = {layout.LIGHT_KINDS["POINT"]: _point, layout.LIGHT_KINDS["DIRECTIONAL"]: _directional}


def is_above(s: Surface, to: LightSample, terms: int) -> Array:
    """Above the surface, both the true and the shaded one, where something scatters."""
    above = (dot(s.n, to.direction) > 0.0) & (dot(s.ns, to.direction) > 0.0)
    coefficients = {DIFFUSE: s.material["kd"], HIGHLIGHT: s.material["ks"]}
    scatters = [coefficient > 0.0 for term, coefficient in coefficients.items() if terms & term]
    return above & np.any(scatters, axis=0)


def schlick(cosine: Array) -> Array:
    """(1 - c)^5, by which Schlick's approximation fades a tint to white at grazing angles."""
    x = 1.0 - cosine
    return x * x * (x * x) * x


def reflected_light(light: np.void, to: LightSample, s: Surface, u: Array, terms: int) -> Array:
    """What the light adds to the radiance where nothing shadows it: I f(r) [kd F (Ns.L) + ks H (R.V)^m]."""
    material = s.material
    cosine = dot(s.ns, to.direction)
    mirror = s.ns * (2.0 * cosine) - to.direction
    aligned = -dot(mirror, u)
    diffuse = material["kd"] * cosine if terms & DIFFUSE else np.zeros_like(cosine)
    shine = np.where(aligned > 0.0, material["ks"] * power(aligned, material["shininess"]), _ZERO)
    if not terms & HIGHLIGHT:
        shine = np.zeros_like(cosine)
    fade = np.where(_is_schlick(s), schlick(cosine), _ZERO)
    highlight = bands(material["highlight"])
    highlight = highlight + (1.0 - highlight) * fade
    return light["intensity"][:, None] * to.factor * (diffuse * color_of(s) + shine * highlight)


def local_light(flat: FlatScene, s: Surface, gathers: Array, terms: int) -> Array:
    """e + ka F A, without the ambient term where rays gather it instead."""
    emission = bands(s.material["emission"]) if terms & EMISSION else np.zeros_like(color_of(s))
    ambient = ambient_share(s) * flat.scene["ambient"][0][:, None]
    if not terms & AMBIENT:
        ambient = np.zeros_like(ambient)
    return emission + np.where(gathers, _ZERO, ambient)


def ambient_share(s: Surface) -> Array:
    """ka F"""
    return s.material["ka"] * color_of(s)


def _is_schlick(s: Surface) -> Array:
    return s.material["fresnel"] == layout.FRESNEL["SCHLICK"]


@dataclass(frozen=True)
class Refraction:
    """Snell at a normal that faces the ray; k < 0 is total internal reflection."""

    eta: Array
    cos_i: Array
    k: Array
    cos_t: Array


def refraction(n: Array, u: Array, eta_i: Array, eta_t: Array) -> Refraction:
    eta = eta_i / eta_t
    cos_i = -dot(n, u)
    k = 1.0 - eta * eta * (1.0 - cos_i * cos_i)
    return Refraction(eta, cos_i, k, np.sqrt(larger(k, _ZERO)))


def refracted(n: Array, u: Array, r: Refraction) -> Array:
    return unit(u * r.eta + n * (r.eta * r.cos_i - r.cos_t))


def mirrored(n: Array, u: Array) -> Array:
    return unit(u - n * (2.0 * dot(n, u)))


def fresnel(r: Refraction, eta_i: Array, eta_t: Array) -> Array:
    """Reflectance of unpolarised light; 1 in total internal reflection."""
    s = (eta_i * r.cos_i - eta_t * r.cos_t) / (eta_i * r.cos_i + eta_t * r.cos_t)
    p = (eta_t * r.cos_i - eta_i * r.cos_t) / (eta_t * r.cos_i + eta_i * r.cos_t)
    return np.where(r.k < 0.0, ONE, (s * s + p * p) * 0.5)


def conductor(eta: Array, k: Array, cosine: Array) -> Array:
    """Unpolarised reflectance of a complex index eta + ik relative to the medium before it, (bands, n)."""
    c2 = cosine * cosine
    s2 = 1.0 - c2
    real, imaginary = eta * eta - k * k - s2, 2.0 * eta * k
    modulus = np.sqrt(real * real + imaginary * imaginary)
    a = np.sqrt(larger(0.5 * (modulus + real), _ZERO))
    across = 2.0 * a * cosine
    along = across * s2
    s = (modulus + c2 - across) / (modulus + c2 + across)
    p = s * ((modulus * c2 + s2 * s2 - along) / (modulus * c2 + s2 * s2 + along))
    return (s + p) * 0.5


@dataclass(frozen=True)
class Bounce:
    """Unit directions (3, n) and the share of the light, a value a band, of reflection and transmission."""

    reflected: Array
    transmitted: Array
    reflect: Array
    transmit: Array
    total_internal: Array  # a transmission was asked for and could not leave


def bounce_at(s: Surface, u: Array, eta_i: Array, eta_t: Array) -> Bounce:
    """`eta_i`, `eta_t`: indices on the rays' side and behind the surfaces."""
    material = s.material
    thin = material["thin"] != 0

    up = mirrored(s.ns, u)
    reflected = np.where(dot(up, s.n) > 0.0, up, mirrored(s.n, u))

    # straight through a thin sheet and between equal indices; what would stay above takes the true normal
    straight = thin | (eta_i == eta_t)
    shaded, true = refraction(s.ns, u, eta_i, eta_t), refraction(s.n, u, eta_i, eta_t)
    down = refracted(s.ns, u, shaded)
    stays = ~straight & (shaded.k >= 0.0) & ~(dot(down, s.n) < 0.0)
    r = Refraction(
        *(np.where(stays, b, a) for a, b in zip(vars(shaded).values(), vars(true).values(), strict=True))
    )
    transmitted = np.where(straight, u, np.where(stays, refracted(s.n, u, true), down))
    total_internal = (material["kt"] > 0.0) & ~straight & (r.k < 0.0)

    share = np.where(eta_i == eta_t, _ZERO, fresnel(r, eta_i, eta_t))
    share = np.where(thin, 2.0 * share / (1.0 + share), share)
    fade = np.where(_is_schlick(s), schlick(-dot(s.ns, u)), _ZERO)
    mirror = bands(material["mirror"])
    reflect = material["kr"] * (mirror + (1.0 - mirror) * fade)
    transmit = material["kt"] * bands(material["tint"])
    metal = material["fresnel"] == layout.FRESNEL["CONDUCTOR"]
    before = ONE / eta_i
    index = bands(material["eta"]) * before, bands(material["k"]) * before
    share = np.where(metal, conductor(*index, -dot(s.ns, u)), share)
    split = metal | (material["fresnel"] == layout.FRESNEL["FRESNEL"])
    return Bounce(
        reflected,
        transmitted,
        np.where(split, reflect * share, np.where(total_internal, reflect + transmit, reflect)),
        np.where(total_internal, _ZERO, np.where(split, transmit * (1.0 - share), transmit)),
        total_internal,
    )


def cosine_direction(n: Array, key: Array, index: Array) -> Array:
    """Direction `index` of a cosine-distributed set about n: the R2 sequence (Roberts 2018) plus a hash."""
    x = 2.0 * unit_interval(mix_bits(key + np.uint32(1)) + index * np.uint32(0xC13FA9A9)) - 1.0
    y = 2.0 * unit_interval(mix_bits(key + np.uint32(2)) + index * np.uint32(0x91E10DA5)) - 1.0
    disk_x, disk_y = _concentric(x, y)
    sign = np.where(n[2] < 0.0, -ONE, ONE)
    a = -1.0 / (sign + n[2])
    b = n[0] * n[1] * a
    tangent = vector(1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0])
    bitangent = vector(b, sign + n[1] * n[1] * a, -n[1])
    height = np.sqrt(larger(1.0 - disk_x * disk_x - disk_y * disk_y, _ZERO))
    return unit(tangent * disk_x + bitangent * disk_y + n * height)


def _concentric(x: Array, y: Array) -> tuple[Array, Array]:
    """The square [-1, 1]^2 onto the disk (Shirley and Chiu 1997)."""
    wide = np.abs(x) > np.abs(y)
    radius, ratio = np.where(wide, x, y), np.where(wide, y / x, x / y)
    sine, cosine = sine_cosine(0.785398163 * ratio)
    along, across = radius * cosine, radius * sine
    center = ~wide & (y == 0.0)
    return np.where(center, _ZERO, np.where(wide, along, across)), np.where(
        center, _ZERO, np.where(wide, across, along)
    )


def ambient_directions(s: Surface, path: Array, samples: int) -> tuple[Array, Array]:
    """Directions (3, n, samples) of the rays that gather ambient light, and the key (n,) that they share."""
    key = combine(path & ~np.uint32(layout.PATH["PATH_FLAGS"]), np.uint32(3))
    index = np.arange(samples, dtype=np.uint32)
    shape = (3, len(key), samples)
    n, ns = np.broadcast_to(s.n[:, :, None], shape), np.broadcast_to(s.ns[:, :, None], shape)
    about = cosine_direction(ns, key[:, None], index)
    return np.where(dot(about, n) > 0.0, about, cosine_direction(n, key[:, None], index)), key
