"""What every reader of meshes raises."""

from codecs import BOM_UTF16_BE, BOM_UTF16_LE


class BrokenMesh(ValueError):
    """A mesh file that cannot be read; its text says why, for people."""


def check_narrow(data: bytes) -> None:
    """BrokenMesh for a text of two bytes a letter, of which no line would be found."""
    if data.startswith((BOM_UTF16_LE, BOM_UTF16_BE)):
        raise BrokenMesh("its text is UTF-16; save it as UTF-8")
