"""`clrt validate --against`: a student's tracer, whole and with each fault, and programs that misbehave."""

from __future__ import annotations

import json
import os
import random
import shlex
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.resources import validation_module
from clrt.cli import main
from clrt.flatten.flatten import flatten
from tests import rotation
from tests.pictured import image, put

against = validation_module("suite.against")
programs = validation_module("suite.program")
scenefiles = validation_module("suite.scenefiles")
cases = validation_module("cases")
layers = validation_module("compare.layers")
STUDENT = Path(__file__).resolve().parents[1] / "student"
TRACER, SCENE = STUDENT / "tracer.py", STUDENT / "scene.toml"
COMMAND = f"{shlex.quote(sys.executable)} {shlex.quote(str(TRACER))} {{scene.toml}} "

# fault of tests/student/tracer.py -> the cause that has to come first, and the case that shows it ("": SCENE)
NAMED = {
    "no shadows": ("shadows missing", ""),
    "normals inwards": ("the lights on every sphere missing", "diffuse"),
    "falloff by the distance": ("falloff by the distance", ""),
    "no falloff": ("falloff of lights", ""),
    "refraction inverted": ("ior inverted", ""),
    "no refraction": ("no refraction", ""),
    "gamma applied": ("sRGB applied twice", ""),
    "upside down": ("vertical flip", ""),
    "mirrored": ("horizontal flip", ""),
    "turned": ("rotation by 180 degrees", ""),
    "wrong fov axis": ("fov axis", ""),
    "fov not halved": ("fov doubled", ""),
    "no specular": ("highlights missing", ""),
    "wrong exponent": ("shininess 2 times", ""),
    "depth off by one": ("max_depth 3", ""),
    "ambient missing": ("ambient light missing", ""),
    "ambient twice": ("ambient light times 2", ""),
    "second light lost": ("light 2 of 2 (direction 1, -1.5, -1) missing", ""),
    "no reflection": ("reflections missing", ""),
    "no transmission": ("transmission missing", ""),
    "pixel corners": ("shift by 0.5 pixel right and 0.5 pixel down", ""),
    "channels swapped": ("red and blue swapped", ""),
    "background black": ("background missing", ""),
    "emission missing": ("emission missing", ""),
    "too dark": ("exposure factor 0.5", ""),
    "a shape is lost": ("shape 3 (sphere) missing", ""),
}
ALL = os.environ.get("CLRT_FAULTS") == "all"
DRAWN = [*NAMED] if ALL else random.Random(rotation.seed()).sample([*NAMED], 5)
"""Five of them, others after a change of the code: each takes a search. `make release` judges all."""
IN_8_BITS = ["no shadows", "no specular", "upside down", "ambient missing"]


def judge(command: str, case: str = "", **options: Any) -> Any:
    """Judged with all the time that a search for causes takes where kernels are compiled on the way."""
    name = case or cases.own_case(str(SCENE))
    return against.judge_case(against.Task(name, programs.parse(command), **{"seconds": 200.0, **options}))


def test_the_table_has_every_fault() -> None:
    sys.path.insert(0, str(STUDENT))
    try:
        import tracer
    finally:
        sys.path.remove(str(STUDENT))
    assert set(tracer.FAULTS) == set(NAMED) and len(NAMED) >= 20


@pytest.mark.parametrize("out", ["{out.exr}", "{out.png}"])
def test_a_right_tracer_passes(out: str) -> None:
    for case in ("", "diffuse", "highlight", "mirror"):
        found = judge(COMMAND + out, case)
        assert found.passed and found.result.causes == (), case
    (_, comparison) = found.result.results["oracle64"]
    names = {gate.name for gate in comparison.gates}
    assert ("within 1.5 steps of 255" in names) == (out == "{out.png}")
    assert ("within 1e-4" in names) == (out == "{out.exr}")


@pytest.mark.slow
@pytest.mark.parametrize("fault", DRAWN)
def test_each_fault_is_named(fault: str) -> None:
    cause, case = NAMED[fault]
    found = judge(f"{COMMAND}{{out.exr}} --fault {shlex.quote(fault)}", case)
    assert not found.passed
    first = found.result.causes[0]
    assert (first.name, first.proven) == (cause, True), [c.name for c in found.result.causes]


@pytest.mark.parametrize("fault", IN_8_BITS if ALL else random.Random(rotation.seed()).sample(IN_8_BITS, 1))
def test_faults_are_named_in_pictures_of_8_bits_too(fault: str) -> None:
    found = judge(f"{COMMAND}{{out.png}} --fault {shlex.quote(fault)}")
    assert not found.passed and found.result.causes[0].name == NAMED[fault][0]


def run(*arguments: str, capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    code = main(["validate", *arguments])
    said = capsys.readouterr()
    return code, said.out, said.err


def test_the_command_says_what_to_mend(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    chosen = [word for name in ("diffuse", "highlight", "directional light", "checkered plane", "ambient")
              for word in ("--case", name)]  # fmt: skip
    report = tmp_path / "out.html"
    code, out, _ = run("--against", f"{COMMAND}{{out.exr}} --fault 'no specular'", *chosen,
                       "--report", str(report), capsys=capsys)  # fmt: skip
    assert code == 1
    assert "wrong highlight: " in out and "cause: highlights missing" in out and "wrong diffuse" not in out
    assert "no picture checkered plane: exit code 1: TypeError" in out
    assert "highlights missing: there is nothing of highlights (2 of the 2 wrong)" in out
    assert "all pictures with highlight are wrong (2 of the 2 wrong)" in out
    assert out.rstrip().endswith("2 of 4 pictures are right; 1 cases gave none")
    page, data = report.read_text(), json.loads(report.with_suffix(".json").read_text())
    assert "highlights missing" in page and "3 of 5 pictures differ from the reference" in page
    assert data["passed"] is False and "no specular" in data["subject"]
    by_name = {case["name"]: case for case in data["cases"]}
    assert by_name["highlight"]["causes"][0]["name"] == "highlights missing"
    xml = report.with_suffix(".xml").read_text()
    assert xml.count("<failure") == 3 and "<skipped" not in xml


def test_only_features_that_a_case_was_measured_to_show_are_suspected() -> None:
    """Of somebody's own scene, which nobody measured, all that it has."""
    def judged(passed: bool, features: set[str], shows: set[str]) -> Any:
        case = SimpleNamespace(features=frozenset(features), shows=frozenset(shows))
        return SimpleNamespace(passed=passed, result=SimpleNamespace(case=case, results={"oracle64": None}))

    right = judged(True, {"sphere", "mirror"}, {"sphere"})
    assert against.suspects([right, judged(False, {"sphere", "mirror", "sky"}, {"sphere", "mirror"})]) == [
        ("mirror", 1)
    ]
    assert against.suspects([right, judged(False, {"sphere", "sky"}, set())]) == [("sky", 1)]


def test_its_own_scene_and_a_right_program(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = run(str(SCENE), "--against", COMMAND + "{out.exr}", capsys=capsys)
    assert code == 0 and out == "1 of 1 pictures are right\n"
    code, out, _ = run(str(SCENE), "--against", COMMAND + "{out.exr}", "--json", capsys=capsys)
    found = json.loads(out)
    assert code == 0 and found["passed"] and len(found["cases"]) == 1


@pytest.mark.parametrize(("command", "says"), [
    ("", "'' is empty; it must not be"), ("ls '", "No closing quotation"),
    ("no-such-program {scene.toml} {out.exr}", "'no-such-program': there is no such program"),
    ("ls {scene.toml}", "names no place for the picture, such as {out.exr}"),
    ("ls {out.exr}", "names no place for the scene, such as {scene.toml}"),
    ("ls {scene.toml} {scene.json} {out.exr}", "names more than one kind of place for the scene"),
    ("ls {scene.txt} {out.exr}", "'{scene.txt}' stands for nothing; there are {scene.toml}"),
    ("ls {scene.toml} {out.jpg}", "'{out.jpg}' stands for nothing"),
])  # fmt: skip
def test_commands_that_cannot_be_run(command: str, says: str, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run("--against", command, capsys=capsys)
    assert code == 2 and out == "" and says in err and err.count("\n") == 1


def test_bytes_that_are_cut_off_are_right(tmp_path: Path) -> None:
    """int(255.999 v), as many a first ray tracer has it, of a program that is right in all else."""
    script = tmp_path / "cut.py"
    script.write_text(
        "import sys, runpy, numpy as np, OpenImageIO as oiio\n"
        f"sys.argv = [{str(TRACER)!r}, sys.argv[1], 'a.exr']\nout = sys.orig_argv[-1]\n"
        f"runpy.run_path({str(TRACER)!r}, run_name='__main__')\n"
        "v = np.clip(oiio.ImageBuf('a.exr').get_pixels(oiio.FLOAT)[..., :3].astype(float), 0, 1)\n"
        "v = np.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)\n"
        "b = oiio.ImageBuf(oiio.ImageSpec(v.shape[1], v.shape[0], 3, 'uint8'))\n"
        "b.set_pixels(oiio.ROI(), (255.999 * v).astype(np.uint8)); b.write(out)\n"
    )
    command = f"{shlex.quote(sys.executable)} {shlex.quote(str(script))} {{scene.toml}} {{out.png}}"
    for case in ("", "diffuse"):
        found = judge(command, case)
        assert found.passed, [gate for gate in found.result.results["oracle64"][1].gates if not gate.passed]


def test_floats_of_16_bits_are_right(tmp_path: Path) -> None:
    """As most programs write .exr; but not what is wrong by a hundredth."""
    script = tmp_path / "half.py"
    script.write_text(
        "import sys, runpy, numpy as np, OpenImageIO as oiio\n"
        "out, factor = sys.argv[2], float(sys.argv[3])\n"
        f"sys.argv = [{str(TRACER)!r}, sys.argv[1], 'whole.exr']\n"
        f"runpy.run_path({str(TRACER)!r}, run_name='__main__')\n"
        "v = oiio.ImageBuf('whole.exr').get_pixels(oiio.FLOAT)[..., :3]\n"
        "b = oiio.ImageBuf(oiio.ImageSpec(v.shape[1], v.shape[0], 3, 'half'))\n"
        "b.set_pixels(oiio.ROI(), v * np.float32(factor)); b.write(out, 'half')\n"
    )
    command = f"{shlex.quote(sys.executable)} {shlex.quote(str(script))} {{scene.toml}} {{out.exr}}"
    for case in ("", "diffuse"):
        found = judge(f"{command} 1", case)
        assert found.passed, [gate for gate in found.result.results["oracle64"][1].gates if not gate.passed]
    assert not judge(f"{command} 0.99", "diffuse", seconds=0.0).passed


@pytest.mark.parametrize("compression", ["dwaa", "b44"])
def test_what_a_lossy_exr_loses_is_no_fault(
    tmp_path: Path, compression: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nor are a hundredth too little light, and a picture that is pressed too hard, right."""
    script = tmp_path / "lossy.py"
    script.write_text(
        "import sys, clrt, numpy as np\n"
        "from clrt.images.file import write\n"
        "image = clrt.render(sys.argv[1], layers=['depth', 'diffuse'])\n"
        "of = lambda a: (np.atleast_3d(a) * np.float32(sys.argv[3])).astype(np.float16)\n"
        "names = ('R', 'G', 'B', 'depth.V', 'diffuse.R', 'diffuse.G', 'diffuse.B')\n"
        "parts = [of(image.pixels), np.atleast_3d(image.layers['depth']).astype(np.float16)]\n"
        "parts += [of(image.layers['diffuse'])]\n"
        "write(sys.argv[2], parts, names, {'compression': sys.argv[4]})\n"
    )
    command = f"{shlex.quote(sys.executable)} {shlex.quote(str(script))} {{scene.toml}} {{out.exr}}"
    for case in ("diffuse", "fresnel"):
        found = judge(f"{command} 1 {compression}", case)
        assert found.passed, [gate for gate in found.result.results["oracle64"][1].gates if not gate.passed]
    (note,) = against.told([found])
    assert f"its pictures are an EXR of the compression {compression}, which loses" in note
    assert note in against.suite_result([found], programs.parse(command), "", 0.0).notes
    assert not judge(f"{command} 0.97 {compression}", "diffuse", seconds=0.0).passed
    hard = judge(f"{command} 1 dwaa:500", "fresnel", seconds=0.0)
    assert not hard.passed and not hard.result.causes and hard.told
    main(["validate", "--case", "diffuse", "--against", f"{command} 1 {compression}"])
    assert "note: its pictures are an EXR" in capsys.readouterr().out


@pytest.mark.parametrize(("layer", "channel", "factor", "right"), [
    ("depth", "V", 1, True), ("depth", "Z", 1, True), ("z", "Z", 1, True), ("z", "V", 1, False),
    ("z", "Z", 1.01, False), ("depth", "Z", 1.01, False),
])  # fmt: skip
def test_depth_may_be_along_the_rays_or_planar(
    tmp_path: Path, layer: str, channel: str, factor: float, right: bool
) -> None:
    """Of `depth.Z`, which compositors take for planar; `depth.V` is clrt's own name of the other."""
    script = tmp_path / "deep.py"
    script.write_text(
        "import sys, clrt, numpy as np\n"
        "from clrt.images.file import write\n"
        f"image = clrt.render(sys.argv[1], layers=['{layer}'])\n"
        f"deep = np.atleast_3d(image.layers['{layer}']).astype(np.float32) * np.float32({factor})\n"
        f"write(sys.argv[2], [image.pixels, deep], ('R', 'G', 'B', 'depth.{channel}'))\n"
    )
    command = f"{shlex.quote(sys.executable)} {shlex.quote(str(script))} {{scene.toml}} {{out.exr}}"
    assert judge(command, "diffuse", seconds=0.0).passed == right


@pytest.mark.parametrize(("miss", "met", "right"), [
    ("0", "1", True), ("1e10", "1", True), ("-1", "1", True), ("9.0", "1", False), ("0", "0", False),
])  # fmt: skip
def test_where_a_ray_meets_nothing_others_have_other_depths(
    tmp_path: Path, miss: str, met: str, right: bool
) -> None:
    """Blender 1e10, Mitsuba 0; where something is met, 0 is wrong. The case "background" has both."""
    script = tmp_path / "deep.py"
    script.write_text(
        "import sys, clrt, numpy as np\n"
        "from clrt.images.file import write\n"
        "image = clrt.render(sys.argv[1], layers=['z'])\n"
        "z = image.layers['z']\n"
        "assert np.isinf(z).any() and np.isfinite(z).any()\n"
        f"deep = np.where(np.isinf(z), {miss}, z * {met}).astype(np.float32)[..., None]\n"
        "write(sys.argv[2], [image.pixels, deep], ('R', 'G', 'B', 'depth.Z'))\n"
    )
    command = f"{shlex.quote(sys.executable)} {shlex.quote(str(script))} {{scene.toml}} {{out.exr}}"
    found = judge(command, "background", seconds=0.0)
    assert found.passed == right and not found.result.unproven


def test_pictures_of_a_scene_are_laid_beside_it(tmp_path: Path) -> None:
    """A program gets what it reads by the names that the scene has for them, in folders, too."""
    (tmp_path / "own" / "in").mkdir(parents=True)
    put(tmp_path / "own" / "in" / "a.exr", np.full((2, 2, 3), 0.5))
    looks = {"color": image("in/a.exr"), "normal_map": {"file": "in/a.exr"}}
    table = {"camera": {"origin": [0, 0, 5], "target": [0, 0, 0]},
             "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": looks}]}  # fmt: skip
    scene = clrt.load_dict(table, folder=tmp_path / "own")
    for kind in (".toml", ".json"):
        (folder := tmp_path / kind[1:]).mkdir()
        scenefiles.write_scene(scene, folder / f"scene{kind}")
        assert flatten(clrt.load(folder / f"scene{kind}")).hash == flatten(scene).hash


def test_nothing_asked_is_nothing_passed(capsys: pytest.CaptureFixture[str]) -> None:
    """No case can be written as the program takes it: the exit code, and what other programs are told."""
    command = "true {scene.nff} {out.exr}"
    code, out, _ = run("--against", command, "--case", "ambient", "--json", capsys=capsys)
    found = json.loads(out)
    assert (code, found["passed"], found["cases"]) == (1, False, [])


def test_options_that_do_not_go_together(capsys: pytest.CaptureFixture[str]) -> None:
    command = COMMAND + "{out.exr}"
    assert "--mutants is of clrt's own" in run("--against", command, "--mutants", capsys=capsys)[2]
    assert "--timeout: 0.0 is not allowed" in run("--against", command, "--timeout", "0", capsys=capsys)[2]
    assert (
        "no-such.toml: there is no such file" in run("no-such.toml", "--against", command, capsys=capsys)[2]
    )


def rendered(code: str, tmp_path: Path, timeout: float = 20.0, out: str = "{out.exr}") -> Any:
    """What a Python program makes of a small scene."""
    script = tmp_path / "program.py"
    script.write_text("import os, sys, time, subprocess\nscene, out = sys.argv[1:3]\n" + code)
    command = f"{shlex.quote(sys.executable)} {shlex.quote(str(script))} {{scene.toml}} {out}"
    return programs.parse(command, timeout).render(clrt.load(SCENE).override(width=8, height=6))


@pytest.mark.parametrize(("code", "says"), [
    ("sys.exit('lost\\nmy way')", "exit code 1: my way"), ("pass", "wrote no picture to {out.exr}"),
    ("os.kill(os.getpid(), 11)", "ended by SIGSEGV"),
    ("os.kill(os.getpid(), 40)", "ended by signal 40"),
    ("open(out, 'w').write('hello')", "out.exr: not an EXR"),
    ("os.mkfifo(out)", "out.exr: cannot be read"),
    ("os.mkdir(out)", "out.exr: cannot be read"),
    ("os.symlink('/dev/zero', out)", "a device"),
    ("[os.remove(f) or os.mkdir(f) for f in os.listdir('.') if f[0] == '.']; sys.exit(3)", "exit code 3"),
    ("[os.mkdir('d' * 100) or os.chdir('d' * 100) for _ in range(1500)]", "wrote no picture"),
    ("sys.stderr.write('\\x1b[31mred\\x1b' + 'x' * 10**6); sys.exit(3)", "exit code 3"),
])  # fmt: skip
def test_what_a_program_does_wrong_is_one_line(code: str, says: str, tmp_path: Path) -> None:
    found = rendered(code, tmp_path)
    assert found.pixels is None and "\n" not in found.failure and "\x1b" not in found.failure
    assert len(found.failure) < 1200
    if "cannot be read" in says or "a device" in says:
        assert found.failure.startswith("out.exr: "), found.failure
    else:
        assert says in found.failure


def test_a_program_that_hangs_is_ended_with_all_it_started(tmp_path: Path) -> None:
    child = tmp_path / "child.pid"
    code = (f"p = subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(600)'])\n"
            f"open({str(child)!r}, 'w').write(str(p.pid))\ntime.sleep(600)")  # fmt: skip
    start = time.monotonic()
    found = rendered(code, tmp_path, timeout=3.0)
    assert found.failure == "had not ended after 3 s" and time.monotonic() - start < 20
    assert gone(int(child.read_text()))


@pytest.mark.parametrize("more", ["", ", start_new_session=True"], ids=["in the group", "in one of its own"])
def test_what_a_program_leaves_running_is_ended_too(tmp_path: Path, more: str) -> None:
    if more and sys.platform != "linux":
        pytest.skip("elsewhere nobody can be asked whose environment a process has")
    child = tmp_path / "child.pid"
    code = (f"p = subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(600)']{more})\n"
            f"open({str(child)!r}, 'w').write(str(p.pid))")  # fmt: skip
    assert rendered(code, tmp_path).failure == "wrote no picture to {out.exr}"
    assert gone(int(child.read_text()))


def gone(pid: int) -> bool:
    for _ in range(200):
        state = subprocess.run(["ps", "-o", "stat=", "-p", str(pid)], capture_output=True, text=True).stdout
        if not state.strip() or state.startswith("Z"):
            return True
        time.sleep(0.05)
    return False


def test_no_shell_sees_the_command_and_its_folder_is_removed(tmp_path: Path) -> None:
    code = (
        "print(repr(sys.argv[3:]), os.getcwd(), os.environ['TMPDIR'], sorted(os.listdir('.')))\nsys.exit(1)"
    )
    found = rendered(code, tmp_path, out="{out.exr} '$HOME;ls>x' `id` {width} {height} {spp} {depth}")
    words, _, rest = found.failure.removeprefix("exit code 1: ").partition("] ")
    assert words == "['$HOME;ls>x', '`id`', '8', '6', '1', '4'"
    cwd, tmp, listing = rest.split(" ", 2)
    assert cwd == tmp and not os.path.exists(cwd) and listing == "['scene.toml']"


def test_a_file_larger_than_what_is_read_cannot_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(programs, "Limits", lambda: clrt.Limits(file_bytes=1 << 16))
    code = "import signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
    code += "time.sleep(0.5)\nopen(out, 'wb').write(bytes(1 << 20))"
    found = rendered(code, tmp_path)
    assert "File too large" in found.failure


def test_files_from_where_the_user_is_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "my.py").write_text("x")
    monkeypatch.chdir(tmp_path)
    program = programs.parse(f"{sys.executable} my.py other.py {{scene.toml}} {{out.exr}}")
    assert program.arguments[1:3] == (str(tmp_path / "my.py"), "other.py")


def test_an_nff_is_handed_on_in_the_size_that_is_asked_for(tmp_path: Path) -> None:
    text = (
        "b 0.1 0.2 0.4\nv\nfrom 0 -5 1\nat 0 0 0\nup 0 0 1\nangle 40\nhither 1\nresolution 64 48\n"
        "l 3 -4 5\nf 0.8 0.4 0.2 0.7 0 20 0 1\ns 0 0 0 1\n"
    )
    (tmp_path / "ball.nff").write_text(text)
    script = tmp_path / "program.py"
    script.write_text(
        "import sys, clrt\nassert 'resolution 160 120' in open(sys.argv[1]).read()\n"
        "clrt.render(clrt.load(sys.argv[1])).save(sys.argv[2])\n"
    )
    command = f"{shlex.quote(sys.executable)} {shlex.quote(str(script))} {{scene.nff}} {{out.exr}}"
    found = judge(command, cases.own_case(str(tmp_path / "ball.nff")))
    assert found.passed, found.result.unproven
    assert "ambient: NFF has no words for" in judge(command, "diffuse").left_out
    assert main(["convert", str(tmp_path / "ball.nff"), str(tmp_path / "ball.toml")]) == 0
    found = judge(command, cases.own_case(str(tmp_path / "ball.toml")))
    assert found.passed and not found.left_out, "an .nff is written of what it can say"


def test_layers_tell_more(tmp_path: Path) -> None:
    """A picture that is right, of which a layer is not: only its term is blamed."""
    script = tmp_path / "program.py"
    script.write_text(
        "import sys, clrt, numpy as np\n"
        "image = clrt.render(clrt.load(sys.argv[1]), layers=['diffuse', 'highlight', 'depth', 'shape'])\n"
        "layers = dict(image.layers)\n"
        "if len(sys.argv) > 3: layers[sys.argv[3]] = layers[sys.argv[3]] * np.float32(1.01)\n"
        "clrt.Image(image.pixels, layers).save(sys.argv[2])\n"
    )
    command = f"{shlex.quote(sys.executable)} {shlex.quote(str(script))} {{scene.toml}} {{out.exr}}"
    found = judge(command, "highlight")
    assert found.passed
    metrics = found.result.results["oracle64"][1].metrics
    assert metrics["generation 0 camera diffuse: largest"] < 1e-4 and metrics["another shape"] == 0
    for layer, blamed in (
        ("diffuse", "generation 0, camera, diffuse"),
        ("depth", "generation 0, camera, geometry"),
    ):
        wrong = judge(f"{command} {layer}", "highlight")
        assert not wrong.passed and wrong.result.results["oracle64"][1].worst == blamed


def test_layers_are_read_within_limits(tmp_path: Path) -> None:
    depth = np.full((4, 6), 2, np.float32)
    file = clrt.Image(
        np.ones((4, 6, 3), np.float32), {"depth": depth, "normal": np.zeros((4, 6, 3), np.float32)}
    )
    saved = file.save(tmp_path / "a.exr")
    found = layers.read_layers(saved, clrt.Limits())
    assert set(found) == {"depth"} and (found["depth"] == 2).all()
    with pytest.raises(clrt.LimitError, match="image_bytes"):
        layers.read_layers(saved, clrt.Limits(image_bytes=100))
    plain = clrt.Image(np.ones((4, 6, 3), np.float32)).save(tmp_path / "b.exr")
    assert layers.read_layers(plain, clrt.Limits()) == {}


def test_only_clrts_own_formats_say_where_more_samples_are_taken() -> None:
    scene = clrt.load(SCENE).replace({"adaptive": {"spp": 16}})
    for suffix in (".toml", ".json", ".xml", ".pov", ".nff"):
        program = programs.parse(f"true {{scene{suffix}}} {{out.exr}}")
        assert ("adaptive: " in program.unable(scene)) == (suffix not in (".toml", ".json")), suffix
