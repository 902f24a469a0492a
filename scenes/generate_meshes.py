"""Write the meshes of the scenes: knot.ply (a torus knot), gem.obj (a brilliant), both for showcase.toml too;
stone-*.ply (an octahedron with colours of vertices, or of faces).

The knot is made of quadrilaterals without normals (`smooth = true` in a scene derives them); the gem's facets
are flat n-gons, wound counter-clockwise from outside. showcase.toml holds its meshes itself, so that it needs
no mesh reader.

    python scenes/generate_meshes.py [FOLDER]
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MARK = "# Below: what generate_meshes.py writes."
GEM_KEYS = """\
material = "stone"
transform = [
    { rotate = [[0, 1, 0], 11.25] }, { rotate = [[0, 0, 1], -41.2] }, # down onto a facet of the pavilion
    { scale = 0.6 }, { rotate = [[0, 1, 0], -75.0] }, { translate = [-0.1, 0.005, 2.2] },
]"""
KNOT_KEYS = """\
material = "gold"
smooth = true
transform = [
    { rotate = [[0, 0, 1], 90.0] }, { scale = 0.95 }, { rotate = [[0, 1, 0], 24.0] },
    { translate = [-1.25, 1.52, -0.55] },
]"""


def torus_knot(
    p: int = 2,
    q: int = 3,
    ring: float = 1.0,
    swing: float = 0.42,
    tube: float = 0.24,
    along: int = 360,
    around: int = 28,
) -> tuple[Array, list[tuple[int, int, int, int]]]:
    """Vertices (along * around, 3) and quads of a tube around the (p, q) torus knot, its axis along z.

    The tube's frame is carried along the curve by double reflection (Wang et al. 2008) and untwisted evenly,
    so that the seam closes.
    """
    t = np.arange(along + 1) / along * 2.0 * np.pi
    radius = ring + swing * np.cos(q * t)
    curve = np.stack([radius * np.cos(p * t), radius * np.sin(p * t), swing * np.sin(q * t)], axis=1)
    tangent = np.gradient(np.concatenate([curve[-3:-1], curve, curve[1:3]]), axis=0)[2:-2]
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    normal = carried_frame(curve, tangent)
    binormal = np.cross(tangent, normal)
    twist = np.arctan2(normal[-1] @ binormal[0], normal[-1] @ normal[0])
    turn = np.arange(along) / along * -twist
    angle = turn[:, None] + (np.arange(around) / around * 2.0 * np.pi)[None]
    offset = np.cos(angle)[..., None] * normal[:-1, None] + np.sin(angle)[..., None] * binormal[:-1, None]
    vertices = (curve[:-1, None] + tube * offset).reshape(-1, 3)
    quads = []
    for i in range(along):
        for j in range(around):
            a, b = i * around + j, i * around + (j + 1) % around
            c, d = (i + 1) % along * around + (j + 1) % around, (i + 1) % along * around + j
            quads.append((a, b, c, d))
    return vertices, quads


def carried_frame(curve: Array, tangent: Array) -> Array:
    """Normals (n, 3) along a curve that turn as little as possible (double reflection)."""
    first = np.cross(tangent[0], [0.0, 0.0, 1.0])
    normals = [first / np.linalg.norm(first)]
    for i in range(len(curve) - 1):
        v1 = curve[i + 1] - curve[i]
        r = normals[-1] - 2.0 / (v1 @ v1) * (v1 @ normals[-1]) * v1
        t = tangent[i] - 2.0 / (v1 @ v1) * (v1 @ tangent[i]) * v1
        v2 = tangent[i + 1] - t
        normals.append(r - 2.0 / max(float(v2 @ v2), 1e-30) * (v2 @ r) * v2)
    return np.array(normals)


def ring_of(count: int, radius: float, y: float, phase: float) -> list[list[float]]:
    """`count` points of a horizontal circle, counter-clockwise seen from -y."""
    angles = (np.arange(count) + phase) / count * 2.0 * np.pi
    return [[radius * float(np.cos(a)), y, radius * float(np.sin(a))] for a in angles]


def gem() -> tuple[Array, list[tuple[int, ...]]]:
    """A brilliant cut with eightfold symmetry: table, stars, bezels, girdle, pavilion.

    The girdle's radius is 1, the culet is at the origin.
    Proportions near Tolkowsky's: table 0.53, crown angle 34.5 degrees, pavilion angle 40.75 degrees.
    """
    deep, crown, table = np.tan(np.radians(40.75)), np.tan(np.radians(34.5)), 0.53
    girdle, top = deep, deep + 0.04
    points = ring_of(8, table / np.cos(np.pi / 8), top + (1 - table) * crown, 0.5)
    points += ring_of(16, 1.0, top, 0.0) + ring_of(16, 1.0, girdle, 0.0) + [[0.0, 0.0, 0.0]]
    upper, lower, culet = 8, 24, 40
    faces: list[tuple[int, ...]] = [tuple(reversed(range(8)))]
    for k in range(8):
        a, b = (k - 1) % 8, k
        g0, g1, g2 = upper + (2 * k - 1) % 16, upper + 2 * k, upper + (2 * k + 1) % 16
        faces += [(a, b, g1), (g0, a, g1), (b, g2, g1)]
        h0, h1, h2 = lower + (2 * k - 1) % 16, lower + 2 * k, lower + (2 * k + 1) % 16
        faces += [(g0, g1, h1, h0), (g1, g2, h2, h1), (h0, h1, culet), (h1, h2, culet)]
    return np.array(points), faces


def write_ply(path: Path, vertices: Array, quads: list[tuple[int, int, int, int]]) -> None:
    """Write quads as binary little-endian PLY (float32 vertices, 16-bit indices)."""
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(quads)}\nproperty list uchar ushort vertex_indices\nend_header\n"
    )
    faces = np.zeros(len(quads), dtype=[("n", "u1"), ("v", "<u2", 4)])
    faces["n"], faces["v"] = 4, quads
    path.write_bytes(header.encode() + vertices.astype("<f4").tobytes() + faces.tobytes())


def stone() -> tuple[Array, list[tuple[int, ...]], NDArray[np.uint8]]:
    """An octahedron with quiet sRGB colours (6, 3) of its vertices."""
    vertices = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    colors = np.array([[200, 90, 70], [80, 140, 90], [90, 100, 190], [190, 180, 80], [150, 150, 150],
                       [90, 60, 120]])  # fmt: skip
    return vertices, [tuple(face) for face in faces], colors.astype(np.uint8)


def write_colored(path: Path, of_faces: bool) -> None:
    """Write the stone as an ASCII PLY with colours of its vertices, or of its faces (a corner's)."""
    vertices, faces, colors = stone()
    tone = "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
    at = "".join(f"property float {axis}\n" for axis in "xyz")
    head = f"ply\nformat ascii 1.0\nelement vertex {len(vertices)}\n{at}{'' if of_faces else tone}"
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\n"
    head += f"{tone if of_faces else ''}end_header"
    tones = np.empty((len(vertices), 0), np.uint8) if of_faces else colors
    lines = [[*map(int, at), *color] for at, color in zip(vertices, tones, strict=True)]
    lines += [[3, *face, *(colors[face[k % 3]] if of_faces else ())] for k, face in enumerate(faces)]
    path.write_text("\n".join([head, *(" ".join(map(str, line)) for line in lines), ""]))


def write_obj(path: Path, vertices: Array, faces: list[tuple[int, ...]]) -> None:
    """Write a Wavefront OBJ of n-gons."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices]
    lines += ["f " + " ".join(str(i + 1) for i in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")


def rows(items: Iterable[str], most: int = 110) -> str:
    """Items of a TOML array, as many in a line as fit."""
    lines, line = [], "   "
    for item in items:
        if len(line) + len(item) + 2 > most:
            lines.append(line)
            line = "   "
        line += f" {item},"
    return "\n".join([*lines, line])


def inline_mesh(name: str, vertices: Array, faces: Sequence[tuple[int, ...]], keys: str) -> str:
    """A mesh as a TOML table; `keys` are its other keys."""
    points = rows(f"[{x:.4f}, {y:.4f}, {z:.4f}]" for x, y, z in vertices)
    indices = rows(str(list(face)) for face in faces)
    head = f'[[shapes]]\ntype = "mesh"\nname = "{name}"\n{keys}\n'
    return f"{head}vertices = [\n{points}\n]\nfaces = [\n{indices}\n]\n"


def rewrite_showcase(path: Path) -> None:
    """Replace what follows MARK in showcase.toml by its two meshes."""
    above, mark, _ = path.read_text().partition(MARK)
    if not mark:
        raise SystemExit(f"{path}: the line {MARK!r} is missing")
    meshes = (
        inline_mesh("brilliant", *gem(), GEM_KEYS),
        inline_mesh("knot", *torus_knot(along=240, around=18), KNOT_KEYS),
    )
    path.write_text(above + mark + "\n\n" + "\n".join(meshes))


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    write_ply(folder / "knot.ply", *torus_knot())
    write_obj(folder / "gem.obj", *gem())
    for kind in ("vertices", "faces"):
        write_colored(folder / f"stone-{kind}.ply", kind == "faces")
    rewrite_showcase(folder / "showcase.toml")
