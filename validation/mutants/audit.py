"""Faults that an audit planted and that went unnoticed: in kernels (K), in what they are given (H), and in
what reads scenes, under every oracle but Mitsuba's side."""

from __future__ import annotations

from typing import Final

from .kernels import Mutant

_BEHIND: Final = "store_surface(world, ray, hit.primitive, hit.t, width, i, i + 1, surfaces, surface_code);"
_DISPERSED: Final = (
    Mutant("K1: tinted shadows of dispersed rays in the first band", "kernels/tinted.clh",
           "material->tint[band_at(band, b)]", "material->tint[b]", ("dispersion and tinted shadows",)),
    Mutant("K2: the sky of dispersed rays in the first band", "kernels/sky.clh",
           "in_band(info->sky_red, s, b)", "(floatP)(info->sky_red[b])", ("dispersion and a sky",)),
    Mutant("K3: ambient rays of dispersed rays in the first band", "kernels/ambient.cl",
           "(second ? material->color2 : material->color)[band_at(band, b)]",
           "(second ? material->color2 : material->color)[b]", ("dispersion and ambient rays",)),
)  # fmt: skip
_BEHIND_BOUNDARIES: Final = (
    Mutant("K4: checkers lost behind hidden boundaries", "kernels/boundaries.cl", _BEHIND,
           _BEHIND + " if (surface_code[i] >= 0) surface_code[i] &= ~SURFACE_SECOND_COLOR;",
           ("things behind hidden boundaries",)),
    Mutant("K5: smooth meshes flat behind hidden boundaries", "kernels/boundaries.cl", _BEHIND,
           _BEHIND + " for (int k = 0; k < 3; k++) surfaces[in_block(i, SHADING_X + k, SURFACE_FIELDS)] = "
           "surfaces[in_block(i, NORMAL_X + k, SURFACE_FIELDS)];", ("things behind hidden boundaries",)),
)  # fmt: skip
_STARTS: Final = (
    Mutant("H1: the smallest medium entered first", "clrt/flatten/media.py", "np.argsort(-np.prod(",
           "np.argsort(np.prod(", ("camera in equal media",)),
    Mutant("H2: paraboloids half as wide inside", "clrt/flatten/inside.py", "4 * shape.focal * height",
           "2 * shape.focal * height", ("camera in a paraboloid",)),
    Mutant("H3: metals do not ask what is before them", "clrt/flatten/media.py",
           " or material.conductor is not None", "", ("metal in glass",)),
    Mutant("H4: inside of a quadric beyond its clip", "clrt/flatten/inside.py",
           "if shape.clip is not None:", "if False:", ("camera in a clipped quadric",)),
    Mutant("H5: rays looked for at the eye, not at the near plane", "clrt/flatten/camera.py",
           "corners = origin + near * forward + across", "corners = origin + across",
           ("near plane in glass",)),
)  # fmt: skip
_READING: Final = (
    Mutant("rotations clockwise", "clrt/scene/transforms.py",
           "across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])",
           "across = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])", ("opaque box",)),
    Mutant("Fresnel without a mirror", "clrt/scene/materials.py",
           "given = self.fresnel is True or self.conductor is not None",
           "given = self.conductor is not None", ("nested glass",)),
    Mutant("no ambient coefficient where none is given", "clrt/scene/materials.py",
           "return self.diffuse if self.ambient is None", "return 0.0 if self.ambient is None",
           ("opaque sphere",)),
    Mutant("diamond as lecture notes have it", "clrt/spectra/indices.py", '"diamond": 2.419',
           '"diamond": 2.47', ("clear sphere",)),
    Mutant("upside down from above", "clrt/scene/camera.py", "return (0.0, 0.0, 1.0) if",
           "return (0.0, 0.0, -1.0) if", ("camera from above",)),
    Mutant("SF11 of another melt", "clrt/spectra/tables/glasses.csv", "SF11,1.73759695", "SF11,1.74759695",
           ("dispersion",)),
    Mutant("normals not weighted by area", "clrt/meshfiles/parts.py", "across = _cross(b - a, c - a)",
           "across = _units(_cross(b - a, c - a))", ("opaque smooth mesh",)),
)  # fmt: skip

AUDIT_FAULTS: Final = (*_DISPERSED, *_BEHIND_BOUNDARIES, *_STARTS, *_READING)
