"""The pytest plugin, run as another project runs it: the example project in tests/, whole and broken."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import clrt

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "tests" / "example_project"
Run = Callable[..., tuple[int, str]]


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A copy of the example project, without what its runs leave."""
    copied = tmp_path / "project"
    left = shutil.ignore_patterns("__pycache__", "picture-reports", ".pytest*")
    shutil.copytree(EXAMPLE, copied, ignore=left)
    (copied / "pytest.ini").write_text("[pytest]\n")
    return copied


@pytest.fixture
def run(project: Path, tmp_path: Path) -> Run:
    """Run pytest in the project; the plugin is found by the entry point that pyproject.toml names."""
    points = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"]["pytest11"]
    info = tmp_path / "installed" / "clrt-0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: clrt\nVersion: 0\n")
    lines = "".join(f"{name} = {target}\n" for name, target in points.items())
    (info / "entry_points.txt").write_text(f"[pytest11]\n{lines}")
    path = os.pathsep.join([str(ROOT), str(info.parent)])
    apart = ["--basetemp", str(tmp_path / "inner")]  # what other runs left behind is not removed by this one

    def ran(*options: str) -> tuple[int, str]:
        found = subprocess.run(
            [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *apart, *options],
            cwd=project, text=True, capture_output=True, timeout=300, check=False,
            env={**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"},
        )  # fmt: skip
        return found.returncode, found.stdout + found.stderr

    return ran


def reports(project: Path) -> list[str]:
    return sorted(path.name for path in project.glob("picture-reports/*"))


def plant(project: Path, old: str, new: str) -> None:
    text = (project / "toy.py").read_text()
    assert text.count(old) == 1
    (project / "toy.py").write_text(text.replace(old, new))


def test_the_example_passes_and_leaves_nothing(project: Path, run: Run) -> None:
    code, said = run()
    assert code == 0 and "4 passed" in said, said
    assert reports(project) == []


def test_a_fault_is_told_and_shown(project: Path, run: Run) -> None:
    plant(project, "y = (height", "y = -(height")
    code, said = run("-k", "test_a_ball")
    assert code == 1
    assert re.search(r"not the picture \S+pictures/test_toy/test_a_ball.exr: different: SSIM", said), said
    assert "cause: vertical flip" in said
    report = re.search(r"report: (\S+)", said)
    assert report and reports(project) == ["test_toy.test_a_ball.html"]
    page = Path(report[1]).read_text()
    assert "vertical flip" in page and "http" not in re.sub(r"http-equiv|http://www.w3.org", "", page)
    # mended, the report of the older run is gone
    plant(project, "y = -(height", "y = (height")
    assert run("-k", "test_a_ball")[0] == 0 and reports(project) == []


def test_what_is_updated_is_listed_and_then_passes(project: Path, run: Run) -> None:
    plant(project, "0.1 + 0.8 * cosine", "0.1 + 0.7 * cosine")
    kept = project / "pictures" / "test_toy"
    before = {path.name: path.read_bytes() for path in kept.iterdir()}
    assert run()[0] == 1 and {path.name: path.read_bytes() for path in kept.iterdir()} == before
    code, said = run("--update-pictures", "-n", "2")
    assert code == 0 and "5 reference pictures updated: look at them" in said, said
    assert str(kept / "test_a_ball.exr") in said
    assert {path.name for path in kept.iterdir()} == set(before)
    assert run()[0] == 0
    code, said = run("--update-pictures")
    assert code == 0 and "updated" not in said, "what passes is left as it is"


def test_a_picture_that_is_not_kept_yet_fails(project: Path, run: Run) -> None:
    (project / "pictures" / "test_toy" / "test_a_ball.exr").unlink()
    code, said = run("--picture-reports", "out")
    assert code == 1 and "there is no reference picture" in said and "--update-pictures" in said
    found = re.search(r"look at (\S+),", said)
    assert found and Path(found[1]) == project / "out" / "test_toy.test_a_ball.exr"
    assert run("--update-pictures", "--picture-reports", "out")[0] == 0 and run()[0] == 0
    assert not [path for path in (project / "out").rglob("*") if path.is_file()], "it is kept elsewhere"


def test_what_was_shown_of_a_picture_goes_when_it_passes(project: Path, run: Run) -> None:
    kept = project / "pictures" / "test_toy" / "test_a_ball.exr"
    whole = kept.read_bytes()
    kept.unlink()
    assert run()[0] == 1 and "test_toy.test_a_ball.exr" in reports(project)
    kept.write_bytes(whole)
    assert run()[0] == 0 and reports(project) == []


def test_bytes_are_kept_as_png_and_floats_as_exr() -> None:
    names = sorted(path.name for path in (EXAMPLE / "pictures" / "test_toy").iterdir())
    assert sum(name.endswith(".png") for name in names) == 1 and len(names) == 5
    (bytes_,) = (name for name in names if name.endswith(".png"))
    assert "bytes" in bytes_


def test_a_kept_png_is_all_there_was(project: Path, run: Run) -> None:
    """A sun of 1 is kept as bytes; one of 500 is not what these hold, nor is less than nothing."""
    test = "import numpy as np\ndef test_sun(same_picture):\n    a = np.zeros((24, 32, 3))\n"
    test += "    a[8:16, 8:16] = {}\n    same_picture(a)\n"
    (project / "test_toy.py").write_text(test.format(1))
    assert run("--update-pictures")[0] == 0 and run()[0] == 0
    assert (project / "pictures" / "test_toy" / "test_sun.png").exists()
    for value, figure in ((500, "PSNR above white"), ("1\n    a[0] = -50", "similar: PSNR ")):
        (project / "test_toy.py").write_text(test.format(value))
        code, said = run()
        assert code == 1 and figure in said and "test_sun.png" in said, said


def test_misuse_is_told(project: Path, run: Run) -> None:
    (project / "test_toy.py").write_text(
        "import numpy as np\nfrom toy import ball\n"
        "def test_twice(same_picture):\n    same_picture(ball(), 'a')\n    same_picture(ball(), 'a')\n"
        "def test_nan(same_picture):\n    same_picture(ball() * np.nan)\n"
        "def test_kind(same_picture):\n    same_picture('a.txt')\n"
    )
    code, said = run("--update-pictures")
    assert code == 1 and "3 failed" in said
    assert "give each picture a name of its own" in said and "pixels that are NaN or infinite" in said
    assert "a.txt: not a picture's file" in said


def test_tests_of_one_name_have_reports_of_their_own(project: Path, run: Run) -> None:
    (project / "pytest.ini").write_text("[pytest]\naddopts = --import-mode=importlib\n")
    test = "import numpy as np\ndef test_one(same_picture): same_picture(np.full((2, 3, 3), {}))\n"
    for folder in ("a", "b"):
        (project / folder).mkdir()
        (project / folder / "test_x.py").write_text(test.format(0.5))
    assert run("--update-pictures", "a", "b")[0] == 0
    (project / "a" / "test_x.py").write_text(test.format(0.9))
    code, said = run("a", "b")
    report = re.search(r"report: (\S+)", said)
    assert code == 1 and report and Path(report[1]) == project / "picture-reports/a/test_x.test_one.html"
    assert Path(report[1]).exists(), "that of b has passed, and removes its own"
    (project / "c").mkdir()
    (project / "c" / "test_x.py").write_text(
        test.format(0.5) + "def test_two(same_picture): same_picture(np.ma.masked_less(np.eye(3)[None], 1))\n"
    )
    (project / "c" / "pictures").write_text("no folder")
    code, said = run("--update-pictures", "c")
    assert code == 1 and "c/pictures/test_x cannot be made: Not a directory" in said and "are masked" in said


def test_a_picture_that_passes_needs_no_folder_of_reports(project: Path, run: Run) -> None:
    assert run("--update-pictures")[0] == 0
    (project / "file").write_text("")
    code, said = run("--picture-reports", "file/reports")
    assert code == 0, said


def test_a_scene_names_the_cause(project: Path, run: Run) -> None:
    """A picture without its second light: the kept picture only shows that it is darker."""
    sys.path.insert(0, str(ROOT / "tests"))
    import compare_samples as samples

    samples.scene().save(project / "scene.toml")
    (project / "test_toy.py").write_text(
        "import clrt, numpy as np\n"
        "def test_it(same_picture):\n"
        "    same_picture(np.load('picture.npy'), scene='scene.toml')\n"
    )
    np.save(project / "picture.npy", samples.picture())
    assert run("--update-pictures")[0] == 0
    np.save(project / "picture.npy", clrt.render(samples.with_lights(1, 0)).pixels)
    code, said = run()
    assert code == 1 and "cause: light 2 of 2 (direction 1, -1.5, -1) missing" in said, said


def test_a_damaged_picture_can_be_replaced(project: Path, run: Run) -> None:
    kept = project / "pictures" / "test_toy" / "test_a_ball.exr"
    before = kept.read_bytes()
    kept.write_bytes(b"no picture")
    assert run("-k", "test_a_ball")[0] == 1 and kept.read_bytes() == b"no picture"
    assert run("-k", "test_a_ball", "--update-pictures")[0] == 0
    assert kept.read_bytes() != b"no picture" and len(kept.read_bytes()) == len(before)


def test_a_wrong_scene_does_not_hide_the_verdict(project: Path, run: Run) -> None:
    (project / "test_toy.py").write_text(
        "from toy import ball\ndef test_a_ball(same_picture): same_picture(ball()[::-1], scene='none.toml')\n"
    )
    code, said = run()
    assert code == 1 and re.search(r"not the picture \S+test_a_ball.exr: different", said), said
    assert "no cause was looked for in scene=: none.toml" in said and len(reports(project)) == 1


def test_nothing_heavy_is_imported_at_start() -> None:
    code = "import sys, clrt.judging.plugin; print(*sorted({name.split('.')[0] for name in sys.modules}))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True,
                           env={**os.environ, "PYTHONPATH": str(ROOT)})  # fmt: skip
    loaded = set(found.stdout.split())
    assert {"clrt", "pytest"} <= loaded
    heavy = {"numpy", "pyopencl", "OpenImageIO", "msgspec", "rich", "skimage", "scipy", "jinja2"}
    assert loaded & heavy == set()
