"""What every reader of meshes raises."""


class BrokenMesh(ValueError):
    """A mesh file that cannot be read; its text says why, for people."""
