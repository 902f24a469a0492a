"""Deliberate faults in light with extent, filters and gloss: shafts, draws, tints, films, disks, mattes."""

from __future__ import annotations

from typing import Final

from .checks import CHECK
from .kernels import CAMERA, DIFFUSE, GEOMETRY, REFLECTION, Mutant

_SHAFTS: Final = (
    Mutant("a shaft to a light's middle only", "kernels/light.cl",
           "shaft_between(start, which, light->place.xyz, size, &shaft)",
           "shaft_between(start, which, light->place.xyz, size * 0.0f, &shaft)",
           ("disk and sphere", "rectangle"), DIFFUSE),
    Mutant("a shaft's planes taken from the other side", "kernels/boxes.clh", "> 0.0f == k < 3)",
           "> 0.0f == k >= 3)", ("rectangle",), DIFFUSE),
    Mutant("a shaft that begins half way", "kernels/boxes.clh",
           "REAL from = (REAL)(0.0f), to = (REAL)(1.0f);", "REAL from = (REAL)(0.5f), to = (REAL)(1.0f);",
           ("rectangle",), DIFFUSE),
    Mutant("what stands in a shaft stops nothing", "kernels/shaft.clh",
           "else seen[place[lane]] = primitive[lane] < 0;", "else seen[place[lane]] = 1;",
           ("rectangle",), DIFFUSE),
    Mutant("what stands in a shaft stops no tinted feeler", "kernels/shaft.clh", "seen[place[lane]] = 0;",
           "seen[place[lane]] = CLEAR;", ("what stands before a rectangle, tinted",), DIFFUSE),
    Mutant("one of those that stand in a shaft forgotten", "kernels/shaft.clh",
           "i < unbounded + surfaces + count; i++", "i < unbounded + surfaces + count - 1; i++",
           ("rectangle",), DIFFUSE),
    Mutant("polygons in a shaft are met too late", "kernels/shaft.clh", "& ~(t > ray->t_max);",
           "& (t > ray->t_max);", ("what stands before a rectangle",), DIFFUSE),
    Mutant("only rays of one way asked of what stands", "kernels/shaft.clh", "left &= ~lanes_of(members);",
           "left = 0;", ("what stands before a rectangle",), DIFFUSE),
    Mutant("spheres in a shaft stop no feeler", "kernels/shaft.clh", "if (p.kind == SPHERE) {",
           "if (p.kind == SPHERE) { continue;", ("rectangle", "disk and sphere"), DIFFUSE),
)  # fmt: skip

_LIGHT: Final = (
    Mutant("a light's points on a line", "kernels/draws.clh", "draw.y += 0x91E10DA5u;", "",
           ("rectangle",), DIFFUSE),
    Mutant("a spot's penumbra outside of its cone", "kernels/light_spot.clh", "(light->angle - theta) /",
           "(light->angle + light->width - theta) /", ("spots",), DIFFUSE),
    Mutant("panes take off their tint alone", "kernels/tinted.clh",
           "material->kt * material->tint[band_at(band, b)]", "material->tint[band_at(band, b)]",
           ("tinted shadows",), DIFFUSE),
    Mutant("a film that ends at half of white", "kernels/film.cl", "mean <= BRIGHTEST ? mean : BRIGHTEST",
           "mean <= 0.5f ? mean : 0.5f", ("diffuse",)),
    Mutant("a film that holds what is infinite", "kernels/film.cl", "mean <= BRIGHTEST ? mean : BRIGHTEST",
           "mean", (CHECK + "overflow",)),
    Mutant("the second band lost in developing", "kernels/film.cl", "for (int b = 1; b < BANDS; b++) sum",
           "for (int b = 2; b < BANDS; b++) sum", ("patches",), CAMERA),
)  # fmt: skip

_DISKS: Final = (
    Mutant("a disk of wedges with gaps", "kernels/disk.clh", "0.785398163f *", "0.7f *", ("lens",), GEOMETRY),
    Mutant("facets of which half are hidden", "kernels/gloss.clh", " + part * b;", " + b;",
           ("rough metal",), REFLECTION),
    Mutant("facets seen as by a smooth surface", "kernels/gloss.clh",
           "unit3(vec(alpha * v.x, alpha * v.y, v.z))", "v", ("rough metal",), REFLECTION),
    Mutant("G1 of the roughness, not of its square", "kernels/gloss.clh", "alpha * alpha * slope",
           "alpha * slope", ("rough metal",), REFLECTION),
    Mutant("G1 of the ray that comes, not of the one that goes", "kernels/gloss.clh",
           "(r.x * r.x + r.y * r.y) / (r.z * r.z)", "(v.x * v.x + v.y * v.y) / (v.z * v.z)",
           ("rough metal",), REFLECTION),
)  # fmt: skip

_COVERAGE: Final = tuple(
    Mutant(name, "clrt/engine/coverage.py", old, new, (CHECK + "mattes",))
    for name, old, new in (
        ("the smallest part of a pixel first", "np.lexsort((name, -part, pixel))",
         "np.lexsort((name, part, pixel))"),
        ("parts of what is hit, not of the pixel", "part = part / total[start + pixel]",
         "part = part / np.bincount(pixel, part)[pixel]"),
        ("one name for all parts of pixels", "names[name[kept]]", "names[0 * name[kept]]"),
        ("the quarters of a pixel lost", "(rank < RANKS) & (part > 0)", "(rank < RANKS) & (part > 0.25)"),
    )
)

# what kernels are given of lights, lens and filters, and what becomes of their weights
_GIVEN: Final = tuple(
    Mutant(name, f"clrt/{file}", old, new, cases, where)
    for name, file, old, new, cases, where in (
        ("a rectangle as bright as half of it", "flatten/materials.py",
         "= source.u, source.v\n    record[\"share\"] = source.area",
         "= source.u, source.v\n    record[\"share\"] = 0.5 * source.area", ("rectangle",), DIFFUSE),
        ("a disk of light that is an ellipse", "flatten/materials.py",
         '= source.radius * np.array([x * y * a,', '= 0.6 * source.radius * np.array([x * y * a,',
         ("disk and sphere",), DIFFUSE),
        ("spheres of light 5 % too small", "flatten/materials.py", 'record["radius"] = source.radius',
         'record["radius"] = 0.95 * source.radius', ("disk and sphere",), DIFFUSE),
        ("every light with extent shines one way", "flatten/materials.py",
         'record["two_sided"] = source.two_sided', 'record["two_sided"] = False',
         ("lights seen from all sides",), ""),
        ("a penumbra of the angle's rest", "flatten/materials.py", "source.angle * source.penumbra",
         "source.angle * (1 - source.penumbra)", ("spots",), DIFFUSE),
        ("lights are seen though not visible", "flatten/lightsurfaces.py", " and light.visible", "",
         ("rectangle", "disk and sphere"), ""),
        ("a rectangle seen half as long", "flatten/lightsurfaces.py", '[:3] = 1.0, 1.0, np.inf',
         '[:3] = 0.5, 1.0, np.inf', ("lights that are seen", "lights seen from all sides"), ""),
        ("an oblique rectangle seen upright", "flatten/lightsurfaces.py", "np.cross(other, n)", "side",
         ("lights that are seen", "lights seen from all sides"), ""),
        ("a lens in focus behind its target", "scene/camera.py", "return min(max(math.dist(",
         "return min(max(1.05 * math.dist(", ("lens beyond near",), GEOMETRY),
        ("alpha of samples that count alike", "engine/job.py", 'counts = None if weights is None else',
         'counts = None if weights is None or weights else', (CHECK + "alpha",), ""),
        ("alpha beyond 1", "engine/coverage.py", "np.clip(share, 0.0, 1.0)", "np.clip(share, -9.0, 9.0)",
         (CHECK + "alpha",), ""),
    )
)  # fmt: skip

EXTENT_FAULTS: Final = (*_SHAFTS, *_LIGHT, *_DISKS, *_COVERAGE, *_GIVEN)
