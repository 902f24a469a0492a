"""Numbers as others have published them, and as docs/ states them: typed in, none from the package."""

from __future__ import annotations

# n_d and Abbe's number, n_F - n_C: SCHOTT's data sheets of N-BK7, N-SF10, N-SF11 (2023); of silica Malitson,
# J. Opt. Soc. Am. 55, 1205 (1965), table II, to the digits given there
GLASSES = {
    "BK7": (1.51680, 64.17, 1e-5, 5e-3),
    "SF10": (1.72828, 28.53, 1e-5, 5e-3),
    "SF11": (1.78472, 25.68, 1e-5, 5e-3),
    "silica": (1.45846, 67.82, 1e-5, 5e-3),
}
LINES = {"d": 587.5618, "F": 486.1327, "C": 656.2725, "D": 589.29}  # nm
# at the sodium line: diamond, CRC Handbook of Chemistry and Physics; water of 20 degrees, Daimon and Masumura
SODIUM = {"diamond-dispersive": (2.417, 1e-3), "water-dispersive": (1.33336, 5e-5)}
# docs/model.md, "Reflection and transmission"
NAMED_INDEX = {"air": 1.0, "water": 1.333, "ice": 1.31, "glass": 1.5, "diamond": 2.419}

# CIE 15:2004, table T.4: x, y, z of the 1931 observer
OBSERVER = {
    400: (0.01431, 0.000396, 0.06785), 450: (0.3362, 0.038, 1.77211), 500: (0.0049, 0.323, 0.272),
    550: (0.43345, 0.99495, 0.00875), 555: (0.51205, 1.0, 0.00575), 600: (1.0622, 0.631, 0.0008),
    650: (0.2835, 0.107, 0.0), 700: (0.011359, 0.004102, 0.0),
}  # fmt: skip
# CIE 15:2004, table T.1
ILLUMINANTS = {
    "A": {400: 14.7080, 450: 33.0859, 500: 59.8611, 560: 100.0, 600: 129.043, 700: 198.261},
    "D65": {400: 82.7549, 450: 117.008, 500: 109.354, 550: 104.046, 560: 100.0, 600: 90.0062, 700: 71.6091},
    "E": {360: 100.0, 560: 100.0, 830: 100.0},
}
# CIE 15:2004, tables T.3 and T.8: chromaticity x, y
CHROMATICITY = {
    "A": (0.44758, 0.40745), "D65": (0.31272, 0.32903), "E": (1 / 3, 1 / 3),
    "F1": (0.3131, 0.3371), "F2": (0.3721, 0.3751), "F3": (0.4091, 0.3941), "F4": (0.4402, 0.4031),
    "F5": (0.3138, 0.3452), "F6": (0.3779, 0.3882), "F7": (0.3129, 0.3292), "F8": (0.3458, 0.3586),
    "F9": (0.3741, 0.3727), "F10": (0.3458, 0.3588), "F11": (0.3805, 0.3769), "F12": (0.4370, 0.4042),
}  # fmt: skip
# 8-bit sRGB of the ColorChecker as its maker printed it (X-Rite, 2009), for another instrument's chart
CHART = (
    (115, 82, 68), (194, 150, 130), (98, 122, 157), (87, 108, 67), (133, 128, 177), (103, 189, 170),
    (214, 126, 44), (80, 91, 166), (193, 90, 99), (94, 60, 108), (157, 188, 64), (224, 163, 46),
    (56, 61, 150), (70, 148, 73), (175, 54, 60), (231, 199, 31), (187, 86, 149), (8, 133, 161),
    (243, 243, 242), (200, 200, 200), (160, 160, 160), (122, 122, 121), (85, 85, 85), (52, 52, 52),
)  # fmt: skip
# IEC 61966-2-1: bytes and linear values
SRGB = {0: 0.0, 10: 0.00303527, 55: 0.0382044, 118: 0.181164, 188: 0.502886, 254: 0.991102, 255: 1.0}
# ITU-R BT.709-6: linear RGB to XYZ, from its primaries and white, to four digits
XYZ_OF_RGB = ((0.4124, 0.3576, 0.1805), (0.2126, 0.7152, 0.0722), (0.0193, 0.1192, 0.9505))

# docs/scene-files.md and clrt/scene/scene.schema.json say what holds where a key is not given
MATERIAL = {
    "color": 0.8, "ambient": None, "diffuse": 1.0, "specular": 0.0, "shininess": 32.0, "reflection": None,
    "transmission": None, "ior": 1.5, "fresnel": False, "highlight_color": 1.0, "reflection_color": 1.0,
    "transmission_color": 1.0, "emission": 0.0, "absorption": 0.0, "priority": 0, "thin": False,
    "conductor": None, "roughness": 0.0, "normal_map": None,
}  # fmt: skip
CAMERA = {
    "type": "perspective", "fov": 45.0, "fov_axis": "horizontal", "size": 2.0, "near": 0.0, "mirror": False,
    "shift": (0.0, 0.0), "width": 640, "height": 480, "spp": 1, "jitter": None, "up": (0.0, 1.0, 0.0),
    "aperture": 0.0, "focus": None, "filter": "box",
}  # fmt: skip
SCENE = {
    "max_depth": 5, "min_weight": 0.0, "depth_color": 0.0, "background": 0.0, "ambient": 0.0,
    "ambient_samples": 0, "medium_ior": 1.0, "one_sided": "none", "shadow": "opaque", "conformance": "none",
    "spectrum": None, "adaptive": None, "version": 1,
}  # fmt: skip
ADAPTIVE = {"spp": 64, "threshold": 0.01}
SPECTRUM = {"bands": 24, "range": (380.0, 750.0), "white": "D65", "white_balance": False,
            "response": "cie", "group": 1}  # fmt: skip
CHECKER = {"colors": (0.9, 0.1), "size": 1.0, "divisions": 16}
POINT = {"intensity": 1.0, "falloff": "none"}
SPOT = {**POINT, "angle": 30.0, "penumbra": 0.1}
AREA = {"radiance": 1.0, "samples": 16, "two_sided": False, "visible": True}
IMAGE = {
    "encoding": None, "tint": (1.0, 1.0, 1.0), "part": None, "wrap": "repeat", "filter": "linear",
    "scale": (1.0, 1.0), "offset": (0.0, 0.0),
}  # fmt: skip
# docs/model.md, "Light at a hit", "Reflection and transmission": material -> ka, kr, kt
COEFFICIENTS = [
    ({}, (1.0, 0.0, 0.0)),
    ({"diffuse": 0.3}, (0.3, 0.0, 0.0)),
    ({"diffuse": 0.3, "ambient": 0.2}, (0.2, 0.0, 0.0)),
    ({"ambient": 0.0, "reflection": 0.4}, (0.0, 0.4, 0.0)),
    ({"transmission": 0.6}, (1.0, 0.0, 0.6)),
    ({"fresnel": True}, (1.0, 1.0, 1.0)),
    ({"fresnel": True, "reflection": 0.5, "transmission": 0.0}, (1.0, 0.5, 0.0)),
    ({"fresnel": "schlick"}, (1.0, 0.0, 0.0)),
    ({"conductor": "gold"}, (1.0, 1.0, 0.0)),
    ({"conductor": "gold", "fresnel": True}, (1.0, 1.0, 0.0)),
]

_C, _S = 0.8660254037844386, 0.5  # cosine and sine of 30 degrees
# steps -> the matrix that they are, written out by hand
TRANSFORMS = {
    "move": ([{"translate": [1, -2, 3]}], [[1, 0, 0, 1], [0, 1, 0, -2], [0, 0, 1, 3], [0, 0, 0, 1]]),
    "one scale": ([{"scale": 2}], [[2, 0, 0, 0], [0, 2, 0, 0], [0, 0, 2, 0], [0, 0, 0, 1]]),
    "three scales": ([{"scale": [2, -1, 0.5]}],
                     [[2, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0.5, 0], [0, 0, 0, 1]]),
    # counter-clockwise seen from the axis' tip: about x from y to z, about y from z to x, about z from x to y
    "about x": ([{"rotate": ["x", 30]}], [[1, 0, 0, 0], [0, _C, -_S, 0], [0, _S, _C, 0], [0, 0, 0, 1]]),
    "about y": ([{"rotate": ["y", 30]}], [[_C, 0, _S, 0], [0, 1, 0, 0], [-_S, 0, _C, 0], [0, 0, 0, 1]]),
    "about z": ([{"rotate": ["z", 30]}], [[_C, -_S, 0, 0], [_S, _C, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]),
    "a quarter back": ([{"rotate": ["z", -90]}], [[0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]),
    # a third of a turn about the diagonal, of any length: x to y, y to z, z to x
    "about the diagonal": ([{"rotate": [[2, 2, 2], 120]}],
                           [[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]]),
    "the first acts first": ([{"scale": 2}, {"translate": [1, 2, 3]}],
                             [[2, 0, 0, 1], [0, 2, 0, 2], [0, 0, 2, 3], [0, 0, 0, 1]]),
    "and the last last": ([{"translate": [1, 2, 3]}, {"scale": 2}],
                          [[2, 0, 0, 2], [0, 2, 0, 4], [0, 0, 2, 6], [0, 0, 0, 1]]),
    "three steps": ([{"scale": [1, 2, 1]}, {"rotate": ["z", 90]}, {"translate": [0, 1, 0]}],
                    [[0, -2, 0, 0], [1, 0, 0, 1], [0, 0, 1, 0], [0, 0, 0, 1]]),
    "a matrix": ([[1, 2, 3, 4], [0, 1, 5, 6], [0, 0, 1, 7], [0, 0, 0, 1]],
                 [[1, 2, 3, 4], [0, 1, 5, 6], [0, 0, 1, 7], [0, 0, 0, 1]]),
}  # fmt: skip
# a corner between triangles of areas 3, 1.5 and 1: sides 2, 3, 1 along x, y, z
CORNER = {
    "vertices": [[0, 0, 0], [2, 0, 0], [0, 3, 0], [0, 0, 1]],
    "faces": [[0, 1, 2], [0, 2, 3], [0, 3, 1]],
    # (3, 2, 6), (0, 2, 6), (3, 0, 6), (3, 2, 0), each of length 1
    "normals": [[3 / 7, 2 / 7, 6 / 7], [0, 2 / 40**0.5, 6 / 40**0.5], [3 / 45**0.5, 0, 6 / 45**0.5],
                [3 / 13**0.5, 2 / 13**0.5, 0]],
}  # fmt: skip
