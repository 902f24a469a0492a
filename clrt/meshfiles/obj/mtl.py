"""Materials of MTL files, which go with OBJ files, as tables of a scene file."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from clrt.base.errors import show
from clrt.base.mark import unmarked
from clrt.images.file import KINDS
from clrt.meshfiles.broken import BrokenMesh
from clrt.meshfiles.facets import Facets, Rgb, shown, unlit
from clrt.meshfiles.look import Table, not_there
from clrt.meshfiles.obj.lines import words_of
from clrt.meshfiles.obj.maps import Beside, finite, normals_of, texture

_MIRRORS: Final = (3, 5, 8)  # models of illumination with reflections
_GLASSES: Final = (4, 6, 7, 9)
_BENDING: Final = (6, 7)  # the others many programs write for all materials, with Tf 1 1 1
_ROUNDED: Final = 0.01  # by which d and 1 - Tr of one material may differ
_FRESNEL: Final = 5
_PASSED_OVER: Final = ("ka", "sharpness", "map_ka", "map_ks", "map_ns", "aniso", "anisor")
_OTHERS: Final = {
    "map_d": "transparency in textures", "map_tr": "transparency in textures", "bump": "bump maps",
    "map_bump": "bump maps", "disp": "displacement", "decal": "decals", "refl": "reflection maps",
    "map_pr": "textures of roughness and metal", "map_pm": "textures of roughness and metal",
    "ps": "sheen", "pc": "clearcoat", "pcr": "clearcoat",
}  # fmt: skip


@dataclass
class Phong:
    """A material as an MTL file states it; None where it says nothing."""

    kd: Rgb | None = None
    ks: Rgb = (0.0, 0.0, 0.0)
    ke: Rgb = (0.0, 0.0, 0.0)
    tf: Rgb | None = None
    ns: float = 10.0
    ni: float = 1.5
    dissolve: float | None = None
    tr: float | None = None
    illum: int = 2
    pr: float | None = None
    pm: float | None = None
    map_kd: Table | None = None
    textured: bool = False  # whether a map_Kd stands there, whatever becomes of it
    map_ke: Table | None = None
    glowing: bool = False  # likewise of a map_Ke
    norm: Table | None = None
    left_out: dict[str, None] = field(default_factory=dict)

    def with_pictures(self, beside: Beside, shows: Callable[[str], bool]) -> Phong:
        """The material with the names of pictures as a scene has them, without those that are not there, and
        those of a kind that is not read: what `shows` says of a file."""
        files: dict[str, Table | None] = {}
        for key in ("map_kd", "map_ke", "norm"):
            picture = getattr(self, key)
            if picture is not None:
                name = picture["file"]
                file = beside(name) or beside(name.partition(" #")[0])  # a comment, if it is no letter of it
                if file is None:
                    self.left_out[not_there(picture["file"])] = None
                elif not shows(file):
                    self.left_out[f"the picture {show(file[:60])} (no {KINDS})"] = None
                    file = None
                files[key] = None if file is None else picture | {"file": file}
        return replace(self, **files)  # type: ignore[arg-type]

    @property
    def pictured(self) -> bool:
        """Whether it shows pictures, which need uv."""
        return any(picture is not None for picture in (self.map_kd, self.map_ke, self.norm))

    def table(self, uv: bool) -> Table:
        """The material, as a scene file has it; without pictures where what has it has no uv."""
        if self._inverse:
            self.left_out["Tr 1 without d, which would leave nothing that is seen"] = None
        elif self.tr is not None and not math.isclose(self.d, 1.0 - self.tr, abs_tol=_ROUNDED):
            self.left_out[f"Tr {self.tr:g}, which contradicts d {self.d:g}"] = None
        if self.textured and self.kd is not None and not any(self.kd):
            self.left_out["Kd 0 0 0, which would leave a map_Kd black"] = None
        if not uv and self.pictured:
            return replace(self, map_kd=None, map_ke=None, norm=None).table(True)
        light = (1.0, 1.0, 1.0) if self.map_ke is not None and not any(self.ke) else self.ke
        if self.glowing and self.map_ke is None and any(light):
            self.left_out["the light of what glows by a picture that is left out"] = None
            light = (0.0, 0.0, 0.0)
        if self.pr is not None or self.pm is not None:
            facets = self._facets(light)
            self.left_out |= dict.fromkeys(facets.lost)
            return facets.table()
        if self.illum == 0:
            return unlit(self.map_kd, self._base, self.d)
        table: Table = {"color": shown(self.map_kd, self._base)}
        table |= {"emission": shown(self.map_ke, light)} if any(light) else {}
        table |= {"normal_map": normals_of(self.norm)} if self.norm is not None else {}
        if self.illum != 1 and any(self.ks):
            strength = max(self.ks)
            tint = [part / strength for part in self.ks]
            table |= {"specular": strength, "highlight_color": tint, "shininess": max(self.ns / 4, 1.0)}
            if self.illum in _MIRRORS:
                table |= {"reflection": strength, "reflection_color": tint}
            if self.illum == _FRESNEL:
                table |= {"fresnel": "schlick", "reflection": 1.0, "reflection_color": list(self.ks)}
        return table | self._passing()

    @property
    def d(self) -> float:
        """How opaque it is: what `d` says, wherever it stands, for many programs write `Tr` as if it were
        `d`."""
        if self.dissolve is not None:
            return self.dissolve
        return 1.0 if self.tr is None or self._inverse else 1.0 - self.tr

    @property
    def _inverse(self) -> bool:
        """Whether `Tr` alone would leave nothing that is seen: many programs write so what is opaque."""
        return self.dissolve is None and self.tr == 1

    @property
    def _base(self) -> Rgb:
        """The diffuse colour, which multiplies a picture: where a file has that alone, it is 1, and so where
        nothing would be seen of the picture, as Maya writes it."""
        stated = self.kd is not None and (any(self.kd) or not self.textured)
        return self.kd if stated and self.kd else (0.8, 0.8, 0.8) if self.map_kd is None else (1.0, 1.0, 1.0)

    @property
    def _clear(self) -> bool:
        """Whether all light passes but for what `Tf` takes."""
        lets = self.d == 1 and self.tf is not None and any(self.tf)
        dark = not self.textured and self.kd is not None and not any(self.kd)
        return lets and (self.illum in _BENDING or (self.illum in _GLASSES and dark))

    def _passing(self) -> Table:
        """What of the table is of light that passes."""
        glass = self.illum in _GLASSES
        share = 1.0 if self._clear else 1.0 - self.d
        if share <= 0:
            return {}
        table: Table = {"diffuse": 1.0 - share, "transmission": share}
        if glass and self.tf is not None:
            table["transmission_color"] = list(self.tf)
        if self.illum not in _BENDING:
            return table | {"thin": True}
        return table | {"ior": self.ni, "fresnel": self.illum == max(_BENDING)}

    def _facets(self, emission: Rgb) -> Facets:
        by_exponent = 1.0 - math.sqrt(min(self.ns, 1000.0) / 1000.0)  # as Blender writes it
        return Facets(
            base=self.tf if self._clear and self.tf is not None else self._base,
            metallic=min(self.pm or 0.0, 1.0),
            roughness=by_exponent if self.pr is None else min(self.pr, 1.0),
            ior=self.ni,
            alpha=self.d,
            transmission=float(self._clear),
            solid=self.illum in _BENDING,
            emission=emission,
            picture=None if self._clear else self.map_kd,
            glow=self.map_ke,
            normal_map=None if self.norm is None else normals_of(self.norm),
        )


def read_mtl(data: bytes, name: str) -> dict[bytes, Phong]:
    """The materials in an MTL file by name, as `name_of` has it; BrokenMesh names file and line.

    Of pictures the files are as it names them: a file may name many, of which few are used.
    """
    found: dict[bytes, Phong] = {}
    current: bytes | None = None
    # lines and words of bytes: a text has far more characters that end a line, or are space
    for number, line in enumerate(unmarked(data).splitlines(), 1):
        words = words_of(line)
        key = text_of(words[0]).lower() if words else ""
        if key == "newmtl":
            current = name_of(words[1:])
            found[current] = Phong(left_out=earlier(current) if current in found else {})
        elif current is not None and key:
            try:
                _say(found[current], key, [text_of(word) for word in words[1:]])
            except (ValueError, IndexError, OverflowError):
                text = f"{show(text_of(line).strip()[:60])} is not understood"
                raise BrokenMesh(f"{show(name[:60])}, line {number}: {text}") from None
    return found


def name_of(words: Sequence[bytes]) -> bytes:
    """A name of some words, which spaces are between: compared as bytes, whatever letters they stand for."""
    return b" ".join(words)


def said(name: bytes) -> bytes:
    """A name without the comment behind it, if ` #` begins one and is no letter of the name."""
    return name.partition(b" #")[0]


def text_of(data: bytes) -> str:
    """Text of UTF-8, or, where it is none, of Latin-1."""
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def earlier(name: bytes) -> dict[str, None]:
    """What is left out where two materials have one name."""
    return {f"the earlier one of two materials called {show(text_of(name)[:60])}": None}


def _say(material: Phong, key: str, words: list[str]) -> None:
    """Keep what one line says of a material; ValueError or IndexError where its numbers are none."""
    if key in _PASSED_OVER:
        return
    if key in ("kd", "ks", "ke", "tf"):
        if words[0] in ("spectral", "xyz"):
            material.left_out[f"{words[0]} colours"] = None
        else:
            setattr(material, key, _rgb(words))
    elif key == "ni" and _number(words[0]) == 0:  # as written where nothing is known of it
        material.left_out["an index of refraction (Ni) of 0"] = None
    elif key in ("ns", "ni", "pr", "pm"):
        setattr(material, key, _number(words[0]))
    elif key == "d":
        material.dissolve = _share(words[1] if words[0] == "-halo" else words[0])
    elif key == "tr":
        material.tr = _share(words[0])
    elif key == "illum":
        number = finite(words[0])  # some write 2.000000
        if number != int(number):
            raise ValueError(words[0])
        material.illum = int(number)
    elif key in ("map_kd", "map_ke", "norm"):
        setattr(material, key, texture(words, material.left_out, normals=key == "norm"))
        material.textured |= key == "map_kd" and bool(words)
        material.glowing |= key == "map_ke" and bool(words)
    else:
        material.left_out[_OTHERS.get(key, "textures" if key.startswith("map_") else show(key[:20]))] = None


def _rgb(words: Sequence[str]) -> Rgb:
    """Three numbers; one number stands for a grey."""
    red, green, blue = map(_number, words[:3] if len(words) > 1 else [words[0]] * 3)
    return red, green, blue


def _number(word: str) -> float:
    """A number that is finite; one below 0 counts as 0."""
    return max(finite(word), 0.0)


def _share(word: str) -> float:
    return min(_number(word), 1.0)
