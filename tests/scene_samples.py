"""A scene with one of everything."""

from __future__ import annotations

import numpy as np

from clrt.scene.scene import (
    Box,
    Camera,
    Checker,
    Cone,
    Cylinder,
    DirectionalLight,
    Disk,
    DiskLight,
    Ellipsoid,
    Material,
    Mesh,
    Paraboloid,
    Plane,
    PointLight,
    Polygon,
    Quadric,
    RectangleLight,
    Scene,
    Sphere,
    SphereLight,
    SpotLight,
    Step,
)

QUAD = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]


def every_kind() -> Scene:
    """A scene with every table, shape and kind of value."""
    red = Material(color=(0.9, 0.1, 0.1), specular=0.05, diffuse=0.5)
    return Scene(
        max_depth=3,
        background=(0.1, 0.2, 0.3),
        depth_color=0.5,
        shadow="tinted",
        camera=Camera(
            origin=(0, 1, 5), target=(0, 0, 0), spp=4, jitter=7, fov_axis="vertical", shift=(0.5, 0)
        ),
        materials={"red": red, "odd name": Material(color=Checker(colors=(0.5, (1, 0, 0)), size=2))},
        lights=[
            PointLight(position=(1, 2, 3), falloff="inverse-square"),
            DirectionalLight(direction=(0, -1, 0)),
            SpotLight(position=(1, 2, 3), target=(0, 0, 0), penumbra=0.5),
            RectangleLight(center=(0, 3, 0), u=(1, 0, 0), v=(0, 0, 1), samples=4),
            DiskLight(center=(0, 3, 1), normal=(0, -1, 0), radius=0.5, two_sided=True),
            SphereLight(center=(2, 3, 1), radius=0.25, radiance=(3, 2, 1), visible=False),
        ],
        shapes=[
            Sphere(center=(0, 0, 0), radius=1, material="red", name="ball"),
            Plane(point=(0, -1, 0), normal=(0, 2, 0), material="odd name"),
            Polygon(
                points=QUAD, transform=[Step(translate=(0, 0, 1)), Step(rotate=("y", 30)), Step(scale=2)]
            ),
            Mesh(vertices=QUAD, faces=[[0, 1, 2], [0, 2, 3]], normals=[[0, 0, 1]] * 4),
            Mesh(vertices=QUAD, faces=[[0, 1, 2, 3], [0, 1, 2]], material=Material(emission=0.1)),
            Quadric(coefficients=(1, 1, 1, 0, 0, 0, 0, 0, 0, -1), clip=((-1, -1, 0), (1, 1, 1))),
            Ellipsoid(center=(0, 0, 0), radii=(1, 2, 3), transform=np.diag([1, 2, 1, 1])),
            Cylinder(p0=(0, 0, 0), p1=(0, 1, 0), radius=0.5, caps=True),
            Cone(p0=(0, 0, 0), r0=0.5, p1=(0, 1, 0), r1=0, caps=True),
            Paraboloid(apex=(0, 0, 0), axis=(0, 3, 0), focal=0.25, height=2),
            Disk(center=(0, 0, 0), normal=(0, 1, 0), radius=2),
            Box(
                min=(0, 0, 0), max=(1, 2, 3), transform=[Step(scale=(1, 2, 1)), Step(rotate=((1, 1, 0), 45))]
            ),
        ],
    )
