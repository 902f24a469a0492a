"""Mitsuba's BSDFs and textures as materials of a scene file."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from clrt.base.errors import fault, show
from clrt.formats.mitsuba.blends import blended, rgb
from clrt.formats.mitsuba.file import Context
from clrt.formats.mitsuba.spectra import SPECTRA
from clrt.formats.mitsuba.values import Array, Plugin, color, moved
from clrt.formats.xml_tree import Element, unknown
from clrt.meshfiles.facets import Facets, fresnel_of
from clrt.meshfiles.look import placement_of
from clrt.spectra.bands import conductor
from clrt.spectra.curves import normal_reflectance

Table = dict[str, Any]
IOR: Final = {
    "vacuum": 1.0, "helium": 1.000036, "hydrogen": 1.000132, "air": 1.000277, "carbon dioxide": 1.00045,
    "water": 1.3330, "acetone": 1.36, "ethanol": 1.361, "carbon tetrachloride": 1.461, "glycerol": 1.4729,
    "benzene": 1.501, "silicone oil": 1.52045, "bromine": 1.661, "water ice": 1.31, "fused quartz": 1.458,
    "pyrex": 1.470, "acrylic glass": 1.49, "polypropylene": 1.49, "bk7": 1.5046, "sodium chloride": 1.544,
    "amber": 1.55, "pet": 1.5750, "diamond": 2.419,
}  # fmt: skip
"""Mitsuba's names of indices of refraction."""
_DIFFUSE: Final = ("reflectance", "diffuse_reflectance", "base_color")
"""What a BSDF that is none of these may call the colour that it has most of."""
METALS: Final = {"Au": "gold", "Ag": "silver", "Cu": "copper", "Al": "aluminium"}
_ALPHA: Final = {"alpha": "alpha", "alpha_u": "alpha", "alpha_v": "alpha", "distribution": "distribution",
                 "sample_visible": "-"}  # fmt: skip
_DIELECTRIC: Final = {"int_ior": "ior", "ext_ior": "ior", "specular_reflectance": "tint",
                      "specular_transmittance": "tint"}  # fmt: skip
_CONDUCTOR: Final = {"material": "conductor", "eta": "", "k": "", "specular_reflectance": "tint"}
_PLASTIC: Final = {"diffuse_reflectance": "color", "int_ior": "ior", "ext_ior": "ior", "nonlinear": "x",
                   "specular_reflectance": ""}  # fmt: skip
_PRINCIPLED: Final = dict.fromkeys(
    ("base_color", "roughness", "metallic", "spec_trans", "eta", "specular"), "x"
) | dict.fromkeys(
    ("anisotropic", "spec_tint", "sheen", "sheen_tint", "flatness", "clearcoat", "clearcoat_gloss",
     "diff_trans"), "0",
) | dict.fromkeys(
    ("main_specular_sampling_rate", "clearcoat_sampling_rate", "diffuse_reflectance_sampling_rate",
     "specular_reflectance_sampling_rate"), "-",
)  # fmt: skip


@dataclass(eq=False)
class Materials:
    """Materials and textures by the elements that describe them, each read once."""

    context: Context
    named: dict[str, Table] = field(default_factory=dict)
    _read: dict[int, Table | None] = field(default_factory=dict)
    _textures: dict[int, Any] = field(default_factory=dict)

    def of(self, element: Element) -> Table:
        """The material that an element describes; SceneError where it is made of itself."""
        key = id(element)
        if key not in self._read:
            self._read[key] = None
            self._read[key] = self._table(Plugin.of(element))
        found = self._read[key]
        if found is None:
            raise element.says("this BSDF refers to itself")
        return found

    def _table(self, plugin: Plugin) -> Table:
        make = _KINDS.get(plugin.type)
        if make is not None:
            return make(plugin, self)
        self.context.without(plugin, [*_KINDS], _OTHERS)
        inner = self.context.first(plugin, "bsdf")
        if inner is not None:
            return self.of(inner)
        name = next((name for name in _DIFFUSE if self.has(plugin, name)), _DIFFUSE[0])
        return {"color": self.color(plugin, name, 0.5), "diffuse": 1.0}

    def has(self, plugin: Plugin, name: str) -> bool:
        """Whether it has a value or an object of that name."""
        return name in plugin.values or self.context.called(plugin, name) is not None

    def inner(self, plugin: Plugin, count: int = 1) -> list[Table]:
        """The BSDFs within another, exactly so many."""
        found = self.context.elements(plugin, "bsdf")
        if len(found) != count:
            text = f"a {plugin.type} needs {count} bsdf within it, not {len(found)}"
            raise plugin.element.says(text)
        tables = [self.of(element) for element in found]
        for table in tables:
            self.context.take(table, "bsdf", plugin.element)
        return tables

    def color(self, plugin: Plugin, name: str, default: float) -> Any:
        """A colour or a texture."""
        element = self.context.called(plugin, name)
        if element is None:
            return plugin.color(name, default)
        if element.keys.get("type") in SPECTRA:
            return color(element, name)
        if element.tag != "texture":
            raise plugin.element.says(f"{name}: a {element.tag} is no colour; give it a texture")
        if id(element) not in self._textures:
            self._textures[id(element)] = self.texture(Plugin.of(element))
        self.context.take(self._textures[id(element)], "texture", plugin.element)
        return self._textures[id(element)]

    def tint(self, plugin: Plugin, name: str, default: float) -> Any:
        """A colour or an image: where a pattern cannot be."""
        return _unpatterned(self.color(plugin, name, default), self.context)

    def texture(self, plugin: Plugin) -> Any:
        """A texture as a scene file has it; what there is none of is grey."""
        if plugin.type == "bitmap":
            self.context.check(plugin, _BITMAP)
            return self._bitmap(plugin)
        if plugin.type == "checkerboard":
            self.context.check(plugin, _TO_UV | {"color0": "x", "color1": "x"})
            pair = [plugin.color("color0", 0.4), plugin.color("color1", 0.2)]
            return {"type": "checker", "colors": pair, "to_uv": _to_uv(plugin)}
        self.context.without(plugin, ["bitmap", "checkerboard", *SPECTRA], _OTHER_TEXTURES)
        inner = self.context.first(plugin, "texture") if self.context.first_version else None
        return 0.5 if inner is None else self.texture(Plugin.of(inner))

    def _bitmap(self, plugin: Plugin) -> Table:
        if "filename" not in plugin.values:
            raise plugin.element.says("a bitmap needs its filename")
        wrap = plugin.one_of("wrap_mode", "repeat", {name: name for name in ("repeat", "mirror", "clamp")})
        kind = plugin.one_of("filter_type", "bilinear", _FILTERS)
        table: Table = {"type": "image", "file": self.context.file(plugin.values["filename"]), "wrap": wrap,
                        "filter": kind}  # fmt: skip
        to_uv = _to_uv(plugin)
        scale, offset = np.diag(to_uv)[:2], to_uv[:2, 3]
        if max(abs(to_uv[0, 1]), abs(to_uv[1, 0])) > _ROUNDED * np.abs(to_uv[:2, :2]).max():
            self.context.left_out["rotations of textures"] = None
            scale = np.linalg.norm(to_uv[:2, :2], axis=0)
            offset = offset + (to_uv[:2, :2].sum(axis=1) - scale) / 2  # about the middle of the picture
        table |= {"scale": scale.tolist(), "offset": offset.tolist()}
        gamma = plugin.number("gamma", _FILE_GAMMA)
        if gamma not in (1, 2.2, _FILE_GAMMA):
            self.context.left_out["the gamma of a bitmap"] = None
        linear = plugin.flag("raw", False) or gamma == 1
        return table | ({"encoding": "linear"} if linear else {})


_TO_UV: Final = dict.fromkeys(("to_uv", "uscale", "vscale", "uoffset", "voffset"), "x")
_BITMAP: Final = _TO_UV | dict.fromkeys(("filename", "filter_type", "wrap_mode", "raw", "gamma"), "x") | {
    "format": "-", "accel": "-"}  # fmt: skip
_FILTERS: Final = dict.fromkeys(("bilinear", "trilinear", "ewa"), "linear") | {"nearest": "nearest"}
"""The second and third are of the first version."""
_FLOATS: Final = (".exr", ".hdr", ".pfm")
_ROUNDED: Final = 1e-6  # of a sine of half a turn, in files of seven digits
_FILE_GAMMA: Final = -1.0  # in the first version: that of the file


def _to_uv(plugin: Plugin) -> Array:
    """`to_uv`, after what the first version says of it: an offset first, and then a scale."""
    matrix = plugin.to_world("to_uv")
    if plugin.values.keys().isdisjoint(_TO_UV.keys() - {"to_uv"}):
        return matrix
    scale = np.diag([plugin.number("uscale", 1.0), plugin.number("vscale", 1.0), 1.0, 1.0])
    return matrix @ scale @ moved([plugin.number("uoffset", 0.0), plugin.number("voffset", 0.0), 0.0])


def _unpatterned(color: Any, context: Context) -> Any:
    """A colour that is no checker: the mean of one."""
    if not isinstance(color, dict) or color["type"] != "checker":
        return color
    context.left_out["a checkerboard, but for its mean, where there can be none"] = None
    return mean(color)


def mean(checker: Table) -> list[float]:
    """The colour that a checker is from afar."""
    return [float(part) for part in np.mean([rgb(one) for one in checker["colors"]], axis=0)]


def ior(plugin: Plugin, name: str, default: str) -> float:
    """An index of refraction, a number or a name."""
    element = plugin.values.get(name)
    if element is None:
        return IOR[default]
    if element.tag != "string":
        return _index(plugin, name, 0.0)
    called = element.get("value").lower()
    if called not in IOR:
        raise unknown(element, "index of refraction called", element.get("value"), [*IOR])
    return IOR[called]


def _index(plugin: Plugin, name: str, default: float) -> float:
    value = plugin.number(name, default)
    if value <= 0:
        raise plugin.values[name].says(fault("", name, value, "it must be a number > 0"))
    return value


def _alpha_of(plugin: Plugin, materials: Materials) -> float:
    """Its alpha, or the mean of those along u and v by which the highlight has as much light."""
    names = ("alpha_u", "alpha_v") if {"alpha_u", "alpha_v"} & plugin.values.keys() else ("alpha",)
    if [name for name in ("alpha", "alpha_u", "alpha_v") if materials.context.called(plugin, name)]:
        materials.context.left_out["textures of roughness"] = None
    values = [plugin.number(name, 0.1) for name in names]
    for name, value in zip(names, values, strict=True):
        if not 0 <= value <= 1:
            raise plugin.values[name].says(fault("", name, value, "it must be a number from 0 to 1"))
    if len({*values}) > 1:
        materials.context.left_out[f"alpha u and alpha v of {plugin.type}, but for their mean"] = None
    return math.prod(values) ** (1 / len(values)) if len({*values}) > 1 else values[0]


def _diffuse(plugin: Plugin, materials: Materials) -> Table:
    name = "reflectance"
    if materials.context.first_version and materials.has(plugin, "diffuse_reflectance"):
        name = "diffuse_reflectance"  # as it was called there, too
    materials.context.check(plugin, {name: "color"})
    return {"color": materials.color(plugin, name, 0.5), "diffuse": 1.0}


def _conductor(plugin: Plugin, materials: Materials) -> Table:
    rough = plugin.type == "roughconductor"
    materials.context.check(plugin, _CONDUCTOR | (_ALPHA if rough else {}))
    metal = plugin.text("material", "none")
    tint = materials.tint(plugin, "specular_reflectance", 1.0)
    table = {"diffuse": 0.0, "reflection": 1.0, "reflection_color": tint}
    if metal in METALS:
        table["conductor"] = METALS[metal]
    elif metal != "none":
        materials.context.left_out[f"the metal {show(metal)}"] = None
    if not rough:
        return table
    alpha = _alpha_of(plugin, materials)
    table["roughness"] = math.sqrt(alpha)
    square = max(alpha, 0.0025) ** 2
    lobe = {"specular": 0.25 / square, "shininess": max(1.0, 0.5 / square - 0.5)}
    return table | lobe | {"highlight_color": _highlight(tint, table.get("conductor"))}


def _highlight(tint: Any, metal: str | None) -> Any:
    """The tint times what a metal reflects straight on, which is coloured for mirrors alone."""
    if metal is None:
        return tint
    own = normal_reflectance(*conductor(metal, None))
    if isinstance(tint, dict):
        return tint | {"tint": own.tolist()}
    return (own * rgb(tint)).tolist()


def _dielectric(plugin: Plugin, materials: Materials) -> Table:
    rough = plugin.type == "roughdielectric"
    materials.context.check(plugin, _DIELECTRIC | (_ALPHA if rough else {}))
    outside = ior(plugin, "ext_ior", "air")
    if rough:
        materials.context.left_out["the roughness of glass"] = None
    thin = {"thin": True} if plugin.type == "thindielectric" else {}
    return {
        "diffuse": 0.0, "fresnel": True, "ior": ior(plugin, "int_ior", "bk7"),
        "ext_ior": 1.0 if outside == IOR["air"] else outside,
        "reflection": 1.0, "reflection_color": materials.tint(plugin, "specular_reflectance", 1.0),
        "transmission": 1.0, "transmission_color": materials.tint(plugin, "specular_transmittance", 1.0),
    } | thin  # fmt: skip


def _plastic(plugin: Plugin, materials: Materials) -> Table:
    rough = plugin.type == "roughplastic"
    materials.context.check(plugin, _PLASTIC | (_ALPHA if rough else {}))
    if plugin.flag("nonlinear", False):
        materials.context.left_out[f"nonlinear of {plugin.type}"] = None
    roughness = math.sqrt(_alpha_of(plugin, materials)) if rough else 0.0
    outside = ior(plugin, "ext_ior", "air")
    index = ior(plugin, "int_ior", "polypropylene") / (1.0 if outside == IOR["air"] else outside)
    color = materials.color(plugin, "diffuse_reflectance", 0.5)
    table = Facets(roughness=roughness, ior=index, f0=(fresnel_of(index),) * 3).table()
    return table | {"color": color}


def _principled(plugin: Plugin, materials: Materials) -> Table:
    context = materials.context
    context.check(plugin, _PRINCIPLED)
    shares = [min(max(plugin.number(name, default), 0.0), 1.0)
              for name, default in (("metallic", 0.0), ("roughness", 0.5), ("spec_trans", 0.0))]  # fmt: skip
    names = ("metallic", "roughness", "spec_trans")
    if [name for name in names if context.called(plugin, name) is not None]:  # asks for each
        context.left_out["textures of metal and roughness"] = None
    color = materials.tint(plugin, "base_color", 0.5)
    picture = color if isinstance(color, dict) else None
    specular = 2 / (1 - math.sqrt(0.08 * min(max(plugin.number("specular", 0.5), 0.0), 1.0))) - 1
    base = (1.0, 1.0, 1.0) if picture is not None else rgb(color)
    red, green, blue = (math.sqrt(max(part, 0.0)) for part in base)  # light crosses a body's surface twice
    found = Facets(
        base=base, picture=picture, metallic=shares[0], roughness=shares[1], transmission=shares[2],
        lets=None if picture is not None else (red, green, blue), solid=True,
        ior=_index(plugin, "eta", specular),
    )  # fmt: skip
    if picture is not None and found.passes > 0:
        context.left_out["the root of a picture by which glass lets light pass"] = None
    context.left_out |= dict.fromkeys(found.lost)
    return found.table()


def _inner(plugin: Plugin, materials: Materials) -> Table:
    materials.context.check(plugin, {"allow_transmission": "x"})
    if plugin.flag("allow_transmission", False):
        materials.context.left_out[f"allow transmission of {plugin.type}"] = None
    front = materials.context.first(plugin, "bsdf")  # a second one is that of the back
    if front is None:
        raise plugin.element.says(f"a {plugin.type} needs a bsdf within it")
    table = materials.of(front)
    materials.context.take(table, "bsdf", plugin.element)
    return table


def _normal_map(plugin: Plugin, materials: Materials) -> Table:
    materials.context.check(plugin, {"flip_invalid_normals": "-", "use_shadowing_function": "-"})
    found = materials.inner(plugin)[0]
    picture = materials.color(plugin, "normalmap", 0.5)
    if not isinstance(picture, dict) or picture["type"] != "image":
        raise plugin.element.says("a normalmap needs a bitmap called 'normalmap'")
    left_out = materials.context.left_out
    if "encoding" not in picture and not picture["file"].lower().endswith(_FLOATS):
        left_out["that a normal map without raw is decoded from sRGB"] = None
    if "normal_map" in found:
        left_out["a normal map within another"] = None
    return found | {"normal_map": {"file": picture["file"], "placement": placement_of(picture)}}


def _blend(plugin: Plugin, materials: Materials) -> Table:
    """The sum of two."""
    context = materials.context
    context.check(plugin, {"weight": "x"})
    first, second = materials.inner(plugin, 2)
    weight = plugin.number("weight", 0.5)
    if context.called(plugin, "weight") is not None:
        context.left_out["textures of a blend"] = None
    share = min(max(weight, 0.0), 1.0)
    return blended([(1 - share, first), (share, second)], context.left_out)


_KINDS: Final[dict[str, Callable[[Plugin, Materials], Table]]] = {
    "diffuse": _diffuse, "conductor": _conductor, "roughconductor": _conductor, "dielectric": _dielectric,
    "thindielectric": _dielectric, "roughdielectric": _dielectric, "plastic": _plastic,
    "roughplastic": _plastic, "principled": _principled, "twosided": _inner, "normalmap": _normal_map,
    "blendbsdf": _blend,
}  # fmt: skip
_OTHERS: Final = (
    "mask", "bumpmap", "null", "measured", "measured_polarized", "principledthin", "pplastic", "circular",
    "hair", "polarizer", "retarder",
)  # fmt: skip
_OTHER_TEXTURES: Final = ("mesh_attribute", "volume")
