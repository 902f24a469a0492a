"""Scenes of extreme numbers, of any size that float32 holds: what the checks of single values let through."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

Table = dict[str, Any]
SIZES: Final = (0.0, 1e-45, 1e-38, 1e-30, 1e-10, 1e-3, 0.5, 1.0, 2.0, 1e3, 1e10, 1e18, 1e19, 1e30, 3e38)
_FAR: Final = SIZES[: SIZES.index(1e18) + 1]  # what a camera may have, and where a light may be
_LENGTHS: Final = (1e-18, *_FAR[_FAR.index(1e-10) :])  # whose squares float32 holds: of lights with extent


def extreme_scene(generator: np.random.Generator) -> Table:
    """A scene whose numbers are of any size that float32 holds, which may or may not be a right one."""

    def number(least: float = 0.0, sizes: tuple[float, ...] = SIZES) -> float:
        value = float(generator.choice(sizes))
        return value if least >= 0 or generator.random() < 0.5 else -value

    def some(*values: float) -> float:
        return float(generator.choice(values))

    def vector() -> list[float]:
        return [number(-1) for _ in range(3)]

    def place() -> list[float]:
        sizes = SIZES if generator.random() < 0.2 else _FAR
        return [number(-1, sizes) for _ in range(3)]

    def color() -> Any:
        kind = generator.integers(5)
        if kind == 0:
            return {"blackbody": float(generator.choice([500, 1000, 6500, 1e5])), "scale": number()}
        if kind == 1:
            width = float(generator.choice([0.01, 30, 1e30]))
            return {"gaussian": [float(generator.uniform(360, 830)), width], "scale": number()}
        if kind == 2:
            return [[400, number()], [500, number()], [700, number()]]
        return number() if kind == 3 else [number() for _ in range(3)]

    def index() -> Any:
        choices: list[Any] = ["BK7", 1.5, number(), [[400, 1 + number()], [700, 1.2]]]
        choices.append({"cauchy": [1.5, number(-1)]})
        choices.append({"sellmeier": [[number(-1), number(-1)], [number(-1), number(-1)]]})
        return choices[generator.integers(len(choices))]

    def material() -> Table:
        out: Table = {"color": color(), "emission": color(), "absorption": number(), "ior": index()}
        out |= {name: number() for name in ("diffuse", "specular", "shininess", "reflection", "transmission")}
        out |= {
            "fresnel": [False, True, "schlick"][generator.integers(3)],
            "thin": bool(generator.integers(2)),
        }
        if generator.random() < 0.2:
            metal = ["gold", {"eta": number(), "k": number()}][generator.integers(2)]
            out |= {"conductor": metal, "transmission": 0, "fresnel": False}
        if generator.random() < 0.3:  # what is rough transmits nothing
            out |= {"roughness": some(1e-45, 0.009, 0.01, 0.3, 1.0), "transmission": 0}
        return out

    def shape() -> Table:
        shapes: list[Table] = [
            {"type": "sphere", "center": vector(), "radius": number()},
            {"type": "plane", "point": vector(), "normal": vector()},
            {"type": "box", "min": vector(), "max": vector()},
            {"type": "disk", "center": vector(), "normal": vector(), "radius": number()},
            {"type": "cylinder", "p0": vector(), "p1": vector(), "radius": number(), "caps": True},
            {"type": "cone", "p0": vector(), "p1": vector(), "r0": number(), "r1": number(), "caps": True},
            {"type": "ellipsoid", "center": vector(), "radii": [number() for _ in range(3)]},
            {"type": "paraboloid", "apex": vector(), "axis": vector(), "focal": number(), "height": number()},
            {"type": "quadric", "coefficients": [number(-1) for _ in range(10)]},
            {"type": "polygon", "points": [vector() for _ in range(3)]},
            {"type": "mesh", "vertices": [vector() for _ in range(4)], "smooth": bool(generator.integers(2)),
             "faces": [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]},
        ]  # fmt: skip
        out = shapes[generator.integers(len(shapes))] | {"material": material()}
        if out["type"] != "plane" and generator.random() < 0.3:
            steps: list[Table] = [{"scale": vector()}, {"translate": vector()}, {"rotate": ["x", number(-1)]}]
            out["transform"] = [steps[k] for k in generator.integers(3, size=2)]
        return out

    def light() -> Table:
        kind = generator.choice(["directional", "point", "spot", "rectangle", "disk", "sphere"])
        where: Table = {"type": str(kind)}
        if kind == "directional":
            return where | {"direction": vector(), "intensity": color()}
        if kind in ("point", "spot"):
            falloff = ["none", "inverse-square"][generator.integers(2)]
            where |= {"position": place(), "falloff": falloff, "intensity": color()}
            if kind == "spot":
                where["target"] = place()
                where |= {"angle": some(1e-38, 1e-3, 30.0, 90.0), "penumbra": some(0.0, 1e-45, 0.5, 1.0)}
            return where
        if kind == "rectangle":
            where |= {"u": vector(), "v": vector()}
            if generator.random() < 0.7:
                where |= {"u": [0, 0, some(*_LENGTHS)], "v": [some(*_LENGTHS), 0, 0]}
        else:
            where["radius"] = some(*_LENGTHS) if generator.random() < 0.7 else number()
        if kind == "disk":
            where["normal"] = vector()
        where |= {"center": place(), "radiance": color(), "samples": int(generator.choice([1, 2, 7, 16]))}
        return where | {name: bool(generator.integers(2)) for name in ("two_sided", "visible")}

    near = [some(*_FAR) * some(-1, 1) for _ in range(3)]
    camera: Table = {
        "origin": near if generator.random() < 0.9 else vector(), "target": vector(),
        "fov": some(1e-30, 45, 179.999), "width": 4, "height": 3,
        "near": some(*_FAR), "size": 1 + some(*_FAR),
        "type": ["perspective", "orthographic"][generator.integers(2)],
    }  # fmt: skip
    if generator.random() < 0.3:
        camera |= {"aperture": some(*_FAR), "focus": some(*SIZES[3:])}
    if generator.random() < 0.3:
        camera |= {"filter": str(generator.choice(["tent", "gaussian", "mitchell"])), "spp": 4}
    table: Table = {
        "camera": camera, "ambient": color(), "background": color(), "depth_color": color(),
        "medium_ior": float(generator.choice([1e-3, 1.0, 1e6])), "min_weight": number(),
        "lights": [light() for _ in range(2)],
        "shapes": [shape() for _ in range(generator.integers(1, 4))],
    }  # fmt: skip
    if generator.random() < 0.6:
        table["spectrum"] = {
            "bands": int(generator.integers(3, 12)),
            "white_balance": bool(generator.integers(2)),
        }
        table["spectrum"]["response"] = ["cie", "thesis-2011"][generator.integers(2)]
    if generator.random() < 0.2:
        table["adaptive"] = {"spp": 4 * camera.get("spp", 1), "threshold": some(0.0, 1e-45, 0.01, 1.0)}
    return table


def calm(table: Table, generator: np.random.Generator) -> Table:
    """The scene with most parts made ordinary, so that more than a few scenes are accepted."""
    out = dict(table)
    seen = {name: table["camera"][name] for name in ("aperture", "focus", "filter", "spp")
            if name in table["camera"]}  # fmt: skip
    usual_camera = {"origin": [0, 1, 5], "target": [0, 0, 0], "width": 2, "height": 2, **seen}
    for key, usual in (("camera", usual_camera), ("medium_ior", 1.0), ("ambient", 0.1), ("background", 0.1),
                       ("depth_color", 0.0), ("lights", table["lights"][1:])):  # fmt: skip
        if generator.random() < 0.7:
            out[key] = usual
    if generator.random() < 0.5:
        out["lights"] = [_near(light) for light in out["lights"]]
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1.0}
    out["shapes"] = [
        {**ball, "material": shape["material"]} if generator.random() < 0.5 else shape
        for shape in out["shapes"]
    ]
    for shape in out["shapes"]:
        for name in list(shape["material"]):
            if generator.random() < 0.4:
                del shape["material"][name]
    return out


def _near(light: Table) -> Table:
    """The light in an ordinary place."""
    usual = {"position": [1, 3, 2], "center": [1, 3, 2], "target": [0, 0, 0], "direction": [0, -1, 0]}
    return {key: usual.get(key, value) for key, value in light.items()}
