"""Which faces of an OBJ file have which material, told in a way that trimesh hands on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Final

from clrt.base.errors import show
from clrt.meshfiles.gltf_textures import Itself
from clrt.meshfiles.look import Look, Names
from clrt.meshfiles.mtl import Phong, earlier, name_of, read_mtl, text_of
from clrt.meshfiles.mtl_maps import Beside

LIBRARY: Final = "clrt.mtl"
"""The materials file that is made up, so that trimesh keeps materials apart."""

_FEW, _MOST, _COSTLY = 64, 1024, 10**8
Fetch = Callable[[str], tuple[Path, Callable[[], bytes]] | None]
"""A file beside the OBJ, and what reads it; None where there is none of that name."""


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
                name = name_of(line[6:].split())
                now = numbers.setdefault(name, len(numbers))
                faces.setdefault(now, [])
            elif line.startswith(b"mtllib"):
                self.libraries.append(text_of(line[6:].strip()))
            else:
                head.append(line)
        self.names = list(numbers)
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

    def look(self, used: Mapping[int, bool], fetch: Fetch, itself: Itself) -> Look:
        """The `used` materials (each: with uv) of the libraries that are there; others are left out."""
        found = Look()
        known: dict[bytes, tuple[Phong, Beside]] = {}
        seen: set[Path] = set()  # a library may be named often, and in many ways
        for name in dict.fromkeys(self.libraries):
            files = [name] if fetch(name) is not None else name.split()  # names may have spaces
            for file in dict.fromkeys(files):
                there = fetch(file)
                if there is None:
                    found.left_out[f"the materials of {show(file[:60])}, which is not there"] = None
                elif there[0] not in seen:
                    seen.add(there[0])
                    read = read_mtl(there[1](), file)
                    place = partial(_within, file, itself.beside)
                    for called, phong in read.items():
                        phong.left_out.update(earlier(called) if called in known else {})
                        known[called] = (phong, place)
        names = Names()  # of other bytes may be the same text
        for number, uv in used.items():
            its_name = self.names[number]
            if its_name in known:
                phong, its = known[its_name]
                found.called[number] = text = names.new(text_of(its_name))
                found.materials[text] = phong.with_pictures(its, itself.shows).table(uv)
                found.left_out.update(phong.left_out)
            elif seen:
                found.left_out[f"the material {show(text_of(its_name)[:60])}, which its library lacks"] = None
        return found


def _within(library: str, beside: Beside, name: str) -> str | None:
    """A file that a materials file names, which is beside it."""
    return beside((PurePosixPath(library.replace("\\", "/")).parent / name).as_posix())
