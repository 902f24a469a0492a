"""Which faces of an OBJ file have which material, told in a way that trimesh hands on."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Final

from clrt.base.errors import show
from clrt.meshfiles.gltf.textures import Itself
from clrt.meshfiles.look import NONE, Look, Names, Used, textures_without_uv
from clrt.meshfiles.obj.lines import formed, has_colors, mixed_forms
from clrt.meshfiles.obj.maps import Beside, unquoted
from clrt.meshfiles.obj.mtl import Phong, earlier, name_of, read_mtl, said, text_of

LIBRARY: Final = "clrt.mtl"
"""The materials file that is made up, so that trimesh keeps materials apart."""

_FEW, _MOST, _COSTLY = 64, 1024, 10**8
Fetch = Callable[[str], tuple[Path, Callable[[], bytes]] | None]
"""A file beside the OBJ, and what reads it; None where there is none of that name."""


class Materials:
    """The materials of an OBJ by number, and the lines of the file, its faces in groups.

    Those of a group have one material and corners of one form: trimesh drops what others lack.
    """

    def __init__(self, data: bytes) -> None:
        """data: with plain lines (`clrt.meshfiles.obj.lines`)."""
        self.libraries: list[str] = []
        self.colored = has_colors(data)
        numbers: dict[bytes, int] = {}
        head: list[bytes] = [b"mtllib " + LIBRARY.encode()]
        faces: dict[tuple[int, tuple[bool, bool] | None], list[bytes]] = {}
        mixed, form, now = mixed_forms(data), None, NONE
        for line in data.splitlines():
            if line.startswith(b"f "):
                if mixed:
                    form, line = formed(line)
                faces.setdefault((now, form), []).append(line)
            elif line.startswith(b"usemtl"):
                now = numbers.setdefault(name_of(line[6:].split()), len(numbers))
            elif line.startswith(b"mtllib"):
                self.libraries += filter(None, [unquoted(text_of(line[6:].strip()))])
            else:
                head.append(line)
        self.names = list(numbers)
        # trimesh takes a time of vertices x groups, and of groups squared
        vertices = sum(line.startswith(b"v ") for line in head)
        self.many = len(faces) > (_MOST if len(faces) * vertices <= _COSTLY else _FEW)
        if self.many:
            together: dict[tuple[int, tuple[bool, bool] | None], list[bytes]] = {}
            for (_, form), lines in faces.items():
                together.setdefault((NONE, form), []).extend(lines)
            faces = together
        self.groups = [number for number, _ in faces]
        """Their materials, or NONE; of all where there are too many."""
        for group, lines in enumerate(faces.values()):
            head += [b"usemtl g%d" % group, *lines]
        self.lines = b"\n".join(head) + b"\n"

    def library(self) -> bytes:
        """What trimesh is given for `LIBRARY`."""
        # of a single material it keeps no name
        return "".join(f"newmtl g{group}\nKd 1 1 1\n" for group in range(len(self.groups) + 1)).encode()

    def material(self, name: str) -> int:
        """The number of the material, or NONE, of the group that `library` calls `name`."""
        return self.groups[int(name[1:])] if re.fullmatch(r"g\d+", name) else NONE

    def look(self, used: Used, fetch: Fetch, itself: Itself) -> Look:
        """The `used` materials of the libraries that are there; others are left out."""
        found = Look()
        if self.colored:
            found.left_out["the colours of vertices"] = None
        known: dict[bytes, tuple[Phong, Beside]] = {}
        seen: set[Path] = set()  # a library may be named often, and in many ways
        for name in dict.fromkeys(self.libraries):
            plain = name.partition("#")[0].strip()
            # names may have spaces, and ` #`
            files = next(([whole] for whole in (name, plain) if fetch(whole) is not None), plain.split())
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
        bare: dict[bytes, bytes | None] = {}
        for called in known:
            bare[said(called)] = None if said(called) in bare else called
        for number, uv in used:
            its_name = self.names[number]
            if its_name not in known:  # it has a comment, or the library's has
                its_name = said(its_name) if said(its_name) in known else bare.get(its_name) or its_name
            if its_name in known:
                phong, its = known[its_name]
                phong = phong.with_pictures(its, itself.shows)
                found.add(names, (number, uv), text_of(its_name), phong.table(uv))
                found.left_out.update(phong.left_out)
                if phong.pictured and not uv:
                    found.left_out[textures_without_uv(text_of(its_name))] = None
            elif seen:
                found.left_out[f"the material {show(text_of(its_name)[:60])}, which its library lacks"] = None
        return found


def _within(library: str, beside: Beside, name: str) -> str | None:
    """A file that a materials file names, which is beside it."""
    return beside((PurePosixPath(library.replace("\\", "/")).parent / name).as_posix())
