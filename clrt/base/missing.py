"""What other renderers have and clrt has not, by the words that scenes use for it.

A guess at a similar key would mislead there: `fog` is no misspelt key. docs/what-clrt-does-not-do.md has a
row for each of FEATURES and says what to do instead.
"""

from __future__ import annotations

from typing import Final

from clrt.base.errors import show

PAGE: Final = "docs/what-clrt-does-not-do.md"

# what clrt has not -> words of scene files that ask for it, in lower case with _ for spaces and hyphens
FEATURES: Final[dict[str, tuple[str, ...]]] = {
    "procedural textures": ("noise", "perlin", "turbulence", "marble", "wood", "procedural", "stripes",
                            "color_ramp", "gradient_texture"),
    "bump and displacement maps": ("bump", "bump_map", "bumpmap", "displacement", "displacement_map",
                                   "bumpiness"),
    "other models of reflection": ("beckmann", "oren_nayar", "cook_torrance", "principled", "disney",
                                   "anisotropy", "anisotropic", "sheen", "clearcoat", "metallic",
                                   "metalness", "brdf", "bsdf"),
    "subsurface scattering": ("subsurface", "sss", "bssrdf", "translucency"),
    "fog and clouds": ("fog", "haze", "mist", "smoke", "cloud", "clouds", "volume", "volumetric",
                       "scattering", "participating_medium", "phase_function"),
    "lights of other forms": ("mesh_light", "polygon_light", "tube", "tube_light", "line_light",
                              "triangle_light"),
    "measured lights": ("ies", "ies_profile", "photometric", "goniometric"),
    "environment lighting": ("environment_light", "envmap", "environment_map", "hdri", "sky_light",
                             "skylight", "dome", "dome_light", "infinite_light"),
    "global illumination": ("path_tracing", "path_tracer", "pathtracing", "global_illumination", "gi",
                            "radiosity", "photon_map", "photons", "caustics", "bidirectional", "metropolis",
                            "ambient_occlusion", "integrator"),
    "fisheye and panoramic cameras": ("fisheye", "panorama", "panoramic", "spherical", "equirectangular",
                                      "omnidirectional", "stereo", "cylindrical"),
    "motion blur": ("motion", "motion_blur", "shutter", "shutter_open", "shutter_close", "shutter_speed",
                    "velocity", "exposure_time"),
    "animation": ("animation", "animate", "keyframe", "keyframes", "frame", "frames", "timeline", "fps"),
    "constructive solid geometry": ("csg", "union", "intersection", "difference", "merge", "boolean",
                                    "subtract", "clipped_by"),
    "instances and groups": ("instance", "instances", "instancing", "groups", "include",
                             "prototype", "reference"),
    "curved shapes of higher order": ("torus", "nurbs", "bezier", "bezier_patch", "bilinear_patch", "patch",
                                      "spline", "blob", "metaball", "isosurface", "julia", "quartic", "cubic",
                                      "superellipsoid", "sdf", "fractal", "heightfield", "height_field",
                                      "hair", "curve", "curves", "subdivision"),
    "tone curves of your own": ("tonemap", "tone_map", "tone_mapping", "tonemapping", "reinhard", "aces",
                                "filmic", "gamma", "bloom", "vignette"),
    "denoising": ("denoise", "denoiser", "denoising", "sampler"),
}  # fmt: skip

# other programs' word -> what clrt calls it
OTHER_WORDS: Final[dict[str, str]] = {
    "texture": "color",
    "texture_map": "color",
    "image_map": "image",
    "image_texture": "image",
    "bitmap": "image",
    "albedo_map": "color",
    "color_map": "color",
    "pigment": "color",
    "normalmap": "normal_map",
    "uv_map": "uv",
    "pixel_filter": "filter",
    "reconstruction_filter": "filter",
    "metal": "conductor",
    "refraction": "transmission",
    "refractive_index": "ior",
    "index_of_refraction": "ior",
    "area": "rectangle",
    "area_light": "rectangle",
    "rectangle_light": "rectangle",
    "rect_light": "rectangle",
    "quad": "rectangle",
    "quad_light": "rectangle",
    "sphere_light": "sphere",
    "disk_light": "disk",
    "light_samples": "samples",
    "soft_shadows": "samples",
    "spotlight": "spot",
    "spot_light": "spot",
    "cone_angle": "angle",
    "spot_angle": "angle",
    "cutoff_angle": "angle",
    "look_at": "target",
    "lookat": "target",
    "look_from": "origin",
    "eye": "origin",
    "field_of_view": "fov",
    "fovy": "fov",
    "fov_y": "fov",
    "vertical_fov": "fov",
    "object": "shapes",
    "objects": "shapes",
    "primitives": "shapes",
    "emitter": "lights",
    "emitters": "lights",
    "reflectivity": "reflection",
    "dispersion": "ior",
    "rough": "roughness",
    "glossiness": "roughness",
    "microfacet": "roughness",
    "ggx": "roughness",
    "aperture_radius": "aperture",
    "lens": "aperture",
    "lens_radius": "aperture",
    "depth_of_field": "aperture",
    "dof": "aperture",
    "bokeh": "aperture",
    "focal_distance": "focus",
    "focus_distance": "focus",
    "recursion_depth": "max_depth",
    "max_recursion": "max_depth",
    "samples_per_pixel": "spp",
    "smooth_normals": "smooth",
    "ka": "ambient",
    "kd": "diffuse",
    "ks": "specular",
    "kr": "reflection",
    "kt": "transmission",
}

# likewise of types of shapes, where lights may have the same
OTHER_SHAPES: Final[dict[str, str]] = {
    "quad": "polygon", "square": "polygon", "rectangle": "polygon", "triangle": "polygon", "cube": "box",
    "cuboid": "box", "tube": "cylinder", "pipe": "cylinder", "circle": "disk", "ball": "sphere",
}  # fmt: skip

# likewise of cameras, where lights have the key
_OF_CAMERAS: Final = {"position": "origin"}

# what is another number there
_MIND: Final[dict[str, str]] = {
    "glossiness": "1 less it", "fovy": 'with fov_axis = "vertical"', "fov_y": 'with fov_axis = "vertical"',
    "vertical_fov": 'with fov_axis = "vertical"', "cone_angle": "from the axis, half of a whole cone",
    "spot_angle": "from the axis, half of a whole cone",
}  # fmt: skip

# the keys of the scene itself, which a TOML file must have before its first table
SCENE_KEYS: Final = frozenset({
    "version", "max_depth", "min_weight", "depth_color", "background", "ambient", "ambient_samples",
    "medium_ior", "one_sided", "shadow", "conformance",
})  # fmt: skip

_FEATURE: Final = {word: feature for feature, words in FEATURES.items() for word in words}


def advice(word: object, known: list[str]) -> str:
    """'; ...' on a key or name that is not among the `known` ones of its place; "" for an unknown word."""
    plain = _plain(word)
    for table in (OTHER_WORDS, OTHER_SHAPES, _OF_CAMERAS):
        if (other := table.get(plain)) in known:
            return f"; clrt calls it {other!r}" + (f", {_MIND[plain]}" if plain in _MIND else "")
    if f"{plain}s" in known:
        return f"; did you mean {f'{plain}s'!r}?"
    if plain in _FEATURE:
        return f"; clrt has no {_FEATURE[plain]} ({PAGE})"
    if plain in SCENE_KEYS:
        return f"; {plain!r} is a key of the scene itself: top-level keys go before the first [table]"
    return ""


def _plain(word: object) -> str:
    return (word if isinstance(word, str) else show(word))[:80].lower().replace("-", "_").replace(" ", "_")
