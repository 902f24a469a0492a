"""Planted miscompiles: the self-test blames the right kernel, and leaves a program that shows it."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import clrt
from clrt.base.resources import kernel_folder, validation_module
from clrt.cli import main
from clrt.device.device import Device

blame = validation_module("conformance.blame")
bundle = validation_module("conformance.bundle")
selftest = validation_module("selftest")
scenes = validation_module("twin.scenes").scenes()
ROOT = Path(__file__).resolve().parents[2]

# file, what stands there, what takes its place; the kernel that is then wrong, the parameter that shows it
PLANTED = {
    "a camera ray": ("generate.cl", "2.0f * y / (float)camera.height", "1.999f * y / (float)camera.height",
                     "generate", "rays"),
    "a sphere": ("sphere.clh", "radius2 = radius * radius", "radius2 = radius * radius * 1.00001f",
                 "closest", "hit_t"),
    "a normal": ("surface.clh", "choose(at.outward, minus(at.outward), inside)", "at.outward",
                 "surface", "surfaces"),
    "a shadow": ("trace.cl", "((primitive) < 0)", "((primitive) == (primitive))", "occluded", "seen"),
    "a cosine": ("light.clh", "material->kd * cosine", "material->kd * 0.999f * cosine",
                 "illuminate", "local_radiance"),
    "ambient light": ("light.cl", "select(material->ka * colors", "select(material->ka * 1.001f * colors",
                      "shade", "local_radiance"),
    "a mirror": ("bounce.clh", "times(n, 2.0f * dot3(n, u))", "times(n, 1.9999f * dot3(n, u))",
                 "reflect", "child_rays"),
    "a mean": ("film.cl", "= film[i] / samples;", "= film[i] / (samples + 0.001f);", "resolve", "film"),
    # what a driver may do that contracts a product and a sum although the pragma forbids it
    "contraction": ("math.clh", "return a.x * b.x + a.y * b.y + a.z * b.z;",
                    "return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z));", "generate", "rays"),
}  # fmt: skip
RUN = {"a camera ray", "a shadow", "contraction"}  # whose programs run: each compiles all kernels


def planted(name: str, folder: Path) -> Device:
    """A device whose kernels have the fault."""
    file, old, new, *_ = PLANTED[name]
    copied = folder / "kernels"
    shutil.copytree(kernel_folder(), copied)
    text = (copied / file).read_text()
    assert text.count(old) == 1, f"{name}: the place of the planted fault has changed"
    (copied / file).write_text(text.replace(old, new))
    return Device(kernels=copied)


def first_fault(device: Device) -> Any:
    for seed, name in enumerate(("spheres", "inside glass")):
        found = blame.blame(device, *scenes[name], seed)
        if found:
            return found
    return None


def reproduce(place: Path) -> subprocess.CompletedProcess[str]:
    """Run the program elsewhere, with nothing of clrt to be found."""
    bare = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return subprocess.run([sys.executable, "-P", str(place / "reproduce.py")], cwd="/", env=bare,
                          capture_output=True, text=True, timeout=300)  # fmt: skip


@pytest.mark.parametrize("name", PLANTED)
def test_the_right_kernel_is_blamed_and_a_program_shows_it(name: str, tmp_path: Path, hasty: None) -> None:
    device = planted(name, tmp_path)
    fault = first_fault(device)
    assert fault is not None
    *_, kernel, parameter = PLANTED[name]
    assert (fault.kernel, fault.launch.names[fault.argument]) == (kernel, parameter)
    assert fault.expected != fault.found == fault.launch.after[fault.argument][fault.word]
    place = bundle.write_bundle(tmp_path, name, "differs", device, fault)
    report = json.loads((place / "report.json").read_text())
    assert report["kernel"] == kernel and report["argument"] == parameter
    assert report["shown by reproduce.py"] is True
    assert report["build options"].startswith("-cl-std=CL1.2") and "-I" not in report["build options"]
    assert report["driver"] and report["device"] == device.info.label
    item, items = report["first work-item"], report["work-items"]
    assert item is None or 0 <= item < items
    if name in RUN:
        ran = reproduce(place)
        assert ran.returncode == 1, ran.stdout + ran.stderr
        assert f"found {fault.found:#010x}, expected {fault.expected:#010x}" in ran.stdout


def test_the_program_passes_where_the_kernels_are_right(tmp_path: Path) -> None:
    """What it shows is the fault, not its own mistake: the right kernels give the expected bits."""
    device = planted("a sphere", tmp_path)
    fault = first_fault(device)
    place = bundle.write_bundle(tmp_path, "a sphere", "differs", device, fault)
    right = Device().variant(scenes["spheres"][1].ray_format)
    (place / "kernels.cl").write_text(right.kernels.source)
    ran = reproduce(place)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    lines = (place / "reproduce.py").read_text().splitlines()
    assert len(lines) <= 30 and max(map(len, lines)) <= 200
    assert not any("clrt" in line for line in lines if line.startswith(("import", "from")))


def test_the_work_item_is_the_one_that_wrote_it(tmp_path: Path) -> None:
    device = planted("a sphere", tmp_path)
    fault = first_fault(device)
    item = bundle.first_item(device, fault)
    assert item == fault.word // device.packet, "a packet of rays is one work-item, and each has one hit_t"
    local = fault.launch.local
    assert bundle.replayed(device, fault, item + local) == fault.found
    if item:
        before = int(fault.launch.before[fault.argument][fault.word])
        assert bundle.replayed(device, fault, item) == before


def test_nothing_is_blamed_where_all_is_right() -> None:
    device = Device()
    assert blame.blame(device, *scenes["spheres"], 0) is None
    faults: list[Any] = []
    assert selftest.check_arithmetic(device, faults)[0] and selftest.check_layout(device, faults)[0]
    assert faults == []


def test_wrong_arithmetic_is_blamed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """As if the device fused a product and a sum: numpy is told to expect what is not there."""
    device, faults = Device(), []
    with monkeypatch.context() as patch:
        patch.setitem(selftest._OPERATIONS, "fma(a, b, c)", lambda a, b, c: a * b + c)
        assert not selftest.check_arithmetic(device, faults)[0]
    (fault,) = faults
    place = bundle.write_bundle(tmp_path, "arithmetic", "differs", device, fault)
    assert json.loads((place / "report.json").read_text())["first work-item"] == fault.item
    assert reproduce(place).returncode == 1


OPTIONAL = ("skimage", "scipy", "jinja2", "PIL", "mitsuba", "trimesh", "flip_evaluator", "colour", "shapely",
            "mapbox_earcut", "matplotlib", "dask", "distributed", "av", "hypothesis")  # fmt: skip


def selftested(folder: Path, *more: str, **environment: str) -> tuple[int, str, ElementTree.Element]:
    """`clrt selftest --quick` in a process of its own."""
    command = [sys.executable, "-m", "clrt", "selftest", "--quick", *more, "--junit", str(folder / "out.xml")]
    ran = subprocess.run([*command, "--bundle", str(folder / "bundle")], capture_output=True, text=True,
                         cwd=ROOT, env={**os.environ, **environment}, timeout=600)  # fmt: skip
    return ran.returncode, ran.stdout, ElementTree.parse(folder / "out.xml").getroot()


@pytest.mark.slow
def test_relaxed_math_is_caught_and_shown(tmp_path: Path) -> None:
    """pyopencl adds these options to every build: as a driver that relaxes on its own would.

    And all of it with what `pip install clrt` brings.
    """
    (tmp_path / "lean").mkdir()
    missing = f"import sys\nsys.modules.update(dict.fromkeys({OPTIONAL}))\n"
    (tmp_path / "lean" / "sitecustomize.py").write_text(missing)
    paths = os.pathsep.join([str(tmp_path / "lean"), str(ROOT)])
    only = "--only", "arithmetic,spheres"  # for each, a driver that keeps no programs compiles all kernels
    relaxed = {"PYOPENCL_BUILD_OPTIONS": "-cl-fast-relaxed-math", "PYTHONPATH": paths}
    code, out, root = selftested(tmp_path, *only, **relaxed)
    assert code == 1
    failed = {case.get("name"): case.find("failure").get("message") for case in root.iter("testcase")
              if case.find("failure") is not None}  # fmt: skip
    assert "spheres" in failed and set(failed) <= {"arithmetic", "spheres"}
    assert failed["spheres"].startswith("kernel generate: pass generate, generation 0")
    assert "bundle/spheres: kernel generate; run its reproduce.py" in out
    for check in failed:  # Intel's compiler relaxes nothing in kernels as short as those of "arithmetic"
        place = tmp_path / "bundle" / check
        assert "-cl-fast-relaxed-math" in json.loads((place / "report.json").read_text())["build options"]
        assert reproduce(place).returncode == 1
        program = place / "reproduce.py"
        program.write_text(program.read_text().replace("-cl-fast-relaxed-math", ""))
        assert reproduce(place).returncode == 0, "without the option the bits are right"


@pytest.mark.slow
def test_a_good_device_passes_and_leaves_an_empty_folder(tmp_path: Path) -> None:
    code, out, root = selftested(tmp_path)
    assert code == 0 and "checks passed" in out
    (suite,) = root.iter("testsuite")
    assert suite.get("failures") == "0" and suite.get("tests") == str(len(list(root.iter("testcase"))))
    named = {entry.get("name"): entry.get("value") for entry in root.iter("property")}
    assert named["device"] == suite.get("name") and named["driver"] and named["clrt"] == clrt.__version__
    assert list((tmp_path / "bundle").iterdir()) == []


def test_what_no_kernel_can_be_blamed_for_is_said(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Pictures that have other hashes than expected, where all kernels are right on what they were asked."""
    result = selftest.Result("expected pictures", False, "1 of 31 differ", 0.0)
    monkeypatch.setattr(selftest, "run_selftest", lambda *_: iter([result]))
    bundles = tmp_path / "bundle"
    assert main(["selftest", "--only", "expected pictures", "--bundle", str(bundles)]) == 1
    said = capsys.readouterr().out
    assert "bundle/expected-pictures: no kernel can be blamed" in said and "1 of 1 checks failed" in said
    report = json.loads((bundles / "expected-pictures" / "report.json").read_text())
    assert report["detail"] == result.detail
    assert main(["selftest", "--only", "expected"]) == 2
    assert "--only: 'expected' is not one of layout of records, arithmetic" in capsys.readouterr().err


def test_files_that_cannot_be_written_are_told_first(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "file").write_text("kept")
    assert main(["selftest", "--bundle", str(tmp_path / "full")]) == 2
    assert main(["selftest", "--junit", str(tmp_path / "no" / "out.xml")]) == 2
    said = capsys.readouterr()
    assert "full: is not empty; a bundle needs a folder of its own" in said.err and said.out == ""
    assert "cannot be written" in said.err and (tmp_path / "full" / "file").read_text() == "kept"


def test_it_needs_no_optional_package(tmp_path: Path) -> None:
    """All of it with numpy and pyopencl alone, as `pip install clrt` has them."""
    code = (
        "import sys\n"
        f"sys.modules.update(dict.fromkeys({OPTIONAL}))\n"
        "from clrt.base.resources import validation_module as module\n"
        "from clrt.device.device import Device\n"
        "import pathlib\n"
        "names = 'conformance.bundle', 'conformance.junit', 'selftest'\n"
        "bundle, junit, selftest = map(module, names)\n"
        "device = Device()\n"
        "result = next(selftest.run_selftest(device, True, True))\n"
        f"junit.write_junit(pathlib.Path({str(tmp_path / 'out.xml')!r}), [result], bundle.about(device))\n"
    )
    subprocess.run(
        [sys.executable, "-c", code], check=True, cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)}
    )
    assert (tmp_path / "out.xml").read_text().count("<testcase") == 1


def test_bits_are_told_as_floats_too() -> None:
    assert bundle._as_float(int(np.float32(1.5).view(np.uint32))) == "0x1.8000000000000p+0"
