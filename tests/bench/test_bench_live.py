"""The benchmark of updates: each does what its name says, and stands beside what it is measured against."""

from __future__ import annotations

import clrt
from clrt.bench import live, report


def test_updates_stand_beside_a_new_tracer() -> None:
    made = live.times(1, None, clrt.Settings(), quick=True)
    assert len({m.key for m in made}) == len(made) == 10
    by_name = {(m.name, m.queue): m for m in made}
    moved, new = by_name["update, moved vertices", ""], by_name[live.NEW, ""]
    assert live.ratio(made, moved) == moved.median / new.median and live.ratio(made, new) is None
    picture = by_name["picture of 64 x 64", ""]
    kernels = by_name["picture of 64 x 64", live.KERNELS]
    assert live.ratio(made, picture) == picture.median / kernels.median and live.ratio(made, kernels) is None
    assert 0 < kernels.median < picture.median
    film, alone = (by_name["series of 2 pictures", how] for how in ("", live.KERNELS))
    assert live.ratio(made, film) == film.median / alone.median > 1
    (table,) = report.tables(report.Report({}, tuple(made)))
    assert table.row_count == 10
