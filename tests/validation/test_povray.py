"""POV-Ray as an oracle: it agrees where it can express a scene, says where it cannot, and is missed aloud."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
import pytest

import clrt
import compare_samples as samples
import pov_files
from clrt.base.resources import validation_module
from clrt.cli import main

cases = validation_module("cases")
client = validation_module("oracle_povray.client")
compare = validation_module("compare.oracle")
oracles = validation_module("oracles")
reference_of = validation_module("compare.reference").reference_of
pov = validation_module("oracle_povray.scene")
suite = validation_module("suite.run")
types = validation_module("types")
worker = validation_module("suite.worker")

pytestmark = pytest.mark.filterwarnings("ignore::clrt.base.errors.ClrtWarning")
PUBLISHED = ("balls_c_s4", "mount_c_s6", "teapot_c_s12", "tetra_c_s6", "tree_c_s11")
NAMES = (
    "ambient", "emission", "diffuse", "broad highlight", "flat highlight", "mirror", "tinted mirror",
    "transmission", "tinted transmission", "both", "inverse square", "directional light", "five lights",
    "bubble, constant", "orthographic", "shifted camera", "mirrored camera",
)  # fmt: skip


@pytest.fixture(scope="module", autouse=True)
def povray() -> None:
    """Where it cannot run its tests fail: what they prove is not proven."""
    if client.missing():
        pytest.fail(f"nothing is proven: {client.missing()}")


def expressible() -> list[str]:
    found = [name for name in cases.matrix_cases() if "povray" in cases.case_named(name).oracles]
    return [name for name in found if oracles.able("povray", cases.case_named(name))]


def test_it_can_express_enough() -> None:
    able = expressible()
    assert len(able) >= 18
    features = {feature for name in able for feature in cases.case_named(name).features}
    assert {"sphere", "plane", "diffuse", "highlight", "mirror", "transmission", "shadows", "inverse square",
            "directional light"} <= features  # fmt: skip


@pytest.mark.parametrize("name", [name for name in NAMES if name in expressible()])
def test_it_agrees(name: str) -> None:
    found = worker.run_case(worker.Task(name, ("povray",)))
    assert found.passed, found.results["povray"][1].gates
    assert found.results["povray"][1].metrics["within 1e-4"] >= 0.999


@pytest.mark.parametrize("shape", [
    {"type": "box", "min": [-1, -1, -1], "max": [1, 0.6, 1]},
    {"type": "disk", "center": [0, 0, 0], "normal": [0.3, 0.2, 1], "radius": 1.2},
    {"type": "ellipsoid", "center": [0, 0, 0], "radii": [1.3, 0.7, 1]},
    {"type": "cylinder", "p0": [-1, -0.5, 0], "p1": [0.8, 0.7, 0.3], "radius": 0.6, "caps": True},
    {"type": "cone", "p0": [-1, -0.5, 0], "r0": 0.9, "p1": [0.8, 0.7, 0.3], "r1": 0.2},
    {"type": "polygon", "points": [[-1, -1, 0], [1, -1, 0], [0.2, 0, 0], [1, 1, 0], [-1, 1, 0]]},
    {"type": "quadric", "coefficients": [1, 0.5, 1, 0.2, 0, 0.1, 0, 0.1, 0, -0.8],
     "clip": [[-2, -1, -2], [2, 0.7, 2]]},
    {"type": "mesh", "vertices": [[-1, -1, 0], [1, -1, 0.4], [0, 1, 0.2]], "faces": [[0, 1, 2]],
     "normals": [[-0.3, 0, 1], [0.3, 0.1, 1], [0, 0.3, 1]]},
], ids=lambda shape: shape["type"])  # fmt: skip
def test_it_sees_the_same_shapes(shape: dict[str, Any]) -> None:
    """Each, moved and turned, before a wall that it casts a shadow on."""
    stretched = shape["type"] not in ("disk", "cylinder", "cone")  # whose caps stay round
    scale = [1.1, 0.9, 1.2] if stretched else [1.1, 1.1, 1.1]
    moved = [{"scale": scale}, {"rotate": [[1, 0.6, 0.2], 25.0]}, {"translate": [0.2, -0.1, 0]}]
    matte = {"color": [0.7, 0.5, 0.3], "diffuse": 0.6, "specular": 0.2, "shininess": 20}
    wall = {"type": "plane", "point": [0, 0, -2], "normal": [0, 0.1, 1], "material": {"color": 0.5}}
    table = {
        "ambient": 0.2, "background": 0.3,
        "camera": {"origin": [0.5, 0.8, 6], "target": [0, 0, 0], "fov": 45, "width": 96, "height": 72},
        "lights": [{"type": "point", "position": [-3, 4, 6], "intensity": 0.6}],
        "shapes": [wall, {**shape, "material": matte, "transform": moved}],
    }  # fmt: skip
    check(table)


@pytest.mark.parametrize("camera", [
    {"type": "orthographic", "size": 5},
    {"type": "orthographic", "size": 4, "fov_axis": "vertical", "near": 1},
    {"fov": 60, "fov_axis": "vertical"}, {"mirror": True}, {"shift": [0.3, -7.25]}, {"up": [0.4, 1, 0.1]},
    {"type": "orthographic", "size": 5, "shift": [10.5, 3.25], "mirror": True},
])  # fmt: skip
def test_it_sees_from_the_same_place(camera: dict[str, Any]) -> None:
    table = {**samples.SCENE, "camera": {**samples.SCENE["camera"], **camera}}
    check({**table, "shapes": samples.SCENE["shapes"][:2]})


def check(table: dict[str, Any]) -> None:
    """A scene's picture is POV-Ray's."""
    scene = clrt.load_dict(table)
    reference = reference_of(scene)
    ours = reference.render()
    assert (
        agree(ours, client.render(scene).pixels, reference.edges(ours), compare.limits(1, many_edges=True))
        == []
    )


def agree(ours: np.ndarray, theirs: np.ndarray, edges: np.ndarray, limit: Any) -> list[str]:
    """The gates that fail."""
    images = [types.OracleImage(np.clip(image, 0, 1), {}, None, None, "", 0.0) for image in (ours, theirs)]
    found = compare.compare(*images, edges, 1, limit)
    return [f"{gate.name} {gate.value}" for gate in found.gates if not gate.passed]


def test_a_fault_fails() -> None:
    """Not all that looks alike passes: an exponent of 36 in place of 40, shadows that are 2 % too dark."""
    scene = oracles.scene_of(cases.case_named("broad highlight"))
    theirs, reference = client.render(scene).pixels, reference_of(scene)
    edges = reference.edges(reference.render())
    limit = compare.limits(1)
    assert agree(reference.render(), theirs, edges, limit) == []
    assert agree(reference.render() * 1.002, theirs, edges, limit) != []
    assert agree(reference.render(shadows=False), theirs, edges, limit) != []


@pytest.mark.shared
@pytest.mark.parametrize("name", PUBLISHED)
def test_published_scenes(name: str, shared_folder: Path, tmp_path: Path) -> None:
    """POV-Ray renders their own files; clrt what a reader of 100 lines makes of them.

    Outside edges all but 1 of 900 pixels agree within 1e-4 (most within 8e-6, a step of 16 bits). The gates
    on whole pictures are those that 160 x 160 pixels with many edges reach: PSNR 45.0 at least. Balls that
    mirror each other four times over magnify the bound by which rays leave: 2.1 % of their edges.
    """
    file = shared_folder / "data" / "pov" / f"{name}.pov"
    scene = clrt.load_dict(pov_files.scene(file, 160))
    command = ["povray", f"+I{file}", "+Oout.png", "+W160", "+H160", "+FN16", "File_Gamma=1", "-D", "-A"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    theirs = (
        np.asarray(oiio.ImageBuf(str(tmp_path / "out.png")).get_pixels(oiio.UINT16), float)[..., :3] / 65535
    )
    reference = reference_of(scene)
    ours = reference.render()
    limit = compare.Limits(
        ssim=0.998, window=None, flip=0.003, psnr=44.5, mask=0.3, fine=0.9985, coarse=0.9998, masked=0.025
    )
    assert agree(ours, theirs, reference.edges(ours), limit) == []


@pytest.mark.parametrize(("changes", "says"), [
    ({"background": "sky.png"}, "background image"), ({"ambient_samples": 4}, "ambient rays"),
    ({"spectrum": {"bands": 8}}, "light in bands"), ({"one_sided": "opaque"}, "one-sided surfaces"),
    ({"medium_ior": 1.33}, "medium around all"), ({"depth_color": 0.1}, "depth colour"),
    ({"max_depth": 256}, "so many generations"), ({"adaptive": {"threshold": 0.1}}, "adaptive samples"),
])  # fmt: skip
def test_it_says_what_it_cannot_express(changes: dict[str, Any], says: str, tmp_path: Path) -> None:
    clrt.Image(np.ones((4, 8, 3), np.float32)).save(tmp_path / "sky.png")
    scene = clrt.load_dict({**samples.SCENE, **changes}, folder=tmp_path)
    assert says in pov.not_in_pov(scene)
    with pytest.raises(clrt.ClrtError, match="POV-Ray has no"):
        pov.to_pov(scene)


@pytest.mark.parametrize(("material", "says"), [
    ({"fresnel": True}, "Fresnel terms"), ({"thin": True, "transmission": 0.5}, "straight through"),
    ({"specular": 0.2, "highlight_color": [1, 0.5, 0]}, "colour of a highlight"),
    ({"transmission": 0.5, "transmission_color": [1, 0.5, 0]}, "tint of what passes"),
    ({"transmission": 1.0, "diffuse": 0.1}, "tint of what passes"),
    ({"transmission": 0.5, "absorption": 0.1}, "media"), ({"conductor": "gold"}, "spectra"),
    ({"color": [0, 1, 1], "emission": 0.2}, "emission of a colour"),
    ({"color": {"type": "checker", "colors": [0.2, 0.7]}}, "checker"),
])  # fmt: skip
def test_it_says_which_material_it_cannot_express(material: dict[str, Any], says: str) -> None:
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": material}
    found = pov.not_in_pov(clrt.load_dict({**samples.SCENE, "shapes": [ball]}))
    assert found.startswith("shapes[0]: POV-Ray has no") and says in found


GLASS = {"diffuse": 0.0, "ior": 1.5, "reflection": 0.15, "transmission": 0.75}
BALL = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": GLASS}
BLOCK = {"type": "box", "min": [-1, -1, -1], "max": [1, 0.6, 1], "material": GLASS}


def in_glass(shape: dict[str, Any], *others: dict[str, Any], **material: Any) -> dict[str, Any]:
    """A shape of glass before a wall."""
    wall = {"type": "plane", "point": [0, 0, -2], "normal": [0, 0.1, 1], "material": {"color": 0.5}}
    return {
        "ambient": 0.2, "background": 0.3, "max_depth": 6,
        "camera": {"origin": [0.5, 2.8, 6], "target": [0, 0, 0], "fov": 30, "width": 96, "height": 72},
        "lights": [{"type": "point", "position": [-3, 4, 6], "intensity": 0.6}],
        "shapes": [wall, {**shape, "material": GLASS | material}, *others],
    }  # fmt: skip


def beside_edges(table: dict[str, Any]) -> list[str]:
    """The gates that fail, but for those on edges, of which a block of glass shows many."""
    scene = clrt.load_dict(table)
    reference = reference_of(scene)
    ours = reference.render()
    theirs, limit = client.render(scene).pixels, compare.limits(1, many_edges=True)
    return [gate for gate in agree(ours, theirs, reference.edges(ours), limit) if "edges" not in gate]


def test_it_reflects_totally_where_the_shares_are_1(monkeypatch: pytest.MonkeyPatch) -> None:
    """In a block; in a ball nothing is reflected totally that came from outside."""
    block = BLOCK | {"transform": [{"rotate": [[0.2, 1, 0.1], 25.0]}]}
    assert beside_edges(in_glass(block, reflection=0.25, transmission=0.75)) == []
    assert beside_edges(in_glass(block) | {"max_depth": 1}) == []
    check(in_glass(BALL))
    assert beside_edges(in_glass(BALL, {**BALL, "center": [0.4, 2.1, 0]})) == []
    monkeypatch.setattr(pov, "_total", lambda *_: False)
    assert beside_edges(in_glass(block)) != []


@pytest.mark.parametrize("table", [
    in_glass(BLOCK), in_glass(BLOCK, reflection=0.25, reflection_color=[1, 0.5, 1]),
    in_glass(BALL | {"transform": [{"scale": [1, 2, 1]}]}), in_glass(BALL, ior=0.8),
    in_glass(BALL | {"radius": 7}),
    in_glass(BALL, {**BALL, "center": [0, 0.5, 0], "material": {"reflection": 1}}),
    in_glass(BALL, {**BLOCK, "material": {"reflection": 1}}),
    {**in_glass(BALL), "camera": {**in_glass(BALL)["camera"], "type": "orthographic", "size": 3}},
])  # fmt: skip
def test_it_says_where_it_would_reflect_more(table: dict[str, Any]) -> None:
    found = pov.not_in_pov(clrt.load_dict(table))
    assert found.startswith("shapes[1]: POV-Ray has no total reflection of less than all: let")


@pytest.mark.parametrize("shape", [
    {"type": "cylinder", "p0": [0, 0, 0], "p1": [0, 1, 0], "radius": 1},
    {"type": "cone", "p0": [0, 0, 0], "p1": [0, 1, 0], "r0": 1, "r1": 0.5},
    {"type": "quadric", "coefficients": [1, 1, 1, 0, 0, 0, 0, 0, 0, -1], "clip": [[-2, 0, -2], [2, 2, 2]]},
])  # fmt: skip
def test_open_ends_of_glass_are_not_written(shape: dict[str, Any]) -> None:
    """There light enters glass where a ray goes in, and leaves it nowhere."""
    glass = {"diffuse": 0, "ior": 1.5, "reflection": 0.2, "transmission": 0.8}
    found = pov.not_in_pov(clrt.load_dict({**samples.SCENE, "shapes": [{**shape, "material": glass}]}))
    assert found == "shapes[0]: POV-Ray has no open ends of what light passes, as the model has them"
    dull = {"color": 0.5, "priority": 2, "absorption": 0.3}
    assert not pov.not_in_pov(clrt.load_dict({**samples.SCENE, "shapes": [{**shape, "material": dull}]}))


def test_the_command_converts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    samples.scene().save(tmp_path / "a.toml")
    assert main(["convert", str(tmp_path / "a.toml"), str(tmp_path / "a.pov")]) == 0
    text = (tmp_path / "a.pov").read_text()
    assert text == pov.to_pov(samples.scene()) and text.count("light_source") == 2
    assert main(["convert", "refraction", str(tmp_path / "b.pov")]) == 2
    said = capsys.readouterr().err
    assert "POV-Ray has no" in said and said.count("\n") == 1 and not (tmp_path / "b.pov").exists()


def test_a_program_may_be_povray_itself(capsys: pytest.CaptureFixture[str]) -> None:
    command = "povray +I{scene.pov} +O{out.png} +W{width} +H{height} +FN16 File_Gamma=srgb -D -A"
    code = main(["validate", "--against", command, "--case", "mirror", "--case", "fresnel"])
    out = capsys.readouterr().out
    assert code == 0 and "left out fresnel: it cannot be written as .pov" in out
    assert "Fresnel terms as the model has them" in out and out.endswith("1 of 1 pictures are right\n")


def test_its_absence_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(client.shutil, "which", lambda name: None)
    plan = suite.Plan(cases=("mirror",))
    assert [task.oracles for task in suite.tasks_of(plan)] == [("oracle64", "mitsuba-table", "mitsuba-bsdf")]
    assert any("POV-Ray is not installed" in note for note in suite.notes(plan, []))


def test_a_failure_is_one_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(client, "write_pov", lambda scene, path: path.write_text("sphere {"))
    with pytest.raises(client.PovrayError) as caught:
        client.render(samples.scene())
    assert "\n" not in str(caught.value) and "POV-Ray wrote no picture: " in str(caught.value)


@pytest.mark.parametrize("by", [1e-5, 1e-3, 1e4, 1e7])
@pytest.mark.parametrize("view", ["perspective", "orthographic"])
def test_scenes_of_any_size_are_written(by: float, view: str) -> None:
    """POV-Ray drops hits nearer than 1e-3 and sees no farther than 1e7: all is scaled before."""
    lights = [{"type": "point", "position": [3, 5, 4], "intensity": 40.0, "falloff": "inverse-square"},
              {"type": "directional", "direction": [1, -1.5, -1], "intensity": 0.3}]  # fmt: skip
    looks = {"perspective": {"fov": 50}, "orthographic": {"type": "orthographic", "size": 7}}[view]
    glass = {"diffuse": 0, "reflection": 0.1, "transmission": 0.9, "ior": 1.5}
    shapes = [
        {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]},
        {"type": "sphere", "center": [0.2, 0.2, 1.5], "radius": 0.7, "material": glass},
        {"type": "box", "min": [-2.5, -1, -1], "max": [-1.2, 0.5, 0.5], "transform": [{"rotate": ["y", 20]}]},
        {"type": "mesh", "vertices": [[1.5, -1, 0], [2.5, -1, 0], [2, 1, 0]], "faces": [[0, 1, 2]]},
    ]

    def scene(size: float) -> clrt.Scene:
        def moved(table: Any, keys: tuple[str, ...]) -> Any:
            return {k: (np.array(v) * size).tolist() if k in keys else v for k, v in table.items()}

        places = ("origin", "target", "size", "position", "point", "center", "radius", "min", "max",
                  "vertices")  # fmt: skip
        camera = {"origin": [0, 1, 6], "target": [0, 0, 0], "width": 60, "height": 40, **looks}
        light = {**moved(lights[0], places), "intensity": 40.0 * size**2}
        made = [moved(shape, places) for shape in shapes]
        return clrt.load_dict({"camera": moved(camera, places), "lights": [light, lights[1]], "shapes": made})

    found = client.render(scene(by)).pixels
    off = np.abs(found - np.clip(clrt.render(scene(1.0)).pixels, 0, 1)).max(axis=2)
    assert (off > 2e-3).mean() < 0.02, "edges of shadows and glass alone"
