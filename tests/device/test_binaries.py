"""Compiled programs that clrt keeps itself, for drivers that keep none."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest

import clrt
from clrt.device import binaries, cachefolder, cachelock, intel, kernelcache
from clrt.device import driver as driver_module
from clrt.device.opencl import cl

SCENE = clrt.load_dict(
    {
        "camera": {"origin": [0, 1, 4], "target": [0, 0, 0], "width": 16, "height": 12},
        "lights": [{"type": "point", "position": [3, 5, 4]}],
        "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}],
    }
)
SOURCE = "__kernel void twice(__global float *x) { x[get_global_id(0)] *= 2.0f; }"


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Every driver treated as one that keeps no programs; the folder of clrt's own."""
    kernelcache.prepare()
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(driver_module, "_KEEPS_PROGRAMS", ())
    return cachefolder.ours("binaries")


def build(source: str = SOURCE, threads: int | None = None) -> tuple[list[str], list[str]]:
    """Build anew, as in a new process: what watchers were told, and the kernels' names."""
    context, told = driver_module.Driver(None, clrt.Settings(threads=threads), None).context, []
    cachelock.watchers.append(told.append)
    try:
        program = driver_module._program.__wrapped__(context, source)
    finally:
        cachelock.watchers.clear()
    return [what for what in told if what], [kernel.function_name for kernel in program.all_kernels()]


def test_a_program_is_compiled_once_and_damage_is_found(kept: Path) -> None:
    compiled, ready = (["compiling kernels"], ["twice"]), ([], ["twice"])
    assert build() == compiled and build() == ready
    (file,) = kept.iterdir()
    good = file.read_bytes()
    for bad in (b"", good[:-1], good + b"x", good[:200], good[:130], good[: len(good) // 2] + b"\xff" * 99):
        file.write_bytes(bad)
        assert build() == compiled and file.read_bytes()[:65] == good[:65] and build() == ready
    assert build(SOURCE.replace("2.0f", "3.0f")) == compiled
    first, second = kept.iterdir()
    data = {file: file.read_bytes() for file in (first, second)}
    first.write_bytes(data[second])  # whole, but another program
    assert build() == compiled or build(SOURCE.replace("2.0f", "3.0f")) == compiled
    assert [file.stat().st_mode & 0o077 for file in [kept]] == [0]


def test_who_has_warnings_for_errors_can_compile(kept: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert build()[0]


def test_fewer_threads_take_what_all_compiled(kept: Path) -> None:
    assert build()[0] == ["compiling kernels"]
    assert build(threads=1) == ([], ["twice"])


def test_intels_compiler_leaves_kernels_as_wide_as_they_are_written() -> None:
    """It would take four times as long, for slower pictures."""
    driver = driver_module.Driver(None, clrt.Settings(), None)
    if driver.info.platform != intel.PLATFORM:
        assert driver.given(SOURCE) == SOURCE
        return
    kernel = cl.Kernel(driver.build(SOURCE), "twice")
    together = cl.kernel_sub_group_info.MAX_SUB_GROUP_SIZE_FOR_NDRANGE
    assert kernel.get_sub_group_info(driver.device, together, [64]) == 64  # 16: as many go through a vector


def test_a_binary_that_the_driver_refuses_is_compiled_again(kept: Path) -> None:
    assert build()[0] == ["compiling kernels"]
    (file,) = kept.iterdir()
    name = file.read_bytes()[:64]
    file.write_bytes(binaries._head(name, b"no binary") + b"no binary")
    assert build() == (["compiling kernels"], ["twice"])


def test_a_full_disk_costs_time_only(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kept.parent.mkdir()
    kept.write_text("a file where the folder should be")
    assert build() == (["compiling kernels"], ["twice"])


def test_pictures_of_kept_kernels_are_the_same(kept: Path) -> None:
    expected = clrt.render(SCENE).hash
    for turn in range(2):
        driver_module._program.cache_clear()
        assert clrt.render(SCENE).hash == expected, turn
    assert len(list(kept.iterdir())) == 1 and issubclass(cl.Program, object)
