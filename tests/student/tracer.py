"""A student's ray tracer, with a fault to order: what `clrt validate --against` is tried on.

    python tracer.py SCENE.toml OUT.exr [--fault NAME]

Written from docs/model.md alone, in float64 numpy, and imports nothing of clrt. It knows spheres and planes,
point and directional lights, Phong's model, mirrors and glass with constant shares. FAULTS names what it can
be made to do wrong; each stands where a student would have made the mistake.
"""

from __future__ import annotations

import argparse
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

FAULTS = (
    "no shadows", "normals inwards", "falloff by the distance", "no falloff", "refraction inverted",
    "no refraction", "gamma applied", "upside down", "mirrored", "wrong fov axis", "fov not halved",
    "no specular", "wrong exponent", "depth off by one", "ambient missing", "ambient twice",
    "second light lost", "no reflection", "no transmission", "pixel corners", "channels swapped",
    "background black", "emission missing", "too dark", "turned", "a shape is lost",
)  # fmt: skip
EPSILON = 1e-6


def unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.sum(a * b, axis=-1, keepdims=True)


def colour(value: Any) -> np.ndarray:
    return np.broadcast_to(np.asarray(value, float), 3)


class Tracer:
    def __init__(self, scene: dict[str, Any], fault: str) -> None:
        self.scene, self.fault = scene, fault
        self.shapes = scene["shapes"][:-1] if fault == "a shape is lost" else scene["shapes"]
        self.lights = scene.get("lights", [])
        if fault == "second light lost":
            self.lights = self.lights[:1]
        self.depth = scene.get("max_depth", 5) - (fault == "depth off by one")
        self.sky = colour(0 if fault == "background black" else scene.get("background", 0))
        share = {"ambient missing": 0.0, "ambient twice": 2.0}.get(fault, 1.0)
        self.ambient = share * colour(scene.get("ambient", 0))

    def picture(self) -> np.ndarray:
        camera = self.scene["camera"]
        width, height = camera["width"], camera["height"]
        origin, target = np.array(camera["origin"], float), np.array(camera["target"], float)
        forward = unit(target - origin)
        right = unit(np.cross(forward, camera.get("up", [0, 1, 0])))
        up = np.cross(right, forward)
        offset = 0.0 if self.fault == "pixel corners" else 0.5
        x = 2 * (np.arange(width) + offset) / width - 1
        y = 1 - 2 * (np.arange(height) + offset) / height
        angle = np.radians(camera.get("fov", 45))
        tangent = np.tan(angle if self.fault == "fov not halved" else angle / 2)
        across, down = tangent, tangent * height / width
        if (camera.get("fov_axis", "horizontal") == "vertical") != (self.fault == "wrong fov axis"):
            across, down = tangent * width / height, tangent
        d = forward + across * x[None, :, None] * right + down * y[:, None, None] * up
        d = unit(d).reshape(-1, 3)
        pixels = self.radiance(np.broadcast_to(origin, d.shape), d, 0).reshape(height, width, 3)
        return self.finished(pixels)

    def finished(self, pixels: np.ndarray) -> np.ndarray:
        changes = {
            "upside down": lambda p: p[::-1], "mirrored": lambda p: p[:, ::-1],
            "turned": lambda p: p[::-1, ::-1],
            "channels swapped": lambda p: p[..., ::-1], "too dark": lambda p: p * 0.5,
            "gamma applied": lambda p: np.where(p <= 0.0031308, 12.92 * p,
                                                1.055 * np.maximum(p, 1e-9) ** (1 / 2.4) - 0.055),
        }  # fmt: skip
        return changes.get(self.fault, lambda p: p)(pixels)

    def nearest(self, o: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        best, which = np.full(len(o), np.inf), np.full(len(o), -1)
        for number, shape in enumerate(self.shapes):
            t = self.meet(shape, o, d)
            closer = t < best
            best, which = np.where(closer, t, best), np.where(closer, number, which)
        return best, which

    def meet(self, shape: dict[str, Any], o: np.ndarray, d: np.ndarray) -> np.ndarray:
        with np.errstate(all="ignore"):
            if shape["type"] == "plane":
                normal = unit(np.array(shape["normal"], float))
                t = ((shape["point"] - o) @ normal) / (d @ normal)
                return np.where(t > EPSILON, t, np.inf)
            assert shape["type"] == "sphere", f"{shape['type']}: not known"
            to = o - np.array(shape["center"], float)
            b, c = np.sum(to * d, -1), np.sum(to * to, -1) - shape["radius"] ** 2
            root = np.sqrt(b * b - c)
            near, far = -b - root, -b + root
            return np.where(near > EPSILON, near, np.where(far > EPSILON, far, np.inf))

    def normal(self, shape: dict[str, Any], p: np.ndarray) -> np.ndarray:
        if shape["type"] == "plane":
            return np.broadcast_to(unit(np.array(shape["normal"], float)), p.shape)
        return unit(p - np.array(shape["center"], float))

    def radiance(self, o: np.ndarray, d: np.ndarray, generation: int) -> np.ndarray:
        result = np.tile(self.sky, (len(o), 1))
        t, which = self.nearest(o, d)
        for number, shape in enumerate(self.shapes):
            on = which == number
            if on.any():
                result[on] = self.shade(shape, o[on], d[on], t[on], generation)
        return result

    def shade(
        self, shape: dict[str, Any], o: np.ndarray, d: np.ndarray, t: np.ndarray, generation: int
    ) -> Any:
        material = shape.get("material", {})
        if isinstance(material, str):
            material = self.scene["materials"][material]
        p, outward = o + t[:, None] * d, self.normal(shape, o + t[:, None] * d)
        inside = dot(outward, d) > 0
        n = np.where(inside, -outward, outward)
        if self.fault == "normals inwards" and shape["type"] == "sphere":
            n = -n
        base, kd = colour(material.get("color", 0.8)), material.get("diffuse", 1.0)
        light = material.get("ambient", kd) * base * self.ambient
        if self.fault != "emission missing":
            light = light + colour(material.get("emission", 0))
        light = np.tile(light, (len(p), 1))
        for lamp in self.lights:
            light += self.lit(lamp, material, base, kd, p, n, d)
        kr, kt = material.get("reflection", 0.0), material.get("transmission", 0.0)
        if generation >= self.depth or not (kr or kt):
            return light
        bounced = d - 2 * dot(n, d) * n
        weight = np.full((len(p), 1), kr)
        if kt and self.fault != "no transmission":
            ior = {"glass": 1.5, "water": 1.333, "diamond": 2.419}.get(
                material.get("ior", 1.5), material.get("ior", 1.5))  # fmt: skip
            eta = np.where(inside, ior, 1 / ior)
            if self.fault == "refraction inverted":
                eta = 1 / eta
            if self.fault == "no refraction":
                eta = np.ones_like(eta)
            cosine = -dot(n, d)
            k = 1 - eta**2 * (1 - cosine**2)
            through = (k >= 0)[:, 0]
            weight = weight + np.where(k < 0, kt, 0.0)
            bent = unit(eta * d + (eta * cosine - np.sqrt(np.maximum(k, 0))) * n)
            if through.any():
                start = p[through] - EPSILON * n[through]
                light[through] += kt * self.radiance(start, bent[through], generation + 1)
        weight = weight * (self.fault != "no reflection")
        seen = weight[:, 0] > 0
        if seen.any():
            start = p[seen] + EPSILON * n[seen]
            light[seen] += weight[seen] * self.radiance(start, bounced[seen], generation + 1)
        return light

    def lit(self, lamp: Any, material: Any, base: Any, kd: float, p: Any, n: Any, d: Any) -> np.ndarray:
        if lamp["type"] == "directional":
            to = np.broadcast_to(-unit(np.array(lamp["direction"], float)), p.shape)
            distance = np.full((len(p), 1), np.inf)
        else:
            way = np.array(lamp["position"], float) - p
            distance = np.linalg.norm(way, axis=-1, keepdims=True)
            to = way / distance
        strength = colour(lamp.get("intensity", 1))
        if lamp.get("falloff", "none") == "inverse-square" and self.fault != "no falloff":
            strength = strength / (distance if self.fault == "falloff by the distance" else distance**2)
        cosine = dot(n, to)
        brings = (cosine > 0)[:, 0]
        if self.fault != "no shadows":
            blocked, _ = self.nearest(p + EPSILON * n, to)
            brings &= ~(blocked < distance[:, 0])
        mirrored = 2 * cosine * n - to
        aligned = np.maximum(dot(mirrored, -d), 0)
        exponent = material.get("shininess", 32) * (2 if self.fault == "wrong exponent" else 1)
        specular = 0 if self.fault == "no specular" else material.get("specular", 0)
        shine = (
            specular
            * colour(material.get("highlight_color", 1))
            * np.where(aligned > 0, aligned**exponent, 0)
        )
        return np.where(brings[:, None], strength * (kd * base * cosine + shine), 0.0)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("scene", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--fault", choices=FAULTS, default="")
    options = parser.parse_args()
    pixels = Tracer(tomllib.loads(options.scene.read_text()), options.fault).picture().astype(np.float32)
    import OpenImageIO as oiio

    png = options.out.suffix == ".png"
    if png:
        p = np.clip(pixels, 0, 1)
        pixels = np.where(p <= 0.0031308, 12.92 * p, 1.055 * np.maximum(p, 1e-9) ** (1 / 2.4) - 0.055)
    out = oiio.ImageOutput.create(str(options.out))
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], 3, oiio.UINT8 if png else oiio.FLOAT)
    out.open(str(options.out), spec)
    out.write_image(np.ascontiguousarray(pixels, np.float32))
    out.close()


if __name__ == "__main__":
    main()
