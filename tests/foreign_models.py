"""Models as other programs write them, each made here: nothing foreign is shipped.

trimesh's own exporters; Blender's OBJ and glTF, MeshLab's, CloudCompare's and FreeCAD's PLY by what these write.
"""

from __future__ import annotations

import io
import json
import shutil
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np
import trimesh
from PIL import Image

SCENES: Final = Path(__file__).parents[1] / "scenes"
WOOD: Final = SCENES / "wood.png"


def _knot(bumps: int = 96, around: int = 24) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A trefoil: vertices (n, 3), quads (m, 4), linear-to-the-eye colours (n, 3) uint8 along it."""
    t = np.linspace(0, 2 * np.pi, bumps, endpoint=False)
    path = np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=1)
    ahead = np.roll(path, -1, axis=0) - np.roll(path, 1, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    side = np.cross(ahead, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, ahead)
    s = np.linspace(0, 2 * np.pi, around, endpoint=False)
    ring = np.cos(s)[None, :, None] * side[:, None] + np.sin(s)[None, :, None] * up[:, None]
    vertices = (path[:, None] + 0.55 * ring).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(bumps), np.arange(around), indexing="ij")
    corners = [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)]
    quads = np.stack([(a % bumps) * around + b % around for a, b in corners], axis=-1).reshape(-1, 4)
    phase = np.repeat(t, around)[:, None] + np.array([0.0, 2.1, 4.2])
    return vertices, quads, np.round(127.5 + 120 * np.cos(phase)).astype(np.uint8)


def _ball(rows: int = 24, columns: int = 48) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A sphere with a seam: vertices, uv with v = 0 at the bottom, triangles."""
    u, v = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    theta, phi = np.pi * (1 - v.ravel()), 2 * np.pi * u.ravel()
    vertices = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), -np.sin(theta) * np.sin(phi)], axis=1)
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    a = (i * (columns + 1) + j).ravel()
    triangles = np.concatenate([np.stack([a, a + 1, a + columns + 2], 1), np.stack([a, a + columns + 2, a + columns + 1], 1)])
    area = np.linalg.norm(np.cross(vertices[triangles[:, 1]] - vertices[triangles[:, 0]],
                                   vertices[triangles[:, 2]] - vertices[triangles[:, 0]]), axis=1)  # fmt: skip
    return vertices, np.stack([u.ravel(), v.ravel()], axis=1), triangles[area > 1e-12]


def trimesh_glb(folder: Path) -> Path:
    """trimesh's GLB: a textured ball on a plain slab, each with a PBR material."""
    vertices, uv, faces = _ball()
    wood = trimesh.visual.material.PBRMaterial(
        baseColorTexture=Image.open(WOOD), roughnessFactor=0.4, metallicFactor=0.0, name="wood"
    )
    ball = trimesh.Trimesh(vertices, faces, visual=trimesh.visual.TextureVisuals(uv, material=wood), process=False)
    slab = trimesh.creation.box((4, 0.3, 4))
    slab.apply_translation((0, -1.15, 0))
    blue = trimesh.visual.material.PBRMaterial(baseColorFactor=[40, 80, 160, 255], metallicFactor=0.0, roughnessFactor=0.8)
    slab.visual = trimesh.visual.TextureVisuals(material=blue)
    path = folder / "trimesh.glb"
    path.write_bytes(trimesh.Scene({"ball": ball, "slab": slab}).export(file_type="glb"))
    return path


def trimesh_obj(folder: Path) -> Path:
    """trimesh's OBJ with its MTL and picture beside it."""
    vertices, uv, faces = _ball()
    wood = trimesh.visual.material.SimpleMaterial(image=Image.open(WOOD), diffuse=[255, 255, 255, 255])
    ball = trimesh.Trimesh(vertices, faces, visual=trimesh.visual.TextureVisuals(uv, material=wood), process=False)
    path = folder / "trimesh.obj"
    ball.export(path, mtl_name="trimesh.mtl")
    return path


def trimesh_ply(folder: Path) -> Path:
    """trimesh's PLY with a colour at each vertex."""
    vertices, quads, colors = _knot()
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
        b"# Blender 4.2.0 MTL File: 'scene.blend'\r\n# www.blender.org\r\n\r\nnewmtl Material.001\r\nNs 250.0\r\n"
        b"Ka 1.0 1.0 1.0\r\nKs 0.5 0.5 0.5\r\nKe 0.0 0.0 0.0\r\nNi 1.45\r\nd 1.0\r\nillum 2\r\n"
        b"map_Kd -s 2 2 1 textures\\wood 1.png\r\n\r\nnewmtl Red\r\nNs 360.0\r\nKd 0.8 0.03 0.02\r\nKs 0.5 0.5 0.5\r\n"
        b"Ni 1.45\r\nd 1.0\r\nillum 2\r\n"
    )  # fmt: skip
    corners = [(x, y, z) for y in (0.0, 1.4) for x, z in ((-0.7, 0.7), (0.7, 0.7), (0.7, -0.7), (-0.7, -0.7))]
    sides = ["1/1/1 2/2/1 6/3/1 5/4/1", "2/1/2 3/2/2 7/3/2 6/4/2", "3/1/3 4/2/3 8/3/3 7/4/3", "4/1/4 1/2/4 5/3/4 8/4/4",
             "5/1/5 6/2/5 7/3/5 8/4/5", "4/1/6 3/2/6 2/3/6 1/4/6"]  # fmt: skip
    ring = [(1.7 + 0.6 * np.cos(a), y, 0.6 * np.sin(a)) for y in (0.0, 1.0) for a in np.arange(8) * np.pi / 4]
    lines = ["# Blender 4.2.0", "# www.blender.org", "mtllib blender.mtl", "o Cube.001"]
    lines += [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in corners]
    lines += ["vn 0 0 1", "vn 1 0 0", "vn 0 0 -1", "vn -1 0 0", "vn 0 1 0", "vn 0 -1 0"]
    lines += ["vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1", "s 0", "usemtl Material.001", *(f"f {side}" for side in sides)]
    lines += ["o Prism.002", *(f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in ring), "s 0", "usemtl Red"]
    lines += ["f " + " ".join(str(9 + 8 + k) for k in range(7, -1, -1)), "f " + " ".join(str(9 + k) for k in range(8))]
    lines += [f"f {9 + (k + 1) % 8} {9 + k} {17 + k} {17 + (k + 1) % 8}" for k in range(8)]
    path = folder / "blender.obj"
    path.write_bytes("\r\n".join([*lines, ""]).encode())
    return path


def meshlab_ply(folder: Path) -> Path:
    """MeshLab's binary PLY: flags, colours with alpha, a quality at each vertex."""
    vertices, quads, colors = _knot()
    faces = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    kinds = [("place", "<f4", 3), ("flags", "<i4"), ("color", "u1", 4), ("quality", "<f4")]
    rows = np.zeros(len(vertices), kinds)
    rows["place"], rows["color"] = vertices, np.c_[colors[:, ::-1], np.full(len(colors), 255)]
    sides = np.zeros(len(faces), [("count", "u1"), ("corners", "<i4", 3), ("flags", "<i4")])
    sides["count"], sides["corners"] = 3, faces
    names = [*(f"float {axis}" for axis in "xyz"), "int flags", *(f"uchar {c}" for c in ("red", "green", "blue", "alpha")),
             "float quality"]  # fmt: skip
    return _ply(folder / "meshlab.ply", "comment VCGLIB generated", names, rows.tobytes(), len(rows),
                ["list uchar int vertex_indices", "int flags"], sides.tobytes(), len(sides))  # fmt: skip


def cloudcompare_ply(folder: Path) -> Path:
    """CloudCompare's: coordinates in double, far from 0, a scalar field, `vertex_index`."""
    x, z = (grid.ravel() for grid in np.meshgrid(np.linspace(-3, 3, 61), np.linspace(-3, 3, 61)))
    y = 0.9 * np.exp(-(x * x + z * z) / 3) * np.cos(2.2 * np.hypot(x, z))
    rows = np.zeros(len(x), [("place", "<f8", 3), ("color", "u1", 3), ("scalar_Height", "<f4")])
    rows["place"] = np.stack([x + 450, y + 120, z - 300], axis=1)
    height = (y - y.min()) / np.ptp(y)
    ramp = np.array([[30, 60, 140], [50, 140, 90], [220, 190, 90], [240, 240, 240]], float)
    rows["color"] = np.stack([np.interp(height, np.linspace(0, 1, 4), ramp[:, c]) for c in range(3)], axis=1).round()
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(60), np.arange(60)))
    a = i * 61 + j
    faces = np.concatenate([np.stack([a, a + 61, a + 62], 1), np.stack([a, a + 62, a + 1], 1)])
    sides = np.zeros(len(faces), [("count", "u1"), ("corners", "<i4", 3)])
    sides["count"], sides["corners"] = 3, faces
    names = [*(f"double {axis}" for axis in "xyz"), *(f"uchar {c}" for c in ("red", "green", "blue")),
             "float scalar_Height"]  # fmt: skip
    return _ply(folder / "cloudcompare.ply", "comment Created by CloudCompare v2.13\nobj_info Generated by CloudCompare!",
                names, rows.tobytes(), len(rows), ["list uchar int vertex_index"], sides.tobytes(), len(sides))  # fmt: skip


def freecad_ply(folder: Path) -> Path:
    """FreeCAD's as text, in mm, a colour on each face."""
    box = trimesh.creation.box((40, 25, 30))
    colors = np.repeat([[200, 40, 30], [40, 150, 60], [40, 70, 190], [220, 180, 40], [150, 60, 160], [60, 170, 180]], 2, 0)
    order = np.argsort(box.face_normals @ [1.0, 10.0, 100.0], kind="stable")
    lines = ["ply", "format ascii 1.0", "comment Created by FreeCAD <https://www.freecad.org>",
             f"element vertex {len(box.vertices)}", *(f"property float32 {axis}" for axis in "xyz"),
             f"element face {len(box.faces)}", "property list uchar int vertex_index",
             *(f"property uchar {c}" for c in ("red", "green", "blue")), "end_header",
             *(" ".join(f"{v:g}" for v in row) for row in box.vertices),
             *(f"3 {a} {b} {c} " + " ".join(map(str, color))
               for (a, b, c), color in zip(box.faces[order], colors, strict=True)), ""]  # fmt: skip
    path = folder / "freecad.ply"
    path.write_text("\n".join(lines))
    return path


def _ply(path: Path, comment: str, names: list[str], rows: bytes, count: int, lists: list[str], sides: bytes,
         faces: int) -> Path:  # fmt: skip
    head = ["ply", "format binary_little_endian 1.0", comment, f"element vertex {count}"]
    head += [f"property {name}" for name in names]
    head += [f"element face {faces}", *(f"property {name}" for name in lists), "end_header", ""]
    path.write_bytes("\n".join(head).encode() + rows + sides)
    return path


def _glb(path: Path, tree: dict[str, Any], chunks: list[bytes]) -> Path:
    """A GLB of a document whose buffer views are the chunks."""
    views, data = [], b""
    for chunk in chunks:
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(chunk)})
        data += chunk + bytes(-len(chunk) % 4)
    tree = {"asset": {"version": "2.0", "generator": "by hand"}, **tree, "bufferViews": views,
            "buffers": [{"byteLength": len(data)}]}  # fmt: skip
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(data))
    path.write_bytes(head + struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x4E4942) + data)
    return path


def _arrays(*arrays: np.ndarray) -> tuple[list[bytes], list[dict[str, Any]]]:
    kinds = {("f", 3): (5126, "VEC3"), ("f", 2): (5126, "VEC2"), ("u", 1): (5125, "SCALAR")}
    accessors = []
    for number, array in enumerate(arrays):
        component, kind = kinds[array.dtype.kind, array.shape[1] if array.ndim > 1 else 1]
        accessors.append({"bufferView": number, "componentType": component, "count": len(array), "type": kind})
    return [array.tobytes() for array in arrays], accessors


def khr_materials(folder: Path) -> Path:
    """glTF with lamps, glass of a volume, its index, strong emission, a metal and a clear sheet."""
    vertices, uv, faces = _ball()
    ground = np.array([[-6, -1, 4], [6, -1, 4], [6, -1, -6], [-6, -1, -6]], "<f4")
    chunks, accessors = _arrays(vertices.astype("<f4"), faces.astype("<u4").reshape(-1), ground,
                                np.array([0, 1, 2, 0, 2, 3], "<u4"))  # fmt: skip
    ball = {"POSITION": 0, "NORMAL": 0}
    meshes = [{"primitives": [{"attributes": ball, "indices": 1, "material": k}]} for k in range(4)]
    meshes += [{"primitives": [{"attributes": {"POSITION": 2}, "indices": 3, "material": 4}]}]
    ext = "KHR_materials_"
    glass = {ext + "transmission": {"transmissionFactor": 1}, ext + "ior": {"ior": 1.45},
             ext + "volume": {"thicknessFactor": 1, "attenuationColor": [0.5, 0.9, 0.7], "attenuationDistance": 1}}  # fmt: skip
    materials = [
        {"name": "glass", "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0}, "extensions": glass},
        {"name": "lamp", "emissiveFactor": [1, 0.6, 0.2], "extensions": {ext + "emissive_strength": {"emissiveStrength": 2}}},
        {"name": "gold", "pbrMetallicRoughness": {"baseColorFactor": [1, 0.76, 0.33, 1], "roughnessFactor": 0.2}},
        {"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [0.7, 0.05, 0.04, 1], "metallicFactor": 0,
                                                 "roughnessFactor": 0.3}},
        {"name": "ground", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0}},
    ]  # fmt: skip
    lights = [{"type": "point", "intensity": 60, "name": "Light"}, {"type": "directional", "intensity": 1.5}]
    places = [[-1.1, 0, 1.2], [-2.6, 0, -1.6], [0.4, 0, -2.2], [1.6, 0, 0.4]]
    nodes: list[dict[str, Any]] = [{"mesh": k, "translation": at, "name": f"Ball.00{k}"} for k, at in enumerate(places)]
    nodes += [{"mesh": 4, "name": "Ground"}, {"translation": [2, 5, 4], "extensions": {"KHR_lights_punctual": {"light": 0}}},
              {"rotation": [-0.5, 0.2, 0, 0.84], "extensions": {"KHR_lights_punctual": {"light": 1}}},
              {"translation": [0, 2.2, 8], "rotation": [-0.13, 0, 0, 0.9915], "camera": 0, "name": "Camera"}]  # fmt: skip
    return _glb(folder / "khr.glb", {
        "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes, "meshes": meshes,
        "materials": materials, "accessors": accessors, "extensions": {"KHR_lights_punctual": {"lights": lights}},
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.62, "aspectRatio": 4 / 3, "znear": 0.1}}],
        "extensionsUsed": ["KHR_lights_punctual", *glass, ext + "emissive_strength"],
    }, chunks)  # fmt: skip


def khr_textures(folder: Path) -> Path:
    """glTF with a moved and repeated picture, and a ball whose dents are a sparse accessor."""
    vertices, uv, faces = _ball()
    picture = io.BytesIO()
    Image.open(SCENES / "tiles.png").convert("RGB").save(picture, "PNG")
    dented = np.flatnonzero(vertices @ [0.3, 0.5, 0.81] > 0.86)
    dents = (vertices[dented] * 0.72).astype("<f4")
    down = np.stack([uv[:, 0], 1 - uv[:, 1]], axis=1).astype("<f4")
    chunks, accessors = _arrays(vertices.astype("<f4"), faces.astype("<u4").reshape(-1), down)
    sparse = {"count": len(dented), "indices": {"bufferView": 3, "componentType": 5125}, "values": {"bufferView": 4}}
    accessors.append(accessors[0] | {"sparse": sparse})
    chunks += [dented.astype("<u4").tobytes(), dents.tobytes(), picture.getvalue()]
    info = {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [4, 2], "offset": [0.1, 0.25]}}}
    material = {"name": "tiles", "pbrMetallicRoughness": {"baseColorTexture": info, "metallicFactor": 0,
                                                          "roughnessFactor": 0.25}}  # fmt: skip
    shown = [{"attributes": {"POSITION": number, "TEXCOORD_0": 2}, "indices": 1, "material": 0} for number in (0, 3)]
    return _glb(folder / "textures.glb", {
        "scene": 0, "scenes": [{"nodes": [0, 1]}], "meshes": [{"primitives": [one]} for one in shown],
        "nodes": [{"mesh": 0, "translation": [-1.1, 0, 0]}, {"mesh": 1, "translation": [1.1, 0, 0]}],
        "materials": [material], "textures": [{"source": 0, "sampler": 0}], "samplers": [{"wrapS": 10497}],
        "images": [{"bufferView": 5, "mimeType": "image/png"}], "accessors": accessors,
        "extensionsUsed": ["KHR_texture_transform"],
    }, chunks)  # fmt: skip


MODELS: Final[dict[str, Callable[[Path], Path]]] = {
    "trimesh, glb": trimesh_glb, "trimesh, obj and mtl": trimesh_obj, "trimesh, ply": trimesh_ply,
    "trimesh, stl": trimesh_stl, "Blender's way, obj": blender_obj, "MeshLab's way, ply": meshlab_ply,
    "CloudCompare's way, ply": cloudcompare_ply, "FreeCAD's way, ply": freecad_ply,
    "glTF, KHR lights and glass": khr_materials, "glTF, sparse, moved picture": khr_textures,
}  # fmt: skip
