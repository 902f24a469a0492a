"""Mesh files of other programs: OBJ, PLY, STL and glTF. What reads them is imported when there is one."""

from typing import Final

SUFFIXES: Final = (".obj", ".ply", ".glb", ".gltf", ".stl")
