"""Where two of the meshes meet that Mitsuba has in place of curved shapes."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.mitsuba_rooms import room

EYE = np.array([2.3, 3.9, 9.8])
# tubes end to end: past its end the mesh of the first goes on, and crosses that of the second
TUBE = {"type": "cylinder", "radius": 0.06, "material": "a"}
TUBES = [{**TUBE, "p0": [-1.6421, 1.41, -0.6], "p1": [-1.4722, 1.0, -0.6]},
         {**TUBE, "p0": [-1.4722, 1.0, -0.6], "p1": [-1.2021, 0.6479, -0.6]}]  # fmt: skip


def test_a_tube_is_met_where_another_ones_mesh_crosses_it(mitsuba: Any) -> None:
    seen = EYE + 11.38267 * np.array([-0.33111253, -0.25529487, -0.90839915])  # a wall, near the second's end
    camera = {"origin": EYE.tolist(), "target": seen.tolist(), "fov": 2e-4}
    theirs = mitsuba.render(room({"a": {"color": 0.5}}, TUBES, camera=camera))
    assert (theirs.shape == 1).all()
    assert np.abs(theirs.t - 11.38267).max() < 1e-3  # and not the wall behind it, 0.11 farther
