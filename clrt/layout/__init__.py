"""The one table of record layouts: what the host packs and the kernels read.

Every record that crosses from Python to OpenCL is described here once. `dtype(name)` gives the numpy
side, `clrt.layout.declarations` the C side, so the two cannot drift apart. Only `float4`, `float`, `int` and
`uint` occur (a `float3` would bring hidden padding), the wide fields come first, and a record that holds a
`float4` is a multiple of 16 bytes, so that every OpenCL device agrees on the layout; a test asks each device.

Three kinds of data:

* RECORDS: C structs, one array of them per section of the world (`Sphere spheres[]`, ...).
* WORLD: the sections, in the order in which every kernel that sees the scene receives them.
* BLOCKS: what travels in queues. Rays move in blocks of LANES (16 or 8): inside a block each field is a
  run of LANES floats, so that neighbouring work-items touch neighbouring memory.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from clrt.base import layers

BANDS: Final = 3  # bands of light a ray carries in RGB mode; a compile-time constant of the kernels
# Places in a ray's list of media, oldest first, -1 where empty; a compile-time constant of the kernels, 0 for
# scenes that need no lists
MEDIA: Final = 8
PANES: Final = 4096  # surfaces that a tinted feeler goes through; to find n at one place takes n^2 / 32 tests

# field of the record Material -> of the scene's
COEFFICIENTS: Final = {
    "ka": "ka", "kd": "diffuse", "ks": "specular", "shininess": "shininess", "kr": "kr", "kt": "kt",
}  # fmt: skip

# fmt: off
# name -> ((field, C type), ...); "@BANDS" after a type makes an array of one value a band
RECORDS: Final[dict[str, tuple[tuple[str, str], ...]]] = {
    # --- geometry -----------------------------------------------------------------------------------------
    # One per primitive, in scene order: the number of a primitive is its index here. `index` is the place in
    # the section of its kind (KINDS).
    "Primitive": (("kind", "int"), ("index", "int"), ("shape", "int"), ("material", "int")),
    "Sphere": (("center_radius", "float4"),),  # xyz, w = radius
    # `point` = any point of the plane; `normal` = outward unit normal
    "Plane": (("point", "float4"), ("normal", "float4")),
    "Disk": (("center_radius", "float4"), ("normal", "float4")),
    # corners in winding order; `normals` = index of three corner normals in section `normals`, or -1 (flat)
    "Triangle": (
        ("v0", "float4"), ("v1", "float4"), ("v2", "float4"),
        ("normals", "int"), ("pad0", "int"), ("pad1", "int"), ("pad2", "int"),
    ),
    # `normal`.xyz = outward unit Newell normal, .w = largest |coordinate| of the corners; corners are
    # vertices[first : first + count] of section `vertices`
    "Polygon": (("normal", "float4"), ("first", "int"), ("count", "int"), ("pad0", "int"), ("pad1", "int")),
    # F(x) = sum s_i x_i^2 + 2 g.x + J about `center` (float32-exact), x_i = axis_i.xyz . (p - center) along
    # unit axes of its own: axis_i.w = g_i; `form` = s, .w = J.
    # clip coordinate i of a local point p is clip_i.xyz . p, which must lie in [clip_i.w, clip_high[i]]
    # (-inf, inf without a clip). `reach` = largest |x|, |y|, |z| of the clipped surface's box, 0 if
    # unbounded; .w of center, clip_high, reach: how far it reaches from the centre in x, y, z, else inf
    "Quadric": (
        ("center", "float4"), ("axis_x", "float4"), ("axis_y", "float4"), ("axis_z", "float4"),
        ("form", "float4"), ("clip_x", "float4"), ("clip_y", "float4"), ("clip_z", "float4"),
        ("clip_high", "float4"), ("reach", "float4"),
    ),
    # Node of the tree: the boxes of WIDE children, plane by plane (low x, high x, low y, high y, low z,
    # high z), and what each box holds: a node (>= 0) or a leaf ~(block * 4 + kind of block). An empty place
    # is an inverted box. 448 bytes, seven cache lines.
    "WideNode": (("planes", "float@96"), ("child", "int@16")),
    # Leaves: up to eight primitives of a kind, by coordinate: v0.x of all, v0.y, ..., v2.z; centre x, y, z,
    # radius. An empty place has NaN and primitive -1.
    "TriangleBlock": (("corners", "float@72"), ("primitive", "int@8")),
    "SphereBlock": (("places", "float@32"), ("primitive", "int@8")),
    # Binary node of the builder: children `first`, `first + 1` (count = 0), or items first .. first + count.
    # `part`: number from 1 of the subtree whose root it is, 0 of none; `shares` = how it collapses, 4 bits
    # for each number of places (collapse.clh)
    "BuildNode": (
        ("low", "float4"), ("high", "float4"),
        ("first", "int"), ("count", "int"), ("kind", "int"), ("part", "int"),
        ("shares", "uint@2"), ("pad0", "int"), ("pad1", "int"),
    ),
    # What collapsing costs below a binary node: cost[k] if its boxes take at most k places of a wide node, k
    # from 1 up; from `most` places on it is the same. `inner` = nodes that are no leaves, itself with them
    "Ways": (("cost", "float@16"), ("most", "int"), ("inner", "int")),
    # padded box of a finite primitive, as the builder reads it
    "Box": (("low", "float4"), ("high", "float4")),
    # --- light and materials ------------------------------------------------------------------------------
    # checker = 0: plain; 1: flat (side of a square `checker_size`); 2: sphere (squares round the equator)
    "Material": (
        *((field, "float") for field in COEFFICIENTS), ("ior", "float"), ("checker_size", "float"),
        ("alpha", "float"),  # width of the lobe of a rough mirror, 0 of a perfect one
        ("fresnel", "int"), ("thin", "int"), ("one_sided", "int"), ("checker", "int"),
        # `medium` = the number of the material that stands for the medium within, -1 where rays do not enter
        ("medium", "int"), ("priority", "int"), ("dispersive", "int"),
        ("light", "int"),  # 0; of the surface of a light 1, 2 where it shines on both sides
        ("color", "float@BANDS"), ("color2", "float@BANDS"), ("highlight", "float@BANDS"),
        ("mirror", "float@BANDS"), ("tint", "float@BANDS"), ("emission", "float@BANDS"),
        ("absorption", "float@BANDS"),
        ("eta", "float@BANDS"), ("k", "float@BANDS"),  # of a conductor: its complex index eta + ik
        ("band_ior", "float@BANDS"),  # index of refraction, for each band that of its dispersion group
    ),
    # POINT, SPOT: `place`.xyz its position; DIRECTIONAL: the unit vector towards it. SPOT: `axis` = unit
    # vector that it shines along; `angle` from it where the light ends, `width` of the penumbra, in radians.
    # EXTENDED_KINDS: `place`.xyz the middle, `axis` = unit normal, `u`, `v` = half sides or radii across each
    # other, `share` of a point: area / (pi samples); `radius` of a sphere; all points are within
    # |u| + |v| + radius of the middle in each coordinate. `samples` feelers at a hit, 1 of others;
    # `surface` = the primitive by which rays see it, -1 without one
    "Light": (
        ("place", "float4"), ("axis", "float4"), ("u", "float4"), ("v", "float4"),
        ("kind", "int"), ("falloff", "int"), ("angle", "float"), ("width", "float"),
        ("samples", "int"), ("extended", "int"), ("two_sided", "int"), ("surface", "int"),
        ("share", "float"), ("radius", "float"), ("pad0", "int"), ("pad1", "int"),
        ("intensity", "float@BANDS"), ("pad", "float@-BANDS"),
    ),
    # --- pictures on surfaces -----------------------------------------------------------------------------
    # `first` = its first texel, three floats each, rows from the top; (u, v) are first scaled and moved.
    # `levels` smaller pictures of it are textures, too: the largest is this one's number and `smaller`
    "Texture": (
        ("first", "int"), ("width", "int"), ("height", "int"), ("wrap", "int"), ("nearest", "int"),
        ("scale_u", "float"), ("scale_v", "float"), ("offset_u", "float"), ("offset_v", "float"),
        ("levels", "int"), ("smaller", "int"),
    ),
    # Of each material the textures in place of its colours (PICTURES), -1 where it has none, and the map of
    # its normals, with what their x and y are scaled by
    "Pictured": (
        ("color", "int"), ("highlight", "int"), ("mirror", "int"), ("tint", "int"), ("emission", "int"),
        ("normal_map", "int"), ("normal_scale", "float"),
    ),
    # How primitives have u and v (MAPPINGS): of a vector p the numbers row.xyz . p + row.w. Corners of a
    # mesh's triangle number i: from 3 (i + corners) on, two float4 a triangle in section `corner_uv`.
    # `quadric`: MAP_NORMAL, of a quadric and not of a sphere
    "Mapping": (
        ("row_u", "float4"), ("row_v", "float4"), ("row_w", "float4"),
        ("kind", "int"), ("corners", "int"), ("quadric", "int"), ("pad0", "int"),
    ),
    # the reflectances that red, green and blue 1 of a texel stand for; `shown`: of which of PICTURES there
    # are any, 1 << number
    "Primaries": (
        ("shown", "int"), ("red", "float@BANDS"), ("green", "float@BANDS"), ("blue", "float@BANDS"),
    ),
    # What holds for the whole scene; section `scene` has exactly one
    "SceneInfo": (
        ("primitives", "int"), ("unbounded", "int"), ("nodes", "int"), ("lights", "int"),
        ("ambient_samples", "int"), ("tinted", "int"), ("spd", "int"), ("one_sided", "int"),
        # is there a light with extent; how many are seen: their primitives are the last
        ("extended", "int"), ("surfaces", "int"),
        ("rough", "int"),  # is there a rough mirror
        ("medium_ior", "float"), ("min_weight", "float"),
        ("background_width", "int"), ("background_height", "int"),
        ("ambient", "float@BANDS"), ("background", "float@BANDS"), ("depth_color", "float@BANDS"),
        # the light that red, green and blue 1 of the background image stand for
        ("sky_red", "float@BANDS"), ("sky_green", "float@BANDS"), ("sky_blue", "float@BANDS"),
    ),
    # --- camera: everything the pass `generate` needs; vectors are unit, `half` = tan(fov/2) or size/2 ------
    "Camera": (
        ("origin", "float4"), ("forward", "float4"), ("right", "float4"), ("up", "float4"),
        ("half_width", "float"), ("half_height", "float"), ("shift_x", "float"), ("shift_y", "float"),
        ("near", "float"), ("orthographic", "int"), ("width", "int"), ("height", "int"),
        ("grid", "int"), ("jitter", "int"), ("seed", "uint"),
        ("aperture", "float"),  # radius of the lens, 0 for a pinhole
        ("focus", "float"),  # how far along the view is sharp
        ("filter", "int"),  # 0 averages the samples of a pixel's own square, one of FILTERS weighs others
        ("reach", "float"),  # of the filter, in pixels from the middle of one
        ("pad0", "int"),
    ),
}

# fmt: on

# kind of primitive -> the section of WORLD that its records are in; the kernels know it by its place here
SECTIONS: Final = {
    "SPHERE": "spheres", "PLANE": "planes", "DISK": "disks", "TRIANGLE": "triangles", "POLYGON": "polygons",
    "QUADRIC": "quadrics",
}  # fmt: skip
KINDS: Final = {kind: number for number, kind in enumerate(SECTIONS)}
# in kernels LIGHT_POINT, sampled by `light_point`
LIGHT_KINDS: Final = {"POINT": 0, "DIRECTIONAL": 1, "SPOT": 2}
EXTENDED_KINDS: Final = {"RECTANGLE": 16, "DISK": 17, "SPHERE": 18}  # likewise, a point at a time
FALLOFF: Final = {"FALLOFF_NONE": 0, "INVERSE_SQUARE": 1}
FRESNEL: Final = {"CONSTANT": 0, "FRESNEL": 1, "SCHLICK": 2, "CONDUCTOR": 3}
BLOCKS: Final = {"BLOCK_TRIANGLE": 0, "BLOCK_SPHERE": 1, "BLOCK_OTHER": 2}  # kinds of leaves
FILTERS: Final = {"TENT": 1, "GAUSSIAN": 2, "MITCHELL": 3}  # in kernels FILTER_TENT; 0 is the box
REACH: Final = {"tent": 1.0, "gaussian": 2.0, "mitchell": 2.0}  # pixels from a pixel's middle
# what u and v are made of: an outward normal or a point seen as on a sphere; radius and angle, angle and
# height about an axis; coordinates along two axes; corners of triangles
MAPPINGS: Final = {
    "MAP_NORMAL": 0, "MAP_SPHERE": 1, "MAP_POLAR": 2, "MAP_AXIAL": 3, "MAP_FLAT": 4, "MAP_MESH": 5,
}  # fmt: skip
WRAP: Final = {"WRAP_REPEAT": 0, "WRAP_CLAMP": 1, "WRAP_MIRROR": 2}
# field of the record Pictured -> of the scene's Material
PICTURES: Final = {
    "color": "color", "highlight": "highlight_color", "mirror": "reflection_color",
    "tint": "transmission_color", "emission": "emission",
}  # fmt: skip
CHECKER: Final = {"PLAIN": 0, "CHECKER_FLAT": 1, "CHECKER_SPHERE": 2}

# section name -> element type, in the order of the kernels' parameters
WORLD: Final[dict[str, str]] = {
    "scene": "SceneInfo",
    "primitives": "Primitive",
    "spheres": "Sphere",
    "planes": "Plane",
    "disks": "Disk",
    "triangles": "Triangle",
    "normals": "float4",  # corner normals of smooth triangles, three a triangle
    "polygons": "Polygon",
    "vertices": "float4",  # corners of polygons
    "quadrics": "Quadric",
    "unbounded": "int",  # primitive numbers of planes and unbounded quadrics: tested for every ray
    # the tree over the others and its leaves; written by the builder on the device
    "nodes": "WideNode",
    "triangle_blocks": "TriangleBlock",
    "sphere_blocks": "SphereBlock",
    "order": "int",  # primitive numbers of the leaves of other kinds, eight a leaf, filled up with -1
    "materials": "Material",
    "lights": "Light",
    "background": "float",  # lat-long image, rows from the top, red, green and blue of a pixel
}

# sections that kernels for scenes with pictures on surfaces (`RayFormat.images`) receive besides
IMAGES: Final[dict[str, str]] = {
    "textures": "Texture",
    "texels": "float",
    "pictured": "Pictured",
    "mappings": "Mapping",
    "mapping_of": "int",  # of each primitive; -1 where no material asks for u and v
    "corner_uv": "float4",
    "primaries": "Primaries",
}

# What travels between the passes, as parameters of the kernels: field of the Python object
# (`clrt.engine.queues`) -> type and name of the parameter
QUEUE: Final = {
    "rays": "float *rays",
    "pixel_of": "uint *pixel_of",
    "path": "uint *path",
    "weight": "float *weights",
    "media": "int *media",
    "n": "uint n",
}
HITS: Final = {
    "t": "float *hit_t",
    "primitive": "int *hit_primitive",
    "surfaces": "float *surfaces",
    "code": "int *surface_code",
}
# pixels' numbers and samples of each, of rays of generation 0; deeper there are none, and 0 samples
PIXELS: Final = {"numbers": "uint *numbers", "seed": "uint seed", "samples": "uint samples"}
SHADED: Final = {"local": "float *local_radiance", "spawn": "uint *spawn"}
FEELERS: Final = {
    "first": "uint *first_feeler",
    "owner": "uint *owner",
    "rays": "float *feeler_rays",
    "seen": "uint *seen",
    "own": "int *own",
    "filter": "float *filter",
}
# A caller's rays as given: a step of 0 repeats the first vector, bounds without arrays hold for all
ASKED: Final = {
    "origins": "const float *origins",
    "directions": "const float *directions",
    "t_min": "const float *t_min",
    "t_max": "const float *t_max",
    "least": "float least",
    "most": "float most",
    "origin_step": "uint origin_step",
    "direction_step": "uint direction_step",
    "n": "uint n",
    "width": "uint width",  # of the picture whose rays these are
    "patched": "uint patched",  # rays that are taken patch by patch (kernels/asked.clh)
}
# a queue that is written while another is read: all but the number of rays, the last parameter of a queue
CHILD: Final = {field: text.replace("*", "*child_") for field, text in QUEUE.items() if "*" in text}

RAY_FIELDS: Final = ("ORIGIN_X", "ORIGIN_Y", "ORIGIN_Z", "DIRECTION_X", "DIRECTION_Y", "DIRECTION_Z", "T_MAX")

# What the pass `surface` finds at a hit: the point moved back onto its primitive, the geometric normal turned
# to the side the ray came from, the shading normal, and how far spawned rays start off the surface. With it
# goes a word: material * SURFACE_MATERIAL + the flags that are set, or -1 on a miss.
SURFACE_FIELDS: Final = (
    "POINT_X", "POINT_Y", "POINT_Z", "NORMAL_X", "NORMAL_Y", "NORMAL_Z",
    "SHADING_X", "SHADING_Y", "SHADING_Z", "LEAVE_BY",
)
# With lists of media also the materials (as integers, -1: medium_ior) whose indices meet there
TOP_FIELDS: Final = ("TOP_BEFORE", "TOP_AFTER")
# and last, in scenes with pictures, where in them it lies, and what that of the material's colour shows there
UV_FIELDS: Final = ("TEXTURE_U", "TEXTURE_V", "TEXEL_R", "TEXEL_G", "TEXEL_B")
# and with mip levels how far a ray's footprint reaches in u and v, and how wide its cone is there
MIP_FIELDS: Final = ("REACH_U", "REACH_V", "CONE_THERE")
# With mip levels a ray carries behind its weights how wide its cone is where it starts, and by how much it
# grows on its way, a unit of length
CONE: Final = ("CONE_WIDTH", "CONE_SPREAD")
SURFACE: Final = {"SURFACE_INSIDE": 1, "SURFACE_SECOND_COLOR": 2, "SURFACE_EDGE": 4, "SURFACE_MATERIAL": 8}

# A ray's `path` word: upper 28 bits a key that other paths of the picture share only by chance, lower 4 flags
PATH: Final = {
    "PATH_ROUTE": 3,  # 0 direct, 1 reflection, 2 transmission: the first such bounce
    "PATH_GATHERED": 4,  # descends from an ambient ray
    "PATH_GATHERED_FIRST": 8,  # ... that left from generation 0
    "PATH_FLAGS": 15,
}

# What the pass `shade` finds that a ray will spawn, packed into one word; streams are what is counted from it
SPAWN: Final = {
    "SPAWN_FEELERS": 0xFFFF,  # number of shadow feelers
    "SPAWN_REFLECTION": 1 << 16,
    "SPAWN_TRANSMISSION": 1 << 17,
    "SPAWN_AMBIENT": 1 << 18,  # `ambient_samples` rays
    "SPAWN_HIT": 1 << 19,
    "SPAWN_TOTAL_INTERNAL": 1 << 20,
    "SPAWN_GROUP": 1 << 21,  # times the number of narrow transmission rays
    "SPAWN_GROUPS": 127 << 21,
    "SPAWN_LOCAL": 1 << 28,  # there is local light: not all bands are 0
}
# Why a picture is refused while it is traced: a ray is in more than MEDIA, a feeler crosses more than PANES
OVERFLOW: Final = {"MANY_MEDIA": 1, "MANY_PANES": 2}
# What of a feeler is known: 0 where something blocks the light
SEEN: Final = {
    "CLEAR": 1,  # nothing is in its way
    "UNTRACED": 2,  # nothing yet; it is still to be traced
    "FILTERED": 0x7FFFFFFF,  # it is seen, and `filter` says what share of each band comes through
}
STREAMS: Final = ("FEELERS", "REFLECTION", "TRANSMISSION", "AMBIENT", "HIT", "TOTAL_INTERNAL", "GROUPS")

TERMS: Final = {f"TERM_{name.upper()}": 1 << number for number, name in enumerate(layers.TERMS)} | {
    "TERM_ALL": (1 << len(layers.TERMS)) - 1
}

WIDE: Final = 16  # boxes of a node of the tree
ARRANGED: Final = 16384  # rays that one work-item puts in order
CHUNK: Final = 256  # rays that one work-item of the compaction counts

# A ray's box test and every primitive's box are widened by this times the largest |coordinate|: more than
# what a hit may lie before the box by (triangle.clh), so that the tree never rejects what brute force accepts
PAD: Final = 32 * 2.0**-24
QUADRIC_PAD: Final = 64 * 2.0**-24  # roots of a quadratic form carry more rounding
FEELER_REACH: Final = 1 - 2.0**-14  # of the way to a light: what lies in its plane hides nothing
OFFSET: Final = 4 * 2.0**-23  # distance by which spawned rays leave a surface, times the largest |coordinate|
ALONG: Final = 2 * 2.0**-23  # and how far back on the ray that met it, times its length, if they stay before
FROM_EDGE: Final = 4  # times as far from an edge
BESIDE: Final = 256  # times OFFSET: nearer to its start a ray may have crossed an edge by its other side
BRIGHTEST: Final = 1e30  # of a band of a pixel: room for the sums over bands that make it a colour

_NUMPY: Final[dict[str, tuple[type[np.generic], tuple[int, ...]]]] = {
    "float4": (np.float32, (4,)),
    "float": (np.float32, ()),
    "int": (np.int32, ()),
    "uint": (np.uint32, ()),
}


def field_length(kind: str, bands: int) -> tuple[str, int]:
    """C type and array length of a field; `@-BANDS` pads a band array to a multiple of 4."""
    base, _, count = kind.partition("@")
    if not count:
        return base, 0
    if count.isdigit():
        return base, int(count)
    return base, bands if count == "BANDS" else -bands % 4


@cache
def dtype(name: str, bands: int = BANDS) -> np.dtype:
    """The numpy dtype of a record of RECORDS, or of an element type such as "float4" (shape (4,))."""
    if name not in RECORDS:
        element, shape = _NUMPY[name]
        return np.dtype((element, shape))
    fields: list[tuple[str, type[np.generic], tuple[int, ...]]] = []
    for field, kind in RECORDS[name]:
        base, length = field_length(kind, bands)
        scalar, shape = _NUMPY[base]
        if length:
            fields.append((field, scalar, (length,)))
        elif "@" not in kind:
            fields.append((field, scalar, shape))
    return np.dtype(fields)


def world(images: bool) -> dict[str, str]:
    """The sections of a scene with pictures on surfaces, or without: name and element type."""
    return WORLD | IMAGES if images else WORLD


def streams(group: int = 0) -> tuple[str, ...]:
    """The streams that are counted; the last one where there are dispersion groups of `group` bands."""
    return STREAMS if group else STREAMS[:-1]


@dataclass(frozen=True)
class RayFormat:
    """What rays carry: the compile-time constants of the kernels.

    bands: of the scene. media: places in the list of media, 0 where there are none. group: bands that
    dispersion bends together, 0 without it. narrow: the rays of a queue have one such group each. images:
    hits know where in pictures they lie. mips: some pictures have mip levels, and rays carry cones. extent:
    some lights have extent or are seen, or some surfaces are rough.
    """

    bands: int = BANDS
    media: int = 0
    group: int = 0
    narrow: bool = False
    images: bool = False
    mips: bool = False
    extent: bool = False

    @property
    def carried(self) -> int:
        """Bands that a ray of a queue carries."""
        return self.group if self.narrow else self.bands

    @property
    def values(self) -> int:
        """Words of a ray's weight, light or contribution: bands, which a narrow ray's first is, the cone."""
        return self.cone + (len(CONE) if self.mips else 0)

    @property
    def cone(self) -> int:
        """Which of these words is the first of the cone, or would be."""
        return self.carried + self.narrow

    @property
    def surface_fields(self) -> int:
        """How many fields a surface has."""
        mips = len(MIP_FIELDS) if self.mips else 0
        return self.place + (len(UV_FIELDS) if self.images else 0) + mips

    @property
    def place(self) -> int:
        """Which of these fields is the first of where it lies in pictures, or would be."""
        return len(SURFACE_FIELDS) + (len(TOP_FIELDS) if self.media else 0)


def filter_grid(name: str) -> int:
    """The least side of a pixel's grid of samples for this filter: they lie a pixel apart, not farther."""
    return int(2 * REACH.get(name, 0.5))
