"""The float32 twin's light: what a surface sends back, reflects and transmits (docs/model.md)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from clrt import layout
from clrt.flatten.flatten import FlatScene

from .gloss import facet_at
from .lights import LightSample
from .math import ONE, Array, combine, disk, dot, frame_about, larger, mix_bits, power, unit, unit_interval
from .queues import Streams
from .surface import Surface, bands, color_of

EMISSION, AMBIENT, DIFFUSE, HIGHLIGHT, ALL = (
    layout.TERMS[f"TERM_{name}"] for name in ("EMISSION", "AMBIENT", "DIFFUSE", "HIGHLIGHT", "ALL")
)
_ZERO = np.float32(0.0)


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
    seen_instead = (light["surface"] >= 0) & (material["kr"] > 0.0)
    shine = np.where(seen_instead, _ZERO, shine)
    if not terms & HIGHLIGHT:
        shine = np.zeros_like(cosine)
    fade = np.where(_is_schlick(s), schlick(cosine), _ZERO)
    highlight = bands(material["highlight"])
    highlight = highlight + (1.0 - highlight) * fade
    return light["intensity"][:, None] * to.factor * (diffuse * color_of(s) + shine * highlight)


def local_light(flat: FlatScene, s: Surface, gathers: Array, terms: int, ambient: bool) -> Array:
    """e + ka F A, without the ambient term where rays gather it. `ambient`: the rays are ambient ones."""
    emission = bands(s.material["emission"]) if terms & EMISSION else np.zeros_like(color_of(s))
    dark = (s.material["light"] == 1) & s.inside | (s.material["light"] > 0) & ambient
    emission = np.where(dark, _ZERO, emission)
    constant = ambient_share(s) * flat.scene["ambient"][0][:, None]
    if not terms & AMBIENT:
        constant = np.zeros_like(constant)
    return emission + np.where(gathers, _ZERO, constant)


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
    return cosines_at(-dot(n, u), eta_i / eta_t)


def cosines_at(cos_i: Array, eta: Array) -> Refraction:
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


def bounce_at(s: Surface, u: Array, eta_i: Array, eta_t: Array, streams: Streams) -> Bounce:
    """`eta_i`, `eta_t`: indices on the rays' side and behind the surfaces. `streams`: what gloss draws on."""
    material = s.material
    rough = material["alpha"] > 0.0
    facet = facet_at(s.n, s.ns, u, material["alpha"], streams)
    cosine = np.where(rough, facet.cosine, -dot(s.ns, u))
    thin = material["thin"] != 0

    up = mirrored(s.ns, u)
    reflected = np.where(dot(up, s.n) > 0.0, up, mirrored(s.n, u))
    reflected = np.where(rough, facet.direction, reflected)

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

    on_facet = cosines_at(facet.cosine, eta_i / eta_t)
    both = zip(vars(r).values(), vars(on_facet).values(), strict=True)
    share = fresnel(Refraction(*(np.where(rough, b, a) for a, b in both)), eta_i, eta_t)
    share = np.where(eta_i == eta_t, _ZERO, share)
    share = np.where(thin, 2.0 * share / (1.0 + share), share)
    fade = np.where(_is_schlick(s), schlick(cosine), _ZERO)
    mirror = bands(material["mirror"])
    reflect = material["kr"] * (mirror + (1.0 - mirror) * fade)
    reflect = np.where(rough, reflect * facet.passed, reflect)
    transmit = material["kt"] * bands(material["tint"])
    metal = material["fresnel"] == layout.FRESNEL["CONDUCTOR"]
    before = ONE / eta_i
    index = bands(material["eta"]) * before, bands(material["k"]) * before
    share = np.where(metal, conductor(*index, cosine), share)
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
    u1 = unit_interval(mix_bits(key + np.uint32(1)) + index * np.uint32(0xC13FA9A9))
    u2 = unit_interval(mix_bits(key + np.uint32(2)) + index * np.uint32(0x91E10DA5))
    disk_x, disk_y = disk(u1, u2)
    tangent, bitangent = frame_about(n)
    height = np.sqrt(larger(1.0 - disk_x * disk_x - disk_y * disk_y, _ZERO))
    return unit(tangent * disk_x + bitangent * disk_y + n * height)


def ambient_directions(s: Surface, path: Array, samples: int) -> tuple[Array, Array]:
    """Directions (3, n, samples) of the rays that gather ambient light, and the key (n,) that they share."""
    key = combine(path & ~np.uint32(layout.PATH["PATH_FLAGS"]), np.uint32(3))
    index = np.arange(samples, dtype=np.uint32)
    shape = (3, len(key), samples)
    n, ns = np.broadcast_to(s.n[:, :, None], shape), np.broadcast_to(s.ns[:, :, None], shape)
    about = cosine_direction(ns, key[:, None], index)
    return np.where(dot(about, n) > 0.0, about, cosine_direction(n, key[:, None], index)), key
