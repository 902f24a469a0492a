"""Mitsuba's XML: its plugins as far as they have counterparts here, and whole scenes that clrt wrote."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np

from clrt.base import notices
from clrt.base.errors import ClrtError, LimitError, SceneError, located
from clrt.base.files import read_bytes, read_text_bytes, resolve
from clrt.base.limits import Limits
from clrt.base.places import At, listed
from clrt.formats import native
from clrt.formats.mitsuba.bsdfs import Materials
from clrt.formats.mitsuba.file import Context, opened
from clrt.formats.mitsuba.normals import by_number, fronts_differ, inside_out, leans
from clrt.formats.mitsuba.shapes import INSIDE_OUT, Shapes, front, green
from clrt.formats.mitsuba.surroundings import around
from clrt.formats.mitsuba.values import Plugin
from clrt.formats.mitsuba.views import ON_SHAPES, camera, depth, emitter
from clrt.formats.xml_tree import Element
from clrt.scene.mesh import Mesh, MeshData
from clrt.scene.save import moved
from clrt.scene.scene import Scene, read_scene

INSTRUCTION: Final = "clrt"
"""The target of the processing instruction that holds a seal and the scene itself, as JSON."""

_SHALLOW: Final = 2  # generations of rays; of more it is seldom seen
_DIGITS: Final = 8  # of a number of a mesh in JSON, at the least on an average


def load(path: Path, limits: Limits) -> Scene:
    """The scene in Mitsuba's XML (.xml).

    A file that clrt wrote, and that nobody has changed since, is the scene that was written. Of others the
    plugins are read; what has no counterpart is named in one warning.
    """
    context = Context(path.parent, path.name, limits)
    try:
        tops, notes = opened(read_text_bytes(path, limits), context)
        if INSTRUCTION in notes:
            mark, _, text = notes[INSTRUCTION].partition(" ")
            if mark == seal(tops, text, path.parent, limits):
                return native.load_text(text, path.name, path.parent, limits)
            what = "it, or a file that it names, was changed after clrt had written it: its plugins are read"
            notices.warn(path.name, "", what)
        return _scene(tops, context)
    except RecursionError:
        raise LimitError(located(path.name, "", "nesting: deeper than Python follows")) from None


def seal(tops: list[Element], text: str, folder: Path, limits: Limits) -> str:
    """A digest of all that a file says, of the scene itself in it, and of the files that its plugins name.

    The scene itself names no others: the picture of its sky is the one that a plugin names.
    """
    digest = hashlib.sha256(text.encode())
    files: dict[str, bytes] = {}  # a file may be named in every line
    for top in tops:
        for element in top.walk():
            told = [element.tag, *(f"{key}={value}" for key, value in sorted(element.keys.items()))]
            digest.update("\x1f".join([*told, str(len(element.children)), "\n"]).encode())
            if element.keys.get("name") == "filename":
                name = element.keys.get("value", "")
                if name not in files:
                    files[name] = _file_digest(name, folder, limits)
                digest.update(files[name])
    return digest.hexdigest()


def _file_digest(name: str, folder: Path, limits: Limits) -> bytes:
    try:
        return hashlib.sha256(read_bytes(resolve(name, folder, At()), limits)).digest()
    except ClrtError:
        return b"missing"


def with_itself(scene: Scene, path: Path, text: str) -> str:
    """The XML of a scene that is to be written to `path`, with the scene itself in it: as JSON, for `load`.

    Programs pass over processing instructions for others. What would not be read back, being too large,
    stays as it is, and so does what needs files that no plugin names; a warning says so.
    """
    limits = scene.limits
    try:
        tops, _ = opened(text.encode(), Context(path.parent, path.name, limits))
        words = _itself(scene, path, tops).replace("?>", "?\\u003e")  # within a text of JSON's the same
        instruction = f"<?{INSTRUCTION} {seal(tops, words, path.parent, limits)} {words}?>"
        longer = text.removesuffix("</scene>\n") + f"  {instruction}\n</scene>\n"
        limits.check("text_bytes", len(longer.encode()))
    except ClrtError as error:
        what = f"it holds its plugins alone, not the scene itself as well: {error}"
        notices.warn(path.name, "", what)
        return text
    return longer


def _itself(scene: Scene, path: Path, tops: list[Element]) -> str:
    """The scene as JSON that names no file but the picture of the sky, as a plugin of `tops` does.

    So it is not another scene where the files that it was made of are not there, or have changed.
    """
    for name, material in scene.materials.items():  # pictures on surfaces are refused; these are on none
        if material.pictures:
            key = next(iter(material.pictures))
            raise SceneError(located("", f"materials.{name}.{key}", "a picture, which is not copied"))
    meshes = [shape.data() for shape in scene.shapes if isinstance(shape, Mesh)]
    scene.limits.check("text_bytes", _DIGITS * sum(map(_numbers, meshes)))  # before lists are made
    sky = scene.background_path is not None
    table = moved(msgspec.structs.replace(scene, background=0.0) if sky else scene, path, whole=True)
    if sky:
        skies = (element for top in tops if top.keys.get("type") == "envmap" for element in top.children)
        table["background"] = next(sky.keys["value"] for sky in skies if sky.keys.get("name") == "filename")
    return json.dumps(table, separators=(",", ":"))


def _numbers(mesh: MeshData) -> int:
    arrays = [array for array in (mesh.vertices, mesh.normals, mesh.uv) if array is not None]
    faces = mesh.faces.size if isinstance(mesh.faces, np.ndarray) else sum(map(len, mesh.faces))
    return faces + sum(array.size for array in arrays)


def _look_at_files(scene: Scene, shapes: Shapes, context: Context) -> None:
    """Name what meshes of files, which have been read by now, have otherwise there."""
    looks = ((shapes.glass, inside_out, lambda plugin: INSIDE_OUT), (shapes.leaning, leans, green),
             (shapes.leaning, fronts_differ, front))  # fmt: skip
    for plugins, differs, name in looks:
        for number, plugin in plugins.items():
            mesh = scene.shapes[number]
            assert isinstance(mesh, Mesh)
            if differs(mesh, plugin.flag("flip_normals", False), context.limits):
                context.left_out[name(plugin)] = None


def _shows_lights(scene: Scene) -> bool:
    """Whether there is a mirror or glass, and light that a ray may meet: there that is one bounce less."""
    seen = scene.background != 0 or any("radiance" in light.__struct_fields__ for light in scene.lights)
    materials = map(scene.material_of, scene.shapes)
    return seen and any(material.kr > 0 or material.kt > 0 for material in materials)


def _scene(tops: list[Element], context: Context) -> Scene:
    materials = Materials(context)
    shapes = Shapes(materials)
    table: dict[str, Any] = {"lights": shapes.lights}
    cameras, areas, most = 0, list[Element](), None
    for element in tops:
        if element.tag == "shape":
            shapes.add(element)
        elif element.tag == "emitter" and element.keys.get("type") in ON_SHAPES:
            areas.append(element)
        elif element.tag == "emitter":
            emitter(Plugin.of(element), context, table)
        elif element.tag == "sensor":
            cameras += 1
            if cameras == 1:
                view = camera(Plugin.of(element), context)
                table |= {} if view is None else {"camera": view}
        elif element.tag == "integrator":
            most = most if (found := depth(element, context)) is None else found
        elif element.tag == "bsdf":
            materials.of(element)  # so that what is wrong in it is said, though nothing should have it
        elif element.tag in ("medium", "phase", "volume"):
            context.left_out["media"] = None
    for element in areas:  # which shapes refer to
        if not shapes.refers_to(element):
            emitter(Plugin.of(element), context, table)
    context.lost(tops)
    if cameras > 1:
        context.left_out["cameras but the first"] = None
    table |= {} if most is None else {"max_depth": most}
    table |= {"shapes": shapes.shapes, "materials": shapes.named}
    table |= {"medium_ior": min(shapes.outside.values())} if shapes.outside else {}
    with notices.without("diffuse + max("):  # of coefficients that nobody stated here
        scene = read_scene(table, folder=context.folder, source=context.source, limits=context.limits)
    if most is not None and most <= _SHALLOW and _shows_lights(scene):
        context.left_out[f"what mirrors and glass show of light at a max_depth of {most + 2}"] = None
    _look_at_files(scene, shapes, context)
    around(shapes.outside, scene, context.left_out)
    if context.left_out:
        text = f"left out, since there is no counterpart: {listed(context.left_out)}"
        notices.warn(context.source, "", text)
    return by_number(scene)
