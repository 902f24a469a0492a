"""Mitsuba's XML of a scene, with its meshes as PLY files beside it, and its picture of the sky."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
import OpenImageIO as oiio

from clrt.base import notices
from clrt.base.atomic import check_replaceable, replacing, write_text
from clrt.base.errors import ClrtError, located
from clrt.base.install import install_extra
from clrt.base.scratch import scratch
from clrt.images.file import read_image, write
from clrt.scene.scene import Checker, Scene

from .forms import Array
from .handed import tables
from .plugins import Plugin
from .reading import Untranslated, read
from .records import Source
from .translate import translated

VERSION = "3.0.0"
TAGS = {
    "path": "integrator",
    "perspective": "sensor",
    "orthographic": "sensor",
    "thinlens": "sensor",
    "hdrfilm": "film",
    "box": "rfilter",
    "tent": "rfilter",
    "gaussian": "rfilter",
    "mitchell": "rfilter",
    "independent": "sampler",
    "sphere": "shape",
    "rectangle": "shape",
    "disk": "shape",
    "cylinder": "shape",
    "ply": "shape",
    "twosided": "bsdf",
    "diffuse": "bsdf",
    "conductor": "bsdf",
    "roughconductor": "bsdf",
    "dielectric": "bsdf",
    "thindielectric": "bsdf",
    "blendbsdf": "bsdf",
    "point": "emitter",
    "directional": "emitter",
    "spot": "emitter",
    "area": "emitter",
    "constant": "emitter",
    "envmap": "emitter",
    "checkerboard": "texture",
}
_UNWRITTEN = re.compile(r"[$\x00-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")
POINTS = {"position": "point", "center": "point", "p0": "point", "p1": "point", "direction": "vector"}


def _refuse_spectra(scene: Scene) -> None:
    """ClrtError for a scene whose light is more than red, green and blue: what is written has no more."""
    found = "spectrum" if scene.spectrum is not None else None
    values: list[tuple[str, Any]] = [("ambient", scene.ambient)]
    if scene.background_path is None:
        values.append(("background", scene.background))
    values += [(f"lights[{i}].intensity", light.intensity) for i, light in enumerate(scene.lights)]
    for i, shape in enumerate(scene.shapes):
        material = scene.material_of(shape)
        if material.pictures:
            key = next(iter(material.pictures))
            text = "pictures on surfaces are not written; give plain colours"
            raise ClrtError(located(scene.source, f"shapes[{i}].material.{key}", text))
        if material.conductor is not None:
            found = found or f"shapes[{i}].material.conductor"
        for name in ("color", "highlight_color", "reflection_color", "transmission_color", "emission"):
            values.append((f"shapes[{i}].material.{name}", getattr(material, name)))
    plain = (int, float, tuple, Checker)
    found = found or next((place for place, value in values if not isinstance(value, plain)), None)
    if found:
        text = "Mitsuba's XML is written with red, green and blue only; give colours as 3 numbers"
        raise ClrtError(located(scene.source, found, text))


def to_xml(scene: Scene, meshes: str = "meshes") -> str:
    """The scene as Mitsuba's XML. Its meshes are said to lie in the folder `meshes`, where nothing is
    written."""
    _refuse_spectra(scene)
    return _document(scene, meshes, None)[0]


def write_xml(scene: Scene, path: str | os.PathLike[str], finish: Callable[[str], str] = str) -> int:
    """Write the XML to `path`, and the meshes into a folder beside it, named after it.

    The scene is the old one or the new one as a whole: names of meshes hold a digest of what is in them. What
    an old XML named and the new one does not stays, with a warning: other scenes may read it. finish: what
    the XML becomes, where the meshes lie already.

    Returns how many notes on what is not exact the file starts with. ClrtError where a file cannot be
    written, or a package that makes meshes is missing.
    """
    _refuse_spectra(scene)
    path = Path(path)
    folder = f"{_plain(path.stem)}_meshes"
    with scratch() as place:
        try:
            text, meshes = _document(scene, folder, path.parent, _plain_sky(scene, place))
        except ModuleNotFoundError as error:
            needs = f"{path}: its meshes need {error.name}; install it with: {install_extra('validation')}"
            raise ClrtError(needs) from None
        check_replaceable(path)
        before = _own_files(path, folder)
        with _files_beside(path.parent, folder, meshes):
            write_text(path, finish(text))
    left = sorted(name for name in before - _named(text, folder) if (path.parent / name).is_file())
    if left:
        more = f" and {len(left) - 1} more" if len(left) > 1 else ""
        said = f"{left[0]}{more} of the XML that was there stay; delete them if no other scene reads them"
        notices.warn(str(path), "", said)
    return text.count("<!--")


def _plain_sky(scene: Scene, place: Path) -> Path | None:
    """The picture of the sky as an EXR in a folder, where Mitsuba does not read its file as clrt does: other
    formats, inks, parts, channels and primaries, and what is stored turned or in part."""
    path = scene.background_path
    picture = None if path is None else oiio.ImageInput.open(str(path))
    if path is None or picture is None:  # who reads it says so
        oiio.geterror()
        return None
    spec, name = picture.spec(), picture.format_name()
    one, _ = not picture.seek_subimage(1, 0), picture.close()
    plain = spec.get_int_attribute("Orientation", 1) == 1
    if name == "openexr":
        plain = plain and one and oiio.get_roi(spec) == oiio.get_roi_full(spec)
        plain = plain and spec.channelnames in (("R", "G", "B"), ("R", "G", "B", "A"))
        plain = plain and spec.getattribute("chromaticities") is None
    else:
        inks = spec.get_string_attribute("jpeg:ColorSpace") in ("CMYK", "YCbCrK")
        plain = plain and name in ("png", "jpeg", "hdr") and not inks
    if plain:
        return None
    sky = place / f"{path.stem}.exr"
    write(sky, [np.asarray(read_image(path, scene.limits), np.float32)])
    return sky


def _plain(name: str) -> str:
    """A name of a file as a value may have it: without the sign that begins a parameter's, and what XML has
    no words for, control characters and bytes that are no text, each byte of which becomes `%` and two
    digits."""
    return _UNWRITTEN.sub(lambda found: "".join(f"%{byte:02X}" for byte in os.fsencode(found[0])), name)


def _own_files(path: Path, folder: str) -> set[str]:
    """The files of an XML that is replaced which `write_xml` made for it."""
    try:
        old = path.read_text("utf-8")
    except (OSError, ValueError):
        return set()
    return _named(old, folder)


def _named(text: str, folder: str) -> set[str]:
    """The files of an XML whose names are of the kind that `write_xml` gives them."""
    return set(re.findall(rf'value="({re.escape(folder)}/[^"/]*-[0-9a-f]{{16}}\.\w+)"', text))


@contextmanager
def _files_beside(parent: Path, folder: str, meshes: Mapping[str, Plugin | Path]) -> Iterator[None]:
    """Write what is not there yet; remove it, and the folder, where the block fails."""
    made, new = [], bool(meshes) and not (parent / folder).exists()
    try:
        if new:
            try:
                (parent / folder).mkdir()
            except OSError as error:
                raise ClrtError(f"{parent / folder}: cannot be made: {error.strerror}") from None
        for name, mesh in meshes.items():
            file = parent / name
            if not file.exists():
                made.append(file)
            elif _digest(file) in name:
                continue
            _write(mesh, file)
        yield
    except BaseException:
        for path in made:
            with suppress(OSError):
                path.unlink()
        if new:
            with suppress(OSError):
                (parent / folder).rmdir()
        raise


def _write(mesh: Plugin | Path, path: Path) -> None:
    with replacing(path) as temporary:
        if isinstance(mesh, Path):
            shutil.copyfile(mesh, temporary)
        else:
            temporary.write_bytes(ply(mesh))


def _digest(mesh: Plugin | Path) -> str:
    data = mesh.read_bytes() if isinstance(mesh, Path) else ply(mesh)
    return hashlib.sha256(data).hexdigest()[:16]


def _document(
    scene: Scene, meshes: str, folder: Path | None, sky: Path | None = None
) -> tuple[str, dict[str, Plugin | Path]]:
    """The XML; by file name the meshes, and a picture that does not lie among them, which is copied.

    folder: what names of pictures are relative to, None: nothing. sky: in place of the background's own file.
    """
    stated = tables(scene, whole=True) | ({} if sky is None else {"background": str(sky)})
    named = {str(table.get("material")) for table in stated.get("shapes", ())}  # others may be beyond words
    every = stated.get("materials", {})
    stated["materials"] = {name: every[name] for name in every if name in named}
    source = Source(stated, None if scene.folder is None else str(scene.folder))
    try:
        plain, notes = translated(read(source))
    except Untranslated as error:
        raise ClrtError(located(scene.source, "", f"cannot be written as Mitsuba's XML: {error}")) from None
    found: dict[str, Plugin | Path] = {}
    for key, plugin in plain.items():
        if isinstance(plugin, dict) and plugin["type"] == "mesh":
            name = f"{meshes}/{key}.ply" if folder is None else f"{meshes}/{key}-{_digest(plugin)}.ply"
            found[name] = plugin
            inner = {part: plugin[part] for part in ("bsdf", "emitter") if part in plugin}
            plain[key] = {"type": "ply", "filename": name, **inner}
        elif isinstance(plugin, dict) and "filename" in plugin and folder is not None:
            name = os.path.relpath(os.path.realpath(plugin["filename"]), os.path.realpath(folder))
            if not name.startswith(f"{meshes}/") or name != _plain(name):  # all is in one folder
                picture = Path(plugin["filename"])
                name = f"{meshes}/{_plain(picture.stem)}-{_digest(picture)}{_plain(picture.suffix)}"
                found[name] = picture
            plain[key] = {**plugin, "filename": name}
    lines = [f'<scene version="{VERSION}">']
    lines += [f"  <!-- {note.replace('--', '- -')} -->" for note in notes]
    for key, plugin in plain.items():
        if key != "type":
            lines += _element(key, plugin, 1)
    return "\n".join([*lines, "</scene>", ""]), found


def _element(name: str, value: Any, depth: int) -> list[str]:
    """One property or plugin, as indented lines."""
    indent, named = "  " * depth, f"name={quoteattr(name)}"
    if isinstance(value, dict):
        if value["type"] == "rgb":
            return [f'{indent}<rgb {named} value="{_numbers(value["value"])}"/>']
        tag = TAGS[value["type"]]
        # Mitsuba knows children by name (a texture's place) and top-level plugins by id
        label = f"id={quoteattr(name)}" if depth == 1 else named
        lines = [f"{indent}<{tag} type={quoteattr(value['type'])} {label}>"]
        for key, inner in value.items():
            if key != "type":
                lines += _element(key, inner, depth + 1)
        return [*lines, f"{indent}</{tag}>"]
    if isinstance(value, np.ndarray):
        if value.shape == (3, 3):  # in XML even a transform of the plane has 4x4 numbers
            plane, value = value, np.eye(4)
            value[:2, :2], value[:2, 3] = plane[:2, :2], plane[:2, 2]
        matrix = f'<matrix value="{_numbers(value.ravel())}"/>'
        return [f"{indent}<transform {named}>{matrix}</transform>"]
    if isinstance(value, list):
        x, y, z = (_number(part) for part in value)
        return [f'{indent}<{POINTS[name]} {named} x="{x}" y="{y}" z="{z}"/>']
    if isinstance(value, bool):
        return [f'{indent}<boolean {named} value="{str(value).lower()}"/>']
    if isinstance(value, (int, np.integer)):
        return [f'{indent}<integer {named} value="{value}"/>']
    if isinstance(value, (float, np.floating)):
        return [f'{indent}<float {named} value="{_number(value)}"/>']
    return [f"{indent}<string {named} value={quoteattr(value)}/>"]


def _number(value: Any) -> str:
    return repr(float(value))


def _numbers(values: Any) -> str:
    return ", ".join(map(_number, values)) if len(values) == 3 else " ".join(map(_number, values))


def ply(mesh: Plugin) -> bytes:
    """A mesh as a binary PLY file: float32 corners with normals, and u and v where it has them."""
    columns: list[Array] = [mesh["vertices"], mesh["normals"]]
    names = ["x", "y", "z", "nx", "ny", "nz"]
    if "texcoords" in mesh:
        columns.append(mesh["texcoords"])
        names += ["u", "v"]
    vertices = np.concatenate(columns, axis=1).astype("<f4")
    faces = np.empty(len(mesh["faces"]), np.dtype([("count", "u1"), ("corners", "<i4", 3)]))
    faces["count"], faces["corners"] = 3, mesh["faces"]
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    header += [f"property float {name}" for name in names]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    return "\n".join(header).encode() + vertices.tobytes() + faces.tobytes()
