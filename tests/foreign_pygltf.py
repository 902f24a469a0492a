"""A model that pygltflib writes: solid glass and what glows by KHR extensions, with a camera and a light."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pygltflib as gltf

BALL_AND_SHEET = np.array(
    [
        [[1, 0, -1], [-1, 0, -1], [0, 2, 0]], [[0, 0, 1], [1, 0, -1], [0, 2, 0]],
        [[-1, 0, -1], [0, 0, 1], [0, 2, 0]], [[0, 0, 1], [-1, 0, -1], [1, 0, -1]],
        [[-3, -0.5, -3], [3, -0.5, 3], [3, -0.5, -3]],
    ],
    "<f4",
)  # fmt: skip
"""Five triangles: a tetrahedron of glass, and a floor that glows."""
ATTENUATION, DISTANCE, IOR = (0.5, 1.0, 0.25), 2.0, 1.45

BY_HAND = f"""
ambient = 0.05
background = 0.05
shadow = "tinted"
[camera]
origin = [0, 1, 6]
target = [0, 1, 0]
fov = {math.degrees(0.75)!r}
fov_axis = "vertical"
near = 0.5
[[lights]]
type = "point"
position = [1, 3, 4]
intensity = {20 / math.pi!r}
falloff = "inverse-square"
[[shapes]]
type = "mesh"
vertices = {BALL_AND_SHEET[:4].reshape(-1, 3).tolist()}
faces = {np.arange(12).reshape(-1, 3).tolist()}
[shapes.material]
color = 0.9
diffuse = 0
fresnel = true
ior = {IOR}
reflection = 1
transmission = 1
transmission_color = 0.9
absorption = {[-math.log(part) / DISTANCE + 0.0 for part in ATTENUATION]}
specular = 1
shininess = 199.5
[[shapes]]
type = "mesh"
vertices = {BALL_AND_SHEET[4:].reshape(-1, 3).tolist()}
faces = [[0, 1, 2]]
[shapes.material]
color = 0.5
diffuse = 0.96
fresnel = "schlick"
highlight_color = 0.04
specular = 0.25
shininess = 1
emission = [3, 1.5, 0.75]
"""
"""The same scene by docs/models.md."""


def khr_extensions(folder: Path) -> Path:
    """A .glb by pygltflib's own classes and its `save`."""
    glass = {
        "KHR_materials_transmission": {"transmissionFactor": 1.0}, "KHR_materials_ior": {"ior": IOR},
        "KHR_materials_volume": {
            "thicknessFactor": 1.0, "attenuationColor": list(ATTENUATION), "attenuationDistance": DISTANCE,
        },
    }  # fmt: skip
    glow = {"KHR_materials_emissive_strength": {"emissiveStrength": 3.0}}
    lamp = {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 20.0}]}}
    data = BALL_AND_SHEET.tobytes()
    counts, starts = (12, 3), (0, 144)
    corners = [BALL_AND_SHEET[:4].reshape(-1, 3), BALL_AND_SHEET[4:].reshape(-1, 3)]
    model = gltf.GLTF2(
        scene=0, scenes=[gltf.Scene(nodes=[0, 1, 2, 3])],
        nodes=[
            gltf.Node(mesh=0, name="prism"), gltf.Node(mesh=1, name="floor"),
            gltf.Node(camera=0, translation=[0.0, 1.0, 6.0]),
            gltf.Node(translation=[1.0, 3.0, 4.0], extensions={"KHR_lights_punctual": {"light": 0}}),
        ],
        cameras=[gltf.Camera(type="perspective", perspective=gltf.Perspective(yfov=0.75, znear=0.5))],
        meshes=[gltf.Mesh(primitives=[gltf.Primitive(attributes=gltf.Attributes(POSITION=k), material=k)])
                for k in range(2)],
        materials=[
            gltf.Material(name="glass", extensions=glass, pbrMetallicRoughness=gltf.PbrMetallicRoughness(
                baseColorFactor=[0.9, 0.9, 0.9, 1.0], metallicFactor=0.0, roughnessFactor=0.0)),
            gltf.Material(name="glow", extensions=glow, emissiveFactor=[1.0, 0.5, 0.25],
                          pbrMetallicRoughness=gltf.PbrMetallicRoughness(
                              baseColorFactor=[0.5, 0.5, 0.5, 1.0], metallicFactor=0.0)),
        ],
        accessors=[
            gltf.Accessor(bufferView=k, componentType=gltf.FLOAT, count=counts[k], type=gltf.VEC3,
                          min=corners[k].min(axis=0).tolist(), max=corners[k].max(axis=0).tolist())
            for k in range(2)
        ],
        bufferViews=[
            gltf.BufferView(buffer=0, byteOffset=starts[k], byteLength=12 * counts[k],
                            target=gltf.ARRAY_BUFFER) for k in range(2)
        ],
        buffers=[gltf.Buffer(byteLength=len(data))],
        extensions=lamp, extensionsUsed=[*glass, *glow, *lamp],
    )  # fmt: skip
    model.set_binary_blob(data)
    path = folder / "pygltflib.glb"
    model.save(str(path))
    return path
