"""Mitsuba's shapes as those of a scene file, and their area emitters as lights."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from clrt.formats.mitsuba.bsdfs import Materials, mean
from clrt.formats.mitsuba.checkers import checker_of
from clrt.formats.mitsuba.normals import has_uv
from clrt.formats.mitsuba.values import UNIT, Array, Plugin, rows
from clrt.formats.xml_tree import Element, unknown
from clrt.meshfiles.look import Names, placement_of, textures_without_uv
from clrt.scene.transforms import is_similarity

Table = dict[str, Any]
_EVERY: Final = {"to_world": "x", "flip_normals": "x", "silhouette_sampling_weight": "-"}
_MESH: Final = _EVERY | {"filename": "x", "face_normals": "x", "flip_tex_coords": "x"}
_KEYS: Final[dict[str, dict[str, str]]] = {
    "sphere": _EVERY | {"center": "x", "radius": "x"},
    "cylinder": _EVERY | {"p0": "x", "p1": "x", "radius": "x"},
    "rectangle": _EVERY | {"face_normals": "-"}, "cube": _EVERY | {"face_normals": "-"}, "disk": _EVERY,
    "obj": _MESH, "ply": _MESH,
}  # fmt: skip
_OTHERS: Final = ("serialized", "shapegroup", "instance", "bsplinecurve", "linearcurve", "sdfgrid", "merge",
                  "ellipsoids", "ellipsoidsmesh", "hair", "heightfield", "rectangles", "blender")  # fmt: skip
_CORNERS: Final = np.array([[-1.0, -1, 0, 1], [1, -1, 0, 1], [1, 1, 0, 1], [-1, 1, 0, 1]])
_EQUAL: Final = 1e-6  # of squares of lengths: files state six digits or more
_PLAIN: Final = Element("bsdf", {"type": "diffuse"}, 0, "")  # of a shape that names none, as Mitsuba has it
_AS_IT_IS: Final[Table] = {"wrap": "repeat", "filter": "linear", "scale": [1.0, 1.0], "offset": [0.0, 0.0]}
_UV: Final = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
_HALVES: Final = np.array([[0, 1, 2], [0, 2, 3]])
INSIDE_OUT: Final = "which side of glass is its inside"
_CHECKED: Final = ("rectangle", "sphere")  # may have a checker


@dataclass(eq=False)
class Shapes:
    """Shapes, lights and named materials of a scene, as they are met."""

    materials: Materials
    shapes: list[Table] = field(default_factory=list)
    lights: list[Table] = field(default_factory=list)
    named: dict[str, Table] = field(default_factory=dict)
    _names: Names = field(default_factory=Names)
    _made: dict[tuple[Any, ...], Table] = field(default_factory=dict)  # of materials, as shapes have them
    _called: dict[int, str] = field(default_factory=dict)
    _alike: dict[str, str] = field(default_factory=dict)
    _radiances: dict[int, Any] = field(default_factory=dict)
    leaning: dict[int, Plugin] = field(default_factory=dict)  # files with a normal map, by number
    outside: dict[int, float] = field(default_factory=dict)  # indices around glass, by number
    glass: dict[int, Plugin] = field(default_factory=dict)  # files that light enters
    _with_uv: dict[str, bool] = field(default_factory=dict)  # by names of files

    def add(self, element: Element) -> None:
        """One shape, or the light that it is."""
        plugin, context = Plugin.of(element), self.materials.context
        if plugin.type not in _KEYS:
            context.without(plugin, [*_KEYS], _OTHERS)
            return
        context.check(plugin, _KEYS[plugin.type])
        if context.elements(plugin, "medium"):
            context.left_out["media"] = None
        radiance = self._radiance(plugin)
        light = None if radiance is None else _light(plugin)
        if light is not None:
            if context.elements(plugin, "bsdf"):
                context.left_out["the surfaces of lights"] = None
            self.lights.append(light | {"radiance": radiance})
            return
        bsdf = context.first(plugin, "bsdf") or _PLAIN
        table = self._settled(self._inner(self.materials.of(bsdf)))
        flipped = plugin.flag("flip_normals", False)
        file = plugin.type in ("obj", "ply")  # which nobody has looked at yet
        # a mirrored sphere is inside out there, and with its normals flipped right side out again
        turned = _turned(plugin) if plugin.type in ("sphere", "cylinder") else flipped
        if table.get("transmission") and not table.get("thin"):
            self.glass |= {len(self.shapes): plugin} if file else {}
            context.left_out |= {INSIDE_OUT: None} if turned and not file else {}
        if "normal_map" in table and file:
            self.leaning[len(self.shapes)] = plugin
        elif "normal_map" in table and plugin.type != "rectangle":
            context.left_out |= {green(plugin): None} if _green_down(plugin) else {}
            context.left_out |= {front(plugin): None} if flipped else {}
        material = self._dressed(table, plugin)
        if radiance is not None:
            inwards = plugin.type == "sphere" and is_similarity(plugin.to_world())
            of = "a sphere sheds inwards" if inwards else "a mesh sheds"
            context.left_out[f"the light that {of}"] = None
            material = material | {"emission": radiance}
        shape = _MAKE[plugin.type](plugin)
        if file:
            shape |= self._file(plugin)
            if _pictured(material) and not self._uv(shape["file"]):
                context.left_out[textures_without_uv(bsdf.keys.get("id", plugin.type))] = None
                material = self._bare(material)
        elif plugin.type == "rectangle" and _pictured(material):
            shape = {"type": "mesh", "vertices": np.array(shape["points"]), **_sheet(plugin, table)}
        if radiance is None:
            shape["material"] = self._name(bsdf, material)
        else:
            context.take(material, "shape", element)
            shape["material"] = material
        if "id" in element.keys:
            shape["name"] = element.keys["id"]
        self.shapes.append(shape)

    def _name(self, element: Element, table: Table) -> str:
        """The name of a material: one for all that are alike, of the first of them."""
        key = id(table)  # which is kept
        if key not in self._called:
            self.materials.context.take(table, "material", element)
            like = repr(table)
            if like not in self._alike:
                self._alike[like] = self._names.new(element.keys.get("id") or element.keys["type"])
                self.named[self._alike[like]] = table
            self._called[key] = self._alike[like]
        return self._called[key]

    def _radiance(self, plugin: Plugin) -> Any:
        """That of the area emitter within a shape; None where it has none."""
        found = self.materials.context.first(plugin, "emitter")
        if found is None:
            return None
        if id(found) not in self._radiances:
            self._radiances[id(found)] = self._shed(Plugin.of(found))
        self.materials.context.take(self._radiances[id(found)], "light", plugin.element)
        return self._radiances[id(found)]

    def _shed(self, emitter: Plugin) -> Any:
        """The radiance of an area emitter."""
        if emitter.type == "directionalarea":
            self.materials.context.left_out["the light of a directionalarea"] = None
            return 0.0
        if emitter.type != "area":
            raise unknown(emitter.element, "emitter of a shape", emitter.type, ["area", "directionalarea"])
        self.materials.context.check(emitter, {"radiance": "x", "sampling_weight": "-"})
        color = self.materials.tint(emitter, "radiance", 1.0)
        if isinstance(color, dict):
            self.materials.context.left_out["textures of lights"] = None
            return 1.0
        return color

    def _file(self, plugin: Plugin) -> Table:
        if "filename" not in plugin.values:
            raise plugin.element.says(f"the shape {plugin.type} needs its filename")
        name = self.materials.context.file(plugin.values["filename"])
        return {"file": name, "smooth": not plugin.flag("face_normals", False)}

    def refers_to(self, emitter: Element) -> bool:
        """Whether a shape has the light of this emitter."""
        return id(emitter) in self._radiances

    def _uv(self, file: str) -> bool:
        if file not in self._with_uv:
            context = self.materials.context
            self._with_uv[file] = has_uv(context.folder / file, context.limits)
        return self._with_uv[file]

    def _bare(self, table: Table) -> Table:
        """A material without pictures: grey, as what other textures leave."""
        key = id(table), "bare"
        if key not in self._made:
            left = {name: 0.5 if _is_image(value) else value for name, value in table.items()}
            left.pop("normal_map", None)
            self._made[key] = left
        return self._made[key]

    def _inner(self, table: Table) -> Table:
        """A material without the index around it, which is kept."""
        if "ext_ior" not in table:
            return table
        self.outside[len(self.shapes)] = table["ext_ior"]
        key = id(table), "inner"
        if key not in self._made:
            self._made[key] = {name: value for name, value in table.items() if name != "ext_ior"}
        return self._made[key]

    def _settled(self, table: Table) -> Table:
        """A material whose normal map has a placement only where it lies otherwise than that of `color`."""
        if "normal_map" not in table:
            return table
        key = id(table), "settled"
        if key not in self._made:
            self._made[key] = _settled(table)
        return self._made[key]

    def _dressed(self, table: Table, plugin: Plugin) -> Table:
        """The material with patterns and pictures as this shape has its u and v; the same where none are.

        Many shapes may refer to it: it is made once for all that have these alike.
        """
        # Mitsuba turns v of an OBJ over, unless it is told otherwise, and of a PLY if told so; clrt of both
        over = plugin.type in ("obj", "ply") and not plugin.flag("flip_tex_coords", plugin.type == "obj")
        over = over or (plugin.type == "rectangle" and "normal_map" in table and not _turned(plugin))
        patterned = any(_is_checker(value) for value in table.values())
        matrix = plugin.to_world()[:3, :3].tobytes() if patterned and plugin.type in _CHECKED else b""
        key = id(table), over, patterned and plugin.type, matrix
        if key not in self._made:
            self._made[key] = self._fitted(table, plugin, over)
        return self._made[key]

    def _fitted(self, table: Table, plugin: Plugin, over: bool) -> Table:
        changed: Table = {}
        bare = plugin.type == "rectangle" and _pictured(table)  # it becomes a mesh
        for key, value in table.items():
            if _is_checker(value):
                changed[key] = self._checker(value, plugin, bare)
            elif over and _is_image(value):
                changed[key] = value | _upside_down(value)
        normals = table.get("normal_map")
        if over and normals is not None and ("placement" in normals or not _is_image(table.get("color"))):
            changed["normal_map"] = normals | {"placement": _upside_down(normals.get("placement", _AS_IT_IS))}
        return table | changed if changed else table

    def _checker(self, checker: Table, plugin: Plugin, bare: bool) -> Any:
        left_out = self.materials.context.left_out
        if plugin.type in _CHECKED and not bare:
            found, lost = checker_of(checker, plugin)
            left_out.update({lost: None} if lost else {})
            return found
        left_out["a checkerboard, but for its mean, where there can be none"] = None
        return mean(checker)


def _pictured(material: Table) -> bool:
    return "normal_map" in material or any(_is_image(value) for value in material.values())


def _is_checker(value: Any) -> bool:
    return isinstance(value, dict) and value.get("type") == "checker"


def _is_image(value: Any) -> bool:
    return isinstance(value, dict) and value.get("type") == "image"


def _settled(table: Table) -> Table:
    normals, color = table["normal_map"], table.get("color", {})
    if normals["placement"] != (placement_of(color) if _is_image(color) else _AS_IT_IS):
        return table
    return table | {"normal_map": {"file": normals["file"]}}


def _upside_down(placement: Table) -> Table:
    """A placement, or an image, as it is where v runs the other way."""
    (across, down), (x, y) = placement["scale"], placement["offset"]
    return placement | {"scale": [across, -down], "offset": [x, down + y]}


def _turned(plugin: Plugin) -> bool:
    """Whether a normal is not that of the corners: a mirrored rectangle's is still (0, 0, 1)."""
    return plugin.flag("flip_normals", False) != bool(np.linalg.det(plugin.to_world()[:3, :3]) < 0)


def green(plugin: Plugin) -> str:
    """What is left out where a normal map's green is another one."""
    return f"the way that green of a normal map leans on a {plugin.type}"


def front(plugin: Plugin) -> str:
    """What is left out where a normal map's front is the back here, from which all of it is turned over."""
    return f"which side of a {plugin.type} is the front of its normal map"


def _green_down(plugin: Plugin) -> bool:
    """Whether green, across normal and u there, leans to where v grows, and not to where it falls as with us.

    A rectangle becomes a mesh whose v is such that both are one way.
    """
    if plugin.type == "sphere":  # a mirrored one keeps its normals
        return plugin.flag("flip_normals", False)
    return _turned(plugin) != (plugin.type in ("cylinder", "disk"))


def _sheet(plugin: Plugin, table: Table) -> Table:
    """The faces and uv of a rectangle that shows pictures.

    Green of a normal map is across u there and up in the picture here: so v is such that both are one way.
    """
    if "normal_map" not in table:
        return {"faces": _HALVES, "uv": _UV}
    if _turned(plugin):
        return {"faces": _HALVES[:, ::-1], "uv": _UV}
    return {"faces": _HALVES, "uv": _UV * (1.0, -1.0) + (0.0, 1.0)}


def _light(plugin: Plugin) -> Table | None:
    """The light with extent that a shape with an emitter is; None of shapes that no light has."""
    matrix = plugin.to_world()
    middle = matrix[:3, 3].tolist()
    sign = -1.0 if plugin.flag("flip_normals", False) else 1.0
    if np.linalg.det(matrix[:3, :3]) < 0:  # a normal is that of (0, 0, 1) there, and not u x v
        sign = -sign
    if plugin.type == "rectangle":
        u, v = matrix[:3, 0], sign * matrix[:3, 1]
        return {"type": "rectangle", "center": middle, "u": u.tolist(), "v": v.tolist()}
    if plugin.type == "disk" and _is_round(matrix):
        return _round(matrix, sign)
    if plugin.type != "sphere" or not is_similarity(matrix) or sign < 0:
        return None
    scale = float(np.linalg.norm(matrix[:3, 0]))
    center = matrix @ np.array([*plugin.vector("center", (0.0, 0.0, 0.0)), 1.0])
    radius = scale * plugin.number("radius", 1.0)
    return {"type": "sphere", "center": center[:3].tolist(), "radius": radius}


def _is_round(matrix: Array) -> bool:
    """Whether a disk across z stays one, whatever becomes of z itself."""
    u, v = matrix[:3, 0], matrix[:3, 1]
    long = float(u @ u)
    return long > 0 and abs(float(v @ v) - long) <= _EQUAL * long and abs(float(u @ v)) <= _EQUAL * long


def _round(matrix: Array, sign: float) -> Table:
    """The disk that a round one becomes; sign: of the side of u x v that is its front."""
    u, v = matrix[:3, 0], matrix[:3, 1]
    radius = float(np.linalg.norm(u))
    normal = sign * np.cross(u, v) / radius**2
    return {"type": "disk", "center": matrix[:3, 3].tolist(), "normal": normal.tolist(), "radius": radius}


def _placed(plugin: Plugin, shape: Table) -> Table:
    matrix = plugin.to_world()
    return shape if _is_unit(matrix) else shape | {"transform": rows(matrix)}


def _is_unit(matrix: Array) -> bool:
    return matrix is UNIT or bool((matrix == UNIT).all())


def _sphere(plugin: Plugin) -> Table:
    center = list(plugin.vector("center", (0.0, 0.0, 0.0)))
    return _placed(plugin, {"type": "sphere", "center": center, "radius": plugin.number("radius", 1.0)})


def _cylinder(plugin: Plugin) -> Table:
    p0, p1 = plugin.vector("p0", (0.0, 0.0, 0.0)), plugin.vector("p1", (0.0, 0.0, 1.0))
    cylinder = {"type": "cylinder", "p0": list(p0), "p1": list(p1), "radius": plugin.number("radius", 1.0)}
    return _placed(plugin, cylinder)


def _rectangle(plugin: Plugin) -> Table:
    matrix = plugin.to_world()
    points = _CORNERS if matrix is UNIT else _CORNERS @ matrix.T
    return {"type": "polygon", "points": points[:, :3].tolist()}


def _disk(plugin: Plugin) -> Table:
    matrix = plugin.to_world()
    disk = {"type": "disk", "center": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0], "radius": 1.0}
    if matrix is UNIT or not _is_round(matrix) or is_similarity(matrix):
        return _placed(plugin, disk)
    even = matrix.copy()  # as long along z, and still turned about it, as pictures are
    even[:3, 2] = np.cross(matrix[:3, 0], matrix[:3, 1]) / np.linalg.norm(matrix[:3, 0])
    even[:3, 2] *= np.sign(np.linalg.det(matrix[:3, :3]))
    return disk | {"transform": rows(even)}


def _cube(plugin: Plugin) -> Table:
    return _placed(plugin, {"type": "box", "min": [-1.0, -1.0, -1.0], "max": [1.0, 1.0, 1.0]})


def _mesh(plugin: Plugin) -> Table:
    return _placed(plugin, {"type": "mesh"})


_MAKE: Final[dict[str, Callable[[Plugin], Table]]] = {
    "sphere": _sphere, "cylinder": _cylinder, "rectangle": _rectangle, "disk": _disk, "cube": _cube,
    "obj": _mesh, "ply": _mesh,
}  # fmt: skip
