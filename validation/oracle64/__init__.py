"""The image model once more, in float64, recursive and brute force: the renderer's accuracy oracle.

It reads the `Scene` as the user wrote it and shares no code with the flattening, the kernels or the float32
twin, so that a fault in any of those shows as a difference. Where the kernels go by queues, this package goes
by the equation: a ray's radiance is what its hit emits, gathers and reflects, plus what the reflected and the
transmitted ray return.

    vectors     dot products, unit vectors, rigid and affine frames
    flat        plane, disk, polygon, triangle: one formula for the distance, one inside test each
    curved      sphere, and every quadric: ellipsoid, cylinder, cone, paraboloid, general form
    primitives  the shapes of a scene as numbered primitives in such batches
    tree        boxes that skip what a ray cannot meet; brute force gives the same hits
    world       nearest hit, visibility of a light
    spectra     curves from the published tables
    palette     colours as the numbers that rays carry
    surfaces    materials as arrays, checker colours
    media       what rays are inside of
    edges       what a ray meets where two faces are in one place
    spot        the surface and the media where a ray hits
    optics      reflection, refraction, Fresnel, metals
    hashing     what looks random: jitter and ambient directions
    camera      pixels to rays, background image
    film        sums by layer, counts of rays
    bounce      what a hit reflects and transmits
    radiance    the recursion: the model itself
    render      the functions below
    adaptive    even pictures, and which of them each pixel of an adaptive one shows
"""

from .render import Hits64, Result64, edge_mask, media_at, radiance64, render64, trace64

__all__ = ["Hits64", "Result64", "edge_mask", "media_at", "radiance64", "render64", "trace64"]
