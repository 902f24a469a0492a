"""Long renders: what a killed one leaves behind, and that going on from there gives the same picture."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

import clrt
from clrt.cli import main
from clrt.images.file import read_samples
from tests.disk import small_files
from validation.reliability.scene import TEXT

# the ball and the floor of a scene that goes through every pass, larger and without files
SCENE = "ambient = 0.1\n" + TEXT[TEXT.index("[camera]") : TEXT.index('[[shapes]]\ntype = "mesh"')]
SCENE = SCENE.replace("width = 24", "width = 600").replace("height = 18", "height = 400")
LAYERS = ("reflection", "depth", "shape")


class Enough(Exception):
    """Ends a render in its midst."""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "ball.toml"
    path.write_text(SCENE)
    return path


def broken_off(tracer: clrt.Tracer, path: Path, after: int, **options: object) -> int:
    """Render until so many tiles are done, then end it; returns the finished pixels."""
    seen: list[int] = []

    def stop(done: int, total: int, rays: int) -> None:
        seen.append(done)
        if len(seen) == after:
            raise Enough

    with pytest.raises(Enough):
        tracer.render(checkpoint=path, progress=stop, **options)  # type: ignore[arg-type]
    return seen[-1]


def test_a_render_that_was_broken_off_twice_gives_the_same_bits_and_counts(scene: Path) -> None:
    path = scene.with_name("a.checkpoint")
    loaded = clrt.load(scene)
    whole = clrt.render(loaded, width=150, layers=LAYERS)
    small = clrt.Tracer(loaded, settings=clrt.Settings(tile=700))
    large = clrt.Tracer(loaded, settings=clrt.Settings(tile=3000, lanes=8))
    first = broken_off(small, path, 5, width=150, layers=LAYERS)
    second = broken_off(large, path, 2, width=150, layers=LAYERS)
    assert 0 < first < second < whole.width * whole.height
    image = small.render(width=150, layers=LAYERS, checkpoint=path)
    assert image.hash == whole.hash and image.stats["generations"] == whole.stats["generations"]
    for name in LAYERS:
        assert np.array_equal(image.layers[name], whole.layers[name])
    # it is kept: the same call gives the picture without tracing a ray
    calls: list[int] = []
    again = small.render(
        width=150, layers=LAYERS, checkpoint=path, progress=lambda done, total, rays: calls.append(done)
    )
    assert (again.hash, calls) == (whole.hash, []) and again.stats["rays"] == whole.stats["rays"]


def test_crops_and_samples_go_on_too(scene: Path) -> None:
    path, options = scene.with_name("a.checkpoint"), {"width": 90, "crop": (11, 7, 41, 29), "spp": 4}
    tracer = clrt.Tracer(clrt.load(scene), settings=clrt.Settings(tile=800))
    broken_off(tracer, path, 3, **options)
    assert tracer.render(checkpoint=path, **options).hash == tracer.render(**options).hash  # type: ignore[arg-type]


PRISM = {
    "ambient": 0.2, "background": 2.0, "ambient_samples": 2, "max_depth": 3,
    "camera": {"origin": [0, 0, 4], "target": [0, 0, 0], "width": 24, "height": 18, "spp": 4},
    "lights": [{"type": "point", "position": [3, 5, 4], "intensity": 1e30}],
    "shapes": [
        {"type": "sphere", "center": [0, 0, 0], "radius": 1,
         "material": {"ior": "SF10", "reflection": 0.4, "transmission": 0.5}},
        {"type": "sphere", "center": [1, 1, 0], "radius": 0.5, "material": {"color": [0, 1, 0]}},
    ],
}  # fmt: skip
SPECTRA: dict[str, dict[str, object]] = {
    "in RGB": {},
    "in bands": {"spectrum": {"bands": 8}},
    "in bands that disperse together": {"spectrum": {"bands": 16, "group": 4}},
    "as the thesis": {"spectrum": {"bands": 16, "response": "thesis-2011"}},
}


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("how", SPECTRA)
def test_what_a_film_gives_is_within_the_bounds_of_a_checkpoint(
    how: str, dark: bool, tmp_path: Path
) -> None:
    """All layers, the brightest light, counts of every kind; a sky below zero, as sharpening leaves it."""
    clrt.Image(np.full((4, 8, 3), (-50.0, -0.1, 0.2), np.float32)).save(tmp_path / "dark.exr")
    sky = {"background": "dark.exr", "lights": []} if dark else {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it makes light
        scene = clrt.load_dict({**PRISM, **SPECTRA[how], **sky}, folder=tmp_path)
    tracer = clrt.Tracer(scene, settings=clrt.Settings(tile=600))
    whole = tracer.render(layers="all")
    assert whole.pixels.min() < -0.1 if dark else whole.pixels.max() > 1e25
    path = tmp_path / "a.ck"
    broken_off(tracer, path, 1, layers="all")
    again = tracer.render(layers="all", checkpoint=path)
    assert again.hash == whole.hash and again.stats["generations"] == whole.stats["generations"]
    assert tracer.render(layers="all", checkpoint=path).hash == whole.hash


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"width": 91}, "size was 90 x 60, is 91 x 61"),
        ({"spp": 4}, "spp was 1, is 4"),
        ({"max_depth": 2}, "max_depth was 5, is 2"),
        ({"crop": (0, 0, 5, 5)}, "crop was 0 0 90 60, is 0 0 5 5"),
        ({"layers": ("depth",)}, "layers was none, is depth"),
    ],
)
def test_another_render_is_refused(scene: Path, options: dict[str, object], says: str) -> None:
    path = scene.with_name("a.checkpoint")
    tracer = clrt.Tracer(clrt.load(scene), settings=clrt.Settings(tile=2000))
    broken_off(tracer, path, 1, width=90)
    before = path.read_bytes()
    with pytest.raises(clrt.ClrtError, match=f"a.checkpoint: is the checkpoint of another render: {says}"):
        tracer.render(**{"width": 90, "checkpoint": path, **options})  # type: ignore[arg-type]
    assert path.read_bytes() == before


def test_a_render_with_odd_build_options_goes_on(scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They are among what a checkpoint says of its render, a tab and all."""
    monkeypatch.setenv("PYOPENCL_BUILD_OPTIONS", "-DNOTHING=1\t-DMORE=2")
    path = scene.with_name("a.checkpoint")
    whole = clrt.render(scene, width=40, checkpoint=path)
    assert clrt.render(scene, width=40, checkpoint=path).hash == whole.hash
    monkeypatch.delenv("PYOPENCL_BUILD_OPTIONS")
    with pytest.raises(clrt.ClrtError, match="is not a whole checkpoint of clrt"):
        clrt.render(scene, width=40, checkpoint=path)


def test_another_scene_camera_or_kernel_is_refused(scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = scene.with_name("a.checkpoint")
    broken_off(clrt.Tracer(clrt.load(scene), settings=clrt.Settings(tile=2000)), path, 1, width=90)
    for old, new, name in (("radius = 1.0", "radius = 1.01", "scene"), ("1.0, 4.0]", "1.0, 5.0]", "camera")):
        scene.write_text(SCENE.replace(old, new))
        with pytest.raises(clrt.ClrtError, match=f"another render: {name} was "):
            clrt.render(clrt.load(scene), width=90, checkpoint=path)
    scene.write_text(SCENE)
    monkeypatch.setattr("clrt.device.foreign.kernel_source", lambda *_, **__: "other kernels")
    with pytest.raises(clrt.ClrtError, match="another render: kernels was "):
        clrt.render(clrt.load(scene), width=90, checkpoint=path)
    monkeypatch.undo()
    monkeypatch.setenv("POCL_EXTRA_BUILD_FLAGS", "-cl-denorms-are-zero")
    text = "another render: POCL_EXTRA_BUILD_FLAGS was {}, is {}"
    with pytest.raises(clrt.ClrtError, match=text.format("not set", "-cl-denorms-are-zero")):
        clrt.render(clrt.load(scene), width=90, checkpoint=path)
    path.unlink()
    broken_off(clrt.Tracer(clrt.load(scene), settings=clrt.Settings(tile=2000)), path, 1, width=90)
    monkeypatch.undo()
    with pytest.raises(clrt.ClrtError, match=text.format("-cl-denorms-are-zero", "not set")):
        clrt.render(clrt.load(scene), width=90, checkpoint=path)


def test_files_that_are_no_whole_checkpoint(scene: Path) -> None:
    path = scene.with_name("a.checkpoint")
    tracer = clrt.Tracer(clrt.load(scene), settings=clrt.Settings(tile=2000))
    broken_off(tracer, path, 1, width=90)
    whole = path.read_bytes()
    middle = len(whole) // 2
    changed = whole[:middle] + b"\xff\xfe\xfd" + whole[middle + 3 :]
    for data in (b"", b"PK\3\4", whole[:middle], changed, b"x" * 999):
        path.write_bytes(data)
        with pytest.raises(clrt.ClrtError, match="is not a whole checkpoint of clrt") as caught:
            tracer.render(width=90, checkpoint=path)
        assert "\n" not in str(caught.value) and path.read_bytes() == data
    with pytest.raises(clrt.ClrtError, match="make it first"):
        tracer.render(width=90, checkpoint=scene.parent / "none" / "a")


def test_a_killed_command_goes_on_where_it_was(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = scene.with_name("a.checkpoint"), scene.with_name("a.exr")
    command = ["render", str(scene), "-o", str(out), "--spp", "9", "--quiet", "--checkpoint", str(path)]
    process = subprocess.Popen([sys.executable, "-m", "clrt", *command])
    until = time.monotonic() + 120
    while not path.exists() and process.poll() is None and time.monotonic() < until:
        time.sleep(0.005)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL, "it ended before it could be killed"
    assert not out.exists()
    with np.load(path) as stored:
        part = float(stored["done"].mean())
    assert 0 < part < 1
    assert main(command) == 0
    assert capsys.readouterr() == ("", "")
    assert not path.exists(), "it is of no use once the picture is saved"
    assert np.array_equal(read_samples(out), clrt.render(clrt.load(scene), spp=9).pixels)
    left = {file.name for file in scene.parent.iterdir() if not file.name.startswith(".clrt-")}
    assert left == {"ball.toml", "a.exr"}


def test_ctrl_c_says_where_the_finished_part_is(
    scene: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = scene.with_name("a.checkpoint")

    def interrupted(*_: object) -> None:
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr("clrt.engine.checkpoint.Checkpoint.add", interrupted)
    monkeypatch.setattr("clrt.engine.checkpoint.Checkpoint.__exit__", lambda self, *_: self.save())
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    out = str(scene.with_name("a.png"))
    try:
        assert main(["render", str(scene), "-o", out, "--checkpoint", str(path)]) == 130
    finally:
        signal.signal(signal.SIGINT, handler)
    printed, err = capsys.readouterr()
    says = f"clrt: interrupted; {path} holds what is finished: the same command goes on from there\n"
    assert (printed, err) == ("", says)


def test_a_checkpoint_needs_a_file_of_its_own(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(scene.with_name("a.png"))
    assert main(["render", str(scene), "-o", out, "--checkpoint", out]) == 2
    assert "give --checkpoint a file of its own" in capsys.readouterr().err


def test_a_disk_that_is_full_leaves_the_old_checkpoint(scene: Path) -> None:
    path = scene.with_name("a.checkpoint")
    tracer = clrt.Tracer(clrt.load(scene), settings=clrt.Settings(tile=2000))
    broken_off(tracer, path, 1, width=90)
    before = path.read_bytes()
    with small_files(9000), pytest.raises(clrt.ClrtError, match=r"a\.checkpoint: cannot be written: File"):
        tracer.render(width=90, checkpoint=path)
    assert path.read_bytes() == before
    assert sorted(file.name for file in scene.parent.iterdir()) == ["a.checkpoint", "ball.toml"]


def test_the_order_of_layers_makes_no_other_render(scene: Path, tmp_path: Path) -> None:
    """A set has another one in each process."""
    path = tmp_path / "a.checkpoint"
    small = clrt.Tracer(clrt.load(scene), settings=clrt.Settings(tile=700))
    orders = [LAYERS, LAYERS[::-1], set(LAYERS), frozenset(LAYERS)]
    assert len({small.identity(width=60, layers=layers) for layers in orders}) == 1
    whole = small.render(width=60, layers=LAYERS)
    broken_off(small, path, 2, width=60, layers=LAYERS)
    for layers in orders[1:]:
        image = small.render(width=60, layers=layers, checkpoint=path)
        assert image.hash == whole.hash
        assert {name: layer.tobytes() for name, layer in image.layers.items()} == {
            name: layer.tobytes() for name, layer in whole.layers.items()
        }
    assert [*image.layers] == sorted(LAYERS)
