"""A new shape or kind of primitive that somebody forgot somewhere is noticed, not drawn wrongly."""

from __future__ import annotations

import re
import typing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt import layout
from clrt.base import layers
from clrt.base.resources import kernel_folder, validation_module
from clrt.flatten import entries
from clrt.flatten import materials as flatten_materials
from clrt.flatten.flatten import flatten
from clrt.flatten.shapes import _ADD, Collected
from clrt.images import layerpicture
from clrt.scene import lights as lights_of_scenes
from clrt.scene import scene

DOCS = Path(__file__).resolve().parents[2] / "docs"
BALL = {"type": "sphere", "center": [0, 0, 0], "radius": 1}


def test_every_kind_has_a_section_of_records():
    assert set(layout.SECTIONS.values()) < set(layout.WORLD)
    assert len(set(layout.SECTIONS.values())) == len(layout.KINDS)
    assert list(layout.KINDS.values()) == list(range(len(layout.KINDS)))
    assert all(layout.WORLD[section] in layout.RECORDS for section in layout.SECTIONS.values())


def test_kernels_that_name_kinds_are_those_that_the_page_lists():
    page = (DOCS / "adding-a-primitive.md").read_text(encoding="utf-8")
    names = re.compile(rf"\b({'|'.join(layout.SECTIONS)})\b")
    files = ((file.name, re.sub("//.*", "", file.read_text())) for file in kernel_folder().glob("*.cl*"))
    found = {name for name, code in files if names.search(code)}
    assert found == {"primitives.clh", "surface.cl", "crossings.clh", "shaft.clh"}
    assert all(f"`kernels/{name}`" in page for name in found)


@pytest.mark.parametrize("table", [*entries.TABLES, "oracle64", "oracle64 pictures"])
def test_tables_of_shapes_have_every_shape(table: str):
    tables: dict[str, Any] = {
        "oracle64": set(validation_module("oracle64.primitives")._BUILDERS),
        "oracle64 pictures": set(validation_module("oracle64.images")._PLACES),
    } | {name: {kind.__name__ for kind in held} for name, held in entries.TABLES.items()}
    assert tables[table] == {kind.__name__ for kind in scene.SHAPES.values()}


@pytest.mark.parametrize("table", entries.TABLES)
def test_a_shape_that_a_table_lacks_is_no_picture(table: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.delitem(entries.TABLES[table], scene.Disk)  # type: ignore[arg-type]
    flatten(clrt.load_dict({"shapes": [BALL]}))
    disk = {"type": "disk", "center": [0, 0, 0], "normal": [0, 1, 0], "radius": 1}
    with pytest.raises(clrt.ClrtError, match=r"^shapes\[1\]: a Disk has no entry in " + table + ";"):
        flatten(clrt.load_dict({"shapes": [BALL, disk, disk]}))


def test_a_scene_may_hold_every_shape():
    assert set(typing.get_args(scene.AnyShape)) == set(scene.SHAPES.values())
    assert all(name == kind.__struct_config__.tag for name, kind in scene.SHAPES.items())


def test_tables_of_lights_have_every_light():
    lights = set(lights_of_scenes.LIGHTS.values())
    kinds = [kind for kind, _ in flatten_materials._LIGHTS.values()]
    assert lights == set(typing.get_args(scene.Light)) == set(flatten_materials._LIGHTS)
    oracle, twin = validation_module("oracle64.lights"), validation_module("twin.lights")
    assert lights == set(oracle.LIGHTS) | set(oracle.EXTENDED)
    assert sorted(kinds) == sorted(layout.LIGHT_KINDS | layout.EXTENDED_KINDS)
    assert set(layout.LIGHT_KINDS.values()) == set(twin._SAMPLES)
    assert set(layout.EXTENDED_KINDS.values()) == set(twin.EXTENDED)
    assert not set(layout.LIGHT_KINDS.values()) & set(layout.EXTENDED_KINDS.values())
    assert all(name == kind.__struct_config__.tag for name, kind in lights_of_scenes.LIGHTS.items())


def test_layers_have_pictures_and_terms():
    shown = {layer.picture for layer in layers.LAYERS.values()}
    assert shown == set(layers.PICTURES) == set(layerpicture._PICTURES) | {"none"}
    assert set(layers.TERMS) < set(layers.LAYERS)
    masks = {source.mask for layer in layers.LAYERS.values() for source in layer.sources
             if isinstance(source, layers.Paths)}  # fmt: skip
    assert masks < set(layout.PATH)


def test_a_primitive_of_an_unknown_kind_is_no_picture(monkeypatch: pytest.MonkeyPatch):
    def unknown(out: Collected, shape: Any, index: int, material: int, at: str) -> None:
        out.number_all(np.array([len(layout.KINDS)]), index, material)

    monkeypatch.setitem(_ADD, scene.Sphere, unknown)
    with pytest.raises(AssertionError, match=r"not in layout\.SECTIONS"):
        flatten(clrt.load_dict({"shapes": [BALL]}))


def test_a_primitive_without_its_record_is_no_picture(monkeypatch: pytest.MonkeyPatch):
    def forgotten(out: Collected, shape: Any, index: int, material: int, at: str) -> None:
        out.number("DISK", index, material)

    monkeypatch.setitem(_ADD, scene.Sphere, forgotten)
    with pytest.raises(AssertionError, match="1 primitives DISK"):
        flatten(clrt.load_dict({"shapes": [BALL]}))


def test_the_page_names_files_that_exist():
    page = (DOCS / "adding-a-primitive.md").read_text()
    root = DOCS.parent
    named = set(re.findall(r"`((?:kernels|clrt|validation|tests)/[\w/.]+)`", page)) - {"kernels/torus.clh"}
    assert len(named) > 12
    assert not [name for name in sorted(named) if not (root / name).exists()]
    words = {"SECTIONS", "SHAPES", "_ADD", "_INSIDE", "_MAP"}
    assert set(re.findall(r"`(_?[A-Z]{2,}_?[A-Z]*)`", page)) >= words
