"""What a layer is: an entry each, from which film, pictures, files, kernel `geometry` and docs take it."""

from __future__ import annotations

import re
from collections.abc import Iterable
from math import inf
from typing import Final, Literal, NamedTuple

from clrt.base.errors import ClrtError, show
from clrt.base.suggest import nearest

TERMS: Final = ("emission", "ambient", "diffuse", "highlight")  # of local light: in kernels TERM_EMISSION ...
_GENERATION: Final = re.compile(r"generation_(0|[1-9][0-9]{0,8})")
_MOST_NAMED: Final = 64  # generations that a message lists


class Paths(NamedTuple):
    """Light of rays: by layout.PATH[mask] of their path word (None: all set), and generation (None: all)."""

    mask: str = ""
    value: int | None = None
    generation: int | None = None


class Term(NamedTuple):
    """Light of generation 0 by one of layout.TERMS."""

    name: str


class Geometry(NamedTuple):
    """What the kernel `geometry` writes about where the first ray of a pixel hits.

    pictures: it says nothing where no surface of the scene shows a picture.
    """

    pictures: bool = False


class Spectral(NamedTuple):
    """The whole picture of a scene with a spectrum by another response (of FlatScene) than RGB; "": bands."""

    response: str = ""


class Count(NamedTuple):
    """How many samples a pixel got."""


class Samples(NamedTuple):
    """Which part of a pixel's samples hits anything; `of` "shape" or "material": which of these, ranked."""

    of: str = ""


Source = Paths | Term | Geometry | Spectral | Count | Samples


class Layer(NamedTuple):
    """What a layer holds, where it comes from, and how it is stored and shown."""

    sources: tuple[Source, ...]  # which add up
    holds: str
    values: int = 3  # numbers a pixel; 0: the bands of the scene
    kind: str = "float"  # of number, as kernels call it
    channels: tuple[str, ...] = ("R", "G", "B")  # in an .exr; none: by wavelength
    picture: str = "light"  # one of PICTURES
    bare: bool = False  # its channels are the picture's own, and so have no layer's name before them
    formerly: tuple[str, ...] = ()  # what its channels were called in older files
    # the least and the most that a number can be that is no light; a text: the scene's last one of these
    within: tuple[float, float | Literal["shape", "material"]] = (-inf, inf)

    @property
    def is_shown(self) -> bool:
        """Can it be looked at? If not, only an .exr holds it."""
        return self.picture != "none"

    @property
    def is_light(self) -> bool:
        """Does exposure brighten it?"""
        return self.picture in ("light", "luminance", "none")

    def names(self, name: str) -> tuple[str, ...]:
        """Its channels in an .exr, where the layer has this name."""
        if self.bare:
            return self.channels
        joint = "" if self.picture == "mattes" else "."
        return tuple(f"{name}{joint}{channel}" for channel in self.channels)


# how `clrt.images.layerpicture` shows a layer
PICTURES: Final = {
    "light": "light, with `--exposure`",
    "luminance": "Y as grey light",
    "nearness": "grey `nearest / distance`: the nearest hit is 1 (white), what is twice as far 1/2, a miss 0",
    "direction": "red, green, blue = `(n + 1) / 2`; a miss is black",
    "place": "red, green, blue = x, y, z, each from its 5th (0) to its 95th percentile (1) over all hits; "
    "a miss is black",
    "color": "red, green, blue, without exposure",
    "coordinates": "red, green = u, v, each without its whole part; blue 0",
    "share": "grey: 0 black, 1 white",
    "mattes": "each name has a colour, the same in every picture, as much of it as the name covers",
    "number": "number k has hue `0.6180339887 k` (modulo 1) in every picture; a miss is black",
    "part": "grey, the part of the picture's most: 1 (white) where it is that",
    "none": "none: only `.exr` holds them, and `all` leaves them out beside other files",
}

_ROUTE: Final = "light by the first bounce on its way; they sum to the picture"
_GENERATIONS: Final = "light by the number of bounces; they sum to the picture"
_TERM: Final = "the terms of the local light of generation 0"
_HIT: Final = (Geometry(),)
_FINITE: Final = (-3.4028234663852886e38, 3.4028234663852886e38)  # as float32 is
_XYZ: Final = ("X", "Y", "Z")
RANKS: Final = 6  # names that a pixel's mattes hold
_PAIRS: Final = tuple(f"{rank // 2:02}.{'RGBA'[rank % 2 * 2 + k]}" for rank in range(RANKS) for k in (0, 1))
_MATTES: Final = "Cryptomatte: ranked pairs of a name's hash and the part of the samples that it covers, by "

# fmt: off
LAYERS: Final = {
    "direct": Layer((Paths("PATH_ROUTE", 0),), _ROUTE),
    "reflection": Layer((Paths("PATH_ROUTE", 1),), _ROUTE),
    "transmission": Layer((Paths("PATH_ROUTE", 2),), _ROUTE),
    # also what rays gather in place of the constant term
    "ambient": Layer((Paths("PATH_GATHERED_FIRST"), Term("TERM_AMBIENT")), _TERM),
    **{name: Layer((Term(f"TERM_{name.upper()}"),), _TERM) for name in TERMS if name != "ambient"},
    # of the first ray of a pixel; 0 on a miss
    "depth": Layer(_HIT, "way of the ray, from `near` on; infinite on a miss", 1, "float", ("V",), "nearness",
                   formerly=("depth.Z",), within=(0.0, inf)),
    "z": Layer(_HIT, "depth along the view, from the eye; infinite on a miss", 1, "float", ("Z",), "nearness",
               bare=True, within=(_FINITE[0], inf)),
    "distance": Layer(_HIT, "distance from the eye, infinite on a miss", 1, "float", ("V",), "nearness",
                      within=(0.0, inf)),
    "position": Layer(_HIT, "the hit, 0 on a miss", 3, "float", _XYZ, "place", within=_FINITE),
    "normal": Layer(_HIT, "outward geometric unit normal, 0 on a miss", 3, "float", _XYZ, "direction",
                    within=(-2.0, 2.0)),
    "shading_normal": Layer(_HIT, "unit normal that light is computed with, 0 on a miss", 3, "float", _XYZ,
                            "direction", within=(-2.0, 2.0)),
    "albedo": Layer(_HIT, "diffuse reflectance: `diffuse` times the colour there, 0 on a miss",
                    picture="color", within=_FINITE),
    "uv": Layer((Geometry(pictures=True),), "u, v in the surface's pictures, 0 without; of scenes with such",
                2, "float", ("U", "V"), "coordinates", within=_FINITE),
    "shape": Layer(_HIT, "number of the shape, -1 on a miss", 1, "int", ("ID",), "number",
                   within=(-1.0, "shape")),
    "material": Layer(_HIT, "number of the material, -1 on a miss", 1, "int", ("ID",), "number",
                      within=(-1.0, "material")),
    # of all samples of a pixel
    "alpha": Layer((Samples(),), "the part of the samples that hits anything", 1, "float", ("A",), "share",
                   bare=True, within=(0.0, 1.0)),
    "crypto_shape": Layer((Samples("shape"),), _MATTES + "shape", 2 * RANKS, "float", _PAIRS, "mattes",
                          within=_FINITE),
    "crypto_material": Layer((Samples("material"),), _MATTES + "material", 2 * RANKS, "float", _PAIRS,
                             "mattes", within=_FINITE),
    "bands": Layer((Spectral(),), "the picture's bands, of scenes with a `spectrum`", 0, "float", (), "none"),
    "samples": Layer((Count(),), "samples: more where `adaptive` asks", 1, "int", ("N",), "part"),
    "xyz": Layer((Spectral("xyz"),), "CIE XYZ, likewise", 3, "float", _XYZ, "luminance"),
}
# what the kernel `geometry` writes, in the order of its parameters; colours in bands
GEOMETRY: Final = {
    name: layer._replace(values=0) if layer.picture == "color" else layer
    for name, layer in LAYERS.items() if isinstance(layer.sources[0], Geometry)
}
# fmt: on
_OTHER: Final = Layer((), "what its maker says")


def find(name: str) -> Layer:
    """The layer of this name, `generation_3` among them; without sources if it is none of ours."""
    numbered = _GENERATION.fullmatch(name)
    if numbered:
        return Layer((Paths(generation=int(numbered.group(1))),), _GENERATIONS)
    return LAYERS.get(name, _OTHER)


def comes_from(name: str, *kinds: type[Source]) -> bool:
    """Has the layer a source of these kinds?"""
    return any(isinstance(source, kinds) for source in find(name).sources)


def check_layers(
    layers: Iterable[str], max_depth: int, spectral: bool = False, pictured: bool = False
) -> tuple[str, ...]:
    """The names, each once; "all" stands for all there are. ClrtError names an unknown one and its nearest.

    spectral, pictured: whether the scene has a spectrum, and pictures on surfaces. A single name, or
    several with commas, may be one text.
    """
    listed = [name.strip() for name in layers.split(",")] if isinstance(layers, str) else layers
    known = [
        name for name in LAYERS
        if (spectral or not comes_from(name, Spectral)) and (pictured or not _of_pictures(name))
    ]  # fmt: skip
    found: dict[str, None] = {}
    for name in listed:
        if name == "all":
            found |= dict.fromkeys((*known, *(f"generation_{g}" for g in range(max_depth + 1))))
            continue
        if comes_from(name, Spectral) and not spectral:
            raise ClrtError(f"layers: {name!r} is for scenes with a spectrum; this one is in RGB")
        if _of_pictures(name) and not pictured:
            raise ClrtError(f"layers: {name!r} is for scenes with pictures on surfaces; this one has none")
        if name not in known and not _is_generation(name, max_depth):
            numbered = tuple(f"generation_{g}" for g in range(min(max_depth, _MOST_NAMED) + 1))
            near = nearest(name, (*known, *numbered), cutoff=0.6)
            hint = f"did you mean {near!r}?" if near else "known: all, " + ", ".join((*known, *numbered))
            raise ClrtError(f"layers: {show(name)} is not a layer; {hint}")
        found[name] = None
    return tuple(found)


def _of_pictures(name: str) -> bool:
    return any(isinstance(source, Geometry) and source.pictures for source in find(name).sources)


def _is_generation(name: str, max_depth: int) -> bool:
    """Whether this is the layer of a generation that there is."""
    found = _GENERATION.fullmatch(name)
    return found is not None and int(found.group(1)) <= max_depth
