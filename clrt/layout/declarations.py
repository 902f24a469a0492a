"""The C side of the table of layouts: constants, structs and groups of kernel parameters."""

from __future__ import annotations

import re

import numpy as np

from clrt import layout
from clrt.base import layers
from clrt.layout import RayFormat


def c_declarations(ray_format: RayFormat | None = None, lanes: int = 16, packet: int = 16) -> str:
    """The C side of `clrt.layout`: constants, structs, and groups of kernel parameters.

    Of each group, such as the world's buffers: `WORLD_PARAMETERS` is the list of them in a signature, `World`
    the struct that device functions take, `WORLD_OF_PARAMETERS` the initialiser of one from the other.
    """
    ray_format = ray_format or RayFormat()
    constants: dict[str, int] = {
        "BANDS": ray_format.bands,
        "RAY_BANDS": ray_format.carried,
        "VALUES": ray_format.values,
        "GROUP": ray_format.group,
        "NARROW": int(ray_format.narrow),
        "MEDIA": ray_format.media,
        "MOST_PANES": layout.PANES,
        "LANES": lanes,
        "PACKET": packet,
        "WIDE": layout.WIDE,
        "CHUNK": layout.CHUNK,
        "ARRANGED": layout.ARRANGED,
        "STREAMS": len(layout.streams(ray_format.group)),
        "RAY_FIELDS": len(layout.RAY_FIELDS),
        "SURFACE_FIELDS": ray_format.surface_fields,
        "IMAGES": int(ray_format.images),
        "MIPS": int(ray_format.mips),
        "EXTENT": int(ray_format.extent),
    }
    constants |= layout.KINDS | layout.BLOCKS | layout.FALLOFF | layout.FRESNEL | layout.CHECKER
    constants |= layout.MAPPINGS | layout.WRAP
    constants |= {f"PICTURED_{name.upper()}": number for number, name in enumerate(layout.PICTURES)}
    constants |= layout.SURFACE | layout.PATH | layout.SPAWN | layout.SEEN | layout.TERMS | layout.OVERFLOW
    lights = layout.LIGHT_KINDS | layout.EXTENDED_KINDS
    constants |= {f"LIGHT_{kind}": number for kind, number in lights.items()}
    constants |= {f"FILTER_{name}": number for name, number in layout.FILTERS.items()}
    constants |= {f"STREAM_{name}": number for number, name in enumerate(layout.STREAMS)}
    for fields in (layout.RAY_FIELDS, layout.SURFACE_FIELDS + layout.TOP_FIELDS):
        constants |= {name: number for number, name in enumerate(fields)}
    places = layout.UV_FIELDS + layout.MIP_FIELDS
    constants |= {name: ray_format.place + number for number, name in enumerate(places)}
    constants |= {name: ray_format.cone + number for number, name in enumerate(layout.CONE)}
    out = [f"#define {name} {value}" for name, value in constants.items()]
    lists = {"LIGHT_KINDS": layout.LIGHT_KINDS, "EXTENDED_KINDS": layout.EXTENDED_KINDS}
    for name, kinds in {"PRIMITIVE_KINDS": layout.KINDS, **lists}.items():
        out.append(f"#define {name}(X) " + " ".join(f"X({kind}, {kind.lower()})" for kind in kinds))
    for name in ("PAD", "OFFSET", "ALONG", "FROM_EDGE", "BESIDE", "FEELER_REACH", "BRIGHTEST"):
        out.append(f"#define {name} {float(np.float32(getattr(layout, name))).hex()}f")
    out += [_c_struct(name, ray_format.bands) for name in layout.RECORDS]
    world = {name: f"const {kind} *{name}" for name, kind in layout.world(ray_format.images).items()}
    geometry = {name: f"{layer.kind} *out_{name}" for name, layer in layers.GEOMETRY.items()}
    groups = {"World": world, "Queue": layout.QUEUE, "Hits": layout.HITS, "Shaded": layout.SHADED}
    groups |= {"Feelers": layout.FEELERS, "Child": layout.CHILD, "Geometry": geometry}
    groups["Asked"] = layout.ASKED
    groups["Pixels"] = layout.PIXELS
    out += [_c_group(name, list(group.values())) for name, group in groups.items()]
    return "\n".join(out)


def _c_group(name: str, parameters: list[str]) -> str:
    parameters = [_c_type(text) + _c_name(text) for text in parameters]
    start = f"#define {name.upper()}"
    return (
        "typedef struct {\n" + "".join(f"    {parameter};\n" for parameter in parameters) + f"}} {name};\n"
        f"{start}_PARAMETERS {', '.join(parameters)}\n"
        f"{start}_OF_PARAMETERS {{{', '.join(map(_c_name, parameters))}}}\n"
    )


def _c_name(parameter: str) -> str:
    return re.split(r"[ *]", parameter)[-1]


def _c_type(text: str) -> str:
    """The type of a parameter `type name`, so that a name can follow."""
    kind, star, _ = text.partition("*")
    return f"__global {kind}*" if star else kind.split()[0] + " "


def _c_struct(name: str, bands: int) -> str:
    lines = []
    for field, kind in layout.RECORDS[name]:
        base, length = layout.field_length(kind, bands)
        if length:
            lines.append(f"    {base} {field}[{length}];")
        elif "@" not in kind:
            lines.append(f"    {base} {field};")
    return "typedef struct {\n" + "\n".join(lines) + f"\n}} {name};\n"
