"""Models as other programs write them, each made here: nothing foreign is shipped.

trimesh's own exporters, and pygltflib's; Blender's OBJ, MeshLab's, CloudCompare's and FreeCAD's PLY by what
these write.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np
import trimesh
from PIL import Image

from tests.foreign_gltf import khr_materials, khr_textures
from tests.foreign_pygltf import khr_extensions
from tests.foreign_shapes import SCENES, ball, knot

WOOD: Final = SCENES / "wood.png"


def trimesh_glb(folder: Path) -> Path:
    """trimesh's GLB: a textured ball on a plain slab, each with a PBR material."""
    vertices, uv, faces = ball()
    wood = trimesh.visual.material.PBRMaterial(
        baseColorTexture=Image.open(WOOD), roughnessFactor=0.4, metallicFactor=0.0, name="wood"
    )
    sphere = trimesh.Trimesh(
        vertices, faces, visual=trimesh.visual.TextureVisuals(uv, material=wood), process=False
    )
    slab = trimesh.creation.box((4, 0.3, 4))
    slab.apply_translation((0, -1.15, 0))
    blue = trimesh.visual.material.PBRMaterial(
        baseColorFactor=[40, 80, 160, 255], metallicFactor=0.0, roughnessFactor=0.8
    )
    slab.visual = trimesh.visual.TextureVisuals(material=blue)
    path = folder / "trimesh.glb"
    path.write_bytes(trimesh.Scene({"ball": sphere, "slab": slab}).export(file_type="glb"))
    return path


def trimesh_obj(folder: Path) -> Path:
    """trimesh's OBJ with its MTL and picture beside it."""
    vertices, uv, faces = ball()
    wood = trimesh.visual.material.SimpleMaterial(image=Image.open(WOOD), diffuse=[255, 255, 255, 255])
    sphere = trimesh.Trimesh(
        vertices, faces, visual=trimesh.visual.TextureVisuals(uv, material=wood), process=False
    )
    path = folder / "trimesh.obj"
    sphere.export(path, mtl_name="trimesh.mtl")
    return path


def trimesh_ply(folder: Path) -> Path:
    """trimesh's PLY with a colour at each vertex."""
    vertices, quads, colors = knot()
    faces = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    path = folder / "trimesh.ply"
    trimesh.Trimesh(vertices, faces, vertex_colors=colors, process=False).export(path)
    return path


def trimesh_stl(folder: Path) -> Path:
    """trimesh's STL: corners alone."""
    path = folder / "trimesh.stl"
    trimesh.creation.torus(1.0, 0.4).export(path)
    return path


def blender_obj(folder: Path) -> Path:
    """Blender's OBJ: -Z forward, Y up, names with numbers, n-gons, `map_Kd` with options and a backslash."""
    (folder / "textures").mkdir(exist_ok=True)
    shutil.copy(WOOD, folder / "textures" / "wood 1.png")
    (folder / "blender.mtl").write_bytes(
        b"# Blender 4.2.0 MTL File: 'scene.blend'\r\n# www.blender.org\r\n\r\n"
        b"newmtl Material.001\r\nNs 250.0\r\n"
        b"Ka 1.0 1.0 1.0\r\nKs 0.5 0.5 0.5\r\nKe 0.0 0.0 0.0\r\nNi 1.45\r\nd 1.0\r\nillum 2\r\n"
        b"map_Kd -s 2 2 1 textures\\wood 1.png\r\n\r\nnewmtl Red\r\nNs 360.0\r\n"
        b"Kd 0.8 0.03 0.02\r\nKs 0.5 0.5 0.5\r\n"
        b"Ni 1.45\r\nd 1.0\r\nillum 2\r\n"
    )
    corners = [(x, y, z) for y in (0.0, 1.4) for x, z in ((-0.7, 0.7), (0.7, 0.7), (0.7, -0.7), (-0.7, -0.7))]
    sides = [
        "1/1/1 2/2/1 6/3/1 5/4/1",
        "2/1/2 3/2/2 7/3/2 6/4/2",
        "3/1/3 4/2/3 8/3/3 7/4/3",
        "4/1/4 1/2/4 5/3/4 8/4/4",
        "5/1/5 6/2/5 7/3/5 8/4/5",
        "4/1/6 3/2/6 2/3/6 1/4/6",
    ]
    ring = [(1.7 + 0.6 * np.cos(a), y, 0.6 * np.sin(a)) for y in (0.0, 1.0) for a in np.arange(8) * np.pi / 4]
    lines = ["# Blender 4.2.0", "# www.blender.org", "mtllib blender.mtl", "o Cube.001"]
    lines += [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in corners]
    lines += ["vn 0 0 1", "vn 1 0 0", "vn 0 0 -1", "vn -1 0 0", "vn 0 1 0", "vn 0 -1 0"]
    lines += [
        "vt 0 0",
        "vt 1 0",
        "vt 1 1",
        "vt 0 1",
        "s 0",
        "usemtl Material.001",
        *(f"f {side}" for side in sides),
    ]
    lines += ["o Prism.002", *(f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in ring), "s 0", "usemtl Red"]
    lines += [
        "f " + " ".join(str(9 + 8 + k) for k in range(7, -1, -1)),
        "f " + " ".join(str(9 + k) for k in range(8)),
    ]
    lines += [f"f {9 + (k + 1) % 8} {9 + k} {17 + k} {17 + (k + 1) % 8}" for k in range(8)]
    path = folder / "blender.obj"
    path.write_bytes("\r\n".join([*lines, ""]).encode())
    return path


def meshlab_ply(folder: Path) -> Path:
    """MeshLab's binary PLY: flags, colours with alpha, a quality at each vertex."""
    vertices, quads, colors = knot()
    faces = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    kinds = [("place", "<f4", 3), ("flags", "<i4"), ("color", "u1", 4), ("quality", "<f4")]
    rows = np.zeros(len(vertices), kinds)
    rows["place"], rows["color"] = vertices, np.c_[colors[:, ::-1], np.full(len(colors), 255)]
    sides = np.zeros(len(faces), [("count", "u1"), ("corners", "<i4", 3), ("flags", "<i4")])
    sides["count"], sides["corners"] = 3, faces
    names = [
        *(f"float {axis}" for axis in "xyz"),
        "int flags",
        *(f"uchar {c}" for c in ("red", "green", "blue", "alpha")),
        "float quality",
    ]
    return _ply(
        folder / "meshlab.ply",
        "comment VCGLIB generated",
        names,
        rows.tobytes(),
        len(rows),
        ["list uchar int vertex_indices", "int flags"],
        sides.tobytes(),
        len(sides),
    )


def cloudcompare_ply(folder: Path) -> Path:
    """CloudCompare's: coordinates in double, far from 0, a scalar field, `vertex_index`."""
    x, z = (grid.ravel() for grid in np.meshgrid(np.linspace(-3, 3, 61), np.linspace(-3, 3, 61)))
    y = 0.9 * np.exp(-(x * x + z * z) / 3) * np.cos(2.2 * np.hypot(x, z))
    rows = np.zeros(len(x), [("place", "<f8", 3), ("color", "u1", 3), ("scalar_Height", "<f4")])
    rows["place"] = np.stack([x + 450, y + 120, z - 300], axis=1)
    height = (y - y.min()) / np.ptp(y)
    ramp = np.array([[30, 60, 140], [50, 140, 90], [220, 190, 90], [240, 240, 240]], float)
    rows["color"] = np.stack(
        [np.interp(height, np.linspace(0, 1, 4), ramp[:, c]) for c in range(3)], axis=1
    ).round()
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(60), np.arange(60)))
    a = i * 61 + j
    faces = np.concatenate([np.stack([a, a + 61, a + 62], 1), np.stack([a, a + 62, a + 1], 1)])
    sides = np.zeros(len(faces), [("count", "u1"), ("corners", "<i4", 3)])
    sides["count"], sides["corners"] = 3, faces
    names = [
        *(f"double {axis}" for axis in "xyz"),
        *(f"uchar {c}" for c in ("red", "green", "blue")),
        "float scalar_Height",
    ]
    return _ply(
        folder / "cloudcompare.ply",
        "comment Created by CloudCompare v2.13\nobj_info Generated by CloudCompare!",
        names,
        rows.tobytes(),
        len(rows),
        ["list uchar int vertex_index"],
        sides.tobytes(),
        len(sides),
    )


def freecad_ply(folder: Path) -> Path:
    """FreeCAD's as text, in mm, a colour on each face."""
    box = trimesh.creation.box((40, 25, 30))
    colors = np.repeat(
        [[200, 40, 30], [40, 150, 60], [40, 70, 190], [220, 180, 40], [150, 60, 160], [60, 170, 180]], 2, 0
    )
    order = np.argsort(box.face_normals @ [1.0, 10.0, 100.0], kind="stable")
    lines = [
        "ply",
        "format ascii 1.0",
        "comment Created by FreeCAD <https://www.freecad.org>",
        f"element vertex {len(box.vertices)}",
        *(f"property float32 {axis}" for axis in "xyz"),
        f"element face {len(box.faces)}",
        "property list uchar int vertex_index",
        *(f"property uchar {c}" for c in ("red", "green", "blue")),
        "end_header",
        *(" ".join(f"{v:g}" for v in row) for row in box.vertices),
        *(
            f"3 {a} {b} {c} " + " ".join(map(str, color))
            for (a, b, c), color in zip(box.faces[order], colors, strict=True)
        ),
        "",
    ]
    path = folder / "freecad.ply"
    path.write_text("\n".join(lines))
    return path


def _ply(
    path: Path,
    comment: str,
    names: list[str],
    rows: bytes,
    count: int,
    lists: list[str],
    sides: bytes,
    faces: int,
) -> Path:
    head = ["ply", "format binary_little_endian 1.0", comment, f"element vertex {count}"]
    head += [f"property {name}" for name in names]
    head += [f"element face {faces}", *(f"property {name}" for name in lists), "end_header", ""]
    path.write_bytes("\n".join(head).encode() + rows + sides)
    return path


MODELS: Final[dict[str, Callable[[Path], Path]]] = {
    "trimesh, glb": trimesh_glb,
    "trimesh, obj and mtl": trimesh_obj,
    "trimesh, ply": trimesh_ply,
    "trimesh, stl": trimesh_stl,
    "Blender's way, obj": blender_obj,
    "MeshLab's way, ply": meshlab_ply,
    "CloudCompare's way, ply": cloudcompare_ply,
    "FreeCAD's way, ply": freecad_ply,
    "glTF, KHR lights and glass": khr_materials,
    "pygltflib, solid glass and glow": khr_extensions,
    "glTF, sparse, moved picture": khr_textures,
}
