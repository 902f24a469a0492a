"""One picture, bit for bit, whatever tiles, work-groups, lanes, threads, driver and tree compute it."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import clrt
from clrt.base.resources import shipped_scenes
from clrt.device import intel
from clrt.device.platforms import devices
from clrt.device.trial import verdict
from clrt.formats.shipped import load_scene
from clrt.images.image import Image
from clrt.layout.ceilings import PACKETS
from tests.random_scenes import crowd, crowd_rays
from validation import expected as small
from validation.twin.picture import trace32

WHOLE = 1 << 24  # rays of a tile: more than any picture here has
SETTINGS: dict[str, dict[str, int]] = {
    "tiles of 512 rays": {"tile": 1 << 9},
    "tiles of 4k rays": {"tile": 1 << 12},
    "one tile": {"tile": WHOLE},
    "work-groups of 1": {"local_size": 1},
    "1 thread": {"threads": 1},
    "2 threads": {"threads": 2},
}
# PoCL compiles for each of these anew, which takes a hundred times as long as a picture: a scene is rendered
# with one of them here, and with all in validation.reliability's row `sameness`.
COMPILED: list[dict[str, int]] = [
    {"local_size": 64},
    {"local_size": 256},
    {"tile": 1 << 10, "local_size": 8, "lanes": 8, "threads": 1},
]
EXPECTED = json.loads(small.FILE.read_text())  # of every scene: tests/validation/test_twin.py
USUAL = clrt.Settings()
assert (USUAL.tile, USUAL.local_size, USUAL.lanes) == (None, None, 16)
LARGE = {"sphereflake": 500, "mountain": 420, "thesis_4_3_transmission": 230}  # pixels wide
RAYS_OF_LARGE = 1 << 22


@pytest.fixture(autouse=True)
def quiet() -> Iterator[None]:
    """What scenes warn of is tested elsewhere."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", clrt.ClrtWarning)
        yield


def picture(scene: clrt.Scene, width: int, device: str | None = None, **settings: int) -> Image:
    """The picture, computed with these settings: the kernel itself says how large its work-groups were."""
    wanted = clrt.Settings(**settings)  # type: ignore[arg-type]
    image = clrt.render(scene, width=width, device=device, settings=wanted)
    most = min(wanted.local_size or 1, PACKETS)
    assert image.stats["local_size"] == most, "a packet is a group by itself on a CPU"
    return image


@cache
def two_drivers() -> tuple[str, str]:
    """What chooses the driver from PyPI (Intel's where its PoCL does not work), and Debian's PoCL."""
    working = [info for info in devices() if not verdict(info)[0]]
    pip = [info.label for info in working if "PoCL 3.0" in info.version or info.platform == intel.PLATFORM]
    debian = [info.label for info in working if "PoCL 3.1" in info.version]
    assert pip and debian, f"a driver from PyPI and Debian's are needed; here work {working}"
    return pip[0], debian[0]


@pytest.mark.parametrize("name", shipped_scenes())
def test_every_shipped_scene_has_one_hash(name: str) -> None:
    scene = load_scene(name)
    assert clrt.render(scene, width=small.WIDTH).hash == EXPECTED[name]
    expected = picture(scene, 64)
    assert len(np.unique(expected.pixels)) > 50
    compiled = COMPILED[list(shipped_scenes()).index(name) % len(COMPILED)]
    for how, settings in [*SETTINGS.items(), (str(compiled), compiled)]:
        image = picture(scene, 64, **settings)
        assert image.hash == expected.hash, how
        assert image.stats["generations"] == expected.stats["generations"], how


@pytest.mark.debian_pocl
@pytest.mark.parametrize("name", shipped_scenes())
def test_every_shipped_scene_has_one_hash_on_both_drivers(name: str) -> None:
    scene = load_scene(name)
    pip, debian = two_drivers()
    assert picture(scene, 64, pip).hash == picture(scene, 64, debian).hash


@pytest.mark.slow
@pytest.mark.parametrize("name", LARGE)
def test_large_pictures_have_one_hash(name: str) -> None:
    scene = load_scene(name)
    expected = picture(scene, LARGE[name])
    assert expected.stats["traced"] >= RAYS_OF_LARGE
    assert picture(scene, LARGE[name], tile=1 << 12, local_size=256, threads=2).hash == expected.hash
    assert picture(scene, LARGE[name], tile=WHOLE, local_size=1, lanes=8, threads=1).hash == expected.hash


@pytest.mark.slow
@pytest.mark.debian_pocl
@pytest.mark.parametrize("name", LARGE)
def test_large_pictures_have_one_hash_on_both_drivers(name: str) -> None:
    scene = load_scene(name)
    pip, debian = two_drivers()
    assert picture(scene, LARGE[name], pip).hash == picture(scene, LARGE[name], debian).hash


def spent_by_thread() -> dict[str, int]:
    """Nanoseconds on a processor of each thread of this process but the first."""
    spent = {}
    for task in Path("/proc/self/task").iterdir():
        if task.name != str(os.getpid()):
            spent[task.name] = int((task / "schedstat").read_text().split()[0])
    return spent


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="only Linux tells the time of each thread")
@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="one core is always one thread")
@pytest.mark.parametrize("threads", [1, 2])
def test_as_many_threads_work_as_were_asked_for(threads: int) -> None:
    tracer = clrt.Tracer(load_scene("refraction"), settings=clrt.Settings(threads=threads))
    tracer.render(width=64)
    before = spent_by_thread()
    tracer.render(width=200)
    spent = {thread: time - before.get(thread, 0) for thread, time in spent_by_thread().items()}
    working = [thread for thread, time in spent.items() if time > 0.2 * sum(spent.values())]
    helps = tracer.device.info.platform == intel.PLATFORM and threads < tracer.device.info.units
    assert len(working) == threads + helps, spent  # Intel's runtime lets the thread that waits work, too


@pytest.mark.parametrize("name", ["ambient", "showcase", "thesis_3_12_metals"])
def test_a_crop_is_that_part_of_the_whole(name: str) -> None:
    scene = load_scene(name)
    layers = ("reflection", "generation_1", "depth", "normal", "shape")
    whole = clrt.render(scene, width=96, layers=layers)
    x, y, width, height = crop = 37, 11, 41, 23
    part = clrt.render(scene, width=96, crop=crop, layers=layers)
    assert part.pixels.tobytes() == whole.pixels[y : y + height, x : x + width].tobytes()
    for layer in layers:
        assert part.layers[layer].tobytes() == whole.layers[layer][y : y + height, x : x + width].tobytes()


CROWDS = [
    *(("triangles", 1500, scale) for scale in (1.0, 1e-3, 1e5)),
    *(("spheres", 1000, scale) for scale in (1.0, 1e4)),
    ("mixed", 700, 1.0), ("mixed", 300, 1e-2), ("concentric spheres", 300, 1.0),
    *(("mixed", n, 1.0) for n in (1, 2, 8, 9, 65)),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "n", "scale"), CROWDS)
def test_the_tree_finds_what_brute_force_finds(kind: str, n: int, scale: float) -> None:
    scene = crowd(kind, n, seed=n, scale=scale)
    rays = crowd_rays(3000, seed=n, scale=scale)
    tracer = clrt.Tracer(scene)
    hits, expected = tracer.intersect(*rays), trace32(tracer.flat, *rays)
    assert n < 100 or 300 < np.count_nonzero(hits.primitive >= 0) < 3000 or kind == "concentric spheres"
    for name in ("t", "primitive", "shape", "normal", "u", "v"):
        assert getattr(hits, name).tobytes() == getattr(expected, name).tobytes(), name
    assert np.array_equal(tracer.occluded(*rays), expected.primitive >= 0)
    met = expected.primitive >= 0
    nearest = np.where(met, expected.t, np.float32(1))  # nothing lies strictly before it
    assert not tracer.occluded(*rays, t_max=nearest).any()
    assert np.array_equal(tracer.occluded(*rays, t_max=np.nextafter(nearest, np.float32(np.inf))), met)
