"""Pictures on surfaces, as a scene states them: what stands where a colour may, and normal maps."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

from msgspec import Meta

from clrt.base.files import resolve
from clrt.base.hints import Numbers
from clrt.base.places import At
from clrt.base.records import Record, single_of

PICTURED: Final = ("color", "highlight_color", "reflection_color", "transmission_color", "emission")
"""The colours of a material that may be pictures."""

MODELS: Final = (".glb", ".gltf", ".ply")
"""Files that pictures may be parts of."""

File = Annotated[str, Meta(min_length=1, description="file must be the path of a picture")]
Part = Annotated[int, Meta(ge=0, description="part must be a whole number from 0")] | None
Share = Annotated[float, Meta(ge=0)]
if TYPE_CHECKING:
    Pair = Numbers
else:
    Pair = Annotated[tuple[float, float], Meta(description="must be 2 numbers")]
Wrap = Annotated[
    Literal["repeat", "clamp", "mirror"], Meta(description="wrap must be 'repeat', 'clamp' or 'mirror'")
]
Filter = Annotated[
    Literal["linear", "nearest", "mipmap"],
    Meta(description="filter must be 'linear', 'nearest' or 'mipmap'"),
]


class ImageTexture(Record, frozen=True, kw_only=True, tag="image", tag_field="type"):
    """A picture where a colour may stand: at `(u, v)` of a surface its colour at `(u, v) scale + offset`.

    file: EXR, HDR, PNG, JPEG, TIFF or BMP in the scene's folder. wrap: what lies beyond the picture. filter:
    between texels; "mipmap" also between smaller pictures of it, where a sample sees many texels.
    encoding: of its numbers; None: integers are sRGB, floats linear. tint multiplies them.
    part: which of the pictures that are within a model's file (.glb, .gltf), counted from 0;
    of a .ply 0, the colours of its vertices or faces.
    """

    file: File
    part: Part = None
    wrap: Wrap = "repeat"
    filter: Filter = "linear"
    encoding: Annotated[
        Literal["srgb", "linear"] | None, Meta(description="encoding must be 'srgb' or 'linear'")
    ] = None
    scale: Pair = (1.0, 1.0)
    offset: Pair = (0.0, 0.0)
    tint: Annotated[
        tuple[Share, Share, Share], Meta(description="tint must be 3 numbers >= 0")
    ] = (1.0, 1.0, 1.0)

    def check(self, at: At) -> None:
        """Raise for a picture that would show one line of itself alone."""
        _check_scale(self, at)
        if self.filter == "mipmap" and self.file.lower().endswith(".ply"):
            text = "colours of vertices and faces have no mip levels: take 'linear'"
            raise at.key("filter").error(self.filter, text)
        _check_part(self, at)


class Placement(Record, frozen=True, kw_only=True):
    """Where a normal map lies, if not as the picture of `color` does: what the keys of an image say."""

    wrap: Wrap = "repeat"
    filter: Filter = "linear"
    scale: Pair = (1.0, 1.0)
    offset: Pair = (0.0, 0.0)

    def check(self, at: At) -> None:
        """Raise for a picture that would show one line of itself alone."""
        _check_scale(self, at)


class NormalMap(Record, frozen=True, kw_only=True):
    """A picture of normals: `scale` times how far they lean. It lies as `color`'s, or by its `placement`."""

    file: File
    part: Part = None
    scale: float = 1.0
    placement: (
        Annotated[Placement, Meta(description="must be a table such as {scale = [2, 2]}")] | None
    ) = None

    def check(self, at: At) -> None:
        """Raise for a part of a file that has none, and for a placement that cannot be."""
        _check_part(self, at)
        if self.placement is not None:
            self.placement.check(at.key("placement"))


def _check_scale(picture: ImageTexture | Placement, at: At) -> None:
    if not all(single_of(number) for number in picture.scale):
        raise at.key("scale").error(picture.scale, "neither number of scale may be 0")


def _check_part(picture: ImageTexture | NormalMap, at: At) -> None:
    model = picture.file.lower().endswith(MODELS)
    if model and picture.part is None:
        raise at.key("file").error(picture.file, "of a model's file say which picture: part = 0, 1, ...")
    if picture.part is not None and not model:
        raise at.key("part").error(picture.part, f"only {', '.join(MODELS)} files have parts")


def picture_path(picture: ImageTexture | NormalMap, folder: Path | None, at: At) -> Path:
    """The picture's file; SceneError where there is none in `folder`."""
    return resolve(picture.file, folder, at.key("file"))
