"""A scene's tables, as a file or the caller states them, as the records of `records`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio

from .records import (
    LIGHTS,
    AreaLight,
    Camera,
    Checker,
    Conductor,
    DirectionalLight,
    Formula,
    Material,
    NormalMap,
    Picture,
    PointLight,
    Scene,
    Source,
    Spectral,
    Spectrum,
    SpotLight,
)
from .shapes import SHAPES, Mesh, Shape

COLORS = ("highlight_color", "reflection_color", "transmission_color", "emission", "absorption")


_READS = ("openexr", "hdr", "png", "jpeg", "bmp")  # of what is read here, as OpenImageIO calls them
_INKS = ("CMYK", "YCbCrK")


class Untranslated(ValueError):
    """What a scene has and Mitsuba's side has no translation of."""


def read(source: Source) -> Scene:
    """The scene, with what the caller wants otherwise."""
    tables = {key: value for key, value in source.tables.items() if key not in ("$schema", "version")}
    for key in ("ambient", "depth_color"):
        if key in tables:
            tables[key] = color(tables[key])
    back = tables.get("background", 0.0)
    tables["background"] = back if isinstance(back, str) and back not in LIGHTS else color(back)
    tables["materials"] = {name: material(table) for name, table in tables.get("materials", {}).items()}
    tables["lights"] = tuple(map(_light, tables.get("lights", ())))
    tables["shapes"] = tuple(_shape(table, source.folder) for table in tables.get("shapes", ()))
    if tables.get("spectrum") is not None:
        spectral = dict(tables["spectrum"])
        tables["spectrum"] = Spectral(**{key: frozen(value) for key, value in spectral.items()})
    if tables.get("camera") is not None:
        wanted = {name: getattr(source, name) for name in ("width", "height", "spp")}
        stated = Camera(**{key: frozen(value) for key, value in tables["camera"].items()})
        camera = {name: value for name, value in wanted.items() if value is not None}
        resized = replace(stated, **camera)
        # shift and K are of a picture of the size that the table says
        scale = np.array([resized.width / stated.width, resized.height / stated.height, 1.0])
        resized = replace(resized, shift=tuple(scale[:2] * stated.shift))
        if stated.K is not None:
            resized = replace(resized, K=np.array(stated.K, float) * scale[:, None])
        tables["camera"] = resized
    scene = Scene(**tables, folder=source.folder)
    for name in {file for shape in scene.shapes for file in scene.material_of(shape).pictures}:
        _check_stored(Path(scene.folder or ".") / name)
    if scene.background_path is not None:
        _check_stored(scene.background_path)
        _check_readable(scene.background_path)
    return scene if source.max_depth is None else replace(scene, max_depth=source.max_depth)


def _check_stored(path: Path) -> None:
    """Mitsuba takes the samples as they are stored, from the corner of what is stored on."""
    picture = oiio.ImageInput.open(str(path))
    if picture is None:  # of colours of a mesh, or who reads it says so
        oiio.geterror()
        return
    spec, exr = picture.spec(), picture.format_name() == "openexr"
    picture.close()
    if spec.get_int_attribute("Orientation", 1) != 1:
        raise Untranslated("pictures that their file says to turn are not translated")
    if exr and oiio.get_roi(spec) != oiio.get_roi_full(spec):
        raise Untranslated("pictures of which a file stores a part, or more, are not translated")


def _check_readable(sky: Path) -> None:
    """Mitsuba reads a picture of the sky itself."""
    picture = oiio.ImageInput.open(str(sky))
    if picture is None:
        oiio.geterror()
        return
    name, inks = picture.format_name(), picture.spec().get_string_attribute("jpeg:ColorSpace")
    picture.close()
    if name not in _READS or inks in _INKS:
        kind = f"{inks} JPEG" if inks in _INKS else name.upper()
        why = f"a background that is a {kind}, which Mitsuba does not read"
        raise Untranslated(f"{why}; save it as EXR or PNG")


def frozen(value: Any) -> Any:
    """Lists and arrays as tuples, so that equal materials are equal."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    return tuple(map(frozen, value)) if isinstance(value, (list, tuple)) else value


def color(value: Any) -> Any:
    """A number, three numbers, or a Spectrum."""
    value = frozen(value)
    if isinstance(value, str):
        return Spectrum("name", value)
    if isinstance(value, Mapping):
        scale = float(value.get("scale", 1.0))
        ((kind, said),) = ((key, said) for key, said in value.items() if key not in ("scale", "type"))
        return Spectrum(kind, frozen(said), scale)
    return Spectrum("samples", value) if isinstance(value, tuple) and isinstance(value[0], tuple) else value


def _is_picture(value: Any) -> bool:
    return isinstance(value, Mapping) and value.get("type") == "image"


def _picture(table: Any) -> Picture:
    if str(table["file"]).lower().endswith(".ply"):
        if table.keys() - {"type", "file", "part", "wrap", "tint"}:
            raise Untranslated("colours of a mesh are not moved, and are linear")
        return Picture(table["file"], part=table["part"], tint=frozen(table.get("tint", (1.0, 1.0, 1.0))))
    return Picture(**{key: frozen(value) for key, value in _in_a_file(table).items() if key != "type"})


def _in_a_file(table: Any) -> dict[str, Any]:
    if table.get("part") is not None:
        raise Untranslated("pictures within a model's file are not translated")
    return dict(table)


def _normal_map(table: dict[str, Any]) -> NormalMap:
    placement = table.pop("placement", None)
    how = None if placement is None else Picture("", **{key: frozen(of) for key, of in placement.items()})
    return NormalMap(**table, placement=how)


def material(table: Any) -> Material:
    values = {key: frozen(value) for key, value in table.items()}
    for key in COLORS:
        if key in values:
            values[key] = _picture(values[key]) if _is_picture(values[key]) else color(values[key])
    if "normal_map" in values:
        values["normal_map"] = _normal_map(_in_a_file(values["normal_map"]))
    if "color" in values:
        shown = values["color"]
        if isinstance(shown, Mapping) and shown.get("type") == "checker":
            keys = {key: value for key, value in shown.items() if key != "type"}
            if "colors" in keys:
                keys["colors"] = tuple(color(part) for part in keys["colors"])
            values["color"] = Checker(**keys)
        elif _is_picture(shown):
            values["color"] = _picture(shown)
        else:
            values["color"] = color(shown)
    ior = values.get("ior", 1.5)
    if isinstance(ior, Mapping):
        ((kind, numbers),) = ior.items()
        numbers = [numbers["B"], numbers["C"]] if kind == "sellmeier" else numbers
        values["ior"] = Formula(kind, frozen(numbers))
    metal = values.get("conductor")
    if isinstance(metal, Mapping):
        values["conductor"] = Conductor(frozen(metal["eta"]), frozen(metal["k"]))
    return Material(**values)


def _light(table: Any) -> Any:
    kinds = {"point": PointLight, "directional": DirectionalLight, "spot": SpotLight}
    values = {key: frozen(value) for key, value in table.items()}
    for name in ("intensity", "radiance"):
        if name in values:
            values[name] = color(values[name])
    return kinds.get(table["type"], AreaLight)(**values)


def _shape(table: Any, folder: str | None) -> Shape:
    kind = SHAPES[table["type"]]
    values = {key: value for key, value in table.items() if key not in ("type", "name")}
    if isinstance(values.get("material"), Mapping):
        values["material"] = material(values["material"])
    if kind is Mesh:
        values["folder"] = folder
    assert values.keys() <= {each.name for each in fields(kind)}
    return kind(**values)
