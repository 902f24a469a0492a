"""Spectra, metals and dispersive glasses in scene files: read, checked, saved; a fault is one clear line."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

import clrt
from clrt.base.errors import ClrtWarning
from clrt.scene.scene import Material, Spectral, Spectrum
from clrt.scene.schema import schema

CAMERA = {"origin": [0, 0, 5], "target": [0, 0, 0]}
RICH: dict[str, Any] = {
    "spectrum": {"bands": 16, "range": [400, 700], "white": "A", "white_balance": True, "group": 2},
    "camera": CAMERA,
    "background": "D65",
    "ambient": {"name": "F11", "scale": 0.1},
    "depth_color": {"blackbody": 3200},
    "materials": {
        "gold": {"conductor": "gold", "highlight_color": "gold"},
        "own": {"conductor": {"eta": [[400, 1.4], [700, 0.2]], "k": 3.0}},
        "prism": {"fresnel": True, "ior": "BK7", "absorption": [[400, 0.0], [700, 0.3]], "priority": 2},
        "sell": {"fresnel": True, "ior": {"sellmeier": {"B": [1.0], "C": [0.01]}}},
        "cauchy": {"fresnel": True, "ior": {"cauchy": [1.5, 0.004]}},
        "table": {"fresnel": True, "ior": [[400, 1.53], [700, 1.51]]},
        "filter": {"color": [[400, 0.1], [550, 0.9], [550, 0.2], [700, 0.1]]},
        "chart": {"color": {"type": "checker", "colors": ["patch-1", [[400, 0.1], [700, 0.9]]]}},
        "plain": {"color": {"type": "checker", "colors": [[1, 0, 0], [0, 1, 0]]}},
        "lamp": {"emission": {"line": 589.3, "scale": 2.0}},
    },
    "lights": [
        {"type": "point", "position": [1, 2, 3], "intensity": "A"},
        {"type": "directional", "direction": [0, -1, 0], "intensity": {"gaussian": [550, 20]}},
        {"type": "directional", "direction": [0, -1, 0], "intensity": {"band": [500, 600]}},
        {"type": "directional", "direction": [0, -1, 0], "intensity": [[380, 0.0], [780, 1.0]]},
    ],
    "shapes": [
        {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {"color": {"gaussian": [500, 9]}}},
        {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0], "material": "chart"},
    ],
}


def test_every_form_is_read_saved_and_read_again(tmp_path: Path) -> None:
    scene = clrt.load_dict(RICH)
    assert scene.spectrum == Spectral(bands=16, range=(400, 700), white="A", white_balance=True, group=2)
    assert scene.materials["gold"].kr == 1 and scene.materials["gold"].kt == 0
    assert scene.materials["filter"].color == Spectrum(
        samples=((400, 0.1), (550, 0.9), (550, 0.2), (700, 0.1))
    )
    assert scene.to_dict()["materials"]["filter"] == RICH["materials"]["filter"]
    assert scene.to_dict()["ambient"] == RICH["ambient"]
    jsonschema.Draft202012Validator(schema()).validate(scene.to_dict())
    for name in ("a.toml", "a.json"):
        scene.save(tmp_path / name)
        again = clrt.load(tmp_path / name)
        assert again == scene and again.to_dict() == scene.to_dict()


def test_records_and_numpy_arrays_are_taken_too() -> None:
    pairs = np.array([[400.0, 0.5], [700.0, 0.25]])
    scene = clrt.load_dict(
        {"materials": {"a": {"color": pairs}, "b": Material(color=Spectrum(gaussian=(500, 20)))}}
    )
    assert scene.materials["a"].color == Spectrum(samples=((400, 0.5), (700, 0.25)))
    assert scene.materials["b"].color == Spectrum(gaussian=(500, 20))


def test_without_a_table_the_scene_is_rgb() -> None:
    assert clrt.load_dict({}).spectrum is None and "spectrum" not in clrt.load_dict({}).to_dict()


def material(**keys: Any) -> dict[str, Any]:
    return {"materials": {"m": keys}}


def lit(intensity: Any, **more: Any) -> dict[str, Any]:
    return {"lights": [{"type": "directional", "direction": [0, -1, 0], "intensity": intensity}], **more}


BAD: list[tuple[dict[str, Any], list[str]]] = [
    # names
    (lit("D56"), ["lights[0].intensity", "'D56'", "D65", "did you mean 'D65'"]),
    (lit("f11"), ["lights[0].intensity", "'f11'", "did you mean 'F11'"]),
    (lit("gold"), ["lights[0].intensity", "'gold'", "a reflectance", "a light"]),
    (lit({"name": "D6"}), ["lights[0].intensity.name", "'D6'", "did you mean 'D65'"]),
    (material(color="golf"), ["materials.m.color", "'golf'", "did you mean 'gold'"]),
    (material(color="A"), ["materials.m.color", "'A'", "a light", "a reflectance"]),
    (material(color={"type": "checker", "colors": ["gilver", 1]}), ["color.colors[0]", "'silver'"]),
    (material(ior="bk7"), ["materials.m.ior", "'bk7'", "did you mean 'BK7'"]),
    (material(conductor="gols"), ["materials.m.conductor", "'gols'", "did you mean 'gold'"]),
    (material(absorption={"name": "gold"}), ["materials.m.absorption.name", "'gold'", "no name"]),
    ({"spectrum": {"white": "D56"}}, ["spectrum.white", "'D56'", "did you mean 'D65'"]),
    (lit({"blackbdy": 1000}), ["lights[0].intensity", "'blackbdy'", "did you mean 'blackbody'"]),
    # kinds
    (lit({}), ["lights[0].intensity", "one of name, blackbody", "none"]),
    (lit({"line": 500, "band": [400, 500]}), ["lights[0].intensity", "band, line is given"]),
    # wavelengths
    (material(color={"blackbody": 3200}), ["materials.m.color.blackbody", "this is a light"]),
    (lit({"line": 900}), ["lights[0].intensity.line", "900", "nm, from 360 to 830"]),
    (lit({"line": 390}, spectrum={"range": [400, 700]}), ["intensity.line", "390", "400 to 700 nm"]),
    (lit({"gaussian": [0.55, 10]}), ["intensity.gaussian", "0.55", "nm"]),
    (lit({"gaussian": [550, 0]}), ["intensity.gaussian", "0", ">= 0.01 nm"]),
    (lit({"band": [600, 500]}), ["intensity.band", "(600.0, 500.0)", "below the second"]),
    (lit([[400, 1], [390, 1]]), ["intensity.samples[1]", "390", "ascend", "400"]),
    (lit([[0.4, 1], [0.7, 1]]), ["intensity.samples[0]", "0.4", "nm"]),
    (lit([[400, 1]] * 3), ["intensity.samples[2]", "400", "twice"]),
    (lit([[400, 1]] * 2), ["intensity.samples", "2 different wavelengths"]),
    (lit([[400, 1]]), ["intensity.samples", "2 or more"]),
    (material(ior=[[500, 1.5]]), ["materials.m.ior", "2 or more"]),
    ({"spectrum": {"range": [750, 380]}}, ["spectrum.range", "low before high"]),
    ({"spectrum": {"range": [300, 750]}}, ["spectrum.range", "300", "360 to 830"]),
    # values
    (lit([[400, 1], [500, -0.1]]), ["intensity.samples[1]", "-0.1", ">= 0"]),
    (lit([[400, 1], [500, float("nan")]]), ["intensity", "nan", "finite"]),
    (lit({"gaussian": [550, 10], "scale": -1}), ["intensity.scale", "-1", ">= 0"]),
    (lit({"blackbody": 50}), ["intensity.blackbody", "50", "500 to 100000"]),
    (material(ior=1e-4), ["materials.m.ior", "0.0001", "from 0.001 to 1e+06"]),
    (material(ior=[[400, 1.5], [500, 0]]), ["materials.m.ior[1]", "0", "from 0.001 to 1e+06"]),
    (material(ior={"sellmeier": {"B": [-2.0], "C": [0.01]}}), ["materials.m.ior", "nan", "360 nm"]),
    (material(ior={"sellmeier": {"B": [1.0, 1e-7], "C": [0.01, 0.3452288688]}}),
     ["materials.m.ior.sellmeier.C[1]", "no end at 587.562 nm", "below 0.1296 or above 0.6889"]),
    (material(ior={"sellmeier": {"B": [1.0], "C": []}}), ["materials.m.ior.sellmeier.C", "as many"]),
    (material(ior=1e20), ["materials.m.ior", "1e+20", "from 0.001 to 1e+06"]),
    (material(ior=[[400, 1.5], [500, 1e7]]), ["materials.m.ior[1]", "10000000.0", "from 0.001 to 1e+06"]),
    (material(ior={"cauchy": [1.5, 1e9]}), ["materials.m.ior", "from 0.001 to 1e+06"]),
    (material(conductor={"eta": 1e9, "k": 1}), ["conductor.eta", "1000000000.0", "from 0.001 to 1e+06"]),
    (material(conductor={"eta": 1, "k": 1e9}), ["conductor.k", "1000000000.0", "from 0 to 1e+06"]),
    (material(ior={"cauchy": [-1.5]}), ["materials.m.ior", "-1.5", "from 0.001 to 1e+06"]),
    (material(ior={}), ["materials.m.ior", "one of sellmeier, cauchy"]),
    (material(conductor={"eta": 0, "k": 1}), ["materials.m.conductor.eta", "0", "from 0.001 to 1e+06"]),
    (material(conductor={"eta": 1, "k": [[400, -1], [500, 1]]}), ["conductor.k[0]", "-1", "from 0 to 1e+06"]),
    (material(conductor={"eta": 1}), ["materials.m.conductor", "'k' is missing"]),
    (material(conductor="gold", transmission=0.5), ["materials.m.transmission", "0.5", "conductor"]),
    (material(conductor="gold", fresnel="schlick"), ["materials.m.fresnel", "schlick", "conductor"]),
    # how the light is computed
    ({"spectrum": {"bands": 2}}, ["spectrum.bands", "2", "from 3 to 64"]),
    ({"spectrum": {"bands": 8, "group": 9}}, ["spectrum.group", "9", "1 to 8"]),
    ({"spectrum": {"response": "thesis"}}, ["spectrum.response", "'thesis'", "'thesis-2011'"]),
    ({"spectrum": {"faults": True}}, ["spectrum.faults", "thesis-2011"]),
    ({"spectrum": {"band": 24}}, ["spectrum", "'band'", "did you mean 'bands'"]),
]  # fmt: skip


@pytest.mark.parametrize(("table", "parts"), BAD, ids=[parts[0] + parts[1] for _, parts in BAD])
def test_a_fault_is_one_line(table: dict[str, Any], parts: list[str]) -> None:
    with pytest.raises(clrt.SceneError) as caught:
        clrt.load_dict(table, source="room.toml")
    message, at = str(caught.value), 0
    assert message.startswith("room.toml: ") and "\n" not in message and len(message) < 500
    for part in parts:
        found = message.find(part, at)
        assert found >= 0, f"{part!r} is not in {message!r} (from {at})"
        at = found + 1


def test_too_many_bands_are_a_limit() -> None:
    with pytest.raises(clrt.LimitError, match=r"spectrum\.bands: bands: 65 is above the limit of 64"):
        clrt.load_dict({"spectrum": {"bands": 65}})


@pytest.mark.parametrize(
    ("table", "text"),
    [
        (material(color=[[400, 0.5], [700, 1.25]]), "materials.m.color: a reflectance of 1.25; above 1"),
        (material(reflection_color=[1, 2, 1]), "materials.m.reflection_color: a reflectance of 2; above 1"),
        (material(color={"type": "checker", "colors": [0, 3]}), "m.color.colors[1]: a reflectance of 3"),
        (material(ior="BK7", fresnel=True), "materials.m.ior: without [spectrum] its one index is that at "
                                            "587.56 nm, 1.5168"),
    ],
)  # fmt: skip
def test_what_is_probably_not_meant_is_warned_about_once(table: dict[str, Any], text: str) -> None:
    with pytest.warns(ClrtWarning) as caught:
        clrt.load_dict(table)
    assert len(caught) == 1 and text in str(caught[0].message)


def test_good_spectra_are_not_warned_about() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", ClrtWarning)
        clrt.load_dict(RICH)
