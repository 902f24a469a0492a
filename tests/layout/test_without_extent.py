"""Kernels for scenes without lights with extent and rough surfaces ask nothing about them; same bits."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import pytest

import clrt
from clrt.base.resources import kernel_folder
from clrt.device.device import Device
from clrt.flatten.flatten import FlatScene, flatten

ASKS = re.compile(
    r"\b(scene->(extended|rough|surfaces)|light->(extended|surface)|material->(light|alpha))\b"
)
# beside what `kernels/extent.clh` asks: what is said of a light or a surface that has them
SAYS = {
    "material->light == 2 ? (intP)(0) : (s.code & SURFACE_INSIDE) != 0",
    "append_word(to, &a, FEELER_OWN, own, (intP)(light->surface))",
    "pass_standing(&world, &s, &ray, launched, to->at, light->surface, standing, found, seen, filter)",
    "facet_at(s.n, s.ns, u, material->alpha, streams)",
}
BALL = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
FLOOR = {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]}
PLAIN: dict[str, Any] = {
    "camera": {"origin": [0, 1, 4], "target": [0, 0, 0], "width": 32, "height": 24},
    "max_depth": 3,
    "lights": [
        {"type": "point", "position": [3, 5, 4]},
        {"type": "spot", "position": [0, 4, 2], "target": [0, 0, 0], "angle": 30},
    ],
    "shapes": [{**BALL, "material": {"reflection": 0.6}}, FLOOR],
}  # fmt: skip
AREA = {"type": "rectangle", "center": [0, 4, 0], "u": [1, 0, 0], "v": [0, 0, 1], "radiance": 5, "samples": 4}
HAVE: dict[str, dict[str, Any]] = {
    "light": {"lights": [{**AREA, "visible": False}]},
    "seen light": {"lights": [AREA]},
    "rough": {"shapes": [{**BALL, "material": {"reflection": 0.6, "roughness": 0.3}}, FLOOR]},
}  # fmt: skip


def test_no_line_asks_but_through_the_constant() -> None:
    found = set()
    for path in kernel_folder().glob("*.cl*"):
        text = re.sub(r"//.*", "", path.read_text("utf-8"))
        if path.name != "extent.clh":
            for said in SAYS:
                found |= {said} if said in text else set()
                text = text.replace(said, "")
        asked = [line for line in text.splitlines() if ASKS.search(line) and "(EXTENT" not in line]
        assert not asked, (path.name, asked)
    assert found == SAYS


@pytest.mark.parametrize("what", HAVE)
def test_what_has_some_has_another_program_and_needs_it(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    plain, scene = clrt.load_dict(PLAIN), clrt.load_dict({**PLAIN, **HAVE[what]})
    assert not flatten(plain).ray_format.extent
    assert flatten(scene).ray_format.extent
    right = clrt.render(scene).hash
    monkeypatch.setattr(FlatScene, "ray_format", flatten(plain).ray_format)
    assert clrt.Tracer(scene).render().hash != right


def test_scenes_without_have_the_bits_of_kernels_that_ask(tmp_path: Path) -> None:
    kernels = tmp_path / "kernels"
    shutil.copytree(kernel_folder(), kernels)
    for path in kernels.glob("*.cl*"):
        path.write_text(re.sub(r"\bEXTENT\b", "1", path.read_text("utf-8")), "utf-8")
    scene = clrt.load_dict(PLAIN)
    asking = clrt.Tracer(scene, Device(kernels=kernels))
    assert asking.device.kernels.source != clrt.Tracer(scene).device.kernels.source
    assert asking.render().hash == clrt.render(scene).hash


def test_a_scene_that_gets_some_is_rendered_by_the_other_program() -> None:
    plain, rough = clrt.load_dict(PLAIN), clrt.load_dict({**PLAIN, **HAVE["rough"]})
    with clrt.Tracer(plain) as tracer:
        hashes = [tracer.render().hash]
        for scene in (rough, plain):
            tracer.update(scene)
            hashes.append(tracer.render().hash)
    assert hashes == [clrt.render(scene).hash for scene in (plain, rough, plain)]
