"""Materials of a glTF file: metallic-roughness and the extensions that have a counterpart here."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Annotated, Any, Final, Literal

import msgspec
from msgspec import Meta

from clrt.meshfiles.facets import Facets, Rgb, absorption_of, fresnel_of
from clrt.meshfiles.gltf_document import Count, Table, decode, item
from clrt.meshfiles.look import Names
from clrt.meshfiles.look import Table as SceneTable

NotNegative = Annotated[float, Meta(ge=0)]
Vector3 = tuple[float, float, float]
_PREFIX: Final = "KHR_materials_"


class Texture(Table, frozen=True, gc=False):
    index: Count


class Transmission(Table, frozen=True, gc=False):
    transmissionFactor: float = 0.0
    transmissionTexture: Texture | None = None


class Ior(Table, frozen=True, gc=False):
    ior: NotNegative = 1.5


class Volume(Table, frozen=True, gc=False):
    thicknessFactor: NotNegative = 0.0
    thicknessTexture: Texture | None = None
    attenuationDistance: Annotated[float, Meta(gt=0)] = math.inf
    attenuationColor: Vector3 = (1.0, 1.0, 1.0)


class Strength(Table, frozen=True, gc=False):
    emissiveStrength: NotNegative = 1.0


class Specular(Table, frozen=True, gc=False):
    specularFactor: float = 1.0
    specularColorFactor: Vector3 = (1.0, 1.0, 1.0)
    specularTexture: Texture | None = None
    specularColorTexture: Texture | None = None


class Unlit(Table, frozen=True, gc=False):
    """That it is there is all that counts."""


class Metal(Table, frozen=True, gc=False):
    baseColorFactor: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    metallicFactor: float = 1.0
    roughnessFactor: float = 1.0
    baseColorTexture: Texture | None = None
    metallicRoughnessTexture: Texture | None = None


class Material(Table, frozen=True, gc=False):
    name: str = ""
    pbrMetallicRoughness: Metal = Metal()
    normalTexture: Texture | None = None
    occlusionTexture: Texture | None = None
    emissiveTexture: Texture | None = None
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


def materials_of(
    text: msgspec.Raw, numbers: Sequence[int], left_out: dict[str, None]
) -> tuple[dict[str, SceneTable], dict[int, str]]:
    """The materials of some `numbers` by name, and the names by number; what is not read goes to `left_out`.

    Materials are not checked that nothing has.
    """
    tables: dict[str, SceneTable] = {}
    called: dict[int, str] = {}
    names = Names()
    if numbers:
        rows = decode(text, tuple[msgspec.Raw, ...], "materials")
        for number in numbers:
            material = decode(item(rows, number, "materials"), Material, f"materials[{number}]")
            called[number] = names.new(material.name or f"material {number}")
            tables[called[number]] = _table(material, number, left_out)
    return tables, called


def _table(material: Material, number: int, left_out: dict[str, None]) -> SceneTable:
    more = {name: kind() for name, kind in _KNOWN.items()}
    for name, text in material.extensions.items():
        short = name.removeprefix(_PREFIX)
        if name.startswith(_PREFIX) and short in _KNOWN:
            more[short] = decode(text, _KNOWN[short], f"materials[{number}].extensions.{name}")
        else:
            left_out[re.sub(r"[\W_]+", " ", short)[:40]] = None
    _note_textures(material, more, left_out)
    metal = material.pbrMetallicRoughness
    red, green, blue, alpha = map(_share, metal.baseColorFactor)
    if _PREFIX + "unlit" in material.extensions:
        return {"color": 0.0, "diffuse": 0.0, "emission": [red, green, blue]}
    specular: Specular = more["specular"]
    least = fresnel_of(more["ior"].ior)
    factor = _share(specular.specularFactor)
    f0 = (_share(least * max(c, 0.0)) * factor for c in specular.specularColorFactor)
    volume: Volume = more["volume"]
    strength = more["emissive_strength"].emissiveStrength
    found = Facets(
        base=(red, green, blue),
        metallic=_share(metal.metallicFactor),
        roughness=_share(metal.roughnessFactor),
        ior=more["ior"].ior,
        f0=_rgb(f0),
        alpha=_alpha(material, alpha),
        transmission=_share(more["transmission"].transmissionFactor),
        solid=volume.thicknessFactor > 0,
        absorption=absorption_of(volume.attenuationColor, volume.attenuationDistance),
        emission=_rgb(max(c, 0.0) * strength for c in material.emissiveFactor),
    )
    if found.blurred:
        left_out["the roughness of glass"] = None
    return found.table()


def _note_textures(material: Material, more: dict[str, Any], left_out: dict[str, None]) -> None:
    tables = (material, material.pbrMetallicRoughness, *more.values())
    if any(isinstance(getattr(table, name), Texture) for table in tables for name in table.__struct_fields__):
        left_out["textures"] = None


def _alpha(material: Material, alpha: float) -> float:
    if material.alphaMode == "OPAQUE":
        return 1.0
    return alpha if material.alphaMode == "BLEND" else float(alpha >= material.alphaCutoff)


def _share(value: float) -> float:
    return min(max(value, 0.0), 1.0)


def _rgb(values: Any) -> Rgb:
    red, green, blue = values
    return red, green, blue
