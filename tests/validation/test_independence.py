"""Which oracles count as two: told by what their modules import, and so by a shared import that is
planted."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from clrt.base.resources import validation_module
from tests.report_samples import result as sample_result
from validation.oracle_mitsuba import Mitsuba, Source

independence = validation_module("independence")
family, reached, shared = independence.family, independence.reached, independence.shared
RENDERER, SHARED = independence.RENDERER, independence.SHARED

HERE = Path(__file__).resolve().parents[2]
PLANTED = {
    "the other's colours": ("oracle_mitsuba/surfaces.py", "from ..oracle64.palette import Palette as P\n"),
    "the renderer's materials": (
        "oracle_mitsuba/records.py",
        "from clrt.scene.materials import Material as M\n",
    ),
    "within a function": ("oracle_mitsuba/steps.py", "def f():\n    import clrt.scene.transforms\n"),
    "by its installed name": (
        "oracle_mitsuba/spectra.py",
        "from clrt_validation.oracle64 import spectra as s\n",
    ),
    "in what a package does first": (
        "oracle_mitsuba/__init__.py",
        "from ..oracle64.palette import Palette as P\n",
    ),
    "by a string from here": (
        "oracle_mitsuba/insides.py",
        "import_module('..oracle64.palette', __package__)\n",
    ),
    "by a string": ("oracle_mitsuba/insides.py", "import_module('clrt.scene.shapes')\n"),
}


def test_the_oracles_share_nothing() -> None:
    assert shared("oracle64", "mitsuba") == []
    assert family("oracle64") != family("mitsuba-table") == family("mitsuba-bsdf") == family("stock-S1")
    assert family("published") == "published" != family("closed form")


def test_mitsubas_side_has_nothing_of_the_renderers() -> None:
    assert shared("mitsuba", RENDERER) == []
    assert not any(module.split(".")[0] == "clrt" for module in reached("mitsuba"))


def test_the_worker_loads_nothing_of_the_renderers() -> None:
    """Not told by the text but by the process itself, once it has rendered."""
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {"color": "gold", "ior": "SF11"}}
    camera = {"origin": [0, 0, 5], "target": [0, 0, 0], "width": 4, "height": 3}
    scene = {"spectrum": {"bands": 3}, "camera": camera, "shapes": [ball], "background": "D65"}
    with Mitsuba() as fresh:  # other tests hand arrays of clrt's to the one that they share
        assert fresh.render(Source(scene), "spectral").pixels.max() > 0
        modules = fresh.request("modules", None)
    assert [name for name in modules if name.split(".")[0] in ("clrt", "pyopencl", "msgspec")] == []
    ours = {
        f"validation.{name.partition('.')[2]}"
        for name in modules
        if name.split(".")[0].endswith("validation")
    }
    assert ours - {"validation.", "validation.oracle_mitsuba"} <= reached("mitsuba")


@pytest.mark.parametrize("name", PLANTED)
def test_a_shared_import_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    roots = {package: tmp_path / package for package in ("clrt", "validation")}
    for package, folder in roots.items():
        shutil.copytree(HERE / package, folder, ignore=shutil.ignore_patterns("__pycache__", "corpus"))
    assert shared("oracle64", "mitsuba", roots) == []
    again = {
        package: folder.rename(folder.with_name(f"{package}_planted")) for package, folder in roots.items()
    }
    file, line = PLANTED[name]
    target = again["validation"] / file
    target.write_text(f"{target.read_text()}\n{line}")
    assert shared("oracle64", "mitsuba", again)
    assert family("oracle64", again) == family("mitsuba-table", again) == family("stock-S2", again)
    # and the table says so
    result = sample_result(wrong=False)
    assert result.thin == [] and result.passed
    monkeypatch.setattr(independence, "reached", lambda oracle, _=None, real=reached: real(oracle, again))
    assert set(result.thin) == set(result.coverage) and not result.passed


def test_what_is_shared_is_printed() -> None:
    page = (HERE / "docs" / "validation.md").read_text("utf-8")
    for module in SHARED:
        assert f"`{module}`" in page
    for module in shared("oracle64", RENDERER):
        parts = module.split(".")
        packages = [".".join(parts[:n]) for n in range(2, len(parts) + 1)]
        assert any(f"`{name}`" in page for name in packages), module
