"""The scene as the user means it: from files, dicts or Python objects alike, checked in one place."""

from __future__ import annotations

import copy
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import msgspec
from msgspec import Meta

from clrt.base import arguments, display
from clrt.base.arguments import public
from clrt.base.collector import no_collections
from clrt.base.errors import ClrtError, fault
from clrt.base.files import resolve
from clrt.base.hints import Table
from clrt.base.limits import Limits
from clrt.base.places import At, known_keys, listed
from clrt.base.records import read, table_of, tagged
from clrt.scene.adaptive import SAMPLED, Adaptive, check_samples
from clrt.scene.advice import check_lines, warn
from clrt.scene.camera import Camera, resized
from clrt.scene.changes import edited_materials, edited_shapes
from clrt.scene.edit import Draft
from clrt.scene.lights import (
    DirectionalLight,
    DiskLight,
    Light,
    PointLight,
    RectangleLight,
    SphereLight,
    SpotLight,
)
from clrt.scene.materials import IOR, Checker, ImageTexture, Material, NormalMap, Placement, rgb
from clrt.scene.mesh import Mesh, MeshData, Meshes, named_files, read_mesh
from clrt.scene.save import save
from clrt.scene.shapes import (
    Box,
    Cone,
    Cylinder,
    Disk,
    Ellipsoid,
    Paraboloid,
    Plane,
    Polygon,
    Quadric,
    Shape,
    Sphere,
)
from clrt.scene.summary import html, summary
from clrt.scene.tables import (
    check_material,
    check_pictures,
    listing,
    names_files,
    read_lights,
    read_materials,
    special_on_shapes,
)
from clrt.scene.transforms import Step
from clrt.scene.unfiled import made_ready
from clrt.spectra.colors import Background, Colored, LightColor
from clrt.spectra.indices import INDEX, LEAST, MOST
from clrt.spectra.spectrum import LAMPS, Spectral, Spectrum

__all__ = [
    "IOR", "SHAPES", "Adaptive", "Box", "Camera", "Checker", "Cone", "Cylinder", "DirectionalLight", "Disk",
    "DiskLight", "Ellipsoid", "ImageTexture", "Light", "Material", "Mesh", "MeshData", "NormalMap",
    "Paraboloid", "Placement", "Plane", "PointLight", "Polygon", "Quadric", "RectangleLight", "Scene",
    "Shape", "Spectral", "Spectrum", "Sphere", "SphereLight", "SpotLight", "Step", "read_scene", "rgb",
]  # fmt: skip

AnyShape = Sphere | Plane | Polygon | Mesh | Quadric | Ellipsoid | Cylinder | Cone | Paraboloid | Disk | Box
SHAPES: dict[str, type[Shape]] = {
    "sphere": Sphere,
    "plane": Plane,
    "polygon": Polygon,
    "mesh": Mesh,
    "quadric": Quadric,
    "ellipsoid": Ellipsoid,
    "cylinder": Cylinder,
    "cone": Cone,
    "paraboloid": Paraboloid,
    "disk": Disk,
    "box": Box,
}
_DEFAULT_MATERIAL = Material()


class _Settings(Colored, frozen=True, kw_only=True):
    """The scene's own values, without the tables below it."""

    version: Annotated[Literal[1], Meta(description="version must be 1")] = 1
    max_depth: Annotated[
        int, Meta(ge=0, le=1 << 16, description="must be a whole number from 0 to 65536")
    ] = 5
    min_weight: Annotated[float, Meta(ge=0, description="must be a number >= 0")] = 0.0
    depth_color: LightColor = 0.0
    background: Background = 0.0
    ambient: LightColor = 0.0
    ambient_samples: Annotated[
        int, Meta(ge=0, le=1 << 16, description="must be a whole number from 0 to 65536")
    ] = 0
    medium_ior: Annotated[float, Meta(ge=LEAST, le=MOST, description=f"must be {INDEX}")] = 1.0
    one_sided: Annotated[
        Literal["none", "opaque"], Meta(description="one_sided must be 'none' or 'opaque'")
    ] = "none"
    shadow: Annotated[
        Literal["opaque", "tinted"], Meta(description="shadow must be 'opaque' or 'tinted'")
    ] = "opaque"
    conformance: Annotated[
        Literal["none", "spd"], Meta(description="conformance must be 'none' or 'spd'")
    ] = "none"
    spectrum: Annotated[Spectral, Meta(description="must be a table such as {bands = 24}")] | None = None
    adaptive: (
        Annotated[Adaptive, Meta(description="must be a table such as {spp = 64, threshold = 0.01}")] | None
    ) = None


class Document(_Settings, frozen=True, kw_only=True):
    """What a scene file can say."""

    camera: Camera | None = None
    materials: dict[str, Material] = msgspec.field(default_factory=dict)
    lights: tuple[Light, ...] = ()
    shapes: tuple[AnyShape, ...] = ()


class Scene(Document, frozen=True, kw_only=True, eq=False):
    """A whole scene. Lists, tuples, dicts, numpy arrays and records may be mixed freely; all is checked here,
    and stays as it is: to change a scene, make another one (`override`, or `to_dict` and `clrt.load_dict`).

    `folder` is where relative files are looked up (None: the folder that is current now), `source` the name
    that messages start with, `limits` what reading may cost; the three are neither saved nor compared.

    Raises `SceneError` where the scene cannot be rendered, `LimitError` where it is too large, and ClrtError
    where one of the last three is of another kind.
    """

    folder: Path | None = None
    source: str = ""
    limits: Limits = Limits()

    if TYPE_CHECKING:  # what may be given, where the fields say what is there then

        def __init__(
            self,
            *,
            version: int = 1,
            max_depth: int = 5,
            min_weight: float = 0.0,
            depth_color: LightColor = 0.0,
            background: Background | str | os.PathLike[str] = 0.0,
            ambient: LightColor = 0.0,
            ambient_samples: int = 0,
            medium_ior: float = 1.0,
            one_sided: Literal["none", "opaque"] = "none",
            shadow: Literal["opaque", "tinted"] = "opaque",
            conformance: Literal["none", "spd"] = "none",
            spectrum: Spectral | Table | None = None,
            adaptive: Adaptive | Table | None = None,
            camera: Camera | Table | None = None,
            materials: Mapping[str, Material | Table] = ...,
            lights: Sequence[Light | Table] = (),
            shapes: Sequence[AnyShape | Table] = (),
            folder: str | os.PathLike[str] | None = None,
            source: str = "",
            limits: Limits = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        at = At(arguments.text("source", self.source))
        arguments.instance("limits", self.limits, Limits)
        given = Path() if self.folder is None else arguments.path("folder", self.folder)
        with suppress(OSError):  # the current folder was removed: whatever is looked up there says so
            msgspec.structs.force_setattr(self, "folder", given.absolute())
        values = self._read_settings({name: getattr(self, name) for name in _Settings.__struct_fields__}, at)
        values["camera"] = read_camera(self.camera, at)
        # what reads mesh files leaves cycles behind
        with no_collections(paused=not names_files(self.shapes)):
            values["materials"] = read_materials(self.materials, at.key("materials"))
            self._check_pictures(values["materials"], at.key("materials"))
            values["lights"] = read_lights(self.lights, at.key("lights"), self.limits)
            values["shapes"] = self._read_shapes(self.shapes, values["materials"], at.key("shapes"))
        for name, value in values.items():
            msgspec.structs.force_setattr(self, name, value)
        check_samples(self)
        check_lines(self)
        warn(self)

    def _read_settings(self, values: dict[str, Any], at: At) -> dict[str, Any]:
        values = msgspec.structs.asdict(read(_Settings, values, at))
        if values["spectrum"] is not None:
            values["spectrum"].check(at.key("spectrum"))
            self.limits.check("bands", values["spectrum"].bands, at.source, "spectrum.bands")
        if isinstance(values["background"], str) and values["background"] not in LAMPS:
            resolve(values["background"], self.folder, at.key("background"))
        return values

    def _read_shapes(self, data: object, materials: Mapping[str, Material], at: At) -> tuple[Shape, ...]:
        shapes: list[Shape] = []
        special = {name for name, material in materials.items() if special_on_shapes(material)}
        listed = listing(data, at, "shapes")
        meshes = Meshes(named=named_files(listed))
        for index, one in enumerate(listed):
            place = at.item(index)
            shape = self._read_shape(one, place, meshes)
            name = shape.material
            if not (name is None or (type(name) is str and name in materials and name not in special)):
                check_material(shape, materials, place)
            shapes.append(shape)
            meshes.primitives += shape.primitives
            self.limits.check("primitives", meshes.primitives, at.source, at.path)
        return tuple(shapes)

    def _read_shape(self, data: Any, at: At, meshes: Meshes) -> Shape:
        kind = tagged(SHAPES, data, at, "shape")
        if kind is Plane and type(data) is not Plane and data.get("transform") is not None:
            text = "a plane is infinite and takes no transform; move point and normal"
            raise at.key("transform").says(text)
        shape = (
            read_mesh(data, at, self.folder, self.limits, meshes) if kind is Mesh else read(kind, data, at)
        )
        if isinstance(shape.material, Material):
            check_pictures(shape.material, self.folder, at.key("material"), meshes.pictures)
        return shape

    def _check_pictures(self, materials: Mapping[str, Material], at: At) -> None:
        known: set[str] = set()
        for name, material in materials.items():
            check_pictures(material, self.folder, at.key(name), known)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Scene):
            return NotImplemented
        return all(getattr(self, name) == getattr(other, name) for name in Document.__struct_fields__)

    def __ne__(self, other: object) -> bool:  # the base class has one that only looks at identity
        return not self == other

    __hash__ = None  # type: ignore[assignment]

    def material_of(self, shape: Shape) -> Material:
        """The material of one of this scene's shapes; the default one where it names none."""
        if not isinstance(shape, Shape):
            raise ClrtError(fault("", "shape", shape, "it must be one of scene.shapes"))
        if not isinstance(shape.material, str):
            return shape.material or _DEFAULT_MATERIAL
        if shape.material not in self.materials:
            raise ClrtError(fault("", "shape.material", shape.material, "it is no material of this scene"))
        return self.materials[shape.material]

    def _repr_html_(self) -> str:
        """What notebooks show: what is in it."""
        return html(summary(self))

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """What notebooks show: the same, and the widget where there is one."""
        return display.bundle(self, self._repr_html_())

    def to_dict(self) -> dict[str, Any]:
        """The scene as `clrt.load_dict` takes it: built-in types only, default values left out."""
        return {key: value for key, value in table_of(self).items() if key in Document.__struct_fields__}

    @arguments.public
    def save(self, path: str | Path) -> None:
        """Write the scene to a .toml or .json file, whole or not at all; loading it gives an equal scene.

        Mesh files outside the new file's folder are written into it as vertices and faces. ClrtError where
        the file cannot be written, or the background image is not in its folder.
        """
        save(self, arguments.path("path", path))

    def override(
        self,
        *,
        width: int | None = None,
        height: int | None = None,
        spp: int | None = None,
        max_depth: int | None = None,
    ) -> Scene:
        """This scene with other picture settings (None keeps one), without checking its shapes again."""
        given = {"width": width, "height": height, "spp": spp}
        changes = {name: value for name, value in given.items() if value is not None}
        at = At(self.source)
        other = copy.copy(self)
        if max_depth is not None:
            depth = read(_Settings, {"max_depth": max_depth}, at).max_depth
            msgspec.structs.force_setattr(other, "max_depth", depth)
        if changes:
            if self.camera is None:
                raise at.key("camera").says(f"there is no camera whose {listed(changes)} could be set")
            camera = read(Camera, table_of(self.camera) | changes, at.key("camera")).upright()
            if (camera.width, camera.height) != (self.camera.width, self.camera.height):
                same = table_of(resized(self.camera, camera.width, camera.height))
                more = {name: same[name] for name in ("K", "shift") if name in same}
                camera = read(Camera, table_of(camera) | more, at.key("camera"))
            msgspec.structs.force_setattr(other, "camera", camera)
        return other

    @public
    def replace(self, changes: Mapping[str, Any]) -> Scene:
        """This scene with other values at some places: `{"camera.fov": 30, "shapes[3].center": [0, 1, 0]}`.

        Places are those of messages: keys, names of materials (quoted where they hold dots), numbers from 0;
        shapes also by their `name`. A place may be a whole table or list. What is new is checked as a file
        is; what is not stays the same object, so `Tracer.update` sees at once what has changed. A mesh's new
        `vertices` must be as many as before, unless it gets `faces` too. Arrays set of a mesh of a file take
        the file's place: its other arrays stay, and so does `smooth`, where the file has no normals. Raises
        SceneError and LimitError that name the place.
        """
        other = edited(self, changes)
        if any(getattr(other, name) is not getattr(self, name) for name in SAMPLED):
            check_samples(other)
        return other

    def _edited(self, changes: Mapping[str, Any]) -> Scene:
        draft = Draft(self, arguments.mapping("changes", changes), Document.__struct_fields__, made_ready)
        at, values, other = At(self.source), draft.values, copy.copy(self)
        settings = values.keys() & set(_Settings.__struct_fields__)
        if settings:
            given = {name: values.get(name, getattr(self, name)) for name in _Settings.__struct_fields__}
            checked = self._read_settings(given, at)
            values |= {name: checked[name] for name in settings}
        if "camera" in values:
            values["camera"] = read_camera(values["camera"], at)
        if "lights" in values:
            values["lights"] = read_lights(values["lights"], at.key("lights"), self.limits)
        if "materials" in values:
            values["materials"] = edited_materials(self, draft, at.key("materials"))
        if "shapes" in values:
            materials = values.get("materials", self.materials)
            values["shapes"] = edited_shapes(self, draft, materials, at.key("shapes"))
        for name, value in values.items():
            msgspec.structs.force_setattr(other, name, value)
        check_lines(other)
        return other

    @property
    def background_path(self) -> Path | None:
        """The lat-long image's file, or None where the background is a colour."""
        if not isinstance(self.background, str) or self.background in LAMPS:
            return None
        return resolve(self.background, self.folder, At(self.source, "background"))

    @property
    def branching(self) -> bool:
        """Whether some surface both reflects and transmits, so that rays can double at every generation."""
        used = {id(m): m for m in map(self.material_of, self.shapes)}.values()
        return any(m.kt > 0 and (m.kr > 0 or self.conformance == "spd") for m in used)


def read_scene(
    data: object, *, folder: Path | None = None, source: str = "", limits: Limits | None = None
) -> Scene:
    """The scene that a dict in the structure of the scene files describes."""
    at = At(source)
    if not isinstance(data, Mapping):
        raise at.error(data, "a scene must be a table of keys")
    data = {
        key: value for key, value in data.items() if key != "$schema"
    }  # where JSON files name their schema
    known_keys(data, Document.__struct_fields__, at)
    return Scene(**data, folder=folder, source=source, limits=limits or Limits())


def edited(scene: Scene, changes: Mapping[str, Any]) -> Scene:
    """`Scene.replace` for a picture that is asked for with a number of samples of its own.

    Whether `adaptive` goes with them is looked at then, not here.
    """
    return scene._edited(changes)


def previewed(scene: Scene, spp: int) -> Scene:
    """The scene to be looked at with `spp` samples a pixel: `adaptive` goes with its own number alone."""
    if scene.adaptive is None or (scene.camera is not None and scene.camera.spp == spp):
        return scene
    return edited(scene, {"adaptive": None})


def read_camera(data: object, at: At) -> Camera | None:
    """The checked camera that `data`, a table or a Camera, describes; None for None."""
    return None if data is None else read(Camera, data, at.key("camera")).upright()
