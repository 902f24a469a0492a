"""Values, keys and words that good inputs are spoiled with."""

from __future__ import annotations

from typing import Any, Final

NUMBERS: Final[tuple[Any, ...]] = (
    0, -0.0, 1, -1, 2, 3, 1e-45, 1e-38, 1e-30, 1e-7, 0.5, 1e3, 65535, 65536, 1e6, 1e10, 1e19, 1e30, 3.4e38,
    -3.4e38, 1e39, 1e308, 2**31 - 1, 2**31, 2**32, 2**63, 2**64, 10**40, float("nan"), float("inf"),
    -float("inf"), 1.0000001, 0.9999999, 180, 360, 90,
)  # fmt: skip
OTHERS: Final[tuple[Any, ...]] = (
    None, True, False, "", "x", "nan", "1e5", "glass", "D65", "gold", "../../etc/passwd", "/dev/zero",
    "/etc/passwd", "scene.toml", ".", "a" * 5000, "\x00", "\u202e\ud7ff", "%s%n", [], {}, [[]], [{}],
    {"type": "sphere"}, [1, 2], [1, 2, 3], [1, 2, 3, 4], [0, 0, 0], [1e30, 1e30, 1e30], [[0, 0, 0]] * 3,
    {"blackbody": 5000}, {"line": 555}, {"gaussian": [555, 0]}, [[400, 1], [300, 1]], [[555, -1], [600, 2]],
    {"band": [600, 500]}, {"translate": [1, 2, 3]}, [{"scale": [0, 1, 1]}], [{"rotate": [[0, 0, 0], 3]}],
    [{"scale": [1e20, 1e-20, 1]}], "mitchell", "tent", {"spp": 64}, {"spp": 4, "threshold": 0},
    {"type": "image", "file": "paint.png"}, {"type": "image", "file": "mesh.glb", "part": 0}, "repeat",
    "nearest",
    {"file": "paint.png"}, {"file": "paint.png", "scale": 1e30}, [[0, 0], [1, 0], [1, 1], [0, 1]],
)  # fmt: skip
KEYS: Final = (
    "max_depth", "min_weight", "background", "ambient", "ambient_samples", "medium_ior", "one_sided",
    "shadow", "spectrum", "conformance", "camera", "materials", "lights", "shapes", "type", "origin",
    "target", "up", "fov", "fov_axis", "size", "near", "mirror", "shift", "width", "height", "spp",
    "jitter", "aperture", "focus", "roughness", "filter", "adaptive", "threshold", "pose", "K",
    "color", "diffuse", "specular", "shininess", "reflection", "transmission", "ior", "fresnel",
    "thin", "emission", "absorption", "priority", "conductor", "position", "direction", "intensity",
    "falloff", "angle", "penumbra", "radiance", "samples", "two_sided", "visible", "u", "v",
    "center", "radius", "point", "normal", "points", "vertices", "faces", "normals", "file",
    "smooth", "coefficients", "clip", "radii", "p0", "p1", "r0", "r1", "caps", "apex", "axis", "focal",
    "height", "min", "max", "material", "name", "transform", "version", "depth_color", "bands", "range",
    "group", "response", "white", "$schema", "wrap", "encoding", "scale", "offset", "tint", "part",
    "normal_map", "uv", "highlight_color", "reflection_color", "transmission_color", "__class__", "folder",
    "limits",
)  # fmt: skip
WORDS: Final = (
    b"nan", b"inf", b"-1", b"0", b"1e39", b"1e-50", b"999999999999", b"2147483648", b"", b"\x00",
    b"\xff\xfe", b"#", b"p", b"pp", b"f", b"v", b"s", b"c", b"l", b"Surface", b"Mesh", b"Polygon", b"Point",
    b"Spectrum", b"None", b"[[", b"]]", b"{", b"}", b'"', b"=", b"[" * 3000, b"{" * 3000, b"a.b.c.d = 1\n",
    b"1_0", b"0x10", b"1e",
)  # fmt: skip
