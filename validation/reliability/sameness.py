"""One picture, bit for bit: every shipped scene under every choice of how to run."""

from __future__ import annotations

import itertools
import multiprocessing
import time
import warnings
from collections.abc import Iterator
from typing import Any, Final

import clrt
from clrt.base.resources import shipped_scenes
from clrt.device.platforms import devices
from clrt.device.trial import verdict
from clrt.formats.shipped import load_scene

from .figures import Figure, Tell

TILES: Final = (1 << 7, 1 << 10, 1 << 16)  # at WIDTH: about a dozen, two or three, and one
GROUPS: Final = (1, 8, 64, 256)
LANES: Final = (8, 16)
THREADS: Final = (1, None)
WIDTH: Final = 48
LARGE: Final = {"sphereflake": 500, "mountain": 420, "thesis_4_3_transmission": 230}  # pixels wide: 2^22 rays

VARIED: Final[dict[str, tuple[str, dict[str, Any]]]] = {
    "still-life with lights of all kinds, a tent and adaptive samples": (
        "still-life",
        {
            "camera.spp": 4,
            "camera.filter": "tent",
            "adaptive": {"spp": 64, "threshold": 0.02},
            "lights": [
                {"type": "spot", "position": [2, 5, 3], "target": [0, 0, 0], "angle": 25, "penumbra": 0.4},
                {"type": "disk", "center": [-3, 4, 3], "normal": [3, -4, -3], "radius": 1, "radiance": 4,
                 "samples": 9},
                {"type": "sphere", "center": [4, 3, 0], "radius": 0.5, "radiance": 3, "samples": 4},
                {"type": "rectangle", "center": [0, 4, -3], "u": [1, 0, 0], "v": [0, 0, 1], "radiance": 2},
                {"type": "directional", "direction": [-1, -2, -1], "intensity": 0.2},
            ],
        },
    ),
    "rough metals through a lens, a gaussian and jitter": (
        "rough-metals",
        {
            "camera.spp": 9,
            "camera.filter": "gaussian",
            "camera.jitter": 3,
            "camera.aperture": 0.2,
            "camera.focus": 9.0,
        },
    ),
}  # fmt: skip
"""What no shipped scene has, as changes of one."""


def configurations() -> Iterator[dict[str, Any]]:
    """All choices on every driver that works here; one that cannot part its cores runs with all of them."""
    found = [info.label for info in devices() if not verdict(info)[0]]
    for label, tile, group, lanes, threads in itertools.product(found, TILES, GROUPS, LANES, THREADS):
        yield {"device": label, "tile": tile, "local_size": group, "lanes": lanes, "threads": threads}


def run(count: int, tell: Tell) -> Figure:
    """Every scene under every configuration, of which there must be `count`, in two processes beside the one
    that says what is expected."""
    start = time.perf_counter()
    chosen = list(configurations())
    assert len(chosen) >= count, f"{len(chosen)} configurations on this machine; {count} are promised"
    names = [*shipped_scenes(), *VARIED]
    few = [{}, chosen[0], chosen[len(chosen) // 2], chosen[-1]]
    jobs = [
        *((name, width, few) for name, width in LARGE.items()),
        *((name, WIDTH, [{}, *chosen]) for name in names),
    ]
    tried = wrong = traced = 0
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        for number, (name, width, found) in enumerate(pool.imap_unordered(_pictures, jobs)):
            expected, rays = picture(name, width, {})
            tried, wrong = tried + len(found), wrong + sum(one != expected for one in found)
            traced = max(traced, rays)
            tell((number + 1) / len(jobs))
    drivers = sorted({str(how["device"]).split(" / ")[0] for how in chosen})
    detail = f"{len(chosen)} configurations of {len(names)} scenes in 3 processes on {' and '.join(drivers)}"
    return Figure(tried, wrong, f"{detail}; up to {traced:,} rays a picture", time.perf_counter() - start)


def _pictures(job: tuple[str, int, list[dict[str, Any]]]) -> tuple[str, int, list[str]]:
    """A scene's name, its width, and the hashes of its pictures under these configurations."""
    name, width, several = job
    return name, width, [picture(name, width, how)[0] for how in several]


def scene(name: str) -> clrt.Scene:
    """A shipped or VARIED scene."""
    base, changes = VARIED.get(name, (name, {}))
    return load_scene(base).replace(changes)


def picture(name: str, width: int, how: dict[str, Any]) -> tuple[str, int]:
    """Hash of the picture of a `scene`, and rays traced for it."""
    settings = clrt.Settings(**{key: value for key, value in how.items() if key != "device"})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", clrt.ClrtWarning)
        image = clrt.render(scene(name), width=width, device=how.get("device"), settings=settings)
    return image.hash, int(image.stats["traced"])
