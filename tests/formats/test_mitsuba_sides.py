"""Which side of a shape sheds light: as Mitsuba itself says, whichever way it is turned over."""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import clrt
from clrt.scene.transforms import is_similarity

STEPS = (
    "", '<scale x="-1"/>', '<scale z="-1"/>', '<scale value="-1"/>', '<scale x="0.5" y="0.5"/>',
    '<scale x="-1"/><rotate x="1" angle="180"/>', '<scale z="-3"/><rotate y="1" angle="40"/>',
)  # fmt: skip
SHAPE = """<shape type="{kind}"><transform name="to_world">{steps}<translate x="1" y="2" z="3"/></transform>
<boolean name="flip_normals" value="{flip}"/>{emitter}</shape>"""
# A point of the surface, and the direction to the side on which rays meet light there
ASKED = """
import json, sys
import mitsuba as mi
mi.set_variant("scalar_rgb")
found = []
for text in json.load(sys.stdin):
    scene = mi.load_string(text)
    shape = scene.shapes()[0]
    met = shape.sample_position(0.0, [0.3, 0.6])
    ways = {}
    for way in (met.n, -met.n):
        hit = scene.ray_intersect(mi.Ray3f(met.p + 0.01 * way, -way))
        ways[shape.emitter().eval(hit)[0] > 0] = way
    assert len(ways) == 2
    found.append([list(ways[True]), list(met.p)])
print(json.dumps(found))
"""
CASES = [
    (kind, steps, flip)
    for kind, steps, flip in itertools.product(("rectangle", "disk", "sphere"), STEPS, ("false", "true"))
    if kind != "sphere" or ("0.5" not in steps and "-3" not in steps)
]


def scene(kind: str, steps: str, flip: str, emitter: str = '<emitter type="area"/>') -> str:
    shape = SHAPE.format(kind=kind, steps=steps, flip=flip, emitter=emitter)
    return f'<scene version="3.0.0">{shape}</scene>'


@pytest.fixture(scope="module")
def theirs() -> dict[tuple[str, str, str], np.ndarray]:
    texts = json.dumps([scene(*case) for case in CASES])
    done = subprocess.run(
        [sys.executable, "-c", ASKED], input=texts, capture_output=True, text=True, check=True, timeout=300
    )
    return dict(zip(CASES, np.array(json.loads(done.stdout)), strict=True))


@pytest.mark.parametrize(("kind", "steps", "flip"), CASES)
@pytest.mark.filterwarnings("ignore::clrt.ClrtWarning")
def test_a_light_shines_to_the_side_to_which_mitsubas_does(
    tmp_path: Path, theirs: dict[tuple[str, str, str], np.ndarray], kind: str, steps: str, flip: str
) -> None:
    file = tmp_path / "s.xml"
    file.write_text(scene(kind, steps, flip))
    read = clrt.load(file)
    side, point = theirs[kind, steps, flip]
    if kind == "sphere":
        outwards = side @ (point - [1, 2, 3]) > 0
        assert [light.type for light in read.lights] == (["sphere"] if outwards else [])
        return
    (light,) = read.lights
    assert light.type == kind
    ours = np.cross(light.u, light.v) if light.type == "rectangle" else np.array(light.normal)
    assert ours / np.linalg.norm(ours) == pytest.approx(side, abs=1e-6)


@pytest.mark.parametrize(
    ("kind", "steps", "words"),
    [("sphere", '<scale z="-1"/>', "a sphere sheds inwards"), ("disk", '<scale x="2"/>', "a mesh sheds")],
)
def test_what_is_no_light_of_ours_is_named(tmp_path: Path, kind: str, steps: str, words: str) -> None:
    file = tmp_path / "s.xml"
    file.write_text(scene(kind, steps, "false"))
    with pytest.warns(clrt.ClrtWarning, match=words):
        assert not clrt.load(file).lights


@pytest.mark.parametrize(
    ("steps", "radius"),
    [('<scale x="0.5" y="0.5"/>', 0.5), ('<scale z="-2"/><rotate x="1" angle="30"/>', 1.0)],
)
@pytest.mark.filterwarnings("ignore::clrt.ClrtWarning")
def test_a_disk_that_stays_round_is_read(tmp_path: Path, steps: str, radius: float) -> None:
    """Whatever its transform does across it: "an ellipse" was said of it, in files that clrt had written."""
    file = tmp_path / "s.xml"
    file.write_text(scene("disk", steps, "false", ""))
    (disk,) = clrt.load(file).shapes
    assert disk.type == "disk" and is_similarity(disk.matrix)
    assert np.linalg.norm(disk.matrix[:3, 0]) == pytest.approx(radius)
    clrt.Tracer(clrt.load(file)).close()


@pytest.mark.parametrize(
    ("steps", "even"),
    [
        ('<scale x="1.5" y="1.5"/>', '<scale value="1.5"/>'),
        ('<scale x="-1.5" y="1.5"/>', '<scale x="-1.5" y="1.5" z="1.5"/>'),
        ('<scale z="-3"/>', '<scale z="-1"/>'),
    ],
)
@pytest.mark.filterwarnings("ignore::clrt.ClrtWarning")
def test_a_disk_that_stays_round_is_turned_about_its_normal_as_it_was(
    tmp_path: Path, steps: str, even: str
) -> None:
    """As its picture is."""
    file, turn = tmp_path / "s.xml", '<rotate z="1" angle="50"/><rotate y="1" angle="60"/>'
    found = []
    for scaled in (steps, even):
        file.write_text(scene("disk", scaled + turn, "false", ""))
        found.append(clrt.load(file).shapes[0].matrix)
    np.testing.assert_allclose(found[0], found[1], atol=1e-12)


def test_a_rotation_about_an_axis_of_another_length_is_named(tmp_path: Path) -> None:
    """Mitsuba 3 makes a shear of it."""

    def cube(step: str) -> clrt.Scene:
        shape = f'<shape type="cube"><transform name="to_world">{step}</transform></shape>'
        light = '<emitter type="constant"/>'
        (tmp_path / "a.xml").write_text(f'<scene version="3.0.0">\n{light}{shape}</scene>')
        return clrt.load(tmp_path / "a.xml")

    says = r"^a\.xml:2: a rotation about an axis of length 1\.41421: "
    with pytest.warns(clrt.ClrtWarning, match=says) as said:
        turned = cube('<rotate x="1" y="1" angle="40"/>')
    assert len(said) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        right = cube('<rotate x="0.7071" y="0.7071" angle="40"/>')
        cube('<rotate x="2" angle="0"/>')
    np.testing.assert_allclose(turned.shapes[0].matrix, right.shapes[0].matrix, atol=1e-12)
