"""What a page downloads: the scene as it is shown, or the picture."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from clrt.base.errors import one_line
from clrt.base.scratch import scratch
from clrt.scene.save import encoded

if TYPE_CHECKING:
    from clrt.images.image import Image
    from clrt.scene.scene import Scene


def scene_file(scene: Scene) -> tuple[dict[str, Any], bytes]:
    """A TOML file whose names of other files are as seen from the scene's own folder."""
    name = f"{stem(scene.source)}-viewed.toml"
    data = encoded(scene, (scene.folder or Path()) / name)
    about = one_line(
        f"# Saved by clrt view from {scene.source or 'a scene'}; it belongs into the same folder."
    )
    return {"name": name, "type": "application/toml"}, f"{about}\n\n".encode() + data


def picture_file(image: Image, source: str, suffix: str, exposure: float) -> tuple[dict[str, Any], bytes]:
    """A PNG brightened by `exposure` stops, or an EXR of the light itself."""
    with scratch() as folder:
        made = image.save(folder / f"image.{suffix}", 0.0 if suffix == "exr" else exposure)
        data = made.read_bytes()
    kind = {"png": "image/png", "exr": "image/x-exr"}[suffix]
    return {"name": f"{stem(source)}.{suffix}", "type": kind}, data


def stem(source: str) -> str:
    """The scene's name as a part of a file's name."""
    return re.sub(r"[^\w-]+", "_", Path(source).stem)[:60].strip("_") or "scene"
