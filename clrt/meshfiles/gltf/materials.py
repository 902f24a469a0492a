"""Materials of a glTF file: metallic-roughness and the extensions that have a counterpart here."""

from __future__ import annotations

import math
import re
from typing import Annotated, Any, Final, Literal

import msgspec
from msgspec import Meta

from clrt.meshfiles.facets import Facets, Rgb, absorption_of, fresnel_of, unlit
from clrt.meshfiles.gltf.document import Document, Table, decode, item
from clrt.meshfiles.gltf.textures import Info, Itself, Textures
from clrt.meshfiles.look import Look, Names, Used, placement_of, textures_without_uv
from clrt.meshfiles.look import Table as SceneTable

NotNegative = Annotated[float, Meta(ge=0)]
Vector3 = tuple[float, float, float]
_PREFIX: Final = "KHR_materials_"


class Transmission(Table, frozen=True, gc=False):
    transmissionFactor: float = 0.0
    transmissionTexture: Info | None = None


class Ior(Table, frozen=True, gc=False):
    ior: NotNegative = 1.5


class Volume(Table, frozen=True, gc=False):
    thicknessFactor: NotNegative = 0.0
    thicknessTexture: Info | None = None
    attenuationDistance: NotNegative | None = None  # 0 and null, as three.js writes infinity, are without end
    attenuationColor: Vector3 = (1.0, 1.0, 1.0)


class Strength(Table, frozen=True, gc=False):
    emissiveStrength: NotNegative = 1.0


class Specular(Table, frozen=True, gc=False):
    specularFactor: float = 1.0
    specularColorFactor: Vector3 = (1.0, 1.0, 1.0)
    specularTexture: Info | None = None
    specularColorTexture: Info | None = None


class Unlit(Table, frozen=True, gc=False):
    """That it is there is all that counts."""


class Metal(Table, frozen=True, gc=False):
    baseColorFactor: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    metallicFactor: float = 1.0
    roughnessFactor: float = 1.0
    baseColorTexture: Info | None = None
    metallicRoughnessTexture: Info | None = None


class Material(Table, frozen=True, gc=False):
    name: str = ""
    pbrMetallicRoughness: Metal = Metal()
    normalTexture: Info | None = None
    occlusionTexture: Info | None = None
    emissiveTexture: Info | None = None
    emissiveFactor: Vector3 = (0.0, 0.0, 0.0)
    alphaMode: Literal["OPAQUE", "MASK", "BLEND"] = "OPAQUE"
    alphaCutoff: float = 0.5
    extensions: dict[str, msgspec.Raw] = msgspec.field(default_factory=dict)


_KNOWN: Final[dict[str, Any]] = {
    "transmission": Transmission,
    "ior": Ior,
    "volume": Volume,
    "emissive_strength": Strength,
    "specular": Specular,
    "unlit": Unlit,
}


def materials_of(document: Document, itself: Itself, used: Used) -> Look:
    """The `used` materials, and what of them is not read. Materials are not checked that nothing has."""
    look, names = Look(), Names()
    textures = Textures(document, itself, look.left_out)
    if used:
        rows = decode(document.materials, tuple[msgspec.Raw, ...], "materials")
        for number, uv in used:
            material = decode(item(rows, number, "materials"), Material, f"materials[{number}]")
            name = material.name or f"material {number}"
            metal = material.pbrMetallicRoughness
            pictures = metal.baseColorTexture, material.normalTexture, material.emissiveTexture
            if not uv and any(picture is not None for picture in pictures):
                look.left_out[textures_without_uv(name)] = None
            surface = _surface(material, number, uv, textures, look.left_out)
            look.add(names, (number, uv), name, surface)
    return look


def _surface(
    material: Material, number: int, uv: bool, textures: Textures, left_out: dict[str, None]
) -> SceneTable | Facets:
    """What it is made of, or the table of what is unlit."""
    more = {name: kind() for name, kind in _KNOWN.items()}
    for name, text in material.extensions.items():
        short = name.removeprefix(_PREFIX)
        if name.startswith(_PREFIX) and short in _KNOWN:
            more[short] = decode(text, _KNOWN[short], f"materials[{number}].extensions.{name}")
        else:
            left_out[spelt(short)] = None
    metal = material.pbrMetallicRoughness
    _note_textures(material, more, left_out)
    picture = textures.picture(metal.baseColorTexture, uv)
    red, green, blue, alpha = map(_share, metal.baseColorFactor)
    if _PREFIX + "unlit" in material.extensions:
        return unlit(picture, (red, green, blue), _alpha(material, alpha))
    _, rough, metallic = textures.mean(metal.metallicRoughnessTexture)
    specular: Specular = more["specular"]
    least = fresnel_of(more["ior"].ior)
    f0 = (_share(least * max(c, 0.0)) for c in specular.specularColorFactor)
    volume: Volume = more["volume"]
    strength = more["emissive_strength"].emissiveStrength
    glow = textures.picture(material.emissiveTexture, uv)
    if material.emissiveTexture is not None and glow is None and any(material.emissiveFactor):
        left_out["the light of what glows by a picture that is left out"] = None
        strength = 0.0
    found = Facets(
        base=(red, green, blue),
        picture=picture,
        glow=glow,
        normal_map=_normal_map(textures.picture(material.normalTexture, uv), material.normalTexture, picture),
        metallic=_share(metal.metallicFactor * metallic),
        roughness=_share(metal.roughnessFactor * rough),
        ior=more["ior"].ior,
        f0=_rgb(f0),
        weight=_share(specular.specularFactor),
        alpha=_alpha(material, alpha),
        transmission=_share(more["transmission"].transmissionFactor),
        solid=volume.thicknessFactor > 0,
        absorption=absorption_of(volume.attenuationColor, volume.attenuationDistance or math.inf),
        emission=_rgb(max(c, 0.0) * strength for c in material.emissiveFactor),
    )
    left_out |= dict.fromkeys(found.lost)
    if found.passes > 0 and found.weight < 1:
        left_out["the specularFactor of glass"] = None
    if found.passes > 0 and found.alpha < 1:
        left_out["the alpha of glass"] = None
    return found


def spelt(extension: str) -> str:
    """What a message calls an extension of a material."""
    return re.sub(r"[\W_]+", " ", extension)[:40]


def _normal_map(
    picture: SceneTable | None, info: Info | None, color: SceneTable | None
) -> SceneTable | None:
    """The normal map in a picture, with a placement where that is not the one of `color`."""
    if picture is None or info is None:
        return None
    table: SceneTable = {key: picture[key] for key in ("file", "part") if key in picture}
    placement = placement_of(picture)
    table |= {"placement": placement} if placement != placement_of(color or {}) else {}
    return table | ({"scale": info.scale} if info.scale != 1.0 else {})


def _note_textures(material: Material, more: dict[str, Any], left_out: dict[str, None]) -> None:
    """Say what of a material's textures has no counterpart."""
    metal = material.pbrMetallicRoughness
    if material.alphaMode != "OPAQUE" and metal.baseColorTexture is not None:
        left_out["transparency in textures"] = None
    if metal.metallicRoughnessTexture is not None:
        left_out["textures of roughness and metal, but for their mean"] = None
    if material.occlusionTexture is not None:
        left_out["occlusion"] = None
    names = [(table, name) for table in more.values() for name in table.__struct_fields__]
    if any(isinstance(getattr(table, name), Info) for table, name in names):
        left_out["textures of transmission, thickness and specular"] = None


def _alpha(material: Material, alpha: float) -> float:
    if material.alphaMode == "OPAQUE":
        return 1.0
    return alpha if material.alphaMode == "BLEND" else float(alpha >= material.alphaCutoff)


def _share(value: float) -> float:
    return min(max(value, 0.0), 1.0)


def _rgb(values: Any) -> Rgb:
    red, green, blue = values
    return red, green, blue
