"""Deliberate faults in media, absorption, metals, dispersion and colours from bands."""

from __future__ import annotations

from typing import Final

from .kernels import Mutant

_MEDIA: Final = (
    Mutant("absorption that adds light", "kernels/boundaries.cl", "exponential(-absorption * t)",
           "exponential(absorption * t)", ("absorption",)),
    Mutant("absorption 1 % low", "kernels/boundaries.cl", "exponential(-absorption * t)",
           "exponential(-0.99f * absorption * t)", ("absorption",)),
    Mutant("absorption of the medium entered first", "kernels/boundaries.cl",
           "absorb(world, top_of(world, list),", "absorb(world, list.medium[0],",
           ("ice in water in a glass",)),
    Mutant("all boundaries seen", "kernels/boundaries.cl", "if (before != after) break;", "break;",
           ("hidden media",)),
    Mutant("media told apart by their index alone", "clrt/flatten/materials.py",
           "first.setdefault(medium, number)", "first.setdefault((medium.ior, medium.priority), number)",
           ("media that differ by their pattern",)),
    Mutant("media not left in hidden boundaries", "kernels/boundaries.cl", "        list = next;\n", "",
           ("water in a glass", "absorption by pieces", "hidden media")),
    Mutant("a medium not listed is not there", "kernels/boundaries.cl",
           "fits = enter_medium(&list, medium);  // the ray was in it, though it is not listed\n            "
           "next = list;", "next = list;", ("clear clipped quadric", "clear cylinder", "clear polygon")),
    Mutant("rays in two media taken for rays in one", "kernels/boundaries.cl", "mine &= ~several;", "",
           ("water in a glass", "the stronger medium")),
    Mutant("every exit leads out", "kernels/boundaries.cl", "mine & inside & (top == medium)",
           "mine & inside", ("clear clipped quadric", "clear cylinder", "clear polygon")),
    Mutant("priority forgotten", "kernels/media.clh", "if (top == NO_MEDIUM || priority >= highest) {", "{",
           ("the stronger medium", "the other stronger medium")),
    Mutant("the medium entered first of equals", "kernels/media.clh", "priority >= highest",
           "priority > highest", ("the medium entered last",)),
    Mutant("the weakest medium on top", "kernels/media.clh", "priority >= highest", "priority <= highest",
           ("the stronger medium", "the other stronger medium")),
    Mutant("the media of the wrong side handed on", "kernels/media.clh",
           "exits = surface_code & SURFACE_INSIDE;", "exits = !(surface_code & SURFACE_INSIDE);",
           ("ice in water in a glass",)),
    Mutant("things in a medium stand outside it", "kernels/boundaries.cl",
           "*after = select(*after, (intP)(number), mine & ~swapped);",
           "*after = select(*after, (intP)(number), mine & ~swapped);\n            "
           "*before = select(*before, (intP)(NO_MEDIUM), mine);", ("metals in water", "metal in glass")),
    Mutant("media in media stand outside them", "kernels/boundaries.cl",
           "before = top_of(world, list);\n        after",
           "before = inside ? top_of(world, list) : NO_MEDIUM;\n        after", ("water in a glass",)),
    Mutant("cameras start in no medium", "clrt/flatten/media.py",
           "out[which, size[which]] = self.numbers[k]", "out[which, size[which]] = -1",
           ("camera under water", "camera in a paraboloid")),
    Mutant("the same index on both sides", "kernels/bounce.clh",
           "r->eta_i = iors(world, s, s.before, band)", "r->eta_i = iors(world, s, s.after, band)",
           ("ice in water in a glass",)),
)  # fmt: skip

_METALS: Final = (
    Mutant("k added where it is taken away", "kernels/bounce.clh", "eta * eta - k * k - s2",
           "eta * eta + k * k - s2", ("gold",)),
    Mutant("no phase from k", "kernels/bounce.clh", "imaginary = 2.0f * eta * k", "imaginary = 0.0f",
           ("weak metals", "gold")),
    Mutant("the medium before a metal forgotten", "kernels/bounce.clh",
           "bounce.before = 1.0f / ior_before(world, s, band)", "bounce.before = 1.0f",
           ("metals in water",)),
    Mutant("metals polarise", "kernels/bounce.clh", "return (s + p) * 0.5f;", "return s;", ("weak metals",)),
    Mutant("eta and k exchanged", "clrt/flatten/materials.py", 'record["eta"], record["k"] = conductor',
           'record["k"], record["eta"] = conductor', ("weak metals",)),
)  # fmt: skip

_DISPERSION: Final = (
    Mutant("one index for all bands", "clrt/flatten/materials.py", "return ior_at(material.ior, centers)",
           "return ior_at(material.ior, centers * 0 + 587.56)", ("dispersion",)),
    Mutant("the index of the next group", "clrt/flatten/materials.py", "return ior_at(material.ior, centers)",
           "return ior_at(material.ior, centers + bands.width * group)", ("dispersion",)),
    Mutant("the index at a group's start", "clrt/flatten/materials.py",
           "(bands.edges[first] + bands.edges[np.minimum(first + group, bands.n)]) / 2", "bands.edges[first]",
           ("dispersion in groups",)),
    Mutant("the last group says whether all are transmitted", "kernels/light.cl", "transmitted |= goes;",
           "transmitted = goes;", ("dispersion beside none",)),
    Mutant("a coat has one index for all bands", "kernels/bounce.cl",
           "bands_together(disperses(world, s, material) & mine)",
           "bands_together(disperses(world, s, material) & mine & (material->kt > 0.0f ? -1 : 0))",
           ("dispersive coat",)),
)  # fmt: skip

_COLOURS: Final = (
    Mutant("lights not corrected", "clrt/spectra/bands.py", "return found * factor", "return found",
           ("named lights",)),
    Mutant("lights at midpoints", "clrt/spectra/bands.py", "return curve_of(value).averages(bands.edges)",
           "return curve_of(value).at(bands.midpoints)", ("curves of light",)),
    Mutant("RGB lights without D65", "clrt/spectra/bands.py",
           '_upsampled(value, bands) * (1.0 if bands is None else _lamp("D65", bands))',
           "_upsampled(value, bands)", ("RGB in bands",)),
    Mutant("matching functions a band off", "clrt/spectra/colorimetry.py",
           "functions = matching(bands.midpoints)",
           "functions = matching(bands.midpoints + bands.width)", ("patches",)),
    Mutant("green and blue exchanged", "clrt/spectra/colorimetry.py", "return matrix @ xyz_matrix(bands)",
           "return (matrix @ xyz_matrix(bands))[[0, 2, 1]]", ("patches",)),
    Mutant("white balance forgotten", "clrt/spectra/colorimetry.py",
           "if spectral is not None and spectral.white_balance:", "if False:", ("white balance",)),
    Mutant("absorption of the first band", "clrt/flatten/materials.py",
           'record["absorption"] = curve(material.absorption, bands)',
           'record["absorption"] = curve(material.absorption, bands)[0]', ("spectral absorption",)),
)  # fmt: skip

SPECTRAL_FAULTS: Final = (*_MEDIA, *_METALS, *_DISPERSION, *_COLOURS)
