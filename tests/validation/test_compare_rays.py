"""The comparison by generation and kind of ray: what cancels in a picture, and who is to blame."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from clrt.base.resources import validation_module
from compare_samples import EDGES, GREY, failed, oracle

compare = validation_module("compare.oracle")
ray_rows = validation_module("compare.rays").ray_rows


RAYS_ONLY = dataclasses.replace(compare.statistical(compare.limits()), rays=0.999, mean=None)


def rays(**planes: Any) -> Any:
    """An OracleImage of planes such as g0_camera=0.1: generation and kind -> a value everywhere."""
    by_ray = {}
    for key, value in planes.items():
        by_ray[key.replace("g", "generation ", 1).replace("_", " ")] = np.broadcast_to(value, GREY.shape)
    total = sum(values for key, values in by_ray.items() if len(key.split()) < 4)
    return oracle(total, by_ray=by_ray)


def test_errors_that_cancel_are_found_by_the_kind_of_ray():
    mine = rays(g0_camera=0.2, g1_reflection=0.11, g1_transmission=0.09)
    result = compare.compare(mine, rays(g0_camera=0.2, g1_reflection=0.1, g1_transmission=0.1))
    assert failed(result) == {"generation 1, reflection", "generation 1, transmission"}
    assert result.metrics["generation 1 reflection: largest"] == pytest.approx(0.01)


def test_the_tolerance_of_rays_is_that_of_pictures():
    right = rays(g0_camera=0.2, g1_reflection=0.1)
    assert compare.compare(rays(g0_camera=0.2, g1_reflection=0.10009), right, limit=RAYS_ONLY).passed
    wrong = compare.compare(rays(g0_camera=0.2, g1_reflection=0.10011), right, limit=RAYS_ONLY)
    assert failed(wrong) == {"generation 1, reflection"}


def test_the_earliest_generation_is_blamed_and_its_term():
    right = rays(g0_camera=0.2, g1_reflection=0.1, g2_transmission=0.05, g10_reflection=0.01)
    wrong = rays(g0_camera=0.2, g1_reflection=0.1, g2_transmission=0.06, g10_reflection=0.05)
    assert compare.compare(wrong, right).worst == "generation 2, transmission"
    late = rays(g0_camera=0.2, g1_reflection=0.1, g2_transmission=0.05, g10_reflection=0.02)
    assert compare.compare(late, right).worst == "generation 10, reflection"
    right = rays(g0_camera=0.2, g0_camera_diffuse=0.1, g0_camera_highlight=0.1, g1_reflection=0.1)
    wrong = rays(g0_camera=0.25, g0_camera_diffuse=0.1, g0_camera_highlight=0.15, g1_reflection=0.1)
    assert compare.compare(wrong, right).worst == "generation 0, camera, highlight"


def test_rays_that_only_one_has_are_compared_with_black():
    result = compare.compare(rays(g0_camera=0.2), rays(g0_camera=0.1, g3_ambient=0.1))
    assert failed(result) == {"generation 0, camera", "generation 3, ambient"}
    result = compare.compare(rays(g0_camera=0.2, g3_ambient=0.1), rays(g0_camera=0.3))
    assert failed(result) == {"generation 0, camera", "generation 3, ambient"}


def test_a_reference_that_tells_generations_only():
    mine = rays(g0_camera=0.2, g0_camera_diffuse=0.2, g1_reflection=0.1, g1_transmission=0.05)
    assert compare.compare(mine, rays(g0=0.2, g1=0.15)).passed
    assert compare.compare(mine, rays(g0=0.2, g1=0.14)).worst == "generation 1"


def test_terms_of_one_side_only_are_no_difference():
    mine = rays(g0_camera=0.2, g0_camera_diffuse=0.2)
    assert compare.compare(mine, rays(g0_camera=0.2)).passed
    assert [row.label for row in ray_rows(mine, mine, EDGES)] == [
        "generation 0, camera", "generation 0, camera, diffuse"]  # fmt: skip


def test_rays_at_edges_do_not_count():
    a, b = np.array(GREY), np.array(GREY)
    b[:, 1] += 0.3
    assert ray_rows(rays(g0_camera=a), rays(g0_camera=b), EDGES)[0].largest == 0


def test_rays_that_bring_little_light_are_blamed_where_all_of_it_is_wrong():
    right = rays(g0_camera=0.2, g1_transmission=0.001, g2_transmission=0.1)
    wrong = rays(g0_camera=0.2, g1_transmission=0.00099, g2_transmission=0.099)
    result = compare.compare(wrong, right)
    assert "generation 1, transmission" not in failed(result)
    assert result.worst == "generation 1, transmission"
    spot = np.full(GREY.shape, 0.001)
    spot[3, 4:12] = 0.00095  # a few pixels are no fault of these rays
    wrong = rays(g0_camera=0.2, g1_transmission=spot, g2_transmission=0.099)
    assert compare.compare(wrong, right).worst == "generation 2, transmission"
