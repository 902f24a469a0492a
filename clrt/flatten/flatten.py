"""A scene as the arrays that go to the device. Knows no OpenCL; all is computed in float64 and rounded once.

Sections and records are those of `clrt.layout`; the tree over the boxes is built on the device.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from clrt import layout
from clrt.base.errors import SceneError, located
from clrt.base.files import version
from clrt.flatten.camera import flatten_camera
from clrt.flatten.coarse import warn_of_coarse_places
from clrt.flatten.entries import check_entries
from clrt.flatten.flush import warn_of_flush, warn_of_flush_lamps
from clrt.flatten.geometry import GEOMETRY, geometry
from clrt.flatten.hidden import warn_of_hidden_view
from clrt.flatten.images import Pictures
from clrt.flatten.lightsurfaces import SECTIONS, add_surfaces, visible_lights, without_surfaces
from clrt.flatten.mapping import mappings
from clrt.flatten.materials import MaterialTable, flatten_lights, shows_pictures
from clrt.flatten.media import Extents, Media, extents_of, media_of, needs_lists
from clrt.flatten.overlaps import warn_of_overlaps
from clrt.flatten.rims import warn_of_open_meshes
from clrt.flatten.shapes import collect, pictured_meshes
from clrt.images.file import read_image
from clrt.layout import ceilings
from clrt.scene.scene import Mesh, Scene, Shape
from clrt.spectra.bands import Bands, light
from clrt.spectra.colorimetry import RGB_OF_XYZ, rgb_matrix, thesis_matrix, xyz_matrix

__all__ = ["FlatScene", "flatten", "flatten_camera"]


@dataclass(frozen=True, eq=False)
class FlatScene:
    """One array for each section of the world, with at least one element (how many count is in `scene`).

    `finite` are the numbers of the primitives that have a box, ascending, `boxes` their boxes (w is 0), wide
    enough that they contain every hit the kernels may find. `n_shapes` is the number of shapes of the scene.
    `group` is how many bands dispersion bends together, 0 where nothing disperses.
    `response` (rows, bands) float32 turns a pixel's bands into its colour (by `colorimetry.finished`),
    `xyz` (3, bands) into CIE XYZ; None in RGB mode, where the bands are the colour.
    `media` tells in which media rays start; None where rays need no lists of them. From `textures` on:
    sections that a scene without pictures on its surfaces has not, and what was read. `sky` is the file of
    the background image, and its `files.version`. `extents` say what later scenes of the same shapes need
    not find again; they do not travel.
    """

    scene: np.ndarray
    primitives: np.ndarray
    spheres: np.ndarray
    planes: np.ndarray
    disks: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray
    polygons: np.ndarray
    vertices: np.ndarray
    quadrics: np.ndarray
    unbounded: np.ndarray
    materials: np.ndarray
    lights: np.ndarray
    background: np.ndarray
    boxes: np.ndarray
    finite: np.ndarray
    n_shapes: int
    media: Media | None
    group: int = 0
    response: np.ndarray | None = None
    xyz: np.ndarray | None = None
    textures: np.ndarray | None = None
    texels: np.ndarray | None = None
    pictured: np.ndarray | None = None
    mappings: np.ndarray | None = None
    mapping_of: np.ndarray | None = None
    corner_uv: np.ndarray | None = None
    primaries: np.ndarray | None = None
    pictures: Pictures | None = None
    sky: tuple[Path, tuple[int, ...] | None] | None = None
    extents: Extents | None = None

    @property
    def bands(self) -> int:
        """How many values of light a ray carries: 3 in RGB mode."""
        return int(self.scene["ambient"].shape[-1])

    @property
    def ray_format(self) -> layout.RayFormat:
        """What rays carry through this scene."""
        images = self.pictures is not None
        mips = self.pictures is not None and any(self.pictures.levels)
        extent = any(self.scene[name][0] for name in ("extended", "surfaces", "rough"))
        own = {"images": images, "mips": mips, "extent": extent}
        return layout.RayFormat(self.bands, self.media_places, self.group, **own)

    @property
    def media_places(self) -> int:
        """Places in the list of media that each ray carries; 0 where it needs none."""
        return 0 if self.media is None else layout.MEDIA

    @cached_property
    def hash(self) -> str:
        """SHA-256 (hexadecimal) of all arrays: scenes of one hash give one picture from a camera."""
        digest = hashlib.sha256()
        for entry in fields(self):
            value = getattr(self, entry.name)
            if isinstance(value, np.ndarray):
                digest.update(f"{entry.name} {value.dtype.descr} {value.shape}\n".encode())
                digest.update(self._digest(value))
        return digest.hexdigest()

    @property
    def feelers(self) -> int:
        """The most that a hit sends: one to each light, or to each of its points."""
        return int(self.lights["samples"].sum())

    @cached_property
    def seen(self) -> np.ndarray | None:
        """(3, bands) float32: reflectances in bands to the colours they have under D65; None in RGB mode."""
        if self.xyz is None:
            return None
        info = self.scene[0]
        white = info["sky_red"].astype(np.float64) + info["sky_green"] + info["sky_blue"]
        return (RGB_OF_XYZ @ (self.xyz * white)).astype(np.float32)

    @cached_property
    def digests(self) -> dict[int, bytes]:
        """By the identity of an array its SHA-256: those that scenes share are looked through once."""
        return {}

    def __getstate__(self) -> dict[str, object]:
        """Without what was computed from it: identities of arrays mean nothing in another process."""
        kept = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        return kept | {"extents": None}

    def _digest(self, array: np.ndarray) -> bytes:
        if id(array) not in self.digests:
            self.digests[id(array)] = hashlib.sha256(np.ascontiguousarray(array).view(np.uint8).data).digest()
        return self.digests[id(array)]


@np.errstate(all="ignore")  # coordinates that overflow are found and named; light that does is infinite
def flatten(scene: Scene, known: tuple[Scene, FlatScene] | None = None) -> FlatScene:
    """The scene without its camera, for rays of the scene's bands (RGB mode: red, green, blue).

    known: another scene, and what it was flattened to. Where both have the same shapes (the very objects, or
    meshes of the very arrays) the arrays of their geometry are shared, and nobody is warned of the view a
    second time, nor of surfaces that touch unless light passes more of them than before; pictures whose
    files are what they were are not read again.

    Raises `SceneError` with the place of a shape of a kind that a table lacks, or that its transform makes
    one that there is no primitive for, or whose coordinates leave the range of float32, and for a background
    that cannot be read, `LimitError` for more lights than the kernels can count.
    """
    ahead = _taken(scene) if known is None else None
    if ahead is not None:
        return ahead
    check_entries(scene)
    feelers = sum(getattr(light, "samples", 1) for light in scene.lights)  # first: each takes time below
    ceilings.check("lights", feelers, ceilings.LIGHTS, scene.source)
    bands = bands_of(scene)
    materials = MaterialTable(scene, bands)
    numbers = [materials.number(shape) for shape in scene.shapes]
    glowing = {number: materials.glowing(light) for number, light in visible_lights(scene).items()}
    same = known is not None and _same_shapes(scene, known[0]) and _same_fans(scene, known[0])
    before = known[1] if known and known[1].extents and same else None
    if before and before.extents:
        sections, extents = _geometry_of(before, before.extents, numbers)
    else:
        sections = geometry(collect(scene, numbers), scene)
        extents = extents_of(numbers, sections)
    sections["materials"] = materials.records()
    sections["lights"] = flatten_lights(scene, bands)
    sections["background"], sides, sky = _background(scene, known[1] if known else None)
    sections["scene"] = _scene_info(scene, sections, sides, bands)
    lists = needs_lists(scene, sections["materials"], extents)
    media = media_of(scene, sections["materials"], extents) if lists else None
    if media is not None:
        warn_of_overlaps(media, sections["materials"]["priority"][media.numbers])
    if before is None:
        warn_of_coarse_places(scene, extents.low, extents.high)
        warn_of_hidden_view(scene, extents.low, extents.high)
        warn_of_flush_lamps(scene, extents.low, extents.high)
    passes = _passes(sections["materials"], extents)
    told = _passes(before.materials, before.extents) if before and before.extents else False
    if (passes > told).any():
        warn_of_flush(scene, extents.low, extents.high, passes)
        warn_of_open_meshes(scene, passes)
    add_surfaces(scene, sections, glowing)
    shown = materials.pictures(known[1].pictures if known else None)
    pictures = None
    if shown is not None:
        tables, pictures = shown
        sections |= tables | mappings(scene, sections["primitives"], shows_pictures(tables["pictured"]))
    boxes, finite = sections.pop("boxes"), sections.pop("finite")
    kept = {
        name: array if len(array) else np.zeros((1, *array.shape[1:]), array.dtype)
        for name, array in sections.items()
    }
    response, xyz = _responses(scene, bands)
    flat = FlatScene(
        **kept,
        boxes=boxes,
        finite=finite,
        n_shapes=len(scene.shapes),
        media=media,
        group=scene.spectrum.group if scene.spectrum and sections["materials"]["dispersive"].any() else 0,
        response=response,
        xyz=xyz,
        pictures=pictures,
        sky=sky,
        extents=extents,
    )
    if before:
        own = {id(getattr(flat, name)) for name in GEOMETRY}
        flat.digests.update((key, digest) for key, digest in before.digests.items() if key in own)
    return flat


_ahead: list[tuple[Scene, FlatScene]] = []


def flatten_ahead(scene: Scene) -> FlatScene:
    """`flatten(scene)`, which the next call for the very same scene does not do again."""
    _ahead[:] = [(scene, flatten(scene))]
    return _ahead[0][1]


def _taken(scene: Scene) -> FlatScene | None:
    """What was flattened ahead, once."""
    for entry in _ahead:
        if entry[0] is scene:
            _ahead.remove(entry)
            return entry[1]
    return None


def _passes(materials: np.ndarray, extents: Extents) -> np.ndarray:
    """Which shapes light passes."""
    return np.asarray(materials["kt"][list(extents.materials)] > 0)


def _same_shapes(scene: Scene, other: Scene) -> bool:
    """Whether two scenes have shapes in the same places: the same objects, or meshes of the same arrays."""
    if scene.shapes is other.shapes:
        return True
    return len(scene.shapes) == len(other.shapes) and all(map(_same_places, scene.shapes, other.shapes))


def _same_fans(scene: Scene, other: Scene) -> bool:
    """Whether two scenes of the same shapes make triangles of the same meshes."""
    if scene.materials is other.materials and scene.shapes is other.shapes:
        return True
    return pictured_meshes(scene) == pictured_meshes(other)


def _same_places(one: Shape, other: Shape) -> bool:
    if one is other:
        return True
    if not isinstance(one, Mesh) or not isinstance(other, Mesh) or one.data() is not other.data():
        return False
    return bool(one.transform) == bool(other.transform) and one.matrix.tobytes() == other.matrix.tobytes()


def _geometry_of(
    flat: FlatScene, extents: Extents, materials: list[int]
) -> tuple[dict[str, np.ndarray], Extents]:
    """What `geometry` gives for shapes flattened before that now have materials of these numbers."""
    sections = {name: getattr(flat, name) for name in GEOMETRY}
    if flat.scene["surfaces"][0]:
        sections = without_surfaces(sections, flat.n_shapes)
    sections |= {name: sections[name][:0] for name in ("primitives", "unbounded") if not flat.scene[name][0]}
    for name in SECTIONS:
        if not np.frombuffer(sections[name][:1], np.uint8).any():  # no record is all 0: it stands in for none
            sections[name] = sections[name][:0]
    if extents.materials == tuple(materials):
        return sections, extents
    sections["primitives"] = sections["primitives"].copy()
    sections["primitives"]["material"] = np.array(materials, np.int32)[sections["primitives"]["shape"]]
    return sections, replace(extents, materials=tuple(materials))


def _background(
    scene: Scene, known: FlatScene | None
) -> tuple[np.ndarray, tuple[int, int], tuple[Path, tuple[int, ...] | None] | None]:
    """The background image's numbers, its height and width, and its file as `FlatScene.sky`; where there is
    none 0 and None.
    """
    path = scene.background_path
    if path is None:
        return np.zeros(0, np.float32), (0, 0), None
    sky = path, version(path)
    if known and sky[1] is not None and known.sky == sky:
        info = known.scene[0]
        return known.background, (int(info["background_height"]), int(info["background_width"])), sky
    image = read_image(path, scene.limits)
    return np.ascontiguousarray(image, np.float32).reshape(-1), (image.shape[0], image.shape[1]), sky


def _responses(scene: Scene, bands: Bands | None) -> tuple[np.ndarray | None, np.ndarray | None]:
    """`response` and `xyz` of a scene with a spectrum."""
    spectrum = scene.spectrum
    if spectrum is None or bands is None:
        return None, None
    if spectrum.faults:
        text = "faults are for validation/thesis2011/pictures.py; clrt itself has none of them to switch on"
        raise SceneError(located(scene.source, "spectrum.faults", text))
    response = thesis_matrix(bands) if spectrum.response == "thesis-2011" else rgb_matrix(bands, spectrum)
    return response.astype(np.float32), xyz_matrix(bands).astype(np.float32)


def bands_of(scene: Scene) -> Bands | None:
    """The bands of the scene's spectrum; None in RGB mode."""
    spectrum = scene.spectrum
    return None if spectrum is None else Bands(spectrum.bands, *spectrum.range)


def _scene_info(
    scene: Scene, sections: dict[str, np.ndarray], image: tuple[int, int], bands: Bands | None
) -> np.ndarray:
    """The record SceneInfo, shape (1,); `nodes` is left to who builds the tree."""
    out = np.zeros(1, layout.dtype("SceneInfo", layout.BANDS if bands is None else bands.n))
    info = out[0]
    for name in ("primitives", "unbounded", "lights"):
        info[name] = len(sections[name])
    info["ambient_samples"] = scene.ambient_samples
    info["tinted"] = scene.shadow == "tinted"
    info["spd"] = scene.conformance == "spd"
    info["rough"] = (sections["materials"]["alpha"] > 0).any()
    info["extended"] = sections["lights"]["extended"].any()
    info["one_sided"] = sections["materials"]["one_sided"].any()
    info["medium_ior"], info["min_weight"] = scene.medium_ior, scene.min_weight
    info["background_height"], info["background_width"] = image
    info["ambient"], info["depth_color"] = light(scene.ambient, bands), light(scene.depth_color, bands)
    if scene.background_path is None:
        info["background"] = light(scene.background, bands)
    for name, primary in (("sky_red", (1, 0, 0)), ("sky_green", (0, 1, 0)), ("sky_blue", (0, 0, 1))):
        info[name] = light(primary, bands)
    return out


def check_ceilings(flat: FlatScene, source: str = "") -> None:
    """Raise LimitError for a scene that the kernels cannot number or count."""
    info = flat.scene[0]
    ceilings.check("ambient_samples", int(info["ambient_samples"]), ceilings.AMBIENT, source)
    ceilings.check("primitives", int(info["primitives"]), ceilings.PRIMITIVES, source)
    ceilings.check("materials", len(flat.materials), ceilings.MATERIALS, source)
    ceilings.check("bands", flat.bands, ceilings.BANDS, source)
    if flat.group:
        ceilings.check("dispersion groups", -(-flat.bands // flat.group), ceilings.GROUPS, source)
