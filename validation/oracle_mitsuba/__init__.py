"""Mitsuba 3 as an oracle: a renderer of other people's, of another design, that shares no code with this one.

It runs in a process of its own (`client`, `worker`), is handed a scene file's tables, and reads these itself:
nothing that it renders comes from `clrt` or another oracle (validation/independence.py says what they
share). It is asked in two ways:

- layer A, `stock-S1` ...: scenes that Mitsuba's own plugins can express, so that nobody here wrote the
  shading;
- layer B, `table` and `bsdf`: Whitted's recursion, breadth first, on Mitsuba's camera, intersections and
  visibility. `table` computes what surfaces do with light from a table of materials: the full model; `bsdf`
  leaves that to Mitsuba's own BSDFs and emitters where it has them.

    records    the scene: defaults, references and overrides as its tables and docs/scene-files.md say
    shapes     its shapes
    steps      transforms
    meshfile   mesh files, and normals that they lack
    objfile, plyfile, stlfile, gltffile: what reads each kind
    patches    what they read
    published  indices of refraction, typed in
    spectra    curves over the wavelength, by colour-science
    palette    colours, and bands three at a time
    insides    the media in which rays start
    forms      quadric surfaces as 4x4 matrices
    meshing    triangles of what Mitsuba has no plugin for
    parts      the scene's shapes as Mitsuba's
    faces      polygons, boxes and meshes as triangles
    plugins    those as plain data
    surfaces   materials and lights as arrays
    cameras    the camera, as arrays and as Mitsuba's
    hashing    what looks random and is not
    stock      layer A: its configurations
    modes      what each mode can express
    textures   checkers as Mitsuba's, for stock plugins
    skies      backgrounds as Mitsuba's
    endless    meshes of quadrics without an end
    translate  a scene as a dict for Mitsuba
    xml        and as a file
    handed     what clrt has read, for that file
    client     the process, from the caller's side
    adaptive   which of the even pictures each pixel of an adaptive one shows
    worker, rendering, engine, world, whitted, table, lobes, sensors: what runs inside it
"""

from .client import Mitsuba, MitsubaError
from .modes import MODES
from .records import Source

__all__ = ["MODES", "Mitsuba", "MitsubaError", "Source"]
