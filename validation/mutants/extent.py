"""Deliberate faults in light with extent, filters and gloss: shafts, draws, tints, films, disks, mattes."""

from __future__ import annotations

from typing import Final

from .checks import CHECK
from .kernels import CAMERA, DIFFUSE, EMISSION, GEOMETRY, REFLECTION, Mutant

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
    Mutant("all lights draw the same points", "kernels/draws.clh", "(uintP)(0x80000002u + light)",
           "(uintP)(0x80000002u)", ("disk and sphere",), DIFFUSE),
    Mutant("each point of a sphere as bright as all of them", "kernels/light_sphere.clh",
           "2.0f * cap / (float)light->samples", "2.0f * cap", ("disk and sphere",), DIFFUSE),
    Mutant("a sphere as bright as half of it", "kernels/light_sphere.clh", "2.0f * cap /", "cap /",
           ("disk and sphere",), DIFFUSE),
    Mutant("surfaces of lights stop no feeler", "kernels/walk.clh", "if (SURFACES_OF(world.scene)) offer",
           "if (SURFACES_OF(world.scene) && !any) offer", ("lights seen from all sides",), DIFFUSE),
    Mutant("a light shades itself in a shaft", "kernels/shaft.clh", "if (number == own) continue;", "",
           ("lights that are seen",), DIFFUSE),
    Mutant("surfaces of lights in a shaft stop no feeler", "kernels/shaft.clh",
           "unbounded = world->scene->unbounded, surfaces = SURFACES_OF(world->scene);",
           "unbounded = world->scene->unbounded, surfaces = 0;", ("lights that are seen",), DIFFUSE),
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

_LENS: Final = (
    Mutant("an orthographic lens's rays all through the middle", "kernels/generate.cl",
           "if (camera.orthographic) origin = add(origin, in_view);", "", ("orthographic lens",), GEOMETRY),
    Mutant("an orthographic lens's rays go as from an eye", "kernels/generate.cl",
           "camera.orthographic ? forward : to_pixel", "to_pixel", ("orthographic lens",), GEOMETRY),
    Mutant("a lens draws what gloss draws", "kernels/generate.cl", "(uintP)(0x80000000u)",
           "(uintP)(0x80000001u)", ("lens",), GEOMETRY),
    Mutant("samples on the diagonal of a lens", "kernels/generate.cl",
           "mix_bits(h + 2u) + sample * 0x6A09E667u", "mix_bits(h + 2u) + sample * 0x9E3779B9u",
           ("lens beyond near",)),
    Mutant("weights that cancel by an eighth count alike", "kernels/filter.cl", "whole > 0.25f * sizes",
           "whole > 0.875f * sizes", ("mitchell",)),
    Mutant("weights that cancel count nevertheless", "kernels/filter.cl", "whole > 0.25f * sizes",
           "whole != 0.0f", (CHECK + "alpha",)),
    Mutant("weights whose sum is below 0 count nevertheless", "kernels/filter.cl", "whole > 0.25f * sizes",
           "fabs(whole) > 0.25f * sizes", (CHECK + "alpha",)),
    Mutant("weights that cancel by nine tenths count nevertheless", "kernels/filter.cl",
           "whole > 0.25f * sizes", "whole > 0.1f * sizes", (CHECK + "alpha",)),
)  # fmt: skip

_DISKS: Final = (
    Mutant("a disk of wedges with gaps", "kernels/disk.clh", "0.785398163f *", "0.7f *", ("lens",), GEOMETRY),
    Mutant("facets of which half are hidden", "kernels/gloss.clh", " + part * b;", " + b;",
           ("rough metal",), REFLECTION),
    Mutant("gloss draws what a lens draws", "kernels/gloss.clh", "(uintP)(0x80000001u)",
           "(uintP)(0x80000000u)", ("rough metal",), REFLECTION),
    Mutant("samples of gloss on the diagonal", "kernels/gloss.clh",
           "mix_bits(h + 2u) + streams.sample * 0x91E10DA5u",
           "mix_bits(h + 2u) + streams.sample * 0xC13FA9A9u", ("rough metal, 4 samples",), REFLECTION),
    Mutant("one facet for all samples of a pixel", "kernels/gloss.clh",
           "mix_bits(h + 1u) + streams.sample * 0xC13FA9A9u",
           "mix_bits(h + 1u)", ("rough metal, 4 samples",), REFLECTION),
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
        ("parts of what is hit, not of the pixel", "_whole(part / total[start + pixel], pixel)",
         "part / np.bincount(pixel, part)[pixel]"),
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
        ("each point of a rectangle as bright as all of them", "flatten/materials.py",
         "= source.u, source.v\n    record[\"share\"] = source.area / (math.pi * source.samples)",
         "= source.u, source.v\n    record[\"share\"] = source.area / math.pi", ("rectangle",), DIFFUSE),
        ("a disk as bright as half of it", "flatten/materials.py",
         "sign + y * y * a, -y])\n    record[\"share\"] = source.area",
         "sign + y * y * a, -y])\n    record[\"share\"] = 0.5 * source.area", ("disk and sphere",), DIFFUSE),
        ("each point of a disk as bright as all of them", "flatten/materials.py",
         "sign + y * y * a, -y])\n    record[\"share\"] = source.area / (math.pi * source.samples)",
         "sign + y * y * a, -y])\n    record[\"share\"] = source.area / math.pi", ("disk and sphere",),
         DIFFUSE),
        ("a spot that aims a little beside", "flatten/materials.py",
         "_unit(np.subtract(source.target, source.position))",
         "_unit(np.subtract(source.target, np.multiply(source.position, (1.05, 1.0, 1.0))))", ("spots",),
         DIFFUSE),
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
        ("a rectangle seen half as long", "flatten/lightsurfaces.py", '= 1.0, 1.0, np.inf',
         '= 0.5, 1.0, np.inf', ("lights that are seen", "lights seen from all sides"), ""),
        ("what a light sends, shown 2 % fainter", "flatten/materials.py",
         'record["emission"] = light(source.radiance, self._bands)',
         'record["emission"] = 0.98 * light(source.radiance, self._bands)', ("lights that are seen",),
         EMISSION),
        ("an oblique rectangle seen upright", "flatten/lightsurfaces.py", "np.array(cross(other, n))", "side",
         ("lights that are seen", "lights seen from all sides"), ""),
        ("a lens in focus behind its target", "scene/camera.py", "return min(max(math.dist(",
         "return min(max(1.05 * math.dist(", ("lens beyond near",), GEOMETRY),
        ("alpha of samples that count alike", "engine/job.py", 'counts = None if weights is None else',
         'counts = None if weights is None or weights else', (CHECK + "alpha",), ""),
        ("alpha of weights that cancel by an eighth, all counted alike", "engine/coverage.py",
         "> 0.25 * np.abs(weights)", "> 0.875 * np.abs(weights)", (CHECK + "alpha",), ""),
        ("alpha of weights that cancel", "engine/coverage.py", "some = weights.sum(axis=1) > 0.25 *",
         "some = weights.sum(axis=1) > -9.0 *", (CHECK + "alpha",), ""),
        ("alpha beyond 1", "engine/coverage.py", "np.clip(share, 0.0, 1.0)", "np.clip(share, -9.0, 9.0)",
         (CHECK + "alpha",), ""),
    )
)  # fmt: skip

EXTENT_FAULTS: Final = (*_SHAFTS, *_LIGHT, *_LENS, *_DISKS, *_COVERAGE, *_GIVEN)
