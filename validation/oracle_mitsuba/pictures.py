"""What pictures show on surfaces, by Mitsuba's own `bitmap`, and normals that maps bend (worker process)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from . import engine
from .engine import dr, mi
from .footprints import reaches, smaller
from .palette import Bands, Colors
from .places import Chart, chart
from .records import NormalMap, Picture, Scene
from .shapes import Mesh
from .world import Hits

Array = np.ndarray
COLORS = {"F": "color", "H": "highlight_color", "M": "reflection_color", "Tt": "transmission_color",
          "e": "emission"}  # fmt: skip
MIDDLE = {8: 128.0, 16: 32768.0}  # of the whole numbers of a normal map: what stands for 0


class Pictures:
    """The pictures of a scene's materials, as hits see them."""

    def __init__(self, scene: Scene, palette: Colors | Bands) -> None:
        self.scene, self.palette = scene, palette
        self.folder = Path(scene.folder or ".")
        materials = [scene.material_of(shape) for shape in scene.shapes]
        self.shown = [number for number, material in enumerate(materials) if material.pictures]
        self._textures: dict[tuple[Any, ...], Any] = {}

    def tones(self, plain: dict[str, Array], u: Array, width: Array, hits: Hits) -> dict[str, Array]:
        """The colours COLORS (n, 3) at hits of rays `u`; `plain`: those of materials without pictures.

        width: of the rays' cones there, (n,).
        """
        found = {name: np.array(values) for name, values in plain.items()}
        for number in self.shown:
            rows = np.flatnonzero(hits.shape == number)
            material = self.scene.material_of(self.scene.shapes[number])
            asked = {name: getattr(material, key) for name, key in COLORS.items()}
            asked = {name: value for name, value in asked.items() if isinstance(value, Picture)}
            if rows.size and asked:
                here = hits.take(rows)
                at = self._chart(number, here)
                reach = reaches(at, here.outward, u[rows], width[rows])
                for name, picture in asked.items():
                    if picture.part is None:
                        rgb = self._at_levels(self._colors(picture, name == "e"), picture, at, reach)
                    else:
                        rgb = hits.chart[rows, 8:] * np.array(picture.tint)
                    shown = self.palette.shines if name == "e" else self.palette.reflects
                    found[name][rows] = shown(rgb)
        return found

    def bent(self, ns: Array, n: Array, u: Array, width: Array, hits: Hits) -> Array:
        """Shading normals (n, 3) of rays `u` as maps bend them; `ns`, `n` are on the rays' side.

        width: as for `tones`.
        """
        found = ns.copy()
        for number in self.shown:
            material = self.scene.material_of(self.scene.shapes[number])
            rows = np.flatnonzero(hits.shape == number)
            if material.normal_map is None or not rows.size:
                continue
            here = hits.take(rows)
            at = self._chart(number, here)
            like = material.color if isinstance(material.color, Picture) else Picture("")
            like = material.normal_map.placement or like
            reach = reaches(at, here.outward, u[rows], width[rows])
            texel = np.maximum(self._at_levels(self._normals(material.normal_map), like, at, reach), -1.0)
            lean = texel[:, :2] * material.normal_map.scale
            new = _tilted(np.c_[lean, texel[:, 2]], here.shading, at)
            new = np.where(_dot(new, n[rows]) < 0, -new, new)
            flat = ~lean.any(axis=1) & (texel[:, 2] > 0)
            stays = ~(_dot(new, u[rows])[:, 0] < 0) | flat
            found[rows] = np.where(stays[:, None], ns[rows], new)
        return found

    def _chart(self, number: int, hits: Hits) -> Chart:
        shape = self.scene.shapes[number]
        if isinstance(shape, Mesh):
            u, v = hits.chart[:, :2].T
            return Chart(u, v, hits.chart[:, 2:5], hits.chart[:, 5:8])
        return chart(shape, hits.point, hits.outward)

    def _at_levels(self, texels: Array, how: Picture, at: Chart, reach: Array) -> Array:
        """What a picture shows where footprints reach so far in u and v, (n, 2)."""
        if how.filter != "mipmap":
            return self._looked_up(texels, how, at)
        key = "levels", id(texels)
        levels = self._textures.setdefault(key, None) or smaller(texels)
        self._textures[key] = levels
        height, width = texels.shape[:2]
        x = np.max(reach * np.abs(how.scale) * np.array([width, height]), axis=1)
        x = np.clip(np.where(np.isnan(x), np.inf, x), 1, 2.0 ** (len(levels) - 1))
        first = np.minimum(np.floor(np.log2(x)).astype(int), len(levels) - 1)
        found = np.zeros((len(x), 3))
        for number, level in enumerate(levels):
            share = x / 2.0**first - 1
            weight = np.where(first == number, 1 - share, np.where(first == number - 1, share, 0.0))
            rows = np.flatnonzero(weight)
            if rows.size:
                part = Chart(*(getattr(at, name)[rows] for name in ("u", "v", "du", "dv")))
                found[rows] += weight[rows, None] * self._looked_up(level, how, part)
        return found

    def _looked_up(self, texels: Array, how: Picture, at: Chart) -> Array:
        """What Mitsuba's `bitmap` shows of numbers (h, w, 3), as they are, (n, 3)."""
        known = self._textures.setdefault((id(texels), how.wrap, how.filter), None)
        if known is None:
            plugin = {"type": "bitmap", "bitmap": texels, "raw": True, "wrap_mode": how.wrap,
                      "filter_type": "nearest" if how.filter == "nearest" else "bilinear"}  # fmt: skip
            known = self._textures[id(texels), how.wrap, how.filter] = engine.load(plugin)
        si = dr.zeros(mi.SurfaceInteraction3f, len(at.u))
        stated = zip((at.u, at.v), how.scale, how.offset, strict=True)
        places = (np.nan_to_num(each) * scale + offset for each, scale, offset in stated)
        # moved by whole pictures in float64, where float32 is finest
        whole = {"repeat": 1.0, "mirror": 2.0}.get(how.wrap)
        near = [place if whole is None else place % whole for place in places]
        si.uv = mi.Point2f(*(mi.Float(np.ascontiguousarray(place, np.float32)) for place in near))
        return engine.rows(known.eval(si), len(at.u))

    def _colors(self, picture: Picture, light: bool) -> Array:
        key = "colors", picture.file, picture.encoding, picture.tint, light
        if key not in self._textures:
            bitmap = mi.Bitmap(str(self.folder / picture.file))
            if picture.encoding is not None:
                bitmap.set_srgb_gamma(picture.encoding == "srgb")
            linear = bitmap.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False)
            most = np.inf if light else 1.0
            self._textures[key] = np.clip(np.array(linear) * np.array(picture.tint), 0.0, most)
        return np.asarray(self._textures[key])

    def _normals(self, of: NormalMap) -> Array:
        key = "normals", of.file
        if key not in self._textures:
            samples = np.array(mi.Bitmap(str(self.folder / of.file)))
            samples = samples.reshape(*samples.shape[:2], -1)
            samples = np.broadcast_to(samples[..., :3] if samples.shape[2] > 2 else samples[..., :1],
                                      (*samples.shape[:2], 3))  # fmt: skip
            middle = MIDDLE.get(8 * samples.itemsize) if samples.dtype.kind == "u" else None
            values = samples.astype(float)
            self._textures[key] = 2 * values - 1 if middle is None else (values - middle) / (middle - 1)
        return np.asarray(self._textures[key])


def _tilted(texel: Array, normal: Array, at: Chart) -> Array:
    """Unit normals (n, 3): x along u, y up in the picture, z along `normal`, outward."""
    sign = np.where(normal[:, 2] < 0, -1.0, 1.0)  # Duff's frame where u has no way
    a = -1 / (sign + normal[:, 2])
    other = np.stack([1 + sign * normal[:, 0] ** 2 * a, sign * normal[:, 0] * normal[:, 1] * a,
                      -sign * normal[:, 0]], -1)  # fmt: skip
    with np.errstate(all="ignore"):
        along = at.du - _dot(at.du, normal) * normal
        along /= np.linalg.norm(along, axis=1, keepdims=True)
    along = np.where(np.isfinite(along).all(axis=1, keepdims=True), along, other)
    with np.errstate(all="ignore"):
        hand = np.where(_dot(np.cross(at.du, at.dv), normal) < 0, 1.0, -1.0)
    new = texel[:, :1] * along + texel[:, 1:2] * hand * np.cross(normal, along) + texel[:, 2:] * normal
    with np.errstate(invalid="ignore"):  # of length 0: no way, and not towards the ray
        return np.asarray(new / np.linalg.norm(new, axis=1, keepdims=True))


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.sum(a * b, axis=1, keepdims=True))
