"""Which faces of an OBJ file have which material, told in a way that trimesh hands on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from clrt.base.errors import show
from clrt.meshfiles.look import Look, Table
from clrt.meshfiles.mtl import read_mtl

LIBRARY: Final = "clrt.mtl"
"""The materials file that is made up, so that trimesh keeps materials apart."""

_FEW, _MOST, _COSTLY = 64, 1024, 10**8
Fetch = Callable[[str], bytes | None]
"""The contents of a file beside the OBJ; None where there is none of that name."""


class Materials:
    """The materials of an OBJ by number, and the lines of the file with these numbers for names."""

    def __init__(self, data: bytes) -> None:
        """data: with plain lines (`clrt.meshfiles.obj`)."""
        self.libraries: list[str] = []
        numbers: dict[bytes, int] = {}
        head: list[bytes] = [b"mtllib " + LIBRARY.encode()]
        faces: dict[int | None, list[bytes]] = {None: []}
        now: int | None = None
        for line in data.splitlines():
            if line.startswith(b"f "):
                faces[now].append(line)
            elif line.startswith(b"usemtl"):
                name = line[6:].strip()
                now = numbers.setdefault(name, len(numbers))
                faces.setdefault(now, [])
            elif line.startswith(b"mtllib"):
                self.libraries.append(line[6:].strip().decode("utf-8", "replace"))
            else:
                head.append(line)
        self.names = [name.decode("utf-8", "replace") for name in numbers]
        for number, lines in faces.items():
            head += [*([] if number is None else [b"usemtl m%d" % number]), *lines] if lines else []
        # trimesh takes a time of vertices x materials, and of materials squared
        vertices = sum(line.startswith(b"v ") for line in head)
        self.many = len(numbers) > (_MOST if len(numbers) * vertices <= _COSTLY else _FEW)
        self.lines = b"\n".join(head) + b"\n"

    def library(self) -> bytes:
        """What trimesh is given for `LIBRARY`."""
        # of a single material it keeps no name
        return "".join(f"newmtl m{number}\nKd 1 1 1\n" for number in range(len(self.names) + 1)).encode()

    def look(self, fetch: Fetch) -> Look:
        """The materials of the libraries that are there; those that are not are said to be left out."""
        found = Look()
        known: dict[str, tuple[Table, dict[str, None]]] = {}
        for name in self.libraries:
            files = [name] if fetch(name) is not None else name.split()  # names may have spaces
            for file in files:
                data = fetch(file)
                if data is None:
                    found.left_out[f"the materials of {show(file[:60])}, which is not there"] = None
                else:
                    known |= read_mtl(data, file)
        for number, name in enumerate(self.names):
            if name in known:
                table, left_out = known[name]
                found.called[number] = name
                found.materials[name] = table
                found.left_out.update(left_out)
        return found
