"""Why a picture differs from its scene: the scene is misread, as an author might have, and rendered again.

Light adds up: a picture with less of one light, of the ambient light or of the highlights is a mixture of the
picture with and without it. So for these the share that is present is fitted, and 0 means missing. All else
(depth, indices, camera, objects) is rendered with the change and compared.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from msgspec.structs import replace

from clrt.base.errors import ClrtError, ClrtWarning
from clrt.scene.scene import Material, Scene, edited

from .causes import EXACT, NOTHING, Budget, Cause, disagreement, ranked, remaining, told
from .metrics import Array

_OfMaterial = Callable[[Material], dict[str, Any]]
Render = Callable[..., Array]  # (scene, shadows=True, layer="") -> linear picture, the pixels to compare
_MOST_SHAPES = 24  # that are left out one by one
_MOST_LIGHTS = 8
_LIGHTS = "all lights"
_SAME, _NONE = 0.02, 0.03  # a share nearer to 1 is all of it, nearer to 0 nothing


@dataclass(frozen=True)
class _Component:
    """Something that adds light, or takes it away, in proportion."""

    name: str
    absent: Callable[[], Array]  # the picture without it
    independent: bool = True  # False: a sum of others
    lost: str = ""  # what to say where nothing of it is there


@dataclass(frozen=True)
class _Change:
    """A scene as someone might have misread it."""

    name: str
    text: str
    picture: Callable[[], Array]


def explain_by_scene(
    picture: Array,
    scene: Scene,
    reference: Array,
    render: Render,
    tolerance: float,
    report: Callable[[str], None] | None = None,
    budget: Budget | None = None,
    known: bool = False,
) -> list[Cause]:
    """Causes for the difference of a picture and `reference`, which `render(scene)` gave, the best first.

    Pictures are (h, w, 3), or (n, 3) of the same n pixels. Stops where one explains all, or when `budget` is
    spent. `report` gets the name of each cause before it is tried. known: another cause explains all, so
    that only shares are fitted.
    """
    before = disagreement(picture, reference, tolerance)
    if before == 0:
        return []
    say, budget = report or (lambda name: None), budget or Budget(math.inf)
    causes: list[Cause] = []
    parts: dict[str, Array] = {}  # of what is independent: several may be wrong at once
    lights: dict[str, Array] = {}  # all of them as one
    for component in _components(scene, reference, render):
        if budget.over():
            break
        say(component.name)
        part = reference - _quietly(component.absent, reference)
        if np.abs(part).max(initial=0.0) < 1e-6:
            continue
        if component.independent:
            parts[component.name] = part
        elif component.name == _LIGHTS:
            lights[component.name] = part
        cause = _mixed(picture, reference, [component.name], [part], before, tolerance)
        if component.lost and cause.name.endswith(" missing"):
            cause = dataclasses.replace(cause, text=component.lost)
        causes.append(cause)
        if cause.left <= EXACT:
            break
    causes = [cause for cause in causes if cause.name]
    proven = any(cause.proven for cause in causes)
    if not any(cause.left <= EXACT for cause in causes):
        others = {name: part for name, part in parts.items() if not name.startswith("light ")}
        for mixture in ({**lights, **others}, parts) if lights else (parts,):
            cause = _mixed(picture, reference, list(mixture), list(mixture.values()), before, tolerance)
            bare = {name: part for name, part in mixture.items() if name != "highlights"}
            if "highlights" in mixture and "highlights missing" not in cause.name and bare:
                # without lights there are none: their factor is then of what rounding left
                plain = _mixed(picture, reference, list(bare), list(bare.values()), before, tolerance)
                cause = plain if plain.left <= max(EXACT, cause.left) else cause
            causes += [cause] if cause.name else []
    # several parts may feign what one change does, so that a mixture has to be better
    changes = _falloffs(scene, reference, render)
    if not (known or any(cause.left <= NOTHING for cause in causes)):
        for change in changes if proven else itertools.chain(changes, _changes(scene, render)):
            if budget.over():
                break
            say(change.name)
            changed = _quietly(change.picture, reference)
            causes.append(Cause(change.name, change.text, remaining(picture, changed, before, tolerance)))
            if causes[-1].left <= NOTHING:
                break
    return ranked([cause for cause in causes if cause.likely])


def _quietly(render: Callable[[], Array], otherwise: Array) -> Array:
    """A rendering without warnings; `otherwise` where the changed scene cannot be rendered."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ClrtWarning)
        try:
            return render()
        except ClrtError:
            return otherwise


def _mixed(
    picture: Array,
    reference: Array,
    names: Sequence[str],
    parts: Sequence[Array],
    before: float,
    tolerance: float,
) -> Cause:
    """How much of each part the picture has, at least nothing: least squares where nothing is clipped."""
    from scipy.optimize import lsq_linear

    open_ = (picture < 0.95) & (reference < 0.95)
    mixed, shares = reference.astype(np.float64), np.ones(len(parts))
    if parts and open_.any():
        matrix = np.stack([part[open_] for part in parts], axis=1).astype(np.float64)
        lacking = (reference.astype(np.float64) - picture)[open_]
        lost = np.linalg.lstsq(matrix, lacking, rcond=1e-6)[0]
        if (lost > 1).any():  # less than nothing is left: there is no light below 0
            orthogonal, triangular = np.linalg.qr(matrix)
            right = orthogonal.T @ lacking
            lost = lsq_linear(triangular, right, bounds=(-np.inf, 1.0), method="bvls").x
        shares = 1 - lost
        shares[np.abs(shares - 1) < _SAME] = 1
        for share, part in zip(shares, parts, strict=True):
            mixed = mixed - (1 - share) * part
    said, texts = [], []
    for name, share in zip(names, shares, strict=True):
        if abs(share) < _NONE:
            said.append(f"{name} missing")
            texts.append(f"there is nothing of {name}")
        elif share != 1:
            many = name.endswith("s") or name.startswith("the lights")
            are, they = ("are", "they") if many else ("is", "it")
            said.append(f"{name} times {told(share)}")
            texts.append(f"{name} {are} {share:.3g} times as strong as {they} should be")
    left = remaining(picture, mixed, before, tolerance)
    return Cause(" and ".join(said), "; ".join(texts), left, numbers=len(said))


def _components(scene: Scene, reference: Array, render: Render) -> Iterator[_Component]:
    def without(**changes: Any) -> Callable[[], Array]:
        return lambda: render(replace(scene, **changes))

    def plain(change: _OfMaterial) -> Callable[[], Array]:
        return lambda: render(_with_materials(scene, change))

    def no_shadow_of(light: Any) -> Array:
        alone = replace(scene, lights=(light,))
        return reference + render(alone, shadows=False) - render(alone)

    lights = scene.lights[:_MOST_LIGHTS]
    for index, light in enumerate(lights):
        name = f"light {index + 1} of {len(scene.lights)} ({_place(light)})"
        yield _Component(name, without(lights=(*scene.lights[:index], *scene.lights[index + 1 :])))
    if len(lights) > 1:
        lost = "no light reaches anything but what is ambient"
        yield _Component(_LIGHTS, without(lights=()), independent=False, lost=lost)
    if lights and scene.shadow == "opaque":
        yield _Component("shadows", lambda: render(scene, shadows=False), independent=len(lights) == 1)
        for index, light in enumerate(lights if len(lights) > 1 else ()):
            yield _Component(f"shadow of light {index + 1}", partial(no_shadow_of, light))
    materials = [scene.material_of(shape) for shape in scene.shapes]
    there = {  # what a scene has not, cannot be missing
        "ambient light": (scene.ambient != 0, without(ambient=0.0)),
        "background": (scene.background != 0, without(background=0.0)),
        "highlights": (any(m.specular for m in materials), plain(lambda m: {"specular": 0.0})),
        "emission": (any(m.emission != 0 for m in materials), plain(lambda m: {"emission": 0.0})),
    }
    yield from (_Component(name, absent) for name, (has, absent) in there.items() if has)
    kinds = {shape.type for shape in scene.shapes}
    for kind in sorted(kinds) if len(kinds) > 1 else ():
        absent = partial(_unlit, scene, kind, render)
        lost = f"no light reaches any {kind}: its normals point the wrong way, or it shadows itself"
        yield _Component(f"the lights on every {kind}", absent, independent=False, lost=lost)
    yield _Component("diffuse light", plain(lambda m: {"diffuse": 0.0, "ambient": m.ka}), independent=False)


def _unlit(scene: Scene, kind: str, render: Render) -> Array:
    """The picture where lights do not light the shapes of a kind: they shadow themselves, or face away."""
    dark = {"diffuse": 0.0, "specular": 0.0}
    shapes = tuple(
        replace(shape, material=replace(m, ambient=m.ka, **dark)) if shape.type == kind else shape
        for shape, m in ((shape, scene.material_of(shape)) for shape in scene.shapes)
    )
    return render(replace(scene, shapes=shapes))


def _place(light: Any) -> str:
    *place, near = light.place
    vector = ", ".join(f"{value:g}" for value in (place if near else light.direction))
    return f"point at {vector}" if near else f"direction {vector}"


def _falloffs(scene: Scene, reference: Array, render: Render) -> Iterator[_Change]:
    """Other powers of the distance, seen from the first hits: what a mirror shows is left as it is."""
    points = [light for light in scene.lights[:_MOST_LIGHTS] if "falloff" in light.__struct_fields__]
    squared = [light for light in points if light.falloff == "inverse-square"]

    def powered(power: float) -> Array:
        position = render(scene, layer="position").astype(np.float64)
        changed = reference.astype(np.float64)
        for light in squared:
            rest = tuple(other for other in scene.lights if other is not light)
            distance = np.linalg.norm(position - light.place[:3], axis=-1, keepdims=True)
            part = reference - render(replace(scene, lights=rest))
            changed = changed + part * (distance ** (2 - power) - 1)
        return changed

    if squared:
        text = "point lights fade with {} in place of its square"
        for power, name in ((1.0, "the distance"), (4.0, "the fourth power of the distance")):
            yield _Change(f"falloff by {name}", text.format(name), partial(powered, power))
    if points:
        other = {"none": "inverse-square", "inverse-square": "none"}

        def faded() -> Array:
            return render(replace(scene, lights=tuple(
                replace(light, falloff=other[light.falloff]) if light in points else light
                for light in scene.lights
            )))  # fmt: skip

        text = "point lights fade with the distance, or do not"
        yield _Change("falloff of lights", text, faded)


def _changes(scene: Scene, render: Render) -> Iterator[_Change]:
    """Changed scenes are made where they are rendered: one that cannot be is no cause."""

    def change(name: str, text: str, changed: Callable[[], Scene]) -> _Change:
        return _Change(name, text, lambda: render(changed()))

    def other(name: str, text: str, **changes: Any) -> _Change:
        return change(name, text, lambda: replace(scene, **changes))

    yield from _of_camera(scene, change)
    for depth in range(scene.max_depth + 3):
        if depth != scene.max_depth:
            text = f"rays are followed for {depth} generations in place of {scene.max_depth}"
            yield other(f"max_depth {depth}", text, max_depth=depth)
    for name, text, of_material in _OF_MATERIALS:
        yield change(name, text, partial(_with_materials, scene, of_material))
    if scene.depth_color != 0:
        yield other("depth colour missing", "depth_color is not used", depth_color=0.0)
    if scene.min_weight > 0:
        yield other("weak rays kept", "min_weight is not used", min_weight=0.0)
    shadow = {"opaque": "tinted", "tinted": "opaque"}[scene.shadow]
    text = f"shadows are {shadow}, not {scene.shadow}"
    yield other(f"{shadow} shadows", text, shadow=shadow)
    for index, shape in enumerate(scene.shapes[:_MOST_SHAPES]):
        name = f"shape {index} ({shape.name or shape.type})"
        rest = (*scene.shapes[:index], *scene.shapes[index + 1 :])
        yield other(f"{name} missing", f"{name} is not in the picture", shapes=rest)


def _of_camera(
    scene: Scene, change: Callable[[str, str, Callable[[], Scene]], _Change]
) -> Iterator[_Change]:
    camera = scene.camera
    assert camera is not None

    def seen(name: str, text: str, **changes: Any) -> _Change:
        return change(name, text, partial(edited, scene, {f"camera.{key}": changes[key] for key in changes}))

    def angle(name: str, text: str, **changes: Any) -> _Change:
        """`changes` take the place of K, whose other numbers stay."""
        shift = camera.offset(camera.width, camera.height)
        return seen(name, text, **{"fov": camera.fov, "shift": shift} | changes)

    half = (-0.5, 0.0, 0.5)
    for x, y in ((x, y) for x in half for y in half if x or y):
        ways = ((x, ("left", "right")), (y, ("up", "down")))
        words = [f"{abs(value):g} pixel {way[value < 0]}" for value, way in ways if value]
        shift = camera.shift[0] + x, camera.shift[1] + y
        text = "samples are taken at the pixels' corners or borders, not at their centres"
        yield seen(f"shift by {' and '.join(words)}", text, shift=shift)
    axis = {"horizontal": "vertical", "vertical": "horizontal"}[camera.fov_axis]
    yield angle("fov axis", f"the field of view is the {axis} one, not the {camera.fov_axis}", fov_axis=axis)
    if camera.fov < 90:
        yield angle(
            "fov doubled",
            f"the field of view is {2 * camera.fov:g} degrees, not {camera.fov:g}",
            fov=2 * camera.fov,
        )
    yield angle(
        "fov halved",
        f"the field of view is {camera.fov / 2:g} degrees, not {camera.fov:g}",
        fov=camera.fov / 2,
    )
    for spp in (4, 16) if camera.spp == 1 else (1,):
        text = f"{spp} samples a pixel in place of {camera.spp}"
        even = {"camera.spp": spp, "adaptive": None}
        yield change(f"{spp} samples a pixel", text, partial(edited, scene, even))


_OF_MATERIALS: tuple[tuple[str, str, _OfMaterial], ...] = (
    ("reflections missing", "nothing is reflected", lambda m: {"reflection": 0.0}),
    ("transmission missing", "nothing is transmitted", lambda m: {"transmission": 0.0}),
    ("no refraction", "light goes straight through, as if ior were 1", lambda m: {"ior": 1.0}),
    ("ior inverted", "the indices of both sides are swapped", lambda m: {"ior": 1 / m.ior_d}),
    ("mirrors without tint", "reflection_color is not used", lambda m: {"reflection_color": 1.0}),
    ("transmission without tint", "transmission_color is not used", lambda m: {"transmission_color": 1.0}),
    ("highlights without tint", "highlight_color is not used", lambda m: {"highlight_color": 1.0}),
    ("thin sheets as bodies", "what is thin bends light", lambda m: {"thin": False}),
    (
        "Fresnel",
        "reflection by Fresnel's equations where the scene has constants, or the reverse",
        lambda m: {"fresnel": not m.fresnel, "reflection": m.kr, "transmission": m.kt},
    ),
    ("shininess 2 times", "highlights are too small", lambda m: {"shininess": 2 * m.shininess}),
    (
        "shininess 4 times",
        "highlights are too small: Blinn's half vector needs 4 times Phong's exponent",
        lambda m: {"shininess": 4 * m.shininess},
    ),
    ("shininess halved", "highlights are too large", lambda m: {"shininess": m.shininess / 2}),
    (
        "shininess a quarter",
        "highlights are too large: Phong's exponent with Blinn's half vector",
        lambda m: {"shininess": m.shininess / 4},
    ),
)


def _with_materials(scene: Scene, change: _OfMaterial) -> Scene:
    """The scene with the changes to every material that `change` gives for it."""
    shapes = []
    for shape in scene.shapes:
        material = scene.material_of(shape)
        shapes.append(replace(shape, material=replace(material, **change(material))))
    return replace(scene, shapes=tuple(shapes))
