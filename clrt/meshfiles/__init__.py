"""Mesh files of other programs: OBJ, PLY, STL and glTF."""
