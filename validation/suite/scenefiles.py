"""A scene in the format that another program reads."""

from __future__ import annotations

import json
import re
import shutil
import tomllib
from pathlib import Path
from typing import Final

import tomli_w
from msgspec.structs import replace

from clrt.base.errors import ClrtError
from clrt.base.files import read_text_bytes
from clrt.base.limits import Limits
from clrt.base.scratch import scratch
from clrt.formats import load_file
from clrt.formats.nff.writer import write_nff
from clrt.scene.scene import Scene
from clrt.scene.textures import PICTURED, ImageTexture, NormalMap

FORMATS: Final = (".toml", ".json", ".xml", ".pov", ".nff")
_RESOLUTION: Final = re.compile(r"^resolution[ \t].*$", re.MULTILINE)


def write_scene(scene: Scene, path: Path, origin: Path | None = None) -> None:
    """Write the scene, and what files it needs beside it. ClrtError where the format has no words for it.

    origin: the file that it was read from. Where that is an .nff it is handed on, of the size that is asked
    for: it may say what is not written, such as balls that are seen from within.
    """
    if scene.adaptive is not None and path.suffix not in (".toml", ".json"):
        raise ClrtError(f"adaptive: {path.suffix} has no words for samples where pixels differ")
    if path.suffix == ".nff" and origin is not None and origin.suffix.lower() == ".nff":
        _copy_nff(scene, path, origin)
    elif path.suffix == ".nff":
        write_nff(scene, path)
    elif path.suffix == ".xml":
        from ..oracle_mitsuba.xml import write_xml

        if lacks := write_xml(scene, path):
            raise ClrtError(f"Mitsuba's plugins lack {lacks} things of this scene")
    elif path.suffix == ".pov":
        from ..oracle_povray.scene import write_pov

        write_pov(scene, path)
    else:
        _lay_pictures(scene, path.parent)
        _save(scene, path)


def _save(scene: Scene, path: Path) -> None:
    if scene.background_path is None:
        scene.save(path)
    else:
        image = shutil.copyfile(scene.background_path, path.with_name(f"sky{scene.background_path.suffix}"))
        replace(scene, background=0.0).save(path)
        text = path.read_text(encoding="utf-8")
        table = tomllib.loads(text) if path.suffix == ".toml" else json.loads(text)
        table["background"] = image.name
        written = tomli_w.dumps(table) if path.suffix == ".toml" else json.dumps(table)
        path.write_text(written, encoding="utf-8")


def _lay_pictures(scene: Scene, folder: Path) -> None:
    """Lay the pictures on surfaces where `Scene.save` finds them: below the folder, by the names they have.

    Those that lie outside of the scene's own folder have no such place, as `save` says then.
    """
    own = (scene.folder or Path()).resolve()
    for shape in scene.shapes:
        material = scene.material_of(shape)
        for picture in (*(getattr(material, key) for key in PICTURED), material.normal_map):
            if isinstance(picture, (ImageTexture, NormalMap)):
                file = (own / picture.file).resolve()
                if file.is_relative_to(own):
                    copy = folder / file.relative_to(own)
                    copy.parent.mkdir(parents=True, exist_ok=True)
                    shutil.copyfile(file, copy)


def as_nff(scene: Scene, origin: Path | None) -> Scene:
    """The scene that an .nff of the scene's size describes: its angle is between pixels, so that it differs.

    The scene itself where it does not come from an .nff.
    """
    if origin is None or origin.suffix.lower() != ".nff":
        return scene
    with scratch() as folder:
        file = Path(folder, "scene.nff")
        _copy_nff(scene, file, origin)
        return load_file(file, Limits()).override(spp=1)


def _copy_nff(scene: Scene, path: Path, origin: Path) -> None:
    assert scene.camera is not None
    text = read_text_bytes(origin, Limits()).decode("latin-1")
    size = f"resolution {scene.camera.width} {scene.camera.height}"
    path.write_text(_RESOLUTION.sub(size, text), encoding="latin-1")
