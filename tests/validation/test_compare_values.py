"""No value vanishes before it is compared: what is above white or below black counts, unless a file's kind
says that it could not be there, and then it is told."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
import time
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
import pytest

import clrt
import compare_samples as samples
from clrt.base.resources import validation_module
from clrt.cli import main
from clrt.images.file import decode, encode
from clrt.judging.verdict import COMPARING
from tests.pictured import put

causes = validation_module("compare.causes")
curves = validation_module("compare.curves")
metrics = validation_module("compare.metrics")
oracle = validation_module("compare.oracle")
pictures = validation_module("compare.pictures")
edge_mask64 = validation_module("oracle64").edge_mask
SIZE = (24, 32, 3)


def grey(value: float) -> np.ndarray:
    return np.full(SIZE, value, np.float32)


def with_disk(base: np.ndarray, value: float) -> np.ndarray:
    picture = base.astype(np.float32).copy()
    picture[10:16, 10:16] = value
    return picture


NOISE = np.random.default_rng(5).random(SIZE).astype(np.float32)
OFF: dict[str, tuple[np.ndarray, np.ndarray]] = {
    "a sun of 1 for 500": (with_disk(grey(0), 1), with_disk(grey(0), 500)),
    "a sun of 1 for 500, of bytes": (with_disk(decode(encode(NOISE)), 1),
                                     with_disk(decode(encode(NOISE)), 500)),
    "a furnace that makes light": (grey(1.5), grey(1)),
    "white for radiance": (grey(1), 1 + 4 * NOISE),
    "less than nothing": (with_disk(NOISE, -50), with_disk(NOISE, 0)),
    "a little less than nothing": (with_disk(grey(0), -0.05), grey(0)),
    "less than nothing, of bytes": (with_disk(decode(encode(NOISE)), -50),
                                    with_disk(decode(encode(NOISE)), 0)),
    "another sign": (-NOISE, NOISE),
}  # fmt: skip


@pytest.mark.parametrize("name", OFF)
def test_arrays_and_files_of_floats_are_never_clipped(name: str, tmp_path: Path) -> None:
    a, b = OFF[name]
    files = [clrt.Image(image).save(tmp_path / f"{n}.exr") for n, image in enumerate((a, b))]
    for one, other in ((a, b), (b, a), files, files[::-1]):
        verdict = clrt.compare(one, other)
        assert not verdict and verdict.verdict in ("similar", "different"), str(verdict)
        assert verdict.figures["largest difference"] == pytest.approx(np.abs(a - b).max(), rel=1e-6)
        curve = {"another tone curve", "sRGB applied twice", "sRGB not applied"}
        assert not curve & {cause.name for cause in verdict.causes[:1]}
    assert main(["compare", *map(str, files)]) == main(["compare", *map(str, files[::-1])]) == 1


BRIGHT = with_disk(samples.picture()[:24, :32], 7)
BRIGHT[:3, :5, 1] = -2


def in_file(path: Path, bits: int) -> Path:
    """BRIGHT with so many bits, in the file of that name."""
    spec = oiio.ImageSpec(32, 24, 3, {8: "uint8", 16: "uint16", 32: "float"}[bits])
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), spec)
    assert out.write_image(BRIGHT if bits == 32 else encode(BRIGHT, bits=bits)) and out.close()
    return path


@pytest.mark.parametrize("name", ["8.png", "16.png", "8.bmp", "8.tif", "16.tif", "8", "16"])
def test_what_integers_cannot_hold_is_clipped_and_told(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bits, exr = int(name.split(".")[0]), in_file(tmp_path / "32.exr", 32)
    stored = in_file(tmp_path / name, bits) if "." in name else encode(BRIGHT, bits=bits)
    for other in (BRIGHT, exr):
        for which, pair in (("reference", (stored, other)), ("picture", (other, stored))):
            verdict = clrt.compare(*pair)
            assert verdict.verdict == "equal" and verdict.causes == ()
            assert f"51 pixels of the {which} are brighter than white, or below black" in verdict.notes[0]
    wrong = clrt.compare(stored, BRIGHT[::-1])
    assert not wrong and wrong.causes[0].name == "vertical flip" and wrong.causes[0].left < 0.01
    assert clrt.compare(stored, np.clip(BRIGHT, 0, 1)).notes == ()
    if "." in name:
        for names in ((stored, exr), (exr, stored)):
            assert main(["compare", *map(str, names)]) == 0
            assert "note: 51 pixels of the" in capsys.readouterr().out


def test_what_a_scene_shows_above_white_is_clipped_for_a_file_of_bytes(tmp_path: Path) -> None:
    lit = samples.with_lights(4, 4)
    shown = clrt.render(lit)
    assert shown.pixels.max() > 1.2
    lit.save(tmp_path / "scene.toml")
    png, scene = str(shown.save(tmp_path / "a.png")), str(tmp_path / "scene.toml")
    assert main(["compare", png, scene]) == main(["compare", scene, png]) == 0
    assert main(["compare", scene, png, png]) == 0, "and where there are many"
    assert clrt.compare(png, lit).verdict == "equal"
    assert clrt.compare(shown, lit).verdict == "identical"
    assert not clrt.compare(np.clip(shown.pixels, 0, 1), lit)
    dark = clrt.render(samples.with_lights(4, 0)).save(tmp_path / "dark.png")
    assert clrt.compare(dark, lit).causes[0].name.startswith("light 2 of 2")


def test_floats_in_a_tiff_are_radiance(tmp_path: Path) -> None:
    tiff = in_file(tmp_path / "32.tif", 32)
    assert clrt.compare(tiff, BRIGHT).verdict == "identical"
    assert not clrt.compare(tiff, np.clip(BRIGHT, 0, 1))


def test_that_a_picture_of_floats_was_clipped_is_a_cause() -> None:
    for cut in (np.clip(BRIGHT, 0, 1), decode(encode(BRIGHT))):
        verdict = clrt.compare(cut, BRIGHT)
        assert not verdict and verdict.causes[0].name == "clipped" and verdict.causes[0].proven
    assert not list(curves.clipped(BRIGHT, BRIGHT * 2, causes.FLOAT))


def test_a_little_more_than_white_is_no_rounding() -> None:
    for pair in ((grey(1.005), grey(1)), (grey(1), grey(1.005))):
        assert clrt.compare(*pair).verdict == "same picture"


def test_values_tell_of_bytes_only_between_black_and_white() -> None:
    rounded = decode(encode(NOISE)).astype(float)
    assert causes.tolerance_of(rounded, NOISE) == causes.tolerance_of(NOISE, rounded) == causes.BYTE
    for black_and_white in (grey(0), grey(1), with_disk(grey(0), 1)):
        assert causes.tolerance_of(black_and_white, NOISE) == causes.FLOAT
    for beyond in (with_disk(NOISE, 1.1), with_disk(NOISE, -0.1)):
        assert causes.tolerance_of(rounded, beyond) == causes.tolerance_of(beyond, rounded) == causes.FLOAT
    assert causes.tolerance_of(rounded, with_disk(NOISE, 1.005)) == causes.BYTE, "less than a step"
    assert causes.tolerance_of(NOISE, NOISE, (16, 32)) == causes.WORD
    assert causes.tolerance_of(rounded, NOISE, (16, 32)) == causes.BYTE, "8 bits in a file of 16"


def test_the_curve_is_odd() -> None:
    values = np.array([0, 1e-3, 0.2, 1, 3, 1e30])
    assert np.array_equal(metrics.extended(-values), -metrics.extended(values))
    assert (np.diff(metrics.extended(values)) > 0).all()
    assert np.allclose(metrics.to_white([-3, 0.2, 7]), [-metrics.extended(3), metrics.encoded(0.2), 1])
    assert metrics.psnr(metrics.to_white(np.array([1.0])), metrics.to_white(np.array([500.0]))) == np.inf


def test_noisy_oracles_see_what_is_less_than_nothing() -> None:
    """SSIM and single pixels are let go for them, and the mean forgives what cancels."""
    limit = oracle.statistical(oracle.limits(many_edges=True))
    dark = samples.GREY.copy()
    dark[:, 0] = 0
    lower = dark + 0.3 / 49
    lower[:, 0] = -0.3
    found = oracle.compare(samples.oracle(lower), samples.oracle(dark), limit=limit)
    assert samples.failed(found) == {"PSNR"}


def bases(random: np.random.Generator) -> list[np.ndarray]:
    uniform = random.random(SIZE)
    some = uniform < random.random()
    return [uniform, decode(encode(uniform)), some * 1.0, np.full(SIZE, random.choice([0, 0.5, 1, 1.5, -1])),
            np.exp(random.uniform(-4, 4, SIZE)), random.normal(0, 2, SIZE), uniform * some]  # fmt: skip


def test_no_change_of_a_hundredth_of_the_pixels_is_equal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pictures, "_causes", lambda *_: [])  # which take the time, and decide nothing
    monkeypatch.setattr(validation_module("compare.figures"), "flip", lambda *_: None)
    random = np.random.default_rng(11)
    for _ in range(30):
        for base in bases(random):
            changed = base.copy()
            where = random.random(SIZE[:2]) < random.choice([0.02, 0.2, 0.9])
            where.flat[random.choice(where.size, 8, replace=False)] = True  # a hundredth at least
            step = 0.0501 * np.exp(random.uniform(0, random.choice([0.1, 5, 12]), SIZE))
            step *= random.choice([-1, 1], SIZE) if random.random() < 0.5 else random.choice([-1, 1])
            channels = random.random(SIZE) < 0.5
            channels[..., random.integers(3)] = True
            changed += np.where(where[..., None] & channels, step, 0)
            a, b = base.astype(np.float32), changed.astype(np.float32)
            for pair in ((a, b), (b, a)):
                found = pictures.compare_pictures(*pair)
                assert found.verdict not in ("identical", "equal"), found.metrics
                assert not any("count as white" in note for note in found.notes), "nothing was clipped"


def most_memory(height: int, width: int = 1000) -> int:
    """Bytes that comparing two pictures takes a process at most; ru_maxrss begins with ours."""
    code = (
        "import sys, numpy as np, clrt\n"
        "a = np.random.default_rng(1).random((*map(int, sys.argv[1:]), 3), np.float32)\n"
        "assert not clrt.compare(a, a[::-1, ::-1] * np.float32(0.7))\n"
        "print(open('/proc/self/status').read().partition('VmHWM:')[2].split()[0])"
    )
    command = [sys.executable, "-c", code, str(height), str(width)]
    return 1024 * int(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="needs Linux, which counts such memory")
def test_room_of_a_comparison() -> None:
    """It grows by no more than is asked of `host_bytes` before, and is asked."""
    growth = (most_memory(3000) - most_memory(1000)) / (2000 * 1000)
    assert 0.3 * COMPARING < growth < COMPARING
    small = np.zeros((10, 10, 3), np.float32)
    with pytest.raises(clrt.LimitError, match=r"comparing: host_bytes: 11 000 .*clrt.compare\(\.\.\., limi"):
        clrt.compare(small, small, limits=clrt.Limits(host_bytes=10_999))
    assert clrt.compare(small, small, limits=clrt.Limits(host_bytes=11_000))


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="needs Linux, which counts such memory")
@pytest.mark.parametrize("shape", [(1, 300_000), (300_000, 1)])
def test_room_of_a_comparison_of_thin_pictures(shape: tuple[int, int]) -> None:
    """What as many pixels in a square take, and a block's worth: measured 50 MB more; it was 260 and 600."""
    assert most_memory(*shape) < most_memory(550, 550) + (128 << 20)


@pytest.mark.parametrize("shape", [(5, 300, 3), (70, 190, 3), (300, 3, 3), (1, 90, 3)])
def test_figures_do_not_depend_on_how_a_picture_is_cut(
    shape: tuple[int, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of wide pictures the columns are, too: rows alone would not fit into memory."""
    random = np.random.default_rng(5)
    b = random.random(shape, np.float32)
    a = np.clip(b + random.normal(0, 0.02, shape), 0, 2).astype(np.float32)
    found = []
    for pixels in (1 << 20, 1 << 11):
        monkeypatch.setattr(metrics, "_BLOCK", pixels)
        found.append(pictures.compare_pictures(a, b))
    assert len([*metrics.blocks(shape)]) > 1
    assert found[1].metrics == pytest.approx(found[0].metrics, rel=1e-9)
    assert [cause.name for cause in found[0].causes] == [cause.name for cause in found[1].causes]


@pytest.mark.parametrize("name", ["another size", "transpose"])
def test_causes_of_a_picture_of_one_row(name: str) -> None:
    """2 s; a filter as wide as the row is to shrink, or all its pixels as samples, took a minute and more."""
    row = np.random.default_rng(6).random((1, 600_000, 3), np.float32)
    other = row.swapaxes(0, 1) if name == "transpose" else row[:, :64]
    started = time.process_time()
    assert name in [cause.name for cause in pictures.compare_pictures(other, row).causes]
    assert time.process_time() - started < 15


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("value", [3e38, -3e38, 0.0])
def test_huge_values_are_counted_without_foreign_warnings(value: float) -> None:
    spot = with_disk(NOISE, value), with_disk(NOISE, 5)
    for a, b in (spot, (grey(value), grey(5)), (grey(value), NOISE)):
        for one, other in ((a, b), (b, a)):
            verdict = clrt.compare(one, other)
            assert not verdict and not np.isnan([*verdict.figures.values()]).any()


@pytest.mark.parametrize("steps", [255, 255.999])
def test_bytes_that_are_cut_off_are_rounded_otherwise(steps: float) -> None:
    """As many a first ray tracer has it; but not where a hundredth of the pixels is wrong beside."""
    shown = metrics.encoded(samples.picture())
    cut = np.floor(shown * steps).clip(0, 255).astype(np.uint8)
    for reference in (samples.picture(), encode(samples.picture())):
        verdict = clrt.compare(cut, reference)
        assert verdict and verdict.verdict == "equal" and "FLIP" in verdict.figures
        assert verdict.figures["FLIP"] < 0.002 or any("more than rounding" in note for note in verdict.notes)
        wrong = cut.copy()
        wrong[10:20, 30:40] //= 2
        assert not clrt.compare(wrong, reference)


def test_edges_count_in_no_figure_where_they_are_left_out() -> None:
    """A picture that is wrong there alone passes; one that is wrong elsewhere, or all edges, does not."""
    found = samples.with_camera()
    reference = validation_module("compare.reference").reference_of(found)
    right = reference.render()
    edges = reference.edges(right)
    spoilt = np.where(edges[..., None], 1 - right, right).astype(np.float32)
    assert 0.01 < edges.mean() < 0.5
    assert not clrt.compare(spoilt, found, seconds=0)
    verdict = clrt.compare(spoilt, found, seconds=0, mask=True)
    assert verdict and verdict.figures["SSIM"] == 1 and verdict.figures["PSNR"] == np.inf
    ys, xs = np.nonzero(~edges)
    spoilt[ys[::20], xs[::20]] += 0.2
    assert not clrt.compare(spoilt, found, seconds=0, mask=True)
    noise = np.random.default_rng(3).random((40, 40, 3)).astype(np.float32)
    assert not clrt.compare(1 - noise, noise, mask=True)


def test_edges_of_a_bright_picture_are_those_of_a_dim_one() -> None:
    """Above white a change is a part of what is there: of smooth shading as before, not most of it."""
    dim = [clrt.render(samples.with_camera(shift=(x, abs(x)))).pixels for x in (0, 0.05, -0.05)]
    bright = [image * np.float32(1000) for image in dim]
    assert metrics.edge_mask(bright[0], bright[1:]).mean() < 5 * metrics.edge_mask(dim[0], dim[1:]).mean()
    lights = [{**light, "intensity": 300.0} for light in samples.SCENE["lights"]]
    found = clrt.load_dict({**samples.SCENE, "lights": lights})
    assert edge_mask64(found).mean() < 5 * edge_mask64(samples.scene()).mean() < 0.3


LARGE = {
    "vertical flip": lambda p: p[::-1],
    "red and blue swapped": lambda p: p[..., ::-1],
    "exposure factor 0.5": lambda p: p * 0.5,
    "shift by 3 pixels right and 2 pixels up": lambda p: np.roll(p, (-2, 3), axis=(0, 1)),
    "cropped": lambda p: p[9:400, 25:500],
}


@pytest.mark.parametrize("name", LARGE)
def test_causes_in_pictures_of_many_strips(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of which the middle is asked, or means of squares: the cause, and where it is to the pixel.

    A picture is large from fewer pixels on here: of 1800 x 2200 this takes 16 times as long.
    """
    monkeypatch.setattr(pictures, "_LOOKED_AT", 360)
    monkeypatch.setattr(metrics, "_BLOCK", 1 << 16)
    monkeypatch.setattr(validation_module("compare.moves"), "_SEARCHED", 1 << 14)
    y, x = np.mgrid[0:450, 0:550] / 24.25
    waves = np.sin(x + y * y / 30), np.sin(2 * y + x * x / 25), np.cos(x * y / 9)
    large = 0.4 + 0.3 * np.stack(waves, axis=-1)
    large[50:65, 75:105] = 0.9
    pair = (image.astype(np.float32) for image in (LARGE[name](large), large))
    best = pictures.compare_pictures(*pair).causes[0]
    assert best.name == name and best.proven
    assert name != "cropped" or "from pixel (25, 9) on" in best.text


def test_radiances_shared_exponent_is_rounding(tmp_path: Path) -> None:
    """A right picture as .hdr, which OpenImageIO cuts off and others round; not one that is 2 % too dark."""
    right = samples.picture() * np.float32([3, 1, 0.01])
    clrt.compare(right, right)
    file = put(tmp_path / "a.hdr", right)
    verdict = clrt.compare(file, right)
    assert verdict and any("1/128" in note for note in verdict.notes)
    assert clrt.compare(right, file) and main(["compare", str(file), str(file)]) == 0
    assert not clrt.compare(put(tmp_path / "b.hdr", right * np.float32(0.95)), right)
    right[20:30, 30:40] *= 0.9
    assert not clrt.compare(file, right)


def test_limits_hold_for_a_scene_too(tmp_path: Path) -> None:
    deep = {**samples.SCENE, "max_depth": 80, "shapes": samples.SCENE["shapes"][:1]}
    picture = samples.picture()
    with pytest.raises(clrt.LimitError, match="depth: 80 is above the limit of 64"):
        clrt.compare(picture, deep, seconds=0)
    assert clrt.compare(picture, deep, seconds=0, limits=clrt.Limits(depth=99)).figures
    with pytest.raises(clrt.LimitError, match="primitives"):
        clrt.compare(picture, samples.SCENE, limits=clrt.Limits(primitives=1))


@pytest.mark.parametrize("limits", [{}, 0, "", [], False])
def test_limits_are_limits(limits: Any) -> None:
    with pytest.raises(clrt.ClrtError, match=r"limits: .* is not allowed"):
        clrt.compare(np.zeros((2, 2, 3)), np.zeros((2, 2, 3)), limits=limits)


def test_messages_of_limits_advise_the_call_that_takes_them(tmp_path: Path) -> None:
    picture = put(tmp_path / "a.png", np.zeros((4, 4, 3), np.uint8), "uint8")
    deep = {**samples.SCENE, "max_depth": 80}
    few, shallow = clrt.Limits(image_pixels=3), clrt.Limits(depth=2)
    for call, ask in (
        ("clrt.read_image", lambda: clrt.read_image(picture, few)),
        ("clrt.compare", lambda: clrt.compare(picture, picture, limits=few)),
        ("clrt.compare", lambda: clrt.compare(samples.picture(), deep, limits=shallow, seconds=0)),
        ("clrt.load", lambda: clrt.load_dict(deep, limits=clrt.Limits(primitives=1))),  # as it was before
    ):
        with pytest.raises(clrt.LimitError) as caught:
            ask()
        name = str(caught.value).partition(" is above")[0].split(": ")[-2]
        assert f"{call}(..., limits=Limits({name}=N))" in str(caught.value)


def test_sizes_that_differ_take_no_more_room() -> None:
    """A template is looked for among means."""
    a = np.random.default_rng(1).random((1400, 1400, 3), np.float32)
    tracemalloc.start()
    try:
        assert not clrt.compare(a, a[:-1])
        most = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert most < 450 << 20  # 1.8 GB were measured; 0.3 now


DIM = {
    "black": lambda picture: 0 * picture,
    "flipped": lambda picture: picture[:, ::-1].copy(),
    "half the light": lambda picture: picture / 2,
    "a twentieth more": lambda picture: 1.05 * picture,
}


@pytest.mark.parametrize("name", DIM)
@pytest.mark.parametrize("light", [2e-3, 1e-4, 1e-6, 1e-30])
def test_dim_pictures_are_compared_as_bright_ones(name: str, light: float) -> None:
    """Of a room in millimetres a black picture was equal to the right one."""
    right = (light * samples.picture() / samples.picture().max()).astype(np.float32)
    found = clrt.compare(DIM[name](right).astype(np.float32), right)
    assert not found.passed and any("the reference is dim" in note for note in found.notes)
    assert not any(cause.name == "JPEG compression" for cause in found.causes)
    noise = np.random.default_rng(1).uniform(1 - 1e-7, 1 + 1e-7, right.shape)
    assert clrt.compare((right * noise).astype(np.float32), right).verdict == "equal"


def test_how_much_brighter_dim_pictures_are_compared() -> None:
    """By the pixels that are lit; a lamp among them counts no more than they do."""
    picture = np.zeros((40, 50, 3))
    brightening = metrics.brightening
    assert brightening(picture) == 1
    picture[:20] = 3e-6
    assert 0.5 <= 3e-6 * brightening(picture) < 1
    picture[0, :5] = 50.0
    assert 0.5 <= 3e-6 * brightening(picture) < 1
    picture[:2] = 0.02
    assert brightening(picture) == 1


def test_an_oracle_sees_what_is_dim() -> None:
    compare, image = oracle.compare, validation_module("types").OracleImage
    dim = 1e-6 * samples.picture()
    right = image(dim, {"generation 0 camera": dim}, None, None, "", 0.0)
    wrong = dataclasses.replace(right, pixels=right.pixels[:, ::-1].copy())
    assert compare(right, right).passed and not compare(wrong, right).passed
    wrong = dataclasses.replace(right, by_ray={"generation 0 camera": 1.01 * dim})
    assert not compare(wrong, right).passed
