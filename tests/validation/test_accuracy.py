"""The row `accuracy`: hits are within its band of the float64 oracle; what is off by a little more is not."""

from __future__ import annotations

import numpy as np
import pytest

import clrt
from validation import proofs
from validation.reliability import accuracy


def test_hits_are_within_the_band_of_the_analytic_oracle() -> None:
    figure = accuracy.run(100_000, lambda share: None)
    assert figure.tried >= 100_000 and figure.wrong == 0


def test_a_sphere_a_little_too_large_is_outside_the_band() -> None:
    scene = clrt.load_dict({"shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1.00002}]})
    tracer = clrt.Tracer(scene)
    exact = clrt.load_dict({"shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}]})
    tracer._scene = exact  # what the oracle looks at
    o, d = accuracy._rays(1, 2000, 1.0, 0.0)
    met = np.isfinite(tracer.intersect(o, d).t)
    wrong = accuracy.errors(tracer, o, d, accuracy.BAND)
    assert met.sum() > 500 and wrong.sum() > 0.5 * met.sum()


@pytest.mark.parametrize(("name", "aside"), [("triangle", 1e-5), ("needle", 6e-5), ("hair", 6e-4)])
def test_a_triangle_a_little_aside_is_outside_the_band(name: str, aside: float) -> None:
    """A thin one by more than what it is off by for being thin."""
    exact = accuracy._scene(name, 1.0, 0.0)
    corners = np.array(proofs.SOLIDS[name]["vertices"])
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normal /= np.linalg.norm(normal)
    moved = [{"type": "mesh", "vertices": corners + aside * normal, "faces": [[0, 1, 2]]}]
    draw = np.random.default_rng(1)
    aims = draw.dirichlet([2, 2, 2], 2000) @ corners
    o = (aims + draw.normal(size=(2000, 3)) * 0.3).astype(np.float32)
    d = (aims - o).astype(np.float32)
    limits = accuracy._corners(name, 1.0, 0.0)
    assert not accuracy.errors(clrt.Tracer(exact), o, d, accuracy.BAND, *limits).any()
    tracer = clrt.Tracer(clrt.load_dict({"shapes": moved}))
    tracer._scene = exact  # what the oracle looks at
    wrong = accuracy.errors(tracer, o, d, accuracy.BAND, *limits)
    assert wrong.mean() > 0.5
