"""What a render may cost: the bound on its work is known before it starts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.limits import Branching

BALL = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
CAMERA = {"origin": [0, 0, 5], "target": [0, 0, 0]}


def test_limits_of_a_render() -> None:
    limits = clrt.Limits()
    limits.check("pixels", 8192 * 8192)
    limits.check("samples", 4096)
    limits.check("depth", 64)
    limits.check("lights", 65535)
    limits.check("primitives", 10**6)
    more = r"--limit pixels=N or Settings\(limits=Limits\(pixels=N\)\)"
    with pytest.raises(clrt.LimitError, match=rf"pixels: 4 294 967 296 .*{more}"):
        limits.check("pixels", 2**32)


def test_work_grows_with_two_to_the_depth_only_where_rays_branch() -> None:
    limits = clrt.Limits(work=1000)
    limits.check_work(10, 3, Branching(4, True))  # 10 x 3 x 16
    limits.check_work(10, 0, Branching(5, True))
    with pytest.raises(clrt.LimitError, match="work: 1 920 is above"):
        limits.check_work(10, 3, Branching(6, True))
    limits.check_work(10, 3, Branching(32, False))  # 10 x 3 x 33
    with pytest.raises(clrt.LimitError, match="work: 1 020 is above"):
        limits.check_work(10, 3, Branching(33, False))
    with pytest.raises(clrt.LimitError, match=r"work: > 1e300 is above"):
        limits.check_work(10, 3, Branching(65536, True))
    clrt.Limits().check_work(8192 * 8192 * 4096, 1, Branching(64, False))


def test_what_no_tree_holds_is_work() -> None:
    """Each ray is tried on all of it: as long as nobody counts that, 8,192 lights are a second's work."""
    limits = clrt.Limits(work=1000)
    limits.check_work(10, 1, Branching(9, False), 900)  # 100 rays, and 900 tests of each
    with pytest.raises(clrt.LimitError, match=r"work: 1 001 is .*; it counts rays, and what .* in no tree"):
        limits.check_work(10, 1, Branching(9, False), 901)


@pytest.mark.parametrize("unbounded", ["plane", "quadric"])
def test_planes_and_lights_that_are_seen_count(unbounded: str) -> None:
    """64 rays, each tried on 100 of these, count as 128; what the tree holds is free."""
    shape = {
        "plane": {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]},
        "quadric": {"type": "quadric", "coefficients": [1, 0, 1, 0, 0, 0, 0, 0, 0, -1]},
    }[unbounded]
    lamp = {"type": "sphere", "center": [0, 5, 0], "radius": 1, "samples": 1}
    camera = {**CAMERA, "width": 8, "height": 8}

    def render(work: int, shapes: list[dict[str, Any]], **seen: bool) -> None:
        table = {"lights": [lamp | seen], "shapes": shapes, "camera": camera, "max_depth": 0}
        clrt.render(clrt.load_dict(table), settings=clrt.Settings(limits=clrt.Limits(work=work)))

    render(64, [BALL] * 200)
    render(128, [shape] * 99, visible=True)
    render(127, [shape] * 99, visible=False)
    with pytest.raises(clrt.LimitError, match="work: 128 is above the limit of 127"):
        render(127, [shape] * 99, visible=True)


def test_a_weight_cut_off_ends_families_early() -> None:
    assert Branching(64, True, share=0.5, min_weight=0.1).rays == 1 << 4  # 0.5^4 < 0.1
    assert Branching(64, True, share=1.0, min_weight=0.1).rays == 1 << 64
    assert Branching(64, True, share=0.0, min_weight=0.1).rays == 1 << 1
    assert Branching(3, False, share=0.9, min_weight=0.1).rays == 4


def test_ambient_rays_are_work() -> None:
    assert Branching(3, False, ambient=10).rays == 4 * (1 + 10 * 4)
    assert Branching(0, False, ambient=10).rays == 1


def test_light_along_rays_is_as_much_work_as_a_picture_of_as_many() -> None:
    """One ray makes up to 2^depth: who bounds the work of a request bounds that of its rays, too."""
    glass = {"transmission": 0.5, "reflection": 0.5, "diffuse": 0.0}
    shapes = [{**BALL, "material": glass}, {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]}]
    scene = {"shapes": shapes, "camera": {**CAMERA, "width": 1, "height": 1}, "ambient": 1, "max_depth": 4}

    def tracer(work: int) -> clrt.Tracer:
        return clrt.Tracer(scene, settings=clrt.Settings(limits=clrt.Limits(work=work)))

    tracer(48).radiance([[0, 0, 5]] * 3, [0, 0, -1])  # 3 x 2^4
    with pytest.raises(clrt.LimitError, match=r"^rays: work: 48 is above .*how many rays are given"):
        tracer(47).radiance([[0, 0, 5]] * 3, [0, 0, -1])
    for ask in (tracer(15).render, lambda: tracer(15).radiance([0, 0, 5], [0, 0, -1])):
        with pytest.raises(clrt.LimitError, match="work: 16 is above the limit of 15"):
            ask()
    assert tracer(8).radiance([0, 0, 5], [0, 0, -1], max_depth=3)[0].shape == (3,)
    assert tracer(0).radiance(np.zeros((0, 3)), np.zeros((0, 3)))[0].shape == (0, 3)


@pytest.mark.parametrize("more", [{"ambient_samples": 60_000}, {"max_depth": 40}])
def test_a_render_that_would_not_end_is_refused(more: dict[str, Any]) -> None:
    glass = {"diffuse": 0.3, "fresnel": True, "reflection": 1, "transmission": 1}
    lights = [{"type": "point", "position": [0, 5, 0]}]
    table = {"lights": lights, "shapes": [{**BALL, "material": glass}], "camera": CAMERA, **more}
    settings = clrt.Settings(limits=clrt.Limits(work=10**12))
    with pytest.raises(clrt.LimitError, match=r"work: .* is above the limit"):
        clrt.render(clrt.load_dict(table), settings=settings)


def test_a_mesh_too_large_for_the_device_is_refused_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Before it is flattened, which takes as much memory of the host."""
    corners = np.random.default_rng(1).normal(size=(600, 3))
    mesh = {"type": "mesh", "vertices": corners, "faces": np.arange(600).reshape(-1, 3), "smooth": True}
    settings = clrt.Settings(limits=clrt.Limits(device_bytes=1_000_000))
    tracer = clrt.Tracer({"shapes": [mesh] * 2}, settings=settings)
    monkeypatch.setattr("clrt.engine.tracer.flatten", lambda *_: pytest.fail("flattened"))
    many = {"shapes": [mesh] * 20}
    for refused in (lambda: clrt.Tracer(many, settings=settings), lambda: tracer.update(many)):
        with pytest.raises(clrt.LimitError, match=r"shapes: device_bytes: 1 184 000 is above"):
            refused()
