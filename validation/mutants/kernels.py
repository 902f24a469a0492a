"""Deliberate faults in kernels of camera, layers and light, one or more a term; validation must notice each.

Each replaces a text that stands exactly once in its file. `cases` are the smallest that cover the term, the
best first; `where` is what the comparison is to blame, so that whoever breaks a line is told what broke.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from clrt.base.errors import ClrtError


@dataclass(frozen=True)
class Mutant:
    """A fault: `old` becomes `new` in `file`, which is below kernels/ or clrt/."""

    name: str
    file: str
    old: str
    new: str
    cases: tuple[str, ...]
    where: str = ""  # "": it shows in several places, and which is worst says little

    def edit(self, text: str) -> str:
        """The file's text with the fault; ClrtError unless what it replaces stands there once."""
        if text.count(self.old) != 1:
            raise ClrtError(f"{self.file}: {self.name!r} must replace a text that stands there once, "
                            f"and it does {text.count(self.old)} times: {self.old}")  # fmt: skip
        return text.replace(self.old, self.new)


CAMERA, GEOMETRY = "generation 0, camera", "generation 0, camera, geometry"
AMBIENT, EMISSION, DIFFUSE, HIGHLIGHT = (f"{CAMERA}, {term}" for term in ("ambient", "emission", "diffuse",
                                                                          "highlight"))
REFLECTION, TRANSMISSION, GATHERED = (f"generation 1, {kind}" for kind in ("reflection", "transmission",
                                                                           "ambient"))
TRANSMISSION_2 = "generation 2, transmission"

_GENERATE: Final = (
    Mutant("half a pixel to the left", "kernels/filter.clh", "floatP sub_x = (floatP)(0.5f)",
           "floatP sub_x = (floatP)(0.0f)",
           ("diffuse",), GEOMETRY),
    Mutant("a tenth of a pixel down", "kernels/filter.clh", "sub_y = (floatP)(0.5f);",
           "sub_y = (floatP)(0.6f);", ("diffuse",),
           GEOMETRY),
    Mutant("upside down", "kernels/generate.cl", "(1.0f - 2.0f * y / (float)camera.height)",
           "(2.0f * y / (float)camera.height - 1.0f)", ("diffuse",), GEOMETRY),
    Mutant("near counts along the ray", "kernels/generate.cl",
           "camera.near / dot3(direction, forward)",
           "(floatP)(camera.near)", ("near",), GEOMETRY),
    Mutant("orthographic rays ignore near", "kernels/generate.cl",
           "add(add(origin, in_view), times(forward, (floatP)(camera.near)))",
           "add(origin, in_view)",
           ("orthographic, vertical",), GEOMETRY),
    Mutant("shift across is lost", "kernels/generate.cl", "+ camera.shift_x + ", "+ ", ("shifted camera",),
           GEOMETRY),
    Mutant("both jitters are one", "kernels/filter.clh", "mix_bits(key + 2u)", "mix_bits(key + 1u)",
           ("jittered",),
           GEOMETRY),
    Mutant("samples on the diagonal only", "kernels/filter.clh", "convert_floatP(row)",
           "convert_floatP(column)",
           ("4 samples",), DIFFUSE),
    Mutant("a tent of more than a pixel", "kernels/filter.clh", "1.0f - a)", "1.1f - a)", ("tent",)),
    Mutant("a Gaussian too narrow", "kernels/filter.clh", "exponential(-2.0f", "exponential(-2.3f",
           ("gaussian",)),
    Mutant("Mitchell's filter too high in the middle", "kernels/filter.clh", "5.33333333f", "5.6f",
           ("mitchell",)),
    Mutant("Mitchell's filter without its lobes", "kernels/filter.clh", "+ 10.6666667f) / 6.0f",
           "+ 10.6666667f) / 60.0f", ("mitchell",)),
    Mutant("a filter that does not reach out of its pixel", "kernels/filter.clh", "camera.reach *", "0.5f *",
           ("tent",)),
    Mutant("a filter across only", "kernels/filter.cl", "filter_weight(camera, off_middle(camera, y))",
           "filter_weight(camera, off_middle(camera, x))", ("gaussian",)),
    Mutant("weights that do not count", "kernels/filter.cl", "sum += weight[s] * one", "sum += one",
           ("tent",)),
    Mutant("a lens 2 % too wide", "kernels/generate.cl", "(floatP)(camera.aperture)",
           "(floatP)(1.02f * camera.aperture)", ("lens",), GEOMETRY),
    Mutant("out of focus by 1 %", "kernels/generate.cl", "(1.0f / camera.focus)",
           "(0.99f / camera.focus)", ("lens",), GEOMETRY),
    Mutant("a lens that all samples cross at one point", "kernels/generate.cl",
           "mix_bits(h + 1u) + sample * 0x9E3779B9u", "mix_bits(h + 1u)", ("lens beyond near",)),
    Mutant("a lens beyond which near counts along the ray", "kernels/generate.cl", "camera.near / ahead",
           "(floatP)(camera.near)", ("lens beyond near",), GEOMETRY),
    Mutant("a disk that is a square", "kernels/disk.clh", "along = radius * cosine", "along = radius",
           ("lens",), GEOMETRY),
    Mutant("a mean of one sample too many", "kernels/film.cl", "= film[i] / samples;",
           "= film[i] / (samples + 0.001f);",
           ("4 samples",), CAMERA),
)  # fmt: skip

_LAYERS: Final = (
    Mutant("z along the ray", "kernels/film.cl", "out_z[i] = hit ? along", "out_z[i] = hit ? hit_t[number]",
           ("diffuse",), "layer z"),
    Mutant("distance from near on", "kernels/film.cl", "out_distance[i] = hit ? away",
           "out_distance[i] = hit ? hit_t[number]", ("near",), "layer distance"),
    Mutant("orthographic distance from a point", "kernels/film.cl", "camera.orthographic ? along : sqrt",
           "sqrt", ("orthographic",), "layer distance"),
    Mutant("the shading normal of a flat surface", "kernels/film.cl", "SHADING_X, SURFACE_FIELDS)",
           "NORMAL_X, SURFACE_FIELDS)", ("opaque mesh with normals",), "layer shading_normal"),
    Mutant("albedo without its coefficient", "kernels/film.cl", "of->kd * color", "color", ("diffuse",),
           "layer albedo"),
    Mutant("albedo of one checker colour", "kernels/film.cl", "second ? of->color2[b] : of->color[b]",
           "of->color[b]", ("checkered disk",), "layer albedo"),
    Mutant("all of the first material", "kernels/film.cl", "out_material[i] = hit ? material",
           "out_material[i] = hit ? 0", ("diffuse",), "layer material"),
)  # fmt: skip

_LIGHT: Final = (
    Mutant("light from behind the true surface", "kernels/light.clh", "(dot3(s.n, to.direction) > 0.0f) & ",
           "",
           ("light behind, tinted",), DIFFUSE),
    Mutant("light from behind the shaded surface", "kernels/light.clh",
           " & (dot3(s.ns, to.direction) > 0.0f)", "",
           ("light behind",), DIFFUSE),
    Mutant("falloff by the distance, not its square", "kernels/light_point.clh",
           "1.0f / (distance * distance)",
           "1.0f / distance", ("inverse square",), DIFFUSE),
    Mutant("a spot ends a tenth too far out", "kernels/light_spot.clh", "(light->angle - theta) /",
           "(light->angle * 1.1f - theta) /", ("spots",), DIFFUSE),
    Mutant("a spot's light fades with the square", "kernels/light_spot.clh",
           "smaller(larger(share, (floatP)(0.0f)), (floatP)(1.0f))",
           "smaller(larger(share * share, (floatP)(0.0f)), (floatP)(1.0f))", ("spots",), DIFFUSE),
    Mutant("a spot brighter than its light", "kernels/light_spot.clh",
           "smaller(larger(share, (floatP)(0.0f)), (floatP)(1.0f))", "larger(share, (floatP)(0.0f))",
           ("spots",), DIFFUSE),
    Mutant("a spot shines outside of its cone", "kernels/light_spot.clh",
           "sample.factor *= smaller(larger(share, (floatP)(0.0f)), (floatP)(1.0f));\n"
           "    sample.direction = choose(same(vec(0.0f, 0.0f, 0.0f)), sample.direction, share > 0.0f);",
           "sample.factor *= larger((floatP)(0.2f), smaller(larger(share, (floatP)(0.0f)), (floatP)(1.0f)));",
           ("spots",), DIFFUSE),
    Mutant("lights with extent without their cosine", "kernels/light.clh",
           "light->share * cosine / (distance * distance)", "light->share / (distance * distance)",
           ("rectangle",), DIFFUSE),
    Mutant("panels shine on both sides", "kernels/light.clh", "if (light->two_sided) cosine", "cosine",
           ("lights seen from all sides",), DIFFUSE),
    Mutant("a rectangle's points in its middle", "kernels/light_rectangle.clh",
           "times(same(light->u), 2.0f * unit_interval(draw.x) - 1.0f)",
           "times(same(light->u), unit_interval(draw.x) - 0.5f)", ("rectangle",), DIFFUSE),
    Mutant("a disk's points in its middle", "kernels/light_disk.clh", "times(same(light->u), x)",
           "times(same(light->u), x * 0.7f)", ("disk and sphere",), DIFFUSE),
    Mutant("a sphere seen as from afar", "kernels/light_sphere.clh",
           "ratio * ratio / (1.0f + sqrt(power) / d)", "0.5f * ratio * ratio", ("disk and sphere",), DIFFUSE),
    Mutant("a sphere's points on its far side", "kernels/light_sphere.clh",
           "select(along + sqrt(along * along - power), power / (along + radius * chord), outside)",
           "along + sqrt(along * along - power)", ("disk and sphere",), DIFFUSE),
    Mutant("a sphere is dark within", "kernels/light_sphere.clh", "light->two_sided ? (intP)(-1) : outside",
           "outside", ("within a sphere of light",), DIFFUSE),
    Mutant("all points of a light are one", "kernels/draws.clh", "draw.x += 0xC13FA9A9u;", "",
           ("rectangle",), DIFFUSE),
    Mutant("all samples of a pixel see the same points", "kernels/draws.clh",
           "place = streams.sample * points", "place = streams.sample * 0u",
           ("lights with extent in mirrors",), DIFFUSE),
    Mutant("deeper rays see the same points", "kernels/draws.clh",
           "as_uintP(load_word(path, first, n) & ~PATH_FLAGS)", "(uintP)(7u)",
           ("lights with extent in mirrors",), REFLECTION),
    Mutant("ambient rays of a hit see the same points", "kernels/ambient.cl", "combine(key, k) & ~(uint)",
           "key & ~(uint)", ("lights with extent and ambient rays",), GATHERED),
    Mutant("a light shades itself", "kernels/walk.clh", "best->primitive = select(best->primitive, "
           "before.primitive, own == i);", "", ("lights seen from all sides",), DIFFUSE),
    Mutant("lights seen from behind", "kernels/light.cl",
           "material->light == 2 ? (intP)(0) : (s.code & SURFACE_INSIDE) != 0", "(intP)(0)",
           ("lights seen from all sides",), EMISSION),
    Mutant("ambient rays see lights", "kernels/light.cl", "if (ambient_queue) return (intP)(-1);", "",
           ("lights seen from all sides",), GATHERED),
    Mutant("highlights of lights that a mirror shows", "kernels/light.clh",
           " && !(IS_SEEN(light) && material->kr > 0.0f)", "",
           ("lights seen from all sides",), HIGHLIGHT),
    Mutant("diffuse 1 % low", "kernels/light.clh", "material->kd * cosine", "material->kd * 0.99f * cosine",
           ("diffuse",),
           DIFFUSE),
    Mutant("diffuse light by the true normal", "kernels/light.clh",
           "const floatP cosine = dot3(s.ns, to.direction)",
           "const floatP cosine = dot3(s.n, to.direction)", ("opaque smooth mesh",), DIFFUSE),
    Mutant("exponent 36 for 40", "kernels/light.clh", "power(aligned, material->shininess)",
           "power(aligned, material->shininess * 0.9f)", ("highlight",), HIGHLIGHT),
    Mutant("highlight 1 % high", "kernels/light.clh", "material->ks * power",
           "material->ks * 1.01f * power",
           ("highlight",), HIGHLIGHT),
    Mutant("highlight cut off too early", "kernels/light.clh", "aligned > 0.0f);", "aligned > 0.3f);",
           ("broad highlight",), HIGHLIGHT),
    Mutant("highlight without its tint", "kernels/light.clh", "+ shine * highlight)", "+ shine)",
           ("highlight",), HIGHLIGHT),
    Mutant("highlight does not fade by Schlick", "kernels/light.clh",
           "highlight = tint + (1.0f - tint) * fade", "highlight = tint",
           ("schlick highlight",), HIGHLIGHT),
    Mutant("lights without colour", "kernels/light.clh", "in_band(light->intensity, s, b) * to.factor",
           "in_band(light->intensity, s, 0) * to.factor",
           ("five lights",), DIFFUSE),
    Mutant("lost shadow", "kernels/trace.cl", "((primitive) < 0)", "((primitive) == (primitive))",
           ("diffuse",), DIFFUSE),
    Mutant("feelers go all the way", "kernels/light.cl", "way.distance * FEELER_REACH", "way.distance",
           ("lamps in the ceiling",), DIFFUSE),
    Mutant("shadows from behind the light", "kernels/light.cl",
           "{start, way.direction, way.distance * FEELER_REACH}",
           "{start, way.direction, (floatP)(INFINITY)}", ("inside sphere",), DIFFUSE),
    Mutant("tinted shadows without their tint", "kernels/tinted.clh",
           "material->kt * material->tint[band_at(band, b)]", "material->kt",
           ("tinted shadows",), DIFFUSE),
    Mutant("tinted shadows end at the first pane", "kernels/tinted.clh",
           "{.count = PANES}", "{.count = 0}",
           ("tinted shadows",), DIFFUSE),
    Mutant("emission 2 % low", "kernels/light.cl", "emission = EMISSION_OF(s, material, b)",
           "emission = 0.98f * EMISSION_OF(s, material, b)",
           ("emission",), EMISSION),
    Mutant("ambient light by the diffuse coefficient", "kernels/light.cl",
           "select(material->ka * colors", "select(material->kd * colors", ("ambient",), AMBIENT),
    Mutant("ambient rays see the background", "kernels/light.cl",
           "if (!ambient_queue) backgrounds(world, s, u, missed, value);",
           "backgrounds(world, s, u, missed, value); ambient_queue = 0;", ("ambient rays",), GATHERED),
    Mutant("depth colour for reflection only", "kernels/light.cl",
           "select(value[b], value[b] + on, goes_on)",
           "select(value[b], value[b] + 0.0f * on, goes_on)",
           ("no bounces",), CAMERA),
    Mutant("four of five lights", "kernels/light.cl",
           "intP todo = arrives != 0, mine;",
           "intP todo = (arrives != 0) & -(int)(l > 0), mine;",
           ("five lights",), DIFFUSE),
    Mutant("ambient rays weigh too little", "kernels/ambient.cl", "/ (float)samples",
           "/ (float)(samples + 1)",
           ("ambient rays",), GATHERED),
    Mutant("ambient rays all in one direction", "kernels/ambient.cl",
           "Vec direction = cosine_direction(shading, key, k)",
           "Vec direction = cosine_direction(shading, key, 0)", ("ambient rays",), GATHERED),
    Mutant("ambient rays below the surface", "kernels/ambient.cl",
           "if (!(dot3(direction, geometric) > 0.0f)) direction = cosine_direction(geometric, key, k);", "",
           ("ambient rays on a mesh",), GATHERED),
    Mutant("ambient rays uniform, not by the cosine", "kernels/ambient.cl",
           "larger(1.0f - disk_x * disk_x - disk_y * disk_y, 0.0f)",
           "larger(1.0f - disk_x * disk_x, 0.0f)", ("ambient rays",), GATHERED),
)  # fmt: skip

KERNEL_FAULTS: Final = (*_GENERATE, *_LAYERS, *_LIGHT)
