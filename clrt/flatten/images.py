"""Pictures on surfaces as the device reads them: texels in a row, and how each material shows them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from clrt import layout
from clrt.base.files import version
from clrt.base.places import At
from clrt.images.levels import halved, level_sizes
from clrt.images.texture import Role, finished, read_plain, texture_bytes
from clrt.scene.scene import ImageTexture, Material, NormalMap, Placement, Scene
from clrt.scene.textures import picture_path
from clrt.spectra.bands import Bands, reflectance

_NONE: Final = -1
_MIPMAP: Final = "mipmap"
_CHANNELS: Final = 3

Tint = tuple[float, float, float]
Source = tuple[Path, Role, str | None, int | None, Tint]
"""A picture's file, what its numbers are for, their encoding (None: that of such a file), which part of the
file it is (None: all), and what multiplies it."""


@dataclass(frozen=True)
class Pictures:
    """Pictures that were read: of each its first texel, height and width, and the texels, float32.

    levels: which have mip levels; their texels follow, level after level. versions: of their files.
    """

    sources: tuple[Source, ...]
    levels: tuple[bool, ...]
    versions: tuple[tuple[int, ...] | None, ...]
    sizes: np.ndarray
    texels: np.ndarray


class TextureTable:
    """The distinct pictures of a scene's materials, numbered as they come up."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._numbers: dict[tuple[Source, ImageTexture | Placement], int] = {}

    def record(self, material: Material) -> np.ndarray:
        """The record Pictured of a material, shape (1,)."""
        out = np.zeros(1, layout.dtype("Pictured"))
        record = out[0]
        for field, name in layout.PICTURES.items():
            value = getattr(material, name)
            role: Role = "light" if field == "emission" else "reflectance"
            record[field] = self._number(value, role, value) if isinstance(value, ImageTexture) else _NONE
        record["normal_map"] = _NONE
        if material.normal_map is not None:
            of = material.normal_map
            like = material.color if isinstance(material.color, ImageTexture) else ImageTexture(file=of.file)
            record["normal_map"] = self._number(of, "normal", of.placement or like)
            record["normal_scale"] = of.scale
        return out

    def _number(
        self, picture: ImageTexture | NormalMap, role: Role, like: ImageTexture | Placement
    ) -> int:
        path = picture_path(picture, self._scene.folder, At(self._scene.source))
        tint: Tint = getattr(picture, "tint", (1.0, 1.0, 1.0))
        source: Source = path, role, getattr(picture, "encoding", None), picture.part, tint
        return self._numbers.setdefault((source, like), len(self._numbers))

    def sections(self, known: Pictures | None, bands: Bands | None) -> tuple[dict[str, np.ndarray], Pictures]:
        """The sections `textures`, `texels` and `primaries`, and what was read; `known` is not read again
        where its files are what they were.
        """
        sources = tuple(dict.fromkeys(source for source, _ in self._numbers))
        shrunk = {source for source, how in self._numbers if how.filter == _MIPMAP}
        levels = tuple(source in shrunk for source in sources)
        versions = tuple(version(path) for path, *_ in sources)
        pictures = known
        if pictures is None or (pictures.sources, pictures.levels) != (sources, levels) or (
            None in versions or pictures.versions != versions
        ):  # fmt: skip
            pictures = replace(_read(sources, levels, self._scene), versions=versions)
        places = {source: number for number, source in enumerate(pictures.sources)}
        out = np.zeros(len(self._numbers), layout.dtype("Texture"))
        for record, (source, how) in zip(out, self._numbers, strict=True):
            record["first"], record["height"], record["width"] = pictures.sizes[places[source]]
            record["wrap"] = layout.WRAP[f"WRAP_{how.wrap.upper()}"]
            record["nearest"] = how.filter == "nearest"
            record["scale_u"], record["scale_v"] = how.scale
            record["offset_u"], record["offset_v"] = how.offset
        out = _with_levels(out, [how.filter == _MIPMAP for _, how in self._numbers])
        primaries = np.zeros(1, layout.dtype("Primaries", layout.BANDS if bands is None else bands.n))
        for number, name in enumerate(("red", "green", "blue")):
            one = [0.0, 0.0, 0.0]
            one[number] = 1.0
            primaries[name] = reflectance((one[0], one[1], one[2]), bands)
        return {"textures": out, "texels": pictures.texels, "primaries": primaries}, pictures


def _with_levels(textures: np.ndarray, levels: list[bool]) -> np.ndarray:
    """The records of textures, and behind them those of the mip levels of some."""
    out = [textures]
    count = len(textures)
    for number in np.flatnonzero(levels).tolist():
        record = textures[number]
        sizes = level_sizes(int(record["height"]), int(record["width"]))
        own = np.repeat(textures[number : number + 1], len(sizes))
        before = int(record["height"]) * int(record["width"])
        for level, size in zip(own, sizes, strict=True):
            level["first"] = record["first"] + before
            level["height"], level["width"] = size
            before += size[0] * size[1]
        record["levels"], record["smaller"] = len(sizes), count - number
        out.append(own)
        count += len(own)
    return np.concatenate(out)


def _read(sources: tuple[Source, ...], levels: tuple[bool, ...], scene: Scene) -> Pictures:
    """The pictures, whose sizes are checked together before one is read."""
    from clrt.meshfiles.pictures import PictureFiles  # knows all files of models; most scenes have none

    limits, files = scene.limits, PictureFiles(scene.limits)
    alike: dict[tuple[Any, ...], list[int]] = {}  # what differs in its tint alone is read once
    for number, (path, role, encoding, part, _) in enumerate(sources):
        alike.setdefault((path, part, role, encoding), []).append(number)
    headers: dict[tuple[Path, int | None, bool], int] = {}
    wanted = [(source[0], source[3], shrunk) for source, shrunk in zip(sources, levels, strict=True)]
    for path, part, shrunk in dict.fromkeys(wanted):
        with files.file(path, part) as file:
            headers[path, part, shrunk] = texture_bytes(file, limits, shrunk)
    total = sum(headers[key] for key in wanted)
    limits.check("texture_bytes", total, scene.source, "materials")
    # in one piece from the start, or all of them would be held twice; lanes read four numbers of a texel
    texels = np.zeros(total // 4 + 1, np.float32)
    sizes = np.zeros((len(sources), 3), np.int64)
    first = 0
    for (path, part, role, encoding), numbers in alike.items():
        corners = files.corners(path, part)
        with files.file(path, part) as file:
            plain = read_plain(file, role, encoding, limits)
            count = plain.shape[0] * plain.shape[1]
            smaller = sum(height * width for height, width in level_sizes(*plain.shape[:2]))
            end = _CHANNELS * (first + sum(count + levels[number] * smaller for number in numbers))
            # the file may be another one by now
            limits.check("texture_bytes", 4 * end, scene.source, "materials")
            texels.resize(max(len(texels), end + 1), refcheck=False)
            for number in numbers:
                own = plain if number == numbers[-1] else plain.copy()
                own = finished(own, role, sources[number][-1], str(path if corners else file), corners)
                sizes[number] = first, *own.shape[:2]
                for more in range(1 + levels[number] * len(level_sizes(*own.shape[:2]))):
                    own = halved(own) if more else own
                    texels[_CHANNELS * first : _CHANNELS * first + own.size] = own.reshape(-1)
                    first += own.size // _CHANNELS
                del own
            del plain  # before the next is read
    return Pictures(sources, levels, (), sizes, texels)
