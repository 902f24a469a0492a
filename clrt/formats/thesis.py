"""Scenes of the thesis' own program: words and numbers, surfaces with spectra of 20 bands."""

from __future__ import annotations

import math
from array import array
from pathlib import Path
from typing import Any, Final

import numpy as np

from clrt.base import notices
from clrt.base.collector import no_collections
from clrt.base.errors import show
from clrt.base.limits import Limits
from clrt.base.places import At
from clrt.formats.tokens import Tokens, build
from clrt.meshfiles.planar import same_turn
from clrt.scene.scene import Scene

BANDS: Final = 380.0 + 18.0 * np.arange(20)
"""Lower ends of the program's bands in nm, each 18 nm wide."""
_END: Final = 740.0


def load(path: Path, limits: Limits, response: str = "thesis-2011", faults: bool = False) -> Scene:
    """The scene in a text file of the thesis' program, in its own 20 bands.

    `response`: "thesis-2011" shows colours as that program does, "cie" as the CIE 1931 observer sees them;
    the light is then so bright that a spectrum of 1 with an intensity of 1 has Y = 1. `faults` is for
    validation, which then copies the program's faults. Words that the program would skip are warned about.
    """
    if response not in ("thesis-2011", "cie"):
        raise At(path.name).error(response, "response must be 'thesis-2011' or 'cie'")
    reader = _Reader(path, limits, response, faults)
    with no_collections():
        reader.read()
    return build(reader.table(), reader.lines, reader.shape_lines, path, limits)


def interval(low: float, high: float) -> np.ndarray:
    """(20,) bands: 1 where low <= band <= high."""
    return np.array([1.0 if low <= band <= high else 0.0 for band in BANDS])


def _peak_1(spectrum: np.ndarray) -> np.ndarray:
    return spectrum / spectrum.max()


_RED, _GREEN, _BLUE = interval(600, 750), interval(500, 600), interval(380, 500)
SPECTRA: Final = {
    "Magenta": _peak_1(_RED + 0.5 * _BLUE + 0.1 * _GREEN),
    "Red": _peak_1(_RED + 0.1 * _BLUE + 0.1 * _GREEN),
}
"""(20,) values of the spectra that the program knows by name."""


def steps(values: np.ndarray) -> list[list[float]]:
    """(nm, value) pairs of the curve that has (20,) values in the bands and steps between them."""
    (ends,) = np.nonzero(np.append(np.diff(values) != 0, True))
    points: list[list[float]] = []
    start = BANDS[0]
    for end in ends:
        stop = BANDS[end + 1] if end + 1 < len(BANDS) else _END
        points += [[float(start), float(values[end])], [float(stop), float(values[end])]]
        start = stop
    return points


def _key(material: dict[str, Any]) -> tuple[Any, ...]:
    """The same for equal materials only."""
    color = material["color"]
    return (tuple(map(tuple, color)) if isinstance(color, list) else color, *list(material.values())[1:])


class _Reader:
    """The state while reading, with the program's defaults."""

    def __init__(self, path: Path, limits: Limits, response: str, faults: bool) -> None:
        self.response, self.faults = response, faults
        self.tokens = Tokens(path, limits)
        self.lines: dict[str, int] = {}
        self.width, self.height = 800, 600
        self.pixel = 0.0015 * 500 / 800
        self.focal = [0.0, 20.0, -30.0]
        self.ambient = 1.0
        self.lights: list[dict[str, Any]] = []
        self.materials: dict[str, dict[str, Any]] = {}
        self.names: dict[tuple[Any, ...], str] = {}  # of the materials, by what they say
        self.shape_lines = array("Q")
        self.shapes: list[dict[str, Any]] = []

    def read(self) -> None:
        entities = {
            "Width": self._width,
            "Height": self._height,
            "Pixel": self._pixel,
            "Focal": self._focal,
            "Ambient": self._ambient,
            "Light": self._light,
            "Sphere": self._sphere,
            "Plane": self._plane,
            "Polygon": self._polygon,
            "Mesh": self._mesh,
            "Ellipsoid": self._ellipsoid,
            "Quadric": self._quadric,
        }
        while self.tokens.peek() is not None:
            word = self.tokens.word("an object")
            if word in entities:
                entities[word]()
            else:
                text = f"the word {show(word)} is skipped; known are {', '.join(entities)}"
                notices.warn(self.tokens.source, f"line {self.tokens.line}", text)

    def table(self) -> dict[str, Any]:
        x, y, z = self.focal
        camera = {
            "origin": self.focal,
            "target": [x, y, z + max(1.0, abs(z))],  # far enough to differ from the origin in float32
            "fov": math.degrees(2 * math.atan(self.width * self.pixel / 2)),
            "near": 1.0,
            "mirror": True,
            # The program samples pixel corners, so that on an even side one of them is the middle.
            "shift": [0.0 if side % 2 else -0.5 for side in (self.width, self.height)],
            "width": self.width,
            "height": self.height,
        }
        return {
            "max_depth": 3,
            "medium_ior": 1.0003,
            "spectrum": {
                "bands": len(BANDS),
                "range": [BANDS[0], _END],
                "response": self.response,
                "faults": self.faults,
            },
            "ambient": self._radiance(np.ones(len(BANDS)), self.ambient),
            "camera": camera,
            "materials": self.materials,
            "lights": self.lights,
            "shapes": self.shapes,
        }

    def _width(self) -> None:
        self.width = self.tokens.side("Width")
        self.pixel = 1.5 / self.width

    def _height(self) -> None:
        self.height = self.tokens.side("Height")

    def _pixel(self) -> None:
        self.pixel = self.tokens.number("Pixel")
        if not self.pixel > 0:
            raise self.tokens.error(f"Pixel {self.pixel:g} is not allowed; it must be > 0")

    def _focal(self) -> None:
        self.lines["camera"] = self.tokens.line
        self.focal = self.tokens.numbers(3, "Focal")

    def _ambient(self) -> None:
        self.ambient = self.tokens.number("Ambient")
        if self.ambient < 0:
            raise self.tokens.error(f"Ambient {self.ambient:g} is not allowed; it must be >= 0")

    def _light(self) -> None:
        self.lines[f"lights[{len(self.lights)}]"] = self.tokens.line
        position = self._vector("Point")
        self.tokens.expect("Spectrum")
        spectrum = self._spectrum()
        self.tokens.expect("Intensity")
        intensity = self.tokens.number("Intensity")
        if not spectrum.any():
            raise self.tokens.error(
                "the light's spectrum is empty; it must contain one of 380, 398, ... 722 nm"
            )
        light = self._radiance(spectrum, intensity)
        self.lights.append({"type": "point", "position": position, "intensity": light})

    def _radiance(self, spectrum: np.ndarray, intensity: float) -> list[list[float]]:
        """The spectrum as (nm, value) pairs with the integral over nm, or (CIE) the mean, `intensity`."""
        width = 18.0 if self.response == "thesis-2011" else 1 / len(BANDS)
        return steps(spectrum * intensity / (width * spectrum.sum()))

    def _sphere(self) -> None:
        line, center = self.tokens.line, self._vector("Point")
        self.tokens.expect("Radius")
        self._add(line, type="sphere", center=center, radius=self.tokens.number("Radius"))

    def _plane(self) -> None:
        self._add(self.tokens.line, type="plane", point=self._vector("Point"), normal=self._vector("Vector"))

    def _ellipsoid(self) -> None:
        self._add(
            self.tokens.line, type="ellipsoid", center=self._vector("Center"), radii=self._vector("Radii")
        )

    def _quadric(self) -> None:
        line = self.tokens.line
        self.tokens.expect("Constants")
        self._add(line, type="quadric", coefficients=self.tokens.numbers(10, "Constants A to J"))

    def _polygon(self) -> None:
        self._add(self.tokens.line, type="polygon", points=self._points())

    def _mesh(self) -> None:
        line = self.tokens.line
        faces: list[list[int]] = []
        vertices: list[list[float]] = []
        while self.tokens.peek() == "Polygon":
            self.tokens.expect("Polygon")
            points = self._points()
            self._surface()  # the mesh's own surface, which comes last, shades all
            faces.append([len(vertices) + corner for corner in range(len(points))])
            vertices += points
        if not faces:
            raise self.tokens.error("a Mesh has one or more Polygons")
        self._add(line, type="mesh", vertices=vertices, faces=faces)

    def _points(self) -> list[list[float]]:
        points = []
        while self.tokens.peek() == "Point":
            points.append(self._vector("Point"))
        if len(points) < 3:
            raise self.tokens.error(f"{len(points)} Points are not allowed; a Polygon has 3 or more")
        return points if same_turn(points) else points[::-1]

    def _vector(self, word: str) -> list[float]:
        self.tokens.expect(word)
        return self.tokens.numbers(3, word)

    def _add(self, line: int, **shape: Any) -> None:
        """Read the surface that ends a shape, and keep both."""
        surface_line, material = self._surface()
        name = self.names.setdefault(_key(material), f"surface_{len(self.names) + 1}")
        self.materials[name] = material
        self.lines.setdefault(f"materials.{name}", surface_line)
        self.shape_lines.append(line)
        self.shapes.append(shape | {"material": name})

    def _surface(self) -> tuple[int, dict[str, Any]]:
        self.tokens.expect("Surface")
        line = self.tokens.line
        if self.tokens.expect("None", "Spectrum") == "None":
            return line, {"color": 0.0}
        color = steps(self._spectrum())
        self.tokens.expect("Constants")
        wanted = "Constants: diffuse, specular, transmissive, refraction, smoothness"
        diffuse, specular, transmissive, refraction, smoothness = self.tokens.numbers(5, wanted)
        return line, {
            "color": color,
            "diffuse": diffuse,
            "specular": specular,
            "reflection": specular,
            "transmission": transmissive,
            "ior": refraction or 1.0,
            "shininess": smoothness,
        }

    def _spectrum(self) -> np.ndarray:
        word = self.tokens.peek()
        if word in SPECTRA:
            return SPECTRA[self.tokens.expect(*SPECTRA)]
        return interval(
            self.tokens.number("Magenta, Red or the lower end in nm"), self.tokens.number("the upper end")
        )
