"""Pictures on surfaces, as a scene states them: what stands where a colour may, and normal maps."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final, Literal

from msgspec import Meta

from clrt.base.files import resolve
from clrt.base.places import At
from clrt.base.records import Record, single_of

PICTURED: Final = ("color", "highlight_color", "reflection_color", "transmission_color", "emission")
"""The colours of a material that may be pictures."""

File = Annotated[str, Meta(min_length=1, description="file must be the path of a picture")]
Pair = Annotated[tuple[float, float], Meta(description="must be 2 numbers")]


class ImageTexture(Record, frozen=True, kw_only=True, tag="image", tag_field="type"):
    """A picture where a colour may stand: at `(u, v)` of a surface its colour at `(u, v) scale + offset`.

    file: EXR, HDR, PNG, JPEG, TIFF or BMP in the scene's folder. wrap: what lies beyond the picture. filter:
    between texels. encoding: of its numbers; None: integers are sRGB, floats linear.
    """

    file: File
    wrap: Annotated[
        Literal["repeat", "clamp", "mirror"], Meta(description="wrap must be 'repeat', 'clamp' or 'mirror'")
    ] = "repeat"
    filter: Annotated[
        Literal["linear", "nearest"], Meta(description="filter must be 'linear' or 'nearest'")
    ] = "linear"
    encoding: Annotated[
        Literal["srgb", "linear"] | None, Meta(description="encoding must be 'srgb' or 'linear'")
    ] = None
    scale: Pair = (1.0, 1.0)
    offset: Pair = (0.0, 0.0)

    def check(self, at: At) -> None:
        """Raise for a picture that would show one line of itself alone."""
        if not all(single_of(number) for number in self.scale):
            raise at.key("scale").error(self.scale, "neither number of scale may be 0")


class NormalMap(Record, frozen=True, kw_only=True):
    """A picture of normals: `scale` times how far they lean; uv, wrap and filter are those of `color`'s."""

    file: File
    scale: float = 1.0


def picture_path(picture: ImageTexture | NormalMap, folder: Path | None, at: At) -> Path:
    """The picture's file; SceneError where there is none in `folder`."""
    return resolve(picture.file, folder, at.key("file"))
