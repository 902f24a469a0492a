"""A program that uses every public name as the pages say, for type checkers alone: nobody runs it."""

from __future__ import annotations

from pathlib import Path
from typing import assert_type

import numpy as np
import numpy.typing as npt

import clrt
from clrt.scene import (
    Adaptive,
    Box,
    Checker,
    Cone,
    Cylinder,
    DirectionalLight,
    Disk,
    DiskLight,
    Ellipsoid,
    ImageTexture,
    Material,
    Mesh,
    NormalMap,
    Paraboloid,
    Placement,
    Plane,
    PointLight,
    Polygon,
    Quadric,
    RectangleLight,
    Spectral,
    Spectrum,
    Sphere,
    SphereLight,
    SpotLight,
    Step,
)  # fmt: skip


def scenes() -> None:
    """Cameras and scenes of lists, arrays, tuples, tables and records."""
    version: str = clrt.__version__
    pose, matrix = np.eye(4), [[70, 0, 30], [0, 68, 25.5], [0, 0, 1]]
    camera = clrt.Camera(origin=[0, 0, 5], target=[0, 0, 0], fov=30)
    clrt.Camera(origin=np.array([0, 0, 5.0]), target=(0, 0, 0), up=[0, 1, 0], shift=[1, 2.5])
    clrt.Camera(pose=pose, K=matrix, width=64, height=48)
    clrt.Camera(pose=pose.tolist(), K=np.array(matrix))
    x, y, z = camera.origin
    wide: float = x + y + camera.origin[2] + camera.fov
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
    scene = clrt.Scene(camera=camera, shapes=[ball])
    view = {"origin": [0, 0, 5], "target": [0, 0, 0]}
    clrt.Scene(camera=view, shapes=(Sphere(center=[0, 0, 0], radius=1), ball))
    clrt.Scene(
        lights=[{"type": "point", "position": [1, 2, 3]}, PointLight(position=np.ones(3))],
        materials={"red": {"color": [0.9, 0.1, 0.1]}, "grey": Material(color=0.5)},
        background=[0.1, 0.2, 0.3], ambient=np.array([0.1, 0.1, 0.1]), spectrum={"bands": 8}, folder="scenes",
        adaptive={"spp": 16}, limits=clrt.Limits(depth=99),
    )  # fmt: skip
    assert_type(clrt.load("showcase"), clrt.Scene)
    assert_type(clrt.load(Path("a.toml"), limits=clrt.Limits(depth=99)), clrt.Scene)
    assert_type(clrt.load_dict({"shapes": [ball]}), clrt.Scene)
    other = scene.replace({"camera.fov": 30, "shapes[0].center": np.ones(3)}).override(width=30)
    other.save("x.toml")
    other.to_dict()["camera"]
    assert other.camera is not None and isinstance(other.shapes[0], Sphere)
    print(version, wide, z, other.camera.fov, other.shapes[0].radius)


def records() -> None:
    """All that scenes are made of."""
    Sphere(center=np.zeros(3), radius=1, material={"diffuse": 0.5}, transform=[{"scale": [1, 2, 3]}])
    Box(min=[0, 0, 0], max=[1, 1, 1], transform=np.eye(4), material=Material(diffuse=0.5))
    Cylinder(p0=[0, 0, 0], p1=[1, 1, 1], radius=1, material="red")
    Cone(p0=[0, 0, 0], p1=[1, 1, 1], r0=1, r1=0)
    Plane(point=[0, 0, 0], normal=[0, 1, 0])
    Polygon(points=[[0, 0, 0], [0, 1, 0], [1, 0, 0]])
    Polygon(points=np.eye(3))
    Mesh(vertices=[[0, 0, 0], [1, 0, 0], [0, 1, 0]], faces=[[0, 1, 2]])
    Mesh(vertices=np.eye(3), faces=np.array([[0, 1, 2]]), smooth=True)
    Disk(center=[0, 0, 0], normal=[0, 0, 1], radius=1)
    Ellipsoid(center=[0, 0, 0], radii=[1, 2, 3])
    Paraboloid(apex=[0, 0, 0], axis=[0, 0, 1], focal=1, height=1)
    Quadric(coefficients=[1] * 10, clip=[[0, 0, 0], [1, 1, 1]])
    Step(translate=[1, 2, 3])
    Step(rotate=["y", 30])
    Material(color=[1, 0, 0], highlight_color=np.ones(3), ior=[[400, 1.5], [700, 1.4]], conductor="gold")
    Material(color={"type": "checker", "colors": [0, 1], "size": 1}, normal_map={"file": "bumps.png"})
    Material(color=Checker(colors=[[1, 1, 1], 0.5]), normal_map=NormalMap(file="bumps.png"))
    Material(color=ImageTexture(file="a.png", scale=[2, 2]), emission=Spectrum(gaussian=[550, 20]))
    Placement(scale=[3, 3])
    DirectionalLight(direction=[0, -1, 0], intensity=[1, 1, 1])
    SpotLight(position=[0, 1, 0], target=[0, 0, 0], angle=30)
    RectangleLight(center=[0, 0, 0], u=[1, 0, 0], v=[0, 1, 0], radiance=[1, 1, 1])
    DiskLight(center=[0, 0, 0], normal=[0, 0, 1], radius=1)
    SphereLight(center=[0, 0, 0], radius=1)
    Spectral(bands=8, range=[400, 700])
    Adaptive(spp=16)


def progress(done: int, total: int, rays: int) -> None:
    """As `render` calls it."""
    print(done, total, rays)


def pictures(scene: clrt.Scene) -> None:
    """Rendering, pictures, series, judging."""
    image = clrt.render(scene, width=16, layers=["depth"], progress=progress, crop=(0, 0, 3, 3))
    assert_type(image, clrt.Image)
    clrt.render({"shapes": []}, layers="all", device="PoCL", checkpoint="x.npz", camera=scene.camera)
    saved: Path = image.save(Path("a.png"), exposure=1, bits=8)
    pixels: npt.NDArray[np.float32] = image.pixels
    read = clrt.read_image("a.png")
    assert_type(read, np.ndarray)
    assert_type(clrt.read_image("a.exr", layers="all"), clrt.Image)
    assert_type(clrt.read_image("a.exr", None, "all"), clrt.Image)
    assert_type(clrt.read_image("a.exr", clrt.Limits(), ["depth"]), clrt.Image)
    assert_type(clrt.read_image("a.exr", clrt.Limits(), None), np.ndarray)
    names: tuple[str, ...] = clrt.views()
    many = clrt.sweep(scene, {"camera.fov": np.linspace(20, 30, 5)}, width=16)
    both = clrt.sweep("showcase", {"camera.fov": [30, 50], "materials.glass.ior": np.array([1.3, 1.5])})
    for values, shown in (*many, *both):
        assert_type(shown, clrt.Image)
        print(values["camera.fov"], shown.hash)
    assert scene.camera is not None
    around = clrt.turntable(scene.camera, 12)
    assert_type(clrt.camera_path([around[0], around[3]], 9, times=[0, 1]), list[clrt.Camera])
    verdict = clrt.compare(read, scene, gates={"SSIM": 0.9}, mask=True, limits=clrt.Limits())
    assert_type(verdict, clrt.Verdict)
    if not verdict:
        print(verdict.causes[0].name, verdict.figures["SSIM"], verdict.save_report("x.html"))
    print(saved, pixels, names)


def rays(scene: clrt.Scene) -> None:
    """Questions about rays, devices, errors."""
    with clrt.Tracer(scene, settings=clrt.Settings(threads=1, limits=clrt.Limits(depth=99))) as tracer:
        hits = tracer.intersect([0, 0, 5], [[0, 0, -1]], fields=["t", "primitive"])
        assert_type(hits, clrt.Hits)
        every = tracer.all_hits(np.zeros(3), np.ones(3))
        assert_type(every, clrt.Crossings)
        light, counts = tracer.radiance([0, 0, 5], [0, 0, -1])
        tree = tracer.explain(3, 4, width=16)
        assert_type(tree, clrt.RayTree)
        for ray in tree.walk():
            print(ray.kind)
        print(hits.t, every.counts, every.rays, every.splits, light, counts["rays"]["camera"])
        print(tracer.update(scene))
    devices: list[clrt.DeviceInfo] = clrt.devices()
    mesh = clrt.RayMeshIntersector(None, device=0)
    print(devices[0].label, mesh.intersects_first(np.zeros((1, 3)), np.zeros((1, 3))))
    view = clrt.widget(scene)
    print(view.scene)
    try:
        clrt.load("nothing")
    except (clrt.SceneError, clrt.DeviceError, clrt.LimitError) as error:
        print(error.args)
    except clrt.ClrtError as error:
        raise SystemExit(str(error)) from clrt.ClrtWarning("a warning")
